//! Labels for trajectories that were not clustered, such as denser or shorter ones: those of their neighbours that move
//! as they do.
//!
//! 1. Each trajectory asks in the first, the middle and the last frame of its life.
//! 2. Asked are the labelled trajectories near in that frame. Over up to five common frames to either side, what both
//!    moved differs by `m` pixels per frame; at a distance of `d` pixels the vote is `exp(−(m / motion)² − (2 d /
//!    radius)²)`.
//! 3. The label with most votes wins if it has at least a given share of them, and if there are votes worth mentioning.
//! 4. Who has many neighbours and votes of none of them moves like nothing around: it is a stranger. Objects that turn,
//!    bend or are seen for a few frames only have such trajectories, and too few longer ones to be clustered.
//!
//! Not in the paper, which has one set of trajectories. Cost: O(points of the labelled) + O(trajectories · neighbours).

use super::input::{STRANGER, UNKNOWN};
use crate::grid::Grid;
use crate::trajectory::Trajectories;

/// Radius within which labelled trajectories vote on others, in pixels of large frames. Higher is slower.
pub(crate) const VOTE_RADIUS: f32 = 24.0;
/// How differently a trajectory may move from those that vote on it, in pixels per frame.
pub(crate) const VOTE_MOTION: f32 = 0.5;
/// Share of the votes that a label needs; below, a trajectory's label stays unknown.
const VOTE_SHARE: f32 = 0.6;

/// Frames to either side over which motion is compared.
const HORIZON: usize = 5;

/// Votes that add up to less than this say nothing: the vote of one neighbour at one and a half times the scale of
/// motion.
const LEAST_VOTES: f32 = 0.1;

/// Strangers have neighbours whose nearness adds up to at least this, and votes of less than that part of it: those of
/// equal motion would all vote in full.
const STRANGER_NEARNESS: f32 = 2.0;
const STRANGER_VOTES: f32 = 0.05;

/// A label below `num_labels` for each trajectory of `asking`, [`STRANGER`] or [`UNKNOWN`]. `label` has one for each of
/// `labelled`; those that are not below `num_labels` do not vote. Both sets are in pixels of the same frames, as is the
/// `radius` within which votes are asked for: 24 in large frames, and about three times the spacing in others.
///
/// # Examples
/// Short trajectories take the label of those around them that move like them.
///
/// ```
/// use tracecut::cut::labels_for;
/// use tracecut::trajectory::Trajectories;
///
/// let moving = |at: &[(f32, f32)], frames: usize| {
///     let mut tracks = Trajectories::empty(8, (64, 48));
///     at.iter().for_each(|&(x, speed)| tracks.push(0, (0..frames).map(|t| (x + speed * t as f32, 20.0, 0.0))));
///     tracks
/// };
/// let labelled = moving(&[(20.0, 2.0), (22.0, 2.0), (24.0, -2.0), (26.0, -2.0)], 8);
/// let asking = moving(&[(23.0, 2.0), (21.0, -2.0)], 3);
/// assert_eq!(labels_for(&asking, &labelled, &[0, 0, 1, 1], 2, 24.0), [0, 1]);
/// ```
#[must_use]
pub fn labels_for(
    asking: &Trajectories,
    labelled: &Trajectories,
    label: &[u32],
    num_labels: usize,
    radius: f32,
) -> Vec<u32> {
    let mut votes = vec![0.0_f32; asking.len() * num_labels];
    let mut nearness = vec![0.0_f32; asking.len()];
    let mut grid = Grid::new(labelled.size.0, labelled.size.1, radius);
    let radius_sq = radius * radius;
    for t in 0..asking.num_frames.min(labelled.num_frames) {
        let voters = |i: usize| label.get(i).is_some_and(|&l| (l as usize) < num_labels);
        grid.clear();
        labelled.alive(t).filter(|&(i, ..)| voters(i)).for_each(|(i, x, y)| grid.add(i as u32, x, y));
        for (i, x, y) in asking.alive(t).filter(|&(i, ..)| asks_in(asking, i, t)) {
            let votes = &mut votes[i * num_labels..(i + 1) * num_labels];
            for (j, distance_sq) in grid.nearby(x, y).filter(|&(_, d_sq)| d_sq <= radius_sq) {
                let j = j as usize;
                if let Some(m_sq) = motion_difference_sq(asking, i, labelled, j, t) {
                    let near = libm::expf(-4.0 * distance_sq / radius_sq);
                    let motion = m_sq / (VOTE_MOTION * VOTE_MOTION);
                    nearness[i] += near;
                    votes[label[j] as usize] += near * libm::expf(-motion);
                }
            }
        }
    }
    if num_labels == 0 {
        return vec![UNKNOWN; asking.len()];
    }
    votes.chunks_exact(num_labels).zip(nearness).map(|(v, near)| winner(v, near)).collect()
}

/// Strangers that do not stand out become [`UNKNOWN`]: what moves like nothing around it is a sign of an object only
/// where it is salient; elsewhere it is an error of the flow. `salience` has a number for each label, or none.
pub fn forget_strangers(label: &mut [u32], salience: &[f32], threshold: f64) {
    for (label, &salience) in label.iter_mut().zip(salience) {
        if *label == STRANGER && f64::from(salience) <= threshold {
            *label = UNKNOWN;
        }
    }
}

