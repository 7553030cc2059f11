//! The first two stages side by side: flow of one frame pair, then tracking through it.

use super::clip::Clip;
use super::found::Tracked;
use super::stage::{Progress, Stage};
use super::trackers::{PairFlow, Trackers};
use super::turn::Turn;
use crate::flow::{CompactFlow, FlowField, FlowPyramid, FlowScratch, flow_between_with};
use crate::image::Plane;
use crate::trajectory::structure;

/// What is known of the present pair of frames.
#[derive(Debug)]
enum Pair {
    Nothing,
    Forward(FlowField),
    Both(FlowField, FlowField),
}

/// Flow and tracking of a clip, three steps a pair: forward flow, backward flow, tracking. Holds the pyramids of two
/// frames.
#[derive(Debug)]
pub(super) struct Motion {
    /// Index of the present pair `(t, t + 1)`.
    t: usize,
    from: FlowPyramid,
    to: FlowPyramid,
    scratch: FlowScratch,
    luma: Plane<f32>,
    pair: Pair,
    trackers: Trackers,
}

impl Motion {
    /// For at least two frames of one size. With trackers that have seen some of the frames, at least one and not all
    /// of them, flow and tracking go on from there.
    pub(super) fn new(clip: &mut Clip) -> Self {
        let (mut trackers, known) = clip.trackers();
        let t = known.saturating_sub(1);
        let (first, luma) = (clip.frames[t].luma(), clip.frames[t + 1].luma());
        let (from, to) = (FlowPyramid::new(&first, &clip.params.flow), FlowPyramid::new(&luma, &clip.params.flow));
        if known == 0 {
            trackers.seed(&structure(&first));
        }
        Self { t, from, to, scratch: FlowScratch::default(), luma, pair: Pair::Nothing, trackers }
    }

    /// One field, or the tracking through a pair of them; finished forward fields are added to those of the clip.
    pub(super) fn step(mut self: Box<Self>, clip: &mut Clip) -> Turn<Box<Self>, Tracked> {
        let (t, pairs) = (self.t as u32, clip.frames.len() as u32 - 1);
        let flow = |done| Progress { stage: Stage::Flow, done: 2 * t + done, total: 2 * pairs };
        let settings = &clip.params.flow;
        match self.pair {
            Pair::Nothing => {
                self.pair = Pair::Forward(flow_between_with(&self.from, &self.to, settings, &mut self.scratch));
                Turn::more(flow(1), self)
            }
            Pair::Forward(forward) => {
                self.pair = Pair::Both(forward, flow_between_with(&self.to, &self.from, settings, &mut self.scratch));
                Turn::more(flow(2), self)
            }
            Pair::Both(forward, backward) => {
                self.pair = Pair::Nothing;
                self.track(&PairFlow::new(forward, backward), clip);
                let progress = Progress { stage: Stage::Trajectories, done: t + 1, total: pairs };
                if t + 1 < pairs { Turn::more(progress, self) } else { Turn::done(progress, self.finish(clip)) }
            }
        }
    }

    fn track(&mut self, flow: &PairFlow, clip: &mut Clip) {
        self.trackers.follow(flow);
        self.trackers.seed(&structure(&self.luma));
        clip.flows.push(CompactFlow::new(&flow.forward));
        self.t += 1;
        if let Some(frame) = clip.frames.get(self.t + 1) {
            self.luma = frame.luma();
            let next = FlowPyramid::new(&self.luma, &clip.params.flow);
            self.from = std::mem::replace(&mut self.to, next);
        }
    }

    /// The trajectories at the last frame.
    fn finish(self: Box<Self>, clip: &mut Clip) -> Tracked {
        let (tracks, numbers) = self.trackers.tracks.numbered();
        let tracked = Tracked {
            input: clip.scale.to_input(&tracks),
            tracks,
            numbers,
            with_past: self.trackers.tracks.with_past(),
            denser: self.trackers.masks.as_ref().map(|masks| masks.numbered().0),
        };
        clip.keep(self.trackers);
        tracked
    }
}
