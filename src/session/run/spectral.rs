//! The stages of affinities (block by block), embedding and discontinuities.

use super::clip::Clip;
use super::state::{StageWork, StepReport};
use crate::Error;
use crate::affinity::AffinityRows;
use crate::camera::{ForwardMotion, PointMatches};
use crate::delaunay::delaunay_edges;
use crate::discontinuity::{alive_points, discontinuities, neighborhoods_from_edges};
use crate::embedding::embed;
use crate::session::base::{Outputs, Stage, TrackSet};
use crate::session::jobs::{Job, JobInput, JobKind, JobResult, PendingJobs};

/// Rows of the affinity matrix in one step; chosen by eye, for steps well below a second.
const AFFINITY_BLOCK: usize = 512;

/// The affinities so far.
#[derive(Debug, Clone)]
pub(crate) struct AffinityWork(AffinityRows);

impl AffinityWork {
    pub(crate) fn new(track_set: &TrackSet, clip: &Clip) -> Self {
        let params = &clip.params;
        Self(AffinityRows::new(track_set.with_past(), params.spacing(), &params.affinity, params.clip.seed))
    }

    /// Returns the number of the next block.
    fn block(&self) -> usize {
        self.0.num_done / AFFINITY_BLOCK
    }

    fn take_rows(&self, clip: &mut Clip, track_set: &TrackSet) -> Option<Job> {
        let tracks = track_set.with_past();
        clip.params.clip.check_trajectories(tracks.len()).ok()?;
        let id = clip.pending_jobs.assign(JobKind::Affinities, self.block()..tracks.len().div_ceil(AFFINITY_BLOCK))?;
        let rows = self.0.block(tracks, id.index as usize * AFFINITY_BLOCK, AFFINITY_BLOCK);
        Some(Job { id, input: JobInput::Affinities(Box::new(rows)) })
    }
}

impl StageWork for AffinityWork {
    /// Computes a block of rows.
    fn step(&mut self, clip: &mut Clip, outputs: &mut Outputs) -> Result<StepReport, Error> {
        let tracks = outputs.track_set.with_past();
        clip.params.clip.check_trajectories(tracks.len())?;
        let blocks = |rows: usize| rows.div_ceil(AFFINITY_BLOCK).max(1);
        let is_more = match clip.pending_jobs.take_result(JobKind::Affinities, self.block()) {
            Some(JobResult::Affinities(entries)) => self.0.accept(entries, AFFINITY_BLOCK),
            _ => self.0.advance(tracks, AFFINITY_BLOCK),
        };
        let report = StepReport::new(Stage::Affinities, blocks(self.0.num_done), blocks(tracks.len()));
        if !is_more {
            outputs.affinities = self.0.finish()?;
        }
        Ok(StepReport { is_last: !is_more, ..report })
    }

    fn take_job(&self, clip: &mut Clip, outputs: &Outputs) -> Option<Job> {
        self.take_rows(clip, &outputs.track_set).or_else(|| take_ahead(&outputs.track_set, clip))
    }

    fn is_waiting(&self, pending_jobs: &PendingJobs, _: &Outputs) -> bool {
        pending_jobs.is_pending(JobKind::Affinities, self.block())
    }
}

/// The embedding, in one step.
#[derive(Debug, Clone)]
pub(crate) struct EmbeddingWork;

impl StageWork for EmbeddingWork {
    fn step(&mut self, clip: &mut Clip, outputs: &mut Outputs) -> Result<StepReport, Error> {
        outputs.embedding = embed(&outputs.affinities, &clip.params.embedding, clip.params.clip.seed);
        Ok(StepReport::new(Stage::Embedding, 1, 1))
    }

    fn take_job(&self, clip: &mut Clip, outputs: &Outputs) -> Option<Job> {
        take_ahead(&outputs.track_set, clip)
    }
}

/// The discontinuities of the embedding, in one step.
#[derive(Debug, Clone)]
pub(crate) struct DiscontinuityWork;

impl StageWork for DiscontinuityWork {
    fn step(&mut self, clip: &mut Clip, outputs: &mut Outputs) -> Result<StepReport, Error> {
        let tracks = &outputs.track_set.tracks;
        let mut graph = |t: usize| match clip.pending_jobs.take_result(JobKind::Delaunay, t) {
            Some(JobResult::Delaunay(edges)) => edges,
            _ => delaunay_edges(&alive_points(tracks, t)),
        };
        let neighborhoods = neighborhoods_from_edges(tracks, &mut graph);
        outputs.discontinuities = discontinuities(neighborhoods, &outputs.embedding, &clip.params.discontinuity);
        Ok(StepReport::new(Stage::Discontinuities, 1, 1))
    }

    fn take_job(&self, clip: &mut Clip, outputs: &Outputs) -> Option<Job> {
        take_ahead(&outputs.track_set, clip)
    }

    fn is_waiting(&self, pending_jobs: &PendingJobs, outputs: &Outputs) -> bool {
        (0..outputs.track_set.tracks.num_frames).any(|t| pending_jobs.is_pending(JobKind::Delaunay, t))
    }
}

/// Hands out a job of a later stage that needs trajectories only: the Delaunay graph of a frame, or the camera's motion in
/// a frame pair.
fn take_ahead(track_set: &TrackSet, clip: &mut Clip) -> Option<Job> {
    let tracks = &track_set.tracks;
    if let Some(id) = clip.pending_jobs.assign(JobKind::Delaunay, 0..tracks.num_frames) {
        return Some(Job { id, input: JobInput::Delaunay(alive_points(tracks, id.index as usize)) });
    }
    let settings = &clip.params.background;
    let is_needed = clip.params.clip.dense && settings.enabled && settings.rigid_scene && !clip.frames.is_empty();
    let pairs = if is_needed { ForwardMotion::num_pairs(tracks) } else { 0 };
    let id = clip.pending_jobs.assign(JobKind::CameraMotion, 0..pairs)?;
    Some(Job { id, input: JobInput::CameraMotion(PointMatches::new(tracks, id.index as usize)) })
}
