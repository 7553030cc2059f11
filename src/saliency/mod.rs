//! Context-aware saliency (section 3): which trajectories stand out against what surrounds them.
//!
//! In: the flow of each frame, trajectories, their embedding. Out: a saliency in `0.0..=1.0` for each pixel and each trajectory, and the
//! foreground.
//!
//! Stand-in.

use crate::discontinuity::Discontinuities;
use crate::embedding::Embedding;
use crate::flow::FlowField;
use crate::image::Plane;

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

crate::params! {
    /// Saliency, and the foreground that follows from it.
    pub struct SaliencyParams {
        /// Motion of the camera that is taken from the flow before its magnitude is looked at (the paper: off).
        pub compensation: Compensation = Compensation::Affine, in 0..=2;
        /// ℓ: trajectories count as close in the embedding while their embedding affinity is above this part of the greater of their
        /// densities (section 3; the value is not given there). Higher averages over fewer.
        pub neighborhood: f64 = 0.4, in 0.0..=1.0;
        /// Trajectories of a context-aware saliency above this are foreground (section 3: 0.5).
        pub threshold: f64 = 0.5, in 0.0..=1.0;
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

/// Saliency maps of the frames of one clip: first all flows are looked at, then maps can be made.
#[derive(Debug, Clone, PartialEq)]
pub struct SaliencyMaps {
    params: SaliencyParams,
}

impl SaliencyMaps {
    /// Nothing looked at yet.
    pub fn new(params: &SaliencyParams) -> Self {
        Self { params: params.clone() }
    }

    /// Takes note of the next frame's flow: its dominant motion and its magnitudes. Call once for each flow of the clip, in order.
    pub fn look_at(&mut self, _flow: &FlowField) {}

    /// The saliency of each pixel of frame `t`, whose flow this is, in `0.0..=1.0`.
    pub fn map(&self, _t: usize, flow: &FlowField) -> Plane<f32> {
        let _ = &self.params;
        flow.u.map(|_| 0.2)
    }
}

/// The context-aware saliency of each trajectory from the greatest saliency of its points.
pub fn context_saliency(
    of_points: Vec<f32>,
    _embedding: &Embedding,
    _discontinuities: &Discontinuities,
    params: &SaliencyParams,
) -> Saliency {
    let in_context = of_points.clone();
    let foreground = in_context.iter().map(|&s| f64::from(s) > params.threshold).collect();
    Saliency { of_points, in_context, foreground }
}
