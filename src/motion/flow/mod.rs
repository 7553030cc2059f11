//! Dense optical flow between two frames.
//!
//! In: two [`FlowPyramid`]s, computed once per frame from its brightness. Out: a [`FlowField`], one displacement a pixel.
//!
//! The method is DIS (Kroeger, Timofte, Dai and Van Gool, "Fast Optical Flow using Dense Inverse Search", ECCV 2016) with
//! OpenCV's spatial propagation, down to full resolution. At each level, from the coarsest to the finest:
//!
//! 1. Lay square patches over the level, overlapping by half; each starts from the coarser level's flow (`patch`).
//! 2. Search each patch in the second frame: try the displacements of its neighbours, then descend on the sum of squared
//!    differences without their mean. The *inverse* formulation needs the gradient of the first frame only. At the two
//!    coarsest levels, where patches are few, all whole-pixel displacements nearby are tried first (`patch`).
//! 3. Every pixel takes the mean of the patches over it, weighted by their match at this pixel (`patch`).
//! 4. Refine the whole field by a variational method (`solver`).
//!
//! **Deviations from DIS and OpenCV.** Levels are halved with a wider Gaussian, a neighbour's displacement must be clearly
//! better to be adopted, and below the coarsest level a patch moves at most three pixels: without these three, repeated
//! texture misleads patches (mean end-point error on the eight Middlebury pairs with known flow 0.42 px, with them
//! 0.34 px, both before the last tuning). The scan of the coarsest levels is ours; it finds fast objects in front of a
//! still background. Patches are searched a second time only where a neighbour disagrees. The refinement solves for both
//! components of a pixel together.
//!
//! **The backward field** of a clip only checks the forward one: where both disagree, something is hidden or the flow is
//! wrong. It is computed independently, and without the refinement ([`FlowParams::for_check`]): that is half of the work,
//! and smoothness would make both fields agree where neither knows the motion.
//!
//! Measured: 0.31 px on these pairs at full size (OpenCV's DIS at its finest scale: 0.49 px). Sessions
//! that make masks reduce frames to `max_side` first: at 480 pixels 0.44 px (Urban3 1.40, before 0.66); their masks do
//! not get worse.
//!
//! **Cost**: linear in pixels; see `patch` and `solver`. **Limits**: brightness only, no colour. Objects that move farther
//! than about half their size in a frame are missed if the background moves differently.

mod compact;
mod field;
mod params;
mod patch;
mod pyramid;
mod solver;
mod variation;

#[doc(hidden)] // For `examples/method.rs`.
pub use compact::CompactFlow;
pub(crate) use compact::STEPS_PER_PIXEL_LOG2;
pub(crate) use field::Field;
pub use field::FlowField;
pub use params::FlowParams;
pub use pyramid::FlowPyramid;
#[doc(hidden)] // For benchmarks.
pub use variation::local_flow_variation;

use params::PATCH_SIDE_PX;
use patch::{PatchMatcher, PatchSearch};
use solver::Refiner;

/// Longest descent of a patch below the coarsest level, in pixels of the level: the coarser level is off by a few at most.
/// Measured on the Middlebury pairs above.
const MAX_DESCENT_PX: f32 = 3.0;

/// Radius of the scan over whole-pixel displacements at the two coarsest levels, in pixels of the level. At finer levels a
/// scan would cost time and find chance matches. Chosen by eye.
const SCAN_RADIUS_PX: [i16; 2] = [4, 2];

#[doc(hidden)]
/// Working memory of [`flow_between_with`], about 60 bytes a pixel of the frame.
///
/// Its contents never affect results; dropping it is always safe.
#[derive(Debug, Clone, Default)]
pub struct FlowScratch {
    matcher: PatchMatcher,
    refiner: Refiner,
}

/// Computes the flow from frame `from` to frame `to`; no motion if their sizes differ.
///
/// # Examples
/// A picture of digits moves one pixel to the right.
///
/// ```
/// use tracecut::flow::{FlowParams, FlowPyramid, flow_between};
/// use tracecut::image::Frame;
///
/// let rows = ["0013588531", "0136898631", "0137998731", "0136898631", "0013588531"];
/// // Each digit becomes a patch of 8 by 8 pixels of that brightness.
/// let grey = |x: usize, y: usize| 25 * (rows[y / 8 % 5].as_bytes()[x / 8 % 10] - b'0');
/// let frame = |shift| {
///     let pixels = (0..80 * 40).flat_map(|i| [grey(i % 80 + shift, i / 80); 3]);
///     Frame::from_rgb(pixels.collect(), 80, 40)
/// };
/// let (first, second) = (FlowPyramid::new(&frame(1)?), FlowPyramid::new(&frame(0)?));
/// let flow = flow_between(&first, &second, &FlowParams::default());
/// let (u, v) = (flow.u[(40, 20)], flow.v[(40, 20)]);
/// assert!((u - 1.0).abs() < 0.25 && v.abs() < 0.25, "{u}, {v}");
/// # Ok::<(), tracecut::Error>(())
/// ```
#[must_use]
pub fn flow_between(from: &FlowPyramid, to: &FlowPyramid, params: &FlowParams) -> FlowField {
    flow_between_with(from, to, params, &mut FlowScratch::default())
}

#[doc(hidden)]
/// Computes [`flow_between`] with working memory that is reused from pair to pair.
#[must_use]
pub fn flow_between_with(
    from: &FlowPyramid,
    to: &FlowPyramid,
    params: &FlowParams,
    scratch: &mut FlowScratch,
) -> FlowField {
    let (width, height) = from.size();
    if from.size() != to.size() || width * height == 0 {
        return FlowField::zero(width, height);
    }
    let num_levels = from.levels.len().min(to.levels.len());
    let mut coarser = None;
    for level in (0..num_levels).rev() {
        let (level_from, level_to) = (&from.levels[level], &to.levels[level]);
        let (stride, finest) = (params.patch_stride as usize, params.search_level as usize);
        let stride = if level > finest { (3 * stride / 4).max(1) } else { stride };
        // Patches that are not searched keep the coarser level's flow: each pixel then takes the best of the motions near it.
        let search = (level >= finest || coarser.is_none()).then(|| PatchSearch {
            max_descent: if coarser.is_some() { MAX_DESCENT_PX } else { PATCH_SIDE_PX as f32 },
            scan_radius: SCAN_RADIUS_PX.get(num_levels - 1 - level).copied(),
        });
        let mut flow = scratch.matcher.flow(level_from, level_to, stride, coarser.as_ref(), search);
        if params.fixed_points > 0 {
            scratch.refiner.refine(&level_from.image, &level_to.image, &mut flow.u, &mut flow.v, params);
        }
        coarser = Some(flow);
    }
    coarser.unwrap_or_default()
}

#[cfg(test)]
mod tests;
