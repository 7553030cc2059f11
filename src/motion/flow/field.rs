//! Flow fields: a displacement for each pixel.

use crate::image::Plane;

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
}
