//! What the flow is: a displacement for each pixel.

use crate::image::Plane;

/// A flow field from frame `t` to `t + 1` (forward) or back: a point at `(x, y)` moves to `(x + u, y + v)`, in pixels.
///
/// Law: `u` and `v` have the same size and finite values.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FlowField {
    /// Horizontal displacement, pixels per frame, positive to the right.
    pub u: Plane<f32>,
    /// Vertical displacement, pixels per frame, positive downwards.
    pub v: Plane<f32>,
}

/// A field that is read pixel by pixel, however it is kept.
pub(crate) trait Field {
    /// Width and height.
    fn size(&self) -> (usize, usize);
    /// The displacement of a pixel.
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
    /// No motion anywhere.
    pub(super) fn still(width: usize, height: usize) -> Self {
        Self { u: Plane::filled(width, height, 0.0), v: Plane::filled(width, height, 0.0) }
    }

    /// The field of the same frames at another size, in pixels of that size.
    #[must_use]
    pub fn at_size(self, width: usize, height: usize) -> Self {
        let size = self.size();
        if size == (width, height) {
            return self;
        }
        let factor = |to: usize, from: usize| to as f32 / from as f32;
        Self {
            u: enlarged(&self.u, width, height, factor(width, size.0)),
            v: enlarged(&self.v, width, height, factor(height, size.1)),
        }
    }
}

/// The plane at a size that is not smaller, between pixels by bilinear interpolation, times `factor`.
fn enlarged(plane: &Plane<f32>, width: usize, height: usize, factor: f32) -> Plane<f32> {
    let place = |to: usize, from: usize, k: usize| {
        let at = ((k as f32 + 0.5) * (from as f32 / to as f32) - 0.5).clamp(0.0, (from - 1) as f32);
        (at as usize, at - at as usize as f32)
    };
    let columns: Vec<_> = (0..width).map(|x| place(width, plane.width(), x)).collect();
    let mut out = Plane::filled(width, height, 0.0);
    // A row of the plane with its last value twice.
    let mut line = vec![0.0; plane.width() + 1];
    for y in 0..height {
        let (above, share) = place(height, plane.height(), y);
        let below = plane.row((above + 1).min(plane.height() - 1));
        for ((value, a), b) in line.iter_mut().zip(plane.row(above)).zip(below) {
            *value = factor * (a + share * (b - a));
        }
        line[plane.width()] = line[plane.width() - 1];
        for (value, &(x, share)) in out.row_mut(y).iter_mut().zip(&columns) {
            let (left, right) = (line[x], line[x + 1]);
            *value = left + share * (right - left);
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
