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
mod params;
mod surround;
#[cfg(test)]
mod tests;

pub(crate) use context::pixels_at;
pub use context::{Saliency, context_saliency, look_up, trajectory_saliency};
pub(crate) use maps::Asked;
pub use maps::SaliencyMaps;
pub use params::{Compensation, Neighborhood, SaliencyParams};
