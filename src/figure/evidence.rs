//! Log-odds that two clusters are one object, and that a cluster is an object.
//!
//! In: trajectories with labels and discontinuities, the camera's motion, pairs that connectedness separates. Out: merged
//! clusters, and the log-odds of each cluster to be an object.
//!
//! Both are weighted sums of a few terms, fitted by logistic regression on clips with true masks (`bench fit` prints
//! them as constants).
//!
//! **Merging.** The terms of two neighbouring clusters: mean discontinuity along the common border (section 2.3 of the
//! paper); by how much one affine motion for both fits worse than one each (model selection as in Torr, Philosophical
//! Transactions 1998), and the residual of one each; the difference of their contrasts to the camera's motion. The
//! likeliest pair is merged and its terms recomputed, as the paper does with discontinuities alone: greedy edge contraction as in
//! Keuper, Andres and Brox (ICCV 2015). The threshold is lower for small pieces, since the cost of a wrong merge grows
//! with the size. Where connectedness separates a part of the border, fixed log-odds replace the sum in proportion.
//!
//! **Objects.** Moving camera: a cluster's share of the frame border for its size, since the scene runs on beyond the frame,
//! and its contrast to the camera's motion; they fall further with its excess of the border if it moves as one rigid surface,
//! since near parts of a deep scene move unlike the camera, but are large and rigid. Still camera: its distance from the
//! background plate.
//!
//! Cost: O(points) for the sums, which add up under merging, and O(clusters) for each merge. It fails where two objects
//! move by one affine motion, and on objects that fill the frame border.

use crate::affinity::{AffinityParams, Velocities};
use crate::camera::DominantMotion;
use crate::connectedness::Separation;
use crate::discontinuity::Discontinuities;
use crate::saliency::SaliencyMaps;
use crate::trajectory::Trajectories;

// Fitted by `cargo run --release -p tracecut-bench -- fit`; do not edit them by hand. Those of pairs with
// `bms26 davis wild --frames 50 --seeds 0`, of objects with `davis wild --frames 40 --seeds 0`, and the last with
// `wild --only cdnet,sbi,ucsd --frames 50 --seeds 0`.

/// Weights of a pair of clusters to be one object: bias, then the terms of `ClusterPair`.
const PAIR_WEIGHTS: [f64; 5] = [3.0988, -0.8723, -0.3585, -0.4741, 0.5241];

/// Weights of a cluster to be an object, with a moving camera: bias, then the terms of `ClusterCues::Moving`.
const OBJECT_WEIGHTS: [f64; 3] = [-4.4246, -1.9021, 0.7811];

/// Weights of a cluster to be an object, with a still camera: bias, then the term of `ClusterCues::Still`.
const STILL_OBJECT_WEIGHTS: [f64; 2] = [2.8582, 1.6986];

/// Label of a trajectory that has none yet.
pub(crate) const UNLABELLED: u32 = u32::MAX;

/// Fewest velocities of a cluster in a frame for its motion there to count. Chosen by eye.
const MIN_VELOCITIES: f64 = 4.0;
/// Added to a gain and to a residual before their logarithms, in squares of the noise: smaller differences mean nothing.
/// Chosen by eye.
const GAIN_FLOOR: f64 = 0.01;
const RESIDUAL_FLOOR: f64 = 0.1;

/// Side of a square frame below whose area contrasts to the camera's motion are scaled up: in small frames everything moves
/// less. The default of `clip.reference`.
const REFERENCE_SIDE_PX: f64 = 360.0;

/// Number of terms of a pair.
const NUM_TERMS: usize = PAIR_WEIGHTS.len() - 1;

/// Trajectories, and everything else that clusters are compared by.
#[derive(Debug, Clone, Copy)]
pub struct EvidenceInput<'a> {
    /// The trajectories.
    pub(crate) tracks: &'a Trajectories,
    /// Their neighbours and discontinuities.
    pub(crate) discontinuities: &'a Discontinuities,
    /// Horizon and noise of velocities.
    pub(crate) affinity: &'a AffinityParams,
    /// The camera's motion in each frame pair.
    pub(crate) camera: &'a [DominantMotion],
    /// Pairs that connectedness separates; `None` with connectedness off.
    pub(crate) separation: Option<&'a Separation>,
}

