//! Which clusters move before a scene that stands still.

use crate::cut::STRANGER;
use crate::discretize::{Clusters, canonical};
use crate::trajectory::Trajectories;

/// A trajectory that ends this far from where it began, in pixels, is as much an object's as the scene's.
const HALF: f32 = 1.0;
/// A cluster is an object if its trajectories have this mean of `r² / (r² + half²)`.
const MOVING: f32 = 0.5;
/// And if its trajectories are at least this far from the plate, in the mean: leaves and clouds move as much, over what
/// looks like them.
const SHOWN: f32 = 0.12;
/// A trajectory that moves less surely than this rests, and this share of all rests where the ground is tracked.
const RESTING: f32 = 0.2;
const TRACKED: f32 = 0.25;
/// Mean distance from the plate of what is the plate itself.
const SAME: f32 = 0.08;
/// A cluster that is like the plate with more than this part of its points is all ground; with less than this, none.
const ALL_GROUND: f32 = 0.9;
const HALF_GROUND: f32 = 0.5;
/// A trajectory of the scene's clusters that moves at least so much, so far from the plate, is none of the scene.
const ASTRAY: f32 = 0.8;
const FAR: f32 = 0.4;
/// One that moves as surely as this, by seven pixels, needs no more than this distance.
const SURELY: f32 = 0.98;
const LEAST_FAR: f32 = 0.02;

/// Clusters of a clip whose camera stands still.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Parted {
    /// The clusters, with what does not belong to them in clusters of its own.
    pub(crate) clusters: Clusters,
    /// Whether each is an object.
    pub(crate) is_object: Vec<bool>,
}

/// Tells moving clusters from the scene. `along` is how far the plate is along each trajectory, 0 to 1.
///
/// Where hardly any trajectory rests, the ground is too plain to be tracked and flow follows what moves before it:
/// trajectories along which the plate never changes are the ground's then, and a cluster of their own; clusters that are
/// nearly all of this kind go there whole, and those of which less than half is stay. In clusters of
/// the scene, trajectories that move far from the plate are taken out, into one cluster.
pub(crate) fn part(tracks: &Trajectories, clusters: &Clusters, along: &[f32]) -> Parted {
    let (ground, astray) = (clusters.count as u32, clusters.count as u32 + 1);
    let Motion { moved, is_tracked, far } = Motion::of(tracks);
    let is_plate = |i: usize| !is_tracked && along[i] < SAME;
    let grounded = means(tracks, clusters, |i| Some(f32::from(u8::from(is_plate(i)))));
    let of_ground = |i: usize| grounded[clusters.label[i] as usize];
    let is_ground = |i: usize| of_ground(i) > ALL_GROUND || is_plate(i) && of_ground(i) > HALF_GROUND;
    let moves = means(tracks, clusters, |i| (!is_ground(i)).then_some(moved[i]));
    let shown = means(tracks, clusters, |i| (!is_ground(i)).then_some(along[i]));
    let mut label = clusters.label.clone();
    for (i, label) in label.iter_mut().enumerate() {
        if is_ground(i) {
            *label = ground;
        } else if moves[*label as usize] < MOVING && strays(moved[i], along[i], far) {
            *label = astray;
        }
    }
    let mut is_object: Vec<bool> = moves.iter().zip(&shown).map(|(&m, &s)| m >= MOVING && s >= SHOWN).collect();
    is_object.extend([false, true]);
    let clusters = canonical(tracks, label.clone());
    let mut renamed = vec![false; clusters.count];
    for (&new, &old) in clusters.label.iter().zip(&label) {
        renamed[new as usize] = is_object[old as usize];
    }
    Parted { clusters, is_object: renamed }
}

/// The same for denser trajectories, which took the labels of those around them: flow that follows what moves nearby
/// makes ground and object alike. Who moves far from the plate with the scene's label becomes a stranger.
pub(crate) fn correct(label: &mut [u32], tracks: &Trajectories, along: &[f32], is_object: &[bool]) {
    let Motion { moved, is_tracked, far } = Motion::of(tracks);
    let is_scene = |label: u32| is_object.get(label as usize) == Some(&false);
    let mut counts = vec![0_u32; is_object.len()];
    for (&label, _) in label.iter().zip(along).filter(|&(&l, &a)| is_scene(l) && a < SAME) {
        counts[label as usize] += 1;
    }
    let ground = (0..counts.len()).rev().max_by_key(|&l| counts[l]).filter(|&l| counts[l] > 0);
    for (i, label) in label.iter_mut().enumerate() {
        match ground {
            Some(ground) if !is_tracked && along[i] < SAME => *label = ground as u32,
            _ if is_scene(*label) && strays(moved[i], along[i], far) => *label = STRANGER,
            _ => {}
        }
    }
}

/// Whether a trajectory that has the scene's label is none of the scene: it moves, and shows something else than the
/// plate; the further it moves, the less so.
fn strays(moved: f32, along: f32, far: f32) -> bool {
    moved > ASTRAY && along > far || moved > SURELY && along > LEAST_FAR
}

/// What trajectories do before a scene that stands still.
struct Motion {
    /// How surely each moves.
    moved: Vec<f32>,
    /// Whether the ground is tracked.
    is_tracked: bool,
    /// Distance from the plate that is not the scene's.
    far: f32,
}

