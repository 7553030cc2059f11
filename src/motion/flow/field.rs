//! Flow fields: a displacement for each pixel.

use crate::image::{BilinearPoint, Plane};

/// A flow field from frame `t` to `t + 1` (forward) or back: a point at `(x, y)` moves to `(x + u, y + v)`, in pixels.
///
/// Invariants: `u` and `v` have the same size and finite values.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FlowField {
    /// Horizontal displacement, pixels per frame, positive to the right.
    pub u: Plane<f32>,
    /// Vertical displacement, pixels per frame, positive downwards.
    pub v: Plane<f32>,
}

/// A flow field in any storage, read pixel by pixel.
pub(crate) trait Field {
    /// Returns width and height in pixels.
    fn size(&self) -> (usize, usize);
    /// Returns the displacement of a pixel.
    fn at(&self, x: usize, y: usize) -> (f32, f32);
}

impl Field for FlowField {
    fn size(&self) -> (usize, usize) {
        (self.u.width(), self.u.height())
    }

    fn at(&self, x: usize, y: usize) -> (f32, f32) {
        (self.u[(x, y)], self.v[(x, y)])
    }
}

impl FlowField {
    /// Creates a field without motion.
    pub(super) fn zero(width: usize, height: usize) -> Self {
        Self { u: Plane::filled(width, height, 0.0), v: Plane::filled(width, height, 0.0) }
    }

    /// Resamples the field to a larger frame size; displacements grow with it.
    #[doc(hidden)] // For `examples/method.rs`.
    #[must_use]
    pub fn at_size(self, width: usize, height: usize) -> Self {
        let size = self.size();
        if size == (width, height) {
            return self;
        }
        let factor = |to: usize, from: usize| to as f32 / from as f32;
        Self {
            u: enlarge(&self.u, width, height, factor(width, size.0)),
            v: enlarge(&self.v, width, height, factor(height, size.1)),
        }
    }
}

/// Enlarges a plane by bilinear interpolation and multiplies it by `factor`.
fn enlarge(plane: &Plane<f32>, width: usize, height: usize, factor: f32) -> Plane<f32> {
    let locate = |to: usize, from: usize, k: usize| {
        let position = ((k as f32 + 0.5) * (from as f32 / to as f32) - 0.5).clamp(0.0, (from - 1) as f32);
        (position as usize, position - position as usize as f32)
    };
    let columns: Vec<_> = (0..width).map(|x| locate(width, plane.width(), x)).collect();
    let mut out = Plane::filled(width, height, 0.0);
    // An interpolated row with its last value repeated.
    let mut line = vec![0.0; plane.width() + 1];
    for y in 0..height {
        let (above, fraction) = locate(height, plane.height(), y);
        let below = plane.row((above + 1).min(plane.height() - 1));
        for ((value, a), b) in line.iter_mut().zip(plane.row(above)).zip(below) {
            *value = factor * (a + fraction * (b - a));
        }
        line[plane.width()] = line[plane.width() - 1];
        for (value, &(x, fraction)) in out.row_mut(y).iter_mut().zip(&columns) {
            *value = line[x] + fraction * (line[x + 1] - line[x]);
        }
    }
    out
}

/// Steps per pixel, as a power of two: 16 bits reach ±512 pixels, longer than the default working size, with an error of 1/128
/// pixel.
pub(crate) const STEPS_PER_PIXEL_LOG2: u32 = 6;
const STEPS_PER_PIXEL: f32 = (1 << STEPS_PER_PIXEL_LOG2) as f32;

/// The largest `f32` below 0.5: with it added, truncation rounds as `f32::round` does, and vectorises.
const BELOW_HALF: f32 = 0.499_999_97;

/// A flow field rounded to 1/64 pixel; displacements beyond ±511 pixels saturate.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CompactFlow {
    u: Plane<i16>,
    v: Plane<i16>,
}

impl CompactFlow {
    /// Rounds `flow` to 1/64 pixel.
    pub fn new(flow: &FlowField) -> Self {
        // The cast saturates and truncates.
        let pack = |plane: &Plane<f32>| {
            let (min, max) = (i32::from(i16::MIN), i32::from(i16::MAX));
            plane.map(|d| ((d * STEPS_PER_PIXEL + BELOW_HALF.copysign(d)) as i32).clamp(min, max) as i16)
        };
        Self { u: pack(&flow.u), v: pack(&flow.v) }
    }

