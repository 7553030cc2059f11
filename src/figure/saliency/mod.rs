//! Context-aware saliency (section 3): which trajectories stand out against what surrounds them.
//!
//! In: the flow of each frame, trajectories, their embedding. Out: a saliency in `0.0..=1.0` for each pixel and each
//! trajectory, and the foreground.
//!
//! 1. The *dominant motion* of each frame, which is the camera's, is subtracted from its flow; what is left has a
//!    magnitude (`dominant`).
//! 2. Magnitudes fall into bins over a range that the whole clip sets (`maps`).
//! 3. A pixel is salient as far as its bin is commoner inside some window than in the ring around it (`surround`).
//! 4. A trajectory's own saliency `s` is the greatest of its points'. In context, as `s̄`, it is the mean over
//!    the trajectories near it in the embedding; above a threshold it is foreground (`context`).
//!
//! **Deviations from the paper**, which [`Params::paper`](crate::Params::paper) undoes but for the sign of step 4. The paper takes
//! the magnitude of the flow as it is, over fixed bins. docs/choices.md lists these choices.
//!
//! **Limits.** Where the world is neither far away nor near to a plane, what stands close to a moving camera differs
//! from the dominant motion as objects do: trees before a running dog, rocks before a goat. What does not move cannot
//! be found.
//!
//! Steps 1 to 3 give the same bits on every target.

mod context;
mod maps;
mod surround;
#[cfg(test)]
mod tests;

pub use context::{context_saliency, look_up, trajectory_saliency};
pub use maps::SaliencyMaps;

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

/// How salient each trajectory is.
///
/// Law: the three have one entry for each trajectory; saliencies are in `0.0..=1.0`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Saliency {
    /// `s_i`: the greatest saliency of the trajectory's points.
    pub of_points: Vec<f32>,
    /// `s̄_i`: the mean of `s` over the trajectory's neighbourhood in the embedding.
    pub in_context: Vec<f32>,
    /// Whether `s̄_i` is above the threshold.
    pub foreground: Vec<bool>,
}
