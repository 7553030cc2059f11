//! Classification of clusters as objects or scene, by the background model.

use crate::background::{Background, ObjectClusters, segment_rigid_scene};
use crate::cut::{OUTLIER, UNKNOWN, propagate_labels};
use crate::discretize::Clusters;
use crate::evidence::{ClusterCues, EvidenceInput, motion_contrasts};
use crate::objects::cluster_cues;
use crate::trajectory::Trajectories;

/// Least log-odds of an object. Chosen by eye, below 0: the pixels of an uncertain cluster decide later.
const MIN_LOG_ODDS: f64 = -1.5;

/// Trajectories of a clip, and the lengths by which their clusters are classified.
#[derive(Debug, Clone, Copy)]
pub struct Observations<'a> {
    /// The clustered trajectories, their neighbours and the motion of the camera.
    pub clustered: &'a EvidenceInput<'a>,
    /// Denser trajectories, which masks are made from.
    pub denser: &'a Trajectories,
    /// Greatest saliency of each of the denser ones, 0 to 1; empty without flow.
    pub saliency: &'a [f32],
    /// Trajectories of more saliency than this are salient.
    pub saliency_threshold: f64,
    /// Longest edge between trajectories of one object, in pixels.
    pub max_edge: f32,
    /// Clustered trajectories within this distance vote on the labels of denser ones, in pixels.
    pub vote_radius: f32,
}

/// Clusters, and which of them are objects.
#[derive(Debug, Clone, PartialEq)]
pub struct Classification {
    /// The clusters, which may differ from the classified ones.
    pub clusters: Clusters,
    /// `true` for each cluster that is an object.
    pub is_object: Vec<bool>,
    /// The cluster of each of the denser trajectories, `u32::MAX` if it is unknown, or
    /// `u32::MAX - 1` if it moves unlike all around it.
    pub label: Vec<u32>,
    /// Log-odds against the cluster of each clustered trajectory, at least 0; empty if all are certain.
    pub penalties: Vec<f32>,
}

impl Observations<'_> {
    /// Labels the denser trajectories by the clustered ones around them.
    pub(crate) fn propagate_labels(&self, clusters: &Clusters) -> Vec<u32> {
        let count = clusters.count.max(1);
        let mut label = propagate_labels(self.denser, self.clustered.tracks, &clusters.label, count, self.vote_radius);
        // Outliers that are not salient are errors of the flow.
        for (label, &saliency) in label.iter_mut().zip(self.saliency) {
            if *label == OUTLIER && f64::from(saliency) <= self.saliency_threshold {
                *label = UNKNOWN;
            }
        }
        label
    }
}

/// Classifies clusters as objects or scene.
///
/// With a forward camera, tracks that violate the rigid scene form clusters of their own.
#[must_use]
pub fn classify_clusters(
    background: &Background,
    clusters: &Clusters,
    observations: &Observations<'_>,
) -> Classification {
    let (ObjectClusters { clusters, is_object }, penalties) = match rigid_scene_clusters(background, observations) {
        Some(objects) => (objects, Vec::new()),
        None => {
            let log_odds = cluster_log_odds(background, clusters, observations.clustered);
            let penalty = |value: f64| if value > MIN_LOG_ODDS { -value.min(0.0) as f32 } else { 0.0 };
            let penalties = clusters.label.iter().map(|&l| penalty(log_odds[l as usize])).collect();
            let is_object = log_odds.iter().map(|&v| v > MIN_LOG_ODDS).collect();
            (ObjectClusters { clusters: clusters.clone(), is_object }, penalties)
        }
    };
    let label = observations.propagate_labels(&clusters);
    Classification { clusters, is_object, label, penalties }
}

/// Computes each cluster's mean penalty over its trajectories, 0 for clusters that are sure.
#[must_use]
pub fn cluster_penalties(clusters: &Clusters, penalties: &[f32], is_sure: impl Fn(usize) -> bool) -> Vec<f32> {
    let mut sums = vec![(0.0, 0.0); clusters.count];
    for (&l, &penalty) in clusters.label.iter().zip(penalties) {
        let sum = &mut sums[l as usize];
        *sum = (sum.0 + f64::from(penalty), sum.1 + 1.0);
    }
    let mean = |(c, (sum, count)): (usize, (f64, f64))| if is_sure(c) || count == 0.0 { 0.0 } else { sum / count };
    sums.into_iter().enumerate().map(|sum| mean(sum) as f32).collect()
}

/// Returns the moving objects before a rigid scene and the scene; `None` unless the camera goes forward and some tracks are
/// the scene's.
fn rigid_scene_clusters(background: &Background, observations: &Observations<'_>) -> Option<ObjectClusters> {
    let EvidenceInput { tracks, discontinuities, .. } = observations.clustered;
    let Background::Forward(motion, _) = background else { return None };
    let objects = segment_rigid_scene(motion, tracks, &discontinuities.neighborhoods, observations.max_edge);
    objects.is_object.contains(&false).then_some(objects)
}

/// Computes the log-odds of each cluster to be an object.
fn cluster_log_odds(background: &Background, clusters: &Clusters, input: &EvidenceInput<'_>) -> Vec<f64> {
    let log_odds = |cues: Vec<ClusterCues>| -> Vec<f64> { cues.iter().map(ClusterCues::log_odds).collect() };
    let has_scene = |log_odds: &[f64]| log_odds.iter().any(|&v| v <= MIN_LOG_ODDS);
    if let Background::Still(scene) = background {
        let cues = scene.plate_distances(input.tracks, clusters).into_iter();
        let by_plate = log_odds(cues.map(|plate_distance| ClusterCues::Still { plate_distance }).collect());
        // If all clusters were objects, no label would be left for the scene: then the frame border decides.
        if has_scene(&by_plate) {
            return by_plate;
        }
    }
    let contrasts = motion_contrasts(&clusters.label, input);
    let mut by_border = log_odds(cluster_cues(input.tracks, clusters, &contrasts));
    // For the same reason the least likely object is the scene then.
    let least = (0..by_border.len()).min_by(|&a, &b| by_border[a].total_cmp(&by_border[b]));
    if let Some(least) = least.filter(|_| !has_scene(&by_border)) {
        by_border[least] = f64::NEG_INFINITY;
    }
    by_border
}
