//! The log-odds that two neighbouring clusters are one thing.

use super::weights::{OBJECT, OBJECT_BEFORE_PLATE, PAIR};
use crate::affinity::{AffinityParams, Velocities};
use crate::camera::DominantMotion;
use crate::connectedness::Separation;
use crate::discontinuity::Discontinuities;
use crate::saliency::SaliencyMaps;
use crate::trajectory::Trajectories;

/// The label of a trajectory that has none yet.
pub(crate) const UNLABELLED: u32 = u32::MAX;

/// Fewest velocities of a cluster in a frame for its motion there to count.
const FEWEST: f64 = 4.0;
/// Least gain, and least that a motion leaves over, in squares of the noise: below, differences mean nothing.
const LEAST_GAIN: f64 = 0.01;
const LEAST_REST: f64 = 0.1;

/// Side of a square frame for which differences from the camera's motion are meant, in pixels: in smaller ones all moves
/// less.
const LARGE: f64 = 360.0;

/// How many terms there are.
const TERMS: usize = PAIR.len() - 1;

/// What clusters are compared by.
#[derive(Debug, Clone, Copy)]
pub struct Known<'a> {
    /// The trajectories.
    pub(crate) tracks: &'a Trajectories,
    /// Their neighbours and discontinuities.
    pub(crate) found: &'a Discontinuities,
    /// How velocities and their noise are taken.
    pub(crate) affinity: &'a AffinityParams,
    /// The camera's motion in each frame pair.
    pub(crate) camera: &'a [DominantMotion],
    /// What keeps trajectories of the foreground apart; `None` with connectedness off.
    pub(crate) separation: Option<&'a Separation>,
}

impl<'a> Known<'a> {
    /// Trajectories, their neighbours and discontinuities; velocities and their noise are taken as affinities have them.
    /// The camera's motion is that which the maps have seen; without maps it is held to stand still.
    pub fn new(
        tracks: &'a Trajectories,
        found: &'a Discontinuities,
        affinity: &'a AffinityParams,
        maps: Option<&'a SaliencyMaps>,
        separation: Option<&'a Separation>,
    ) -> Self {
        Self { tracks, found, affinity, camera: maps.map_or(&[], SaliencyMaps::motions), separation }
    }
}

/// Two clusters that are neighbours, and what is known of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// The clusters, the lower first.
    pub clusters: (u32, u32),
    /// Mean discontinuity along the common border; how much more one affine motion leaves over than one each, by
    /// velocity of the smaller, as a logarithm of squares of the noise; difference of how far they are from the camera's
    /// motion, as mean logarithms; what an affine motion of each leaves over, by velocity, as a logarithm like the second.
    pub terms: [f64; TERMS],
}

/// The common border of two clusters.
#[derive(Debug, Clone, Copy, Default)]
struct Border {
    /// Pairs of neighbours, one of each.
    pairs: f64,
    /// Sum of their discontinuities.
    discontinuity: f64,
    /// How many of them the foreground has apart in some frame.
    apart: f64,
}

impl Border {
    /// Both borders in one.
    fn with(&self, other: &Self) -> Self {
        Self {
            pairs: self.pairs + other.pairs,
            discontinuity: self.discontinuity + other.discontinuity,
            apart: self.apart + other.apart,
        }
    }

    /// The borders of every two of `count` clusters; that of `(p, q)` with `p < q` lies at `p * count + q`.
    fn all(label: &[u32], count: usize, known: &Known) -> Vec<Self> {
        let mut borders = vec![Self::default(); count * count];
        for (&(i, j), d) in known.found.neighborhoods.pairs.iter().zip(&known.found.d) {
            let (p, q) = (label[i as usize], label[j as usize]);
            if p != q && p != UNLABELLED && q != UNLABELLED {
                let apart = known.separation.is_some_and(|s| s.apart(known.tracks, i as usize, j as usize));
                let one = Self { pairs: 1.0, discontinuity: *d, apart: f64::from(u8::from(apart)) };
                let border = &mut borders[p.min(q) as usize * count + p.max(q) as usize];
                *border = border.with(&one);
            }
        }
        borders
    }
}

/// The number of clusters under these labels.
fn count_of(label: &[u32]) -> usize {
    label.iter().filter(|&&l| l != UNLABELLED).max().map_or(0, |&l| l as usize + 1)
}

