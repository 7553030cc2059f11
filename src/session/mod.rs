//! Sessions: all stages over a clip, or over a long clip window by window, and their results.
//!
//! Rooms, each importing only from those before it: `window` (windows, cuts, and object labels across windows), `base`
//! (parameters, stages, outputs), `jobs` (work for any thread or worker), `run` (the states of a run and the work of each
//! stage), then `drive` (threads, workers, windows, checkpoints) and `read` (results and corrections).

/// The windows of long clips: where they begin and end, cuts between shots, and object labels from window to window.
mod window {
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
}

/// Data of a session: parameters, stages, sizes and outputs.
mod base {
    mod outputs;
    mod params;
    mod scale;
    mod stage;

    pub(crate) use outputs::{Cut, CutContext, CutRegion, Outputs, SaliencyOutputs, TrackSet};
    pub(crate) use params::ScaledParams;
    pub use params::{ClipParams, Params};
    pub(crate) use scale::Scale;
    pub use stage::{Progress, Stage, Step};
}

/// Jobs: units of work that any thread or worker can do.
#[cfg_attr(
    all(target_arch = "wasm32", not(feature = "wasm")),
    allow(dead_code, reason = "without threads or an interface no jobs are handed out")
)]
mod jobs {
    mod job;
    #[cfg(any(feature = "wasm", test))]
    mod wire;

    pub(crate) use job::{DescribedSuperpixels, Job, JobId, JobInput, JobKind, JobResult, PendingJobs};
    pub(crate) use job::{FlowFrame, ForwardFlow, PairFlow};
}

/// What runs: the states of a session, and the work of each stage.
mod run {
    mod alternatives;
    mod clip;
    mod cut;
    mod dense;
    mod foreground;
    mod motion;
    mod recut;
    mod session;
    mod spectral;
    mod state;

    pub(crate) use clip::{Clip, Trackers};
    pub(crate) use dense::{estimate_camera, model_background};
    pub(crate) use recut::{TargetLabels, objects_from_labels};
    pub(crate) use session::Phase;
    pub use session::Session;
    pub(crate) use state::{Run, State};
}

/// Execution of sessions: on threads and workers, window by window, and resumed in another process.
mod drive {
    mod advance;
    #[cfg(not(target_arch = "wasm32"))]
    mod checkpoint;
    #[cfg(any(not(target_arch = "wasm32"), feature = "wasm"))]
    mod threads;
    #[cfg(not(target_arch = "wasm32"))]
    mod windows;

    #[cfg(not(target_arch = "wasm32"))]
    pub use checkpoint::Checkpoint;
    #[cfg(not(target_arch = "wasm32"))]
    pub use windows::Windows;
}

/// The results of a session, explanations of them, and corrections.
mod read {
    mod corrections;
    pub mod explanation;
    mod results;
}

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
