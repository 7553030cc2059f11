//! What the stages find, phase by phase: each type holds what is certainly there once its phase is over.

use super::geometry::Scale;
use crate::affinity::AffinityParams;
use crate::background::Background;
use crate::camera::Camera;
use crate::connectedness::{Components, Separation};
use crate::correction::Held;
use crate::cut::{CutInput, CutLabels};
use crate::discontinuity::Discontinuities;
use crate::discretize::Clusters;
use crate::embedding::Embedding;
use crate::evidence::{Known, strangeness};
use crate::image::{Plane, Runs, sample_bilinear};
use crate::judge::cluster_doubts;
use crate::objects::Objects;
use crate::saliency::{Saliency, SaliencyMaps};
use crate::sparse::SymCsr;
use crate::superpixel::Superpixels;
use crate::trajectory::Trajectories;
use std::sync::{Arc, OnceLock};

/// What can be read of a session: the outputs so far, none where they are yet to come.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Found<'a> {
    pub(super) tracked: Option<&'a Tracked>,
    pub(super) affinities: Option<&'a SymCsr>,
    pub(super) embedding: Option<&'a Embedding>,
    pub(super) discontinuities: Option<&'a Discontinuities>,
    pub(super) salient: Option<&'a Salient>,
    pub(super) components: Option<&'a Components>,
    pub(super) separation: Option<&'a Separation>,
    pub(super) clusters: Option<&'a Clusters>,
    pub(super) superpixels: &'a [Superpixels],
    pub(super) cut: Option<&'a Cut>,
    pub(super) masks: &'a [Plane<u8>],
    pub(super) num_corrections: usize,
    pub(super) camera: Option<&'a Camera>,
}

impl<'a> Found<'a> {
    /// What clusters are compared by; `None` until it is known. Without flow the camera is held to stand still.
    pub(super) fn known(&self, params: &'a AffinityParams) -> Option<Known<'a>> {
        let (tracks, maps) = (&self.tracked?.tracks, self.salient.map(|salient| &salient.maps));
        Some(Known::new(tracks, self.discontinuities?, params, maps, self.separation))
    }
}

/// The trajectories of the clip.
#[derive(Debug, Clone)]
pub(super) struct Tracked {
    /// In working pixels.
    pub(super) tracks: Trajectories,
    /// The same in input pixels.
    pub(super) input: Trajectories,
    /// The clip-wide number of each.
    pub(super) numbers: Vec<u32>,
    /// The same in working pixels with what is remembered from before the window; `None` where nothing is.
    pub(super) with_past: Option<Trajectories>,
    /// Denser and shorter ones that masks are made from, in working pixels; `None` without masks.
    pub(super) denser: Option<Trajectories>,
}

impl Tracked {
    /// Trajectories from outside, in input pixels.
    pub(super) fn given(input: Trajectories, scale: Scale) -> Self {
        let tracks = scale.to_working(&input);
        let numbers = (0..tracks.len() as u32).collect();
        Self { tracks, input, numbers, with_past: None, denser: None }
    }

    /// The points in frame `t` get the local flow variation there, where it is not known; it is at half the working
    /// size. Points in the last frame have that of the points before, as those of the tracker.
    pub(super) fn learn(&mut self, t: usize, variation: &Plane<f32>) {
        let is_last = t + 2 == self.tracks.num_frames;
        for i in 0..self.tracks.len() {
            let alive = self.tracks.frames(i);
            if alive.contains(&t) {
                let p = self.tracks.point(i, t);
                let Trajectories { x, y, variation: known, .. } = &mut self.tracks;
                if known[p] == 0.0 {
                    known[p] = sample_bilinear(variation, (x[p] - 0.5) * 0.5, (y[p] - 0.5) * 0.5);
                }
                if is_last && t + 1 < alive.end && known[p + 1] == 0.0 {
                    known[p + 1] = known[p];
                }
            }
        }
    }

    /// The whole life of the trajectories, as far as it is remembered.
    pub(super) fn lived(&self) -> &Trajectories {
        self.with_past.as_ref().unwrap_or(&self.tracks)
    }

    pub(super) fn found(&self) -> Found<'_> {
        Found { tracked: Some(self), ..Found::default() }
    }
}

/// Trajectories with their affinities.
#[derive(Debug, Clone)]
pub(super) struct Linked {
    pub(super) tracked: Tracked,
    pub(super) affinities: SymCsr,
}

