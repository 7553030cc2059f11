//! The Gabriel cut (section 4.2): from labelled trajectories and superpixels to a label for every superpixel of the
//! clip.
//!
//! In: [`CutInput`], the superpixels of all frames, trajectories with the labels of their clusters. Out: [`CutLabels`].
//! The labelling f has little energy
//!
//! ```text
//! E(f) = Σ_r λ_r (1 − h_r(f_r)) + Σ_spatial w_pq [f_p ≠ f_q] + Σ_temporal fl_pq [f_p ≠ f_q]
//! ```
//!
//! over the superpixels r of all frames at once (`terms`), found by alpha-expansion (`expansion`) with minimum cuts
//! (`maxflow`). `h_r` is the normalised histogram of the labels of the trajectories that cross r; λ_r is zero where
//! there are none, and can be lowered where trajectories of different labels mix (`ambiguous`).
//!
//! **Misprints resolved.** The paper prints the mean Pb itself as the cost of parting two neighbours, which makes
//! strong contours dear to cut; its Figure 6 says the contrary, so the cost falls with Pb here. Its temporal
//! neighbourhood bears the spatial one's name.
//!
//! **Beyond the paper**, each with its own parameter: borders count by their length; colours speak where there are no
//! trajectories; short trajectories that move like nothing around them count for all objects; and the cut is made anew
//! with what its objects look like (`appearance`).
//! [`Params::paper`](crate::Params::paper) has none of this. All numbers are whole once the terms are made,
//! and the terms use no function of the standard library that differs between machines: labels are the same everywhere.

mod appearance;
mod colour;
mod expansion;
mod input;
mod maxflow;
mod params;
mod terms;
#[cfg(test)]
mod tests;
mod votes;

pub use appearance::add_appearance;
pub(crate) use colour::{Colour, Corners, Histogram, UNSEEN};
pub(crate) use expansion::rounded;
#[doc(hidden)]
pub use expansion::{Expansion, Potts};
pub use input::{CutInput, CutLabels, STRANGER, UNKNOWN};
pub use params::CutParams;
#[cfg(test)]
pub(crate) use terms::OwnCost;
pub(crate) use terms::pixel_of;
pub(crate) use terms::{Link, Reasons, STEPS_PER_UNIT, margins};
pub(crate) use votes::{VOTE_MOTION, VOTE_RADIUS, motion_difference_sq};
pub use votes::{forget_strangers, labels_for};

use crate::image::Plane;
use crate::superpixel::Superpixels;
use expansion::MAX_WEIGHT;
use terms::{Nodes, energy};

/// The Gabriel cut in steps, each one move of the expansion.
#[derive(Debug, Clone)]
pub(crate) struct GabrielCut {
    expansion: Expansion,
    nodes: Nodes,
    counts: Vec<usize>,
    /// What the expansion is a part of: the labels of all superpixels, and which superpixels and labels take part.
    rest: Option<(Vec<u32>, Vec<u32>, Vec<u32>)>,
}

impl GabrielCut {
    /// Makes the energy; the longest of all steps.
    pub(crate) fn new(input: &CutInput, params: &CutParams) -> Self {
        let nodes = Nodes::new(input);
        let problem = terms::energy_at(input, params, &nodes);
        let start = terms::first_labels(&problem);
        Self { expansion: Expansion::new(problem, start), nodes, counts: counts(input), rest: None }
    }

    /// The same in a part of the clip, from the labels there on.
    pub(crate) fn within(input: &CutInput, params: &CutParams, region: &Region) -> Self {
        let part = Part::new(input, params, region);
        let start = part.present();
        let Part { problem, all, nodes, labels } = part;
        let rest = Some((all, nodes, labels));
        let nodes = Nodes::new(input);
        Self { expansion: Expansion::new(problem, start), nodes, counts: counts(input), rest }
    }

    /// Begins anew with the same links and trajectories: their labels and what speaks for labels may be others.
    pub(crate) fn begin_again(&mut self, input: &CutInput, params: &CutParams) {
        self.expansion.begin_with(terms::own_costs(input, params, &self.nodes), terms::first_labels);
    }

