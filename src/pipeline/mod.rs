//! The stages in their order.

mod correct;
#[cfg(test)]
mod correct_tests;
mod dense;
mod foreground;
mod geometry;
mod motion;
mod recut;
mod results;
mod session;
mod stage;
#[cfg(test)]
mod tests;
mod windows;
#[cfg(test)]
mod windows_tests;

pub use session::Session;
pub use stage::{Progress, Stage, Step};
