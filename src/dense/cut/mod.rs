//! Gabriel cut (section 4.2): from labelled trajectories and superpixels to a label for every superpixel of the clip.
//!
//! In: [`CutInput`], the superpixels of all frames, trajectories with the labels of their clusters. Out: [`CutLabels`].
//! The labelling f minimizes, approximately, the energy
//!
//! ```text
//! E(f) = Σ_r λ_r (1 − h_r(f_r)) + Σ_spatial w_pq [f_p ≠ f_q] + Σ_temporal fl_pq [f_p ≠ f_q]
//! ```
//!
//! over the superpixels r of all frames at once (`terms`), by alpha-expansion (`expansion`) with minimum cuts
//! (`maxflow`). `h_r` is the normalised histogram of the labels of the trajectories that cross r; λ_r is zero without
//! trajectories, and can be zero where trajectories of different labels mix.
//!
//! **Misprints resolved.** The paper prints the mean Pb itself as the cost of different labels, which makes strong contours
//! expensive to cut; its Figure 6 shows the contrary, so the cost falls with Pb here. Its temporal neighbourhood has the
//! spatial one's name.
//!
//! **Beyond the paper**, each with its own parameter: borders count by their length; short trajectories that move unlike
//! all around them count for all objects (`label_votes`); and the cut is repeated with the appearance of its objects
//! (`appearance`). [`Params::paper`](crate::Params::paper) has none of this.
//!
//! Cost: a minimum cut over all superpixels for each move, and two or three cycles of moves over the labels. It fails where an
//! object has no trajectories, or no contour. Energies are integers, and the terms use no function that differs between
//! machines: labels are the same everywhere.

mod appearance;
mod colour;
mod expansion;
mod forest;
mod label_votes;
mod maxflow;
mod terms;

#[doc(hidden)] // For `examples/method.rs`.
pub use appearance::appearance_log_odds;
pub(crate) use appearance::{ClipFeatures, label_kinds};
pub(crate) use appearance::{Features, superpixel_features};
pub(crate) use colour::{Colour, Corners, Histogram, UNSEEN_SHARE};
#[doc(hidden)]
pub use expansion::{Expansion, Potts};
pub(crate) use expansion::{STEPS_PER_UNIT, minimize, to_steps};
pub(crate) use label_votes::{VOTE_RADIUS_PX, propagate_labels};
#[cfg(test)]
pub(crate) use terms::UnaryCost;
pub(crate) use terms::{Link, SuperpixelTerms, margins, pixel_index};

use crate::image::Plane;
use crate::superpixel::Superpixels;
use crate::trajectory::Trajectories;
use expansion::{MAX_WEIGHT, NO_PART};
use terms::{Nodes, energy};

/// The Gabriel cut in steps of one move of the expansion.
#[derive(Debug, Clone)]
pub(crate) struct GabrielCut {
    expansion: Expansion,
    nodes: Nodes,
    /// Number of superpixels in each frame.
    counts: Vec<usize>,
    /// The part of the clip that is cut; `None` for all of it.
    part: Option<CutPart>,
}

impl GabrielCut {
    /// Computes the energy, the longest of all steps.
    pub(crate) fn new(input: &CutInput, params: &CutParams) -> Self {
        let nodes = Nodes::new(input);
        let problem = energy(input, params, &nodes);
        let start = terms::initial_labels(&problem);
        Self { expansion: Expansion::new(problem, start), nodes, counts: counts(input), part: None }
    }

    /// Cuts a part of the clip, starting from the labels there.
    pub(crate) fn of_region(input: &CutInput, params: &CutParams, region: &Region) -> Self {
        let nodes = Nodes::new(input);
        let (part, problem) = CutPart::new(&energy(input, params, &nodes), region);
        let start = part.initial_labels();
        Self { expansion: Expansion::new(problem, start), nodes, counts: counts(input), part: Some(part) }
    }

    /// Restarts with the same superpixels and trajectories, but other labels of these or other evidence.
    pub(crate) fn restart(&mut self, input: &CutInput, params: &CutParams) {
        self.expansion.restart_with(terms::unary_costs(input, params, &self.nodes), terms::initial_labels);
    }

    /// Makes one move. Returns `true` while there are more.
    pub(crate) fn step(&mut self) -> bool {
        self.expansion.step();
        !self.expansion.is_finished()
    }

    /// Returns the moves made so far, and their total if none of the remaining ones gains anything.
    pub(crate) fn progress(&self) -> (u32, u32) {
        self.expansion.progress()
    }