/// Whether `t` is the first, the middle or the last frame of trajectory `i`.
fn asks_in(tracks: &Trajectories, i: usize, t: usize) -> bool {
    let frames = tracks.frames(i);
    t == frames.start || t + 1 == frames.end || t == (frames.start + frames.end) / 2
}

/// By how much both move differently around frame `t`, in pixels per frame squared; `None` without a second common
/// frame.
pub(crate) fn motion_difference_sq(a: &Trajectories, i: usize, b: &Trajectories, j: usize, t: usize) -> Option<f32> {
    let (of_a, of_b) = (a.frames(i), b.frames(j));
    let begin = of_a.start.max(of_b.start).max(t.saturating_sub(HORIZON));
    let end = (of_a.end.min(of_b.end) - 1).min(t + HORIZON);
    let length = end.checked_sub(begin).filter(|&length| length > 0)?;
    let (p, q) = (a.point(i, begin), b.point(j, begin));
    let dx = (a.x[p + length] - a.x[p]) - (b.x[q + length] - b.x[q]);
    let dy = (a.y[p + length] - a.y[p]) - (b.y[q + length] - b.y[q]);
    let frames = length as f32;
    Some((dx * dx + dy * dy) / (frames * frames))
}

fn winner(votes: &[f32], nearness: f32) -> u32 {
    let total: f32 = votes.iter().sum();
    if nearness >= STRANGER_NEARNESS && total < STRANGER_VOTES * nearness {
        return STRANGER;
    }
    let best = (0..votes.len()).rev().max_by(|&a, &b| votes[a].total_cmp(&votes[b])).unwrap_or(0);
    if total >= LEAST_VOTES && votes[best] >= VOTE_SHARE * total { best as u32 } else { UNKNOWN }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (100, 80);

    /// Tracks of `frames` frames from `start` on, each with its own place and velocity.
    fn moving(start: usize, frames: usize, tracks: &[(f32, f32, f32, f32)]) -> Trajectories {
        let mut all = Trajectories::empty(10, SIZE);
        for &(x, y, u, v) in tracks {
            all.push(start, (0..frames).map(|k| (x + u * k as f32, y + v * k as f32, 0.0)));
        }
        all
    }

    fn ask(asking: &Trajectories, labelled: &Trajectories, label: &[u32]) -> Vec<u32> {
        labels_for(asking, labelled, label, 3, VOTE_RADIUS)
    }

    #[test]
    fn of_two_motions_at_one_place_the_own_one_decides() {
        let labelled = moving(0, 10, &[(20.0, 20.0, 1.0, 0.0), (24.0, 20.0, -2.0, 0.0), (22.0, 23.0, -2.0, 0.1)]);
        let asking = moving(0, 3, &[(22.0, 20.0, 1.1, 0.0), (22.0, 20.0, -2.1, 0.0), (22.0, 20.0, 9.0, 9.0)]);
        assert_eq!(ask(&asking, &labelled, &[2, 1, 1]), [2, 1, STRANGER]);
    }

    #[test]
    fn of_equal_motions_the_nearer_decides_and_a_draw_is_unknown() {
        let labelled = moving(0, 10, &[(20.0, 20.0, 1.0, 0.0), (30.0, 20.0, 1.0, 0.0)]);
        let asking = moving(2, 4, &[(23.0, 20.0, 1.0, 0.0), (31.0, 20.0, 1.0, 0.0), (27.0, 20.0, 1.0, 0.0)]);
        assert_eq!(ask(&asking, &labelled, &[0, 1]), [0, 1, UNKNOWN]);
    }

    #[test]
    fn who_has_no_neighbour_in_space_or_time_stays_unknown() {
        let labelled = moving(0, 4, &[(20.0, 20.0, 0.0, 0.0)]);
        let far = moving(0, 4, &[(60.0, 60.0, 0.0, 0.0)]);
        let late = moving(5, 5, &[(20.0, 20.0, 0.0, 0.0)]);
        // One common frame tells nothing about motion.
        let touching = moving(3, 5, &[(20.0, 20.0, 0.0, 0.0)]);
        for asking in [far, late, touching] {
            assert_eq!(ask(&asking, &labelled, &[0]), [UNKNOWN]);
        }
        assert_eq!(ask(&moving(2, 5, &[(20.0, 20.0, 0.0, 0.0)]), &labelled, &[0]), [0]);
        assert_eq!(ask(&labelled, &labelled, &[UNKNOWN]), [UNKNOWN]);
        assert_eq!(ask(&labelled, &Trajectories::empty(10, SIZE), &[]), [UNKNOWN]);
        assert_eq!(labels_for(&labelled, &labelled, &[0], 0, VOTE_RADIUS), [UNKNOWN]);
    }

    #[test]
    fn who_moves_like_none_of_many_neighbours_is_a_stranger() {
        let around: Vec<_> =
            (0..9).map(|k| (20.0 + 8.0 * (k % 3) as f32, 20.0 + 8.0 * (k / 3) as f32, 1.0, 0.0)).collect();
        let labelled = moving(0, 10, &around);
        let asking = moving(0, 3, &[(29.0, 28.0, 4.0, 0.0), (29.0, 28.0, 1.0, 0.1), (90.0, 70.0, 4.0, 0.0)]);
        assert_eq!(ask(&asking, &labelled, &[0; 9]), [STRANGER, 0, UNKNOWN]);
    }
}
