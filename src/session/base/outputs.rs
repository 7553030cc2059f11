//! Outputs of the stages: plain data that a run extends stage by stage and everything else reads.

use super::scale::Scale;
use crate::affinity::AffinityParams;
use crate::background::Background;
use crate::camera::Camera;
use crate::connectedness::{Components, Separation};
use crate::correction::StrokeConstraint;
use crate::cut::{ClipFeatures, CutInput, CutLabels};
use crate::discontinuity::Discontinuities;
use crate::discretize::Clusters;
use crate::embedding::Embedding;
use crate::evidence::EvidenceInput;
use crate::image::{Plane, Runs};
use crate::mask::{Agreement, attach_loose_parts};
use crate::objects::Objects;
use crate::saliency::{Saliency, SaliencyMaps};
use crate::sparse::SymCsr;
use crate::superpixel::Superpixels;
use crate::trajectory::Trajectories;
use std::sync::{Arc, OnceLock};

/// The outputs of a run, at working size. A stage's outputs are complete once the run is past it; superpixels and masks
/// can be read frame by frame before.
#[derive(Debug, Clone, Default)]
pub(crate) struct Outputs {
    pub(crate) track_set: TrackSet,
    /// From motion alone at first; without the affinities between separated trajectories once the foreground is known.
    /// The embedding and the discontinuities follow.
    pub(crate) affinities: SymCsr,
    pub(crate) embedding: Embedding,
    pub(crate) discontinuities: Discontinuities,
    /// `None` without flow.
    pub(crate) saliency: Option<SaliencyOutputs>,
    /// Connected components of the foreground; `None` without flow.
    pub(crate) components: Option<Components>,
    /// Trajectories that the components separate; `None` with connectedness off.
    pub(crate) separation: Option<Separation>,
    pub(crate) clusters: Clusters,
    /// One element per finished frame.
    pub(crate) superpixels: Vec<Superpixels>,
    /// Features of the superpixels, for models of appearance.
    pub(crate) features: ClipFeatures,
    /// `None` without flow.
    pub(crate) camera: Option<Camera>,
    /// `None` with `background.enabled` off.
    pub(crate) background: Option<Background>,
    /// Evidence per trajectory against its cluster being an object, although it was selected; may be empty.
    pub(crate) penalties: Vec<f32>,
    pub(crate) cut: Cut,
    /// One element per finished frame.
    pub(crate) masks: Vec<Plane<u8>>,
    pub(crate) corrections: Corrections,
}

/// The trajectories of a clip.
#[derive(Debug, Clone, Default)]
pub(crate) struct TrackSet {
    /// In working pixels.
    pub(crate) tracks: Trajectories,
    /// The same in input pixels.
    pub(crate) input: Trajectories,
    /// The clip-wide number of each.
    pub(crate) numbers: Vec<u32>,
    /// The same in working pixels with their points from before the window; `None` if there are none.
    pub(crate) with_past: Option<Trajectories>,
    /// Denser and shorter trajectories that masks are made from, in working pixels; `None` without masks.
    pub(crate) mask_tracks: Option<Trajectories>,
}

impl TrackSet {
    /// Trajectories of another tracker, in input pixels.
    pub(crate) fn external(input: Trajectories, scale: Scale) -> Self {
        let tracks = scale.to_working(&input);
        let numbers = (0..tracks.len() as u32).collect();
        Self { tracks, input, numbers, with_past: None, mask_tracks: None }
    }

    /// Returns the trajectories with their points from before the window.
    pub(crate) fn with_past(&self) -> &Trajectories {
        self.with_past.as_ref().unwrap_or(&self.tracks)
    }

    /// Returns the densest trajectories there are.
    pub(crate) fn densest(&self) -> &Trajectories {
        self.mask_tracks.as_ref().unwrap_or(&self.tracks)
    }
}

/// Outputs of the saliency stage.
#[derive(Debug, Clone)]
pub(crate) struct SaliencyOutputs {
    pub(crate) maps: SaliencyMaps,
    pub(crate) tracks: Saliency,
    /// The maximum over the points of each mask trajectory.
    pub(crate) mask_tracks: Vec<f32>,
}

/// The cluster of each superpixel, and the objects that clusters belong to.
#[derive(Debug, Clone, Default)]
pub(crate) struct Cut {
    pub(crate) labels: CutLabels,
    pub(crate) objects: Objects,
    /// Shared with the snapshots before corrections.
    pub(crate) context: Arc<CutContext>,
    /// The agreement of the masks made from this cut; computed on first use.
    pub(crate) agreement: OnceLock<Agreement>,
}

impl Cut {
    /// Returns the mask of frame `t` before its borders are refined.
    pub(crate) fn coarse_mask(&self, superpixels: &Superpixels, t: usize) -> Plane<u8> {
        let labels: Vec<u8> = self.labels.labels[t].iter().map(|&cluster| self.mask_label(cluster)).collect();
        superpixels.runs().map(|p| labels[p as usize])
    }

