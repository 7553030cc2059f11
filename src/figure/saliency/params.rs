//! The parameters of saliency.

crate::choices! {
    /// Which motion of the camera is taken from the flow before its magnitude counts.
    pub enum Compensation {
        /// None: the magnitude of the flow as it is, as the paper has it.
        Off = "off",
        /// The dominant affine motion of each frame.
        Affine = "affine",
        /// The dominant homography of each frame.
        Homography = "homography",
    }
}

crate::choices! {
    /// Which of two trajectories' densities an affinity is compared with.
    pub enum Neighborhood {
        /// The greater, as discontinuities do: both must be as near as the denser of them has its neighbours.
        Max = "max",
        /// The smaller, as the paper prints it: it is enough to be as near as the sparser has them.
        Min = "min",
    }
}

crate::params! {
    /// Saliency, and the foreground that follows from it.
    pub struct SaliencyParams {
        /// Motion of the camera that is taken from the flow before its magnitude is looked at (the paper: off).
        pub compensation: Compensation = Compensation::Homography, in 0..=2, expert;
        /// Difference from the dominant motion at which a point of the flow counts half when that motion is fitted, in
        /// pixels a frame.
        pub tolerance: f64 = 0.5, in 0.01..=100.0, expert;
        /// Bins of the magnitude (Rahtu et al.: 15). Higher is slower.
        pub bins: u32 = 15, in 2..=32, expert;
        /// Magnitude at which the last bin ends, in pixels a frame (Rahtu et al.: 15); 0 takes it from the clip.
        pub range: f64 = 0.0, in 0.0..=250.0, expert;
        /// Probability that a pixel of a window is salient before its magnitude is looked at (Rahtu et al.: 0.2).
        pub prior: f32 = 0.2, in 0.001..=0.999, expert;
        /// ℓ: trajectories count as close in the embedding while their embedding affinity is above this part of their
        /// density (section 3; the value is not given there). Higher averages over fewer.
        pub neighborhood: f64 = 0.4, in 0.0..=1.0, expert;
        /// Which of two trajectories' densities that is (the paper: min).
        pub form: Neighborhood = Neighborhood::Max, in 0..=1, expert;
        /// Trajectories of a context-aware saliency above this are foreground (section 3: 0.5).
        pub threshold: f64 = 0.5, in 0.0..=1.0;
    }
}

impl SaliencyParams {
    /// As the paper has it: the magnitude of the flow as it is, in bins over 0 to 15 pixels, and the neighbourhood as it is printed with its sign
    /// turned.
    pub(crate) fn paper() -> Self {
        Self { compensation: Compensation::Off, neighborhood: 0.7, form: Neighborhood::Min, ..Self::default() }
    }
}
