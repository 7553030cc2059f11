//! Parameters of tracking.

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
