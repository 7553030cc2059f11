//! Dense optical flow between two frames. (Stub: see the flow work item.)

mod compact;
mod variation;

use crate::image::Plane;
pub use compact::CompactFlow;
pub use variation::local_flow_variation;

crate::params! {
    /// Dense optical flow by inverse search (DIS) and variational refinement.
    pub struct FlowParams {
        /// Side of a square patch, in pixels.
        pub patch_size: u32 = 8, in 4..=16;
    }
}

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

/// What the flow needs of one frame, made once per frame and used for the pairs on both sides of it.
#[derive(Debug, Clone, Default)]
pub struct FlowPyramid {
    luma: Plane<f32>,
}

impl FlowPyramid {
    /// From brightness in `0.0..=255.0`.
    pub fn new(luma: &Plane<f32>, _params: &FlowParams) -> Self {
        Self { luma: luma.clone() }
    }
}

/// The flow from `from` to `to`, two pyramids of frames of the same size.
pub fn flow_between(from: &FlowPyramid, _to: &FlowPyramid, _params: &FlowParams) -> FlowField {
    let zero = Plane::filled(from.luma.width(), from.luma.height(), 0.0);
    FlowField { u: zero.clone(), v: zero }
}
