//! Figure and ground: which clusters are objects, by what the background tells of them.

use crate::background::{Background, BackgroundParams, Clustering, Parted, part_rigid, stand_out};
use crate::cut::{forget_strangers, labels_for};
use crate::discretize::Clusters;
use crate::evidence::{Known, Signs, strangeness};
use crate::objects::signs;
use crate::trajectory::Trajectories;

/// Least log-odds of an object: what is doubted may still be one, and its pixels decide.
const MIN_LOG_ODDS: f64 = -1.5;

/// The trajectories of a clip, as clusters of them are judged.
#[derive(Debug, Clone, Copy)]
pub struct Observations<'a> {
    /// The clustered trajectories, their neighbours and the motion of the camera.
    pub known: &'a Known<'a>,
    /// Denser trajectories, which masks are made from.
    pub denser: &'a Trajectories,
    /// Greatest saliency of each of the denser ones, 0 to 1; empty without flow.
    pub saliency: &'a [f32],
    /// Trajectories of more saliency than this stand out.
    pub saliency_threshold: f64,
    /// Longest edge between trajectories of one object, in pixels.
    pub max_edge: f32,
    /// Clustered trajectories within this distance vote on the labels of denser ones, in pixels.
    pub vote_radius: f32,
    /// Distance between neighbours of the denser ones, in pixels.
    pub spacing: f32,
}

/// Clusters, and which of them are objects.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// The labels of the clustered trajectories; not always those that were judged.
    pub clusters: Clusters,
    /// Whether each cluster is an object.
    pub is_object: Vec<bool>,
    /// The cluster of each of the denser trajectories, or one of [`UNKNOWN`](crate::cut::UNKNOWN) and
    /// [`STRANGER`](crate::cut::STRANGER).
    pub label: Vec<u32>,
    /// Log-odds against the cluster of each clustered trajectory, at least 0; empty where nothing speaks against any.
    pub doubts: Vec<f32>,
}

impl Observations<'_> {
    /// The labels of the denser trajectories by those of the clustered ones around them.
    pub(crate) fn propagate_labels(&self, clusters: &Clusters) -> Vec<u32> {
        let count = clusters.count.max(1);
        let mut label = labels_for(self.denser, self.known.tracks, &clusters.label, count, self.vote_radius);
        forget_strangers(&mut label, self.saliency, self.saliency_threshold);
        label
    }
}

/// Finds the clusters that are objects.
///
/// Where the camera goes forward, objects become clusters of their own, by what no rigid scene explains. Where no cluster
/// is an object, salient trajectories that move alike become some, unless the camera stands still.
#[must_use]
pub fn judge_clusters(
    background: &Background,
    clusters: &Clusters,
    observations: &Observations<'_>,
    params: &BackgroundParams,
) -> Figure {
    let (clusters, is_object, doubts) = match part_from_rigid_scene(background, observations) {
        Some(Parted { clusters, is_object }) => (clusters, is_object, Vec::new()),
        None => {
            let values = log_odds(background, clusters, observations.known);
            let doubt = |value: f64| if value > MIN_LOG_ODDS { -value.min(0.0) as f32 } else { 0.0 };
            let doubts = clusters.label.iter().map(|&l| doubt(values[l as usize])).collect();
            (clusters.clone(), values.iter().map(|&v| v > MIN_LOG_ODDS).collect(), doubts)
        }
    };
    let label = observations.propagate_labels(&clusters);
    if matches!(background, Background::Moving(_)) && params.salient_fallback && !is_object.contains(&true) {
        let Observations { known, denser, saliency, saliency_threshold, vote_radius, spacing, .. } = *observations;
        let salient: Vec<bool> = saliency.iter().map(|&s| f64::from(s) > saliency_threshold).collect();
        let before = Clustering { tracks: known.tracks, clusters: &clusters, radius: vote_radius };
        if let Some(found) = stand_out(&before, (denser, &label), &salient, spacing) {
            return Figure { clusters: found.clusters, is_object: found.is_object, label: found.voted, doubts };
        }
    }
    Figure { clusters, is_object, label, doubts }
}

/// The mean over each cluster of the doubts of its trajectories, 0 for those that are sure.
#[must_use]
pub fn cluster_doubts(clusters: &Clusters, doubts: &[f32], is_sure: impl Fn(usize) -> bool) -> Vec<f32> {
    let mut sums = vec![(0.0, 0.0); clusters.count];
    for (&l, &doubt) in clusters.label.iter().zip(doubts) {
        let sum = &mut sums[l as usize];
        *sum = (sum.0 + f64::from(doubt), sum.1 + 1.0);
    }
    let mean = |(c, (sum, count)): (usize, (f64, f64))| if is_sure(c) || count == 0.0 { 0.0 } else { sum / count };
    sums.into_iter().enumerate().map(|sum| mean(sum) as f32).collect()
}

/// Objects that no rigid scene explains; `None` unless the camera goes forward, and where nothing that was tracked belongs
/// to the scene.
fn part_from_rigid_scene(background: &Background, observations: &Observations<'_>) -> Option<Parted> {
    let Known { tracks, found, .. } = observations.known;
    let Background::Forward(travel, _) = background else { return None };
    let parted = part_rigid(travel, tracks, &found.neighborhoods, observations.max_edge);
    parted.is_object.contains(&false).then_some(parted)
}

/// The log-odds of each cluster to be an object.
fn log_odds(background: &Background, clusters: &Clusters, known: &Known<'_>) -> Vec<f64> {
    if let Background::Still(scene) = background {
        let unlike = scene.unlike_plate(known.tracks, clusters);
        let values: Vec<f64> = unlike.iter().map(|&unlike| Signs::Still { unlike }.value()).collect();
        // Where nothing that was tracked belongs to the scene, no label is left for it: the rim decides.
        if values.iter().any(|&v| v <= MIN_LOG_ODDS) {
            return values;
        }
    }
    let value = |signs: &Option<Signs>| signs.map_or(f64::NEG_INFINITY, |signs| signs.value());
    signs(known.tracks, clusters, &strangeness(&clusters.label, known)).iter().map(value).collect()
}
