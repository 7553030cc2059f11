//! The stages in their order.

#[cfg(not(target_arch = "wasm32"))]
mod checkpoint;
mod clip;
mod correct;
#[cfg(test)]
mod correct_tests;
mod dense;
mod figure;
mod foreground;
#[cfg(not(target_arch = "wasm32"))]
mod fork;
mod found;
mod geometry;
mod give;
#[cfg(test)]
mod given_tests;
#[cfg_attr(
    all(target_arch = "wasm32", not(feature = "wasm")),
    allow(dead_code, reason = "the decoder gives nothing away")
)]
mod ledger;
#[cfg(not(target_arch = "wasm32"))]
mod long;
#[cfg(test)]
mod long_tests;
mod motion;
mod pair;
mod params;
#[cfg_attr(
    all(target_arch = "wasm32", not(feature = "wasm")),
    allow(dead_code, reason = "the decoder gives nothing away")
)]
mod piece;
#[cfg(test)]
mod piece_tests;
#[cfg(any(not(target_arch = "wasm32"), feature = "wasm"))]
mod plan;
mod recut;
mod results;
mod session;
mod spectral;
mod stage;
mod state;
mod sure;
#[cfg(test)]
mod tests;
#[cfg(not(target_arch = "wasm32"))]
mod threads;
mod trackers;
mod turn;
mod why;
#[cfg(test)]
mod why_tests;
mod windows;
#[cfg(test)]
mod windows_tests;
#[cfg(any(feature = "wasm", test))]
mod wire;

pub use crate::background::BackgroundParams;
pub use crate::window::ShotParams;
#[cfg(not(target_arch = "wasm32"))]
pub use checkpoint::Checkpoint;
#[cfg(not(target_arch = "wasm32"))]
#[doc(hidden)] // For `bench ablate`.
pub use fork::Forks;
#[cfg(not(target_arch = "wasm32"))]
pub use long::Windows;
pub use params::{ClipParams, Params, ScaledParams};
#[cfg(feature = "wasm")]
pub(crate) use piece::{Made, Piece, PieceId};
#[cfg(all(feature = "wasm", target_arch = "wasm32"))]
pub(crate) use plan::Plan;
#[cfg(any(not(target_arch = "wasm32"), feature = "wasm"))]
pub use plan::Window;
pub use session::Session;
pub use stage::{Progress, Stage, Step};
pub use why::{Affinity, Border, Evidence, Explanation, Flip, LabelCost, Source, SuperpixelLink, Voter};
