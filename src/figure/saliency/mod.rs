//! Context-aware saliency of trajectories (section 3): contrast of their motion to the surroundings.
//!
//! In: the flow of each frame, trajectories, their embedding. Out: a saliency in `0.0..=1.0` for each pixel and each
//! trajectory, and the foreground.
//!
//! 1. The *dominant motion* of each frame, which is the camera's, is subtracted from its flow (`camera::dominant`).
//! 2. The magnitudes of the residual fall into bins, over the range of the whole clip (`maps`).
//! 3. A pixel's saliency is the probability of its bin inside a window, against the ring around it (`centre_surround`).
//! 4. A trajectory's saliency `s` is the greatest of its points'. Its context-aware saliency `s̄` is the mean of `s` over
//!    the trajectories near it in the embedding; above a threshold it is foreground (`context`).
//!
//! **Deviations from the paper**, all of which [`Params::paper`](crate::Params::paper) reverts but the sign of step 4: the paper
//! bins the magnitude of the raw flow over a fixed range. docs/choices.md lists these choices.
//!
//! Cost: O(windows · bins) for each frame, and O(n² K) for n trajectories. It fails where the scene is neither far away nor
//! flat: what is close to a moving camera is as salient as objects, such as trees before a running dog. Static objects are
//! not salient. Steps 1 to 3 give the same bits on every target.

mod centre_surround;
mod context;
mod maps;
mod params;
#[cfg(test)]
mod tests;

pub use context::{Saliency, context_saliency, trajectory_saliency};
pub(crate) use context::{greatest_of_points, point_pixels};
pub use maps::SaliencyMaps;
pub(crate) use maps::SaliencyQuery;
pub use params::{Compensation, Neighborhood, SaliencyParams};
