//! Figure and ground: camera motion, saliency, clusters of trajectories, and the clusters that are objects.

pub mod background;
pub mod camera;
pub(crate) mod classify;
pub mod connectedness;
pub mod discretize;
#[doc(hidden)]
pub mod evidence;
pub(crate) mod objects;
pub mod saliency;
