//! A run of all stages: clips, long ones window by window, and their results.
//!
//! Rooms, each importing only from those before it: `window` (shots, and which object is which in the next window),
//! `base` (parameters, stages, outputs), `jobs` (work that any thread or worker can do), `run` (the states of a run and the
//! work of each stage), then `drive` (who does the work: threads, workers, windows, forks) and `read` (results and
//! corrections).

mod base;
mod drive;
#[cfg_attr(
    all(target_arch = "wasm32", not(feature = "wasm")),
    allow(dead_code, reason = "nothing is given away without an interface for it")
)]
mod jobs;
mod read;
mod run;
mod window;

pub use crate::background::BackgroundParams;
pub use base::{ClipParams, Params, Progress, ScaledParams, Stage, Step};
#[cfg(not(target_arch = "wasm32"))]
#[doc(hidden)] // For `bench ablate`.
pub use drive::Forks;
#[cfg(not(target_arch = "wasm32"))]
pub use drive::{Checkpoint, Windows};
#[cfg(feature = "wasm")]
pub(crate) use jobs::{Made, Piece, PieceId};
pub use read::{Affinity, Border, Evidence, Explanation, Flip, LabelCost, Source, SuperpixelLink, Voter};
pub use run::Session;
#[cfg(all(feature = "wasm", target_arch = "wasm32"))]
pub(crate) use window::Plan;
pub use window::ShotParams;
#[cfg(any(not(target_arch = "wasm32"), feature = "wasm"))]
pub use window::Window;