    /// Makes the remaining moves and returns the labels.
    pub(crate) fn finish(mut self) -> CutLabels {
        while self.step() {}
        self.labels()
    }

    /// Returns the energy of the current labels with another label for one superpixel; `None` if that is fixed.
    #[cfg(test)]
    pub(crate) fn energy_if(&self, node: u32, label: u32) -> Option<i64> {
        let (node, label) = match &self.part {
            None => (node as usize, label),
            Some(part) => (part.nodes.binary_search(&node).ok()?, part.labels.binary_search(&label).ok()? as u32),
        };
        let mut changed = self.expansion.labels().to_vec();
        changed[node] = label;
        Some(self.expansion.problem().energy(&changed))
    }

    /// Returns the number of moves if none but the first gains anything.
    pub(crate) fn min_moves(&self) -> usize {
        self.expansion.min_moves()
    }

    /// Returns the margin of each superpixel's label against labels of another kind, as [`margins`], of a cut of the whole clip.
    pub(crate) fn margins(&self, kind: &[u8]) -> Vec<f32> {
        terms::margins_of(self.expansion.problem(), self.expansion.labels(), kind)
    }

    /// Returns the current labels.
    pub(crate) fn labels(&self) -> CutLabels {
        let label = self.expansion.labels();
        let label = self.part.as_ref().map_or_else(|| label.to_vec(), |part| part.labels_of_clip(label));
        let mut labels = label.as_slice();
        let mut take = |count: usize| {
            let (frame, tail) = labels.split_at(count);
            labels = tail;
            frame.to_vec()
        };
        CutLabels { labels: self.counts.iter().map(|&count| take(count)).collect() }
    }
}

// Cuts of a part of the clip: superpixels of some labels are cut again among these labels, all others are fixed. A fixed
// superpixel has none of these labels, so that an edge to it has a constant cost and is left out. The remaining problem has
// fewer nodes and labels; with two labels one cut solves it.

/// Superpixels that a cut may change, and their labels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Region<'a> {
    /// The current label of each superpixel, frame by frame.
    pub current: &'a [Vec<u32>],
    /// `true` for each label that is cut again.
    pub open: &'a [bool],
    /// Superpixels with legal labels: frame, superpixel, and `true` for each legal label. Ignored if no legal label is
    /// open.
    pub constraints: &'a [(usize, u32, Vec<bool>)],
}

/// The part of a problem that is cut again.
#[derive(Debug, Clone)]
struct CutPart {
    /// The current label of every node of the clip.
    clip_labels: Vec<u32>,
    /// Nodes and labels of the clip that take part, both increasing.
    nodes: Vec<u32>,
    labels: Vec<u32>,
}

impl CutPart {
    fn new(clip: &Potts, region: &Region) -> (Self, Potts) {
        let is_open = |label: u32| region.open.get(label as usize) == Some(&true);
        let mut clip_labels = region.current.concat();
        clip_labels.resize(clip.num_nodes, 0);
        let nodes: Vec<u32> = (0..clip.num_nodes as u32).filter(|&p| is_open(clip_labels[p as usize])).collect();
        let labels: Vec<u32> = (0..clip.num_labels as u32).filter(|&l| is_open(l)).collect();
        let mut part_of = vec![NO_PART; clip.num_nodes];
        nodes.iter().for_each(|&p| part_of[p as usize] = 0);
        let mut problem = clip.split(&part_of, std::slice::from_ref(&labels)).remove(0);
        let mut base = vec![0];
        for frame in region.current {
            base.push(base[base.len() - 1] + frame.len() as u32);
        }
        for (t, superpixel, legal) in region.constraints {
            let Ok(node) = nodes.binary_search(&(base[*t] + superpixel)) else { continue };
            let is_legal = |l: &u32| legal.get(*l as usize) == Some(&true);
            if labels.iter().any(is_legal) {
                let costs = &mut problem.unary[node * labels.len()..][..labels.len()];
                for (cost, _) in costs.iter_mut().zip(&labels).filter(|(_, l)| !is_legal(l)) {
                    *cost = MAX_WEIGHT;
                }
            }
        }
        (Self { clip_labels, nodes, labels }, problem)
    }

    /// The current labels of the part, in its own numbers.
    fn initial_labels(&self) -> Vec<u32> {
        let label = |&p: &u32| self.labels.binary_search(&self.clip_labels[p as usize]).unwrap_or(0) as u32;
        self.nodes.iter().map(label).collect()
    }

