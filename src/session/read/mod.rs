//! The results of a session, explanations of them, and corrections.

mod corrections;
#[cfg(test)]
mod corrections_tests;
pub mod explanation;
#[cfg(test)]
mod explanation_tests;
mod results;
