//! The log-odds that two neighbouring clusters are one thing.

use super::affine::AffineSums;
use super::weights::PAIR;
use crate::affinity::{AffinityParams, Motions};
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
pub(super) struct Border {
    /// Pairs of neighbours, one of each.
    pub(super) pairs: f64,
    /// Sum of their discontinuities.
    discontinuity: f64,
    /// How many of them the foreground has apart in some frame.
    pub(super) apart: f64,
}

impl Border {
    /// Both borders in one.
    pub(super) fn with(&self, other: &Self) -> Self {
        Self {
            pairs: self.pairs + other.pairs,
            discontinuity: self.discontinuity + other.discontinuity,
            apart: self.apart + other.apart,
        }
    }

    /// The borders of every two of `count` clusters; that of `(p, q)` with `p < q` lies at `p * count + q`.
    pub(super) fn all(label: &[u32], count: usize, known: &Known) -> Vec<Self> {
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
pub(super) fn count_of(label: &[u32]) -> usize {
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
pub(super) struct Summary {
    /// Number of trajectories.
    pub(super) size: f64,
    /// Its velocities in each frame.
    motion: Vec<AffineSums>,
    /// ln(1 + r²) of the differences from the camera's motion in units of the noise, their sum and number.
    strange: (f64, f64),
}

impl Summary {
    pub(super) fn of_clusters(label: &[u32], count: usize, known: &Known) -> Vec<Self> {
        let tracks = known.tracks;
        let velocities = Motions::new(tracks, known.affinity);
        let horizon = velocities.horizon();
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
    pub(super) fn take(&mut self, other: &Self) {
        self.size += other.size;
        self.motion.iter_mut().zip(&other.motion).for_each(|(a, b)| *a = a.with(b));
        self.strange = (self.strange.0 + other.strange.0, self.strange.1 + other.strange.1);
    }

    /// The terms of two clusters with this border, in the order of [`Pair::terms`].
    pub(super) fn terms(&self, other: &Self, border: &Border) -> [f64; TERMS] {
        let (gain, own) = self.gain(other);
        let apart = (self.strangeness() - other.strangeness()).abs();
        [border.discontinuity / border.pairs, libm::log(gain + LEAST_GAIN), apart, libm::log(own + LEAST_REST)]
    }

    /// How far it is from the camera's motion.
    pub(super) fn strangeness(&self) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discontinuity::neighborhoods;
    use crate::flow::FlowField;
    use crate::image::Plane;

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
}