impl<'a> EvidenceInput<'a> {
    /// Gathers trajectories, their neighbours and discontinuities, and the parameters of their velocities. The camera's
    /// motion is from the maps; without maps the camera stands still.
    pub fn new(
        tracks: &'a Trajectories,
        discontinuities: &'a Discontinuities,
        affinity: &'a AffinityParams,
        maps: Option<&'a SaliencyMaps>,
        separation: Option<&'a Separation>,
    ) -> Self {
        Self { tracks, discontinuities, affinity, camera: maps.map_or(&[], SaliencyMaps::motions), separation }
    }
}

/// Two neighbouring clusters, and the terms of their log-odds to be one object.
#[doc(hidden)]
#[derive(Debug, Clone, PartialEq)]
pub struct ClusterPair {
    /// The clusters, the lower first.
    pub clusters: (u32, u32),
    /// Mean discontinuity along the common border; logarithm of the gain of one affine motion each over one for both, by
    /// velocity of the smaller, in squares of the noise; difference of their contrasts to the camera's motion; logarithm
    /// of the residual of one affine motion each, by velocity, in squares of the noise.
    pub terms: [f64; NUM_TERMS],
}

/// Common border of two clusters.
#[derive(Debug, Clone, Copy, Default)]
struct ClusterBorder {
    /// Number of pairs of neighbours, one of each cluster.
    pairs: f64,
    /// Sum of their discontinuities.
    discontinuity: f64,
    /// Number of pairs that connectedness separates.
    separated: f64,
}

impl ClusterBorder {
    fn plus(&self, other: &Self) -> Self {
        Self {
            pairs: self.pairs + other.pairs,
            discontinuity: self.discontinuity + other.discontinuity,
            separated: self.separated + other.separated,
        }
    }

    /// Computes the borders of all pairs of `count` clusters; `(p, q)` with `p < q` lies at `p * count + q`.
    fn between_clusters(label: &[u32], count: usize, input: &EvidenceInput) -> Vec<Self> {
        let mut borders = vec![Self::default(); count * count];
        for (&(i, j), d) in input.discontinuities.neighborhoods.pairs.iter().zip(&input.discontinuities.d) {
            let (p, q) = (label[i as usize], label[j as usize]);
            if p != q && p != UNLABELLED && q != UNLABELLED {
                let separated = input.separation.is_some_and(|s| s.separates(input.tracks, i as usize, j as usize));
                let pair = Self { pairs: 1.0, discontinuity: *d, separated: f64::from(u8::from(separated)) };
                let border = &mut borders[p.min(q) as usize * count + p.max(q) as usize];
                *border = border.plus(&pair);
            }
        }
        borders
    }
}

fn num_clusters(label: &[u32]) -> usize {
    label.iter().filter(|&&l| l != UNLABELLED).max().map_or(0, |&l| l as usize + 1)
}

/// Computes the terms of all pairs of neighbouring clusters, in order.
pub(crate) fn cluster_pairs(label: &[u32], input: &EvidenceInput) -> Vec<ClusterPair> {
    let count = num_clusters(label);
    let clusters = ClusterSums::new(label, count, input);
    let borders = ClusterBorder::between_clusters(label, count, input).into_iter().enumerate();
    borders
        .filter(|(_, border)| border.pairs > 0.0)
        .map(|(index, border)| {
            let (p, q) = (index / count, index % count);
            ClusterPair { clusters: (p as u32, q as u32), terms: clusters[p].terms(&clusters[q], &border) }
        })
        .collect()
}

/// Statistics of a cluster's motion, additive over clusters.
#[derive(Debug, Clone)]
struct ClusterSums {
    /// Number of trajectories.
    size: f64,
    /// Velocities in each frame.
    motion: Vec<AffineSums>,
    /// Sum of ln(1 + r²) over the velocities, with their distance `r` from the camera's motion in units of the noise.
    contrast: f64,
    num_velocities: f64,
}

