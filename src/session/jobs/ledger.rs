//! What of the work on a clip is given away, and what has come back.

use super::piece::{Made, PieceId, PieceKind};
use std::ops::Range;

/// The pieces of the present window: those of each kind by number.
#[derive(Debug, Clone, Default)]
pub(crate) struct Ledger {
    epoch: u32,
    jobs: [Vec<Job>; PieceKind::ALL.len()],
}

#[derive(Debug, Clone, Default)]
enum Job {
    /// Nobody works on it.
    #[default]
    Free,
    /// It was given away.
    Out,
    Made(Made),
    /// It was used, or is made here.
    Over,
}

impl Ledger {
    /// No piece is given away. What was, under another `epoch`, will not be accepted.
    pub(crate) fn new(epoch: u32) -> Self {
        Self { epoch, ..Self::default() }
    }

    fn jobs(&mut self, kind: PieceKind, count: usize) -> &mut [Job] {
        let jobs = &mut self.jobs[kind as usize];
        jobs.resize_with(jobs.len().max(count), Job::default);
        jobs
    }

    /// The first free one of `range`, which is out from now on.
    pub(crate) fn take(&mut self, kind: PieceKind, mut range: Range<usize>) -> Option<PieceId> {
        let jobs = self.jobs(kind, range.end);
        let t = range.find(|&t| matches!(jobs[t], Job::Free))?;
        jobs[t] = Job::Out;
        Some(PieceId { epoch: self.epoch, kind, t: t as u32 })
    }

    /// What became of one that is out, if anything did; others are left as they are.
    pub(crate) fn accept(&mut self, id: PieceId, made: Option<Made>) {
        let job = self.jobs[id.kind as usize].get_mut(id.t as usize).filter(|_| id.epoch == self.epoch);
        if let Some(job @ Job::Out) = job {
            *job = made.map_or(Job::Over, Job::Made);
        }
    }

    pub(crate) fn is_out(&self, kind: PieceKind, t: usize) -> bool {
        matches!(self.jobs[kind as usize].get(t), Some(Job::Out))
    }

    /// What became of it if it is back. Either way it is over.
    pub(crate) fn collect(&mut self, kind: PieceKind, t: usize) -> Option<Made> {
        match std::mem::replace(&mut self.jobs(kind, t + 1)[t], Job::Over) {
            Job::Made(made) => Some(made),
            _ => None,
        }
    }

    /// Forgets all of other kinds.
    #[cfg(not(target_arch = "wasm32"))] // For forks.
    pub(crate) fn keep_only(&mut self, kept: &[PieceKind]) {
        for kind in PieceKind::ALL.into_iter().filter(|kind| !kept.contains(kind)) {
            self.jobs[kind as usize].clear();
        }
    }
}
