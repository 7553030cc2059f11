//! The fitted weights, by the command below; do not edit them by hand.
//!
//! `tracecut eval fit bms26 davis wild --out src/evidence/weights.rs`

/// Of a pair of clusters, for that they are one: base, then the terms of `pair`.
pub(super) const PAIR: [f64; 5] = [3.1655, -0.8650, -0.3643, -0.5248, 0.3826];
