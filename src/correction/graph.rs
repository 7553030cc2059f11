//! The proximity graph: affinities weighted by distance, with edges between trajectories that succeed each other.
//!
//! Trajectories without a common frame have no affinity. An object that turns, blurs or is occluded has trajectories of a few
//! frames, and its weakest cut would be one in time. So a trajectory that begins where another has just ended, with the same
//! velocity, is tied to it, as strongly as to all of its neighbours together.

use crate::sparse::SymCsr;
use crate::trajectory::Trajectories;

// All chosen by eye.
/// Distance at which an affinity is weighted by `1/e`, in units of the spacing. Gaps between two objects of similar motion are
/// a few of these wide; with much less, holes would split an object.
const REACH_IN_SPACINGS: f32 = 2.5;
/// Smallest weight of an edge.
const MIN_WEIGHT: f32 = 1e-4;
/// Largest number of frames from the end of a trajectory to the begin of its successor.
const MAX_GAP_FRAMES: usize = 4;
/// Number of frames over which velocities are measured.
const VELOCITY_FRAMES: usize = 3;
/// Difference of velocities at which a succession is weighted by `1/e`, in pixels a frame.
const VELOCITY_REACH_PX: f32 = 1.0;

/// Builds the graph of `members` (increasing): `A_ij exp(−(r_ij / reach)²)`, where `r` is the largest distance in the first,
/// the middle and the last of the common frames. Row `k` is `members[k]`. `spacing` is the distance of neighbouring
/// trajectories in pixels.
///
/// Affinities above 1 stand for many far pairs that were not compared; they are too far apart to count here.
pub(crate) fn proximity_graph(affinities: &SymCsr, tracks: &Trajectories, members: &[u32], spacing: f32) -> SymCsr {
    let mut row = vec![u32::MAX; tracks.len().max(affinities.len())];
    for (k, &i) in (0..).zip(members) {
        row[i as usize] = k;
    }
    let reach_sq = (REACH_IN_SPACINGS * spacing).powi(2);
    let mut upper = Vec::new();
    for (k, &i) in (0..).zip(members) {
        for (j, w) in affinities.row(i as usize) {
            let l = row[j];
            if l == u32::MAX || l <= k {
                continue;
            }
            if let Some(distance_sq) = largest_distance_sq(tracks, i as usize, j) {
                let weight = w.min(1.0) as f32 * libm::expf(-distance_sq / reach_sq);
                if weight >= MIN_WEIGHT {
                    upper.push((k, l, weight));
                }
            }
        }
    }
    let degrees = |edges: &[(u32, u32, f32)]| {
        let mut degrees = vec![0.0_f32; members.len()];
        for &(k, l, weight) in edges {
            degrees[k as usize] += weight;
            degrees[l as usize] += weight;
        }
        degrees
    };
    let mut successions = successions(tracks, members, reach_sq);
    let (affinity_degrees, succession_degrees) = (degrees(&upper), degrees(&successions));
    let gain = |k: u32| affinity_degrees[k as usize].max(1.0) / succession_degrees[k as usize];
    for (k, l, weight) in &mut successions {
        *weight *= (gain(*k) * gain(*l)).sqrt();
    }
    upper.extend(successions);
    SymCsr::from_upper(members.len(), &upper)
}

/// Returns the edges between trajectories that succeed each other. These have at most one common frame, and so no affinity.
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
        for begin in end..(end + MAX_GAP_FRAMES + 1).min(tracks.num_frames) {
            let frames = (begin - end) as f32;
            let (x, y) = (tracks.x[last] + frames * u, tracks.y[last] + frames * v);
            for &(l, j) in begins[begin].iter().filter(|b| b.1 != i) {
                let points = tracks.points(j as usize);
                let distance_sq = (tracks.x[points.start] - x).powi(2) + (tracks.y[points.start] - y).powi(2);
                if distance_sq > 9.0 * reach_sq {
                    continue;
                }
                let (p, q) = velocity(tracks, (points.start + VELOCITY_FRAMES).min(points.end - 1), points.start);
                let turn_sq = ((p - u).powi(2) + (q - v).powi(2)) / (VELOCITY_REACH_PX * VELOCITY_REACH_PX);
                let weight = libm::expf(-distance_sq / reach_sq - turn_sq);
                // Two trajectories of one frame may succeed each other in both directions.
                let is_first = points.len() > 1 || begin > end || l > k;
                if weight >= MIN_WEIGHT && is_first {
                    upper.push((k.min(l), k.max(l), weight));
                }
            }
        }
    }
    upper
}

/// Returns the mean velocity between two points of a trajectory, in pixels a frame.
fn velocity(tracks: &Trajectories, to: usize, from: usize) -> (f32, f32) {
    let frames = (to - from).max(1) as f32;
    ((tracks.x[to] - tracks.x[from]) / frames, (tracks.y[to] - tracks.y[from]) / frames)
}

