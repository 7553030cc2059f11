//! Parameters of the flow.

/// Side of a square patch, in pixels (OpenCV's presets: 8). Larger is smoother and loses small objects; a constant, so
/// that loops over a patch become vector instructions.
pub(super) const PATCH_SIDE: usize = 8;

crate::params! {
    /// Dense optical flow by inverse search (DIS) and variational refinement.
    pub struct FlowParams {
        /// Pixels between neighbouring patches down to the finest level that is searched, the patch's side at most; three
        /// quarters of it at coarser ones. Lower is slower.
        pub patch_stride: u32 = 4, in 1..=8;
        /// Most steps of a patch's descent. Higher is slower.
        pub descents: u32 = 4, in 0..=64;
        /// Finest level at which patches are searched, 0 being full size; in finer ones each pixel takes the motion near
        /// it that fits best. Higher is faster and loses what is small.
        pub search_level: u32 = 0, in 0..=4;
        /// Level at which the flow ends: 0 is full size, 1 half of it. Higher is faster and blurs borders.
        pub finest_level: u32 = 0, in 0..=4;
        /// Standard deviation of the blur that frames get first, in pixels. Higher is smoother and loses fine
        /// structure.
        pub presmoothing: f32 = 0.7, in 0.0..=4.0;
        /// Weight of constant brightness in the refinement.
        pub brightness_weight: f32 = 5.0, in 0.0..=1000.0;
        /// Weight of constant slopes of brightness in the refinement; it copes with changing light.
        pub slope_weight: f32 = 10.0, in 0.0..=1000.0;
        /// Weight of smoothness in the refinement.
        pub smoothness: f32 = 25.0, in 0.001..=1000.0;
        /// Times that the refinement renews its robust weights, at every level; 0 leaves it out. Higher is slower.
        pub fixed_points: u32 = 5, in 0..=12;
        /// Sweeps of the refinement's solver each time. Higher is slower.
        pub sweeps: u32 = 5, in 1..=24;
        /// Over-relaxation of these sweeps.
        pub overrelaxation: f32 = 1.9, in 1.0..=1.99;
    }
}
