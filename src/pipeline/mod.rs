//! The stages in their order.

mod session;

pub use session::{Progress, Session, Stage, Step};
