//! The first two stages side by side: flow of one frame pair, then tracking through it.

use super::clip::Clip;
use super::trackers::Trackers;
use super::turn::Turn;
use crate::flow::CompactFlow;
use crate::session::base::Tracked;
use crate::session::base::{Progress, Stage};
use crate::session::jobs::Ledger;
use crate::session::jobs::{Forward, PairFlow, Seen};
use crate::session::jobs::{Made, PieceKind};
use crate::trajectory::structure;

/// What is known of the present pair of frames.
#[derive(Debug, Clone)]
enum Pair {
    Nothing,
    Forward(Box<Forward>),
    Both(Box<PairFlow>),
}

/// Flow and tracking of a clip, three steps a pair: forward flow, backward flow, tracking; of pairs that came from
/// elsewhere two. Holds the pyramids of two frames.
#[derive(Debug, Clone)]
pub(crate) struct Motion {
    /// Index of the present pair `(t, t + 1)`.
    t: usize,
    /// The second frame of the pair before, if its flow was made here.
    seen: Option<Seen>,
    pair: Pair,
    trackers: Trackers,
    /// Trajectories from outside, which take the place of those that are tracked.
    given: Option<Box<Tracked>>,
}

impl Motion {
    /// For at least two frames of one size. With trackers that have seen some of the frames, at least one and not all
    /// of them, flow and tracking go on from there.
    pub(crate) fn new(clip: &mut Clip) -> Self {
        let (mut trackers, known) = clip.trackers();
        let given = clip.given.take();
        trackers.is_given = given.is_some();
        if known == 0 {
            trackers.seed(&structure(&clip.frames[0].luma()));
        }
        let t = known.saturating_sub(1);
        Self { t, seen: None, pair: Pair::Nothing, trackers, given }
    }

    /// One field, or the tracking through a pair of them; finished forward fields are added to those of the clip.
    pub(crate) fn step(mut self: Box<Self>, clip: &mut Clip) -> Turn<Box<Self>, Tracked> {
        let (t, pairs) = (self.t as u32, clip.frames.len() as u32 - 1);
        let flow = |done| Progress { stage: Stage::Flow, done: 2 * t + done, total: 2 * pairs };
        let settings = &clip.params.for_flow();
        match self.pair {
            Pair::Nothing => {
                if let Some(Made::Pair(made)) = clip.ledger.collect(PieceKind::Pair, self.t) {
                    (self.pair, self.seen) = (Pair::Both(made), None);
                    return Turn::more(flow(2), self);
                }
                let [from, to] = [self.t, self.t + 1].map(|t| &clip.frames[t]);
                let from = self.seen.take().unwrap_or_else(|| Seen::new(from, settings));
                let forward = Forward::new(from, Seen::new(to, settings), settings, &mut clip.scratch);
                self.pair = Pair::Forward(Box::new(forward));
                Turn::more(flow(1), self)
            }
            Pair::Forward(forward) => {
                let (made, seen) = forward.finish(settings, &mut clip.scratch);
                (self.pair, self.seen) = (Pair::Both(Box::new(made)), Some(seen));
                Turn::more(flow(2), self)
            }
            Pair::Both(made) => {
                self.pair = Pair::Nothing;
                self.trackers.follow(&made);
                if let Some(given) = &mut self.given {
                    given.learn(self.t, &made.variation);
                }
                self.trackers.seed(&made.structure);
                clip.flows.push(CompactFlow::new(&made.forward));
                self.t += 1;
                let progress = Progress { stage: Stage::Trajectories, done: t + 1, total: pairs };
                if t + 1 < pairs { Turn::more(progress, self) } else { Turn::done(progress, (*self).finish(clip)) }
            }
        }
    }

    /// Whether the next step needs a pair that was given away.
    pub(crate) fn awaits(&self, ledger: &Ledger) -> bool {
        matches!(self.pair, Pair::Nothing) && ledger.is_out(PieceKind::Pair, self.t)
    }

    /// The trajectories at the last frame.
    fn finish(self, clip: &mut Clip) -> Tracked {
        let denser = self.trackers.masks.as_ref().map(|masks| masks.numbered().0);
        let tracked = match self.given {
            Some(given) => Tracked { denser, ..*given },
            None => {
                let (tracks, numbers) = self.trackers.tracks.numbered();
                let input = clip.scale.to_input(&tracks);
                Tracked { input, tracks, numbers, with_past: self.trackers.tracks.with_past(), denser }
            }
        };
        clip.keep(self.trackers);
        clip.scratch = Default::default();
        tracked
    }
}
