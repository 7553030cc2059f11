//! Long clips, window by window: where windows begin and end, where a shot ends, and which objects of one window are which
//! of the next.

mod identity;
#[cfg(any(not(target_arch = "wasm32"), feature = "wasm"))]
mod plan;
mod portrait;
mod shot;

pub(crate) use identity::Identities;
#[cfg(any(not(target_arch = "wasm32"), feature = "wasm"))]
pub(crate) use plan::Plan;
#[cfg(any(not(target_arch = "wasm32"), feature = "wasm"))]
pub use plan::Window;
pub(crate) use portrait::portraits;
pub use shot::ShotParams;
pub(crate) use shot::{Thumbnail, unmatched_share};
