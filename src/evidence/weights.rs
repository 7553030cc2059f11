//! The fitted weights, by the command below; do not edit them by hand.
//!
//! `tracecut eval fit bms26 davis wild --frames 50 --seeds 0`

/// Of a pair of clusters, for that they are one: base, then the terms of `pair`.
pub(super) const PAIR: [f64; 5] = [3.1816, -0.9164, -0.3270, -0.5452, 0.5461];

/// Of a cluster, for that it is an object: base, then the terms of `object`.
pub(super) const OBJECT: [f64; 3] = [-2.8779, -1.4743, 0.5769];
