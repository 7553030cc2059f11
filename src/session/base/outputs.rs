//! Outputs of the stages: plain data that a run extends stage by stage, and that everything else reads.

use super::scale::Scale;
use crate::affinity::AffinityParams;
use crate::background::Background;
use crate::camera::Camera;
use crate::connectedness::{Components, Separation};
use crate::correction::Held;
use crate::cut::{CutInput, CutLabels};
use crate::discontinuity::Discontinuities;
use crate::discretize::Clusters;
use crate::embedding::Embedding;
use crate::evidence::EvidenceInput;
use crate::image::{Plane, Runs};
use crate::objects::Objects;
use crate::saliency::{Saliency, SaliencyMaps};
use crate::sparse::SymCsr;
use crate::superpixel::Superpixels;
use crate::trajectory::Trajectories;
use std::sync::{Arc, OnceLock};

/// The outputs of a run, at working size. The outputs of a stage are complete once the run is past it; superpixels and
/// masks can be read frame by frame before.
#[derive(Debug, Clone, Default)]
pub(crate) struct Outputs {
    pub(crate) tracked: Tracked,
    /// By motion alone at first; once the foreground separates trajectories, without their affinities. The embedding and
    /// the discontinuities follow.
    pub(crate) affinities: SymCsr,
    pub(crate) embedding: Embedding,
    pub(crate) discontinuities: Discontinuities,
    /// `None` without flow.
    pub(crate) salient: Option<Salient>,
    /// Connected pieces of the foreground; `None` without flow.
    pub(crate) components: Option<Components>,
    /// Trajectories that the components separate; `None` with connectedness off.
    pub(crate) separation: Option<Separation>,
    pub(crate) clusters: Clusters,
    /// One element per finished frame.
    pub(crate) superpixels: Vec<Superpixels>,
    /// `None` without flow.
    pub(crate) camera: Option<Camera>,
    /// `None` unless clips are judged by it.
    pub(crate) background: Option<Background>,
    /// Per trajectory, what speaks against its cluster being an object, although it is one; empty where nothing does.
    pub(crate) doubts: Vec<f32>,
    pub(crate) cut: Cut,
    /// One element per finished frame.
    pub(crate) masks: Vec<Plane<u8>>,
    pub(crate) corrections: Corrections,
}

/// The trajectories of a clip.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tracked {
    /// In working pixels.
    pub(crate) tracks: Trajectories,
    /// The same in input pixels.
    pub(crate) input: Trajectories,
    /// The clip-wide number of each.
    pub(crate) numbers: Vec<u32>,
    /// The same in working pixels with what is remembered from before the window; `None` where nothing is.
    pub(crate) with_past: Option<Trajectories>,
    /// Denser and shorter ones that masks are made from, in working pixels; `None` without masks.
    pub(crate) denser: Option<Trajectories>,
}

impl Tracked {
    /// Trajectories from outside, in input pixels.
    pub(crate) fn given(input: Trajectories, scale: Scale) -> Self {
        let tracks = scale.to_working(&input);
        let numbers = (0..tracks.len() as u32).collect();
        Self { tracks, input, numbers, with_past: None, denser: None }
    }

    /// The trajectories with all that is remembered of their past.
    pub(crate) fn with_past(&self) -> &Trajectories {
        self.with_past.as_ref().unwrap_or(&self.tracks)
    }
}

/// What stands out by its motion.
#[derive(Debug, Clone)]
pub(crate) struct Salient {
    pub(crate) maps: SaliencyMaps,
    /// The greatest saliency of each of the denser trajectories.
    pub(crate) of_denser: Vec<f32>,
    pub(crate) saliency: Saliency,
}

/// A cluster for each superpixel, and which clusters are which objects.
#[derive(Debug, Clone, Default)]
pub(crate) struct Cut {
    pub(crate) labels: CutLabels,
    pub(crate) objects: Objects,
    /// Shared with the snapshots before corrections.
    pub(crate) ground: Arc<CutGround>,
    /// Made when first asked for.
    pub(crate) sureness: OnceLock<Sureness>,
}