impl ClusterSums {
    fn new(label: &[u32], count: usize, input: &EvidenceInput) -> Vec<Self> {
        let tracks = input.tracks;
        let velocities = Velocities::new(tracks, input.affinity);
        let horizon = velocities.horizon;
        let motion = vec![AffineSums::default(); tracks.num_frames];
        let mut clusters = vec![Self { size: 0.0, motion, contrast: 0.0, num_velocities: 0.0 }; count];
        let half = [tracks.size.0, tracks.size.1].map(|side| side as f64 / 2.0);
        let scale_sq = (4.0 * half[0] * half[1] / REFERENCE_SIDE_PX.powi(2)).min(1.0);
        for (i, &l) in label.iter().enumerate().filter(|(_, l)| **l != UNLABELLED) {
            let (cluster, points) = (&mut clusters[l as usize], tracks.points(i));
            cluster.size += 1.0;
            let steps = steps_against_camera(tracks, i, input.camera);
            for (s, p) in (points.start..points.end.saturating_sub(horizon)).enumerate() {
                let (u, v, weight) = velocities.at(p);
                let place = (f64::from(tracks.x[p]) / half[0] - 1.0, (f64::from(tracks.y[p]) - half[1]) / half[0]);
                cluster.motion[tracks.frames(i).start + s].add(place, (f64::from(u), f64::from(v)), f64::from(weight));
                let sum = steps[s..s + horizon].iter().fold((0.0, 0.0), |sum, (x, y)| (sum.0 + x, sum.1 + y));
                let speed_sq = (sum.0 * sum.0 + sum.1 * sum.1) / (horizon * horizon) as f64;
                cluster.contrast += libm::log(1.0 + speed_sq * f64::from(weight) / scale_sq);
                cluster.num_velocities += 1.0;
            }
        }
        clusters
    }

    fn add(&mut self, other: &Self) {
        self.size += other.size;
        self.motion.iter_mut().zip(&other.motion).for_each(|(a, b)| *a = a.plus(b));
        self.contrast += other.contrast;
        self.num_velocities += other.num_velocities;
    }

    /// Computes the terms of two clusters with this border, in the order of [`ClusterPair::terms`].
    fn terms(&self, other: &Self, border: &ClusterBorder) -> [f64; NUM_TERMS] {
        let (gain, residual) = self.fit_motions(other);
        let contrast = (self.mean_contrast() - other.mean_contrast()).abs();
        let discontinuity = border.discontinuity / border.pairs;
        [discontinuity, libm::log(gain + GAIN_FLOOR), contrast, libm::log(residual + RESIDUAL_FLOOR)]
    }

    /// Mean contrast to the camera's motion.
    fn mean_contrast(&self) -> f64 {
        self.contrast / self.num_velocities.max(1.0)
    }

    /// Mean squared residual from one affine motion a frame, over the frames with enough velocities; 1 without any.
    fn mean_residual(&self) -> f64 {
        let enough = || self.motion.iter().filter(|sums| sums.count >= MIN_VELOCITIES);
        let count: f64 = enough().map(|sums| sums.count).sum();
        if count > 0.0 { enough().map(AffineSums::residual).sum::<f64>() / count } else { 1.0 }
    }

    /// Returns the gain of one affine motion each over one for both, by velocity of the smaller, and the residual of one
    /// each, by velocity, over the frames in which both have enough velocities; 1 without such a frame.
    fn fit_motions(&self, other: &Self) -> (f64, f64) {
        let (mut gain, mut residual, mut counts) = (0.0, 0.0, (0.0, 0.0));
        let is_enough = |sums: &AffineSums| sums.count >= MIN_VELOCITIES;
        for (a, b) in self.motion.iter().zip(&other.motion).filter(|(a, b)| is_enough(a) && is_enough(b)) {
            let separate = a.residual() + b.residual();
            gain += (a.plus(b).residual() - separate).max(0.0);
            residual += separate;
            counts = (counts.0 + a.count, counts.1 + b.count);
        }
        let fewer = f64::min(counts.0, counts.1);
        if fewer > 0.0 { (gain / fewer, residual / (counts.0 + counts.1)) } else { (1.0, 1.0) }
    }
}

/// Steps of trajectory `i` less the camera's motion, in pixels; 0 where that is unknown.
fn steps_against_camera(tracks: &Trajectories, i: usize, camera: &[DominantMotion]) -> Vec<(f64, f64)> {
    let points = tracks.points(i);
    let at = |p: usize| (f64::from(tracks.x[p]), f64::from(tracks.y[p]));
    let step = |(t, p): (usize, usize)| {
        let (from, to) = (at(p), at(p + 1));
        let Some(motion) = camera.get(t) else { return (0.0, 0.0) };
        let (u, v) = motion.at(from.0, from.1);
        (to.0 - from.0 - u, to.1 - from.1 - v)
    };
    tracks.frames(i).zip(points.start..points.end.saturating_sub(1)).map(step).collect()
}

