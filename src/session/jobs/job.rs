//! Jobs of a run that depend on little of it: any thread, worker or process can do them, in any order.
//!
//! A session hands out a [`Job`] and stores its result. A step uses the results that have arrived and computes the others
//! itself, so results do not depend on who does the work, and a lost job only costs time.

use crate::affinity::AffinityBlock;
use crate::background::{ReprojectionErrors, ReprojectionInput};
use crate::camera::{Egomotion, PointMatches};
use crate::cut::{Features, superpixel_features};
use crate::delaunay::delaunay_edges;
use crate::discretize::NormalizedRows;
use crate::flow::{
    CompactFlow, FlowField, FlowParams, FlowPyramid, FlowScratch, flow_between_with, local_flow_variation,
};
use crate::image::{Frame, Plane};
use crate::mask::refine;
use crate::saliency::SaliencyQuery;
use crate::session::base::Params;
use crate::superpixel::{Superpixels, frame_superpixels};
use crate::trajectory::structure;
use std::ops::Range;

/// Identifies a job of a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct JobId {
    /// The window of the session, counted over all of its clips.
    pub(crate) epoch: u32,
    pub(crate) kind: JobKind,
    /// The frame, the first frame of the pair, or the number of the block.
    pub(crate) index: u32,
}

/// The kind of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum JobKind {
    /// Flow of a frame pair.
    PairFlow = 0,
    Superpixels = 1,
    /// A refined mask.
    Mask = 2,
    /// Saliency of the trajectory points in a frame.
    Saliency = 3,
    /// Delaunay graph of the trajectories in a frame.
    Delaunay = 4,
    /// A block of rows of the affinity matrix.
    Affinities = 5,
    /// Egomotion motion of the camera in a frame pair.
    CameraMotion = 6,
    /// Clusters from a number of eigenvectors.
    Rotation = 7,
    /// Reprojection errors of the pixels of a frame.
    Reprojection = 8,
}

impl JobKind {
    pub(crate) const ALL: [Self; 9] = [
        Self::PairFlow,
        Self::Superpixels,
        Self::Mask,
        Self::Saliency,
        Self::Delaunay,
        Self::Affinities,
        Self::CameraMotion,
        Self::Rotation,
        Self::Reprojection,
    ];
}

/// A job with everything it needs, owned.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Job {
    pub(crate) id: JobId,
    pub(crate) input: JobInput,
}

/// The input of a job of each kind.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum JobInput {
    PairFlow(Frame, Frame),
    Superpixels(Frame),
    /// A frame and its mask, whose borders are to be refined.
    Mask(Frame, Plane<u8>),
    Saliency(SaliencyQuery),
    Delaunay(Vec<(f32, f32)>),
    Affinities(Box<AffinityBlock>),
    CameraMotion(PointMatches),
    Rotation(NormalizedRows),
    Reprojection(ReprojectionInput),
}

/// The result of a job of each kind.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum JobResult {
    PairFlow(Box<PairFlow>),
    Superpixels(DescribedSuperpixels),
    Mask(Plane<u8>),
    Saliency(Vec<f32>),
    Delaunay(Vec<(u32, u32)>),
    Affinities(Vec<(u32, u32, f32)>),
    /// The motion, and whether it is reliable.
    CameraMotion(Option<(Egomotion, bool)>),
    Rotation(Vec<u32>),
    Reprojection(ReprojectionErrors),
}

/// The superpixels of a frame, and the features of each.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct DescribedSuperpixels {
    pub(crate) superpixels: Superpixels,
    pub(crate) features: Vec<Features>,
}

impl DescribedSuperpixels {
    /// Computes the superpixels of a frame.
    pub(crate) fn new(frame: &Frame, params: &Params) -> Self {
        let superpixels = frame_superpixels(frame, &params.contour, &params.superpixel);
        Self { features: superpixel_features(frame, &superpixels), superpixels }
    }
}

impl Job {
    /// Runs the job with the parameters of the session that handed it out.
    pub(crate) fn run(&self, params: &Params, scratch: &mut FlowScratch) -> JobResult {
        match &self.input {
            JobInput::PairFlow(from, to) => {
                JobResult::PairFlow(Box::new(PairFlow::new(from, to, &params.for_flow(), scratch)))
            }
            JobInput::Superpixels(frame) => JobResult::Superpixels(DescribedSuperpixels::new(frame, params)),
            JobInput::Mask(frame, labels) => {
                JobResult::Mask(refine(labels, frame, &params.scaled_to((frame.width(), frame.height())).refine))
            }
            JobInput::Saliency(query) => JobResult::Saliency(query.evaluate(&params.saliency)),
            JobInput::Delaunay(points) => JobResult::Delaunay(delaunay_edges(points)),
            JobInput::Affinities(rows) => JobResult::Affinities(rows.entries()),
            JobInput::CameraMotion(matches) => JobResult::CameraMotion(matches.estimate_egomotion()),
            JobInput::Rotation(rows) => JobResult::Rotation(rows.rotate()),
            JobInput::Reprojection(input) => JobResult::Reprojection(input.errors()),
        }
    }
}

