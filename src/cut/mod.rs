//! The Gabriel cut (section 4.2): from labelled trajectories and superpixels to a label for every superpixel of the clip.
//!
//! In: [`CutInput`], the superpixels of all frames, trajectories with the labels of their clusters, optionally the flow between
//! frames. Out: [`CutLabels`]. The labelling f has little energy
//!
//! ```text
//! E(f) = Σ_r λ_r (1 − h_r(f_r)) + Σ_spatial w_pq [f_p ≠ f_q] + Σ_temporal fl_pq [f_p ≠ f_q]
//! ```
//!
//! over the superpixels r of all frames at once (`terms`), found by alpha-expansion (`expansion`) with minimum cuts (`maxflow`). `h_r` is
//! the normalised histogram of the labels of the trajectories that cross r; λ_r is zero where there are none, and can be lowered where
//! trajectories of different labels mix (`ambiguous`).
//!
//! **Misprints resolved.** The paper prints the mean Pb itself as the cost of parting two neighbours, which makes strong contours dear to
//! cut; its Figure 6 says the contrary, so the cost falls with Pb here. Its temporal neighbourhood bears the spatial one's name.
//!
//! **Beyond the paper**, each with its own parameter: borders count by their length; flow links superpixels that no trajectory joins;
//! colours speak where there are no trajectories; short trajectories that move like nothing around them count for all objects.
//! [`CutParams::paper`] has none of this. All numbers are whole once the terms are made, and the terms use no function of the standard
//! library that differs between machines: labels are the same everywhere.

mod ambiguous;
mod colour;
mod expansion;
mod maxflow;
mod objects;
mod refine;
mod region;
mod terms;
#[cfg(test)]
mod tests;
mod votes;

pub use ambiguous::ambiguous_shares;
pub use expansion::{Expansion, MAX_WEIGHT, Potts};
pub use maxflow::Network;
pub use objects::{Objects, find_objects};
pub use refine::{RefineParams, refine, refine_since};
pub use region::Region;
pub use terms::energy;
pub(crate) use terms::{areas, pixel_of};
pub use votes::labels_for;

use crate::flow::CompactFlow;
use crate::image::{Frame, Plane};
use crate::superpixel::Superpixels;
use crate::trajectory::Trajectories;
use region::Part;

crate::params! {
    /// The Gabriel cut.
    pub struct CutParams {
        /// Weight of a superpixel's own trajectories (λ of section 4.2, whose value the paper does not give).
        pub unary_weight: f32 = 1.0, in 0.0..=1000.0;
        /// A superpixel's own trajectories count in full from this many labelled ones on, in proportion below; 0 and 1: always in
        /// full, as in the paper.
        pub full_tracks: f32 = 0.0, in 0.0..=1000.0;
        /// Weight of the border between two superpixels of a frame. Higher makes labels smoother.
        pub spatial_weight: f32 = 2.0, in 0.0..=1000.0;
        /// A border costs `exp(−mean Pb / this)` to cut. The paper prints the mean Pb itself, a misprint.
        pub pb_scale: f32 = 0.03, in 0.001..=100.0;
        /// Whether borders count by their length, relative to the mean and within 0.05 to 4. The paper does not.
        pub by_length: bool = true, in 0..=1;
        /// Weight of the share of common trajectories between superpixels of consecutive frames.
        pub temporal_weight: f32 = 2.0, in 0.0..=1000.0;
        /// Weight of the share of pixels that flow carries from one superpixel into another. Not in the paper. Over 8 DAVIS clips
        /// it leaves the mean J as it is (0.752; 0.753 without) and raises the mean F from 0.701 to 0.710.
        pub flow_weight: f32 = 1.0, in 0.0..=1000.0;
        /// Weight of the colours of a label over the clip, where a superpixel has no trajectories of its own that count. Not in the
        /// paper; over 8 DAVIS clips it raises the mean J from 0.750 to 0.752, most where trajectories are few.
        pub colour_weight: f32 = 0.3, in 0.0..=1000.0;
        /// A superpixel's own trajectories do not count if a larger share of it than this lies between trajectories of different
        /// labels (section 4.2: 0.3). 1 turns the rule off.
        pub ambiguous_share: f32 = 1.0, in 0.0..=1.0;
        /// Whether a superpixel's own trajectories count less, by `(1 − share)²`, the larger that share is. Not in the paper.
        pub ambiguous_soft: bool = false, in 0..=1;
        /// Radius within which labelled trajectories vote on others, in pixels of the processed frames. Higher is slower.
        pub vote_radius: f32 = 24.0, in 1.0..=1000.0;
        /// How differently a trajectory may move from those that vote on it, in pixels per frame.
        pub vote_motion: f32 = 0.5, in 0.001..=100.0;
        /// Share of the votes that a label needs; below, a trajectory's label stays unknown.
        pub vote_share: f32 = 0.6, in 0.0..=1.0;
        /// Weight of a salient trajectory that moves like none of those around it: it counts for every object and not for the background.
        /// Not in the paper. Over 8 DAVIS clips it raises the mean J from 0.725 to 0.752, most where an object has few trajectories that
        /// last.
        pub stranger_weight: f32 = 1.0, in 0.0..=100.0;
    }
}

