//! From frames to what motion alone says of trajectories.

pub mod affinity;
pub mod discontinuity;
pub mod embedding;
pub mod flow;
pub mod trajectory;