/// Weighted sum of terms; the first weight is the bias.
fn log_odds(weights: &[f64], terms: &[f64]) -> f64 {
    weights[0] + weights[1..].iter().zip(terms).map(|(weight, term)| weight * term).sum::<f64>()
}

type Vector = (f64, f64);

/// Ridge on the slopes of an affine motion, as a part of the weights, for points on a line. Chosen by eye.
const AFFINE_RIDGE: f64 = 1e-3;

/// Normal equations of the best affine motion of a set of velocities, additive over sets.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct AffineSums {
    /// Number of points.
    count: f64,
    /// Weights, times 1, x, y, x², xy, y².
    places: [f64; 6],
    /// Weights and velocity to the right, and down, times 1, x, y.
    u: [f64; 3],
    v: [f64; 3],
    /// Weights times squared speed.
    energy: f64,
}

impl AffineSums {
    /// Adds a point, in coordinates of the order of 1, with its velocity in pixels a frame and the inverse variance of that.
    fn add(&mut self, point: Vector, velocity: Vector, weight: f64) {
        let ((x, y), (u, v)) = (point, velocity);
        self.count += 1.0;
        let basis = [1.0, x, y];
        let squares = [1.0, x, y, x * x, x * y, y * y];
        self.places.iter_mut().zip(squares).for_each(|(sum, value)| *sum += weight * value);
        self.u.iter_mut().zip(basis).for_each(|(sum, value)| *sum += weight * u * value);
        self.v.iter_mut().zip(basis).for_each(|(sum, value)| *sum += weight * v * value);
        self.energy += weight * (u * u + v * v);
    }

    fn plus(&self, other: &Self) -> Self {
        let mut sum = *self;
        sum.count += other.count;
        sum.places.iter_mut().zip(other.places).for_each(|(a, b)| *a += b);
        sum.u.iter_mut().zip(other.u).for_each(|(a, b)| *a += b);
        sum.v.iter_mut().zip(other.v).for_each(|(a, b)| *a += b);
        sum.energy += other.energy;
        sum
    }

    /// Sum of squared residuals of the best affine motion, in units of the noise.
    fn residual(&self) -> f64 {
        let [w, x, y, xx, xy, yy] = self.places;
        if w <= 0.0 {
            return 0.0;
        }
        // Gaussian elimination: of the mean, then of the x axis from the y axis.
        let (xx, xy, yy) = (xx - x * x / w + AFFINE_RIDGE * w, xy - x * y / w, yy - y * y / w + AFFINE_RIDGE * w);
        let yy = yy - xy * xy / xx;
        let explained = |[b, b_x, b_y]: [f64; 3]| {
            let (b_x, b_y) = (b_x - x * b / w, b_y - y * b / w);
            let b_y = b_y - xy * b_x / xx;
            b * b / w + b_x * b_x / xx + b_y * b_y / yy
        };
        (self.energy - explained(self.u) - explained(self.v)).max(0.0)
    }
}

/// Rise of the merging threshold with the logarithm of the smaller piece's share of the trajectories: the cost of a wrong
/// merge grows with the piece. Chosen by eye.
const THRESHOLD_BY_LOG_SHARE: f64 = 0.4;
/// Log-odds of two clusters that connectedness separates. Chosen by eye.
const SEPARATED_LOG_ODDS: f64 = -3.0;

/// Merges clusters of one object: repeatedly the likeliest pair of neighbours, while its log-odds exceed the threshold.
/// Unlabelled trajectories stay so.
pub(crate) fn merge_by_evidence(label: &mut [u32], input: &EvidenceInput, threshold: f64) {
    let mut state = MergeState::new(label, input, threshold);
    while let Some((p, q)) = state.likeliest_pair() {
        state.merge(p, q);
    }
    for l in label.iter_mut().filter(|l| **l != UNLABELLED) {
        *l = state.merged_into[*l as usize];
    }
}

/// State of the greedy merging; the pair `p < q` has the index `p * count + q`.
struct MergeState {
    count: usize,
    threshold: f64,
    num_tracks: f64,
    sums: Vec<ClusterSums>,
    border: Vec<ClusterBorder>,
    /// Log-odds of each pair above its threshold, minus infinity without a border.
    score: Vec<f64>,
    /// The cluster that each was merged into.
    merged_into: Vec<u32>,
}

