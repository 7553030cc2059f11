//! Affinities as far as trajectories stay near each other, and on from those that end to those that begin in their
//! place.
//!
//! Trajectories that are never seen together have no affinity. Things that turn, blur or pass behind others have
//! trajectories of a few frames, and the weakest place of what they move like would be a moment: before and after. So
//! who begins where another has just ended, with the same velocity, is bound to it, and as strongly as to all its
//! neighbours together.

use crate::sparse::SymCsr;
use crate::trajectory::Trajectories;

/// Distance at which an affinity counts `1/e` of itself, in distances of neighbours. Gaps between two things that move
/// alike are a few of these wide; much less, and holes within one thing would part it.
const REACH: f32 = 2.5;

/// Affinities that count less than this are left out.
const NEGLIGIBLE: f32 = 1e-4;

/// Longest time from the end of a trajectory to the beginning of one that succeeds it, in frames.
const LONGEST_GAP: usize = 4;
/// Frames over which velocities of both are taken, and difference of velocities at which succession counts `1/e`, in
/// pixels a frame.
const VELOCITY_FRAMES: usize = 3;
const VELOCITY_REACH: f32 = 1.0;

/// The graph of `members` (increasing): `A_ij exp(−(r_ij / reach)²)`, where `r` is the largest distance of both in the
/// first, the middle and the last of their common frames. Row `k` is `members[k]`. `spacing` is the distance of
/// neighbours in pixels.
///
/// An affinity above 1 stands for many far pairs that were not compared; such pairs are too far apart to count here.
pub(crate) fn near_affinities(affinities: &SymCsr, tracks: &Trajectories, members: &[u32], spacing: f32) -> SymCsr {
    let mut place = vec![u32::MAX; tracks.len().max(affinities.len())];
    for (k, &i) in (0..).zip(members) {
        place[i as usize] = k;
    }
    let reach_sq = (REACH * spacing).powi(2);
    let mut upper = Vec::new();
    for (k, &i) in (0..).zip(members) {
        for (j, w) in affinities.row(i as usize) {
            let other = place[j];
            if other == u32::MAX || other <= k {
                continue;
            }
            if let Some(apart_sq) = largest_distance_sq(tracks, i as usize, j) {
                let weight = w.min(1.0) as f32 * libm::expf(-apart_sq / reach_sq);
                if weight >= NEGLIGIBLE {
                    upper.push((k, other, weight));
                }
            }
        }
    }
    let degrees = |edges: &[(u32, u32, f32)]| {
        let mut degrees = vec![0.0_f32; members.len()];
        for &(k, other, weight) in edges {
            degrees[k as usize] += weight;
            degrees[other as usize] += weight;
        }
        degrees
    };
    let mut next = successions(tracks, members, reach_sq);
    let (near, after) = (degrees(&upper), degrees(&next));
    let gain = |k: u32| near[k as usize].max(1.0) / after[k as usize];
    for (k, other, weight) in &mut next {
        *weight *= (gain(*k) * gain(*other)).sqrt();
    }
    upper.extend(next);
    SymCsr::from_upper(members.len(), &upper)
}

/// Edges between those that end and those that begin in their place; these have at most one common frame, and so no
/// affinity.
fn successions(tracks: &Trajectories, members: &[u32], reach_sq: f32) -> Vec<(u32, u32, f32)> {
    let mut upper = Vec::new();
    let mut begins: Vec<Vec<(u32, u32)>> = vec![Vec::new(); tracks.num_frames];
    for (k, &i) in (0..).zip(members) {
        begins[tracks.start_frame[i as usize] as usize].push((k, i));
    }
    for (k, &i) in (0..).zip(members) {
        let last = tracks.points(i as usize).end - 1;
        let end = tracks.frames(i as usize).end - 1;
        let (u, v) = velocity(tracks, last, tracks.points(i as usize).start.max(last.saturating_sub(VELOCITY_FRAMES)));
        for begin in end..(end + LONGEST_GAP + 1).min(tracks.num_frames) {
            let frames = (begin - end) as f32;
            let (x, y) = (tracks.x[last] + frames * u, tracks.y[last] + frames * v);
            for &(other, j) in begins[begin].iter().filter(|b| b.1 != i) {
                let points = tracks.points(j as usize);
                let apart_sq = (tracks.x[points.start] - x).powi(2) + (tracks.y[points.start] - y).powi(2);
                if apart_sq > 9.0 * reach_sq {
                    continue;
                }
                let (p, q) = velocity(tracks, (points.start + VELOCITY_FRAMES).min(points.end - 1), points.start);
                let turn_sq = ((p - u).powi(2) + (q - v).powi(2)) / (VELOCITY_REACH * VELOCITY_REACH);
                let weight = libm::expf(-apart_sq / reach_sq - turn_sq);
                // Two trajectories of one frame may succeed each other both ways.
                let once = points.len() > 1 || begin > end || other > k;
                if weight >= NEGLIGIBLE && once {
                    upper.push((k.min(other), k.max(other), weight));
                }
            }
        }
    }
    upper
}

