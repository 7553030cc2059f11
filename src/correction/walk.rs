//! Which stroke each trajectory belongs to: random walks over the affinities that end at strokes.
//!
//! From a trajectory a walk goes to another with a probability in proportion to their affinity, and on from there; at
//! each step it may die. `u_s` is the probability that it comes to stroke `s` before any other (Grady, "Random walks
//! for image segmentation", PAMI 2006). The embedding has the same walk, `P = D⁻¹ A`: what it seldom crosses is where
//! the embedding has its discontinuities. Between strokes, each trajectory goes with the one that is reached most
//! often. That walks die makes the near count more than the many: without it, a long stroke would take whatever is far
//! from all of them.
//!
//! Where strokes are to change a part of something only, walks die sooner, and a trajectory goes with a stroke only if
//! most of its walks get there alive: those that are bound closely to the stroke.
//!
//! `u_s = (1 − κ) P u_s`, with 1 under the stroke and 0 under the others, by Gauss-Seidel sweeps forward and back. All
//! terms are positive, so that small probabilities are as exact as large ones, which is what comparing them takes.

use crate::sparse::SymCsr;

/// How often a walk dies at a step where things are to stay as they are. At 0.15 a stroke over a uniform area takes
/// along what lies within about one distance of neighbours.
const DEATH: f64 = 0.15;
/// The same where a thing is divided: less, so that strokes need not be everywhere.
const RARE_DEATH: f64 = 0.05;

/// Sweeps are over when none changes a probability by more than this part of it, and after `MAX_SWEEPS` at the latest.
const TOLERANCE: f64 = 1e-3;
const MAX_SWEEPS: usize = 200;

/// What a trajectory is in the walk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Walker {
    /// Under a stroke, of this number: walks end here.
    Under(u8),
    /// Walks end here and reach no stroke.
    Settled,
    /// Part of something that strokes divide.
    Free,
    /// Part of something that is to stay as it is where strokes do not reach far.
    Bound,
}

/// The stroke that each node of `graph` goes with; `None` for those that go with none. There are `count` strokes.
pub(crate) fn nearest_stroke(graph: &SymCsr, walkers: &[Walker], count: u8) -> Vec<Option<u8>> {
    let start = |w: &Walker| match w {
        Walker::Under(s) => (f64::INFINITY, Some(*s)),
        Walker::Settled => (f64::INFINITY, None),
        Walker::Free => (0.0, None),
        Walker::Bound => (0.5, None),
    };
    let mut best: Vec<(f64, Option<u8>)> = walkers.iter().map(start).collect();
    let degrees = graph.degrees();
    for stroke in 0..count {
        for (best, reach) in best.iter_mut().zip(reach(graph, &degrees, walkers, stroke)) {
            if reach > best.0 {
                *best = (reach, Some(stroke));
            }
        }
    }
    best.into_iter().map(|b| b.1).collect()
}

/// How often walks from each node end at `stroke`.
fn reach(graph: &SymCsr, degrees: &[f64], walkers: &[Walker], stroke: u8) -> Vec<f64> {
    let n = graph.len();
    let mut reach: Vec<f64> = walkers.iter().map(|w| f64::from(u8::from(*w == Walker::Under(stroke)))).collect();
    for sweep in 0..MAX_SWEEPS {
        let mut moved = false;
        for k in 0..n {
            let i = if sweep % 2 == 0 { k } else { n - 1 - k };
            let alive = match walkers[i] {
                Walker::Free => 1.0 - RARE_DEATH,
                Walker::Bound => 1.0 - DEATH,
                _ => continue,
            };
            if degrees[i] > 0.0 {
                let next = alive * graph.row(i).map(|(j, w)| w * reach[j]).sum::<f64>() / degrees[i];
                moved |= (next - reach[i]).abs() > TOLERANCE * next;
                reach[i] = next;
            }
        }
        if !moved {
            break;
        }
    }
    reach
}

#[cfg(test)]
mod tests {
    use super::*;
    use Walker::{Bound, Free, Settled, Under};

    /// A chain with these weights.
    fn chain(weights: &[f32]) -> SymCsr {
        let upper: Vec<_> = (0..).zip(weights).map(|(i, &w)| (i, i + 1, w)).collect();
        SymCsr::from_upper(weights.len() + 1, &upper)
    }

    #[test]
    fn between_two_strokes_the_weakest_place_decides() {
        let graph = chain(&[1.0, 1.0, 1.0, 1.0, 0.1, 1.0]);
        let walkers = [Under(0), Free, Free, Free, Free, Free, Under(1)];
        let expected = [0, 0, 0, 0, 0, 1, 1].map(Some);
        assert_eq!(nearest_stroke(&graph, &walkers, 2), expected);
    }

    #[test]
    fn reach_on_a_chain_dies_off_as_a_power_of_the_distance() {
        // u_k = r^k on a chain without end, where r = (1 − κ) (1 + r²) / 2.
        let graph = chain(&[1.0; 60]);
        for (kind, alive) in [(Bound, 0.85_f64), (Free, 0.95)] {
            let mut walkers = [kind; 61];
            walkers[0] = Under(0);
            let r = (1.0 - (1.0 - alive * alive).sqrt()) / alive;
            for (k, found) in (0..20).zip(reach(&graph, &graph.degrees(), &walkers, 0)) {
                assert!((found / r.powi(k) - 1.0).abs() < 0.01, "{k}: {found} for {}", r.powi(k));
            }
        }
        let mut bound = [Bound; 6];
        bound[0] = Under(0);
        let went = nearest_stroke(&chain(&[1.0; 5]), &bound, 1);
        assert_eq!(went, [Some(0), Some(0), None, None, None, None]);
    }

    #[test]
    fn what_no_walk_leads_to_a_stroke_from_goes_with_none() {
        let graph = SymCsr::from_upper(6, &[(0, 1, 1.0), (2, 3, 1.0), (4, 5, 1.0)]);
        let walkers = [Under(0), Free, Free, Free, Settled, Free];
        assert_eq!(nearest_stroke(&graph, &walkers, 1), [Some(0), Some(0), None, None, None, None]);
        assert!(nearest_stroke(&SymCsr::default(), &[], 3).is_empty());
        assert_eq!(nearest_stroke(&graph, &[Free; 6], 0), [None; 6]);
    }
}
