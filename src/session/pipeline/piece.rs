//! Pieces of a run that depend on a frame or two alone: any thread, worker or process can work on them, in any order.
//!
//! A session gives a [`Piece`] away by [`Session::take_piece`] and takes what became of it by [`Session::accept`]. Its
//! steps use what is there; what is not back yet they make themselves, so nothing depends on who does the work, and a
//! piece that never comes back is only late.

use super::clip::Clip;
use super::ledger::Ledger;
use super::pair::PairFlow;
use super::params::Params;
use super::session::{Phase, Session};
use crate::flow::FlowScratch;
use crate::image::{Frame, Plane};
use crate::mask::refine;
use crate::superpixel::{Superpixels, frame_superpixels};

/// Which piece of which run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PieceId {
    /// The window that the session was at.
    pub(super) epoch: u32,
    pub(super) kind: PieceKind,
    /// Frame, or first frame of the pair.
    pub(super) t: u32,
}

/// What is to be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PieceKind {
    Pair = 0,
    Superpixels = 1,
    Mask = 2,
}

/// A piece of work: what it needs, owned.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Piece {
    pub(super) id: PieceId,
    pub(super) work: Work,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Work {
    Pair(Frame, Frame),
    Superpixels(Frame),
    /// Borders of these labels are to be refined.
    Mask(Frame, Plane<u8>),
}

/// What became of a piece.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Made {
    Pair(Box<PairFlow>),
    Superpixels(Superpixels),
    Mask(Plane<u8>),
}

impl Piece {
    pub(crate) fn id(&self) -> PieceId {
        self.id
    }

    /// Does the work, under the parameters of the session that gave it away.
    pub(crate) fn work(&self, params: &Params, scratch: &mut FlowScratch) -> Made {
        match &self.work {
            Work::Pair(from, to) => Made::Pair(Box::new(PairFlow::new(from, to, &params.flow, scratch))),
            Work::Superpixels(frame) => {
                Made::Superpixels(frame_superpixels(frame, &params.contour, &params.superpixel))
            }
            Work::Mask(frame, labels) => {
                Made::Mask(refine(labels, frame, &params.for_size((frame.width(), frame.height())).refine))
            }
        }
    }
}

impl Session {
    /// A piece of work that is coming and that nobody has; `None` where there is none at present. Flow is given away for
    /// at most `ahead` pairs from the one that is next, as what is made of a pair takes 20 bytes a pixel until then.
    pub(crate) fn take_piece(&mut self, ahead: usize) -> Option<Piece> {
        let epoch = self.epoch;
        let piece = |kind, t: usize, work| Piece { id: PieceId { epoch, kind, t: t as u32 }, work };
        let (clip, labels) = match &mut self.phase {
            Phase::Frames(clip) => (clip, None),
            Phase::Begun(clip, state) => (clip, Some(state)),
            Phase::Empty => return None,
        };
        let Clip { ledger, frames, flows, params, .. } = clip.as_mut();
        let pairs = flows.len()..frames.len().saturating_sub(1).min(flows.len() + ahead);
        if let Some(t) = ledger.pairs.take(pairs) {
            return Some(piece(PieceKind::Pair, t, Work::Pair(frames[t].clone(), frames[t + 1].clone())));
        }
        let is_dense = params.clip.dense;
        if let Some(t) = ledger.superpixels.take(0..if is_dense { frames.len() } else { 0 }) {
            return Some(piece(PieceKind::Superpixels, t, Work::Superpixels(frames[t].clone())));
        }
        let masking = labels.and_then(|state| state.masking())?;
        let t = ledger.masks.take(masking.made()..frames.len())?;
        Some(piece(PieceKind::Mask, t, Work::Mask(frames[t].clone(), masking.labels(t))))
    }

    /// Takes what became of a piece. What nobody waits for any more, since the session was cleared or went on without
    /// it, is dropped.
    pub(crate) fn accept(&mut self, id: PieceId, made: Made) {
        let Some(ledger) = self.ledger(id) else { return };
        match made {
            Made::Pair(made) => ledger.pairs.accept(id.t, Some(made)),
            Made::Superpixels(made) => ledger.superpixels.accept(id.t, Some(made)),
            Made::Mask(made) => ledger.masks.accept(id.t, Some(made)),
        }
    }

    /// The piece will not come back: the session makes it itself.
    #[cfg(any(feature = "wasm", test))]
    pub(crate) fn release(&mut self, id: PieceId) {
        let Some(ledger) = self.ledger(id) else { return };
        match id.kind {
            PieceKind::Pair => ledger.pairs.accept(id.t, None),
            PieceKind::Superpixels => ledger.superpixels.accept(id.t, None),
            PieceKind::Mask => ledger.masks.accept(id.t, None),
        }
    }

    /// Takes a piece and makes it at once; false where there is none.
    pub(crate) fn make_piece(&mut self, ahead: usize) -> bool {
        let Some(piece) = self.take_piece(ahead) else { return false };
        let made = match &mut self.phase {
            Phase::Frames(clip) | Phase::Begun(clip, _) => piece.work(&self.params, &mut clip.scratch),
            Phase::Empty => return false,
        };
        self.accept(piece.id, made);
        true
    }

    /// Whether the next step needs a piece that is out. It can be taken all the same, and makes the piece itself.
    pub(crate) fn awaits(&self) -> bool {
        match &self.phase {
            Phase::Begun(clip, state) => state.awaits(&clip.ledger),
            _ => false,
        }
    }

    fn ledger(&mut self, id: PieceId) -> Option<&mut Ledger> {
        match &mut self.phase {
            Phase::Frames(clip) | Phase::Begun(clip, _) if id.epoch == self.epoch => Some(&mut clip.ledger),
            _ => None,
        }
    }
}