    /// Makes one move. Returns whether any is left.
    pub(crate) fn step(&mut self) -> bool {
        self.expansion.step();
        !self.expansion.is_finished()
    }

    /// Moves made, and how many it will have been if none of those left changes anything.
    pub(crate) fn progress(&self) -> (u32, u32) {
        self.expansion.progress()
    }

    /// Makes the moves that are left and returns the labels.
    pub(crate) fn finish(mut self) -> CutLabels {
        while self.step() {}
        self.labels()
    }

    /// The energy of the labels as they are now, with another label for one superpixel; `None` where it has no such choice.
    #[cfg(test)]
    pub(crate) fn energy_if(&self, node: u32, label: u32) -> Option<i64> {
        let (node, label) = match &self.rest {
            None => (node as usize, label),
            Some((_, nodes, labels)) => (nodes.binary_search(&node).ok()?, labels.binary_search(&label).ok()? as u32),
        };
        let mut found = self.expansion.labels().to_vec();
        found[node] = label;
        Some(self.expansion.problem().energy(&found))
    }

    /// The labels as they are now.
    pub(crate) fn labels(&self) -> CutLabels {
        let mut label = self.expansion.labels().to_vec();
        if let Some((all, nodes, labels)) = &self.rest {
            label = Part::merged(all.clone(), nodes, labels, &label);
        }
        let mut rest = label.as_slice();
        let mut take = |count: usize| {
            let (frame, after) = rest.split_at(count);
            rest = after;
            frame.to_vec()
        };
        CutLabels { labels: self.counts.iter().map(|&count| take(count)).collect() }
    }
}

// The cut anew in a part of the clip: superpixels of some labels choose among these labels again; all others keep
// theirs.
//
// What a superpixel beyond the region has can be no choice of those inside, so that an edge between them costs the
// same whatever is chosen, and falls away. What is left is a problem of its own, smaller in nodes and labels; where
// two labels are concerned, one cut solves it.

/// Which superpixels may change, and how.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Region<'a> {
    /// The label of each superpixel, frame by frame, as it is.
    pub present: &'a [Vec<u32>],
    /// Which labels can be given and taken.
    pub open: &'a [bool],
    /// Superpixels that must have one of some labels: frame, superpixel, and whether each label is legal. Of those
    /// without a legal label that is open nothing is asked.
    pub held: &'a [(usize, u32, Vec<bool>)],
}

/// A part of a problem.
#[derive(Debug, Clone)]
struct Part {
    problem: Potts,
    /// The label of every node of the whole, as it is.
    all: Vec<u32>,
    /// Node and label of the whole for each of the part.
    nodes: Vec<u32>,
    labels: Vec<u32>,
}

impl Part {
    fn new(input: &CutInput, params: &CutParams, region: &Region) -> Self {
        let whole = energy(input, params);
        let is_open = |label: u32| region.open.get(label as usize) == Some(&true);
        let mut all = region.present.concat();
        all.resize(whole.num_nodes, 0);
        let nodes: Vec<u32> = (0..whole.num_nodes as u32).filter(|&p| is_open(all[p as usize])).collect();
        let labels: Vec<u32> = (0..whole.num_labels as u32).filter(|&l| is_open(l)).collect();
        let mut problem = restricted(&whole, &nodes, &labels);
        let mut base = vec![0];
        for frame in region.present {
            base.push(base[base.len() - 1] + frame.len() as u32);
        }
        for (t, superpixel, legal) in region.held {
            let Ok(node) = nodes.binary_search(&(base[*t] + superpixel)) else { continue };
            let is_legal = |l: &u32| legal.get(*l as usize) == Some(&true);
            if labels.iter().any(is_legal) {
                let costs = &mut problem.unary[node * labels.len()..][..labels.len()];
                for (cost, _) in costs.iter_mut().zip(&labels).filter(|(_, l)| !is_legal(l)) {
                    *cost = MAX_WEIGHT;
                }
            }
        }
        Self { problem, all, nodes, labels }
    }