/// All neighbouring clusters, in order, and what is known of them.
pub(crate) fn pairs(label: &[u32], known: &Known) -> Vec<Pair> {
    let count = count_of(label);
    let clusters = Summary::of_clusters(label, count, known);
    let neighbours = Border::all(label, count, known).into_iter().enumerate().filter(|(_, border)| border.pairs > 0.0);
    neighbours
        .map(|(place, border)| {
            let (p, q) = (place / count, place % count);
            Pair { clusters: (p as u32, q as u32), terms: clusters[p].terms(&clusters[q], &border) }
        })
        .collect()
}

/// What is known of one cluster; what is known of two together adds up.
#[derive(Debug, Clone)]
struct Summary {
    /// Number of trajectories.
    size: f64,
    /// Its velocities in each frame.
    motion: Vec<AffineSums>,
    /// ln(1 + r²) of the differences from the camera's motion in units of the noise, their sum and number.
    strange: (f64, f64),
}

impl Summary {
    fn of_clusters(label: &[u32], count: usize, known: &Known) -> Vec<Self> {
        let tracks = known.tracks;
        let velocities = Velocities::new(tracks, known.affinity);
        let horizon = velocities.horizon;
        let blank = || Self { size: 0.0, motion: vec![AffineSums::default(); tracks.num_frames], strange: (0.0, 0.0) };
        let mut clusters: Vec<Self> = (0..count).map(|_| blank()).collect();
        let half = [tracks.size.0, tracks.size.1].map(|side| side as f64 / 2.0);
        let scale_sq = (4.0 * half[0] * half[1] / LARGE.powi(2)).min(1.0);
        for (i, &l) in label.iter().enumerate().filter(|(_, l)| **l != UNLABELLED) {
            let (cluster, points) = (&mut clusters[l as usize], tracks.points(i));
            cluster.size += 1.0;
            let strays = from_camera(tracks, i, known.camera);
            for (s, p) in (points.start..points.end.saturating_sub(horizon)).enumerate() {
                let (u, v, weight) = velocities.at(p);
                let place = (f64::from(tracks.x[p]) / half[0] - 1.0, (f64::from(tracks.y[p]) - half[1]) / half[0]);
                cluster.motion[tracks.frames(i).start + s].add(place, (f64::from(u), f64::from(v)), f64::from(weight));
                let way = strays[s..s + horizon].iter().fold((0.0, 0.0), |sum, (x, y)| (sum.0 + x, sum.1 + y));
                let speed_sq = (way.0 * way.0 + way.1 * way.1) / (horizon * horizon) as f64;
                let strange = libm::log(1.0 + speed_sq * f64::from(weight) / scale_sq);
                cluster.strange = (cluster.strange.0 + strange, cluster.strange.1 + 1.0);
            }
        }
        clusters
    }

    /// Takes in another cluster.
    fn take(&mut self, other: &Self) {
        self.size += other.size;
        self.motion.iter_mut().zip(&other.motion).for_each(|(a, b)| *a = a.with(b));
        self.strange = (self.strange.0 + other.strange.0, self.strange.1 + other.strange.1);
    }

    /// The terms of two clusters with this border, in the order of [`Pair::terms`].
    fn terms(&self, other: &Self, border: &Border) -> [f64; TERMS] {
        let (gain, own) = self.gain(other);
        let apart = (self.strangeness() - other.strangeness()).abs();
        [border.discontinuity / border.pairs, libm::log(gain + LEAST_GAIN), apart, libm::log(own + LEAST_REST)]
    }

    /// How far it is from the camera's motion.
    fn strangeness(&self) -> f64 {
        self.strange.0 / self.strange.1.max(1.0)
    }

    /// How much more one affine motion leaves over than one each, by velocity of the smaller, and what one each leaves, by
    /// velocity, over the frames in which both have a few; 1 where there is no such frame.
    fn gain(&self, other: &Self) -> (f64, f64) {
        let (mut gain, mut own, mut counts) = (0.0, 0.0, (0.0, 0.0));
        let both = self.motion.iter().zip(&other.motion).filter(|(a, b)| a.count >= FEWEST && b.count >= FEWEST);
        for (a, b) in both {
            let alone = a.residual() + b.residual();
            gain += (a.with(b).residual() - alone).max(0.0);
            own += alone;
            counts = (counts.0 + a.count, counts.1 + b.count);
        }
        let fewer = f64::min(counts.0, counts.1);
        if fewer > 0.0 { (gain / fewer, own / (counts.0 + counts.1)) } else { (1.0, 1.0) }
    }
}

