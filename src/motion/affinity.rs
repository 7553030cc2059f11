//! Motion affinities between trajectories: the maximum velocity difference of Brox and Malik (ECCV 2010), as section
//! 2.1 asks.
//!
//! In: trajectories with the local flow variation at their points. Out: the symmetric sparse matrix A, entries in
//! `0.0..`.
//!
//! 1. Velocities over a horizon of `h` frames: `v_t = (p_{t+h} − p_t) / h`, in pixels per frame; the noise that a
//!    velocity may have, `s_t² = (weight · mean local flow variation over the horizon)² + floor²`.
//! 2. For a pair with common frames: `d_t² = d_sp · |v_t^a − v_t^b|² / (h · min(s_t^a, s_t^b)²)`, where `d_sp` is their
//!    mean distance over the common frames; `d² = max_t d_t²`; `A_ab = exp(−λ d²)`.
//! 3. Pairs within a radius are all taken. Of the farther ones a fixed pseudo-random fraction is taken with the inverse
//!    weight, so that degrees keep their expected value: without far pairs the graph has a continuum of slow modes and
//!    objects fragment.
//!
//! Deviations from Brox and Malik: the floor (σ → 0 on still or affine regions would cut everything), added in
//! quadrature; far pairs are sampled; "within the radius" is judged in the middle of the common frames. Pairs with
//! fewer common frames than `min_overlap` have no affinity. Cost: O(n²) cheap tests, O(pairs · common frames)
//! arithmetic.

use crate::Error;
use crate::rng::mix;
use crate::sparse::SymCsr;
use crate::trajectory::Trajectories;
use std::ops::Range;

crate::params! {
    /// Motion affinities.
    pub struct AffinityParams {
        /// λ of w = exp(−λ d²) (Brox and Malik 2010: 0.1). Higher separates weaker motion differences.
        pub lambda: f32 = 0.1, in 0.001..=100.0, expert;
        /// Horizon of a velocity, in frames (Brox and Malik 2010: 5).
        pub horizon: u32 = 5, in 1..=50, expert;
        /// Floor of the velocity noise, in pixels per frame, added in quadrature to the local flow variation. Lower
        /// separates weaker motion differences and fragments more.
        pub noise_floor: f32 = 0.2, in 0.001..=10.0;
        /// Factor of the local flow variation in the velocity noise (Brox and Malik 2010: 1). Lower separates weaker
        /// motion differences and fragments objects that turn, zoom or bend.
        pub variation_weight: f32 = 0.5, in 0.0..=10.0, expert;
        /// Radius within which every pair is compared, in steps of the seed grid. Higher is slower.
        pub local_radius: f32 = 7.5, in 1.0..=1000.0, expert;
        /// One of this many farther pairs is compared, with this weight. 0 leaves them out. Lower is slower.
        pub far_sampling: u32 = 32, in 0..=1000, expert;
        /// Fewest common frames of a pair, in frames; short clips use all frames they have.
        pub min_overlap: u32 = 4, in 2..=100, expert;
    }
}

/// Affinities below this are dropped (the value of the published normalized-cut code).
const NEGLIGIBLE: f32 = 1e-6;

/// The affinity matrix A of all trajectories; `spacing` is the typical distance of neighbours in a frame, in pixels.
///
/// # Errors
/// [`Error::Data`] when there are more pairs than 32-bit offsets can hold.
///
/// # Examples
/// Two trajectories move to the right, one to the left.
///
/// ```
/// use tracecut::affinity::{AffinityParams, affinities};
/// use tracecut::trajectory::Trajectories;
///
/// let mut tracks = Trajectories::empty(8, (64, 48));
/// for (x, speed) in [(10.0, 2.0), (14.0, 2.0), (40.0, -2.0)] {
///     tracks.push(0, (0..8).map(|t| (x + speed * t as f32, 20.0, 0.0)));
/// }
/// let a = affinities(&tracks, 8.0, &AffinityParams::default(), 0)?;
/// let of_first: Vec<(usize, f64)> = a.row(0).filter(|&(j, _)| j > 0).collect();
/// assert_eq!(of_first, [(1, 1.0)]); // the third has none to the first
/// # Ok::<(), tracecut::Error>(())
/// ```
pub fn affinities(tracks: &Trajectories, spacing: f32, params: &AffinityParams, seed: u32) -> Result<SymCsr, Error> {
    let mut rows = AffinityRows::new(tracks, spacing, params, seed);
    while rows.advance(tracks, usize::MAX) {}
    rows.finish()
}

