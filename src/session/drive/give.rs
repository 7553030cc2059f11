//! What a session gives away of its work, and takes back.

use crate::session::jobs::{Made, Piece, PieceId, PieceKind, Work};
use crate::session::run::{Phase, Session};

impl Session {
    /// A piece of work that is coming and that nobody has; `None` where there is none at present. Flow is given away for
    /// at most `ahead` pairs from the one that is next, as what is made of a pair takes 20 bytes a pixel until then.
    pub(crate) fn take_piece(&mut self, ahead: usize) -> Option<Piece> {
        let epoch = self.epoch;
        let (clip, state) = match &mut self.phase {
            Phase::Frames(clip) => (clip, None),
            Phase::Begun(clip, state) => (clip, Some(state)),
            Phase::Empty => return None,
        };
        let pairs = clip.flows.len()..clip.frames.len().saturating_sub(1).min(clip.flows.len() + ahead);
        // What is waited for first is given away before what can wait.
        let (kind, t, work) = if let Some(t) = clip.ledger.take(PieceKind::Pair, pairs) {
            (PieceKind::Pair, t, Work::Pair(clip.frames[t].clone(), clip.frames[t + 1].clone()))
        } else if let Some(taken) = state.and_then(|state| state.take(clip)) {
            taken
        } else {
            let frames = 0..if clip.params.clip.dense { clip.frames.len() } else { 0 };
            let t = clip.ledger.take(PieceKind::Superpixels, frames)?;
            (PieceKind::Superpixels, t, Work::Superpixels(clip.frames[t].clone()))
        };
        Some(Piece { id: PieceId { epoch, kind, t: t as u32 }, work })
    }

    /// Takes what became of a piece. What nobody waits for any more, since the session was cleared or went on without
    /// it, is dropped.
    pub(crate) fn accept(&mut self, id: PieceId, made: Made) {
        self.settle(id, Some(made));
    }

    /// The piece will not come back: the session makes it itself.
    #[cfg(any(feature = "wasm", test))]
    pub(crate) fn release(&mut self, id: PieceId) {
        self.settle(id, None);
    }

    fn settle(&mut self, id: PieceId, made: Option<Made>) {
        match &mut self.phase {
            Phase::Frames(clip) | Phase::Begun(clip, _) if id.epoch == self.epoch => {
                clip.ledger.accept(id.kind, id.t, made);
            }
            _ => {}
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
}
