//! Objects that no cluster shows: trajectories that stand out from the motion of the camera, next to each other and
//! alike.
//!
//! What is small or blurred has fewer long trajectories than a cluster needs, but it may have many short ones. Not in
//! the paper, which has no objects without clusters.

use crate::cut::{UNKNOWN, VOTE_MOTION, labels_for, motion_difference_sq};
use crate::discretize::{Clusters, canonical};
use crate::grid::Grid;
use crate::objects::find_objects_above;
use crate::sets::DisjointSets;
use crate::trajectory::Trajectories;

/// Trajectories are neighbours within this many times their spacing.
const REACH: f32 = 2.0;
/// Fewest trajectories in a frame, in the mean from the first to the last frame that has any.
const LEAST: usize = 8;
/// Least part of the clip's frames that these are.
const SEEN: f32 = 0.5;
/// What standing out is worth against the frame's rim, as log-odds.
const STANDS_OUT: f64 = 0.8;
/// Width of the frame's rim, as part of its shorter side. What lies there with three quarters may be a piece of the scene
/// that something near cuts off.
const RIM: f32 = 0.125;

/// Clustered trajectories.
pub(crate) struct Clustering<'a> {
    pub(crate) tracks: &'a Trajectories,
    pub(crate) clusters: &'a Clusters,
    /// How far away, in pixels, others ask them for a label.
    pub(crate) radius: f32,
}

/// Clusters with those that stand out among them.
pub(crate) struct StandOut {
    pub(crate) clusters: Clusters,
    /// The labels of the denser trajectories.
    pub(crate) voted: Vec<u32>,
    pub(crate) is_object: Vec<bool>,
}

/// Denser trajectories that stand out and move alike, as clusters of their own; they are `spacing` pixels apart, and
/// `salient` says which of them stand out. What has fewer trajectories than a cluster needs is found by them. `None` where
/// there are none.
pub(crate) fn stand_out(
    before: &Clustering<'_>,
    (denser, voted): (&Trajectories, &[u32]),
    salient: &[bool],
    spacing: f32,
) -> Option<StandOut> {
    let (found, new) = salient_objects(denser, salient, spacing);
    if new == 0 {
        return None;
    }
    let Clustering { tracks, clusters, radius } = *before;
    let count = clusters.count;
    let mut labels = voted.to_vec();
    for (label, found) in labels.iter_mut().zip(found) {
        *label = found.map_or(*label, |k| count as u32 + k);
    }
    // Of the clustered trajectories those have a new label that most around them have.
    let mut old = clusters.label.clone();
    let asked = labels_for(tracks, denser, &labels, count + new, radius);
    for (label, asked) in old.iter_mut().zip(asked) {
        let is_new = (count..count + new).contains(&(asked as usize));
        *label = if is_new { asked } else { *label };
    }
    let clusters = canonical(tracks, old.clone());
    let (mut renamed, mut is_object) = (vec![UNKNOWN; count + new], vec![false; clusters.count]);
    for (&old, &now) in old.iter().zip(&clusters.label) {
        renamed[old as usize] = now;
        is_object[now as usize] = old as usize >= count;
    }
    labels.iter_mut().for_each(|label| *label = renamed.get(*label as usize).copied().unwrap_or(*label));
    is_object.contains(&true).then_some(StandOut { clusters, voted: labels, is_object })
}

/// Groups of salient trajectories that are objects by the frame's rim: the group of each trajectory, and how many groups
/// there are. Trajectories are `spacing` pixels apart; neighbours in a group differ by less than those that vote may.
fn salient_objects(tracks: &Trajectories, salient: &[bool], spacing: f32) -> (Vec<Option<u32>>, usize) {
    let mut sets = alike(tracks, salient, REACH * spacing);
    let roots: Vec<usize> = (0..tracks.len()).map(|i| sets.root(i)).collect();
    let mut lives = vec![Life { points: 0, on_rim: 0, first: usize::MAX, end: 0 }; tracks.len()];
    let (right, bottom) = (tracks.size.0 as f32 - 1.0, tracks.size.1 as f32 - 1.0);
    let rim = RIM * (right.min(bottom) + 1.0);
    for (i, &root) in roots.iter().enumerate().filter(|&(i, _)| salient.get(i) == Some(&true)) {
        let (frames, life) = (tracks.frames(i), &mut lives[root]);
        (life.first, life.end) = (life.first.min(frames.start), life.end.max(frames.end));
        life.points += frames.len();
        for p in tracks.points(i) {
            let (x, y) = (tracks.x[p], tracks.y[p]);
            life.on_rim += usize::from(x.min(y).min(right - x).min(bottom - y) < rim);
        }
    }
    // Cluster 0 is all else.
    let large: Vec<usize> = (0..tracks.len()).filter(|&root| lives[root].is_object(tracks.num_frames)).collect();
    let label = roots.iter().map(|r| large.binary_search(r).map_or(0, |k| 1 + k as u32)).collect();
    let clusters = Clusters { count: 1 + large.len(), label };
    let objects = find_objects_above(tracks, &clusters, -STANDS_OUT);
    let mut number = vec![None; clusters.count];
    let mut count = 0;
    for (number, _) in number.iter_mut().zip(&objects.of_cluster).skip(1).filter(|(_, object)| **object > 0) {
        *number = Some(count);
        count += 1;
    }
    (clusters.label.iter().map(|&c| number[c as usize]).collect(), count as usize)
}

