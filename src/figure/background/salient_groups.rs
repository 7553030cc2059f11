//! Objects without a cluster: groups of salient trajectories that are near each other and move alike.
//!
//! Small or blurred objects have fewer long trajectories than a cluster needs, but they may have many short ones. Salient
//! trajectories are connected in each frame where they are near and move alike; connected groups that are dense, last and
//! keep off the frame border are classified as clusters are ([`crate::objects`]). Not in the paper, which has no
//! objects without clusters. Cost: O(points · neighbours). It fails where noise of the flow is salient and coherent.

use super::segmented::ObjectClusters;
use crate::cut::{UNKNOWN, VOTE_MOTION_PX, motion_difference_sq, propagate_labels};
use crate::discretize::Clusters;
use crate::grid::Grid;
use crate::objects::find_objects_above;
use crate::sets::DisjointSets;
use crate::trajectory::Trajectories;

// All constants of this file are chosen by eye.

/// Largest distance of neighbours, in multiples of the spacing of trajectories.
const NEIGHBOUR_SPACINGS: f32 = 2.0;
/// Fewest trajectories of a group, as a mean over its frames.
const MIN_MEAN_TRACKS: usize = 8;
/// Least share of the clip's frames between a group's first and last.
const MIN_FRAME_SHARE: f32 = 0.5;
/// Prior log-odds that a salient group is an object, against the cue of the frame border.
const SALIENT_LOG_ODDS: f64 = 0.8;
/// Width of the frame border, as a part of the shorter side. A group with three quarters of its points there may be a piece
/// of the scene that a near thing cuts off.
const BORDER_WIDTH: f32 = 0.125;

/// Clustered trajectories, and the denser ones with the labels that they have from them.
pub(crate) struct SalientInput<'a> {
    pub(crate) tracks: &'a Trajectories,
    pub(crate) clusters: &'a Clusters,
    pub(crate) denser: &'a Trajectories,
    /// Label of each denser trajectory.
    pub(crate) denser_label: &'a [u32],
    /// `true` for each denser trajectory that is salient.
    pub(crate) is_salient: &'a [bool],
    /// Distance of neighbours among the denser trajectories, in pixels.
    pub(crate) spacing: f32,
    /// Distance within which trajectories vote on others, in pixels.
    pub(crate) vote_radius: f32,
}

/// Adds a cluster for each group of salient trajectories that is an object. Returns all clusters and the labels of the
/// denser trajectories, or `None` if there is no such group.
pub(crate) fn add_salient_objects(input: &SalientInput<'_>) -> Option<(ObjectClusters, Vec<u32>)> {
    let SalientInput { tracks, clusters, denser, denser_label, is_salient, spacing, vote_radius } = *input;
    let (groups, num_groups) = salient_groups(denser, is_salient, spacing);
    if num_groups == 0 {
        return None;
    }
    let count = clusters.count;
    let mut labels = denser_label.to_vec();
    for (label, group) in labels.iter_mut().zip(groups) {
        *label = group.map_or(*label, |k| count as u32 + k);
    }
    // Clustered trajectories take the new label of the majority around them.
    let mut old_label = clusters.label.clone();
    let votes = propagate_labels(tracks, denser, &labels, count + num_groups, vote_radius);
    for (label, vote) in old_label.iter_mut().zip(votes) {
        let is_new = (count..count + num_groups).contains(&(vote as usize));
        *label = if is_new { vote } else { *label };
    }
    let clusters = Clusters::from_labels(tracks, old_label.clone());
    let (mut new_label, mut is_object) = (vec![UNKNOWN; count + num_groups], vec![false; clusters.count]);
    for (&old, &new) in old_label.iter().zip(&clusters.label) {
        new_label[old as usize] = new;
        is_object[new as usize] = old as usize >= count;
    }
    labels.iter_mut().for_each(|label| *label = new_label.get(*label as usize).copied().unwrap_or(*label));
    is_object.contains(&true).then_some((ObjectClusters { clusters, is_object }, labels))
}

/// Groups of salient trajectories that are objects by the frame border: the group of each trajectory, and their number.
/// Trajectories are `spacing` pixels apart.
fn salient_groups(tracks: &Trajectories, is_salient: &[bool], spacing: f32) -> (Vec<Option<u32>>, usize) {
    let mut sets = connect_alike(tracks, is_salient, NEIGHBOUR_SPACINGS * spacing);
    let roots: Vec<usize> = (0..tracks.len()).map(|i| sets.root(i)).collect();
    let mut extents = vec![GroupExtent { points: 0, border_points: 0, first: usize::MAX, end: 0 }; tracks.len()];
    let (right, bottom) = (tracks.size.0 as f32 - 1.0, tracks.size.1 as f32 - 1.0);
    let border_width = BORDER_WIDTH * (right.min(bottom) + 1.0);
    for (i, &root) in roots.iter().enumerate().filter(|&(i, _)| is_salient.get(i) == Some(&true)) {
        let (frames, extent) = (tracks.frames(i), &mut extents[root]);
        (extent.first, extent.end) = (extent.first.min(frames.start), extent.end.max(frames.end));
        extent.points += frames.len();
        for p in tracks.points(i) {
            let (x, y) = (tracks.x[p], tracks.y[p]);
            extent.border_points += usize::from(x.min(y).min(right - x).min(bottom - y) < border_width);
        }
    }
    // Cluster 0 is the rest.
    let large: Vec<usize> = (0..tracks.len()).filter(|&root| extents[root].is_large(tracks.num_frames)).collect();
    let label = roots.iter().map(|r| large.binary_search(r).map_or(0, |k| 1 + k as u32)).collect();
    let clusters = Clusters { count: 1 + large.len(), label };
    let objects = find_objects_above(tracks, &clusters, -SALIENT_LOG_ODDS);
    let mut number = vec![None; clusters.count];
    let mut count = 0;
    for (number, _) in number.iter_mut().zip(&objects.of_cluster).skip(1).filter(|(_, object)| **object > 0) {
        *number = Some(count);
        count += 1;
    }
    (clusters.label.iter().map(|&c| number[c as usize]).collect(), count as usize)
}