/// Mean velocity between two points of a trajectory, in pixels a frame.
fn velocity(tracks: &Trajectories, to: usize, from: usize) -> (f32, f32) {
    let frames = (to - from).max(1) as f32;
    ((tracks.x[to] - tracks.x[from]) / frames, (tracks.y[to] - tracks.y[from]) / frames)
}

/// `None` without a common frame.
fn largest_distance_sq(tracks: &Trajectories, i: usize, j: usize) -> Option<f32> {
    let (a, b) = (tracks.frames(i), tracks.frames(j));
    let (start, end) = (a.start.max(b.start), a.end.min(b.end));
    let last = end.checked_sub(1).filter(|&last| last >= start)?;
    let apart_sq = |t: usize| {
        let ((ax, ay), (bx, by)) = (tracks.at(i, t)?, tracks.at(j, t)?);
        Some((ax - bx).powi(2) + (ay - by).powi(2))
    };
    Some(apart_sq(start)?.max(apart_sq((start + last) / 2)?).max(apart_sq(last)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_near_in_all_common_frames_counts_and_what_parts_does_not() {
        let mut tracks = Trajectories::empty(5, (200, 100));
        for (x, u) in [(10.0, 0.0), (18.0, 0.0), (26.0, 30.0), (150.0, 0.0)] {
            tracks.push(0, (0..5).map(|t| (x + u * t as f32, 20.0, 0.0)));
        }
        tracks.push(1, [(10.0, 20.0, 0.0), (10.0, 20.0, 0.0)]);
        let all = [(0, 1, 0.9), (0, 2, 0.9), (0, 3, 32.0), (0, 4, 0.5), (1, 2, 0.9)];
        let graph = near_affinities(&SymCsr::from_upper(5, &all), &tracks, &[0, 1, 2, 3, 4], 8.0);
        let expected = 0.9 * (-(8.0_f64 / 20.0).powi(2)).exp();
        let row: Vec<_> = graph.row(0).collect();
        assert_eq!(row.iter().map(|e| e.0).collect::<Vec<_>>(), [1, 4]);
        assert!((row[0].1 - expected).abs() < 1e-6 && (row[1].1 - 0.5).abs() < 1e-6, "{row:?}");
        let some = near_affinities(&SymCsr::from_upper(5, &all), &tracks, &[1, 4], 8.0);
        assert_eq!((some.len(), some.column.len()), (2, 0));
        assert!(near_affinities(&SymCsr::default(), &Trajectories::default(), &[], 8.0).is_empty());
    }

    #[test]
    fn who_begins_where_another_of_the_same_velocity_ended_is_bound_to_it() {
        let mut tracks = Trajectories::empty(12, (200, 100));
        let mut push = |start: usize, x: f32, u: f32| tracks.push(start, (0..4).map(|k| (x + u * k as f32, 20.0, 0.0)));
        push(0, 10.0, 3.0);
        // In its place two frames later; in its place, but still; too far away; too late.
        push(5, 25.0, 3.0);
        push(5, 25.0, 0.0);
        push(4, 90.0, 3.0);
        push(8, 34.0, 3.0);
        let graph = near_affinities(&SymCsr::from_upper(5, &[]), &tracks, &[0, 1, 2, 3, 4], 8.0);
        let row: Vec<_> = graph.row(0).collect();
        assert!(row.len() == 2 && row[0].1 > 0.5 && row[1].1 < 0.1, "{row:?}");
        assert_eq!(graph.row(4).map(|e| e.0).collect::<Vec<_>>(), [1, 2]);
        graph.check().unwrap();
    }

    #[test]
    fn trajectories_of_a_single_frame_succeed_each_other_once() {
        let mut tracks = Trajectories::empty(1, (200, 100));
        (0..3).for_each(|k| tracks.push(0, [(10.0 + k as f32, 20.0, 0.0)]));
        let graph = near_affinities(&SymCsr::from_upper(3, &[]), &tracks, &[0, 1, 2], 8.0);
        graph.check().unwrap();
        assert_eq!(graph.column.len(), 6);
    }
}
