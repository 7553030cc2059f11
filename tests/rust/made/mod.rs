//! Generators of whatever a user may bring, and what must hold of every outcome: one function for each way in. The
//! property tests call them with seeds, the fuzz targets in `fuzz/` with the bytes of a fuzzer.

pub mod choices;
pub mod clips;
pub mod images;
pub mod laws;
pub mod mutate;
pub mod readers;
pub mod recorded;
pub mod seeds;
pub mod sessions;
