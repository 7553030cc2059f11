//! Merging pieces of one thing, by what is known of every two of them.

use super::pair::{Border, Known, Summary, UNLABELLED, count_of, log_odds};
use super::weights::PAIR;

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::affinity::AffinityParams;
    use crate::connectedness::{Components, ConnectednessMode, ConnectednessParams, Separation};
    use crate::discontinuity::{Discontinuities, neighborhoods};
    use crate::trajectory::Trajectories;

    const FRAMES: usize = 12;
    const CAUTION: f64 = 2.8;

    /// Eight columns of six trajectories at rest; the columns from `from` on move down by `speed` pixels a frame.
    fn columns(from: usize, speed: f32) -> Trajectories {
        let mut tracks = Trajectories::empty(FRAMES, (120, 80));
        for k in 0..48 {
            let (x, y) = (5.0 + 10.0 * (k / 6) as f32, 5.0 + 8.0 * (k % 6) as f32);
            let speed = if k / 6 < from { 0.0 } else { speed };
            tracks.push(0, (0..FRAMES).map(|t| (x, y + speed * t as f32, 0.05)));
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
            count: vec![2; FRAMES],
            of_point: (0..48 * FRAMES).map(|p| u32::from(p / FRAMES >= 24)).collect(),
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
}
