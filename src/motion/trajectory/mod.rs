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

mod structure;
mod tracker;
mod trajectories;

#[doc(hidden)] // For benchmarks.
pub use structure::structure;
pub use tracker::Tracker;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use tracker::TrackerState;
pub use trajectories::Trajectories;

crate::params! {
    /// Point trajectories.
    pub struct TrajectoryParams {
        /// Spacing of the seed grid, in pixels of the processed frames. Lower is slower and finds smaller objects.
        /// Default: the published tracker's 8.
        pub grid_step: f32 = 8.0, in 3.0..=64.0;
        /// Shortest trajectory kept, in frames (section 5: 7). Clips of fewer than 13 frames use half their length, but
        /// at least 2.
        pub min_length: u32 = 7, in 2..=1000;
        /// Spacing of the denser trajectories that the masks are made from, in pixels of the processed frames.
        pub mask_step: f32 = 4.0, in 2.0..=64.0;
        /// Shortest trajectory that the masks are made from, in frames.
        pub mask_min_length: u32 = 2, in 2..=1000, expert;
        /// A seed needs a structure of more than this fraction of the frame's mean, and eleven times as much on the border
        /// (published tracker: 0.1). Lower tracks weaker texture, which the checks below then have to judge.
        pub structure_mean: f32 = 0.03, in 0.0..=10.0, expert;
        /// A seed needs more than this structure, in grey levels squared (published tracker: 1). 0 seeds all but
        /// constant areas.
        pub structure_floor: f32 = 0.02, in 0.0..=1000.0, expert;
    }
}

impl TrajectoryParams {
    /// Returns these parameters with the spacing and minimum length of the denser trajectories for masks.
    #[doc(hidden)] // For `examples/method.rs`.
    pub fn for_masks(&self) -> Self {
        Self { grid_step: self.mask_step, min_length: self.mask_min_length, ..self.clone() }
    }
}
