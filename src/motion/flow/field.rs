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
}
