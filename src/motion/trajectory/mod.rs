//! Point trajectories: scene points followed from frame to frame along the flow (section 2.1).
//!
//! In: frames and their flow, forward and backward. Out: [`Trajectories`]. The tracker is the paper's, by Sundaram, Brox and
//! Keutzer (ECCV 2010):
//!
//! 1. Seed points on a grid where the structure tensor's smaller eigenvalue shows structure in two directions.
//! 2. Move each point by the forward flow, sampled bilinearly.
//! 3. End it where the backward flow does not lead back, `|w + w'|² ≥ 0.01 (|w|² + |w'|²) + 0.5` (occlusion), or where the
//!    flow changes too fast, `|∇u|² + |∇v|² > 0.01 |w|² + 0.002` (motion boundary).
//! 4. Seed again wherever no live point is near; drop short trajectories.
//!
//! **Deviations** from the published tracker: structure is measured on brightness instead of colour, and flow is sampled
//! bilinearly instead of at the nearest pixel, which keeps velocities smooth. **Cost**: O(pixels + points) per frame.
//! **Limits**: drift adds up; points on an object's border may slide to the background; areas without texture have no
//! points.

mod params;
mod structure;
mod tracker;
mod trajectories;

pub use params::TrajectoryParams;
#[doc(hidden)] // For benchmarks.
pub use structure::structure;
pub use tracker::Tracker;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use tracker::TrackerState;
pub use trajectories::Trajectories;