/// Returns the largest squared distance in the first, the middle and the last common frame; `None` without one.
fn largest_distance_sq(tracks: &Trajectories, i: usize, j: usize) -> Option<f32> {
    let (a, b) = (tracks.frames(i), tracks.frames(j));
    let (start, end) = (a.start.max(b.start), a.end.min(b.end));
    let last = end.checked_sub(1).filter(|&last| last >= start)?;
    let distance_sq = |t: usize| {
        let ((ax, ay), (bx, by)) = (tracks.at(i, t)?, tracks.at(j, t)?);
        Some((ax - bx).powi(2) + (ay - by).powi(2))
    };
    Some(distance_sq(start)?.max(distance_sq((start + last) / 2)?).max(distance_sq(last)?))
}

// Assignment of trajectories to strokes by random walks with absorption.
//
// From a trajectory a walk goes to another with a probability proportional to their affinity; at each step it ends with
// probability κ. `u_s` is the probability that it reaches stroke `s` before any other (Grady, "Random walks for image
// segmentation", PAMI 2006), and each trajectory is assigned to the stroke with the largest one. The embedding has the same
// walk, `P = D⁻¹ A`: its discontinuities are where walks seldom cross. Without κ a long stroke would win all trajectories
// that are far from every stroke.
//
// If strokes change only a part of an object, κ is larger, and a trajectory is assigned to a stroke only if most of its
// walks reach it.
//
// `u_s = (1 − κ) P u_s`, with 1 under the stroke and 0 under the others, is solved by Gauss-Seidel sweeps forward and back.
// All terms are positive, so small probabilities are as exact as large ones, which comparing them needs.

// Both chosen by eye.
/// Probability κ that a walk ends at a step, if trajectories keep their label by default. A stroke over a uniform area then
/// takes what lies within about one distance of neighbours.
const ABSORPTION: f64 = 0.15;
/// The same if an object is divided among strokes: less, so that few strokes are enough.
const ABSORPTION_IN_DIVIDED: f64 = 0.05;

/// Sweeps end when no probability changes by more than this part of itself; chosen by eye.
const RELATIVE_TOLERANCE: f64 = 1e-3;
/// Largest number of sweeps; chosen by eye.
const MAX_SWEEPS: usize = 200;

/// The role of a trajectory in the walk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum WalkNode {
    /// Under the stroke of this number, where walks end.
    Seed(u8),
    /// Walks end here and reach no stroke.
    Fixed,
    /// Part of an object that is divided among the strokes.
    Free,
    /// Keeps its label unless most of its walks reach a stroke.
    Bound,
}

/// Returns the stroke of each node of `graph`; `None` for nodes that keep their label. There are `count` strokes.
pub(super) fn assign_to_strokes(graph: &SymCsr, nodes: &[WalkNode], count: u8) -> Vec<Option<u8>> {
    let start = |node: &WalkNode| match node {
        WalkNode::Seed(s) => (f64::INFINITY, Some(*s)),
        WalkNode::Fixed => (f64::INFINITY, None),
        WalkNode::Free => (0.0, None),
        WalkNode::Bound => (0.5, None),
    };
    let mut best: Vec<(f64, Option<u8>)> = nodes.iter().map(start).collect();
    let degrees = graph.degrees();
    for stroke in 0..count {
        for (best, reach) in best.iter_mut().zip(reach_probabilities(graph, &degrees, nodes, stroke)) {
            if reach > best.0 {
                *best = (reach, Some(stroke));
            }
        }
    }
    best.into_iter().map(|b| b.1).collect()
}

/// Computes the probability that a walk from each node ends at `stroke`.
fn reach_probabilities(graph: &SymCsr, degrees: &[f64], nodes: &[WalkNode], stroke: u8) -> Vec<f64> {
    let n = graph.len();
    let mut reach: Vec<f64> = nodes.iter().map(|node| f64::from(u8::from(*node == WalkNode::Seed(stroke)))).collect();
    for sweep in 0..MAX_SWEEPS {
        let mut is_changed = false;
        for k in 0..n {
            let i = if sweep % 2 == 0 { k } else { n - 1 - k };
            let survival = match nodes[i] {
                WalkNode::Free => 1.0 - ABSORPTION_IN_DIVIDED,
                WalkNode::Bound => 1.0 - ABSORPTION,
                _ => continue,
            };
            if degrees[i] > 0.0 {
                let next = survival * graph.row(i).map(|(j, w)| w * reach[j]).sum::<f64>() / degrees[i];
                is_changed |= (next - reach[i]).abs() > RELATIVE_TOLERANCE * next;
                reach[i] = next;
            }
        }
        if !is_changed {
            break;
        }
    }
    reach
}

#[cfg(test)]
mod tests {
    use super::*;
    use WalkNode::{Bound, Fixed, Free, Seed};

