//! What of the work on a clip is given away, and what has come back.

use super::pair::PairFlow;
use crate::image::Plane;
use crate::superpixel::Superpixels;

/// Pieces of one kind, by frame.
#[derive(Debug, Clone)]
pub(super) struct Jobs<T>(Vec<Job<T>>);

impl<T> Default for Jobs<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

#[derive(Debug, Clone, Default)]
enum Job<T> {
    /// Nobody works on it.
    #[default]
    Free,
    /// It was given away.
    Out,
    Made(T),
    /// It was used, or is made here.
    Over,
}

impl<T> Jobs<T> {
    /// The first free one of `range`, which is out from now on.
    pub(super) fn take(&mut self, mut range: std::ops::Range<usize>) -> Option<usize> {
        self.0.resize_with(self.0.len().max(range.end), Job::default);
        let t = range.find(|&t| matches!(self.0[t], Job::Free))?;
        self.0[t] = Job::Out;
        Some(t)
    }

    /// What became of one that is out, if anything did; others are left as they are.
    pub(super) fn accept(&mut self, t: u32, made: Option<T>) {
        if let Some(job @ Job::Out) = self.0.get_mut(t as usize) {
            *job = made.map_or(Job::Over, Job::Made);
        }
    }

    pub(super) fn is_out(&self, t: usize) -> bool {
        matches!(self.0.get(t), Some(Job::Out))
    }

    /// What became of it if it is back. Either way it is over.
    pub(super) fn collect(&mut self, t: usize) -> Option<T> {
        self.0.resize_with(self.0.len().max(t + 1), Job::default);
        match std::mem::replace(&mut self.0[t], Job::Over) {
            Job::Made(made) => Some(made),
            _ => None,
        }
    }
}

/// The pieces of the present window.
#[derive(Debug, Clone, Default)]
pub(super) struct Ledger {
    pub(super) pairs: Jobs<Box<PairFlow>>,
    pub(super) superpixels: Jobs<Superpixels>,
    pub(super) masks: Jobs<Plane<u8>>,
}