impl MergeState {
    fn new(label: &[u32], input: &EvidenceInput, threshold: f64) -> Self {
        let count = num_clusters(label);
        let sums = ClusterSums::new(label, count, input);
        let num_tracks = sums.iter().map(|s| s.size).sum();
        let border = ClusterBorder::between_clusters(label, count, input);
        let score = vec![f64::NEG_INFINITY; border.len()];
        let merged_into = (0..count as u32).collect();
        let mut state = Self { count, threshold, num_tracks, sums, border, score, merged_into };
        (0..count).for_each(|p| state.update_scores(p));
        state
    }

    fn index(&self, p: usize, q: usize) -> usize {
        p.min(q) * self.count + p.max(q)
    }

    /// Computes the scores of all pairs of `p`.
    fn update_scores(&mut self, p: usize) {
        for q in (0..self.count).filter(|&q| q != p) {
            let index = self.index(p, q);
            self.score[index] = self.score(p, q, &self.border[index]);
        }
    }

    fn score(&self, p: usize, q: usize, border: &ClusterBorder) -> f64 {
        if border.pairs == 0.0 {
            return f64::NEG_INFINITY;
        }
        let (a, b) = (&self.sums[p], &self.sums[q]);
        let threshold = self.threshold + THRESHOLD_BY_LOG_SHARE * libm::log(a.size.min(b.size) / self.num_tracks);
        let separated = border.separated / border.pairs;
        (1.0 - separated) * (log_odds(&PAIR_WEIGHTS, &a.terms(b, border)) - threshold) + separated * SEPARATED_LOG_ODDS
    }

    /// Returns the pair of the highest score, if that is above 0.
    fn likeliest_pair(&self) -> Option<(usize, usize)> {
        let better = |best: usize, next: usize| if self.score[next] > self.score[best] { next } else { best };
        let best = (0..self.score.len()).reduce(better)?;
        (self.score[best] > 0.0).then_some((best / self.count, best % self.count))
    }

    /// Merges `q` into `p`.
    fn merge(&mut self, p: usize, q: usize) {
        let sums = self.sums[q].clone();
        self.sums[p].add(&sums);
        for r in (0..self.count).filter(|&r| r != q) {
            let (from, to) = (self.index(q, r), self.index(p, r));
            let border = std::mem::take(&mut self.border[from]);
            self.score[from] = f64::NEG_INFINITY;
            if r != p {
                self.border[to] = self.border[to].plus(&border);
            }
        }
        self.update_scores(p);
        self.merged_into.iter_mut().filter(|target| **target == q as u32).for_each(|target| *target = p as u32);
    }
}

/// Log-odds above which a cluster is an object, with a moving camera and with a still one. Below 0: pixels can still reject an
/// object later, but not bring it back. Chosen on 44 clips, as docs/choices.md tells.
const OBJECT_THRESHOLD: f64 = -1.3;
const STILL_OBJECT_THRESHOLD: f64 = -0.8;
/// Fall of the log-odds of a rigid cluster with its excess of the frame border: the near parts of a deep scene have more of it
/// than small objects that enter. Chosen on a drawn scene and on clips, as docs/choices.md tells.
const EXCESS_WEIGHT: f64 = 35.0;
/// Bias and weight of the border term alone, without the motion. Chosen by eye.
const BORDER_WEIGHTS: [f64; 2] = [-0.2, -2.0];
/// Added to a border share and to a plate distance before their logarithms. Chosen by eye.
const BORDER_SHARE_FLOOR: f64 = 0.1;
const PLATE_DISTANCE_FLOOR: f64 = 0.02;

/// Motion of a cluster against that of the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ClusterMotion {
    /// Mean of ln(1 + r²) over its velocities, with their distance `r` from the camera's motion in units of the noise.
    pub contrast: f64,
    /// Mean squared residual of its velocities from one affine motion a frame, in squares of the noise.
    pub residual_sq: f64,
}

impl ClusterMotion {
    /// Returns how well one affine motion a frame explains its velocities, 0 to 1.
    fn rigidity(self) -> f64 {
        1.0 / (1.0 + self.residual_sq)
    }
}

/// Cues of a cluster to be an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ClusterCues {
    /// With a moving or unknown camera.
    Moving {
        /// Share of the frame border over the share of the frame: 1 on average.
        border_share: f64,
        /// The cluster's part of the frame border less its part of the frame, at least 0.
        border_excess: f64,
        /// Its motion, if known.
        motion: Option<ClusterMotion>,
    },
    /// With a still camera: mean distance from the background plate, 0 to 1.
    Still { plate_distance: f64 },
}