impl Motion {
    fn of(tracks: &Trajectories) -> Self {
        let moved: Vec<f32> = (0..tracks.len()).map(|i| moved(tracks, i)).collect();
        let resting = moved.iter().filter(|&&m| m < RESTING).count();
        let is_tracked = resting as f32 >= TRACKED * moved.len() as f32;
        Self { moved, is_tracked, far: if is_tracked { FAR } else { SAME } }
    }
}

/// The trajectories that surely move.
pub(super) fn moving(tracks: &Trajectories) -> impl Iterator<Item = usize> {
    (0..tracks.len()).filter(|&i| moved(tracks, i) > SURELY)
}

/// How surely a trajectory moves, 0 to 1, by how far from its beginning it ends: what only sways comes back.
fn moved(tracks: &Trajectories, i: usize) -> f32 {
    let points = tracks.points(i);
    let (first, last) = (points.start, points.end - 1);
    let away = (tracks.x[last] - tracks.x[first]).powi(2) + (tracks.y[last] - tracks.y[first]).powi(2);
    away / (away + HALF * HALF)
}

/// The mean of a number over the points of each cluster's trajectories that have one.
fn means(tracks: &Trajectories, clusters: &Clusters, of: impl Fn(usize) -> Option<f32>) -> Vec<f32> {
    let mut sums = vec![(0.0, 0.0); clusters.count];
    for (i, &c) in clusters.label.iter().enumerate() {
        if let Some(value) = of(i) {
            let (count, sum) = (tracks.points(i).len() as f32, &mut sums[c as usize]);
            *sum = (sum.0 + count * value, sum.1 + count);
        }
    }
    sums.iter().map(|&(sum, count): &(f32, f32)| sum / count.max(1.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Trajectories of eleven frames that move by so many pixels in all.
    fn tracks(ways: &[f32]) -> Trajectories {
        let mut tracks = Trajectories::empty(11, (100, 100));
        for (k, way) in ways.iter().enumerate() {
            tracks.push(0, (0..11).map(|t| (10.0 + way * t as f32 / 10.0, 9.0 * k as f32, 0.0)));
        }
        tracks
    }

    #[test]
    fn what_moves_is_an_object_whatever_its_place() {
        let clusters = Clusters { count: 2, label: vec![0, 0, 0, 1, 1] };
        let found = part(&tracks(&[0.1, 0.2, 0.0, 30.0, 30.0]), &clusters, &[0.0, 0.0, 0.0, 0.9, 0.02]);
        // A plain object is like the plate in places, and stays one thing.
        assert_eq!(found, Parted { clusters, is_object: vec![false, true] });
    }

    #[test]
    fn what_sways_over_its_like_is_none() {
        let clusters = Clusters { count: 2, label: vec![0, 0, 0, 1, 1] };
        let found = part(&tracks(&[0.1, 0.2, 0.0, 3.0, -3.0]), &clusters, &[0.0, 0.0, 0.0, 0.04, 0.02]);
        assert_eq!(found, Parted { clusters, is_object: vec![false, false] });
    }

    #[test]
    fn where_all_clusters_move_the_ground_is_what_stays_like_the_plate() {
        let clusters = Clusters { count: 2, label: vec![0, 0, 0, 1, 1] };
        let found = part(&tracks(&[20.0, 20.0, 20.0, 30.0, 30.0]), &clusters, &[0.0, 0.01, 0.9, 0.9, 0.8]);
        // What moves far from the plate in the ground's own cluster is taken out of it.
        let is_object: Vec<bool> = found.clusters.label.iter().map(|&c| found.is_object[c as usize]).collect();
        assert_eq!(is_object, [false, false, true, true, true], "{found:?}");
    }

    #[test]
    fn who_moves_among_the_scene_far_from_the_plate_is_none_of_it() {
        let clusters = Clusters { count: 1, label: vec![0; 4] };
        let found = part(&tracks(&[0.0, 0.1, 0.0, 25.0]), &clusters, &[0.0, 0.0, 0.0, 0.8]);
        assert_eq!(found.clusters.label, [0, 0, 0, 1]);
        assert_eq!(found.is_object, [false, true]);
    }

    #[test]
    fn who_moves_far_among_the_scene_may_be_nearly_like_the_plate() {
        let clusters = Clusters { count: 1, label: vec![0; 4] };
        let found = part(&tracks(&[0.0, 4.0, 0.0, 25.0]), &clusters, &[0.0, 0.1, 0.0, 0.1]);
        assert_eq!(found.clusters.label, [0, 0, 0, 1]);
    }

    #[test]
    fn every_cluster_has_a_trajectory() {
        for along in [0.0, 0.5, 1.0] {
            let clusters = Clusters { count: 2, label: vec![0, 1, 0] };
            let found = part(&tracks(&[9.0, 9.0, 9.0]), &clusters, &[along; 3]);
            assert_eq!(found.is_object.len(), found.clusters.count);
            assert!((0..found.clusters.count as u32).all(|c| found.clusters.label.contains(&c)));
        }
        let none = part(&tracks(&[]), &Clusters::default(), &[]);
        assert_eq!((none.clusters.count, none.is_object.len()), (0, 0));
    }
}
