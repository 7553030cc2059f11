//! Point trajectories: where the points of the scene go, frame after frame (section 2.1).
//!
//! In: frames and their flow, forward and backward. Out: [`Trajectories`]. The tracker is by Sundaram, Brox and
//! Keutzer (ECCV 2010); the paper uses it:
//!
//! 1. Seed points on a grid where the structure tensor's smaller eigenvalue shows structure in two directions.
//! 2. Move each point by the forward flow, sampled bilinearly.
//! 3. End it where the backward flow does not lead back (occlusion) or where the flow changes too fast (motion
//!    boundary).
//! 4. Seed again wherever no live point is near; drop tracks that are too short.
//!
//! Deviation from the published tracker: structure is measured on brightness instead of colour, and points are sampled
//! bilinearly instead of at the nearest pixel, which keeps velocities smooth.
//! Cost: O(pixels + points) per frame.

mod params;
mod structure;
mod tracker;
mod trajectories;

pub use params::TrajectoryParams;
pub use structure::structure;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use tracker::Found;
pub use tracker::Tracker;
pub use trajectories::Trajectories;
