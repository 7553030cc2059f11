//! The stages of saliency (frame by frame), of the foreground's connected components, and of the clusters.

use super::clip::Clip;
use super::state::{StageWork, StepReport};
use crate::Error;
use crate::connectedness::{ConnectednessMode, Separation, components, constrain};
use crate::discontinuity::discontinuities;
use crate::discretize::{NUM_ROTATIONS, NormalizedRows, discretize_with, rotation_counts, with_background};
use crate::embedding::{Embedding, embed};
use crate::flow::Field;
use crate::saliency::{SaliencyMaps, SaliencyQuery, context_saliency, greatest_of_points, point_pixels};
use crate::session::base::{Outputs, SaliencyOutputs, Stage, TrackSet};
use crate::session::jobs::{Job, JobInput, JobKind, JobResult, PendingJobs};
use crate::sparse::SymCsr;
use crate::trajectory::Trajectories;

/// Saliency: a map of each flow field, and the average over the embedding.
#[derive(Debug, Clone)]
pub(crate) struct SaliencyWork {
    step: SaliencyStep,
    maps: SaliencyMaps,
    /// The saliency of each point of the trajectories; below 0 if unknown.
    track_points: Vec<f32>,
    /// The same for the mask trajectories.
    mask_track_points: Vec<f32>,
}

/// The next step of saliency.
#[derive(Debug, Clone, Copy)]
enum SaliencyStep {
    /// Without flow nothing is salient.
    WithoutFlow,
    /// Samples the saliency map of a frame at its trajectory points.
    Map(usize),
    /// Averages the saliency of trajectories over the embedding.
    Average,
}

impl SaliencyWork {
    pub(super) fn new(track_set: &TrackSet, clip: &mut Clip) -> Self {
        let unknown = |tracks: &Trajectories| vec![-1.0; tracks.x.len()];
        Self {
            step: if clip.flows.is_empty() { SaliencyStep::WithoutFlow } else { SaliencyStep::Map(0) },
            maps: clip.saliency_maps.take().unwrap_or_else(|| SaliencyMaps::new(&clip.params.saliency)),
            track_points: unknown(&track_set.tracks),
            mask_track_points: track_set.mask_tracks.as_ref().map_or_else(Vec::new, unknown),
        }
    }

    /// Collects the points of trajectories in frame `t`, then the points of mask trajectories.
    fn query(&self, t: usize, clip: &Clip, track_set: &TrackSet) -> SaliencyQuery {
        let flow = &clip.flows[t];
        let pixels = |tracks| point_pixels(tracks, t, flow.size()).map(|(_, pixel)| pixel);
        let sets: [Option<&Trajectories>; 2] = [Some(&track_set.tracks), track_set.mask_tracks.as_ref()];
        self.maps.query(t, flow, &mut sets.into_iter().flatten().flat_map(pixels))
    }

    /// Stores the saliency of the trajectory points in frame `t`.
    fn map(&mut self, t: usize, clip: &mut Clip, track_set: &TrackSet) {
        let size = clip.scale.working;
        let values = match clip.pending_jobs.take_result(JobKind::Saliency, t) {
            Some(JobResult::Saliency(values)) => values,
            _ => self.query(t, clip, track_set).evaluate(&clip.params.saliency),
        };
        let points = point_pixels(&track_set.tracks, t, size).zip(&values);
        let count = points.map(|((point, _), &value)| self.track_points[point] = value).count();
        if let Some(mask_tracks) = &track_set.mask_tracks {
            let points = point_pixels(mask_tracks, t, size).zip(values.get(count..).unwrap_or_default());
            points.for_each(|((point, _), &value)| self.mask_track_points[point] = value);
        }
    }

    fn average(&mut self, clip: &Clip, outputs: &Outputs) -> SaliencyOutputs {
        let (track_set, settings) = (&outputs.track_set, &clip.params.saliency);
        let of_points = greatest_of_points(&track_set.tracks, &self.track_points);
        let tracks = context_saliency(of_points, &outputs.embedding, &outputs.discontinuities, settings);
        let maximum = |mask_tracks| greatest_of_points(mask_tracks, &self.mask_track_points);
        let mask_tracks = track_set.mask_tracks.as_ref().map_or_else(Vec::new, maximum);
        let maps = std::mem::replace(&mut self.maps, SaliencyMaps::new(settings));
        SaliencyOutputs { maps, tracks, mask_tracks }
    }
}

impl StageWork for SaliencyWork {
    fn step(&mut self, clip: &mut Clip, outputs: &mut Outputs) -> Result<StepReport, Error> {
        let pairs = clip.flows.len();
        let report = |done| StepReport::new(Stage::Saliency, done, pairs + 1);
        Ok(match self.step {
            SaliencyStep::WithoutFlow => StepReport::new(Stage::Saliency, 1, 1),
            SaliencyStep::Map(t) => {
                self.map(t, clip, &outputs.track_set);
                self.step = if t + 1 < pairs { SaliencyStep::Map(t + 1) } else { SaliencyStep::Average };
                report(t + 1)
            }
            SaliencyStep::Average => {
                outputs.saliency = Some(self.average(clip, outputs));
                report(pairs + 1)
            }
        })
    }