    #[test]
    fn only_pairs_that_stay_near_have_edges() {
        let mut tracks = Trajectories::empty(5, (200, 100));
        for (x, u) in [(10.0, 0.0), (18.0, 0.0), (26.0, 30.0), (150.0, 0.0)] {
            tracks.push(0, (0..5).map(|t| (x + u * t as f32, 20.0, 0.0)));
        }
        tracks.push(1, [(10.0, 20.0, 0.0), (10.0, 20.0, 0.0)]);
        let all = [(0, 1, 0.9), (0, 2, 0.9), (0, 3, 32.0), (0, 4, 0.5), (1, 2, 0.9)];
        let graph = proximity_graph(&SymCsr::from_upper(5, &all), &tracks, &[0, 1, 2, 3, 4], 8.0);
        let expected = 0.9 * (-(8.0_f64 / 20.0).powi(2)).exp();
        let row: Vec<_> = graph.row(0).collect();
        assert_eq!(row.iter().map(|e| e.0).collect::<Vec<_>>(), [1, 4]);
        assert!((row[0].1 - expected).abs() < 1e-6 && (row[1].1 - 0.5).abs() < 1e-6, "{row:?}");
        let some = proximity_graph(&SymCsr::from_upper(5, &all), &tracks, &[1, 4], 8.0);
        assert_eq!((some.len(), some.column.len()), (2, 0));
        assert!(proximity_graph(&SymCsr::default(), &Trajectories::default(), &[], 8.0).is_empty());
    }

    #[test]
    fn successors_of_the_same_velocity_have_edges() {
        let mut tracks = Trajectories::empty(12, (200, 100));
        let mut push = |start: usize, x: f32, u: f32| tracks.push(start, (0..4).map(|k| (x + u * k as f32, 20.0, 0.0)));
        push(0, 10.0, 3.0);
        // In its place two frames later; in its place, but still; too far away; too late.
        push(5, 25.0, 3.0);
        push(5, 25.0, 0.0);
        push(4, 90.0, 3.0);
        push(8, 34.0, 3.0);
        let graph = proximity_graph(&SymCsr::from_upper(5, &[]), &tracks, &[0, 1, 2, 3, 4], 8.0);
        let row: Vec<_> = graph.row(0).collect();
        assert!(row.len() == 2 && row[0].1 > 0.5 && row[1].1 < 0.1, "{row:?}");
        assert_eq!(graph.row(4).map(|e| e.0).collect::<Vec<_>>(), [1, 2]);
        graph.check().unwrap();
    }

    #[test]
    fn trajectories_of_a_single_frame_succeed_each_other_once() {
        let mut tracks = Trajectories::empty(1, (200, 100));
        (0..3).for_each(|k| tracks.push(0, [(10.0 + k as f32, 20.0, 0.0)]));
        let graph = proximity_graph(&SymCsr::from_upper(3, &[]), &tracks, &[0, 1, 2], 8.0);
        graph.check().unwrap();
        assert_eq!(graph.column.len(), 6);
    }

    /// A chain with these weights.
    fn chain(weights: &[f32]) -> SymCsr {
        let upper: Vec<_> = (0..).zip(weights).map(|(i, &w)| (i, i + 1, w)).collect();
        SymCsr::from_upper(weights.len() + 1, &upper)
    }

    #[test]
    fn between_two_strokes_the_weakest_edge_decides() {
        let graph = chain(&[1.0, 1.0, 1.0, 1.0, 0.1, 1.0]);
        let nodes = [Seed(0), Free, Free, Free, Free, Free, Seed(1)];
        let expected = [0, 0, 0, 0, 0, 1, 1].map(Some);
        assert_eq!(assign_to_strokes(&graph, &nodes, 2), expected);
    }

    #[test]
    fn reach_on_a_chain_dies_off_as_a_power_of_the_distance() {
        // u_k = r^k on a chain without end, where r = (1 − κ) (1 + r²) / 2.
        let graph = chain(&[1.0; 60]);
        for (kind, alive) in [(Bound, 0.85_f64), (Free, 0.95)] {
            let mut nodes = [kind; 61];
            nodes[0] = Seed(0);
            let r = (1.0 - (1.0 - alive * alive).sqrt()) / alive;
            for (k, found) in (0..20).zip(reach_probabilities(&graph, &graph.degrees(), &nodes, 0)) {
                assert!((found / r.powi(k) - 1.0).abs() < 0.01, "{k}: {found} for {}", r.powi(k));
            }
        }
        let mut bound = [Bound; 6];
        bound[0] = Seed(0);
        let strokes = assign_to_strokes(&chain(&[1.0; 5]), &bound, 1);
        assert_eq!(strokes, [Some(0), Some(0), None, None, None, None]);
    }

    #[test]
    fn nodes_that_no_walk_connects_to_a_stroke_keep_their_label() {
        let graph = SymCsr::from_upper(6, &[(0, 1, 1.0), (2, 3, 1.0), (4, 5, 1.0)]);
        let nodes = [Seed(0), Free, Free, Free, Fixed, Free];
        assert_eq!(assign_to_strokes(&graph, &nodes, 1), [Some(0), Some(0), None, None, None, None]);
        assert!(assign_to_strokes(&SymCsr::default(), &[], 3).is_empty());
        assert_eq!(assign_to_strokes(&graph, &[Free; 6], 0), [None; 6]);
    }
}