impl Linked {
    pub(super) fn found(&self) -> Found<'_> {
        Found { affinities: Some(&self.affinities), ..self.tracked.found() }
    }
}

/// These with their embedding.
#[derive(Debug, Clone)]
pub(super) struct Placed {
    pub(super) linked: Linked,
    pub(super) embedding: Embedding,
}

impl Placed {
    pub(super) fn found(&self) -> Found<'_> {
        Found { embedding: Some(&self.embedding), ..self.linked.found() }
    }
}

/// What motion says of the trajectories; once the foreground keeps some apart, without what it keeps apart.
#[derive(Debug, Clone)]
pub(super) struct Embedded {
    pub(super) tracked: Tracked,
    pub(super) affinities: SymCsr,
    pub(super) embedding: Embedding,
    pub(super) discontinuities: Discontinuities,
}

impl Embedded {
    pub(super) fn found(&self) -> Found<'_> {
        Found {
            affinities: Some(&self.affinities),
            embedding: Some(&self.embedding),
            discontinuities: Some(&self.discontinuities),
            ..self.tracked.found()
        }
    }
}

/// What stands out.
#[derive(Debug, Clone)]
pub(super) struct Salient {
    pub(super) maps: SaliencyMaps,
    /// The greatest saliency of each of the denser trajectories.
    pub(super) of_denser: Vec<f32>,
    pub(super) saliency: Saliency,
}

/// What stands out, and in which pieces.
#[derive(Debug, Clone)]
pub(super) struct Foreground {
    pub(super) salient: Salient,
    pub(super) components: Components,
    /// Who is kept apart by them; `None` where connectedness is off.
    pub(super) separation: Option<Separation>,
}

impl Foreground {
    /// What is found with this on top of what `motion` has.
    pub(super) fn found<'a>(&'a self, motion: Found<'a>) -> Found<'a> {
        Found {
            salient: Some(&self.salient),
            components: Some(&self.components),
            separation: self.separation.as_ref(),
            ..motion
        }
    }
}

/// Trajectories with their labels.
#[derive(Debug, Clone)]
pub(super) struct Clustered {
    pub(super) embedded: Embedded,
    /// `None` without flow.
    pub(super) foreground: Option<Foreground>,
    pub(super) clusters: Clusters,
}

impl Clustered {
    /// How far each cluster is from the camera's motion; empty without flow.
    pub(super) fn strangeness(&self, params: &AffinityParams) -> Vec<f64> {
        let known = self.foreground.as_ref().and_then(|_| self.found().known(params));
        known.map_or_else(Vec::new, |known| strangeness(&self.clusters.label, &known))
    }

    pub(super) fn found(&self) -> Found<'_> {
        let motion = self.embedded.found();
        let found = self.foreground.as_ref().map_or(motion, |foreground| foreground.found(motion));
        Found { clusters: Some(&self.clusters), ..found }
    }

    /// The trajectories that the cut listens to, and their labels; `voted` has those of the denser ones.
    pub(super) fn counting<'a>(&'a self, voted: Option<&'a [u32]>) -> (&'a Trajectories, &'a [u32]) {
        let tracked = &self.embedded.tracked;
        let tracks = tracked.denser.as_ref().unwrap_or(&tracked.tracks);
        (tracks, voted.unwrap_or(&self.clusters.label))
    }

    /// The greatest saliency of each of the denser trajectories; empty where it is not known.
    pub(super) fn salience(&self) -> &[f32] {
        self.foreground.as_ref().map_or(&[], |foreground| &foreground.salient.of_denser)
    }
}

/// What a cut is made from, at working size: labelled trajectories, and the superpixels of all frames.
#[derive(Debug, Clone)]
pub(super) struct Parts {
    pub(super) clustered: Clustered,
    pub(super) superpixels: Vec<Superpixels>,
    /// `None` without flow.
    pub(super) camera: Option<Camera>,
    /// `None` unless clips are judged by it.
    pub(super) background: Option<Background>,
    /// What speaks against the cluster of each trajectory to be an object, although it is one; empty where nothing does.
    pub(super) doubts: Vec<f32>,
    pub(super) corrections: Corrections,
}