/// How far each step of trajectory `i` is from the camera's motion, in pixels; 0 where that is not known.
fn from_camera(tracks: &Trajectories, i: usize, camera: &[DominantMotion]) -> Vec<(f64, f64)> {
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

/// The log-odds that weights, a base first, give to terms.
pub(crate) fn log_odds(weights: &[f64], terms: &[f64]) -> f64 {
    weights[0] + weights[1..].iter().zip(terms).map(|(weight, term)| weight * term).sum::<f64>()
}

// How well one affine motion explains a set of velocities.

/// Part of the weights that holds the motion's slopes back: few points in a line leave some of them open.
const RIDGE: f64 = 1e-3;

/// Sums over points, from which the best affine motion and what it leaves over follow; those of two sets add up.
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
    /// Adds a point at a place of the order of 1 with a velocity in pixels a frame and the inverse square of its noise.
    fn add(&mut self, (x, y): (f64, f64), (u, v): (f64, f64), weight: f64) {
        self.count += 1.0;
        let basis = [1.0, x, y];
        let squares = [1.0, x, y, x * x, x * y, y * y];
        self.places.iter_mut().zip(squares).for_each(|(sum, value)| *sum += weight * value);
        self.u.iter_mut().zip(basis).for_each(|(sum, value)| *sum += weight * u * value);
        self.v.iter_mut().zip(basis).for_each(|(sum, value)| *sum += weight * v * value);
        self.energy += weight * (u * u + v * v);
    }

    /// Those of both sets.
    fn with(&self, other: &Self) -> Self {
        let mut sum = *self;
        sum.count += other.count;
        sum.places.iter_mut().zip(other.places).for_each(|(a, b)| *a += b);
        sum.u.iter_mut().zip(other.u).for_each(|(a, b)| *a += b);
        sum.v.iter_mut().zip(other.v).for_each(|(a, b)| *a += b);
        sum.energy += other.energy;
        sum
    }

    /// The squared differences from the best affine motion, in units of the noise, summed over the points.
    fn residual(&self) -> f64 {
        let [w, x, y, xx, xy, yy] = self.places;
        if w <= 0.0 {
            return 0.0;
        }
        // Elimination: the sums less their means, then the second axis less the first.
        let (xx, xy, yy) = (xx - x * x / w + RIDGE * w, xy - x * y / w, yy - y * y / w + RIDGE * w);
        let yy = yy - xy * xy / xx;
        let explained = |[b, bx, by]: [f64; 3]| {
            let (bx, by) = (bx - x * b / w, by - y * b / w);
            let by = by - xy * bx / xx;
            b * b / w + bx * bx / xx + by * by / yy
        };
        (self.energy - explained(self.u) - explained(self.v)).max(0.0)
    }
}

// Merging pieces of one thing, by what is known of every two of them.

/// How the caution falls with the share of trajectories, in powers of it: a fragment is one fragment however small it
/// is, and what a wrong join costs grows with the piece.
const BY_SHARE: f64 = 0.4;
/// The log-odds that two are one which the foreground has apart in some frame.
const APART: f64 = -3.0;

/// Gives pieces that are one thing a common label: while more than the caution speaks for it, the two neighbours for which
/// most does are joined, and what is known of both is weighed anew. Unlabelled trajectories take no part.
pub(crate) fn unite(label: &mut [u32], known: &Known, caution: f64) {
    let mut pieces = Pieces::new(label, known, caution);
    while let Some((p, q)) = pieces.likeliest() {
        pieces.join(p, q);
    }
    for l in label.iter_mut().filter(|l| **l != UNLABELLED) {
        *l = pieces.into[*l as usize];
    }
}

/// Pieces while they are joined; every two have a place `p * count + q`, `p < q`.
struct Pieces {
    count: usize,
    caution: f64,
    all: f64,
    summary: Vec<Summary>,
    border: Vec<Border>,
    /// What speaks for a join, above 0; least of all where there is no border.
    value: Vec<f64>,
    /// The piece that each has gone into.
    into: Vec<u32>,
}

