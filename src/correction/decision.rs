//! The meaning of strokes: a label for each of them, and for the trajectories that follow it.
//!
//! **Joining.** All objects of which the strokes cover a good part become one, with the lowest label. The other trajectories
//! under the strokes, mostly background, join it together with those tied closely to them.
//!
//! **Splitting.** A stroke stands for the label that most of it covers. If several strokes stand for the same label:
//!
//! - those that also cover a good part of background, while others do not, are background: they remove a part that is wrongly
//!   labelled;
//! - so are strokes over an object without a trajectory under them: an area without motion, such as plain sky, is no object,
//!   and masks give it to whatever is beside it (both only if some cluster is background);
//! - of the others, the stroke with the largest part keeps the label, and each other one becomes a new object. An object is
//!   divided among its strokes; of the background a stroke takes only what is tied closely to it.
//!
//! Trajectories under a stroke always get its label; those under the strokes of earlier corrections keep theirs.

use super::graph::proximity_graph;
use super::graph::{WalkNode, assign_to_strokes};
use crate::Error;
use crate::sparse::SymCsr;
use crate::trajectory::Trajectories;

/// A stroke covers a good part of a label if at least this share of the stroke lies over it; chosen by eye.
const MIN_GOOD_PART: f64 = 0.2;

/// Strokes with the trajectories and labels under them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StrokeInput<'a> {
    pub(crate) tracks: &'a Trajectories,
    /// Distance of neighbouring trajectories, in pixels.
    pub(crate) spacing: f32,
    pub(crate) affinities: &'a SymCsr,
    /// The label of each trajectory.
    pub(crate) label: &'a [u8],
    /// The labels of all clusters.
    pub(crate) used_labels: &'a [u8],
    /// True for each trajectory whose label an earlier stroke fixes.
    pub(crate) is_fixed: &'a [bool],
    /// The stroke over each trajectory.
    pub(crate) stroke: &'a [Option<u8>],
    /// The mask labels of the pixels under the core of each stroke.
    pub(crate) core_labels: &'a [Vec<u8>],
}

/// The labels after a correction by strokes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Decision {
    /// The label of each trajectory.
    pub(crate) label: Vec<u8>,
    /// The label of each stroke.
    pub(crate) stroke_labels: Vec<u8>,
    /// The labels that may change: labels of strokes, and labels under them.
    pub(crate) affected: Vec<u8>,
}

/// Joins everything under the strokes into one object.
///
/// # Errors
/// [`Error::Data`] if the strokes cover no object, or if no background would remain.
pub(crate) fn join_strokes(input: &StrokeInput) -> Result<Decision, Error> {
    let mut covered = Vec::new();
    for histogram in input.histograms() {
        covered.extend(histogram.labels().filter(|&l| l > 0 && histogram.share(l) >= MIN_GOOD_PART));
    }
    if covered.is_empty() {
        let objects: Vec<u8> = input.core_labels.concat().into_iter().filter(|&l| l > 0).collect();
        covered.extend((!objects.is_empty()).then(|| LabelHistogram::new(&objects).most_common()));
    }
    let sources = distinct(&covered);
    let Some(&target) = sources.first() else {
        return Err(data("the strokes lie over no object (expected at least one to join)"));
    };
    let targets = vec![target; input.core_labels.len()];
    let mut label = input.label.to_vec();
    for l in label.iter_mut().filter(|l| sources.contains(l)) {
        *l = target;
    }
    for from in input.labels_under_strokes() {
        if !sources.contains(&from) {
            input.assign(from, &targets, WalkNode::Bound, &mut label);
        }
    }
    input.decision(label, targets, sources)
}

/// Makes each stroke an object of its own.
///
/// # Errors
/// [`Error::Data`] if a new object has no trajectories or no free label, or if no background would remain.
pub(crate) fn split_strokes(input: &StrokeInput) -> Result<Decision, Error> {
    let histograms = input.histograms();
    let main: Vec<u8> = histograms.iter().map(LabelHistogram::most_common).collect();
    let mut targets = main.clone();
    let mut free = free_labels(input.used_labels);
    let has_background = input.used_labels.contains(&0);
    let mut divided = Vec::new();
    for m in distinct(&main) {
        let rivals: Vec<usize> = (0..main.len()).filter(|&k| main[k] == m).collect();
        let is_empty = |k: usize| !input.stroke.contains(&Some(k as u8));
        let is_background =
            |k: &usize| m != 0 && has_background && (histograms[*k].share(0) >= MIN_GOOD_PART || is_empty(*k));
        let foreground: Vec<usize> = rivals.iter().copied().filter(|k| !is_background(k)).collect();
        let rivals = if foreground.is_empty() {
            rivals
        } else {
            rivals.iter().filter(|k| rivals.len() > 1 && is_background(k)).for_each(|&k| targets[k] = 0);
            foreground
        };
        if rivals.len() < 2 {
            continue;
        }
        if m != 0 {
            divided.push(m);
        }
        let keeper = input.largest_part(m, &rivals);
        for &k in rivals.iter().filter(|&&k| k != keeper) {
            targets[k] = free.next().ok_or_else(|| data(NO_FREE_LABEL))?;
            if is_empty(k) {
                return Err(data(&format!("stroke {k} lies over no trajectory: paint it longer or wider")));
            }
        }
    }
    let mut label = input.label.to_vec();
    for from in input.labels_under_strokes() {
        let kind = if divided.contains(&from) { WalkNode::Free } else { WalkNode::Bound };
        input.assign(from, &targets, kind, &mut label);
    }
    input.decision(label, targets, main)
}

