//! Saliency frame by frame, then the components of the foreground and what they change.

use super::stage::{Progress, Stage};
use crate::connectedness::{
    Components, ConnectednessMode, Separation, components, constrain, join_parts, with_background,
};
use crate::discontinuity::{Discontinuities, discontinuities};
use crate::discretize::Clusters;
use crate::embedding::{Embedding, embed};
use crate::flow::CompactFlow;
use crate::image::Plane;
use crate::params::Params;
use crate::saliency::{Saliency, SaliencyMaps, context_saliency, trajectory_saliency};
use crate::sparse::SymCsr;
use crate::trajectory::Trajectories;

/// What motion alone has found, in working pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motions<'a> {
    pub(super) flows: &'a [CompactFlow],
    pub(super) tracks: &'a Trajectories,
    /// The denser ones that the masks are made from.
    pub(super) mask_tracks: Option<&'a Trajectories>,
    pub(super) affinities: &'a SymCsr,
    pub(super) embedding: &'a Embedding,
    pub(super) discontinuities: &'a Discontinuities,
    /// The parameters, counts of trajectories already at the present spacing.
    pub(super) params: &'a Params,
    /// Distance of neighbouring trajectories, in pixels.
    pub(super) spacing: f32,
}

/// What the foreground stages have found so far.
#[derive(Debug, Default)]
pub(super) struct Foreground {
    maps: Option<SaliencyMaps>,
    /// Flow fields looked at, and maps made.
    looked: usize,
    mapped: usize,
    /// The saliency of each point of the trajectories; below 0 where not known.
    of_points: Vec<f32>,
    /// The greatest saliency of each of the denser trajectories.
    pub(super) of_mask_tracks: Vec<f32>,
    pub(super) saliency: Option<Saliency>,
    pub(super) components: Option<Components>,
    /// Who is kept apart by them.
    separation: Option<Separation>,
    /// Affinities with those of separated trajectories left out, and their embedding.
    constrained: Option<SymCsr>,
    embedding: Option<Embedding>,
}

/// What a step of the connectedness has come to.
pub(super) enum Connected {
    More,
    /// Motion alone decides.
    Unchanged,
    /// The affinities that the foreground allows, and what follows from them.
    Changed(Box<(SymCsr, Embedding, Discontinuities)>),
}

impl Foreground {
    /// One flow field looked at, one map sampled, or, last, the average over the embedding. Without flow there is nothing to do.
    pub(super) fn step_saliency(&mut self, from: &Motions<'_>) -> Progress {
        let pairs = from.flows.len();
        let maps = self.maps.get_or_insert_with(|| SaliencyMaps::new(&from.params.saliency));
        if self.looked < pairs {
            maps.look_at(&from.flows[self.looked].unpack(1.0, 1.0));
            self.looked += 1;
        } else if self.mapped < pairs {
            self.of_points.resize(from.tracks.x.len(), -1.0);
            let t = self.mapped;
            let map = maps.map(t, &from.flows[t].unpack(1.0, 1.0));
            for (i, x, y) in from.tracks.alive(t) {
                let point = from.tracks.points(i).start + t - from.tracks.start_frame[i] as usize;
                self.of_points[point] = nearest(&map, x, y);
            }
            if let Some(denser) = from.mask_tracks {
                self.of_mask_tracks.resize(denser.len(), 0.0);
                for (i, x, y) in denser.alive(t) {
                    self.of_mask_tracks[i] = self.of_mask_tracks[i].max(nearest(&map, x, y));
                }
            }
            self.mapped += 1;
        } else if pairs > 0 {
            let of_points = std::mem::take(&mut self.of_points);
            let settings = &from.params.saliency;
            let alone = trajectory_saliency(from.tracks, &of_points, settings.quantile);
            let found = context_saliency(alone, from.embedding, from.discontinuities, settings);
            self.saliency = Some(found);
        }
        let (done, total) = (self.looked + self.mapped + 1, 2 * pairs + 1);
        let done = if self.saliency.is_some() || pairs == 0 { total } else { done - 1 };
        Progress { stage: Stage::Saliency, done: done as u32, total: total as u32 }
    }

    /// How salient each pixel of a frame is, once all maps have been made.
    pub(super) fn maps(&self) -> Option<&SaliencyMaps> {
        self.maps.as_ref().filter(|_| self.saliency.is_some())
    }

    /// Components and constraints, then the second embedding, then its discontinuities.
    pub(super) fn step_connectedness(&mut self, from: &Motions<'_>) -> (Progress, Connected) {
        let settings = &from.params.connectedness;
        let progress = |done, total| Progress { stage: Stage::Connectedness, done, total };
        let Some(saliency) = &self.saliency else { return (progress(1, 1), Connected::Unchanged) };
        if self.components.is_none() {
            let near = &from.discontinuities.neighborhoods;
            let longest = settings.max_edge * from.spacing;
            let found = components(from.tracks, near, &saliency.foreground, longest, settings.min_component as usize);
            if settings.mode != ConnectednessMode::Off {
                let separation = Separation::new(from.tracks, &found, settings);
                let constrained = constrain(from.affinities, from.tracks, &separation, &saliency.foreground, settings);
                self.constrained = constrained.map(|(affinities, _)| affinities);
                self.separation = Some(separation);
            }
            self.components = Some(found);
            return match self.constrained {
                Some(_) => (progress(1, 3), Connected::More),
                None => (progress(1, 1), Connected::Unchanged),
            };
        }
        let Some(constrained) = &self.constrained else { return (progress(1, 1), Connected::Unchanged) };
        let Some(embedding) = self.embedding.take() else {
            self.embedding = Some(embed(constrained, &from.params.embedding, from.params.clip.seed));
            return (progress(2, 3), Connected::More);
        };
        let near = from.discontinuities.neighborhoods.clone();
        let found = discontinuities(near, &embedding, &from.params.discontinuity);
        let affinities = self.constrained.take().unwrap_or_default();
        (progress(3, 3), Connected::Changed(Box::new((affinities, embedding, found))))
    }

    /// The clusters with the parts of agents joined, and the background in one of its own where the foreground stands alone.
    pub(super) fn settle(
        &self,
        tracks: &Trajectories,
        clusters: Clusters,
        found: &Discontinuities,
        params: &Params,
    ) -> Clusters {
        let (Some(saliency), Some(separation)) = (&self.saliency, &self.separation) else { return clusters };
        let (foreground, settings) = (&saliency.foreground, &params.connectedness);
        let clusters = join_parts(tracks, clusters, found, separation, foreground, settings);
        match settings.mode {
            ConnectednessMode::ForegroundOnly => with_background(tracks, clusters, foreground),
            _ => clusters,
        }
    }
}

/// The value of the pixel nearest to a point.
fn nearest(map: &Plane<f32>, x: f32, y: f32) -> f32 {
    let place = |v: f32, limit: usize| ((v + 0.5).max(0.0) as usize).min(limit - 1);
    map[(place(x, map.width()), place(y, map.height()))]
}
