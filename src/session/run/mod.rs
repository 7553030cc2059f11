//! What runs: the states of a session, and the work of each stage.

mod clip;
mod cut;
mod dense;
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
mod work;

pub(crate) use clip::{Clip, Trackers};
pub(crate) use dense::{background_of, camera_of};
pub(crate) use recut::{Wanted, objects_with};
pub(crate) use session::Phase;
pub use session::Session;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use spectral::AffinityWork;
pub(crate) use state::{Run, State};