    /// The labels of the part as they are.
    fn present(&self) -> Vec<u32> {
        let place = |&p: &u32| self.labels.binary_search(&self.all[p as usize]).unwrap_or(0) as u32;
        self.nodes.iter().map(place).collect()
    }

    /// The labels of the whole, with those of the part.
    fn merged(mut all: Vec<u32>, nodes: &[u32], labels: &[u32], found: &[u32]) -> Vec<u32> {
        for (&p, &l) in nodes.iter().zip(found) {
            all[p as usize] = labels[l as usize];
        }
        all
    }
}

/// The problem on `nodes` and `labels` (both increasing).
fn restricted(whole: &Potts, nodes: &[u32], labels: &[u32]) -> Potts {
    let mut place = vec![u32::MAX; whole.num_nodes];
    for (k, &p) in (0..).zip(nodes) {
        place[p as usize] = k;
    }
    let cost = |p: u32, l: u32| whole.unary[p as usize * whole.num_labels + l as usize];
    let mut part = Potts {
        num_nodes: nodes.len(),
        num_labels: labels.len(),
        unary: nodes.iter().flat_map(|&p| labels.iter().map(move |&l| cost(p, l))).collect(),
        ..Potts::default()
    };
    for (&(p, q), &weight) in whole.edges.iter().zip(&whole.weights) {
        let ends = (place[p as usize], place[q as usize]);
        if ends.0 != u32::MAX && ends.1 != u32::MAX {
            part.edges.push(ends);
            part.weights.push(weight);
        }
    }
    part
}

/// Number of superpixels in each frame.
fn counts(input: &CutInput) -> Vec<usize> {
    input.superpixels.iter().map(|s| s.count).collect()
}

/// The labelling of least energy that alpha-expansion finds.
///
/// # Examples
/// Three superpixels in a row, trajectories in the outer two: that in the middle goes with the one that no contour parts
/// it from.
///
/// ```
/// use tracecut::cut::{CutInput, CutParams, gabriel_cut, paint};
/// use tracecut::image::Plane;
/// use tracecut::superpixel::{Border, Superpixels};
/// use tracecut::trajectory::Trajectories;
///
/// let rows = ["001122", "001122", "001122"];
/// let label = Plane::from_fn(6, 3, |x, y| u32::from(rows[y].as_bytes()[x] - b'0'));
/// // A weak border between 0 and 1, a strong one between 1 and 2.
/// let border = |a: u32, pb: f32| Border { a, b: a + 1, length: 3.0, pb };
/// let mut superpixels = [Superpixels::from(&label)];
/// superpixels[0].borders = vec![border(0, 0.01), border(1, 0.9)];
/// let mut tracks = Trajectories::empty(1, (6, 3));
/// tracks.push(0, [(0.0, 1.0, 0.0)]);
/// tracks.push(0, [(5.0, 1.0, 0.0)]);
/// let input = CutInput {
///     superpixels: &superpixels,
///     tracks: &tracks,
///     label: &[0, 1],
///     num_labels: 2,
///     objects: &[],
///     evidence: &[],
/// };
/// let cut = gabriel_cut(&input, &CutParams::default());
/// assert_eq!(cut.labels, [[0, 0, 1]]);
/// assert_eq!(paint(&superpixels[0], &cut.labels[0]).row(0), [0, 0, 0, 0, 1, 1]);
/// ```
#[must_use]
pub fn gabriel_cut(input: &CutInput, params: &CutParams) -> CutLabels {
    GabrielCut::new(input, params).finish()
}

/// One plane of cluster labels per frame, at the superpixels' size.
///
/// # Examples
/// ```
/// use tracecut::cut::paint;
/// use tracecut::image::Plane;
/// use tracecut::superpixel::Superpixels;
///
/// let label = Plane::from_fn(4, 1, |x, _| x as u32 / 2);
/// let superpixels = Superpixels::from(&label);
/// assert_eq!(paint(&superpixels, &[7, 3]).data(), [7, 7, 3, 3]);
/// ```
#[must_use]
pub fn paint(superpixels: &Superpixels, labels: &[u32]) -> Plane<u32> {
    superpixels.runs().map(|p| labels[p as usize])
}
