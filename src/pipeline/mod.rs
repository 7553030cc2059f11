//! The stages in their order.

mod dense;
mod foreground;
mod geometry;
mod motion;
mod results;
mod session;
mod stage;
#[cfg(test)]
mod tests;

pub use session::Session;
pub use stage::{Progress, Stage, Step};
