//! Saliency frame by frame, then the components of the foreground and what they change, then the clusters.

use super::clip::Clip;
use super::work::{StageWork, Turn};
use crate::Error;
use crate::connectedness::{ConnectednessMode, Separation, components, constrain};
use crate::discontinuity::discontinuities;
use crate::discretize::{NUM_ROTATIONS, NormalizedRows, discretize_with, rotation_counts, with_background};
use crate::embedding::{Embedding, embed};
use crate::flow::Field;
use crate::saliency::{SaliencyMaps, SaliencyQuery, context_saliency, point_pixels, trajectory_saliency};
use crate::session::base::{Outputs, Salient, Stage, Tracked};
use crate::session::jobs::{Ledger, Made, Piece, PieceKind, Work};
use crate::sparse::SymCsr;
use crate::trajectory::Trajectories;

/// Saliency: one look at each flow field, one map of each, and the average over the embedding.
#[derive(Debug, Clone)]
pub(crate) struct SaliencyWork {
    step: SaliencyStep,
    maps: SaliencyMaps,
    /// The saliency of each point of the trajectories; below 0 where not known.
    of_points: Vec<f32>,
    /// The saliency of each point of the denser ones.
    of_denser: Vec<f32>,
}

/// The step of saliency that is next.
#[derive(Debug, Clone, Copy)]
enum SaliencyStep {
    /// There is no flow, and nothing will be salient.
    WithoutFlow,
    /// A flow field is looked at, ...
    Looking,
    /// ... the points of a frame get their saliency from its map, ...
    Mapping(usize),
    /// ... and trajectories theirs in the context of the embedding.
    Averaging,
}

impl SaliencyWork {
    pub(crate) fn new(tracked: &Tracked, clip: &Clip) -> Self {
        let unknown = |tracks: &Trajectories| vec![-1.0; tracks.x.len()];
        Self {
            step: if clip.flows.is_empty() { SaliencyStep::WithoutFlow } else { SaliencyStep::Looking },
            maps: SaliencyMaps::new(&clip.params.saliency),
            of_points: unknown(&tracked.tracks),
            of_denser: tracked.denser.as_ref().map_or_else(Vec::new, unknown),
        }
    }

    /// The points of both sets of trajectories in frame `t`, those of the denser ones last.
    fn query(&self, t: usize, clip: &Clip, tracked: &Tracked) -> SaliencyQuery {
        let flow = &clip.flows[t];
        let at = |tracks| point_pixels(tracks, t, flow.size()).map(|(_, pixel)| pixel);
        let sets: [Option<&Trajectories>; 2] = [Some(&tracked.tracks), tracked.denser.as_ref()];
        self.maps.query(t, flow, &mut sets.into_iter().flatten().flat_map(at))
    }

    fn map(&mut self, t: usize, clip: &mut Clip, tracked: &Tracked) {
        let size = clip.scale.working;
        let values = match clip.ledger.collect(PieceKind::Saliency, t) {
            Some(Made::Saliency(values)) => values,
            _ => self.query(t, clip, tracked).evaluate(&clip.params.saliency),
        };
        let points = point_pixels(&tracked.tracks, t, size).zip(&values);
        let count = points.map(|((point, _), &value)| self.of_points[point] = value).count();
        if let Some(denser) = &tracked.denser {
            let points = point_pixels(denser, t, size).zip(values.get(count..).unwrap_or_default());
            points.for_each(|((point, _), &value)| self.of_denser[point] = value);
        }
    }

    fn average(&mut self, clip: &Clip, outputs: &Outputs) -> Salient {
        let (tracked, settings) = (&outputs.tracked, &clip.params.saliency);
        let alone = trajectory_saliency(&tracked.tracks, &self.of_points);
        let saliency = context_saliency(alone, &outputs.embedding, &outputs.discontinuities, settings);
        let denser = tracked.denser.as_ref();
        let of_denser = denser.map_or_else(Vec::new, |denser| trajectory_saliency(denser, &self.of_denser));
        let maps = std::mem::replace(&mut self.maps, SaliencyMaps::new(settings));
        Salient { maps, of_denser, saliency }
    }
}

impl StageWork for SaliencyWork {
    fn step(&mut self, clip: &mut Clip, outputs: &mut Outputs) -> Result<Turn, Error> {
        let pairs = clip.flows.len();
        let turn = |done| Turn::new(Stage::Saliency, done, 2 * pairs + 1);
        Ok(match self.step {
            SaliencyStep::WithoutFlow => Turn::new(Stage::Saliency, 1, 1),
            SaliencyStep::Looking => {
                let t = self.maps.motions().len();
                self.maps.add_field(&clip.flows[t]);
                self.step = if t + 1 < pairs { SaliencyStep::Looking } else { SaliencyStep::Mapping(0) };
                turn(t + 1)
            }
            SaliencyStep::Mapping(t) => {
                self.map(t, clip, &outputs.tracked);
                self.step = if t + 1 < pairs { SaliencyStep::Mapping(t + 1) } else { SaliencyStep::Averaging };
                turn(pairs + t + 1)
            }
            SaliencyStep::Averaging => {
                outputs.salient = Some(self.average(clip, outputs));
                turn(2 * pairs + 1)
            }
        })
    }