    /// Extends labels of the part to the whole clip.
    fn labels_of_clip(&self, part_labels: &[u32]) -> Vec<u32> {
        let mut clip_labels = self.clip_labels.clone();
        for (&p, &l) in self.nodes.iter().zip(part_labels) {
            clip_labels[p as usize] = self.labels[l as usize];
        }
        clip_labels
    }
}

/// Number of superpixels in each frame.
fn counts(input: &CutInput) -> Vec<usize> {
    input.superpixels.iter().map(|s| s.count).collect()
}

/// Labels all superpixels of the clip by alpha-expansion.
///
/// # Examples
/// Three superpixels in a row, trajectories in the outer two: the middle one has the label of the neighbour across the
/// weaker contour.
///
/// ```
/// use tracecut::cut::{CutInput, CutParams, gabriel_cut, paint};
/// use tracecut::image::Plane;
/// use tracecut::superpixel::{SuperpixelBorder, Superpixels};
/// use tracecut::trajectory::Trajectories;
///
/// let rows = ["001122", "001122", "001122"];
/// let label = Plane::from_fn(6, 3, |x, y| u32::from(rows[y].as_bytes()[x] - b'0'));
/// // A weak border between 0 and 1, a strong one between 1 and 2.
/// let border = |a: u32, pb: f32| SuperpixelBorder { a, b: a + 1, length: 3.0, pb };
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
///     appearance: &[],
/// };
/// let cut = gabriel_cut(&input, &CutParams::default());
/// assert_eq!(cut.labels, [[0, 0, 1]]);
/// assert_eq!(paint(&superpixels[0], &cut.labels[0]).row(0), [0, 0, 0, 0, 1, 1]);
/// ```
#[must_use]
pub fn gabriel_cut(input: &CutInput, params: &CutParams) -> CutLabels {
    GabrielCut::new(input, params).finish()
}

/// Paints the labels of a frame's superpixels on a plane.
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

crate::params! {
    /// The Gabriel cut.
    pub struct CutParams {
        /// Weight of a superpixel's own trajectories (λ of section 4.2, whose value the paper does not give).
        pub unary_weight: f32 = 1.0, in 0.0..=1000.0, expert;
        /// Weight of the border between two superpixels of a frame. Higher makes labels smoother.
        pub spatial_weight: f32 = 2.0, in 0.0..=1000.0;
        /// A border costs `exp(−mean Pb / this)` to cut. The paper prints the mean Pb itself, a misprint.
        pub pb_scale: f32 = 0.03, in 0.001..=100.0, expert;
        /// Weights borders by their length, relative to the mean and within 0.05 to 4. The paper does not.
        pub weight_by_length: bool = true, in 0..=1, expert;
        /// Weight of the share of common trajectories between superpixels of consecutive frames.
        pub temporal_weight: f32 = 1.0, in 0.0..=1000.0;
        /// Number of further cuts, each with the appearance of objects and background, as learned from the cut before. Not
        /// in the paper; docs/choices.md.
        pub appearance_rounds: u32 = 3, in 0..=10, expert;
        /// Weight of the log-odds by appearance in these cuts.
        pub appearance_weight: f32 = 0.8, in 0.0..=100.0, expert;
        /// Factor on the weight of trajectories in these cuts, as what they told is learned.
        pub appearance_unary_factor: f32 = 0.35, in 0.0..=1.0, expert;
        /// A superpixel's own trajectories do not count if a larger share of it than this lies between trajectories of
        /// different labels (section 4.2: 0.3). 1 turns the rule off.
        pub ambiguous_share: f32 = 0.3, in 0.0..=1.0, expert;
    }
}

impl CutParams {
    /// The paper's energy, with its misprints resolved: nothing by length, all weights 1.
    ///
    /// From outside: `preset` = `paper`.
    pub(crate) fn paper() -> Self {
        Self { spatial_weight: 1.0, weight_by_length: false, appearance_rounds: 0, ..Self::default() }
    }
}

/// Label of a trajectory without a known one.
pub(crate) const UNKNOWN: u32 = u32::MAX;

/// Label of a trajectory that moves unlike the labelled ones around it: it tells where objects are, not which.
pub(crate) const OUTLIER: u32 = u32::MAX - 1;

