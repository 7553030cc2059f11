//! The order of all stages, and long clips window by window.

pub mod pipeline;
pub(crate) mod window;
