//! The stages of flow and tracking, which alternate: flow of a frame pair, then tracking through it.

use super::clip::{Clip, Trackers};
use super::state::{StageWork, StepReport};
use crate::Error;
use crate::flow::CompactFlow;
use crate::image::{Plane, sample_bilinear};
use crate::saliency::SaliencyMaps;
use crate::session::base::{Outputs, Stage, TrackSet};
use crate::session::jobs::{FlowFrame, ForwardFlow, JobKind, JobResult, PairFlow, PendingJobs};
use crate::trajectory::{Tracker, Trajectories, structure};

/// The flow of the present frame pair so far.
#[derive(Debug, Clone, Default)]
enum PairState {
    #[default]
    Empty,
    Forward(Box<ForwardFlow>),
    Complete(Box<PairFlow>),
}

/// Flow and tracking of a clip, three steps a pair: forward flow, backward flow, tracking; two steps if a worker computed
/// the flow. Holds the pyramids of two frames.
#[derive(Debug, Clone)]
pub(crate) struct MotionWork {
    /// Index of the present pair `(t, t + 1)`.
    t: usize,
    /// The second frame of the previous pair, if its flow was computed here.
    flow_frame: Option<FlowFrame>,
    pair: PairState,
    trackers: Trackers,
    /// The dominant motions of the pairs so far: they are found while other threads compute flow.
    maps: SaliencyMaps,
    /// Trajectories of another tracker, which replace our own.
    external: Option<Box<TrackSet>>,
}

impl MotionWork {
    /// Starts with at least two frames of one size. If the trackers have seen frames of the previous window, flow and
    /// tracking continue from there.
    pub(super) fn new(clip: &mut Clip) -> Self {
        let (mut trackers, num_tracked) = clip.trackers();
        let external = clip.external.take();
        trackers.has_external = external.is_some();
        if num_tracked == 0 {
            trackers.seed(&structure(&clip.frames[0].luma()));
        }
        let t = num_tracked.saturating_sub(1);
        Self { t, flow_frame: None, pair: PairState::Empty, trackers, maps: clip.dominant_motions(), external }
    }

    /// Returns the finished trajectories. The trackers stay with the clip, for the next window.
    pub(super) fn finish(self, clip: &mut Clip) -> TrackSet {
        let mask_tracks = self.trackers.masks.as_ref().map(|masks| masks.numbered().0);
        let track_set = match self.external {
            Some(external) => TrackSet { mask_tracks, ..*external },
            None => {
                let (tracks, numbers) = self.trackers.tracks.numbered();
                let input = clip.scale.to_input(&tracks);
                TrackSet { input, tracks, numbers, with_past: self.trackers.tracks.with_past(), mask_tracks }
            }
        };
        if let Some(windows) = &mut clip.windows {
            windows.trackers = Some(self.trackers);
        }
        clip.scratch = Default::default();
        clip.saliency_maps = Some(self.maps);
        track_set
    }
}

impl StageWork for MotionWork {
    /// Computes a flow field, or tracks through a pair of them and adds the forward one to the clip.
    fn step(&mut self, clip: &mut Clip, _: &mut Outputs) -> Result<StepReport, Error> {
        let (t, pairs) = (self.t, clip.frames.len() - 1);
        let flow = |done| StepReport { is_last: false, ..StepReport::new(Stage::Flow, 2 * t + done, 2 * pairs) };
        let settings = &clip.params.for_flow();
        Ok(match std::mem::take(&mut self.pair) {
            PairState::Empty => {
                if let Some(JobResult::PairFlow(pair)) = clip.pending_jobs.take_result(JobKind::PairFlow, t) {
                    (self.pair, self.flow_frame) = (PairState::Complete(pair), None);
                    return Ok(flow(2));
                }
                let [from, to] = [t, t + 1].map(|t| &clip.frames[t]);
                let from = self.flow_frame.take().unwrap_or_else(|| FlowFrame::new(from, settings));
                let forward = ForwardFlow::new(from, FlowFrame::new(to, settings), settings, &mut clip.scratch);
                self.pair = PairState::Forward(Box::new(forward));
                flow(1)
            }
            PairState::Forward(forward) => {
                let (pair, flow_frame) = forward.finish(settings, &mut clip.scratch);
                (self.pair, self.flow_frame) = (PairState::Complete(Box::new(pair)), Some(flow_frame));
                flow(2)
            }
            PairState::Complete(pair) => {
                self.trackers.follow(&pair);
                if let Some(external) = &mut self.external {
                    set_variation(&mut external.tracks, t, &pair.variation);
                }
                self.trackers.seed(&pair.structure);
                let flow = CompactFlow::new(&pair.forward);
                self.maps.add_field(&flow);
                clip.flows.push(flow);
                self.t += 1;
                StepReport::new(Stage::Trajectories, t + 1, pairs)
            }
        })
    }

    fn is_waiting(&self, pending_jobs: &PendingJobs, _: &Outputs) -> bool {
        matches!(self.pair, PairState::Empty) && pending_jobs.is_pending(JobKind::PairFlow, self.t)
    }
}

impl Clip {
    /// Returns the trackers for the present window and the number of its frames that they have seen.
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
        (!self.has_external).then_some(&mut self.tracks).into_iter().chain(&mut self.masks)
    }

    /// Starts tracks in the present frame.
    fn seed(&mut self, structure: &Plane<f32>) {
        self.each().for_each(|tracker| tracker.seed(structure));
    }

    /// Tracks into the next frame.
    fn follow(&mut self, flow: &PairFlow) {
        self.each().for_each(|tracker| tracker.follow(&flow.forward, &flow.backward, &flow.variation));
    }
}

/// Sets the local flow variation of the points in frame `t` that have none; `variation` is at half the working size. Points
/// in the last frame take the value of the frame before, as the tracker's do.
fn set_variation(tracks: &mut Trajectories, t: usize, variation: &Plane<f32>) {
    let is_last = t + 2 == tracks.num_frames;
    for i in 0..tracks.len() {
        let alive = tracks.frames(i);
        if alive.contains(&t) {
            let p = tracks.point(i, t);
            let Trajectories { x, y, variation: values, .. } = &mut *tracks;
            if values[p] == 0.0 {
                values[p] = sample_bilinear(variation, (x[p] - 0.5) * 0.5, (y[p] - 0.5) * 0.5);
            }
            if is_last && t + 1 < alive.end && values[p + 1] == 0.0 {
                values[p + 1] = values[p];
            }
        }
    }
}
