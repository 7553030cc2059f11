//! Label propagation to trajectories that were not clustered, such as denser or shorter ones, by votes of neighbours.
//!
//! 1. Each trajectory takes votes in its first, middle and last frame.
//! 2. Voters are the labelled trajectories within a radius in that frame. If both motions differ by `m` pixels a frame over
//!    up to five common frames to either side, the vote at a distance of `d` pixels is `exp(−(m / motion)² − (2 d / radius)²)`.
//! 3. The label with most votes wins if it has a large share of them, and if the votes are not negligible.
//! 4. A trajectory with many neighbours and hardly any votes is an outlier. Objects that turn, bend or are visible for a
//!    few frames only have such trajectories, and too few longer ones to be clustered.
//!
//! Not in the paper, which has one set of trajectories. Cost: O(points of the labelled) + O(trajectories · neighbours). It
//! fails where two objects are near and move alike for a while.

use super::{OUTLIER, UNKNOWN};
use crate::grid::Grid;
use crate::trajectory::Trajectories;

// All constants of this file are chosen by eye.

/// Radius within which labelled trajectories vote on others, in pixels of large frames. Higher is slower.
pub(crate) const VOTE_RADIUS_PX: f32 = 24.0;
/// Scale of the motion difference, in pixels a frame.
pub(crate) const VOTE_MOTION_PX: f32 = 0.5;
/// Least share of the votes of a winning label.
const MIN_VOTE_SHARE: f32 = 0.6;

/// Frames to either side over which motion is compared.
const HORIZON_FRAMES: usize = 5;

/// Least sum of votes: one neighbour at one and a half times the motion scale.
const MIN_VOTES: f32 = 0.1;

/// Least sum of the neighbours' spatial weights, and largest part of it as votes, of an outlier: neighbours of equal
/// motion would vote with their full weight.
const MIN_OUTLIER_WEIGHT: f32 = 2.0;
const MAX_OUTLIER_VOTES: f32 = 0.05;

/// Labels each trajectory of `unlabelled` below `num_labels`, or as [`OUTLIER`] or [`UNKNOWN`]. `label` has a label for each
/// of `labelled`, which does not vote unless it is below `num_labels`. Both sets and the `radius` of votes are in pixels of
/// the same frames; 24 in large frames, and about three times the spacing in others.
pub(crate) fn propagate_labels(
    unlabelled: &Trajectories,
    labelled: &Trajectories,
    label: &[u32],
    num_labels: usize,
    radius: f32,
) -> Vec<u32> {
    let mut votes = vec![0.0_f32; unlabelled.len() * num_labels];
    let mut weights = vec![0.0_f32; unlabelled.len()];
    let mut grid = Grid::new(labelled.size.0, labelled.size.1, radius);
    let radius_sq = radius * radius;
    for t in 0..unlabelled.num_frames.min(labelled.num_frames) {
        let is_voter = |i: usize| label.get(i).is_some_and(|&l| (l as usize) < num_labels);
        grid.clear();
        labelled.alive(t).filter(|&(i, ..)| is_voter(i)).for_each(|(i, x, y)| grid.add(i as u32, x, y));
        for (i, x, y) in unlabelled.alive(t).filter(|&(i, ..)| takes_votes(unlabelled, i, t)) {
            let votes = &mut votes[i * num_labels..(i + 1) * num_labels];
            for (j, distance_sq) in grid.nearby(x, y).filter(|&(_, d_sq)| d_sq <= radius_sq) {
                let j = j as usize;
                if let Some(m_sq) = motion_difference_sq(unlabelled, i, labelled, j, t) {
                    let weight = libm::expf(-4.0 * distance_sq / radius_sq);
                    let motion = m_sq / (VOTE_MOTION_PX * VOTE_MOTION_PX);
                    weights[i] += weight;
                    votes[label[j] as usize] += weight * libm::expf(-motion);
                }
            }
        }
    }
    if num_labels == 0 {
        return vec![UNKNOWN; unlabelled.len()];
    }
    votes.chunks_exact(num_labels).zip(weights).map(|(votes, weight)| elect_label(votes, weight)).collect()
}

/// Returns `true` in the first, the middle and the last frame of trajectory `i`.
fn takes_votes(tracks: &Trajectories, i: usize, t: usize) -> bool {
    let frames = tracks.frames(i);
    t == frames.start || t + 1 == frames.end || t == (frames.start + frames.end) / 2
}

/// Squared difference of two motions around frame `t`, in pixels a frame, squared; `None` without a second common frame.
pub(crate) fn motion_difference_sq(a: &Trajectories, i: usize, b: &Trajectories, j: usize, t: usize) -> Option<f32> {
    let (frames_a, frames_b) = (a.frames(i), b.frames(j));
    let start = frames_a.start.max(frames_b.start).max(t.saturating_sub(HORIZON_FRAMES));
    let end = (frames_a.end.min(frames_b.end) - 1).min(t + HORIZON_FRAMES);
    let length = end.checked_sub(start).filter(|&length| length > 0)?;
    let (p, q) = (a.point(i, start), b.point(j, start));
    let dx = (a.x[p + length] - a.x[p]) - (b.x[q + length] - b.x[q]);
    let dy = (a.y[p + length] - a.y[p]) - (b.y[q + length] - b.y[q]);
    let frames = length as f32;
    Some((dx * dx + dy * dy) / (frames * frames))
}