/// Superpixels, labelled trajectories and evidence. Positions are in pixels of the superpixels' frames.
#[derive(Debug, Clone, Copy)]
pub struct CutInput<'a> {
    /// One partition for each frame.
    pub superpixels: &'a [Superpixels],
    /// Trajectories; there may be more than were clustered.
    pub tracks: &'a Trajectories,
    /// Label of each trajectory. Those that are not below `num_labels` do not vote; their trajectories still
    /// link superpixels of consecutive frames.
    pub label: &'a [u32],
    /// Number of labels.
    pub num_labels: usize,
    /// `true` for each label that is an object; may be empty.
    pub objects: &'a [bool],
    /// Log-odds of each superpixel to be an object's, frame by frame: a cost of the background's labels where positive, of
    /// the objects' where negative; may be empty.
    pub evidence: &'a [f32],
    /// The same by appearance, learned from an earlier cut; empty in the first.
    pub appearance: &'a [f32],
}

/// Label of each superpixel of each frame.
///
/// Law: `labels[t].len() == superpixels[t].count`; every label is below the number of labels, or 0 if there are none.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CutLabels {
    /// Frame by frame, superpixel by superpixel.
    pub labels: Vec<Vec<u32>>,
}

#[cfg(test)]
mod tests {
    use super::terms::ambiguous_shares;
    use super::*;
    use crate::superpixel::SuperpixelBorder;
    use crate::trajectory::Trajectories;

    const WIDTH: usize = 12;
    const HEIGHT: usize = 4;

    /// Three superpixels of 4 x 4 pixels side by side.
    fn thirds() -> Superpixels {
        let border = |a, pb| SuperpixelBorder { a, b: a + 1, length: 4.0, pb };
        let mut thirds = Superpixels::from(&Plane::from_fn(WIDTH, HEIGHT, |x, _| (x / 4) as u32));
        thirds.borders = vec![border(0, 0.0), border(1, 0.06)];
        thirds
    }

    /// Each track stands still where it is, from its first frame to the last of `num_frames`.
    fn standing(num_frames: usize, places: &[(usize, f32, f32)]) -> Trajectories {
        let mut tracks = Trajectories::empty(num_frames, (WIDTH, HEIGHT));
        for &(start, x, y) in places {
            tracks.push(start, (start..num_frames).map(|_| (x, y, 0.0)));
        }
        tracks
    }

