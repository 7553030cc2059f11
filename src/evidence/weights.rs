//! The fitted weights, by the command below; do not edit them by hand.
//!
//! `tracecut eval fit bms26 davis wild --out src/evidence/weights.rs`

/// Of a pair of clusters, for that they are one: base, then the terms of `pair`.
pub(super) const PAIR: [f64; 5] = [3.1591, -0.9145, -0.3441, -0.5383, 0.5149];

/// Of a cluster, for that it is an object: base, then the terms of `object`.
pub(super) const OBJECT: [f64; 3] = [-3.5600, -1.7400, 0.6000];
