//! Sessions: all stages over a clip, or over a long clip window by window, and their results.
//!
//! Rooms, each importing only from those before it: `window` (windows, cuts, and object labels across windows), `base`
//! (parameters, stages, outputs), `jobs` (work for any thread or worker), `run` (the states of a run and the work of each
//! stage), then `drive` (threads, workers, windows, checkpoints) and `read` (results and corrections).

mod base;
mod drive;
#[cfg_attr(
    all(target_arch = "wasm32", not(feature = "wasm")),
    allow(dead_code, reason = "without threads or an interface no jobs are handed out")
)]
mod jobs;
mod read;
mod run;
mod window;

pub use base::{ClipParams, Params, Progress, Stage, Step};
#[cfg(not(target_arch = "wasm32"))]
pub use drive::{Checkpoint, Windows};
#[cfg(feature = "wasm")]
pub(crate) use jobs::{Job, JobId, JobResult};
pub use read::explanation;
pub use run::Session;
pub use window::ShotParams;
#[cfg(any(not(target_arch = "wasm32"), feature = "wasm"))]
pub use window::Window;
#[cfg(all(feature = "wasm", target_arch = "wasm32"))]
pub(crate) use window::WindowPlan;
