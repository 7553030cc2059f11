//! The windows of long clips: where they begin and end, cuts between shots, and object labels from window to window.

mod identity;
#[cfg(any(not(target_arch = "wasm32"), feature = "wasm"))]
mod plan;
mod shot;

pub(crate) use identity::object_appearances;
pub(crate) use identity::{Identities, NumberedTracks};
#[cfg(any(not(target_arch = "wasm32"), feature = "wasm"))]
pub use plan::Window;
#[cfg(any(not(target_arch = "wasm32"), feature = "wasm"))]
pub(crate) use plan::WindowPlan;
pub use shot::ShotParams;
pub(crate) use shot::{Thumbnail, unmatched_share};
