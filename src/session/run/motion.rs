//! The first two stages side by side: flow of one frame pair, then tracking through it.

use super::clip::{Clip, Trackers};
use super::work::{StageWork, Turn};
use crate::Error;
use crate::flow::CompactFlow;
use crate::image::{Plane, sample_bilinear};
use crate::session::base::{Outputs, Stage, Tracked};
use crate::session::jobs::{Forward, Ledger, Made, PairFlow, PieceKind, Seen};
use crate::trajectory::{Tracker, Trajectories, structure};

/// What is known of the present pair of frames.
#[derive(Debug, Clone, Default)]
enum Pair {
    #[default]
    Nothing,
    Forward(Box<Forward>),
    Both(Box<PairFlow>),
}

/// Flow and tracking of a clip, three steps a pair: forward flow, backward flow, tracking; of pairs that came from
/// elsewhere two. Holds the pyramids of two frames.
#[derive(Debug, Clone)]
pub(crate) struct MotionWork {
    /// Index of the present pair `(t, t + 1)`.
    t: usize,
    /// The second frame of the pair before, if its flow was made here.
    seen: Option<Seen>,
    pair: Pair,
    trackers: Trackers,
    /// Trajectories from outside, which take the place of those that are tracked.
    given: Option<Box<Tracked>>,
}

impl MotionWork {
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

    /// The trajectories at the last frame. The trackers stay with the clip, for the next window.
    pub(crate) fn finish(self, clip: &mut Clip) -> Tracked {
        let denser = self.trackers.masks.as_ref().map(|masks| masks.numbered().0);
        let tracked = match self.given {
            Some(given) => Tracked { denser, ..*given },
            None => {
                let (tracks, numbers) = self.trackers.tracks.numbered();
                let input = clip.scale.to_input(&tracks);
                Tracked { input, tracks, numbers, with_past: self.trackers.tracks.with_past(), denser }
            }
        };
        if let Some(windows) = &mut clip.windows {
            windows.trackers = Some(self.trackers);
        }
        clip.scratch = Default::default();
        tracked
    }
}

impl StageWork for MotionWork {
    /// One field, or the tracking through a pair of them; finished forward fields are added to those of the clip.
    fn step(&mut self, clip: &mut Clip, _: &mut Outputs) -> Result<Turn, Error> {
        let (t, pairs) = (self.t, clip.frames.len() - 1);
        let flow = |done| Turn { is_last: false, ..Turn::new(Stage::Flow, 2 * t + done, 2 * pairs) };
        let settings = &clip.params.for_flow();
        Ok(match std::mem::take(&mut self.pair) {
            Pair::Nothing => {
                if let Some(Made::Pair(made)) = clip.ledger.collect(PieceKind::Pair, t) {
                    (self.pair, self.seen) = (Pair::Both(made), None);
                    return Ok(flow(2));
                }
                let [from, to] = [t, t + 1].map(|t| &clip.frames[t]);
                let from = self.seen.take().unwrap_or_else(|| Seen::new(from, settings));
                let forward = Forward::new(from, Seen::new(to, settings), settings, &mut clip.scratch);
                self.pair = Pair::Forward(Box::new(forward));
                flow(1)
            }
            Pair::Forward(forward) => {
                let (made, seen) = forward.finish(settings, &mut clip.scratch);
                (self.pair, self.seen) = (Pair::Both(Box::new(made)), Some(seen));
                flow(2)
            }
            Pair::Both(made) => {
                self.trackers.follow(&made);
                if let Some(given) = &mut self.given {
                    set_variation(&mut given.tracks, t, &made.variation);
                }
                self.trackers.seed(&made.structure);
                clip.flows.push(CompactFlow::new(&made.forward));
                self.t += 1;
                Turn::new(Stage::Trajectories, t + 1, pairs)
            }
        })
    }

    fn awaits(&self, ledger: &Ledger, _: &Outputs) -> bool {
        matches!(self.pair, Pair::Nothing) && ledger.is_out(PieceKind::Pair, self.t)
    }
}

impl Clip {
    /// Trackers for the present window, and how many frames they have seen.
    fn trackers(&mut self) -> (Trackers, usize) {
        let fresh = |first| (Trackers::new(first, self.scale.working, &self.params), 0);
        match &mut self.windows {
            None => fresh(0),
            Some(windows) => match windows.trackers.take() {
                Some(trackers) => (trackers, windows.overlap),
                None => fresh(windows.first_number),
            },
        }
    }
}

impl Trackers {
    fn each(&mut self) -> impl Iterator<Item = &mut Tracker> {
        (!self.is_given).then_some(&mut self.tracks).into_iter().chain(&mut self.masks)
    }

    /// Starts tracks in the present frame, which has this structure.
    fn seed(&mut self, structure: &Plane<f32>) {
        self.each().for_each(|tracker| tracker.seed(structure));
    }

    /// Goes on to the next frame.
    fn follow(&mut self, flow: &PairFlow) {
        self.each().for_each(|tracker| tracker.follow(&flow.forward, &flow.backward, &flow.variation));
    }
}

/// Gives the points in frame `t` the local flow variation there, where it is not known; it is at half the working size.
/// Points in the last frame have that of the points before, as those of the tracker.
fn set_variation(tracks: &mut Trajectories, t: usize, variation: &Plane<f32>) {
    let is_last = t + 2 == tracks.num_frames;
    for i in 0..tracks.len() {
        let alive = tracks.frames(i);
        if alive.contains(&t) {
            let p = tracks.point(i, t);
            let Trajectories { x, y, variation: known, .. } = &mut *tracks;
            if known[p] == 0.0 {
                known[p] = sample_bilinear(variation, (x[p] - 0.5) * 0.5, (y[p] - 0.5) * 0.5);
            }
            if is_last && t + 1 < alive.end && known[p + 1] == 0.0 {
                known[p + 1] = known[p];
            }
        }
    }
}
