//! What strokes mean: a label for each of them, and for the trajectories that go with it.
//!
//! **Together.** All objects that the strokes lie over to a good part become one, with the lowest label. Whatever else
//! is under them joins it, background above all, with what is bound to that closely.
//!
//! **Apart.** A stroke stands for the label that most of it lies over. Where several stand for the same:
//!
//! - those that also lie over background to a good part, while others do not, are background: they take out of an
//!   object what is none;
//! - so are strokes over an object that lie over no trajectory: what nothing moves in, such as a plain sky, is no
//!   object, and masks give it to whatever lies beside it (both only where some cluster is background);
//! - of the others, that with the larger part keeps the label, and each of the rest becomes a new object. An object is
//!   divided between its strokes. Of the background only as much is taken as is bound closely to the stroke.
//!
//! Trajectories under a stroke have its label in any case; those under the strokes of earlier corrections keep theirs.

use super::graph::near_affinities;
use crate::Error;
use crate::sparse::SymCsr;
use crate::trajectory::Trajectories;

/// A stroke lies over a label to a good part if this share of it does.
const GOOD_PART: f64 = 0.2;

/// What strokes are judged by.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Painted<'a> {
    /// The trajectories, and the distance of neighbours, in the same pixels.
    pub tracks: &'a Trajectories,
    /// Distance of neighbours.
    pub spacing: f32,
    /// Their affinities.
    pub affinities: &'a SymCsr,
    /// The label that each has.
    pub label: &'a [u8],
    /// The labels that some cluster has.
    pub used: &'a [u8],
    /// Which of them earlier strokes hold.
    pub settled: &'a [bool],
    /// The stroke that each is under.
    pub under: &'a [Option<u8>],
    /// The mask labels of the pixels of each stroke's core.
    pub over: &'a [Vec<u8>],
}

/// What becomes of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Decision {
    /// The label of each trajectory.
    pub label: Vec<u8>,
    /// The label of each stroke.
    pub of_stroke: Vec<u8>,
    /// Labels that are given or taken: those of strokes, and whatever lies under them.
    pub concerned: Vec<u8>,
}

/// All that the strokes touch is one thing.
///
/// # Errors
/// [`Error::Data`] where they touch no object, or leave no background.
pub(crate) fn together(painted: &Painted) -> Result<Decision, Error> {
    let shares: Vec<Shares> = painted.over.iter().map(|over| Shares::of(over)).collect();
    let mut joined = Vec::new();
    for s in &shares {
        joined.extend(s.labels().filter(|&l| l > 0 && s.part(l) >= GOOD_PART));
    }
    if joined.is_empty() {
        let all = Shares::of(&painted.over.concat().into_iter().filter(|&l| l > 0).collect::<Vec<_>>());
        joined.extend(all.labels().next().map(|_| all.main()));
    }
    let joined = distinct(&joined);
    let Some(&target) = joined.first() else {
        return Err(data("the strokes lie over no object: together needs at least one, for others to join"));
    };
    let targets = vec![target; painted.over.len()];
    let mut label = painted.label.to_vec();
    for l in label.iter_mut().filter(|l| joined.contains(l)) {
        *l = target;
    }
    for from in painted.labels_under() {
        if !joined.contains(&from) {
            painted.follow(from, &targets, Walker::Bound, &mut label);
        }
    }
    painted.decided(label, targets, joined)
}

/// Each stroke is a thing of its own.
///
/// # Errors
/// [`Error::Data`] where there are no trajectories or no free label for a new object, or where no background is left.
pub(crate) fn apart(painted: &Painted) -> Result<Decision, Error> {
    let shares: Vec<Shares> = painted.over.iter().map(|over| Shares::of(over)).collect();
    let main: Vec<u8> = shares.iter().map(Shares::main).collect();
    let mut targets = main.clone();
    let mut free = free_labels(painted.used);
    let has_background = painted.used.contains(&0);
    let mut divided = Vec::new();
    for m in distinct(&main) {
        let rivals: Vec<usize> = (0..main.len()).filter(|&k| main[k] == m).collect();
        let is_empty = |k: usize| !painted.under.contains(&Some(k as u8));
        let leaves = |k: &usize| m != 0 && has_background && (shares[*k].part(0) >= GOOD_PART || is_empty(*k));
        let stays: Vec<usize> = rivals.iter().copied().filter(|k| !leaves(k)).collect();
        let rivals = if stays.is_empty() {
            rivals
        } else {
            rivals.iter().filter(|k| rivals.len() > 1 && leaves(k)).for_each(|&k| targets[k] = 0);
            stays
        };
        if rivals.len() < 2 {
            continue;
        }
        if m != 0 {
            divided.push(m);
        }
        let keeper = painted.largest_part(m, &rivals);
        for &k in rivals.iter().filter(|&&k| k != keeper) {
            targets[k] = free.next().ok_or_else(|| data("all 255 labels are in use: merge some first"))?;
            if is_empty(k) {
                let reason = format!(
                    "stroke {k} lies over no trajectory that a new object could be made of: paint it longer or wider"
                );
                return Err(data(&reason));
            }
        }
    }
    let mut label = painted.label.to_vec();
    for from in painted.labels_under() {
        let kind = if divided.contains(&from) { Walker::Free } else { Walker::Bound };
        painted.follow(from, &targets, kind, &mut label);
    }
    painted.decided(label, targets, main)
}

