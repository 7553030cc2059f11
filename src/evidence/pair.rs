//! The log-odds that two neighbouring clusters are one thing.

use super::affine::AffineSums;
use super::weights::PAIR;
use crate::affinity::{AffinityParams, Motions};
use crate::camera::DominantMotion;
use crate::connectedness::Separation;
use crate::discontinuity::Discontinuities;
use crate::discretize::UNLABELLED;
use crate::trajectory::Trajectories;

/// A wrong join is held to be as bad as e to the power of this many wrong parts.
const CAUTION: f64 = 1.0;
/// The log-odds that two are one which the foreground has apart in some frame.
const APART: f64 = -10.0;
/// Fewest velocities of a cluster in a frame for its motion there to count.
const FEWEST: f64 = 4.0;
/// Least that a motion leaves over, in squares of the noise: below, differences mean nothing.
const LEAST: f64 = 0.01;

/// How many terms there are.
const TERMS: usize = PAIR.len() - 1;

/// What clusters are compared by.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Known<'a> {
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

/// Two clusters that are neighbours, and what is known of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// The clusters, the lower first.
    pub clusters: (u32, u32),
    /// Mean discontinuity along the common border; how much more one affine motion leaves over than one each, by
    /// velocity of the smaller, as a logarithm of squares of the noise; difference of how far they are from the camera's
    /// motion, as mean logarithms.
    pub terms: [f64; TERMS],
}

impl Pair {
    /// The log-odds that both are one.
    fn log_odds(&self) -> f64 {
        PAIR[0] + PAIR[1..].iter().zip(self.terms).map(|(weight, term)| weight * term).sum::<f64>()
    }
}

/// For each pair of neighbours whose clusters differ the log-odds that these are one, less the caution, or that it is kept
/// apart by connectedness; 0 for all others.
pub(crate) fn along_borders(label: &[u32], known: &Known) -> Vec<f64> {
    let pairs = pairs(label, known);
    let odds: Vec<f64> = pairs.iter().map(|pair| pair.log_odds() - CAUTION).collect();
    let of = |&(i, j): &(u32, u32)| {
        let clusters = border(label, i, j)?;
        let kept_apart = known.separation.is_some_and(|s| s.apart(known.tracks, i as usize, j as usize));
        let place = pairs.binary_search_by_key(&clusters, |pair| pair.clusters).ok()?;
        Some(if kept_apart { APART } else { odds[place] })
    };
    known.found.neighborhoods.pairs.iter().map(|pair| of(pair).unwrap_or(0.0)).collect()
}

/// The clusters of two trajectories, the lower first; `None` where they have one, or one has none.
fn border(label: &[u32], i: u32, j: u32) -> Option<(u32, u32)> {
    let (p, q) = (label[i as usize], label[j as usize]);
    (p != q && p != UNLABELLED && q != UNLABELLED).then_some((p.min(q), p.max(q)))
}

/// All neighbouring clusters, in order, and what is known of them.
pub(crate) fn pairs(label: &[u32], known: &Known) -> Vec<Pair> {
    let count = label.iter().filter(|&&l| l != UNLABELLED).max().map_or(0, |&l| l as usize + 1);
    let mut borders = vec![(0.0, 0.0); count * count];
    for (&(i, j), d) in known.found.neighborhoods.pairs.iter().zip(&known.found.d) {
        if let Some((p, q)) = border(label, i, j) {
            let sum: &mut (f64, f64) = &mut borders[p as usize * count + q as usize];
            *sum = (sum.0 + d, sum.1 + 1.0);
        }
    }
    let clusters = Summary::of_clusters(label, count, known);
    let at = |place: usize| (place / count, place % count);
    let neighbours = borders.iter().enumerate().filter(|(_, sum)| sum.1 > 0.0);
    neighbours
        .map(|(place, &(d, pairs))| {
            let (p, q) = at(place);
            let (a, b) = (&clusters[p], &clusters[q]);
            let terms = [d / pairs, libm::log(a.gain(b) + LEAST), (a.strangeness() - b.strangeness()).abs()];
            Pair { clusters: (p as u32, q as u32), terms }
        })
        .collect()
}

