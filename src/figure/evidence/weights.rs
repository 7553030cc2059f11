//! The fitted weights, by the command below; do not edit them by hand.
//!
//! `cargo run --release -p tracecut-bench -- fit bms26 davis wild --frames 50 --seeds 0`
//!
//! The last table is by the same with `wild --only cdnet,sbi,ucsd`, made later.

/// Weights of a pair of clusters to be one object: bias, then the terms of `ClusterPair`.
pub(super) const PAIR_WEIGHTS: [f64; 5] = [3.0988, -0.8723, -0.3585, -0.4741, 0.5241];

/// Weights of a cluster to be an object, with a moving camera: bias, then the terms of `ClusterCues::Moving`.
pub(super) const OBJECT_WEIGHTS: [f64; 3] = [-3.0830, -1.4495, 0.5816];

/// Weights of a cluster to be an object, with a still camera: bias, then the term of `ClusterCues::Still`.
pub(super) const STILL_OBJECT_WEIGHTS: [f64; 2] = [2.8582, 1.6986];