impl Painted<'_> {
    /// The labels of the trajectories under strokes.
    fn labels_under(&self) -> Vec<u8> {
        let under = self.label.iter().zip(self.under).filter(|(_, under)| under.is_some());
        distinct(&under.map(|(&l, _)| l).collect::<Vec<_>>())
    }

    /// Trajectories labelled `from` that strokes take along get their label. The others are of this kind.
    fn follow(&self, from: u8, targets: &[u8], kind: Walker, label: &mut [u8]) {
        let members = self.members(from);
        let walkers: Vec<Walker> = members
            .iter()
            .map(|&i| match self.under[i as usize] {
                Some(k) if kind == Walker::Bound && targets[usize::from(k)] == from => Walker::Settled,
                Some(k) => Walker::Under(k),
                None if self.settled[i as usize] => Walker::Settled,
                None => kind,
            })
            .collect();
        if !walkers.iter().any(|w| matches!(w, Walker::Under(_))) {
            return;
        }
        let graph = near_affinities(self.affinities, self.tracks, &members, self.spacing);
        for (&i, stroke) in members.iter().zip(nearest_stroke(&graph, &walkers, targets.len() as u8)) {
            label[i as usize] = stroke.map_or(from, |k| targets[usize::from(k)]);
        }
    }

    /// Which of some strokes has the largest part of label `m`, in points of trajectories; the first of equal ones.
    fn largest_part(&self, m: u8, rivals: &[usize]) -> usize {
        let members = self.members(m);
        let walkers: Vec<Walker> = members
            .iter()
            .map(|&i| match self.under[i as usize] {
                Some(k) if rivals.contains(&usize::from(k)) => Walker::Under(k),
                _ => Walker::Free,
            })
            .collect();
        let graph = near_affinities(self.affinities, self.tracks, &members, self.spacing);
        let parts = nearest_stroke(&graph, &walkers, self.over.len() as u8);
        let points = |k: usize| -> usize {
            let of_part = members.iter().zip(&parts).filter(|(_, part)| part.is_some_and(|p| usize::from(p) == k));
            of_part.map(|(&i, _)| self.tracks.points(i as usize).len()).sum()
        };
        rivals.iter().copied().rev().max_by_key(|&k| points(k)).unwrap_or(0)
    }

    fn members(&self, label: u8) -> Vec<u32> {
        (0..).zip(self.label).filter(|(_, l)| **l == label).map(|(i, _)| i).collect()
    }

    fn decided(&self, label: Vec<u8>, of_stroke: Vec<u8>, mut concerned: Vec<u8>) -> Result<Decision, Error> {
        if self.label.contains(&0) && !label.contains(&0) {
            return Err(data("nothing would be left of the background"));
        }
        concerned.extend(&of_stroke);
        concerned.extend(self.labels_under());
        self.over.iter().for_each(|over| concerned.extend(over));
        let concerned = distinct(&concerned);
        Ok(Decision { label, of_stroke, concerned })
    }
}

/// How many pixels of a stroke lie over each label.
struct Shares {
    /// Labels, increasing, and their pixels.
    pixels: Vec<(u8, u32)>,
    all: usize,
}

impl Shares {
    fn of(over: &[u8]) -> Self {
        let count = |l: u8| (l, over.iter().filter(|&&o| o == l).count() as u32);
        Self { pixels: distinct(over).into_iter().map(count).collect(), all: over.len() }
    }

    fn labels(&self) -> impl Iterator<Item = u8> + '_ {
        self.pixels.iter().map(|p| p.0)
    }

    fn part(&self, label: u8) -> f64 {
        let pixels = self.pixels.iter().find(|p| p.0 == label).map_or(0, |p| p.1);
        f64::from(pixels) / self.all.max(1) as f64
    }

    /// The label of most pixels, the lowest of equal ones.
    fn main(&self) -> u8 {
        self.pixels.iter().rev().max_by_key(|p| p.1).map_or(0, |p| p.0)
    }
}

fn data(reason: &str) -> Error {
    Error::Data { reason: reason.to_owned() }
}

/// Labels, each once, lowest first.
pub(crate) fn distinct(labels: &[u8]) -> Vec<u8> {
    let mut seen = [false; 256];
    labels.iter().for_each(|&l| seen[usize::from(l)] = true);
    (0..=255).filter(|&l| seen[usize::from(l)]).collect()
}

/// The labels that objects may take, lowest first: those that are not in use.
pub(crate) fn free_labels(used: &[u8]) -> impl Iterator<Item = u8> + '_ {
    (1..=255).filter(|l| !used.contains(l))
}

// Which stroke each trajectory belongs to: random walks over the affinities that end at strokes.
//
// From a trajectory a walk goes to another with a probability in proportion to their affinity, and on from there; at
// each step it may die. `u_s` is the probability that it comes to stroke `s` before any other (Grady, "Random walks
// for image segmentation", PAMI 2006). The embedding has the same walk, `P = D⁻¹ A`: what it seldom crosses is where
// the embedding has its discontinuities. Between strokes, each trajectory goes with the one that is reached most
// often. That walks die makes the near count more than the many: without it, a long stroke would take whatever is far
// from all of them.
//
// Where strokes are to change a part of something only, walks die sooner, and a trajectory goes with a stroke only if
// most of its walks get there alive: those that are bound closely to the stroke.
//
// `u_s = (1 − κ) P u_s`, with 1 under the stroke and 0 under the others, by Gauss-Seidel sweeps forward and back. All
// terms are positive, so that small probabilities are as exact as large ones, which is what comparing them takes.

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
enum Walker {
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
fn nearest_stroke(graph: &SymCsr, walkers: &[Walker], count: u8) -> Vec<Option<u8>> {
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