/// The computation of [`affinities`] in blocks of rows, for progress, for cancelling and for others to help with.
#[derive(Debug, Clone)]
pub(crate) struct AffinityRows {
    /// Number of trajectories.
    count: usize,
    /// Once they are needed: all rows may be made elsewhere.
    motions: Option<Motions>,
    params: AffinityParams,
    radius: f32,
    seed: u32,
    next: usize,
    upper: Vec<(u32, u32, f32)>,
}

/// Some rows of the upper triangle, and all that they are made from.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Rows {
    /// Those of the rows and all after them.
    pub(crate) tracks: Trajectories,
    /// The number of the first one, and how many rows are wanted.
    pub(crate) first: usize,
    pub(crate) count: usize,
    pub(crate) params: AffinityParams,
    /// In pixels, within which all pairs count.
    pub(crate) radius: f32,
    pub(crate) seed: u32,
}

impl Rows {
    /// The entries of these rows.
    pub(crate) fn entries(&self) -> Vec<(u32, u32, f32)> {
        let motions = Motions::new(&self.tracks, &self.params);
        let pairs = Pairs::new(&self.tracks, &motions, self.first, (&self.params, self.radius, self.seed));
        let mut upper = Vec::new();
        (0..self.count.min(self.tracks.len())).for_each(|i| pairs.row(i, &mut upper));
        upper
    }
}

impl AffinityRows {
    /// No pair is compared yet.
    pub(crate) fn new(tracks: &Trajectories, spacing: f32, params: &AffinityParams, seed: u32) -> Self {
        let radius = params.local_radius * spacing;
        Self { count: tracks.len(), motions: None, params: params.clone(), radius, seed, next: 0, upper: Vec::new() }
    }

    /// Rows done so far.
    pub(crate) fn done(&self) -> usize {
        self.next
    }

    /// Compares the next `rows` trajectories with all later ones. Returns whether any are left.
    pub(crate) fn advance(&mut self, tracks: &Trajectories, rows: usize) -> bool {
        let end = self.next.saturating_add(rows).min(tracks.len());
        let motions = self.motions.get_or_insert_with(|| Motions::new(tracks, &self.params));
        let pairs = Pairs::new(tracks, motions, 0, (&self.params, self.radius, self.seed));
        (self.next..end).for_each(|i| pairs.row(i, &mut self.upper));
        self.next = end;
        end < tracks.len()
    }

    /// The rows from `first` on, to be made elsewhere.
    pub(crate) fn rows(&self, tracks: &Trajectories, first: usize, count: usize) -> Rows {
        let tracks = tracks.beginning_with(first);
        Rows { tracks, first, count, params: self.params.clone(), radius: self.radius, seed: self.seed }
    }

    /// Takes the next `rows`, which were made elsewhere. Returns whether any are left.
    pub(crate) fn accept(&mut self, entries: Vec<(u32, u32, f32)>, rows: usize) -> bool {
        self.upper.extend(entries);
        self.next = self.next.saturating_add(rows).min(self.count);
        self.next < self.count
    }

    /// The matrix, once [`AffinityRows::advance`] has returned false.
    ///
    /// # Errors
    /// [`Error::Data`] when there are more pairs than 32-bit offsets can hold.
    pub(crate) fn finish(&self) -> Result<SymCsr, Error> {
        if self.upper.len() > (u32::MAX / 2) as usize {
            let reason =
                format!("{} trajectory pairs are too many (expected at most {})", self.upper.len(), u32::MAX / 2);
            return Err(Error::Data { reason });
        }
        Ok(SymCsr::from_upper(self.count, &self.upper))
    }
}

/// What pairs of trajectories are compared with.
struct Pairs<'a> {
    tracks: &'a Trajectories,
    motions: &'a Motions,
    /// The number of the first trajectory in the clip.
    first: usize,
    radius_sq: f32,
    lambda: f32,
    far_sampling: u64,
    min_overlap: usize,
    seed: u64,
}

impl<'a> Pairs<'a> {
    fn new(
        tracks: &'a Trajectories,
        motions: &'a Motions,
        first: usize,
        (params, radius, seed): (&AffinityParams, f32, u32),
    ) -> Self {
        Self {
            tracks,
            motions,
            first,
            radius_sq: radius.powi(2),
            lambda: params.lambda,
            far_sampling: u64::from(params.far_sampling),
            min_overlap: (params.min_overlap as usize).min(tracks.num_frames.max(2)),
            seed: mix(u64::from(seed) ^ 0xaff1),
        }
    }