    /// Returns the mask label of a cluster; a clip without clusters is all background.
    fn mask_label(&self, cluster: u32) -> u8 {
        self.objects.of_cluster.get(cluster as usize).copied().unwrap_or(0)
    }
}

/// Inputs of the cut that are not kept elsewhere, to explain its result.
#[derive(Debug, Clone, Default)]
pub(crate) struct CutContext {
    /// The clusters of the mask trajectories; `None` without them.
    pub(crate) mask_track_labels: Option<Vec<u32>>,
    /// True for each cluster that is an object.
    pub(crate) is_object: Vec<bool>,
    /// Background evidence for an object in each superpixel; empty without a background.
    pub(crate) evidence: Vec<f32>,
    /// Evidence by appearance, as log-odds; empty without objects.
    pub(crate) appearance: Vec<f32>,
    /// The part that a correction cut again; `None` for the first cut.
    pub(crate) region: Option<CutRegion>,
}

/// The part of the clip that a correction cuts again.
#[derive(Debug, Clone)]
pub(crate) struct CutRegion {
    /// True for each cluster whose superpixels may change their label.
    pub(crate) is_open: Vec<bool>,
    /// Superpixels under strokes: frame, superpixel, and whether each cluster is allowed.
    pub(crate) allowed: Vec<(usize, u32, Vec<bool>)>,
}

/// The corrections in force.
#[derive(Debug, Clone, Default)]
pub(crate) struct Corrections {
    /// Snapshots from before each correction, oldest first.
    snapshots: Vec<Snapshot>,
    pub(crate) constraints: Vec<StrokeConstraint>,
}

/// The outputs that a correction changes, with run-length coded masks.
#[derive(Debug, Clone)]
struct Snapshot {
    clusters: Clusters,
    cut: Cut,
    masks: Vec<Runs<u8>>,
    constraints: Vec<StrokeConstraint>,
}

impl Corrections {
    /// Number of corrections.
    pub(crate) fn count(&self) -> usize {
        self.snapshots.len()
    }
}

impl Outputs {
    /// Collects what clusters are compared by. Without flow the camera is assumed to be still.
    pub(crate) fn cluster_evidence<'a>(&'a self, params: &'a AffinityParams) -> EvidenceInput<'a> {
        let maps = self.saliency.as_ref().map(|saliency| &saliency.maps);
        EvidenceInput::new(&self.track_set.tracks, &self.discontinuities, params, maps, self.separation.as_ref())
    }

    /// Returns the input of a cut with these labels of the mask trajectories.
    pub(crate) fn cut_input_with<'a>(
        &'a self,
        mask_track_labels: Option<&'a [u32]>,
        is_object: &'a [bool],
        evidence: &'a [f32],
        appearance: &'a [f32],
    ) -> CutInput<'a> {
        CutInput {
            superpixels: &self.superpixels,
            tracks: self.track_set.densest(),
            label: mask_track_labels.unwrap_or(&self.clusters.label),
            num_labels: self.clusters.count.max(1),
            objects: is_object,
            evidence,
            appearance,
        }
    }

    /// Returns the input of the present cut.
    pub(crate) fn cut_input(&self) -> CutInput<'_> {
        let context = &*self.cut.context;
        self.cut_input_with(
            context.mask_track_labels.as_deref(),
            &context.is_object,
            &context.evidence,
            &context.appearance,
        )
    }

    /// Returns the mask label of a cluster; a clip without clusters is all background.
    pub(crate) fn mask_label(&self, cluster: u32) -> u8 {
        self.cut.mask_label(cluster)
    }

    /// Gives loose parts of a mask of frame `t` to what surrounds them ([`attach_loose_parts`]).
    pub(crate) fn attach_loose_parts(
        &self,
        mask: &mut Plane<u8>,
        t: usize,
        min_share: f32,
        is_fixed: impl Fn(usize, u8) -> bool,
    ) {
        attach_loose_parts(mask, t, &self.cut_input(), &self.cut.objects.of_cluster, min_share, is_fixed);
    }

    /// Saves all that a correction changes.
    pub(crate) fn push_snapshot(&mut self) {
        self.corrections.snapshots.push(Snapshot {
            clusters: self.clusters.clone(),
            cut: self.cut.clone(),
            masks: self.masks.iter().map(Runs::from_plane).collect(),
            constraints: self.corrections.constraints.clone(),
        });
    }

    /// Undoes the last correction, also while its masks are being made; false without a correction.
    pub(crate) fn pop_snapshot(&mut self) -> bool {
        let Some(Snapshot { clusters, cut, masks, constraints }) = self.corrections.snapshots.pop() else {
            return false;
        };
        (self.clusters, self.cut, self.corrections.constraints) = (clusters, cut, constraints);
        self.masks = masks.iter().map(Runs::to_plane).collect();
        true
    }
}
