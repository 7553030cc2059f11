//! What a run asks of the work of a stage.

use super::clip::Clip;
use crate::Error;
use crate::session::base::{Outputs, Progress, Stage};
use crate::session::jobs::{Ledger, Piece};

/// A step that was taken.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Turn {
    pub(crate) progress: Progress,
    /// Whether it was the last one of the work.
    pub(crate) is_last: bool,
}

impl Turn {
    /// Step `done` of `total`, which is the last.
    pub(crate) fn new(stage: Stage, done: usize, total: usize) -> Self {
        Self { progress: Progress { stage, done: done as u32, total: total as u32 }, is_last: done == total }
    }
}

/// The work of a stage.
pub(crate) trait StageWork {
    /// Takes one bounded step, and extends the outputs.
    ///
    /// # Errors
    /// Those of the stage; all is as it was then.
    fn step(&mut self, clip: &mut Clip, outputs: &mut Outputs) -> Result<Turn, Error>;

    /// A piece of the work at hand, or of what comes soon, that nobody has yet.
    fn take(&self, _clip: &mut Clip, _outputs: &Outputs) -> Option<Piece> {
        None
    }

    /// Whether the next step needs a piece that was given away.
    fn awaits(&self, _ledger: &Ledger, _outputs: &Outputs) -> bool {
        false
    }
}
