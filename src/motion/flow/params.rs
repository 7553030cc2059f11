//! Parameters of the flow.

/// Side of a square patch, in pixels (OpenCV's presets: 8). Larger is smoother and loses small objects. A constant, so that
/// loops over a patch vectorise.
pub(super) const PATCH_SIDE_PX: usize = 8;

crate::params! {
    /// Dense optical flow by inverse search (DIS) and variational refinement.
    pub struct FlowParams {
        /// Pixels between neighbouring patches down to the finest level that is searched, the patch's side at most; three
        /// quarters of it at coarser ones. Lower is slower.
        pub patch_stride: u32 = 4, in 1..=8, expert;
        /// Finest level at which patches are searched, 0 being full size; in finer ones each pixel takes the motion near
        /// it that fits best. Higher is faster and loses what is small.
        pub search_level: u32 = 0, in 0..=4;
        /// Longest side at which the flow of a clip is computed, in pixels; larger frames are reduced for it, and the field is
        /// enlarged. Single pairs, and runs that end with the labels of trajectories, keep their size. Higher is slower.
        pub max_side: u32 = 480, in 16..=4096, expert;
        /// Weight of smoothness in the refinement.
        pub smoothness: f32 = 25.0, in 0.001..=1000.0, expert;
        /// Fixed-point iterations of the refinement at every level, each with new robust weights; 0 skips the refinement.
        /// Higher is slower.
        pub fixed_points: u32 = 5, in 0..=12, expert;
        /// The same for the backward field of a clip, which only checks the forward one; docs/choices.md.
        pub check_fixed_points: u32 = 0, in 0..=12, expert;
    }
}

impl FlowParams {
    /// Returns the parameters of the field that checks another one.
    #[doc(hidden)] // For `examples/method.rs`.
    #[must_use]
    pub fn for_check(&self) -> Self {
        Self { fixed_points: self.check_fixed_points, ..self.clone() }
    }
}