impl CutParams {
    /// The paper's energy, with its misprints resolved: nothing by length or flow, all weights 1, the 30 % rule for ambiguous
    /// superpixels.
    ///
    /// From outside: `preset` = `paper`.
    pub fn paper() -> Self {
        Self {
            spatial_weight: 1.0,
            temporal_weight: 1.0,
            by_length: false,
            flow_weight: 0.0,
            colour_weight: 0.0,
            stranger_weight: 0.0,
            full_tracks: 0.0,
            ambiguous_soft: false,
            ambiguous_share: 0.3,
            ..Self::default()
        }
    }
}

/// The label of a trajectory of which none is known.
pub const UNKNOWN: u32 = u32::MAX;

/// The label of a trajectory that moves like none of the labelled ones around it.
pub const STRANGER: u32 = u32::MAX - 1;

/// What the cut is made from. Positions are in pixels of the superpixels' frames.
#[derive(Debug, Clone, Copy)]
pub struct CutInput<'a> {
    /// One partition for each frame.
    pub superpixels: &'a [Superpixels],
    /// Trajectories; there may be more than were clustered.
    pub tracks: &'a Trajectories,
    /// Label of each trajectory. A [`STRANGER`] votes for all objects. Others that are not below `num_labels`, such as [`UNKNOWN`], vote for
    /// nothing; their trajectories still link superpixels of consecutive frames.
    pub label: &'a [u32],
    /// Number of labels.
    pub num_labels: usize,
    /// Whether each label is an object, for `stranger_weight`; may be empty.
    pub objects: &'a [bool],
    /// Flow from each frame to the next, for `flow_weight`; may be empty.
    pub flows: &'a [CompactFlow],
    /// The frames at the size of the superpixels, for `colour_weight`; may be empty.
    pub frames: &'a [Frame],
}

/// A label for each superpixel of each frame.
///
/// Law: `labels[t].len() == superpixels[t].count`; every label is below the number of labels, or 0 if there are none.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CutLabels {
    /// Frame by frame, superpixel by superpixel.
    pub labels: Vec<Vec<u32>>,
}

/// The Gabriel cut in steps, each one move of the expansion.
#[derive(Debug, Clone)]
pub struct GabrielCut {
    expansion: Expansion,
    counts: Vec<usize>,
    /// What the expansion is a part of: the labels of all superpixels, and which superpixels and labels take part.
    rest: Option<(Vec<u32>, Vec<u32>, Vec<u32>)>,
}

impl GabrielCut {
    /// Makes the energy; the longest of all steps.
    pub fn new(input: &CutInput, params: &CutParams) -> Self {
        let problem = energy(input, params);
        let start = terms::first_labels(&problem);
        Self { expansion: Expansion::new(problem, start), counts: counts(input), rest: None }
    }

    /// The same in a part of the clip, from the labels there on.
    pub fn within(input: &CutInput, params: &CutParams, region: &Region) -> Self {
        let part = Part::new(input, params, region);
        let start = part.present();
        let Part { problem, all, nodes, labels } = part;
        Self { expansion: Expansion::new(problem, start), counts: counts(input), rest: Some((all, nodes, labels)) }
    }

    /// One move; whether any is left.
    pub fn step(&mut self) -> bool {
        self.expansion.step();
        !self.expansion.is_finished()
    }

    /// Moves made, and how many it will have been if none of those left changes anything.
    pub fn progress(&self) -> (u32, u32) {
        self.expansion.progress()
    }

    /// Makes the moves that are left; the labels.
    pub fn finish(self) -> CutLabels {
        let mut label = self.expansion.finish();
        if let Some((all, nodes, labels)) = self.rest {
            label = Part::merged(all, &nodes, &labels, &label);
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

/// Number of superpixels in each frame.
fn counts(input: &CutInput) -> Vec<usize> {
    input.superpixels.iter().map(|s| s.count).collect()
}

/// The labelling of least energy that alpha-expansion finds.
pub fn gabriel_cut(input: &CutInput, params: &CutParams) -> CutLabels {
    GabrielCut::new(input, params).finish()
}

/// One plane of cluster labels per frame, at the superpixels' size.
pub fn paint(superpixels: &Superpixels, labels: &[u32]) -> Plane<u32> {
    superpixels.label.map(|p| labels[p as usize])
}
