//! The generators and checks of the property tests, for fuzz targets.

#[path = "../../cli/tests/readers.rs"]
pub mod checks;
#[path = "../../bench/tests/readers.rs"]
pub mod truth;
#[path = "../../tests/rust/generators/mod.rs"]
pub mod generators;
