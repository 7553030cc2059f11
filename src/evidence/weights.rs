//! The fitted weights, by the command below; do not edit them by hand.
//!
//! `tracecut eval fit bms26 davis wild --out src/evidence/weights.rs`

/// Of a pair of clusters, for that they are one: base, then the terms of `pair`.
pub(super) const PAIR: [f64; 4] = [2.9374, -1.4010, -0.2898, -0.5138];