    fn take_job(&self, clip: &mut Clip, outputs: &Outputs) -> Option<Job> {
        let SaliencyStep::Map(next) = self.step else { return None };
        let id = clip.pending_jobs.assign(JobKind::Saliency, next..clip.flows.len())?;
        Some(Job { id, input: JobInput::Saliency(self.query(id.index as usize, clip, &outputs.track_set)) })
    }

    fn is_waiting(&self, pending_jobs: &PendingJobs, _: &Outputs) -> bool {
        matches!(self.step, SaliencyStep::Map(t) if pending_jobs.is_pending(JobKind::Saliency, t))
    }
}

/// Components of the foreground; if they separate trajectories, also a second embedding and its discontinuities.
#[derive(Debug, Clone, Default)]
pub(crate) enum ConnectednessWork {
    /// Finds the components.
    #[default]
    Components,
    /// Embeds the remaining affinities.
    Embedding(SymCsr),
    /// Computes the discontinuities of the new embedding.
    Discontinuities(SymCsr, Embedding),
}

impl StageWork for ConnectednessWork {
    fn step(&mut self, clip: &mut Clip, outputs: &mut Outputs) -> Result<StepReport, Error> {
        let params = &clip.params;
        Ok(match std::mem::take(self) {
            Self::Components => match separate(clip, outputs) {
                None => StepReport::new(Stage::Connectedness, 1, 1),
                Some(affinities) => {
                    *self = Self::Embedding(affinities);
                    StepReport::new(Stage::Connectedness, 1, 3)
                }
            },
            Self::Embedding(affinities) => {
                let embedding = embed(&affinities, &params.embedding, params.clip.seed);
                *self = Self::Discontinuities(affinities, embedding);
                StepReport::new(Stage::Connectedness, 2, 3)
            }
            Self::Discontinuities(affinities, embedding) => {
                let neighborhoods = std::mem::take(&mut outputs.discontinuities.neighborhoods);
                outputs.discontinuities = discontinuities(neighborhoods, &embedding, &params.discontinuity);
                (outputs.affinities, outputs.embedding) = (affinities, embedding);
                StepReport::new(Stage::Connectedness, 3, 3)
            }
        })
    }
}

/// Finds the components of the foreground. Returns the affinities without those between separated trajectories; `None` if
/// no trajectories are separated.
fn separate(clip: &Clip, outputs: &mut Outputs) -> Option<SymCsr> {
    let (settings, tracks) = (&clip.params.connectedness, &outputs.track_set.tracks);
    let foreground = &outputs.saliency.as_ref()?.tracks.foreground;
    let max_edge = settings.max_edge * clip.params.spacing();
    let neighborhoods = &outputs.discontinuities.neighborhoods;
    let components = components(tracks, neighborhoods, foreground, max_edge, settings.min_component as usize);
    let is_on = settings.mode != ConnectednessMode::Off;
    let separation = is_on.then(|| Separation::new(tracks, &components, settings));
    let remaining = separation.as_ref().and_then(|s| constrain(&outputs.affinities, tracks, s, foreground, settings));
    (outputs.components, outputs.separation) = (Some(components), separation);
    remaining.map(|(affinities, _)| affinities)
}

/// The clusters, in one step. If only the foreground is clustered, the background is a cluster of its own.
#[derive(Debug, Clone)]
pub(crate) struct ClusterWork;

/// Returns the numbers of clusters that rotations are computed for, without duplicates.
fn counts_of_rotations(clip: &Clip, embedding: &Embedding) -> Vec<usize> {
    let mut counts = rotation_counts(embedding, &clip.params.discretize);
    counts.dedup();
    counts
}

impl StageWork for ClusterWork {
    fn step(&mut self, clip: &mut Clip, outputs: &mut Outputs) -> Result<StepReport, Error> {
        let (params, embedding) = (&clip.params, &outputs.embedding);
        let counts = counts_of_rotations(clip, embedding);
        let pending_jobs = &mut clip.pending_jobs;
        let rotated_labels = |count: usize| {
            let job = counts.iter().position(|&c| c == count);
            match job.and_then(|k| pending_jobs.take_result(JobKind::Rotation, k)) {
                Some(JobResult::Rotation(labels)) => labels,
                _ => NormalizedRows::new(embedding, count).rotate(),
            }
        };
        let evidence = outputs.cluster_evidence(&params.affinity);
        let mut clusters = discretize_with(embedding, &evidence, &params.discretize, params.clip.seed, rotated_labels);
        if let (Some(saliency), ConnectednessMode::ForegroundOnly) = (&outputs.saliency, params.connectedness.mode) {
            clusters = with_background(&outputs.track_set.tracks, clusters, &saliency.tracks.foreground);
        }
        outputs.clusters = clusters;
        Ok(StepReport::new(Stage::Clusters, 1, 1))
    }

    fn take_job(&self, clip: &mut Clip, outputs: &Outputs) -> Option<Job> {
        let counts = counts_of_rotations(clip, &outputs.embedding);
        let id = clip.pending_jobs.assign(JobKind::Rotation, 0..counts.len())?;
        Some(Job { id, input: JobInput::Rotation(NormalizedRows::new(&outputs.embedding, counts[id.index as usize])) })
    }

    fn is_waiting(&self, pending_jobs: &PendingJobs, _: &Outputs) -> bool {
        (0..NUM_ROTATIONS).any(|k| pending_jobs.is_pending(JobKind::Rotation, k))
    }
}
