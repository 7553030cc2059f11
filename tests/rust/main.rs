//! The library's integration tests: one program, so that what they share is compiled and linked once.

mod cost;
mod examples;
#[allow(unreachable_pub, dead_code, reason = "fuzz targets, of another crate, call the same modules")]
mod generators;
mod golden;
mod limits;
mod mirror;
mod pipeline;
mod plain_ground;
mod random;
mod repository;
mod spectral;
mod synth;