impl ClusterCues {
    /// Returns the terms of the log-odds; `None` if the motion is unknown.
    pub(crate) fn terms(&self) -> Option<Vec<f64>> {
        match *self {
            Self::Moving { border_share, motion, .. } => Some(vec![border_term(border_share), motion?.contrast]),
            Self::Still { plate_distance } => Some(vec![plate_term(plate_distance)]),
        }
    }

    /// Returns the log-odds of an object, less the threshold: objects are above 0.
    pub(crate) fn log_odds(&self) -> f64 {
        match *self {
            Self::Still { plate_distance } => {
                log_odds(&STILL_OBJECT_WEIGHTS, &[plate_term(plate_distance)]) - STILL_OBJECT_THRESHOLD
            }
            Self::Moving { border_share, motion: None, .. } => log_odds(&BORDER_WEIGHTS, &[border_term(border_share)]),
            Self::Moving { border_share, border_excess, motion: Some(motion) } => {
                let by_terms = log_odds(&OBJECT_WEIGHTS, &[border_term(border_share), motion.contrast]);
                by_terms - OBJECT_THRESHOLD - EXCESS_WEIGHT * border_excess * motion.rigidity()
            }
        }
    }
}

fn border_term(border_share: f64) -> f64 {
    libm::log(border_share + BORDER_SHARE_FLOOR)
}

fn plate_term(plate_distance: f64) -> f64 {
    libm::log(plate_distance + PLATE_DISTANCE_FLOOR)
}