impl Pieces {
    fn new(label: &[u32], known: &Known, caution: f64) -> Self {
        let count = count_of(label);
        let summary = Summary::of_clusters(label, count, known);
        let all = summary.iter().map(|s| s.size).sum();
        let border = Border::all(label, count, known);
        let value = vec![f64::NEG_INFINITY; border.len()];
        let mut pieces = Self { count, caution, all, summary, border, value, into: (0..count as u32).collect() };
        (0..count).for_each(|p| pieces.weigh(p));
        pieces
    }

    fn place(&self, p: usize, q: usize) -> usize {
        p.min(q) * self.count + p.max(q)
    }

    /// Weighs all joins of `p`.
    fn weigh(&mut self, p: usize) {
        for q in (0..self.count).filter(|&q| q != p) {
            let place = self.place(p, q);
            self.value[place] = self.value_of(p, q, &self.border[place]);
        }
    }

    fn value_of(&self, p: usize, q: usize, border: &Border) -> f64 {
        if border.pairs == 0.0 {
            return f64::NEG_INFINITY;
        }
        let (a, b) = (&self.summary[p], &self.summary[q]);
        let caution = self.caution + BY_SHARE * libm::log(a.size.min(b.size) / self.all);
        let apart = border.apart / border.pairs;
        (1.0 - apart) * (log_odds(&PAIR, &a.terms(b, border)) - caution) + apart * APART
    }

    /// The join for which most speaks, if anything does.
    fn likeliest(&self) -> Option<(usize, usize)> {
        let better = |best: usize, next: usize| if self.value[next] > self.value[best] { next } else { best };
        let best = (0..self.value.len()).reduce(better)?;
        (self.value[best] > 0.0).then_some((best / self.count, best % self.count))
    }

    /// Joins `q` into `p`.
    fn join(&mut self, p: usize, q: usize) {
        let other = self.summary[q].clone();
        self.summary[p].take(&other);
        for r in (0..self.count).filter(|&r| r != q) {
            let (from, to) = (self.place(q, r), self.place(p, r));
            let border = std::mem::take(&mut self.border[from]);
            self.value[from] = f64::NEG_INFINITY;
            if r != p {
                self.border[to] = self.border[to].with(&border);
            }
        }
        self.weigh(p);
        self.into.iter_mut().filter(|into| **into == q as u32).for_each(|into| *into = p as u32);
    }
}

// The log-odds that a cluster is an object and not the scene behind.

/// The log-odds at which an object is as well kept as left out: what pixels say can still take one away, but not bring it
/// back.
const CAUTION: f64 = -0.8;
/// What holds more of the rim than this is scene whatever its motion, such as what is near in a scene of depth.
const RUNS_ON: f64 = 1.0;
/// Without the motion, what holds less of the rim than usual is an object.
const OBJECT_BY_RIM: [f64; 2] = [-0.2, -2.0];

/// What a cluster is judged by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Signs {
    /// Where the camera moves, or nothing is known of it.
    Moving {
        /// Its share of the frame's rim over its share of the frame: 1 on average.
        rim: f64,
        /// How far it is from the camera's motion ([`strangeness`]), where that is known.
        strangeness: Option<f64>,
    },
    /// Where the camera stands still: how far it is from the background plate, 0 to 1.
    Still { unlike: f64 },
}

impl Signs {
    /// The terms of [`OBJECT`] or of [`OBJECT_BEFORE_PLATE`]; `None` where motion is not known.
    pub(crate) fn terms(&self) -> Option<Vec<f64>> {
        match *self {
            Self::Moving { rim, strangeness } => Some(vec![of_rim(rim), strangeness?]),
            Self::Still { unlike } => Some(vec![of_plate(unlike)]),
        }
    }

    /// What speaks for an object, above 0.
    pub(crate) fn value(&self) -> f64 {
        match *self {
            Self::Still { unlike } => log_odds(&OBJECT_BEFORE_PLATE, &[of_plate(unlike)]) - CAUTION,
            Self::Moving { rim, strangeness: None } => log_odds(&OBJECT_BY_RIM, &[of_rim(rim)]),
            Self::Moving { rim, strangeness: Some(_) } if rim > RUNS_ON => f64::NEG_INFINITY,
            Self::Moving { rim, strangeness: Some(far) } => log_odds(&OBJECT, &[of_rim(rim), far]) - CAUTION,
        }
    }
}

