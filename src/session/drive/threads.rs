//! A run on several threads.

use crate::Error;
use crate::flow::FlowScratch;
use crate::session::base::{Progress, Step};
use crate::session::jobs::{Made, Piece, PieceId};
use crate::session::run::Session;
use std::sync::{Mutex, PoisonError, mpsc};

/// Pieces that each helper has at a time: the one that it works on, and the next.
const IN_HAND: usize = 2;

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
                        if back.send((piece.id(), piece.work(params, &mut scratch))).is_err() {
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
                    self.accept(id, made);
                }
                if out > 0 && self.awaits() {
                    if self.make_piece(ahead) {
                        continue;
                    }
                    if let Ok((id, made)) = made.recv() {
                        out -= 1;
                        self.accept(id, made);
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
