//! The results of a session, explanations of them, and corrections.

mod confidence;
mod corrections;
#[cfg(test)]
mod corrections_tests;
mod explanation;
#[cfg(test)]
mod explanation_tests;
mod results;

pub use explanation::{
    Affinity, Evidence, Explanation, LabelCost, LabelFlip, LabelSource, ObjectBorder, SuperpixelLink, Voter,
};
