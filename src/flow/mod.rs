//! Dense optical flow between two frames.

mod compact;
mod densify;
mod patch;
mod pyramid;
mod refine;
mod variation;

pub use compact::CompactFlow;
pub use pyramid::FlowPyramid;
pub use variation::local_flow_variation;

use crate::image::{Plane, sample_bilinear};
use densify::{Votes, densify};
use patch::PatchGrid;
use refine::{Effort, Refiner};

crate::params! {
    /// Dense optical flow by inverse search (DIS) and variational refinement.
    pub struct FlowParams {
        /// Side of a square patch, in pixels.
        pub patch_size: u32 = 8, in 4..=16;
        /// Pixels between neighbouring patches, at most the patch's side. Lower is slower.
        pub patch_stride: u32 = 4, in 1..=16;
        /// Most steps of each patch's two descents. Higher is slower.
        pub descents: u32 = 8, in 0..=64;
        /// Level at which the search ends: 0 is full size, 1 half of it. Higher is faster and blurs borders.
        pub finest_level: u32 = 0, in 0..=4;
        /// Standard deviation of the blur that frames get first, in pixels.
        pub presmoothing: f32 = 0.6, in 0.0..=4.0;
        /// Weight of constant brightness.
        pub brightness_weight: f32 = 5.0, in 0.0..=1000.0;
        /// Weight of constant slopes of brightness.
        pub slope_weight: f32 = 10.0, in 0.0..=1000.0;
        /// Weight of smoothness.
        pub smoothness: f32 = 20.0, in 0.001..=1000.0;
        /// Times that the refinement renews its robust weights at the finest level. Higher is slower.
        pub fixed_points: u32 = 5, in 0..=32;
        /// Sweeps of the refinement's solver for each of them. Higher is slower.
        pub sweeps: u32 = 5, in 1..=64;
        /// Over-relaxation of these sweeps.
        pub overrelaxation: f32 = 1.6, in 1.0..=1.99;
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

/// Working memory of [`flow_between_with`]. Its contents never affect results; dropping it is always safe.
#[derive(Debug, Clone, Default)]
pub struct FlowScratch {
    grid: PatchGrid,
    votes: Votes,
    refiner: Refiner,
}

/// The flow from `from` to `to`, two pyramids of frames of the same size.
pub fn flow_between(from: &FlowPyramid, to: &FlowPyramid, params: &FlowParams) -> FlowField {
    flow_between_with(from, to, params, &mut FlowScratch::default())
}

/// As [`flow_between`], with working memory that is kept from one pair to the next.
pub fn flow_between_with(
    from: &FlowPyramid,
    to: &FlowPyramid,
    params: &FlowParams,
    scratch: &mut FlowScratch,
) -> FlowField {
    let (width, height) = from.size();
    let mut flow = FlowField::default();
    if from.size() != to.size() {
        return FlowField { u: Plane::filled(width, height, 0.0), v: Plane::filled(width, height, 0.0) };
    }
    let side = params.patch_size as usize;
    let stride = (params.patch_stride as usize).clamp(1, side);
    let coarsest = from.levels.len().saturating_sub(1);
    let finest = (params.finest_level as usize).min(coarsest);
    for (level, (from, to)) in from.levels.iter().zip(&to.levels).enumerate().skip(finest).rev() {
        let (width, height) = (from.image.width, from.image.height);
        scratch.grid.lay(width, height, side, stride);
        scratch.grid.start((level < coarsest).then_some((&flow.u, &flow.v)));
        scratch.grid.search(from, to, params.descents as usize);
        (flow.u, flow.v) = (Plane::filled(width, height, 0.0), Plane::filled(width, height, 0.0));
        densify(from, to, &scratch.grid, &mut scratch.votes, (&mut flow.u, &mut flow.v));
        let effort = Effort { fixed_points: params.fixed_points as usize, sweeps: params.sweeps as usize };
        scratch.refiner.refine(&from.image, &to.image, (&mut flow.u, &mut flow.v), effort, params);
    }
    if finest > 0 {
        let scale = (1 << finest) as f32;
        flow = FlowField { u: enlarged(&flow.u, scale, width, height), v: enlarged(&flow.v, scale, width, height) };
    }
    flow
}

/// `plane` at `scale` times the size, its values as many times as large.
fn enlarged(plane: &Plane<f32>, scale: f32, width: usize, height: usize) -> Plane<f32> {
    let position = |x: usize| (x as f32 + 0.5) / scale - 0.5;
    Plane::from_fn(width, height, |x, y| scale * sample_bilinear(plane, position(x), position(y)))
}

#[cfg(test)]
mod tests;
