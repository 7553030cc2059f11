//! What the targets call: the generators and checks of the property tests.

#[path = "../../cli/tests/readers/checks.rs"]
pub mod checks;
#[path = "../../bench/tests/readers/checks.rs"]
pub mod truth;
#[path = "../../tests/rust/made/mod.rs"]
pub mod made;
