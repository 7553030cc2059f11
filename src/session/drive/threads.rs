//! Pieces of work that a session gives away and takes back, and a run on several threads by them.

#[cfg(not(target_arch = "wasm32"))]
use crate::Error;
#[cfg(not(target_arch = "wasm32"))]
use crate::flow::FlowScratch;
#[cfg(not(target_arch = "wasm32"))]
use crate::session::base::{Progress, Step};
use crate::session::jobs::{Made, Piece, PieceId, PieceKind, Work};
use crate::session::run::{Phase, Session};
#[cfg(not(target_arch = "wasm32"))]
use std::sync::{Mutex, PoisonError, mpsc};

impl Session {
    /// A piece of work that is coming and that nobody has; `None` where there is none at present. Flow is given away for
    /// at most `ahead` pairs from the one that is next, as what is made of a pair takes 20 bytes a pixel until then.
    pub(crate) fn take_piece(&mut self, ahead: usize) -> Option<Piece> {
        let clip = self.phase.clip_mut()?;
        let pairs = clip.flows.len()..clip.frames.len().saturating_sub(1).min(clip.flows.len() + ahead);
        // What is waited for first is given away before what can wait.
        if let Some(id) = clip.ledger.take(PieceKind::Pair, pairs) {
            let t = id.t as usize;
            return Some(Piece { id, work: Work::Pair(clip.frames[t].clone(), clip.frames[t + 1].clone()) });
        }
        if let Phase::Begun(run) = &mut self.phase
            && let Some(piece) = run.take()
        {
            return Some(piece);
        }
        let clip = self.phase.clip_mut()?;
        let frames = 0..if clip.params.clip.dense { clip.frames.len() } else { 0 };
        let id = clip.ledger.take(PieceKind::Superpixels, frames)?;
        Some(Piece { id, work: Work::Superpixels(clip.frames[id.t as usize].clone()) })
    }

    /// Takes what became of a piece; `None` where it will not come back, so that the session makes it itself. What nobody
    /// waits for any more, since the session was cleared or went on without it, is dropped.
    pub(crate) fn accept(&mut self, id: PieceId, made: Option<Made>) {
        if let Some(clip) = self.phase.clip_mut() {
            clip.ledger.accept(id, made);
        }
    }

    /// Takes a piece and makes it at once; false where there is none.
    pub(crate) fn make_piece(&mut self, ahead: usize) -> bool {
        let Some(piece) = self.take_piece(ahead) else { return false };
        let Self { params, phase, .. } = self;
        let Some(clip) = phase.clip_mut() else { return false };
        let made = piece.work(params, &mut clip.scratch);
        clip.ledger.accept(piece.id, Some(made));
        true
    }

    /// Whether the next step needs a piece that is out. It can be taken all the same, and makes the piece itself.
    pub(crate) fn awaits(&self) -> bool {
        matches!(&self.phase, Phase::Begun(run) if run.awaits())
    }
}

/// Pieces that each helper has at a time: the one that it works on, and the next.
#[cfg(not(target_arch = "wasm32"))]
const IN_HAND: usize = 2;

#[cfg(not(target_arch = "wasm32"))]
impl Session {
    /// Steps until done on `threads` threads, this one included; `report` hears of each step. Results are the same bits
    /// for any number of threads.
    ///
    /// Pieces are made by all threads; what needs all of the clip is done by this one, while the others go on with the
    /// superpixels. Memory grows by about 200 bytes a pixel of a frame for each further thread.
    ///
    /// # Errors
    /// As [`Session::step`].
    pub fn run_on(&mut self, threads: usize, mut report: impl FnMut(Progress)) -> Result<(), Error> {
        let all = |progress| {
            report(progress);
            true
        };
        self.run_while(threads, all).map(|_done| ())
    }

    /// The same as long as `report` gives true; gives whether all is done. What is not goes on when it is called again,
    /// and ends in the same result.
    ///
    /// # Errors
    /// As [`Session::step`].
    #[doc(hidden)] // For the Python package, whose callbacks may raise.
    pub fn run_while(&mut self, threads: usize, mut report: impl FnMut(Progress) -> bool) -> Result<bool, Error> {
        let params = self.params().clone();
        let (give, work) = mpsc::channel::<Piece>();
        let (back, made) = mpsc::channel::<(PieceId, Made)>();
        let work = Mutex::new(work);
        std::thread::scope(|scope| {
            for _ in 1..threads {
                let (work, params, back) = (&work, &params, back.clone());
                scope.spawn(move || {
                    let mut scratch = FlowScratch::default();
                    loop {
                        // Held while waiting: the next in line waits for the lock instead.
                        let next = work.lock().unwrap_or_else(PoisonError::into_inner).recv();
                        let Ok(piece) = next else { break };
                        if back.send((piece.id, piece.work(params, &mut scratch))).is_err() {
                            break;
                        }
                    }
                });
            }
            let helpers = threads.saturating_sub(1);
            let (in_hand, ahead) = (IN_HAND * helpers, IN_HAND * helpers + 2);
            let mut out = 0;
            // Owned here, so that helpers stop when this ends, however it does; and nothing is waited for once all of them
            // have panicked, which the scope tells.
            let (give, made) = (give, made);
            drop(back);
            loop {
                while out < in_hand {
                    let Some(piece) = self.take_piece(ahead) else { break };
                    out += usize::from(give.send(piece).is_ok());
                }
                while let Ok((id, made)) = made.try_recv() {
                    out -= 1;
                    self.accept(id, Some(made));
                }
                if out > 0 && self.awaits() {
                    if self.make_piece(ahead) {
                        continue;
                    }
                    if let Ok((id, made)) = made.recv() {
                        out -= 1;
                        self.accept(id, Some(made));
                        continue;
                    }
                }
                match self.step()? {
                    Step::Working(progress) if report(progress) => {}
                    Step::Working(_) => return Ok(false),
                    Step::Done => return Ok(true),
                }
            }
        })
    }
}