    /// Compares trajectory `i` with all later ones.
    fn row(&self, i: usize, upper: &mut Vec<(u32, u32, f32)>) {
        let tracks = self.tracks;
        let frames = tracks.frames(i);
        for j in i + 1..tracks.len() {
            let start = (tracks.start_frame[j] as usize).max(frames.start);
            let end = frames.end.min(tracks.frames(j).end);
            if end < start + self.min_overlap {
                continue;
            }
            let middle = (start + end) / 2;
            let p = tracks.point(i, middle);
            let q = tracks.point(j, middle);
            let apart = (tracks.x[p] - tracks.x[q]).powi(2) + (tracks.y[p] - tracks.y[q]).powi(2);
            let pair = (self.first + i, self.first + j);
            let scale = if apart <= self.radius_sq {
                1.0
            } else if self.far_sampling > 0
                && mix(self.seed ^ ((pair.0 as u64) << 32 | pair.1 as u64)).is_multiple_of(self.far_sampling)
            {
                self.far_sampling as f32
            } else {
                continue;
            };
            let w = libm::expf(-self.lambda * self.motions.distance_sq(tracks, i, j, start..end));
            if w >= NEGLIGIBLE {
                upper.push((pair.0 as u32, pair.1 as u32, w * scale));
            }
        }
    }
}

/// Velocity and inverse noise at every point that has a full horizon after it, laid out like the points.
#[derive(Debug, Clone)]
pub(crate) struct Motions {
    horizon: usize,
    floor_sq: f32,
    variation_weight: f32,
    vx: Vec<f32>,
    vy: Vec<f32>,
    /// `1 / s_t²`
    certainty: Vec<f32>,
}

impl Motions {
    pub(crate) fn new(tracks: &Trajectories, params: &AffinityParams) -> Self {
        let points = tracks.x.len();
        let mut motions = Self {
            horizon: params.horizon as usize,
            floor_sq: params.noise_floor * params.noise_floor,
            variation_weight: params.variation_weight,
            vx: vec![0.0; points],
            vy: vec![0.0; points],
            certainty: vec![0.0; points],
        };
        for i in 0..tracks.len() {
            let range = tracks.points(i);
            for p in range.start..range.end.saturating_sub(motions.horizon) {
                let (vx, vy, certainty) = motions.velocity(tracks, p, motions.horizon);
                (motions.vx[p], motions.vy[p], motions.certainty[p]) = (vx, vy, certainty);
            }
        }
        motions
    }

    /// Velocity over `horizon` frames from point `p` on, and `1 / s²`.
    fn velocity(&self, tracks: &Trajectories, p: usize, horizon: usize) -> (f32, f32, f32) {
        let over = 1.0 / horizon as f32;
        let sigma = self.variation_weight * tracks.variation[p..p + horizon].iter().sum::<f32>() * over;
        let (dx, dy) = (tracks.x[p + horizon] - tracks.x[p], tracks.y[p + horizon] - tracks.y[p]);
        (dx * over, dy * over, 1.0 / (sigma * sigma + self.floor_sq))
    }

    /// The frames that a velocity runs over.
    pub(crate) fn horizon(&self) -> usize {
        self.horizon
    }

    /// Velocity from a point on, in pixels a frame, and the inverse square of its noise; 0 without a full horizon after it.
    pub(crate) fn at(&self, p: usize) -> (f32, f32, f32) {
        (self.vx[p], self.vy[p], self.certainty[p])
    }