    fn take(&self, clip: &mut Clip, outputs: &Outputs) -> Option<Piece> {
        let SaliencyStep::Mapping(next) = self.step else { return None };
        let id = clip.ledger.take(PieceKind::Saliency, next..clip.flows.len())?;
        Some(Piece { id, work: Work::Saliency(self.query(id.t as usize, clip, &outputs.tracked)) })
    }

    fn awaits(&self, ledger: &Ledger, _: &Outputs) -> bool {
        matches!(self.step, SaliencyStep::Mapping(t) if ledger.is_out(PieceKind::Saliency, t))
    }
}

/// Components of the foreground; where they separate trajectories, a second embedding and its discontinuities.
#[derive(Debug, Clone, Default)]
pub(crate) enum ConnectednessWork {
    /// The foreground is taken to pieces.
    #[default]
    Connecting,
    /// The affinities that are left are embedded, ...
    Reembedding(SymCsr),
    /// ... and the discontinuities of that embedding replace those of motion alone.
    Renewing(SymCsr, Embedding),
}

impl StageWork for ConnectednessWork {
    fn step(&mut self, clip: &mut Clip, outputs: &mut Outputs) -> Result<Turn, Error> {
        let params = &clip.params;
        Ok(match std::mem::take(self) {
            Self::Connecting => match connect(clip, outputs) {
                None => Turn::new(Stage::Connectedness, 1, 1),
                Some(affinities) => {
                    *self = Self::Reembedding(affinities);
                    Turn::new(Stage::Connectedness, 1, 3)
                }
            },
            Self::Reembedding(affinities) => {
                let embedding = embed(&affinities, &params.embedding, params.clip.seed);
                *self = Self::Renewing(affinities, embedding);
                Turn::new(Stage::Connectedness, 2, 3)
            }
            Self::Renewing(affinities, embedding) => {
                let near = std::mem::take(&mut outputs.discontinuities.neighborhoods);
                outputs.discontinuities = discontinuities(near, &embedding, &params.discontinuity);
                (outputs.affinities, outputs.embedding) = (affinities, embedding);
                Turn::new(Stage::Connectedness, 3, 3)
            }
        })
    }
}

/// Takes the foreground to pieces. Returns the affinities without those between separated trajectories; `None` where none
/// are.
fn connect(clip: &Clip, outputs: &mut Outputs) -> Option<SymCsr> {
    let (settings, tracks) = (&clip.params.connectedness, &outputs.tracked.tracks);
    let foreground = &outputs.salient.as_ref()?.saliency.foreground;
    let longest = settings.max_edge * clip.params.spacing();
    let near = &outputs.discontinuities.neighborhoods;
    let components = components(tracks, near, foreground, longest, settings.min_component as usize);
    let is_on = settings.mode != ConnectednessMode::Off;
    let separation = is_on.then(|| Separation::new(tracks, &components, settings));
    let kept = separation.as_ref().and_then(|s| constrain(&outputs.affinities, tracks, s, foreground, settings));
    (outputs.components, outputs.separation) = (Some(components), separation);
    kept.map(|(affinities, _)| affinities)
}

/// The clusters, in one step; where the foreground stands alone the background is in one of its own.
#[derive(Debug, Clone)]
pub(crate) struct ClusterWork;

/// The numbers of clusters that rotations are made for, each once.
fn counts_of_rotations(clip: &Clip, embedding: &Embedding) -> Vec<usize> {
    let mut counts = rotation_counts(embedding, &clip.params.discretize);
    counts.dedup();
    counts
}

impl StageWork for ClusterWork {
    fn step(&mut self, clip: &mut Clip, outputs: &mut Outputs) -> Result<Turn, Error> {
        let (params, embedding) = (&clip.params, &outputs.embedding);
        let counts = counts_of_rotations(clip, embedding);
        let ledger = &mut clip.ledger;
        let rotate = |count: usize| {
            let place = counts.iter().position(|&c| c == count);
            match place.and_then(|k| ledger.collect(PieceKind::Rotation, k)) {
                Some(Made::Rotation(labels)) => labels,
                _ => NormalizedRows::new(embedding, count).rotate(),
            }
        };
        let known = outputs.known(&params.affinity);
        let mut clusters = discretize_with(embedding, &known, &params.discretize, params.clip.seed, rotate);
        if let (Some(salient), ConnectednessMode::ForegroundOnly) = (&outputs.salient, params.connectedness.mode) {
            clusters = with_background(&outputs.tracked.tracks, clusters, &salient.saliency.foreground);
        }
        outputs.clusters = clusters;
        Ok(Turn::new(Stage::Clusters, 1, 1))
    }

    fn take(&self, clip: &mut Clip, outputs: &Outputs) -> Option<Piece> {
        let counts = counts_of_rotations(clip, &outputs.embedding);
        let id = clip.ledger.take(PieceKind::Rotation, 0..counts.len())?;
        Some(Piece { id, work: Work::Rotation(NormalizedRows::new(&outputs.embedding, counts[id.t as usize])) })
    }

    fn awaits(&self, ledger: &Ledger, _: &Outputs) -> bool {
        (0..NUM_ROTATIONS).any(|k| ledger.is_out(PieceKind::Rotation, k))
    }
}
