//! Motion: from frames to trajectories, their affinities, embedding and discontinuities.

pub mod affinity;
pub mod discontinuity;
pub mod embedding;
pub mod flow;
pub mod trajectory;