/// Flow of one frame pair in both directions, with what tracking needs; it depends on the two frames alone.
///
/// Flow has the size of the frames; the other planes have half of it, rounded up.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PairFlow {
    pub(crate) forward: FlowField,
    /// Only checks the forward field.
    pub(crate) backward: CompactFlow,
    pub(crate) variation: Plane<f32>,
    /// The structure of the second frame.
    pub(crate) structure: Plane<f32>,
}

impl PairFlow {
    /// Computes the flow between two frames of one size.
    pub(super) fn new(from: &Frame, to: &Frame, params: &FlowParams, scratch: &mut FlowScratch) -> Self {
        let [from, to] = [from, to].map(|frame| FlowFrame::new(frame, params));
        ForwardFlow::new(from, to, params, scratch).finish(params, scratch).0
    }
}

/// A frame prepared for optical flow.
#[derive(Debug, Clone)]
pub(crate) struct FlowFrame {
    luma: Plane<f32>,
    pyramid: FlowPyramid,
}

impl FlowFrame {
    pub(crate) fn new(frame: &Frame, params: &FlowParams) -> Self {
        Self { pyramid: FlowPyramid::reduced(frame, params.max_side), luma: frame.luma() }
    }

    /// Computes the flow to another frame, at the size of the frames.
    fn flow_to(&self, to: &Self, params: &FlowParams, scratch: &mut FlowScratch) -> FlowField {
        flow_between_with(&self.pyramid, &to.pyramid, params, scratch).at_size(self.luma.width(), self.luma.height())
    }
}

/// A frame pair with its forward flow: half of the work on a [`PairFlow`].
#[derive(Debug, Clone)]
pub(crate) struct ForwardFlow {
    from: FlowFrame,
    to: FlowFrame,
    flow: FlowField,
}

impl ForwardFlow {
    pub(crate) fn new(from: FlowFrame, to: FlowFrame, params: &FlowParams, scratch: &mut FlowScratch) -> Self {
        let flow = from.flow_to(&to, params, scratch);
        Self { from, to, flow }
    }

    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn field(&self) -> &FlowField {
        &self.flow
    }

    /// Computes the backward flow. Also returns the second frame, which is the first of the next pair.
    pub(crate) fn finish(self, params: &FlowParams, scratch: &mut FlowScratch) -> (PairFlow, FlowFrame) {
        let Self { from, to, flow: forward } = self;
        let backward = CompactFlow::new(&to.flow_to(&from, params, scratch));
        let variation = local_flow_variation(&forward);
        (PairFlow { forward, backward, variation, structure: structure(&to.luma) }, to)
    }
}

/// The states of the jobs of the present window, by kind and index.
#[derive(Debug, Clone, Default)]
pub(crate) struct PendingJobs {
    epoch: u32,
    states: [Vec<JobState>; JobKind::ALL.len()],
}

#[derive(Debug, Clone, Default)]
enum JobState {
    #[default]
    Unassigned,
    /// A worker has it.
    Pending,
    Finished(JobResult),
    /// The result was used, or the session computes it itself.
    Closed,
}

impl PendingJobs {
    /// Creates a list without assigned jobs. Results of jobs from another `epoch` will be ignored.
    pub(crate) fn new(epoch: u32) -> Self {
        Self { epoch, ..Self::default() }
    }

    fn states(&mut self, kind: JobKind, count: usize) -> &mut [JobState] {
        let states = &mut self.states[kind as usize];
        states.resize_with(states.len().max(count), JobState::default);
        states
    }

    /// Assigns the first unassigned job of a range.
    pub(crate) fn assign(&mut self, kind: JobKind, mut range: Range<usize>) -> Option<JobId> {
        let states = self.states(kind, range.end);
        let index = range.find(|&index| matches!(states[index], JobState::Unassigned))?;
        states[index] = JobState::Pending;
        Some(JobId { epoch: self.epoch, kind, index: index as u32 })
    }

    /// Stores the result of a pending job (`None` if it was lost). Results of jobs that are not pending are ignored.
    pub(crate) fn store_result(&mut self, id: JobId, result: Option<JobResult>) {
        let state = self.states[id.kind as usize].get_mut(id.index as usize).filter(|_| id.epoch == self.epoch);
        if let Some(state @ JobState::Pending) = state {
            *state = result.map_or(JobState::Closed, JobState::Finished);
        }
    }

    pub(crate) fn is_pending(&self, kind: JobKind, index: usize) -> bool {
        matches!(self.states[kind as usize].get(index), Some(JobState::Pending))
    }

    /// Returns the worker's result if it arrived, and closes the job.
    pub(crate) fn take_result(&mut self, kind: JobKind, index: usize) -> Option<JobResult> {
        match std::mem::replace(&mut self.states(kind, index + 1)[index], JobState::Closed) {
            JobState::Finished(result) => Some(result),
            _ => None,
        }
    }

    /// Lets the jobs of these kinds be assigned again; none of them may be pending.
    pub(crate) fn forget(&mut self, kinds: &[JobKind]) {
        kinds.iter().for_each(|&kind| self.states[kind as usize].clear());
    }
}
