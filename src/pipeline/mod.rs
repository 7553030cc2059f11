//! The stages in their order.

mod clip;
mod correct;
#[cfg(test)]
mod correct_tests;
mod dense;
mod figure;
mod foreground;
mod found;
mod geometry;
mod motion;
mod params;
mod recut;
mod results;
mod session;
mod spectral;
mod stage;
mod state;
#[cfg(test)]
mod tests;
mod trackers;
mod turn;
mod windows;
#[cfg(test)]
mod windows_tests;

pub use params::{ClipParams, Params, ScaledParams};
pub use session::Session;
pub use stage::{Progress, Stage, Step};
