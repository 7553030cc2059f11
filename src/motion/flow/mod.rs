//! Dense optical flow between two frames.
//!
//! In: two [`FlowPyramid`]s, made once per frame from its brightness. Out: a [`FlowField`] with one displacement a
//! pixel.
//!
//! The method is DIS (Kroeger, Timofte, Dai and Van Gool, "Fast Optical Flow using Dense Inverse Search", ECCV 2016)
//! with the spatial propagation that OpenCV added to it, down to full resolution. At each level, from the coarsest to
//! the finest:
//!
//! 1. Lay square patches over the level, overlapping by half; each starts from the coarser level's flow (`patch`).
//! 2. Search each patch in the second frame: try what its neighbours found, then follow the slope of the squared
//!    difference, mean brightness taken out. The *inverse* formulation needs the slopes of the first frame only. At the
//!    two coarsest levels, where there are few patches, whole displacements nearby are all tried before (`patch`).
//! 3. Every pixel takes the mean of the patches over it, weighted by how well each fits there (`patch`).
//! 4. Refine the field as a whole by a variational method (`solver`).
//!
//! **Deviations from DIS and OpenCV.** Levels are halved with a wider Gaussian, a neighbour's displacement must be
//! clearly better before it is taken over, and below the coarsest level a patch moves at most three pixels: without
//! these three, repeated texture leads patches astray (mean end-point error on the eight Middlebury pairs with known
//! flow 0.42 px, with them 0.34 px, both before the last tuning). The scan of the coarsest levels is ours; it finds
//! fast objects on still ground. Patches are searched a second time only where a neighbour disagrees. The refinement
//! solves for both components of a pixel together. Forward and backward flow are each computed in full: one is never
//! derived from the other, because their agreement is what tells occlusions.
//!
//! Measured: 0.31 px on these pairs at full size (OpenCV's DIS at its finest scale: 0.49 px). Sessions
//! that make masks reduce frames to `max_side` first: at 480 pixels 0.44 px (Urban3 1.40, before 0.66); their masks do
//! not get worse.
//!
//! **Limits.** Brightness only, no colour. Objects that move further than about half their own size in a frame are
//! missed where the ground moves otherwise.

mod compact;
mod field;
mod params;
mod patch;
mod pyramid;
mod solver;
mod variation;

pub use compact::CompactFlow;
pub(crate) use field::Field;
pub use field::FlowField;
pub use params::FlowParams;
pub use pyramid::FlowPyramid;
pub use variation::local_flow_variation;

use params::PATCH_SIDE;
use patch::{PatchGrid, Votes, densify};
use pyramid::Level;
use solver::Refiner;

/// Furthest that a patch's descent leads below the coarsest level, in pixels of the level: the coarser level is off by
/// a few at most.
const REACH: f32 = 3.0;

/// Radius of the scan over whole displacements at the coarsest level and the next, in pixels of the level. Finer ones
/// would cost time and find chance likenesses.
const SCAN_RADIUS: [i16; 2] = [4, 2];

#[doc(hidden)]
/// Working memory of [`flow_between_with`], about 60 bytes a pixel of the frame.
///
/// Its contents never affect results; dropping it is always safe.
#[derive(Debug, Clone, Default)]
pub struct FlowScratch {
    grid: PatchGrid,
    votes: Votes,
    refiner: Refiner,
}

/// The flow from `from` to `to`, two pyramids of frames of the same size; no motion if the sizes differ.
///
/// # Examples
/// A picture of digits moves one pixel to the right.
///
/// ```
/// use tracecut::flow::{FlowParams, FlowPyramid, flow_between};
/// use tracecut::image::Plane;
///
/// let rows = ["0013588531", "0136898631", "0137998731", "0136898631", "0013588531"];
/// // Each digit becomes a patch of 8 by 8 pixels of that brightness.
/// let digit = |x: usize, y: usize| f32::from(rows[y / 8 % 5].as_bytes()[x / 8 % 10] - b'0');
/// let first = FlowPyramid::new(&Plane::from_fn(80, 40, |x, y| 25.0 * digit(x + 1, y)));
/// let second = FlowPyramid::new(&Plane::from_fn(80, 40, digit).map(|v| 25.0 * v));
/// let flow = flow_between(&first, &second, &FlowParams::default());
/// let (u, v) = (flow.u[(40, 20)], flow.v[(40, 20)]);
/// assert!((u - 1.0).abs() < 0.25 && v.abs() < 0.25, "{u}, {v}");
/// ```
#[must_use]
pub fn flow_between(from: &FlowPyramid, to: &FlowPyramid, params: &FlowParams) -> FlowField {
    flow_between_with(from, to, params, &mut FlowScratch::default())
}

#[doc(hidden)]
/// As [`flow_between`], with working memory that is kept from one pair to the next.
#[must_use]
pub fn flow_between_with(
    from: &FlowPyramid,
    to: &FlowPyramid,
    params: &FlowParams,
    scratch: &mut FlowScratch,
) -> FlowField {
    let (width, height) = from.size();
    if from.size() != to.size() || width * height == 0 {
        return FlowField::still(width, height);
    }
    let num_levels = from.levels.len().min(to.levels.len());
    let mut coarser = None;
    for level in (0..num_levels).rev() {
        let scan = SCAN_RADIUS.get(num_levels - 1 - level).copied();
        let pair = (&from.levels[level], &to.levels[level]);
        scratch.lay_patches(pair.0, level, coarser.as_ref(), params);
        let reach = if coarser.is_some() { REACH } else { PATCH_SIDE as f32 };
        // Where patches are not searched they keep the coarser level's flow: each pixel then takes the motion near it that
        // fits best.
        let search =
            (level >= params.search_level as usize || coarser.is_none()).then_some(PatchSearch { reach, scan });
        let mut flow = scratch.match_patches(pair, search.as_ref());
        scratch.refiner.refine(&pair.0.image, &pair.1.image, &mut flow.u, &mut flow.v, params);
        coarser = Some(flow);
    }
    coarser.unwrap_or_default()
}

/// How patches are searched at one level.
#[derive(Debug, Clone, Copy)]
struct PatchSearch {
    /// Furthest that a descent may lead, in pixels.
    reach: f32,
    /// Radius of the scan before it, in pixels.
    scan: Option<i16>,
}

impl FlowScratch {
    /// Step 1: patches over the level, starting from the flow of the coarser one.
    fn lay_patches(&mut self, from: &Level, level: usize, coarser: Option<&FlowField>, params: &FlowParams) {
        let mut stride = params.patch_stride as usize;
        if level > params.search_level as usize {
            stride = (3 * stride / 4).max(1);
        }
        self.grid.lay(from.image.width, from.image.height, stride);
        if let Some(coarser) = coarser {
            self.grid.start_from(coarser);
        }
    }

    /// Steps 2 and 3; without a `search`, patches stay where they start.
    fn match_patches(&mut self, (from, to): (&Level, &Level), search: Option<&PatchSearch>) -> FlowField {
        if let Some(search) = search {
            if let Some(radius) = search.scan {
                self.grid.scan(from, to, radius);
            }
            self.grid.search(from, to, search.reach);
        }
        let mut flow = FlowField::still(from.image.width, from.image.height);
        densify(from, to, &self.grid, &mut self.votes, &mut flow);
        flow
    }
}

#[cfg(test)]
mod tests;
