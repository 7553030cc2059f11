//! What is read of a session, and corrected in it.

mod corrections;
#[cfg(test)]
mod corrections_tests;
mod results;
mod sureness;
mod why;
#[cfg(test)]
mod why_tests;

pub use why::{Affinity, Border, Evidence, Explanation, Flip, LabelCost, Source, SuperpixelLink, Voter};