    /// `d²(i, j)` over the common frames, at least two.
    fn distance_sq(&self, tracks: &Trajectories, i: usize, j: usize, common: Range<usize>) -> f32 {
        let (p, q) = (tracks.point(i, common.start), tracks.point(j, common.start));
        let length = common.len();
        let mut apart = 0.0;
        for k in 0..length {
            apart += ((tracks.x[p + k] - tracks.x[q + k]).powi(2) + (tracks.y[p + k] - tracks.y[q + k]).powi(2)).sqrt();
        }
        let mut largest = 0.0_f32;
        if length > self.horizon {
            for k in 0..length - self.horizon {
                let (a, b) = (p + k, q + k);
                let difference = (self.vx[a] - self.vx[b]).powi(2) + (self.vy[a] - self.vy[b]).powi(2);
                largest = largest.max(difference * self.certainty[a].max(self.certainty[b]));
            }
        } else {
            let (a, b) = (self.velocity(tracks, p, length - 1), self.velocity(tracks, q, length - 1));
            largest = ((a.0 - b.0).powi(2) + (a.1 - b.1).powi(2)) * a.2.max(b.2);
        }
        apart / length as f32 * largest / self.horizon as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Trajectories of constant velocity from frame `start`, each `(x, y, u, v, start, length)`.
    fn moving(frames: usize, list: &[(f32, f32, f32, f32, usize, usize)]) -> Trajectories {
        let mut tracks = Trajectories::empty(frames, (640, 480));
        for &(x, y, u, v, start, length) in list {
            tracks.push(start, (0..length).map(|k| (x + u * k as f32, y + v * k as f32, 0.0)));
        }
        tracks
    }

    fn value(a: &SymCsr, i: usize, j: usize) -> f64 {
        a.row(i).find(|&(k, _)| k == j).map_or(0.0, |(_, w)| w)
    }

    #[test]
    fn the_affinity_of_two_constant_velocities_has_its_closed_form() {
        let tracks = moving(10, &[(100.0, 100.0, 1.0, 0.0, 0, 10), (120.0, 100.0, 1.0, 0.4, 0, 10)]);
        let a = affinities(&tracks, 8.0, &AffinityParams::default(), 0).unwrap();
        let apart = (0..10).map(|k| 20.0_f64.hypot(0.4 * k as f64)).sum::<f64>() / 10.0;
        let expected = (-0.1 * apart * 0.16 / (5.0 * 0.2 * 0.2)).exp();
        assert!((value(&a, 0, 1) - expected).abs() < 1e-5, "{} {expected}", value(&a, 0, 1));
    }

    #[test]
    fn equal_motion_has_affinity_one_and_no_common_frames_none() {
        let tracks =
            moving(20, &[(10.0, 10.0, 1.0, 1.0, 0, 10), (30.0, 10.0, 1.0, 1.0, 2, 8), (30.0, 30.0, 1.0, 1.0, 10, 10)]);
        let a = affinities(&tracks, 8.0, &AffinityParams::default(), 0).unwrap();
        a.check().unwrap();
        assert!((value(&a, 0, 1) - 1.0).abs() < 1e-6);
        assert_eq!(value(&a, 0, 2), 0.0);
    }

    #[test]
    fn a_difference_in_one_moment_counts_fully() {
        let mut tracks = moving(20, &[(10.0, 10.0, 1.0, 0.0, 0, 20), (30.0, 10.0, 1.0, 0.0, 0, 20)]);
        let before = value(&affinities(&tracks, 8.0, &AffinityParams::default(), 0).unwrap(), 0, 1);
        for p in 30..40 {
            tracks.y[p] += 3.0;
        }
        let after = value(&affinities(&tracks, 8.0, &AffinityParams::default(), 0).unwrap(), 0, 1);
        assert!(before > 0.99 && after < 0.3, "{before} {after}");
    }

    #[test]
    fn far_pairs_are_sampled_at_their_rate_with_inverse_weight() {
        let list: Vec<_> = (0..400).map(|k| (k as f32 % 2.0 * 500.0 + 10.0, (k / 2) as f32, 0.0, 0.0, 0, 8)).collect();
        let params = AffinityParams { local_radius: 50.0, ..AffinityParams::default() };
        let a = affinities(&moving(8, &list), 8.0, &params, 0).unwrap();
        let far: Vec<f64> = a.value.iter().map(|&w| f64::from(w)).filter(|&w| w > 1.5).collect();
        assert!(far.iter().all(|&w| (w - 32.0).abs() < 1e-4));
        let expected = 2.0 * 200.0 * 200.0;
        assert!((far.iter().sum::<f64>() / expected - 1.0).abs() < 0.1, "{}", far.iter().sum::<f64>() / expected);
        assert_ne!(a, affinities(&moving(8, &list), 8.0, &params, 1).unwrap());
    }

    #[test]
    fn blocks_of_rows_give_the_same_matrix_and_no_trajectories_an_empty_one() {
        let list: Vec<_> =
            (0..60).map(|k| ((k % 10) as f32 * 8.0, (k / 10) as f32 * 8.0, 0.1 * k as f32, 0.0, 0, 9)).collect();
        let (tracks, params) = (moving(9, &list), AffinityParams::default());
        let mut rows = AffinityRows::new(&tracks, 8.0, &params, 3);
        while rows.advance(&tracks, 7) {}
        assert_eq!(rows.finish().unwrap(), affinities(&tracks, 8.0, &params, 3).unwrap());
        assert!(affinities(&Trajectories::empty(5, (8, 8)), 8.0, &params, 0).unwrap().is_empty());
    }

    #[test]
    fn two_frames_are_enough() {
        let tracks = moving(2, &[(10.0, 10.0, 1.0, 0.0, 0, 2), (20.0, 10.0, 1.0, 0.0, 0, 2)]);
        assert!((value(&affinities(&tracks, 8.0, &AffinityParams::default(), 0).unwrap(), 0, 1) - 1.0).abs() < 1e-6);
    }
}
