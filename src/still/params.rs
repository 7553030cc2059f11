//! The parameters of single images.

crate::choices! {
    /// What a discontinuity of pixels is measured in.
    pub enum Grouping {
        /// All eigenvectors at once, as between trajectories: the paper's Ŵ.
        Joint = "joint",
        /// Each eigenvector beside the constant one, a mean over all of them.
        Single = "single",
    }
}

crate::params! {
    /// Pixel embedding of single images, and its discontinuities.
    pub struct StillParams {
        /// Longest side at which an image is looked at, in pixels; larger ones are reduced. Higher is slower and takes
        /// more memory.
        pub max_side: u32 = 640, in 16..=4096;
        /// Pixels at most this far apart are compared, in pixels. Higher is slower.
        pub radius: u32 = 5, in 1..=10, expert;
        /// Pb that leaves 1/e of the affinity of two pixels when it lies between them.
        pub sigma: f32 = 0.1, in 0.001..=10.0, expert;
        /// Number of eigenvectors, the constant one included. Higher is slower.
        pub dimensions: u32 = 24, in 2..=64, expert;
        /// What d is measured in: all eigenvectors at once (the paper: joint), or each beside the constant one and then
        /// a mean.
        pub grouping: Grouping = Grouping::Single, in 0..=1, expert;
        /// How much the discontinuities count beside Pb in the combined map; 0 gives Pb.
        pub weight: f32 = 1.0, in 0.0..=100.0;
    }
}