impl StrokeInput<'_> {
    fn histograms(&self) -> Vec<LabelHistogram> {
        self.core_labels.iter().map(|labels| LabelHistogram::new(labels)).collect()
    }

    /// Returns the labels of the trajectories under strokes.
    fn labels_under_strokes(&self) -> Vec<u8> {
        let under = self.label.iter().zip(self.stroke).filter(|(_, stroke)| stroke.is_some());
        distinct(&under.map(|(&l, _)| l).collect::<Vec<_>>())
    }

    /// Assigns trajectories labelled `from` to the strokes that they are tied to. Those not under a stroke are nodes of this
    /// kind.
    fn assign(&self, from: u8, targets: &[u8], kind: WalkNode, label: &mut [u8]) {
        let members = self.members(from);
        let node = |&i: &u32| match self.stroke[i as usize] {
            Some(k) if kind == WalkNode::Bound && targets[usize::from(k)] == from => WalkNode::Fixed,
            Some(k) => WalkNode::Seed(k),
            None if self.is_fixed[i as usize] => WalkNode::Fixed,
            None => kind,
        };
        let nodes: Vec<WalkNode> = members.iter().map(node).collect();
        if !nodes.iter().any(|node| matches!(node, WalkNode::Seed(_))) {
            return;
        }
        let graph = proximity_graph(self.affinities, self.tracks, &members, self.spacing);
        for (&i, stroke) in members.iter().zip(assign_to_strokes(&graph, &nodes, targets.len() as u8)) {
            label[i as usize] = stroke.map_or(from, |k| targets[usize::from(k)]);
        }
    }

    /// Returns the stroke with the largest part of label `m`, in points of trajectories; the first of equal ones.
    fn largest_part(&self, m: u8, rivals: &[usize]) -> usize {
        let members = self.members(m);
        let node = |&i: &u32| match self.stroke[i as usize] {
            Some(k) if rivals.contains(&usize::from(k)) => WalkNode::Seed(k),
            _ => WalkNode::Free,
        };
        let nodes: Vec<WalkNode> = members.iter().map(node).collect();
        let graph = proximity_graph(self.affinities, self.tracks, &members, self.spacing);
        let strokes = assign_to_strokes(&graph, &nodes, self.core_labels.len() as u8);
        let num_points = |k: usize| -> usize {
            let part = members.iter().zip(&strokes).filter(|(_, stroke)| stroke.is_some_and(|s| usize::from(s) == k));
            part.map(|(&i, _)| self.tracks.points(i as usize).len()).sum()
        };
        rivals.iter().copied().rev().max_by_key(|&k| num_points(k)).unwrap_or(0)
    }

    fn members(&self, label: u8) -> Vec<u32> {
        (0..).zip(self.label).filter(|(_, l)| **l == label).map(|(i, _)| i).collect()
    }

    fn decision(&self, label: Vec<u8>, stroke_labels: Vec<u8>, mut affected: Vec<u8>) -> Result<Decision, Error> {
        if self.label.contains(&0) && !label.contains(&0) {
            return Err(data("no background would be left"));
        }
        affected.extend(&stroke_labels);
        affected.extend(self.labels_under_strokes());
        self.core_labels.iter().for_each(|labels| affected.extend(labels));
        let affected = distinct(&affected);
        Ok(Decision { label, stroke_labels, affected })
    }
}

/// The number of a stroke's pixels over each label.
struct LabelHistogram {
    /// Labels, increasing, with their pixels.
    counts: Vec<(u8, u32)>,
    total: usize,
}

impl LabelHistogram {
    fn new(labels: &[u8]) -> Self {
        let count = |l: u8| (l, labels.iter().filter(|&&label| label == l).count() as u32);
        Self { counts: distinct(labels).into_iter().map(count).collect(), total: labels.len() }
    }

    fn labels(&self) -> impl Iterator<Item = u8> + '_ {
        self.counts.iter().map(|c| c.0)
    }

    fn share(&self, label: u8) -> f64 {
        let count = self.counts.iter().find(|c| c.0 == label).map_or(0, |c| c.1);
        f64::from(count) / self.total.max(1) as f64
    }

    /// Returns the most common label, the lowest of equally common ones.
    fn most_common(&self) -> u8 {
        self.counts.iter().rev().max_by_key(|c| c.1).map_or(0, |c| c.0)
    }
}

/// The message of corrections that need another label.
pub(crate) const NO_FREE_LABEL: &str = "all 255 labels are in use: merge objects first";

fn data(reason: &str) -> Error {
    Error::Data { reason: reason.to_owned() }
}

/// Returns the different labels of a list, lowest first.
pub(crate) fn distinct(labels: &[u8]) -> Vec<u8> {
    let mut is_used = [false; 256];
    labels.iter().for_each(|&l| is_used[usize::from(l)] = true);
    (0..=255).filter(|&l| is_used[usize::from(l)]).collect()
}

/// Returns the labels that a new object may take, lowest first.
pub(crate) fn free_labels(used: &[u8]) -> impl Iterator<Item = u8> + '_ {
    (1..=255).filter(|l| !used.contains(l))
}
