//! Saliency frame by frame, then the components of the foreground and what they change, then the clusters.

use super::clip::Clip;
use super::turn::Turn;
use crate::connectedness::{ConnectednessMode, Separation, components, constrain};
use crate::discontinuity::discontinuities;
use crate::discretize::{MOST_ROTATIONS, RowsOf, discretize_by, rotation_counts, with_background};
use crate::embedding::{Embedding, embed};
use crate::evidence::Known;
use crate::flow::Field;
use crate::saliency::{Asked, SaliencyMaps, context_saliency, pixels_at, trajectory_saliency};
use crate::session::base::{Clustered, Embedded, Foreground, Found, Salient};
use crate::session::base::{Progress, Stage};
use crate::session::jobs::Ledger;
use crate::session::jobs::{Made, PieceKind, Work};
use crate::sparse::SymCsr;
use crate::trajectory::Trajectories;

/// Flow being looked at, field by field.
#[derive(Debug, Clone)]
pub(crate) struct Looking {
    embedded: Embedded,
    maps: SaliencyMaps,
}

/// The saliency of the trajectories' points, frame by frame.
#[derive(Debug, Clone)]
pub(crate) struct Mapping {
    embedded: Embedded,
    maps: SaliencyMaps,
    mapped: usize,
    /// The saliency of each point of the trajectories; below 0 where not known.
    of_points: Vec<f32>,
    /// That of each point of the denser ones.
    of_denser: Vec<f32>,
}

/// Saliency of all points, to be brought into the context of the embedding.
#[derive(Debug, Clone)]
pub(crate) struct Averaging(Mapping);

/// One look at each field, one map of each, and the average over the embedding.
fn progress(clip: &Clip, done: usize) -> Progress {
    Progress { stage: Stage::Saliency, done: done as u32, total: 2 * clip.flows.len() as u32 + 1 }
}

impl Looking {
    /// For clips with any flow.
    pub(crate) fn new(embedded: Embedded, clip: &Clip) -> Self {
        Self { embedded, maps: SaliencyMaps::new(&clip.params.saliency) }
    }

    pub(crate) fn step(mut self: Box<Self>, clip: &Clip) -> Turn<Box<Self>, Box<Mapping>> {
        let t = self.maps.motions().len();
        self.maps.look(&clip.flows[t]);
        let progress = progress(clip, t + 1);
        if t + 1 < clip.flows.len() {
            return Turn::more(progress, self);
        }
        Turn::done(progress, Box::new(Mapping::new(*self)))
    }

    pub(crate) fn found(&self) -> Found<'_> {
        self.embedded.found()
    }
}

impl Mapping {
    fn new(Looking { embedded, maps }: Looking) -> Self {
        let unknown = |num_points: usize| vec![-1.0; num_points];
        let of_denser = unknown(embedded.tracked.denser.as_ref().map_or(0, |denser| denser.x.len()));
        Self { of_points: unknown(embedded.tracked.tracks.x.len()), of_denser, embedded, maps, mapped: 0 }
    }

    pub(crate) fn mapped(&self) -> usize {
        self.mapped
    }

    /// The points of both sets of trajectories in frame `t`, those of the denser ones last.
    fn asked(&self, t: usize, clip: &Clip) -> Asked {
        let (tracked, flow) = (&self.embedded.tracked, &clip.flows[t]);
        let at = |tracks| pixels_at(tracks, t, flow.size()).map(|(_, pixel)| pixel);
        let sets: [Option<&Trajectories>; 2] = [Some(&tracked.tracks), tracked.denser.as_ref()];
        self.maps.asked(t, flow, &mut sets.into_iter().flatten().flat_map(at))
    }

    pub(crate) fn take(&self, clip: &mut Clip) -> Option<(PieceKind, usize, Work)> {
        let t = clip.ledger.take(PieceKind::Saliency, self.mapped..clip.flows.len())?;
        Some((PieceKind::Saliency, t, Work::Saliency(self.asked(t, clip))))
    }

