//! What runs: the states of a session, and the work of each stage.

mod clip;
mod dense;
mod figure;
mod foreground;
#[cfg(test)]
mod given_tests;
mod motion;
mod recut;
mod session;
mod spectral;
mod state;
#[cfg(test)]
mod tests;
mod trackers;
mod turn;

pub(crate) use clip::Clip;
pub(crate) use dense::{background_of, camera_of, clusters_of, place, to_input};
pub(crate) use recut::{Wanted, objects_with};
pub(crate) use session::Phase;
pub use session::Session;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use spectral::Linking;
pub(crate) use state::State;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use trackers::Trackers;
