//! The fitted weights, by the command below; do not edit them by hand.
//!
//! `cargo run --release -p tracecut-bench -- fit bms26 davis wild --frames 50 --seeds 0`
//!
//! The last table is by the same with `wild --only cdnet,sbi,ucsd`, made later.

/// Of a pair of clusters, for that they are one: base, then the terms of `pair`.
pub(super) const PAIR: [f64; 5] = [3.0988, -0.8723, -0.3585, -0.4741, 0.5241];

/// Of a cluster, for that it is an object: base, then the terms of `Signs`.
pub(super) const OBJECT: [f64; 3] = [-3.0830, -1.4495, 0.5816];

/// Of a cluster before a still camera, for that it is an object: base, then its term of `Signs`.
pub(super) const OBJECT_BEFORE_PLATE: [f64; 2] = [2.8582, 1.6986];
