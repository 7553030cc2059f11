//! Generators of inputs, and the invariants of their results. The property tests call them with seeds, the fuzz targets in
//! `fuzz/` with the bytes of a fuzzer.

pub mod choices;
pub mod clips;
pub mod invariants;
pub mod seeds;
pub mod sessions;
