//! What runs: the states of a session, and the work of each stage.

mod alternatives;
mod clip;
mod cut;
mod dense;
#[cfg(test)]
mod external_tests;
mod foreground;
mod motion;
mod recut;
mod session;
mod spectral;
mod state;
#[cfg(test)]
mod tests;

pub(crate) use clip::{Clip, Trackers};
pub(crate) use dense::{estimate_camera, model_background};
pub(crate) use recut::{TargetLabels, objects_from_labels};
pub(crate) use session::Phase;
pub use session::Session;
pub(crate) use state::{Run, State};