impl Parts {
    /// What speaks against each cluster, by the trajectories that it has now: corrections make clusters anew. `is_sure` says
    /// of which clusters the user has told.
    pub(super) fn doubts(&self, is_sure: impl Fn(usize) -> bool) -> Vec<f32> {
        cluster_doubts(&self.clustered.clusters, &self.doubts, is_sure)
    }

    /// What the cut is made from; `voted` has the labels of the denser trajectories.
    pub(super) fn input<'a>(
        &'a self,
        voted: Option<&'a [u32]>,
        is_object: &'a [bool],
        evidence: &'a [f32],
    ) -> CutInput<'a> {
        let (tracks, label) = self.clustered.counting(voted);
        CutInput {
            superpixels: &self.superpixels,
            tracks,
            label,
            num_labels: self.clustered.clusters.count.max(1),
            objects: is_object,
            evidence,
        }
    }

    pub(super) fn found(&self) -> Found<'_> {
        Found {
            camera: self.camera.as_ref(),
            superpixels: &self.superpixels,
            num_corrections: self.corrections.before.len(),
            ..self.clustered.found()
        }
    }
}

/// A cluster for each superpixel, and which clusters are which objects.
#[derive(Debug, Clone)]
pub(super) struct Cut {
    pub(super) labels: CutLabels,
    pub(super) objects: Objects,
    /// Shared with what was before a correction.
    pub(super) ground: Arc<CutGround>,
    /// Made when first asked for.
    pub(super) sure: OnceLock<Sureness>,
}

/// What confidences are made from.
#[derive(Debug, Clone)]
pub(super) struct Sureness {
    /// How much dearer another mask label is for each superpixel, in units of cost.
    pub(super) margins: Vec<f32>,
    /// What the background says for an object, the mean over each mask label.
    pub(super) cue: [f32; 256],
}

/// What the cut was made from, as far as it is not kept elsewhere: to say why.
#[derive(Debug, Clone)]
pub(super) struct CutGround {
    /// The labels of the denser trajectories; `None` without them.
    pub(super) voted: Option<Vec<u32>>,
    /// Whether each cluster is an object.
    pub(super) is_object: Vec<bool>,
    /// What the background says for an object in each superpixel; empty without one.
    pub(super) cues: Vec<f32>,
    /// The same with what objects look like.
    pub(super) evidence: Vec<f32>,
    /// What a correction cut anew; `None` for the first cut.
    pub(super) region: Option<CutRegion>,
}

/// What a correction cut anew.
#[derive(Debug, Clone)]
pub(super) struct CutRegion {
    /// Which clusters could be given and taken.
    pub(super) open: Vec<bool>,
    /// Superpixels under strokes: frame, superpixel, and whether each cluster was legal.
    pub(super) held: Vec<(usize, u32, Vec<bool>)>,
}

/// All that is found of a clip with masks.
#[derive(Debug, Clone)]
pub(super) struct Segmented {
    pub(super) parts: Parts,
    pub(super) cut: Cut,
    pub(super) masks: Vec<Plane<u8>>,
}

impl Segmented {
    pub(super) fn found(&self) -> Found<'_> {
        Found { cut: Some(&self.cut), masks: &self.masks, ..self.parts.found() }
    }
}

/// The corrections in force.
#[derive(Debug, Clone, Default)]
pub(super) struct Corrections {
    /// What was before each of them, the first correction first.
    pub(super) before: Vec<Snapshot>,
    /// What strokes hold.
    pub(super) held: Vec<Held>,
}

/// What was before a correction, masks in little memory.
#[derive(Debug, Clone)]
pub(super) struct Snapshot {
    clusters: Clusters,
    cut: Cut,
    masks: Vec<Runs<u8>>,
    held: Vec<Held>,
}

impl Segmented {
    /// What is found now, to be restored later.
    pub(super) fn snapshot(&self) -> Snapshot {
        Snapshot {
            clusters: self.parts.clustered.clusters.clone(),
            cut: self.cut.clone(),
            masks: self.masks.iter().map(Runs::of).collect(),
            held: self.parts.corrections.held.clone(),
        }
    }
}

impl Snapshot {
    /// All as it was.
    pub(super) fn restore(self, mut parts: Parts) -> Segmented {
        parts.clustered.clusters = self.clusters;
        parts.corrections.held = self.held;
        Segmented { parts, cut: self.cut, masks: self.masks.iter().map(Runs::plane).collect() }
    }
}
