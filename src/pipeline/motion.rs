//! The first two stages side by side: flow of one frame pair, then tracking through it.

use super::stage::{Progress, Stage};
use crate::flow::{CompactFlow, FlowField, FlowPyramid, FlowScratch, flow_between_with, local_flow_variation};
use crate::image::{Frame, Plane};
use crate::params::Params;
use crate::trajectory::{Tracker, structure};

/// What is known of the present pair of frames.
#[derive(Debug)]
enum Pair {
    Nothing,
    Forward(FlowField),
    Both(FlowField, FlowField),
}

/// Frames before a window that trajectories remember.
const REMEMBERED: usize = 100;

/// The trackers of a clip, both through the same frames.
#[derive(Debug, Clone)]
pub(super) struct Trackers {
    pub(super) tracks: Tracker,
    /// Follows the denser trajectories that the masks are made from.
    pub(super) masks: Option<Tracker>,
}

impl Trackers {
    /// For frames of `size` pixels; trajectories are numbered from `first` on.
    pub(super) fn new(first: u32, size: (usize, usize), params: &Params) -> Self {
        let masks = params.clip.dense.then(|| Tracker::new(size, &params.trajectory.for_masks()));
        Self { tracks: Tracker::numbering_from(first, size, &params.trajectory), masks }
    }

    fn each(&mut self) -> impl Iterator<Item = &mut Tracker> {
        std::iter::once(&mut self.tracks).chain(&mut self.masks)
    }

    /// Goes on to a window that begins `dropped` frames later. The past is for the affinities; masks are made without them.
    pub(super) fn advance(&mut self, dropped: usize) {
        self.tracks.advance(dropped, REMEMBERED);
        self.masks.iter_mut().for_each(|tracker| tracker.advance(dropped, 0));
    }
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
    trackers: Trackers,
}

impl Motion {
    /// For at least two frames of one size. With trackers that have seen the first `known` frames, at least one and not all of them,
    /// flow and tracking go on from there.
    pub(super) fn new(frames: &[Frame], trackers: Trackers, known: usize, params: &Params) -> Self {
        let t = known.saturating_sub(1);
        let (first, luma) = (frames[t].luma(), frames[t + 1].luma());
        let mut motion = Self {
            num_pairs: frames.len() - 1,
            t,
            from: FlowPyramid::new(&first, &params.flow),
            to: FlowPyramid::new(&luma, &params.flow),
            scratch: FlowScratch::default(),
            luma,
            pair: Pair::Nothing,
            trackers,
            params: params.clone(),
        };
        if known == 0 {
            motion.seed(&structure(&first));
        }
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
                self.trackers.each().for_each(|tracker| tracker.follow(&forward, &backward, &variation));
                let structure = structure(&self.luma);
                self.seed(&structure);
                flows.push(CompactFlow::new(&forward));
                self.next_pair(frames);
                Progress { stage: Stage::Trajectories, done: t + 1, total }
            }
        }
    }

    fn seed(&mut self, structure: &Plane<f32>) {
        self.trackers.each().for_each(|tracker| tracker.seed(structure));
    }

    fn next_pair(&mut self, frames: &[Frame]) {
        self.t += 1;
        if let Some(frame) = frames.get(self.t + 1) {
            self.luma = frame.luma();
            let next = FlowPyramid::new(&self.luma, &self.params.flow);
            self.from = std::mem::replace(&mut self.to, next);
        }
    }

    /// The trackers, at the last frame.
    pub(super) fn into_trackers(self) -> Trackers {
        self.trackers
    }
}
