//! A run and its states: the order of the stages.

use super::alternatives::Alternatives;
use super::clip::Clip;
use super::cut::CutWork;
use super::dense::{MaskWork, SuperpixelWork};
use super::foreground::{ClusterWork, ConnectednessWork, SaliencyWork};
use super::motion::MotionWork;
use super::recut::{Recut, TargetLabels};
use super::spectral::{AffinityWork, DiscontinuityWork, EmbeddingWork};
use crate::Error;
use crate::session::base::{Outputs, Progress, Stage, Step, TrackSet};
use crate::session::jobs::{Job, PendingJobs};
use crate::trajectory::Trajectories;

/// A run that has begun.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    pub(crate) clip: Clip,
    pub(crate) outputs: Outputs,
    pub(crate) state: State,
    pub(crate) alternatives: Alternatives,
}

/// The present stage of a run with its unfinished work.
#[derive(Debug, Clone)]
pub(crate) enum State {
    /// Flow and tracking alternate.
    Motion(Box<MotionWork>),
    Affinities(Box<AffinityWork>),
    Embedding(EmbeddingWork),
    Discontinuities(DiscontinuityWork),
    Saliency(Box<SaliencyWork>),
    Connectedness(Box<ConnectednessWork>),
    Clusters(ClusterWork),
    Superpixels(SuperpixelWork),
    Cut(Box<CutWork>),
    Masks(Box<MaskWork>),
    Done,
}

/// Evaluates an expression with the work of a state.
macro_rules! with_work {
    ($state:expr, $work:ident => $then:expr, else $done:expr) => {
        match $state {
            State::Motion($work) => $then,
            State::Affinities($work) => $then,
            State::Embedding($work) => $then,
            State::Discontinuities($work) => $then,
            State::Saliency($work) => $then,
            State::Connectedness($work) => $then,
            State::Clusters($work) => $then,
            State::Superpixels($work) => $then,
            State::Cut($work) => $then,
            State::Masks($work) => $then,
            State::Done => $done,
        }
    };
}

impl State {
    /// Returns the state that follows once the work of this one is done.
    fn next(self, clip: &mut Clip, outputs: &mut Outputs, alternatives: &mut Alternatives) -> Self {
        match self {
            Self::Motion(work) => Self::with_tracks(work.finish(clip), clip, outputs),
            Self::Affinities(_) => Self::Embedding(EmbeddingWork),
            Self::Embedding(_) => Self::Discontinuities(DiscontinuityWork),
            Self::Discontinuities(_) => Self::Saliency(Box::new(SaliencyWork::new(&outputs.track_set, clip))),
            Self::Saliency(_) => Self::Connectedness(Box::default()),
            Self::Connectedness(_) => Self::Clusters(ClusterWork),
            Self::Clusters(_) if clip.params.clip.dense && !clip.frames.is_empty() => {
                let is_new = alternatives.note(&outputs.clusters);
                match alternatives.is_trying() {
                    false => Self::Superpixels(SuperpixelWork::new()),
                    true if is_new => Self::Cut(Box::new(CutWork::new(None))),
                    true => Self::clusters_or_masks(alternatives.next(outputs, clip)),
                }
            }
            Self::Superpixels(work) => Self::Cut(work.cut),
            Self::Cut(work) => match work.finish(outputs) {
                None => Self::clusters_or_masks(alternatives.judge(outputs, clip)),
                recut => Self::Masks(Box::new(MaskWork { recut })),
            },
            Self::Clusters(_) | Self::Masks(_) | Self::Done => Self::Done,
        }
    }

    fn clusters_or_masks(again: bool) -> Self {
        if again { Self::Clusters(ClusterWork) } else { Self::Masks(Box::new(MaskWork { recut: None })) }
    }

    fn with_tracks(track_set: TrackSet, clip: &Clip, outputs: &mut Outputs) -> Self {
        outputs.track_set = track_set;
        Self::Affinities(Box::new(AffinityWork::new(&outputs.track_set, clip)))
    }
}

impl Run {
    /// Starts a run of a valid clip ([`Clip::check`]).
    pub(super) fn new(mut clip: Clip) -> Self {
        let mut outputs = Outputs::default();
        let external = if clip.is_single_frame_shot() {
            Some(Box::new(TrackSet::external(Trajectories::empty(1, clip.scale.input), clip.scale)))
        } else {
            clip.external.take_if(|_| clip.frames.is_empty())
        };
        let state = match external {
            Some(track_set) => State::with_tracks(*track_set, &clip, &mut outputs),
            None => State::Motion(Box::new(MotionWork::new(&mut clip))),
        };
        Self { clip, outputs, state, alternatives: Alternatives::default() }
    }

    /// Takes one bounded step. Nothing changes on an error.
    pub(super) fn step(&mut self) -> Result<Step, Error> {
        let Self { clip, outputs, state, alternatives } = self;
        let report = with_work!(state, work => work.step(clip, outputs)?, else return Ok(Step::Done));
        let was_trying = alternatives.is_trying();
        if report.is_last {
            *state = std::mem::replace(state, State::Done).next(clip, outputs, alternatives);
        }
        Ok(Step::Working(alternatives.progress(report.progress, was_trying)))
    }

    /// Hands out an unassigned job of this stage, or of one that follows soon.
    pub(crate) fn take_job(&mut self) -> Option<Job> {
        with_work!(&self.state, work => work.take_job(&mut self.clip, &self.outputs), else None)
    }

    /// Returns whether the next step needs the result of a pending job.
    pub(crate) fn is_waiting(&self) -> bool {
        with_work!(&self.state, work => work.is_waiting(&self.clip.pending_jobs, &self.outputs), else false)
    }

    /// Returns whether a stage is finished and its outputs are complete.
    pub(crate) fn is_past(&self, stage: Stage) -> bool {
        let present = match &self.state {
            // The first clustering can be read while others are made.
            _ if self.alternatives.is_trying() => Stage::Cut,
            State::Motion(_) => Stage::Flow,
            State::Affinities(_) => Stage::Affinities,
            State::Embedding(_) => Stage::Embedding,
            State::Discontinuities(_) => Stage::Discontinuities,
            State::Saliency(_) => Stage::Saliency,
            State::Connectedness(_) => Stage::Connectedness,
            State::Clusters(_) => Stage::Clusters,
            State::Superpixels(_) => Stage::Superpixels,
            State::Cut(_) => Stage::Cut,
            State::Masks(_) => Stage::Masks,
            State::Done => return true,
        };
        present > stage
    }

    /// Returns to the cut after a correction.
    pub(crate) fn cut_again(&mut self, target: TargetLabels) {
        self.state = State::Cut(Box::new(CutWork::new(Some(Recut::new(&mut self.outputs, target)))));
    }

    /// Undoes the last correction, also while its masks are being made; false without a correction.
    pub(crate) fn undo_correction(&mut self) -> bool {
        let is_undone = self.outputs.pop_snapshot();
        if is_undone {
            self.state = State::Done;
        }
        is_undone
    }
}

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