/// The terms of confidence.
#[derive(Debug, Clone)]
pub(crate) struct Sureness {
    /// How much dearer another mask label is for each superpixel, in units of cost.
    pub(crate) margins: Vec<f32>,
    /// What the background says for an object, the mean over each mask label.
    pub(crate) cue: [f32; 256],
}

/// What the cut was made from, as far as it is not kept elsewhere: to say why.
#[derive(Debug, Clone, Default)]
pub(crate) struct CutGround {
    /// The labels of the denser trajectories; `None` without them.
    pub(crate) voted: Option<Vec<u32>>,
    /// Whether each cluster is an object.
    pub(crate) is_object: Vec<bool>,
    /// What the background says for an object in each superpixel; empty without one.
    pub(crate) cues: Vec<f32>,
    /// The same with what objects look like.
    pub(crate) evidence: Vec<f32>,
    /// What a correction cut again; `None` for the first cut.
    pub(crate) region: Option<CutRegion>,
}

/// What a correction cuts again.
#[derive(Debug, Clone)]
pub(crate) struct CutRegion {
    /// Which clusters could be given and taken.
    pub(crate) open: Vec<bool>,
    /// Superpixels under strokes: frame, superpixel, and whether each cluster was legal.
    pub(crate) held: Vec<(usize, u32, Vec<bool>)>,
}

/// The corrections in force.
#[derive(Debug, Clone, Default)]
pub(crate) struct Corrections {
    /// Snapshots from before each correction, the first correction first.
    before: Vec<Snapshot>,
    /// What strokes hold.
    pub(crate) held: Vec<Held>,
}

/// The outputs that a correction changes, masks in little memory.
#[derive(Debug, Clone)]
struct Snapshot {
    clusters: Clusters,
    cut: Cut,
    masks: Vec<Runs<u8>>,
    held: Vec<Held>,
}

impl Corrections {
    /// Number of corrections.
    pub(crate) fn count(&self) -> usize {
        self.before.len()
    }
}

impl Outputs {
    /// What clusters are compared by. Without flow the camera is held to stand still.
    pub(crate) fn known<'a>(&'a self, params: &'a AffinityParams) -> EvidenceInput<'a> {
        let maps = self.salient.as_ref().map(|salient| &salient.maps);
        EvidenceInput::new(&self.tracked.tracks, &self.discontinuities, params, maps, self.separation.as_ref())
    }

    /// What a cut is made from; `voted` has the labels of the denser trajectories.
    pub(crate) fn input_of_cut<'a>(
        &'a self,
        voted: Option<&'a [u32]>,
        is_object: &'a [bool],
        evidence: &'a [f32],
    ) -> CutInput<'a> {
        CutInput {
            superpixels: &self.superpixels,
            tracks: self.tracked.denser.as_ref().unwrap_or(&self.tracked.tracks),
            label: voted.unwrap_or(&self.clusters.label),
            num_labels: self.clusters.count.max(1),
            objects: is_object,
            evidence,
        }
    }

    /// What the cut in force was made from.
    pub(crate) fn cut_input(&self) -> CutInput<'_> {
        let ground = &*self.cut.ground;
        self.input_of_cut(ground.voted.as_deref(), &ground.is_object, &ground.evidence)
    }

    /// The mask label of a cluster; a clip without clusters is all background.
    pub(crate) fn label_of(&self, cluster: u32) -> u8 {
        self.cut.objects.of_cluster.get(cluster as usize).copied().unwrap_or(0)
    }

    /// Remembers all that a correction changes.
    pub(crate) fn remember(&mut self) {
        self.corrections.before.push(Snapshot {
            clusters: self.clusters.clone(),
            cut: self.cut.clone(),
            masks: self.masks.iter().map(Runs::of).collect(),
            held: self.corrections.held.clone(),
        });
    }

    /// Restores what was before the last correction, also while its masks are being made; false without a correction.
    pub(crate) fn restore(&mut self) -> bool {
        let Some(Snapshot { clusters, cut, masks, held }) = self.corrections.before.pop() else { return false };
        (self.clusters, self.cut, self.corrections.held) = (clusters, cut, held);
        self.masks = masks.iter().map(Runs::plane).collect();
        true
    }
}
