//! A flow field in four bytes a pixel, to keep those of a whole clip.

use super::field::{Field, FlowField};
use crate::image::Plane;

/// Steps per pixel. 16 bits then reach ±512 pixels, twice what the largest default frame can use, with an error of
/// 1/128 pixel.
const SCALE: f32 = 64.0;

/// A flow field rounded to 1/64 pixel; displacements beyond ±511 pixels saturate.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CompactFlow {
    u: Plane<i16>,
    v: Plane<i16>,
}

impl CompactFlow {
    /// Rounds `flow`.
    pub fn new(flow: &FlowField) -> Self {
        // A float-to-integer cast saturates, which is what is wanted at both ends.
        let pack = |plane: &Plane<f32>| plane.map(|d| (d * SCALE).round() as i16);
        Self { u: pack(&flow.u), v: pack(&flow.v) }
    }

    /// The field, each component multiplied by its factor.
    pub fn unpack(&self, scale_u: f32, scale_v: f32) -> FlowField {
        let unpack = |plane: &Plane<i16>, scale: f32| plane.map(|d| f32::from(d) * (scale / SCALE));
        FlowField { u: unpack(&self.u, scale_u), v: unpack(&self.v, scale_v) }
    }
}

impl Field for CompactFlow {
    fn size(&self) -> (usize, usize) {
        (self.u.width(), self.u.height())
    }

    fn at(&self, x: usize, y: usize) -> (f32, f32) {
        let unpack = |d: i16| f32::from(d) * (1.0 / SCALE);
        (unpack(self.u[(x, y)]), unpack(self.v[(x, y)]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_costs_at_most_a_128th_of_a_pixel_and_large_motion_saturates() {
        let u = Plane::from_fn(50, 1, |x, _| 0.37 * x as f32 - 9.0);
        let flow = FlowField { u: u.clone(), v: Plane::filled(50, 1, 1e9) };
        let back = CompactFlow::new(&flow).unpack(1.0, 2.0);
        assert!(u.data().iter().zip(back.u.data()).all(|(a, b)| (a - b).abs() <= 1.0 / 128.0));
        assert!(back.v.data().iter().all(|&v| (v - 1024.0).abs() < 0.1));
    }
}
