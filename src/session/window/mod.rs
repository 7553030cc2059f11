//! Long clips, window by window: where a shot ends, and which objects of one window are which of the next.
//!
//! `pipeline` moves the window along; what has to be known for that is found here.

mod identity;
mod portrait;
mod shot;

pub(crate) use identity::Identities;
pub(crate) use portrait::portraits;
pub use shot::ShotParams;
pub(crate) use shot::{Thumbnail, unmatched_share};
