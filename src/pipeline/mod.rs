//! The stages in their order.

mod dense;
mod geometry;
mod motion;
mod session;

pub use session::{Progress, Session, Stage, Step};
