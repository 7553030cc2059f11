//! The interface between a run and the work of a stage.

use super::clip::Clip;
use crate::Error;
use crate::session::base::{Outputs, Progress, Stage};
use crate::session::jobs::{Job, PendingJobs};

/// The report of one step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StepReport {
    pub(crate) progress: Progress,
    /// True if the work is finished.
    pub(crate) is_last: bool,
}

impl StepReport {
    /// Reports step `done` of `total`; the last one finishes the work.
    pub(crate) fn new(stage: Stage, done: usize, total: usize) -> Self {
        Self { progress: Progress { stage, done: done as u32, total: total as u32 }, is_last: done == total }
    }
}

/// The unfinished work of a stage.
pub(crate) trait StageWork {
    /// Takes one bounded step and extends the outputs.
    ///
    /// # Errors
    /// Those of the stage; nothing changes then.
    fn step(&mut self, clip: &mut Clip, outputs: &mut Outputs) -> Result<StepReport, Error>;

    /// Hands out an unassigned job of this work, or of work that follows soon.
    fn take_job(&self, _clip: &mut Clip, _outputs: &Outputs) -> Option<Job> {
        None
    }

    /// Returns whether the next step needs the result of a pending job.
    fn is_waiting(&self, _pending_jobs: &PendingJobs, _outputs: &Outputs) -> bool {
        false
    }
}
