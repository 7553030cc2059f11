//! The stages in their order.

mod correct;
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
