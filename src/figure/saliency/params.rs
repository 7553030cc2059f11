//! The parameters of saliency.

crate::choices! {
    /// Model of the camera's motion that is subtracted from the flow.
    pub enum Compensation {
        /// None: the magnitude of the raw flow, as in the paper.
        Off = "off",
        /// The dominant affine motion of each frame.
        Affine = "affine",
        /// The dominant homography of each frame.
        Homography = "homography",
    }
}

crate::choices! {
    /// Density that the affinity of two trajectories is compared with.
    pub enum Neighborhood {
        /// The greater of both, as in discontinuities.
        Max = "max",
        /// The smaller of both, as the paper prints it.
        Min = "min",
    }
}

crate::params! {
    /// Saliency, and the foreground that follows from it.
    pub struct SaliencyParams {
        /// Model of the camera's motion that is subtracted from the flow (the paper: off).
        pub compensation: Compensation = Compensation::Homography, in 0..=2, expert;
        /// Residual at which a point of the flow counts half in the fit of the dominant motion, in pixels a frame.
        pub tolerance: f64 = 0.5, in 0.01..=100.0, expert;
        /// Bins of the magnitude (Rahtu et al.: 15). Higher is slower.
        pub bins: u32 = 15, in 2..=32, expert;
        /// Magnitude at which the last bin ends, in pixels a frame (Rahtu et al.: 15); 0 takes it from the clip.
        pub range: f64 = 0.0, in 0.0..=250.0, expert;
        /// Prior probability that a pixel of a window is salient (Rahtu et al.: 0.2).
        pub prior: f32 = 0.2, in 0.001..=0.999, expert;
        /// ℓ: trajectories are near in the embedding if their embedding affinity is above this part of their density
        /// (section 3; the value is not given there). Higher averages over fewer.
        pub neighborhood: f64 = 0.4, in 0.0..=1.0, expert;
        /// Density of two trajectories: the greater or the smaller (the paper: min).
        pub form: Neighborhood = Neighborhood::Max, in 0..=1, expert;
        /// Trajectories of a context-aware saliency above this are foreground (section 3: 0.5).
        pub threshold: f64 = 0.5, in 0.0..=1.0;
    }
}

impl SaliencyParams {
    /// The paper's: magnitude of the raw flow, and the printed neighbourhood with its sign reversed.
    pub(crate) fn paper() -> Self {
        Self { compensation: Compensation::Off, neighborhood: 0.7, form: Neighborhood::Min, ..Self::default() }
    }
}