    /// Returns the displacement of pixel `p`, row by row, in steps.
    pub(crate) fn steps(&self, p: usize) -> (i32, i32) {
        (self.u.data()[p].into(), self.v.data()[p].into())
    }

    /// Samples the field between pixels.
    pub(crate) fn sample(&self, x: f32, y: f32) -> (f32, f32) {
        let point = BilinearPoint::new(self.u.width(), self.u.height(), x, y);
        let [u, v] = [&self.u, &self.v].map(|plane| point.sample_as(plane, f32::from));
        (u * (1.0 / STEPS_PER_PIXEL), v * (1.0 / STEPS_PER_PIXEL))
    }

    /// Returns a word for each pixel, for a message.
    #[cfg(any(feature = "wasm", test))]
    pub(crate) fn words(&self) -> impl Iterator<Item = u32> + '_ {
        let word = |(&u, &v): (&i16, &i16)| u32::from(u.cast_unsigned()) | u32::from(v.cast_unsigned()) << 16;
        self.u.data().iter().zip(self.v.data()).map(word)
    }

    /// Reads the words of a field of this size.
    #[cfg(any(feature = "wasm", test))]
    pub(crate) fn from_words(width: usize, height: usize, words: &[u32]) -> Option<Self> {
        let component = |shift: u32| words.iter().map(|word| ((word >> shift) as u16).cast_signed()).collect();
        let [u, v] = [0, 16].map(|shift| Plane::from_vec(width, height, component(shift)));
        Some(Self { u: u?, v: v? })
    }

    /// Returns the field, each component multiplied by its factor.
    pub fn unpack(&self, scale_u: f32, scale_v: f32) -> FlowField {
        let unpack = |plane: &Plane<i16>, scale: f32| plane.map(|d| f32::from(d) * (scale / STEPS_PER_PIXEL));
        FlowField { u: unpack(&self.u, scale_u), v: unpack(&self.v, scale_v) }
    }
}

impl Field for CompactFlow {
    fn size(&self) -> (usize, usize) {
        (self.u.width(), self.u.height())
    }

    fn at(&self, x: usize, y: usize) -> (f32, f32) {
        let unpack = |d: i16| f32::from(d) * (1.0 / STEPS_PER_PIXEL);
        (unpack(self.u[(x, y)]), unpack(self.v[(x, y)]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_stays_one_at_another_size_and_lengths_grow_with_the_frame() {
        let field = FlowField { u: Plane::from_fn(6, 4, |x, _| x as f32), v: Plane::from_fn(6, 4, |_, y| y as f32) };
        let large = field.clone().at_size(9, 8);
        let inner = (2..7).flat_map(|x| (2..6).map(move |y| (x, y)));
        for (x, y) in inner {
            let (u, v) = ((x as f32 + 0.5) / 1.5 - 0.5, (y as f32 + 0.5) / 2.0 - 0.5);
            assert!((large.u[(x, y)] - 1.5 * u).abs() < 1e-5 && (large.v[(x, y)] - 2.0 * v).abs() < 1e-5, "{x} {y}");
        }
        assert_eq!((large.u[(0, 0)], large.u[(8, 0)], large.v[(0, 7)]), (0.0, 7.5, 6.0));
        assert_eq!(field.clone().at_size(6, 4), field);
    }

    #[test]
    fn numbers_are_rounded_as_the_standard_library_does() {
        let near = |v: f32| [v.next_down(), v, v.next_up()];
        let halves = (-3000..3000).flat_map(|k| near(k as f32 / 2.0));
        let values: Vec<f32> = halves.chain([f32::NAN, -0.0, 4e4, -4e4, 1e30]).map(|v| v / STEPS_PER_PIXEL).collect();
        let u = Plane::from_vec(values.len(), 1, values).unwrap();
        let compact = CompactFlow::new(&FlowField { v: u.clone(), u: u.clone() });
        assert!(
            u.data().iter().zip(compact.u.data()).all(|(d, &rounded)| rounded == (d * STEPS_PER_PIXEL).round() as i16)
        );
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
