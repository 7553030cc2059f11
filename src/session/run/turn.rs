//! What a step of some work comes to.

use crate::session::base::{Progress, Stage};

/// The work with one step more done, or what it was for.
#[derive(Debug)]
pub(crate) struct Turn<W, O> {
    progress: Progress,
    outcome: Outcome<W, O>,
}

#[derive(Debug)]
enum Outcome<W, O> {
    More(W),
    Done(O),
}

impl<W, O> Turn<W, O> {
    /// Some of the work is left.
    pub(crate) fn more(progress: Progress, work: W) -> Self {
        Self { progress, outcome: Outcome::More(work) }
    }

    /// It is done.
    pub(crate) fn done(progress: Progress, output: O) -> Self {
        Self { progress, outcome: Outcome::Done(output) }
    }

    /// It took this one step, all that `stage` has.
    pub(crate) fn whole(stage: Stage, output: O) -> Self {
        Self::done(Progress { stage, done: 1, total: 1 }, output)
    }

    /// With what is left of the work as another.
    pub(crate) fn map<V>(self, of: impl FnOnce(W) -> V) -> Turn<V, O> {
        let outcome = match self.outcome {
            Outcome::More(work) => Outcome::More(of(work)),
            Outcome::Done(output) => Outcome::Done(output),
        };
        Turn { progress: self.progress, outcome }
    }

    /// How far it is, and what follows: `more` of the same, or `done`.
    pub(crate) fn then<S>(self, more: impl FnOnce(W) -> S, done: impl FnOnce(O) -> S) -> (Progress, S) {
        match self.outcome {
            Outcome::More(work) => (self.progress, more(work)),
            Outcome::Done(output) => (self.progress, done(output)),
        }
    }
}
