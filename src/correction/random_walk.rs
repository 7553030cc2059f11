//! Assignment of trajectories to strokes by random walks with absorption.
//!
//! From a trajectory a walk goes to another with a probability proportional to their affinity; at each step it ends with
//! probability κ. `u_s` is the probability that it reaches stroke `s` before any other (Grady, "Random walks for image
//! segmentation", PAMI 2006), and each trajectory is assigned to the stroke with the largest one. The embedding has the same
//! walk, `P = D⁻¹ A`: its discontinuities are where walks seldom cross. Without κ a long stroke would win all trajectories
//! that are far from every stroke.
//!
//! If strokes change only a part of an object, κ is larger, and a trajectory is assigned to a stroke only if most of its
//! walks reach it.
//!
//! `u_s = (1 − κ) P u_s`, with 1 under the stroke and 0 under the others, is solved by Gauss-Seidel sweeps forward and back.
//! All terms are positive, so small probabilities are as exact as large ones, which comparing them needs.

use crate::sparse::SymCsr;

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