/// Elects the label of a trajectory whose neighbours have this sum of weights.
fn elect_label(votes: &[f32], weight: f32) -> u32 {
    let total: f32 = votes.iter().sum();
    if weight >= MIN_OUTLIER_WEIGHT && total < MAX_OUTLIER_VOTES * weight {
        return OUTLIER;
    }
    let best = (0..votes.len()).rev().max_by(|&a, &b| votes[a].total_cmp(&votes[b])).unwrap_or(0);
    if total >= MIN_VOTES && votes[best] >= MIN_VOTE_SHARE * total { best as u32 } else { UNKNOWN }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (100, 80);

    /// Tracks of `frames` frames from `start` on, each with its own position and velocity.
    fn moving(start: usize, frames: usize, motions: &[(f32, f32, f32, f32)]) -> Trajectories {
        let mut tracks = Trajectories::empty(10, SIZE);
        for &(x, y, u, v) in motions {
            tracks.push(start, (0..frames).map(|k| (x + u * k as f32, y + v * k as f32, 0.0)));
        }
        tracks
    }

    fn propagate(unlabelled: &Trajectories, labelled: &Trajectories, label: &[u32]) -> Vec<u32> {
        propagate_labels(unlabelled, labelled, label, 3, VOTE_RADIUS_PX)
    }

    #[test]
    fn of_two_motions_at_one_place_the_equal_one_decides() {
        let labelled = moving(0, 10, &[(20.0, 20.0, 1.0, 0.0), (24.0, 20.0, -2.0, 0.0), (22.0, 23.0, -2.0, 0.1)]);
        let unlabelled = moving(0, 3, &[(22.0, 20.0, 1.1, 0.0), (22.0, 20.0, -2.1, 0.0), (22.0, 20.0, 9.0, 9.0)]);
        assert_eq!(propagate(&unlabelled, &labelled, &[2, 1, 1]), [2, 1, OUTLIER]);
    }

    #[test]
    fn of_equal_motions_the_nearer_decides_and_a_draw_is_unknown() {
        let labelled = moving(0, 10, &[(20.0, 20.0, 1.0, 0.0), (30.0, 20.0, 1.0, 0.0)]);
        let unlabelled = moving(2, 4, &[(23.0, 20.0, 1.0, 0.0), (31.0, 20.0, 1.0, 0.0), (27.0, 20.0, 1.0, 0.0)]);
        assert_eq!(propagate(&unlabelled, &labelled, &[0, 1]), [0, 1, UNKNOWN]);
    }

    #[test]
    fn without_neighbours_in_space_or_time_the_label_is_unknown() {
        let labelled = moving(0, 4, &[(20.0, 20.0, 0.0, 0.0)]);
        let far = moving(0, 4, &[(60.0, 60.0, 0.0, 0.0)]);
        let late = moving(5, 5, &[(20.0, 20.0, 0.0, 0.0)]);
        // One common frame has no motion.
        let touching = moving(3, 5, &[(20.0, 20.0, 0.0, 0.0)]);
        for unlabelled in [far, late, touching] {
            assert_eq!(propagate(&unlabelled, &labelled, &[0]), [UNKNOWN]);
        }
        assert_eq!(propagate(&moving(2, 5, &[(20.0, 20.0, 0.0, 0.0)]), &labelled, &[0]), [0]);
        assert_eq!(propagate(&labelled, &labelled, &[UNKNOWN]), [UNKNOWN]);
        assert_eq!(propagate(&labelled, &Trajectories::empty(10, SIZE), &[]), [UNKNOWN]);
        assert_eq!(propagate_labels(&labelled, &labelled, &[0], 0, VOTE_RADIUS_PX), [UNKNOWN]);
    }

    #[test]
    fn tracks_unlike_their_many_neighbours_are_outliers() {
        let around: Vec<_> =
            (0..9).map(|k| (20.0 + 8.0 * (k % 3) as f32, 20.0 + 8.0 * (k / 3) as f32, 1.0, 0.0)).collect();
        let labelled = moving(0, 10, &around);
        let unlabelled = moving(0, 3, &[(29.0, 28.0, 4.0, 0.0), (29.0, 28.0, 1.0, 0.1), (90.0, 70.0, 4.0, 0.0)]);
        assert_eq!(propagate(&unlabelled, &labelled, &[0; 9]), [OUTLIER, 0, UNKNOWN]);
    }

    #[test]
    fn short_trajectories_take_the_label_of_those_around_them_that_move_like_them() {
        let moving = |at: &[(f32, f32)], frames: usize| {
            let mut tracks = Trajectories::empty(8, (64, 48));
            at.iter().for_each(|&(x, speed)| tracks.push(0, (0..frames).map(|t| (x + speed * t as f32, 20.0, 0.0))));
            tracks
        };
        let labelled = moving(&[(20.0, 2.0), (22.0, 2.0), (24.0, -2.0), (26.0, -2.0)], 8);
        let unlabelled = moving(&[(23.0, 2.0), (21.0, -2.0)], 3);
        assert_eq!(propagate_labels(&unlabelled, &labelled, &[0, 0, 1, 1], 2, 24.0), [0, 1]);
    }
}