/// Extent of a group of trajectories in space and time.
#[derive(Clone)]
struct GroupExtent {
    points: usize,
    /// Those of the points at the frame border.
    border_points: usize,
    first: usize,
    /// The frame after the last.
    end: usize,
}

impl GroupExtent {
    fn is_large(&self, num_frames: usize) -> bool {
        let frames = self.end.saturating_sub(self.first);
        let is_long = frames as f32 >= MIN_FRAME_SHARE * num_frames as f32;
        4 * self.border_points < 3 * self.points && is_long && self.points >= MIN_MEAN_TRACKS * frames
    }
}

/// Joins salient trajectories that are within `radius` pixels in some frame and move alike around it.
fn connect_alike(tracks: &Trajectories, is_salient: &[bool], radius: f32) -> DisjointSets {
    let mut sets = DisjointSets::new(tracks.len());
    let mut grid = Grid::new(tracks.size.0, tracks.size.1, radius);
    for t in 0..tracks.num_frames {
        grid.clear();
        let points: Vec<_> = tracks.alive(t).filter(|&(i, ..)| is_salient.get(i) == Some(&true)).collect();
        points.iter().for_each(|&(i, x, y)| grid.add(i as u32, x, y));
        for &(i, x, y) in &points {
            for (j, _) in grid.nearby(x, y).filter(|&(j, d_sq)| j as usize > i && d_sq <= radius * radius) {
                let difference_sq = motion_difference_sq(tracks, i, tracks, j as usize, t);
                if difference_sq.is_some_and(|sq| sq < VOTE_MOTION_PX * VOTE_MOTION_PX) {
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

    /// A moving lattice of points four pixels apart; those inside the box are salient and faster by (1.8, 0).
    fn scene(inside: impl Fn(f32, f32) -> bool) -> (Trajectories, Vec<bool>) {
        let (mut tracks, mut salient) = (Trajectories::empty(6, (96, 64)), Vec::new());
        for (x, y) in (0..24 * 16).map(|k| ((4 * (k % 24) + 2) as f32, (4 * (k / 24) + 2) as f32)) {
            let is_inside = inside(x, y);
            let speed = if is_inside { 2.0 } else { 0.2 };
            tracks.push(
                0,
                (0..6).map(|t| t as f32).take_while(|t| x + speed * t < 96.0).map(|t| (x + speed * t, y, 0.0)),
            );
            salient.push(is_inside);
        }
        (tracks, salient)
    }

    fn groups(scene: &(Trajectories, Vec<bool>)) -> (Vec<Option<u32>>, usize) {
        salient_groups(&scene.0, &scene.1, 4.0)
    }

    #[test]
    fn a_salient_group_is_an_object() {
        let scene = scene(|x, y| (30.0..50.0).contains(&x) && (20.0..40.0).contains(&y));
        let (group, count) = groups(&scene);
        assert_eq!(count, 1);
        assert!(group.iter().zip(&scene.1).all(|(group, &salient)| *group == salient.then_some(0)));
    }

    #[test]
    fn distant_groups_and_different_motions_are_separate() {
        let two = scene(|x, y| !(40.0..56.0).contains(&x) && (12.0..84.0).contains(&x) && (20.0..40.0).contains(&y));
        assert_eq!(groups(&two).1, 2);
        let (mut tracks, salient) = scene(|x, y| (20.0..60.0).contains(&x) && (20.0..40.0).contains(&y));
        let mut sheared = Trajectories::empty(6, (96, 64));
        for i in 0..tracks.len() {
            let upper = salient[i] && tracks.y[tracks.points(i).start] < 30.0;
            let rise = if upper { 1.0 } else { 0.0 };
            let points = tracks.points(i).enumerate();
            sheared.push(0, points.map(|(t, p)| (tracks.x[p], tracks.y[p] - rise * t as f32, 0.0)));
        }
        tracks = sheared;
        assert_eq!(groups(&(tracks, salient)).1, 2);
    }

    #[test]
    fn small_brief_and_enclosing_groups_and_those_at_the_border_are_none() {
        assert_eq!(groups(&scene(|x, y| x == 30.0 && y < 26.0)).1, 0);
        let (mut tracks, salient) = scene(|x, y| (30.0..50.0).contains(&x) && (20.0..40.0).contains(&y));
        tracks.num_frames = 13;
        assert_eq!(groups(&(tracks, salient)).1, 0);
        assert_eq!(groups(&scene(|x, y| y < 8.0 && (20.0..60.0).contains(&x))).1, 0);
        assert_eq!(groups(&scene(|x, y| !(16.0..80.0).contains(&x) || !(12.0..52.0).contains(&y))).1, 0);
        assert_eq!(groups(&(Trajectories::empty(3, (20, 20)), Vec::new())).1, 0);
    }
}
