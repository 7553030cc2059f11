//! A flow field in four bytes a pixel, to keep those of a whole clip.

use super::field::{Field, FlowField};
use crate::image::Plane;

/// Steps per pixel. 16 bits then reach ±512 pixels, twice what the largest default frame can use, with an error of
/// 1/128 pixel.
const SCALE: f32 = 64.0;

/// The number before one half: with it added, cutting towards 0 rounds as `f32::round` does, and many at a time.
const BELOW_HALF: f32 = 0.499_999_97;

/// A flow field rounded to 1/64 pixel; displacements beyond ±511 pixels saturate.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CompactFlow {
    u: Plane<i16>,
    v: Plane<i16>,
}

impl CompactFlow {
    /// Rounds `flow`.
    pub fn new(flow: &FlowField) -> Self {
        // A float-to-integer cast saturates, which is what is wanted at both ends, and cuts towards 0.
        let pack = |plane: &Plane<f32>| {
            let limits = (i32::from(i16::MIN), i32::from(i16::MAX));
            plane.map(|d| ((d * SCALE + BELOW_HALF.copysign(d)) as i32).clamp(limits.0, limits.1) as i16)
        };
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
    fn numbers_are_rounded_as_the_standard_library_does() {
        let near = |v: f32| [v.next_down(), v, v.next_up()];
        let halves = (-3000..3000).flat_map(|k| near(k as f32 / 2.0));
        let values: Vec<f32> = halves.chain([f32::NAN, -0.0, 4e4, -4e4, 1e30]).map(|v| v / SCALE).collect();
        let u = Plane::from_vec(values.len(), 1, values).unwrap();
        let found = CompactFlow::new(&FlowField { v: u.clone(), u: u.clone() });
        assert!(u.data().iter().zip(found.u.data()).all(|(d, &found)| found == (d * SCALE).round() as i16));
    }

    #[test]
    fn rounding_costs_at_most_a_128th_of_a_pixel_and_large_motion_saturates() {
        let u = Plane::from_fn(50, 1, |x, _| 0.37 * x as f32 - 9.0);
        let flow = FlowField { u: u.clone(), v: Plane::filled(50, 1, 1e9) };
        let back = CompactFlow::new(&flow).unpack(1.0, 2.0);
        assert!(u.data().iter().zip(back.u.data()).all(|(a, b)| (a - b).abs() <= 1.0 / 128.0));
        assert!(back.v.data().iter().all(|&v| (v - 1024.0).abs() < 0.1));
    }
}
