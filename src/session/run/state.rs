//! The state table: which work follows which.

use super::clip::Clip;
use super::dense::{Cutting, Dividing, Masking, Moving, Towards};
use super::foreground::{Averaging, Connected, Connecting, Looking, Mapping, Reembedding, Renewing};
use super::motion::Motion;
use super::recut::Wanted;
use super::spectral::{self, Linking};
use super::turn::Turn;
use crate::Error;
use crate::session::base::{Clustered, Embedded, Found, Linked, Parts, Placed, Segmented, Tracked};
use crate::session::base::{Stage, Step};
use crate::session::jobs::Ledger;
use crate::session::jobs::{PieceKind, Work};
use crate::trajectory::Trajectories;

/// What a begun run is at: each variant owns what is found so far, and the unfinished work of its stage.
#[derive(Debug, Clone)]
pub(crate) enum State {
    /// Flow and tracking take turns.
    Motion(Box<Motion>),
    Affinities(Box<Linking>),
    Embedding(Box<Linked>),
    Discontinuities(Box<Placed>),
    /// There is no flow to look at, and nothing will be salient.
    Unseen(Box<Embedded>),
    /// Saliency: flow is looked at, ...
    Looking(Box<Looking>),
    /// ... maps are made, ...
    Mapping(Box<Mapping>),
    /// ... and brought into the context of the embedding.
    Averaging(Box<Averaging>),
    Connectedness(Box<Connecting>),
    /// Where the foreground keeps trajectories apart: a second embedding, ...
    Reembedding(Box<Reembedding>),
    /// ... and its discontinuities.
    Renewing(Box<Renewing>),
    Clusters(Box<Connected>),
    /// Done, without masks.
    Clustered(Box<Clustered>),
    Superpixels(Box<Dividing>),
    /// The cut: its energy, ...
    Energy(Box<Cutting>),
    /// ... and its moves.
    Moves(Box<Moving>),
    Masks(Box<Masking>),
    /// Done, with masks.
    Segmented(Box<Segmented>),
}

impl State {
    /// The first work on a clip that is as it should be ([`Clip::check`]).
    pub(crate) fn first(clip: &mut Clip) -> Self {
        if clip.is_lone_frame() {
            return Self::of_tracks(Tracked::given(Trajectories::empty(1, clip.scale.input), clip.scale), clip);
        }
        match clip.given.take_if(|_| clip.frames.is_empty()) {
            Some(given) => Self::of_tracks(*given, clip),
            None => Self::Motion(Box::new(Motion::new(clip))),
        }
    }

    /// The first work on trajectories.
    fn of_tracks(tracked: Tracked, clip: &Clip) -> Self {
        Self::Affinities(Box::new(Linking::new(tracked, clip)))
    }

    /// Takes one bounded step. This is where it is said which state follows which. After an error it is as it was.
    pub(crate) fn next(self, clip: &mut Clip) -> (Result<Step, Error>, Self) {
        let (progress, next) = match self {
            Self::Motion(work) => work.step(clip).then(Self::Motion, |tracked| Self::of_tracks(tracked, clip)),
            Self::Affinities(work) => match work.step(clip) {
                Ok(turn) => turn.then(Self::Affinities, Self::Embedding),
                Err((work, error)) => return (Err(error), Self::Affinities(work)),
            },
            Self::Embedding(work) => work.step(clip).then(Self::Embedding, Self::Discontinuities),
            Self::Discontinuities(work) => {
                work.step(clip).then(Self::Discontinuities, |embedded| Self::saliency(embedded, clip))
            }
            Self::Unseen(embedded) => Turn::whole(Stage::Saliency, embedded).then(Self::Unseen, |embedded| {
                Self::Connectedness(Box::new(Connecting { embedded: *embedded, salient: None }))
            }),
            Self::Looking(work) => work.step(clip).then(Self::Looking, Self::Mapping),
            Self::Mapping(work) => work.step(clip).then(Self::Mapping, Self::Averaging),
            Self::Averaging(work) => work.step(clip).then(Self::Averaging, Self::Connectedness),
            Self::Connectedness(work) => work.step(clip).then(Self::Reembedding, Self::Clusters),
            Self::Reembedding(work) => work.step(clip).then(Self::Reembedding, Self::Renewing),
            Self::Renewing(work) => work.step(clip).then(Self::Renewing, Self::Clusters),
            Self::Clusters(work) => work.step(clip).then(Self::Clusters, |clustered| Self::masks(clustered, clip)),
            Self::Superpixels(work) => work.step(clip).then(Self::Superpixels, Self::Energy),
            Self::Energy(work) => {
                let towards = |towards| match towards {
                    Towards::Energy(work) => Self::Energy(work),
                    Towards::Moves(work) => Self::Moves(work),
                };
                work.step(clip).then(towards, Self::Masks)
            }
            Self::Moves(work) => work.step(clip).then(Self::Moves, Self::Masks),
            Self::Masks(work) => work.step(clip).then(Self::Masks, Self::Segmented),
            done @ (Self::Clustered(_) | Self::Segmented(_)) => return (Ok(Step::Done), done),
        };
        (Ok(Step::Working(progress)), next)
    }