/// What the trajectories of a group come to.
#[derive(Clone)]
struct Life {
    points: usize,
    on_rim: usize,
    first: usize,
    /// The frame after the last.
    end: usize,
}

impl Life {
    fn is_object(&self, num_frames: usize) -> bool {
        let frames = self.end.saturating_sub(self.first);
        let is_seen = frames as f32 >= SEEN * num_frames as f32;
        4 * self.on_rim < 3 * self.points && is_seen && self.points >= LEAST * frames
    }
}

/// Salient trajectories in sets: two are in one that are near in some frame and move alike around it, and those that a
/// chain of such pairs leads to.
fn alike(tracks: &Trajectories, salient: &[bool], reach: f32) -> DisjointSets {
    let mut sets = DisjointSets::new(tracks.len());
    let mut grid = Grid::new(tracks.size.0, tracks.size.1, reach);
    for t in 0..tracks.num_frames {
        grid.clear();
        let here: Vec<_> = tracks.alive(t).filter(|&(i, ..)| salient.get(i) == Some(&true)).collect();
        here.iter().for_each(|&(i, x, y)| grid.add(i as u32, x, y));
        for &(i, x, y) in &here {
            for (j, _) in grid.nearby(x, y).filter(|&(j, d_sq)| j as usize > i && d_sq <= reach * reach) {
                let difference_sq = motion_difference_sq(tracks, i, tracks, j as usize, t);
                if difference_sq.is_some_and(|sq| sq < VOTE_MOTION * VOTE_MOTION) {
                    sets.join(i, j as usize);
                }
            }
        }
    }
    sets
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lattice of points four pixels apart, which moves; the salient ones inside the box by (2, 0) more.
    fn scene(inside: impl Fn(f32, f32) -> bool) -> (Trajectories, Vec<bool>) {
        let (mut tracks, mut salient) = (Trajectories::empty(6, (96, 64)), Vec::new());
        for (x, y) in (0..24 * 16).map(|k| ((4 * (k % 24) + 2) as f32, (4 * (k / 24) + 2) as f32)) {
            let own = inside(x, y);
            let speed = if own { 2.0 } else { 0.2 };
            tracks.push(
                0,
                (0..6).map(|t| t as f32).take_while(|t| x + speed * t < 96.0).map(|t| (x + speed * t, y, 0.0)),
            );
            salient.push(own);
        }
        (tracks, salient)
    }

    fn found(scene: &(Trajectories, Vec<bool>)) -> (Vec<Option<u32>>, usize) {
        salient_objects(&scene.0, &scene.1, 4.0)
    }

    #[test]
    fn what_stands_out_together_is_an_object() {
        let scene = scene(|x, y| (30.0..50.0).contains(&x) && (20.0..40.0).contains(&y));
        let (group, count) = found(&scene);
        assert_eq!(count, 1);
        assert!(group.iter().zip(&scene.1).all(|(group, &salient)| *group == salient.then_some(0)));
    }

    #[test]
    fn two_apart_or_of_different_motion_are_two() {
        let apart = scene(|x, y| !(40.0..56.0).contains(&x) && (12.0..84.0).contains(&x) && (20.0..40.0).contains(&y));
        assert_eq!(found(&apart).1, 2);
        let (mut tracks, salient) = scene(|x, y| (20.0..60.0).contains(&x) && (20.0..40.0).contains(&y));
        let mut other = Trajectories::empty(6, (96, 64));
        for i in 0..tracks.len() {
            let upper = salient[i] && tracks.y[tracks.points(i).start] < 30.0;
            let rise = if upper { 1.0 } else { 0.0 };
            let points = tracks.points(i).enumerate();
            other.push(0, points.map(|(t, p)| (tracks.x[p], tracks.y[p] - rise * t as f32, 0.0)));
        }
        tracks = other;
        assert_eq!(found(&(tracks, salient)).1, 2);
    }

    #[test]
    fn few_brief_enclosing_ones_and_those_on_the_rim_are_none() {
        assert_eq!(found(&scene(|x, y| x == 30.0 && y < 26.0)).1, 0);
        let (mut tracks, salient) = scene(|x, y| (30.0..50.0).contains(&x) && (20.0..40.0).contains(&y));
        tracks.num_frames = 13;
        assert_eq!(found(&(tracks, salient)).1, 0);
        assert_eq!(found(&scene(|x, y| y < 8.0 && (20.0..60.0).contains(&x))).1, 0);
        assert_eq!(found(&scene(|x, y| !(16.0..80.0).contains(&x) || !(12.0..52.0).contains(&y))).1, 0);
        assert_eq!(found(&(Trajectories::empty(3, (20, 20)), Vec::new())).1, 0);
    }
}