/// What is known of one cluster.
struct Summary {
    /// Its velocities in each frame.
    motion: Vec<AffineSums>,
    /// ln(1 + r²) of the differences from the camera's motion in units of the noise, their sum and number.
    strange: (f64, f64),
}

impl Summary {
    fn of_clusters(label: &[u32], count: usize, known: &Known) -> Vec<Self> {
        let tracks = known.tracks;
        let velocities = Motions::new(tracks, known.affinity);
        let horizon = velocities.horizon();
        let blank = || Self { motion: vec![AffineSums::default(); tracks.num_frames], strange: (0.0, 0.0) };
        let mut clusters: Vec<Self> = (0..count).map(|_| blank()).collect();
        let half = [tracks.size.0, tracks.size.1].map(|side| side as f64 / 2.0);
        for (i, &l) in label.iter().enumerate().filter(|(_, l)| **l != UNLABELLED) {
            let (cluster, points) = (&mut clusters[l as usize], tracks.points(i));
            let strays = from_camera(tracks, i, known.camera);
            for (s, p) in (points.start..points.end.saturating_sub(horizon)).enumerate() {
                let (u, v, weight) = velocities.at(p);
                let place = (f64::from(tracks.x[p]) / half[0] - 1.0, (f64::from(tracks.y[p]) - half[1]) / half[0]);
                cluster.motion[tracks.frames(i).start + s].add(place, (f64::from(u), f64::from(v)), f64::from(weight));
                let way = strays[s..s + horizon].iter().fold((0.0, 0.0), |sum, (x, y)| (sum.0 + x, sum.1 + y));
                let speed_sq = (way.0 * way.0 + way.1 * way.1) / (horizon * horizon) as f64;
                let strange = libm::log(1.0 + speed_sq * f64::from(weight));
                cluster.strange = (cluster.strange.0 + strange, cluster.strange.1 + 1.0);
            }
        }
        clusters
    }

    /// How much more one affine motion leaves over than one each, by velocity of the smaller, over the frames in which both
    /// have a few; 1 where there is no such frame.
    fn gain(&self, other: &Self) -> f64 {
        let (mut gain, mut counts) = (0.0, (0.0, 0.0));
        let both = self.motion.iter().zip(&other.motion).filter(|(a, b)| a.count >= FEWEST && b.count >= FEWEST);
        for (a, b) in both {
            gain += (a.with(b).residual() - a.residual() - b.residual()).max(0.0);
            counts = (counts.0 + a.count, counts.1 + b.count);
        }
        let fewer = f64::min(counts.0, counts.1);
        if fewer > 0.0 { gain / fewer } else { 1.0 }
    }

    fn strangeness(&self) -> f64 {
        self.strange.0 / self.strange.1.max(1.0)
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
        assert!(known_pairs[0].log_odds() > CAUTION && known_pairs[1].log_odds() < CAUTION, "{known_pairs:?}");
        assert!(known_pairs.iter().all(|pair| (pair.terms[0] - 0.7).abs() < 1e-12));
        let along = along_borders(&label, &known);
        for (&(i, j), &odds) in found.neighborhoods.pairs.iter().zip(&along) {
            let expected = match (label[i as usize], label[j as usize]) {
                (0, 1) | (1, 0) => known_pairs[0].log_odds() - CAUTION,
                (1, 2) | (2, 1) => known_pairs[1].log_odds() - CAUTION,
                _ => 0.0,
            };
            assert_eq!(odds, expected);
        }
    }

    #[test]
    fn a_higher_discontinuity_speaks_against_and_without_clusters_there_are_no_pairs() {
        let ((tracks, label), camera) = (scene(), at_rest());
        let affinity = AffinityParams::default();
        let odds = |d: f64| {
            let found = discontinuities(&tracks, d);
            let known =
                Known { tracks: &tracks, found: &found, affinity: &affinity, camera: &camera, separation: None };
            (pairs(&label, &known)[0].log_odds(), pairs(&vec![UNLABELLED; tracks.len()], &known).len())
        };
        assert!(odds(0.1).0 > odds(0.9).0);
        assert_eq!(odds(0.1).1, 0);
    }
}
