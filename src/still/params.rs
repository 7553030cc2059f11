//! Parameters of single images.

crate::choices! {
    /// The eigenvectors that a discontinuity of pixels is computed from.
    pub enum Grouping {
        /// All eigenvectors together, as between trajectories: the paper's Ŵ.
        Joint = "joint",
        /// Each eigenvector with the constant one, and then a mean over all of them.
        Single = "single",
    }
}

crate::params! {
    /// Pixel embedding of single images, and its discontinuities.
    pub struct StillParams {
        /// Longest side at which an image is processed, in pixels; larger ones are reduced. Higher is slower and takes more
        /// memory.
        pub max_side: u32 = 640, in 16..=4096;
        /// Radius within which pixels are compared, in pixels. Higher is slower.
        pub radius: u32 = 5, in 1..=10, expert;
        /// Pb between two pixels that lowers their affinity to 1/e.
        pub sigma: f32 = 0.1, in 0.001..=10.0, expert;
        /// Number of eigenvectors, the constant one included. Higher is slower.
        pub dimensions: u32 = 24, in 2..=64, expert;
        /// Eigenvectors that d is computed from: all together (the paper: joint), or each with the constant one and then a
        /// mean.
        pub grouping: Grouping = Grouping::Single, in 0..=1, expert;
        /// Weight of the discontinuities in the combined map; 0 gives Pb.
        pub weight: f32 = 1.0, in 0.0..=100.0;
    }
}