    pub(crate) fn step(mut self: Box<Self>, clip: &mut Clip) -> Turn<Box<Self>, Box<Averaging>> {
        let (t, size) = (self.mapped, clip.scale.working);
        let found = match clip.ledger.collect(PieceKind::Saliency, t) {
            Some(Made::Saliency(found)) => found,
            _ => self.asked(t, clip).answer(&clip.params.saliency),
        };
        let tracked = &self.embedded.tracked;
        let points = pixels_at(&tracked.tracks, t, size).zip(&found);
        let count = points.map(|((point, _), &value)| self.of_points[point] = value).count();
        if let Some(denser) = &tracked.denser {
            let points = pixels_at(denser, t, size).zip(found.get(count..).unwrap_or_default());
            points.for_each(|((point, _), &value)| self.of_denser[point] = value);
        }
        self.mapped += 1;
        let (pairs, progress) = (clip.flows.len(), progress(clip, clip.flows.len() + t + 1));
        if self.mapped < pairs { Turn::more(progress, self) } else { Turn::done(progress, Box::new(Averaging(*self))) }
    }

    pub(crate) fn found(&self) -> Found<'_> {
        self.embedded.found()
    }
}

impl Averaging {
    pub(crate) fn step(self: Box<Self>, clip: &Clip) -> Turn<Box<Self>, Box<Connecting>> {
        let Mapping { embedded, maps, of_points, of_denser, .. } = self.0;
        let settings = &clip.params.saliency;
        let alone = trajectory_saliency(&embedded.tracked.tracks, &of_points);
        let saliency = context_saliency(alone, &embedded.embedding, &embedded.discontinuities, settings);
        let denser = embedded.tracked.denser.as_ref();
        let of_denser = denser.map_or_else(Vec::new, |denser| trajectory_saliency(denser, &of_denser));
        let salient = Some(Salient { maps, of_denser, saliency });
        Turn::done(progress(clip, 2 * clip.flows.len() + 1), Box::new(Connecting { embedded, salient }))
    }

    pub(crate) fn found(&self) -> Found<'_> {
        self.0.found()
    }
}

/// What stands out, to be taken to pieces.
#[derive(Debug, Clone)]
pub(crate) struct Connecting {
    pub(crate) embedded: Embedded,
    /// `None` without flow.
    pub(crate) salient: Option<Salient>,
}

/// All that the labels of the trajectories are made from.
#[derive(Debug, Clone)]
pub(crate) struct Connected {
    embedded: Embedded,
    /// `None` without flow.
    foreground: Option<Foreground>,
}

/// Affinities that the foreground allows, to be embedded.
#[derive(Debug, Clone)]
pub(crate) struct Reembedding {
    connected: Connected,
    affinities: SymCsr,
}

/// These and their embedding, whose discontinuities are still those of motion alone.
#[derive(Debug, Clone)]
pub(crate) struct Renewing {
    connected: Connected,
    affinities: SymCsr,
    embedding: Embedding,
}

/// Step `done` of the three that a second embedding takes.
fn of_three(done: u32) -> Progress {
    Progress { stage: Stage::Connectedness, done, total: 3 }
}

impl Connecting {
    pub(crate) fn step(self: Box<Self>, clip: &Clip) -> Turn<Box<Reembedding>, Box<Connected>> {
        let Self { embedded, salient } = *self;
        let Some(salient) = salient else {
            return Turn::whole(Stage::Connectedness, Box::new(Connected { embedded, foreground: None }));
        };
        let settings = &clip.params.connectedness;
        let (tracks, foreground) = (&embedded.tracked.tracks, &salient.saliency.foreground);
        let longest = settings.max_edge * clip.params.spacing();
        let near = &embedded.discontinuities.neighborhoods;
        let components = components(tracks, near, foreground, longest, settings.min_component as usize);
        let apart = settings.mode != ConnectednessMode::Off;
        let separation = apart.then(|| Separation::new(tracks, &components, settings));
        let kept = separation.as_ref().and_then(|s| constrain(&embedded.affinities, tracks, s, foreground, settings));
        let connected = Connected { embedded, foreground: Some(Foreground { salient, components, separation }) };
        match kept {
            Some((affinities, _)) => Turn::more(of_three(1), Box::new(Reembedding { connected, affinities })),
            None => Turn::whole(Stage::Connectedness, Box::new(connected)),
        }
    }

