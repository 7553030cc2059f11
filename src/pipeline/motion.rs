//! The first two stages side by side: flow of one frame pair, then tracking through it.

use super::stage::{Progress, Stage};
use crate::flow::{CompactFlow, FlowField, FlowPyramid, FlowScratch, flow_between_with, local_flow_variation};
use crate::image::{Frame, Plane};
use crate::params::Params;
use crate::trajectory::{Tracker, Trajectories, structure};

/// What is known of the present pair of frames.
#[derive(Debug)]
enum Pair {
    Nothing,
    Forward(FlowField),
    Both(FlowField, FlowField),
}

/// Flow and tracking of a clip, three steps a pair: forward flow, backward flow, tracking. Holds the pyramids of two frames.
#[derive(Debug)]
pub(super) struct Motion {
    params: Params,
    num_pairs: usize,
    /// Index of the present pair `(t, t + 1)`.
    t: usize,
    from: FlowPyramid,
    to: FlowPyramid,
    scratch: FlowScratch,
    luma: Plane<f32>,
    pair: Pair,
    tracker: Tracker,
    /// Follows the denser trajectories that the masks are made from.
    mask_tracker: Option<Tracker>,
}

impl Motion {
    /// For at least two frames of one size.
    pub(super) fn new(frames: &[Frame], params: &Params) -> Self {
        let size = (frames[0].width(), frames[0].height());
        let (first, luma) = (frames[0].luma(), frames[1].luma());
        let mut motion = Self {
            num_pairs: frames.len() - 1,
            t: 0,
            from: FlowPyramid::new(&first, &params.flow),
            to: FlowPyramid::new(&luma, &params.flow),
            scratch: FlowScratch::default(),
            luma,
            pair: Pair::Nothing,
            tracker: Tracker::new(size, &params.trajectory),
            mask_tracker: params.clip.dense.then(|| Tracker::new(size, &params.trajectory.for_masks())),
            params: params.clone(),
        };
        motion.seed(&structure(&first));
        motion
    }

    pub(super) fn is_finished(&self) -> bool {
        self.t == self.num_pairs
    }

    /// One field, or the tracking through a pair of them; finished forward fields are added to `flows`.
    pub(super) fn step(&mut self, frames: &[Frame], flows: &mut Vec<CompactFlow>) -> Progress {
        let (t, total) = (self.t as u32, self.num_pairs as u32);
        match std::mem::replace(&mut self.pair, Pair::Nothing) {
            Pair::Nothing => {
                self.pair =
                    Pair::Forward(flow_between_with(&self.from, &self.to, &self.params.flow, &mut self.scratch));
                Progress { stage: Stage::Flow, done: 2 * t + 1, total: 2 * total }
            }
            Pair::Forward(forward) => {
                self.pair =
                    Pair::Both(forward, flow_between_with(&self.to, &self.from, &self.params.flow, &mut self.scratch));
                Progress { stage: Stage::Flow, done: 2 * t + 2, total: 2 * total }
            }
            Pair::Both(forward, backward) => {
                let variation = local_flow_variation(&forward);
                for tracker in std::iter::once(&mut self.tracker).chain(&mut self.mask_tracker) {
                    tracker.follow(&forward, &backward, &variation);
                }
                let structure = structure(&self.luma);
                self.seed(&structure);
                flows.push(CompactFlow::new(&forward));
                self.next_pair(frames);
                Progress { stage: Stage::Trajectories, done: t + 1, total }
            }
        }
    }

    fn seed(&mut self, structure: &Plane<f32>) {
        self.tracker.seed(structure);
        if let Some(tracker) = &mut self.mask_tracker {
            tracker.seed(structure);
        }
    }

    fn next_pair(&mut self, frames: &[Frame]) {
        self.t += 1;
        if let Some(frame) = frames.get(self.t + 1) {
            self.luma = frame.luma();
            let next = FlowPyramid::new(&self.luma, &self.params.flow);
            self.from = std::mem::replace(&mut self.to, next);
        }
    }

    /// The trajectories to cluster, and the denser ones that the masks are made from.
    pub(super) fn into_trajectories(self) -> (Trajectories, Option<Trajectories>) {
        (self.tracker.finish(), self.mask_tracker.map(Tracker::finish))
    }
}