fn of_rim(rim: f64) -> f64 {
    libm::log(rim + 0.1)
}

fn of_plate(unlike: f64) -> f64 {
    libm::log(unlike + 0.02)
}

/// How far each cluster is from the camera's motion: the mean of ln(1 + r²) over its velocities, whose difference from
/// that motion is r in units of the noise.
pub(crate) fn strangeness(label: &[u32], known: &Known) -> Vec<f64> {
    Summary::of_clusters(label, count_of(label), known).iter().map(Summary::strangeness).collect()
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
        vec![DominantMotion::none(&FlowField { u: still.clone(), v: still }); FRAMES - 1]
    }

    fn discontinuities(tracks: &Trajectories, d: f64) -> Discontinuities {
        let neighborhoods = neighborhoods(tracks);
        let d = vec![d; neighborhoods.pairs.len()];
        Discontinuities { neighborhoods, d, ..Discontinuities::default() }
    }

    #[test]
    fn what_moves_as_the_camera_does_is_one_and_what_moves_otherwise_is_another() {
        let ((tracks, label), camera) = (scene(), at_rest());
        let (found, affinity) = (discontinuities(&tracks, 0.7), AffinityParams::default());
        let known = Known { tracks: &tracks, found: &found, affinity: &affinity, camera: &camera, separation: None };
        let known_pairs = pairs(&label, &known);
        assert_eq!(known_pairs.iter().map(|pair| pair.clusters).collect::<Vec<_>>(), [(0, 1), (1, 2)]);
        let [one, two] = [0, 1].map(|k| log_odds(&PAIR, &known_pairs[k].terms));
        assert!(one > two + 2.0, "{known_pairs:?}");
        assert!(known_pairs.iter().all(|pair| (pair.terms[0] - 0.7).abs() < 1e-12));
    }

    #[test]
    fn a_higher_discontinuity_speaks_against_and_without_clusters_there_are_no_pairs() {
        let ((tracks, label), camera) = (scene(), at_rest());
        let affinity = AffinityParams::default();
        let odds = |d: f64| {
            let found = discontinuities(&tracks, d);
            let known =
                Known { tracks: &tracks, found: &found, affinity: &affinity, camera: &camera, separation: None };
            let first = log_odds(&PAIR, &pairs(&label, &known)[0].terms);
            (first, pairs(&vec![UNLABELLED; tracks.len()], &known).len())
        };
        assert!(odds(0.1).0 > odds(0.9).0);
        assert_eq!(odds(0.1).1, 0);
    }

    #[test]
    fn what_is_known_of_two_adds_up_to_what_is_known_of_both() {
        let ((tracks, label), camera) = (scene(), at_rest());
        let (found, affinity) = (discontinuities(&tracks, 0.7), AffinityParams::default());
        let known = Known { tracks: &tracks, found: &found, affinity: &affinity, camera: &camera, separation: None };
        let parts = Summary::of_clusters(&label, 3, &known);
        let mut both = parts[0].clone();
        both.take(&parts[1]);
        let together: Vec<u32> = label.iter().map(|&l| l.saturating_sub(1)).collect();
        let expected = pairs(&together, &known)[0].terms;
        let border = Border { pairs: 1.0, discontinuity: 0.7, apart: 0.0 };
        for (a, b) in both.terms(&parts[2], &border).into_iter().zip(expected) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }

    /// Points that move by an affine motion, and by `noise` besides.
    fn points(motion: [f64; 6], noise: f64, seed: u64) -> AffineSums {
        let mut rng = Rng::for_stage(seed, "affine");
        let mut sums = AffineSums::default();
        for _ in 0..200 {
            let (x, y) = (rng.range(-1.0, 1.0), rng.range(-1.0, 1.0));
            let [a, b, c, d, e, f] = motion;
            let stray = (noise * rng.range(-1.0, 1.0), noise * rng.range(-1.0, 1.0));
            sums.add((x, y), (a + b * x + c * y + stray.0, d + e * x + f * y + stray.1), 4.0);
        }
        sums
    }

    #[test]
    fn an_affine_motion_leaves_hardly_anything_and_noise_is_left() {
        let motion = [3.0, 0.5, -0.2, 1.0, 0.3, 0.4];
        assert!(points(motion, 0.0, 1).residual() / 200.0 < 0.01);
        // Each axis has the variance of an even spread, noise² / 3.
        let left = points(motion, 0.5, 1).residual() / 200.0;
        assert!((left / (4.0 * 2.0 * 0.25 / 3.0) - 1.0).abs() < 0.15, "{left}");
    }

    #[test]
    fn two_motions_together_leave_more_than_apart_and_one_motion_does_not() {
        let (one, same) =
            (points([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.1, 1), points([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.1, 2));
        let other = points([2.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.1, 3);
        let gain = |a: &AffineSums, b: &AffineSums| a.with(b).residual() - a.residual() - b.residual();
        assert!(gain(&one, &other) > 100.0 * gain(&one, &same).max(0.1));
        assert!(gain(&one, &same) > -1e-6);
        assert_eq!(AffineSums::default().residual(), 0.0);
    }

    const COLUMN_FRAMES: usize = 12;
    const CAUTION: f64 = 2.8;

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

    /// Labels after merging pieces of two columns each, all discontinuities between which are `d`.
    fn united(tracks: &Trajectories, d: f64, separation: Option<&Separation>) -> Vec<u32> {
        let near = neighborhoods(tracks);
        let found = Discontinuities { d: vec![d; near.pairs.len()], neighborhoods: near, ..Discontinuities::default() };
        let mut label: Vec<u32> = (0..48).map(|k| k / 12).collect();
        let affinity = AffinityParams::default();
        unite(&mut label, &Known { tracks, found: &found, affinity: &affinity, camera: &[], separation }, CAUTION);
        label
    }

    #[test]
    fn pieces_of_one_motion_are_one_thing_and_those_of_two_are_two() {
        assert_eq!(united(&columns(8, 0.0), 0.5, None), [0; 48]);
        let two: Vec<u32> = (0..48).map(|k| if k < 24 { 0 } else { 2 }).collect();
        assert_eq!(united(&columns(4, 2.0), 0.9, None), two);
    }

    #[test]
    fn what_the_foreground_has_apart_stays_apart() {
        let tracks = columns(8, 0.0);
        let parts = Components {
            count: vec![2; COLUMN_FRAMES],
            of_point: (0..48 * COLUMN_FRAMES).map(|p| u32::from(p / COLUMN_FRAMES >= 24)).collect(),
        };
        let settings = ConnectednessParams { mode: ConnectednessMode::Paper, ..ConnectednessParams::default() };
        let separation = Separation::new(&tracks, &parts, &settings);
        let label = united(&tracks, 0.1, Some(&separation));
        assert_eq!(label, (0..48).map(|k| if k < 24 { 0 } else { 2 }).collect::<Vec<_>>());
    }

    #[test]
    fn unlabelled_ones_and_none_at_all_are_left() {
        let tracks = columns(8, 0.0);
        let found = Discontinuities { neighborhoods: neighborhoods(&tracks), ..Discontinuities::default() };
        let affinity = AffinityParams::default();
        let known = Known { tracks: &tracks, found: &found, affinity: &affinity, camera: &[], separation: None };
        let mut label = vec![UNLABELLED; 48];
        unite(&mut label, &known, CAUTION);
        assert_eq!(label, [UNLABELLED; 48]);
    }

    #[test]
    fn what_holds_the_rim_and_goes_with_the_camera_is_scene_and_what_does_neither_an_object() {
        let value = |rim: f64, strangeness| Signs::Moving { rim, strangeness }.value();
        for rim in [0.9, 0.1] {
            assert!(value(rim, Some(5.0)) > value(rim, Some(0.2)));
        }
        assert!(value(1.1, Some(0.2)) < 0.0 && value(0.0, Some(5.0)) > 0.0);
        // A piece of the scene in the middle of the frame; what is near in a scene of depth.
        assert!(value(0.6, Some(0.3)) < 0.0 && value(2.0, Some(9.0)) < 0.0);
        assert!(value(1.1, None) < 0.0 && value(0.0, None) > 0.0);
    }

    #[test]
    fn what_is_like_the_plate_is_scene_and_what_is_not_an_object() {
        let value = |unlike| Signs::Still { unlike }.value();
        // Leaves sway over what looks like them. An object is like the plate in places.
        assert!(value(0.02) < -1.5 && value(0.4) > 0.0);
    }
}