    /// Saliency is seen in flow.
    fn saliency(embedded: Box<Embedded>, clip: &Clip) -> Self {
        if clip.flows.is_empty() {
            return Self::Unseen(embedded);
        }
        Self::Looking(Box::new(Looking::new(*embedded, clip)))
    }

    /// Masks are made of frames, where they are asked for.
    fn masks(clustered: Box<Clustered>, clip: &Clip) -> Self {
        if !clip.params.clip.dense || clip.frames.is_empty() {
            return Self::Clustered(clustered);
        }
        Self::Superpixels(Box::new(Dividing::new(*clustered)))
    }

    /// Finished masks are cut anew where a correction asks for it.
    pub(crate) fn corrected(self, wanted: Wanted) -> Self {
        match self {
            Self::Segmented(found) => Self::Energy(Box::new(Cutting::again(*found, wanted))),
            other => other,
        }
    }

    /// All is as it was before the last correction, also while its masks are being made; without a correction it is as
    /// it was, with `false`.
    pub(crate) fn undone(mut self) -> (bool, Self) {
        let Some(before) = self.parts_mut().and_then(|parts| parts.corrections.before.pop()) else {
            return (false, self);
        };
        let parts = match self {
            Self::Energy(work) => work.parts,
            Self::Moves(work) => work.parts,
            Self::Masks(work) => work.parts,
            Self::Segmented(found) => found.parts,
            other => return (false, other),
        };
        (true, Self::Segmented(Box::new(before.restore(parts))))
    }

    fn parts_mut(&mut self) -> Option<&mut Parts> {
        match self {
            Self::Energy(work) => Some(&mut work.parts),
            Self::Moves(work) => Some(&mut work.parts),
            Self::Masks(work) => Some(&mut work.parts),
            Self::Segmented(found) => Some(&mut found.parts),
            _ => None,
        }
    }

    /// Whether the next step needs a piece that was given away.
    pub(crate) fn awaits(&self, ledger: &Ledger) -> bool {
        match self {
            Self::Motion(work) => work.awaits(ledger),
            Self::Affinities(work) => ledger.is_out(PieceKind::Affinities, work.block()),
            Self::Discontinuities(found) => found.awaits(ledger),
            Self::Mapping(work) => ledger.is_out(PieceKind::Saliency, work.mapped()),
            Self::Clusters(work) => work.awaits(ledger),
            Self::Superpixels(work) => ledger.is_out(PieceKind::Superpixels, work.made()),
            Self::Energy(work) => work.awaits(ledger),
            Self::Masks(work) => ledger.is_out(PieceKind::Mask, work.made()),
            _ => false,
        }
    }

    /// A piece of what is at hand, or soon will be, that nobody has yet: its kind, its number and what it is made from.
    pub(crate) fn take(&self, clip: &mut Clip) -> Option<(PieceKind, usize, Work)> {
        match self {
            Self::Affinities(work) => work.take(clip).or_else(|| spectral::take_ahead(&work.tracked, clip)),
            Self::Embedding(found) => spectral::take_ahead(&found.tracked, clip),
            Self::Discontinuities(found) => spectral::take_ahead(&found.linked.tracked, clip),
            Self::Mapping(work) => work.take(clip),
            Self::Clusters(work) => work.take(clip),
            Self::Energy(work) => work.take(clip),
            Self::Masks(work) => work.take(clip),
            _ => None,
        }
    }

    pub(crate) fn is_done(&self) -> bool {
        matches!(self, Self::Clustered(_) | Self::Segmented(_))
    }

    /// What is found so far.
    pub(crate) fn found(&self) -> Found<'_> {
        match self {
            Self::Motion(_) => Found::default(),
            Self::Affinities(work) => work.found(),
            Self::Embedding(found) => found.found(),
            Self::Discontinuities(found) => found.found(),
            Self::Unseen(found) => found.found(),
            Self::Looking(work) => work.found(),
            Self::Mapping(work) => work.found(),
            Self::Averaging(work) => work.found(),
            Self::Connectedness(work) => work.found(),
            Self::Reembedding(work) => work.found(),
            Self::Renewing(work) => work.found(),
            Self::Clusters(work) => work.found(),
            Self::Clustered(found) => found.found(),
            Self::Superpixels(work) => work.found(),
            Self::Energy(work) => work.found(),
            Self::Moves(work) => work.found(),
            Self::Masks(work) => work.found(),
            Self::Segmented(found) => found.found(),
        }
    }
}
