//! A run: which work follows which.

use super::clip::Clip;
use super::cut::CutWork;
use super::dense::{MaskWork, SuperpixelWork};
use super::foreground::{ClusterWork, ConnectednessWork, SaliencyWork};
use super::motion::MotionWork;
use super::recut::{Recut, Wanted};
use super::spectral::{AffinityWork, DiscontinuityWork, EmbeddingWork};
use super::work::StageWork;
use crate::Error;
use crate::session::base::{Outputs, Stage, Step, Tracked};
use crate::session::jobs::Piece;
use crate::trajectory::Trajectories;

/// A run that has begun.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    pub(crate) clip: Clip,
    pub(crate) outputs: Outputs,
    pub(crate) state: State,
}

/// The stage that a run is at, with the unfinished work of it.
#[derive(Debug, Clone)]
pub(crate) enum State {
    /// Flow and tracking take turns.
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

/// Calls something of the work of a state, whichever it is.
macro_rules! of_work {
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
    /// What follows once the work of this state is done.
    fn next(self, clip: &mut Clip, outputs: &mut Outputs) -> Self {
        match self {
            Self::Motion(work) => Self::with_tracks(work.finish(clip), clip, outputs),
            Self::Affinities(_) => Self::Embedding(EmbeddingWork),
            Self::Embedding(_) => Self::Discontinuities(DiscontinuityWork),
            Self::Discontinuities(_) => Self::Saliency(Box::new(SaliencyWork::new(&outputs.tracked, clip))),
            Self::Saliency(_) => Self::Connectedness(Box::default()),
            Self::Connectedness(_) => Self::Clusters(ClusterWork),
            // Masks are made of frames, where they are asked for.
            Self::Clusters(_) if clip.params.clip.dense && !clip.frames.is_empty() => Self::Superpixels(SuperpixelWork),
            Self::Superpixels(_) => Self::Cut(Box::new(CutWork::new(None))),
            Self::Cut(work) => Self::Masks(Box::new(MaskWork { recut: work.finish(outputs) })),
            Self::Clusters(_) | Self::Masks(_) | Self::Done => Self::Done,
        }
    }

    fn with_tracks(tracked: Tracked, clip: &Clip, outputs: &mut Outputs) -> Self {
        outputs.tracked = tracked;
        Self::Affinities(Box::new(AffinityWork::new(&outputs.tracked, clip)))
    }
}

impl Run {
    /// For a clip that is as it should be ([`Clip::check`]).
    pub(crate) fn new(mut clip: Clip) -> Self {
        let mut outputs = Outputs::default();
        let given = if clip.is_lone_frame() {
            Some(Box::new(Tracked::given(Trajectories::empty(1, clip.scale.input), clip.scale)))
        } else {
            clip.given.take_if(|_| clip.frames.is_empty())
        };
        let state = match given {
            Some(given) => State::with_tracks(*given, &clip, &mut outputs),
            None => State::Motion(Box::new(MotionWork::new(&mut clip))),
        };
        Self { clip, outputs, state }
    }

    /// Takes one bounded step. After an error all is as it was.
    pub(crate) fn step(&mut self) -> Result<Step, Error> {
        let Self { clip, outputs, state } = self;
        let turn = of_work!(state, work => work.step(clip, outputs)?, else return Ok(Step::Done));
        if turn.is_last {
            *state = std::mem::replace(state, State::Done).next(clip, outputs);
        }
        Ok(Step::Working(turn.progress))
    }

    /// A piece of what is at hand, or soon will be, that nobody has yet.
    pub(crate) fn take(&mut self) -> Option<Piece> {
        of_work!(&self.state, work => work.take(&mut self.clip, &self.outputs), else None)
    }

    /// Whether the next step needs a piece that was given away.
    pub(crate) fn awaits(&self) -> bool {
        of_work!(&self.state, work => work.awaits(&self.clip.ledger, &self.outputs), else false)
    }

    /// Whether a stage is over, so that all of its outputs are there.
    pub(crate) fn is_past(&self, stage: Stage) -> bool {
        let present = match &self.state {
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

    /// Goes back to the cut, where a correction asks for another one.
    pub(crate) fn cut_again(&mut self, wanted: Wanted) {
        self.state = State::Cut(Box::new(CutWork::new(Some(Recut::new(&mut self.outputs, wanted)))));
    }

    /// Restores what was before the last correction, also while its masks are being made; false without a correction.
    pub(crate) fn undo_correction(&mut self) -> bool {
        let is_undone = self.outputs.restore();
        if is_undone {
            self.state = State::Done;
        }
        is_undone
    }
}
