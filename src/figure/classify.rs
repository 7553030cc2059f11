//! Classification of clusters as objects or scene, by the background model.

use crate::background::{Background, ObjectClusters, segment_rigid_scene};
use crate::cut::{OUTLIER, UNKNOWN, propagate_labels};
use crate::discretize::Clusters;
use crate::evidence::{ClusterCues, EvidenceInput, cluster_motions};
use crate::objects::cluster_cues;
use crate::trajectory::Trajectories;

/// Least log-odds of an object. Chosen by eye, below 0: the pixels of an uncertain cluster decide later.
const MIN_LOG_ODDS: f64 = -2.0;

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

    /// Classifies clusters by their log-odds to be objects.
    pub(crate) fn classify(&self, clusters: &Clusters, log_odds: &[f64]) -> Classification {
        let penalty = |value: f64| if value > MIN_LOG_ODDS { -value.min(0.0) as f32 } else { 0.0 };
        Classification {
            clusters: clusters.clone(),
            is_object: log_odds.iter().map(|&v| v > MIN_LOG_ODDS).collect(),
            label: self.propagate_labels(clusters),
            penalties: clusters.label.iter().map(|&l| penalty(log_odds[l as usize])).collect(),
        }
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
    match rigid_scene_clusters(background, observations) {
        Some(ObjectClusters { clusters, is_object }) => {
            let label = observations.propagate_labels(&clusters);
            Classification { clusters, is_object, label, penalties: Vec::new() }
        }
        None => observations.classify(clusters, &cluster_log_odds(background, clusters, observations.clustered)),
    }
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
    let objects =
        segment_rigid_scene(background.forward()?, tracks, &discontinuities.neighborhoods, observations.max_edge);
    objects.is_object.contains(&false).then_some(objects)
}

/// Computes the log-odds of each cluster to be an object.
fn cluster_log_odds(background: &Background, clusters: &Clusters, input: &EvidenceInput<'_>) -> Vec<f64> {
    let has_scene = |log_odds: &[f64]| log_odds.iter().any(|&v| v <= MIN_LOG_ODDS);
    let motions = cluster_motions(&clusters.label, input);
    let cues = cluster_cues(input.tracks, clusters, &motions).into_iter();
    let mut log_odds: Vec<f64> = cues.map(|cues| cues.log_odds()).collect();
    if let Some((scene, stillness)) = background.still() {
        let distances = scene.plate_distances(input.tracks, clusters);
        let by_plate = distances.into_iter().map(|plate_distance| ClusterCues::Still { plate_distance }.log_odds());
        let share = f64::from(stillness);
        let both: Vec<f64> =
            log_odds.iter().zip(by_plate).map(|(border, plate)| (1.0 - share) * border + share * plate).collect();
        // If all clusters were objects, no label would be left for the scene: then the frame border decides.
        if has_scene(&both) {
            log_odds = both;
        }
    }
    // For the same reason the least likely object is the scene then.
    let least = (0..log_odds.len()).min_by(|&a, &b| log_odds[a].total_cmp(&log_odds[b]));
    if let Some(least) = least.filter(|_| !has_scene(&log_odds)) {
        log_odds[least] = f64::NEG_INFINITY;
    }
    log_odds
}