    pub(crate) fn found(&self) -> Found<'_> {
        Found { salient: self.salient.as_ref(), ..self.embedded.found() }
    }
}

impl Reembedding {
    pub(crate) fn step(self: Box<Self>, clip: &Clip) -> Turn<Box<Self>, Box<Renewing>> {
        let Self { connected, affinities } = *self;
        let embedding = embed(&affinities, &clip.params.embedding, clip.params.clip.seed);
        Turn::done(of_three(2), Box::new(Renewing { connected, affinities, embedding }))
    }

    pub(crate) fn found(&self) -> Found<'_> {
        self.connected.found()
    }
}

impl Renewing {
    pub(crate) fn step(self: Box<Self>, clip: &Clip) -> Turn<Box<Self>, Box<Connected>> {
        let Self { connected: Connected { embedded, foreground }, affinities, embedding } = *self;
        let near = embedded.discontinuities.neighborhoods;
        let discontinuities = discontinuities(near, &embedding, &clip.params.discontinuity);
        let embedded = Embedded { tracked: embedded.tracked, affinities, embedding, discontinuities };
        Turn::done(of_three(3), Box::new(Connected { embedded, foreground }))
    }

    pub(crate) fn found(&self) -> Found<'_> {
        self.connected.found()
    }
}

impl Connected {
    /// The numbers of clusters that rotations are made for, each once.
    fn counts(&self, clip: &Clip) -> Vec<usize> {
        let mut counts = rotation_counts(&self.embedded.embedding, &clip.params.discretize);
        counts.dedup();
        counts
    }

    pub(crate) fn take(&self, clip: &mut Clip) -> Option<(PieceKind, usize, Work)> {
        let counts = self.counts(clip);
        let k = clip.ledger.take(PieceKind::Rotation, 0..counts.len())?;
        Some((PieceKind::Rotation, k, Work::Rotation(RowsOf::new(&self.embedded.embedding, counts[k]))))
    }

    pub(crate) fn awaits(&self, ledger: &Ledger) -> bool {
        (0..MOST_ROTATIONS).any(|k| ledger.is_out(PieceKind::Rotation, k))
    }

    /// The clusters; where the foreground stands alone the background is in one of its own.
    pub(crate) fn step(self: Box<Self>, clip: &mut Clip) -> Turn<Box<Self>, Box<Clustered>> {
        let counts = self.counts(clip);
        let Self { embedded, foreground } = *self;
        let (params, tracks) = (&clip.params, &embedded.tracked.tracks);
        let maps = foreground.as_ref().map(|found| &found.salient.maps);
        let separation = foreground.as_ref().and_then(|found| found.separation.as_ref());
        let known = Known::new(tracks, &embedded.discontinuities, &params.affinity, maps, separation);
        let (embedding, ledger) = (&embedded.embedding, &mut clip.ledger);
        let turned = |count: usize| {
            let place = counts.iter().position(|&c| c == count);
            match place.and_then(|k| ledger.collect(PieceKind::Rotation, k)) {
                Some(Made::Rotation(labels)) => labels,
                _ => RowsOf::new(embedding, count).turned(),
            }
        };
        let mut clusters = discretize_by(embedding, &known, &params.discretize, params.clip.seed, turned);
        if let (Some(foreground), ConnectednessMode::ForegroundOnly) = (&foreground, params.connectedness.mode) {
            clusters = with_background(tracks, clusters, &foreground.salient.saliency.foreground);
        }
        Turn::whole(Stage::Clusters, Box::new(Clustered { embedded, foreground, clusters }))
    }

    pub(crate) fn found(&self) -> Found<'_> {
        let motion = self.embedded.found();
        self.foreground.as_ref().map_or(motion, |foreground| foreground.found(motion))
    }
}