    fn input<'a>(superpixels: &'a [Superpixels], tracks: &'a Trajectories, label: &'a [u32], n: usize) -> CutInput<'a> {
        CutInput { superpixels, tracks, label, num_labels: n, objects: &[], evidence: &[], appearance: &[] }
    }

    fn energy(input: &CutInput, params: &CutParams) -> Potts {
        super::energy(input, params, &Nodes::new(input))
    }

    fn units(cost: f64) -> i32 {
        (cost * 65536.0).round() as i32
    }

    /// The weight between two nodes; each pair must occur once at most.
    fn weight(problem: &Potts, p: u32, q: u32) -> Option<i32> {
        let mut weights = problem.edges.iter().zip(&problem.weights).filter(|(e, _)| **e == (p, q)).map(|(_, &w)| w);
        let weight = weights.next();
        assert_eq!(weights.next(), None);
        weight
    }

    #[test]
    fn unary_costs_are_one_minus_the_histogram_and_nothing_without_trajectories() {
        let superpixels = [thirds()];
        let tracks =
            standing(1, &[(0, 0.0, 0.0), (0, 1.0, 1.0), (0, 2.0, 2.0), (0, 3.0, 3.0), (0, 5.0, 0.0), (0, 6.0, 0.0)]);
        let label = [1, 1, 1, 0, UNKNOWN, 0];
        let params = CutParams { unary_weight: 2.0, ambiguous_share: 1.0, ..CutParams::default() };
        let problem = energy(&input(&superpixels, &tracks, &label, 2), &params);
        assert_eq!(problem.unary, [units(1.5), units(0.5), 0, units(2.0), 0, 0]);
    }

    #[test]
    fn borders_cost_less_where_contours_are_strong_and_more_where_they_are_long() {
        let mut s = thirds();
        let no_tracks = Trajectories::empty(1, (WIDTH, HEIGHT));
        let paper = CutParams { spatial_weight: 3.0, ..CutParams::paper() };
        let problem = energy(&input(std::slice::from_ref(&s), &no_tracks, &[], 2), &paper);
        assert_eq!(problem.edges, [(0, 1), (1, 2)]);
        assert_eq!(problem.weights, [units(3.0), units(3.0 * f64::exp(-2.0))]);
        s.borders[0].length = 12.0;
        let weight_by_length = CutParams { weight_by_length: true, ..paper };
        let problem = energy(&input(std::slice::from_ref(&s), &no_tracks, &[], 2), &weight_by_length);
        assert_eq!(problem.weights, [units(4.5), units(1.5 * f64::exp(-2.0))]);
    }

    /// The defaults with every term at weight 1, whatever they measure best with.
    fn equal_weights() -> CutParams {
        CutParams { unary_weight: 1.0, spatial_weight: 1.0, temporal_weight: 1.0, ..CutParams::default() }
    }

    #[test]
    fn temporal_weights_are_common_trajectories_by_the_larger_number() {
        let superpixels = [thirds(), thirds()];
        // In frame 0: two in superpixel 0. In frame 1: one of them still there, one in 1, and two new ones in 1.
        let mut tracks = Trajectories::empty(2, (WIDTH, HEIGHT));
        tracks.push(0, [(1.0, 1.0, 0.0), (1.0, 1.0, 0.0)]);
        tracks.push(0, [(3.4, 1.0, 0.0), (3.6, 1.0, 0.0)]);
        tracks.push(1, [(5.0, 1.0, 0.0)]);
        tracks.push(1, [(6.0, 1.0, 0.0)]);
        let problem = energy(&input(&superpixels, &tracks, &[UNKNOWN; 4], 2), &equal_weights());
        assert_eq!(weight(&problem, 0, 3), Some(units(0.5)));
        assert_eq!(weight(&problem, 0, 4), Some(units(1.0 / 3.0)));
        assert_eq!(problem.edges.len(), 6);
        assert!(problem.unary.iter().all(|&c| c == 0));
    }

    #[test]
    fn points_outside_the_image_belong_to_the_nearest_pixel() {
        let superpixels = [thirds()];
        let tracks = standing(1, &[(0, -0.9, -0.9), (0, 11.9, 3.9), (0, 1e9, -1e9)]);
        let problem = energy(&input(&superpixels, &tracks, &[0, 0, 0], 2), &CutParams::default());
        assert_eq!(problem.unary, [0, units(1.0), 0, 0, 0, units(1.0)]);
    }

    #[test]
    fn ambiguous_superpixels_lose_their_witnesses_softly_or_all_at_once() {
        let superpixels = [thirds()];
        // Label 0 left, label 1 right of it: the triangles between x = 2 and x = 6 are mixed.
        let tracks = standing(
            1,
            &[
                (0, 0.0, 0.0),
                (0, 2.0, 0.0),
                (0, 0.0, 3.0),
                (0, 2.0, 3.0),
                (0, 6.0, 0.0),
                (0, 6.0, 3.0),
                (0, 9.0, 0.0),
                (0, 9.0, 3.0),
            ],
        );
        let label = [0, 0, 0, 0, 1, 1, 1, 1];
        assert_eq!(ambiguous_shares(&superpixels[0], &tracks, &label, 0), [0.5, 0.75, 0.0]);
        let unary = |ambiguous_share| {
            let params = CutParams { ambiguous_share, ..CutParams::default() };
            energy(&input(&superpixels, &tracks, &label, 2), &params).unary
        };
        let one = units(1.0);
        assert_eq!(unary(1.0), [0, one, one, 0, one, 0]);
        assert_eq!(unary(0.6), [0, one, 0, 0, one, 0]);
        assert_eq!(unary(0.3), [0, 0, 0, 0, one, 0]);
    }

    #[test]
    fn labels_spread_to_superpixels_without_trajectories_up_to_the_strongest_contour() {
        let mut s = thirds();
        s.borders[0].pb = 0.3;
        let superpixels = [s.clone(), thirds(), s];
        let tracks = standing(3, &[(0, 1.0, 1.0), (0, 10.0, 1.0)]);
        let cut = gabriel_cut(&input(&superpixels, &tracks, &[0, 1], 2), &CutParams::default());
        assert_eq!(cut.labels[0], [0, 1, 1]);
        assert_eq!(cut.labels[1], [0, 0, 1]);
        assert_eq!(cut.labels[2], [0, 1, 1]);
        let mask = paint(&superpixels[0], &cut.labels[0]);
        assert_eq!(mask.row(2), [0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1]);
    }

    #[test]
    fn renaming_labels_renames_the_result() {
        let mut s = thirds();
        s.borders[0].length = 2.0;
        s.borders[1].pb = 0.1;
        let superpixels = [s.clone(), s];
        let tracks = standing(2, &[(0, 1.0, 1.0), (0, 1.0, 2.0), (0, 6.0, 1.0), (0, 9.0, 1.0), (1, 10.0, 1.0)]);
        let run =
            |label: &[u32]| gabriel_cut(&input(&superpixels, &tracks, label, 3), &equal_weights()).labels.concat();
        let plain = run(&[0, 0, 1, 2, 2]);
        assert!((0..3).all(|l| plain.contains(&l)));
        let renamed = run(&[2, 2, 0, 1, 1]);
        assert_eq!(renamed, plain.iter().map(|&l| (l + 2) % 3).collect::<Vec<_>>());
    }

    #[test]
    fn without_trajectories_or_labels_everything_is_label_zero() {
        let superpixels = [thirds(), thirds()];
        let no_tracks = Trajectories::empty(2, (WIDTH, HEIGHT));
        for num_labels in [0, 1, 2, 5] {
            let cut = gabriel_cut(&input(&superpixels, &no_tracks, &[], num_labels), &CutParams::default());
            assert_eq!(cut.labels, [[0, 0, 0], [0, 0, 0]]);
        }
        assert!(gabriel_cut(&input(&[], &no_tracks, &[], 2), &CutParams::default()).labels.is_empty());
    }

    #[test]
    fn one_superpixel_a_frame_takes_the_label_of_most() {
        let single = Superpixels::from(&Plane::filled(WIDTH, HEIGHT, 0));
        let tracks = standing(1, &[(0, 1.0, 1.0), (0, 5.0, 1.0), (0, 9.0, 1.0)]);
        let one = std::slice::from_ref(&single);
        for params in [CutParams::default(), CutParams::paper()] {
            assert_eq!(gabriel_cut(&input(one, &tracks, &[1, 2, 2], 3), &params).labels, [[2]]);
        }
        // Trajectories of more frames than there are superpixels, labels that do not exist.
        let longer = standing(5, &[(0, 1.0, 1.0), (2, 5.0, 1.0)]);
        assert_eq!(gabriel_cut(&input(one, &longer, &[1], 2), &CutParams::default()).labels, [[1]]);
        assert_eq!(gabriel_cut(&input(one, &longer, &[7, 7, 7], 2), &CutParams::default()).labels, [[0]]);
    }

    #[test]
    fn steps_count_up_to_the_result_of_the_whole() {
        let superpixels = [thirds(), thirds()];
        let tracks = standing(2, &[(0, 1.0, 1.0), (0, 6.0, 1.0), (0, 9.0, 1.0)]);
        let input = input(&superpixels, &tracks, &[0, 1, 2], 3);
        let mut cut = GabrielCut::new(&input, &CutParams::default());
        let mut last = 0;
        loop {
            let more = cut.step();
            let (done, total) = cut.progress();
            assert!(done > last && done <= total && more == (done < total));
            last = done;
            if !more {
                break;
            }
        }
        assert_eq!(cut.finish(), gabriel_cut(&input, &CutParams::default()));
    }

    #[test]
    fn evidence_costs_the_labels_that_it_speaks_against() {
        let superpixels = [thirds()];
        let no_tracks = Trajectories::empty(1, (3, 1));
        let evidence = [0.5, -0.25, 0.0];
        let input =
            CutInput { objects: &[false, true, true], evidence: &evidence, ..input(&superpixels, &no_tracks, &[], 3) };
        let params = CutParams::default();
        let [half, quarter] = [0.5, 0.25].map(|cost: f32| (cost * 65536.0) as i32);
        assert_eq!(energy(&input, &params).unary, [half, 0, 0, 0, quarter, quarter, 0, 0, 0]);
    }

    #[test]
    fn beside_appearance_trajectories_count_less() {
        let superpixels = [thirds()];
        let tracks = standing(1, &[(0, 0.0, 0.0)]);
        let appearance = [0.5, -1.0, 0.0];
        let input =
            CutInput { objects: &[false, true], appearance: &appearance, ..input(&superpixels, &tracks, &[1], 2) };
        let params = CutParams { appearance_weight: 2.0, appearance_unary_factor: 0.25, ..CutParams::default() };
        let problem = energy(&input, &params);
        assert_eq!(problem.unary, [units(0.25 + 1.0), 0, 0, units(2.0), 0, 0]);
    }
}