/// Computes the motion of each cluster.
pub(crate) fn cluster_motions(label: &[u32], input: &EvidenceInput) -> Vec<ClusterMotion> {
    let motion =
        |sums: &ClusterSums| ClusterMotion { contrast: sums.mean_contrast(), residual_sq: sums.mean_residual() };
    ClusterSums::new(label, num_clusters(label), input).iter().map(motion).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::affinity::AffinityParams;
    use crate::connectedness::{Components, ConnectednessMode, ConnectednessParams, Separation};
    use crate::discontinuity::{Discontinuities, neighborhoods};
    use crate::flow::FlowField;
    use crate::image::Plane;
    use crate::rng::Rng;
    use crate::trajectory::Trajectories;

    const FRAMES: usize = 10;

    /// Three columns of trajectories, each a cluster: the first two stand still as the flow does, the third moves.
    fn scene() -> (Trajectories, Vec<u32>) {
        let mut tracks = Trajectories::empty(FRAMES, (120, 80));
        let mut label = Vec::new();
        for k in 0..12 * 8 {
            let (column, row) = (k % 12, k / 12);
            let speed = if column < 8 { 0.0 } else { 1.5 };
            let sway = 0.01 * ((k * 7) % 5) as f32;
            let point =
                |t: usize| (5.0 + 8.0 * column as f32 + (speed + sway) * t as f32, 5.0 + 9.0 * row as f32, 0.05);
            tracks.push(0, (0..FRAMES).map(point));
            label.push(column as u32 / 4);
        }
        (tracks, label)
    }

    fn at_rest() -> Vec<DominantMotion> {
        let still = Plane::filled(120, 80, 0.0);
        vec![DominantMotion::still(&FlowField { u: still.clone(), v: still }); FRAMES - 1]
    }

    fn evidence_input<'a>(
        tracks: &'a Trajectories,
        discontinuities: &'a Discontinuities,
        affinity: &'a AffinityParams,
        camera: &'a [DominantMotion],
    ) -> EvidenceInput<'a> {
        EvidenceInput { tracks, discontinuities, affinity, camera, separation: None }
    }

    fn discontinuities(tracks: &Trajectories, d: f64) -> Discontinuities {
        let neighborhoods = neighborhoods(tracks);
        let d = vec![d; neighborhoods.pairs.len()];
        Discontinuities { neighborhoods, d, ..Discontinuities::default() }
    }

    #[test]
    fn clusters_that_move_with_the_camera_are_likelier_one() {
        let ((tracks, label), camera) = (scene(), at_rest());
        let (discontinuities, affinity) = (discontinuities(&tracks, 0.7), AffinityParams::default());
        let input = evidence_input(&tracks, &discontinuities, &affinity, &camera);
        let pairs = cluster_pairs(&label, &input);
        assert_eq!(pairs.iter().map(|pair| pair.clusters).collect::<Vec<_>>(), [(0, 1), (1, 2)]);
        let [one, two] = [0, 1].map(|k| log_odds(&PAIR_WEIGHTS, &pairs[k].terms));
        assert!(one > two + 2.0, "{pairs:?}");
        assert!(pairs.iter().all(|pair| (pair.terms[0] - 0.7).abs() < 1e-12));
    }

    #[test]
    fn log_odds_fall_with_the_discontinuity() {
        let ((tracks, label), camera) = (scene(), at_rest());
        let affinity = AffinityParams::default();
        let odds = |d: f64| {
            let discontinuities = discontinuities(&tracks, d);
            let input = evidence_input(&tracks, &discontinuities, &affinity, &camera);
            let first = log_odds(&PAIR_WEIGHTS, &cluster_pairs(&label, &input)[0].terms);
            (first, cluster_pairs(&vec![UNLABELLED; tracks.len()], &input).len())
        };
        assert!(odds(0.1).0 > odds(0.9).0);
        assert_eq!(odds(0.1).1, 0);
    }

    #[test]
    fn sums_of_two_clusters_add_up() {
        let ((tracks, label), camera) = (scene(), at_rest());
        let (discontinuities, affinity) = (discontinuities(&tracks, 0.7), AffinityParams::default());
        let input = evidence_input(&tracks, &discontinuities, &affinity, &camera);
        let parts = ClusterSums::new(&label, 3, &input);
        let mut both = parts[0].clone();
        both.add(&parts[1]);
        let merged: Vec<u32> = label.iter().map(|&l| l.saturating_sub(1)).collect();
        let expected = cluster_pairs(&merged, &input)[0].terms;
        let border = ClusterBorder { pairs: 1.0, discontinuity: 0.7, separated: 0.0 };
        for (a, b) in both.terms(&parts[2], &border).into_iter().zip(expected) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }

    /// Points of an affine motion, with noise.
    fn points(motion: [f64; 6], noise: f64, seed: u64) -> AffineSums {
        let mut rng = Rng::for_stage(seed, "affine");
        let mut sums = AffineSums::default();
        for _ in 0..200 {
            let (x, y) = (rng.range(-1.0, 1.0), rng.range(-1.0, 1.0));
            let [a, b, c, d, e, f] = motion;
            let error = (noise * rng.range(-1.0, 1.0), noise * rng.range(-1.0, 1.0));
            sums.add((x, y), (a + b * x + c * y + error.0, d + e * x + f * y + error.1), 4.0);
        }
        sums
    }

    #[test]
    fn the_residual_of_an_affine_motion_is_the_noise() {
        let motion = [3.0, 0.5, -0.2, 1.0, 0.3, 0.4];
        assert!(points(motion, 0.0, 1).residual() / 200.0 < 0.01);
        // Each axis has the variance of an even spread, noise² / 3.
        let residual = points(motion, 0.5, 1).residual() / 200.0;
        assert!((residual / (4.0 * 2.0 * 0.25 / 3.0) - 1.0).abs() < 0.15, "{residual}");
    }

    #[test]
    fn two_motions_gain_by_a_model_each() {
        let (slow, slow_too) =
            (points([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.1, 1), points([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.1, 2));
        let faster = points([2.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.1, 3);
        let gain = |a: &AffineSums, b: &AffineSums| a.plus(b).residual() - a.residual() - b.residual();
        assert!(gain(&slow, &faster) > 100.0 * gain(&slow, &slow_too).max(0.1));
        assert!(gain(&slow, &slow_too) > -1e-6);
        assert_eq!(AffineSums::default().residual(), 0.0);
    }

    const COLUMN_FRAMES: usize = 12;
    const THRESHOLD: f64 = 2.8;

    /// Eight columns of six trajectories at rest; the columns from `from` on move down by `speed` pixels a frame.
    fn columns(from: usize, speed: f32) -> Trajectories {
        let mut tracks = Trajectories::empty(COLUMN_FRAMES, (120, 80));
        for k in 0..48 {
            let (x, y) = (5.0 + 10.0 * (k / 6) as f32, 5.0 + 8.0 * (k % 6) as f32);
            let speed = if k / 6 < from { 0.0 } else { speed };
            tracks.push(0, (0..COLUMN_FRAMES).map(|t| (x, y + speed * t as f32, 0.05)));
        }
        tracks
    }

    /// Labels after merging clusters of two columns each, with discontinuities `d`.
    fn merged_labels(tracks: &Trajectories, d: f64, separation: Option<&Separation>) -> Vec<u32> {
        let discontinuities = discontinuities(tracks, d);
        let mut label: Vec<u32> = (0..48).map(|k| k / 12).collect();
        let affinity = AffinityParams::default();
        let input =
            EvidenceInput { tracks, discontinuities: &discontinuities, affinity: &affinity, camera: &[], separation };
        merge_by_evidence(&mut label, &input, THRESHOLD);
        label
    }

    #[test]
    fn clusters_of_one_motion_are_merged() {
        assert_eq!(merged_labels(&columns(8, 0.0), 0.5, None), [0; 48]);
        let two: Vec<u32> = (0..48).map(|k| if k < 24 { 0 } else { 2 }).collect();
        assert_eq!(merged_labels(&columns(4, 2.0), 0.9, None), two);
    }

    #[test]
    fn separated_clusters_are_not_merged() {
        let tracks = columns(8, 0.0);
        let parts = Components {
            count: vec![2; COLUMN_FRAMES],
            of_point: (0..48 * COLUMN_FRAMES).map(|p| Some(u32::from(p / COLUMN_FRAMES >= 24))).collect(),
        };
        let settings = ConnectednessParams { mode: ConnectednessMode::Paper, ..ConnectednessParams::default() };
        let separation = Separation::new(&tracks, &parts, &settings);
        let label = merged_labels(&tracks, 0.1, Some(&separation));
        assert_eq!(label, (0..48).map(|k| if k < 24 { 0 } else { 2 }).collect::<Vec<_>>());
    }

    #[test]
    fn unlabelled_trajectories_stay_unlabelled() {
        let tracks = columns(8, 0.0);
        let discontinuities = Discontinuities { neighborhoods: neighborhoods(&tracks), ..Discontinuities::default() };
        let affinity = AffinityParams::default();
        let input = evidence_input(&tracks, &discontinuities, &affinity, &[]);
        let mut label = vec![UNLABELLED; 48];
        merge_by_evidence(&mut label, &input, THRESHOLD);
        assert_eq!(label, [UNLABELLED; 48]);
    }

    #[test]
    fn objects_keep_off_the_border_or_contrast_with_the_camera() {
        let value = |border_share: f64, contrast| moving(0.3, border_share, contrast, 0.1).log_odds();
        for border_share in [0.9, 0.1] {
            assert!(value(border_share, Some(5.0)) > value(border_share, Some(0.2)));
        }
        assert!(value(1.1, Some(0.2)) < 0.0 && value(0.0, Some(5.0)) > 0.0);
        // A piece of the scene in the middle of the frame; a near part of a deep scene, and a small object or one that bends, as
        // near to the border.
        assert!(value(0.6, Some(0.3)) < 0.0 && value(1.2, Some(5.0)) < -1.5);
        assert!(
            moving(0.01, 1.2, Some(5.0), 0.1).log_odds() > -0.5 && moving(0.3, 1.2, Some(5.0), 3.0).log_odds() > -0.5
        );
        assert!(value(1.1, None) < 0.0 && value(0.0, None) > 0.0);
    }

    /// The cues of a cluster with this part of the frame.
    fn moving(part: f64, border_share: f64, contrast: Option<f64>, residual_sq: f64) -> ClusterCues {
        let motion = contrast.map(|contrast| ClusterMotion { contrast, residual_sq });
        ClusterCues::Moving { border_share, border_excess: (part * (border_share - 1.0)).max(0.0), motion }
    }

    #[test]
    fn log_odds_of_an_object_have_no_jump_at_any_share_of_the_border() {
        let value = |step: u32| moving(0.2, f64::from(step) / 100.0, Some(4.0), 0.1).log_odds();
        let falls: Vec<f64> = (50..150).map(|step| value(step) - value(step + 1)).collect();
        assert!(falls.iter().all(|fall| (0.0..0.1).contains(fall)), "{falls:?}");
    }

    #[test]
    fn clusters_far_from_the_plate_are_objects() {
        let value = |plate_distance| ClusterCues::Still { plate_distance }.log_odds();
        // Swaying leaves look like the plate; an object does in places.
        assert!(value(0.02) < -1.5 && value(0.4) > 0.0);
    }
}
