//! Motion affinities between trajectories by their largest velocity difference (section 2.1; Brox and Malik, ECCV 2010).
//!
//! In: trajectories with the local flow variation at their points. Out: the symmetric sparse matrix A, entries in
//! `0.0..`.
//!
//! 1. Velocities over a horizon of `h` frames: `v_t = (p_{t+h} − p_t) / h`, in pixels per frame, and their noise
//!    `s_t² = (weight · mean local flow variation over the horizon)² + floor²`.
//! 2. For a pair with common frames: `d_t² = d_sp · |v_t^a − v_t^b|² / (h · min(s_t^a, s_t^b)²)`, where `d_sp` is their
//!    mean distance over the common frames; `d² = max_t d_t²`; `A_ab = exp(−λ d²)`.
//! 3. All pairs within a radius count. Of farther pairs a fixed pseudo-random fraction counts, with the inverse weight, so
//!    that degrees keep their expected value. Without far pairs the graph has a continuum of slow modes, and objects
//!    fragment.
//!
//! **Deviations** from Brox and Malik: a noise floor, added in quadrature (σ → 0 on still or affine regions would cut
//! everything); sampling of far pairs, whose distance is measured in the middle of the common frames. Pairs with fewer
//! common frames than `min_overlap` have no affinity.
//!
//! **Cost**: O(n²) cheap tests, O(pairs · common frames) arithmetic. **Limits**: a translational model; on a zooming or
//! rotating object only close pairs are similar, and one wrong flow field lowers an affinity for good.

use crate::Error;
use crate::order::larger;
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

/// Smallest affinity kept (published normalized-cut code of Cour, Yu and Shi, 2004).
const MIN_AFFINITY: f32 = 1e-6;

/// Computes the affinity matrix A of all trajectories. `spacing` is the typical distance of neighbours in a frame, in
/// pixels.
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
/// let first_row: Vec<(usize, f64)> = a.row(0).collect();
/// assert_eq!(first_row, [(1, 1.0)]); // the third has no affinity to the first
/// # Ok::<(), tracecut::Error>(())
/// ```
pub fn affinities(tracks: &Trajectories, spacing: f32, params: &AffinityParams, seed: u32) -> Result<SymCsr, Error> {
    let mut rows = AffinityRows::new(tracks, spacing, params, seed);
    while rows.advance(tracks, usize::MAX) {}
    rows.finish()
}

/// The computation of [`affinities`] in blocks of rows, for progress, cancelling and other threads.
#[derive(Debug, Clone)]
pub(crate) struct AffinityRows {
    /// Number of trajectories.
    count: usize,
    /// Computed on demand: all rows may come from other threads.
    velocities: Option<Velocities>,
    params: AffinityParams,
    /// Radius within which all pairs count, in pixels.
    radius: f32,
    seed: u32,
    /// Number of rows done.
    pub(crate) num_done: usize,
    upper: Vec<(u32, u32, f32)>,
}

/// The input of a block of rows of the upper triangle.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AffinityBlock {
    /// The trajectories from `first` on.
    pub(crate) tracks: Trajectories,
    /// First row of the block.
    pub(crate) first: usize,
    /// Number of rows.
    pub(crate) count: usize,
    pub(crate) params: AffinityParams,
    /// Radius within which all pairs count, in pixels.
    pub(crate) radius: f32,
    pub(crate) seed: u32,
}

impl AffinityBlock {
    /// Computes the entries `(i, j, affinity)` of these rows.
    pub(crate) fn entries(&self) -> Vec<(u32, u32, f32)> {
        let velocities = Velocities::new(&self.tracks, &self.params);
        let pairs = Pairs::new(&self.tracks, &velocities, self.first, &self.params, self.radius, self.seed);
        let mut upper = Vec::new();
        (0..self.count.min(self.tracks.len())).for_each(|i| pairs.row(i, &mut upper));
        upper
    }
}

impl AffinityRows {
    /// Starts without any row done.
    pub(crate) fn new(tracks: &Trajectories, spacing: f32, params: &AffinityParams, seed: u32) -> Self {
        let radius = params.local_radius * spacing;
        Self {
            count: tracks.len(),
            velocities: None,
            params: params.clone(),
            radius,
            seed,
            num_done: 0,
            upper: Vec::new(),
        }
    }

    /// Compares the next `rows` trajectories with all later ones. Returns true while rows are left.
    pub(crate) fn advance(&mut self, tracks: &Trajectories, rows: usize) -> bool {
        let end = self.num_done.saturating_add(rows).min(tracks.len());
        let velocities = self.velocities.get_or_insert_with(|| Velocities::new(tracks, &self.params));
        let pairs = Pairs::new(tracks, velocities, 0, &self.params, self.radius, self.seed);
        (self.num_done..end).for_each(|i| pairs.row(i, &mut self.upper));
        self.num_done = end;
        end < tracks.len()
    }

    /// Returns the input of `count` rows from `first` on, for another thread.
    pub(crate) fn block(&self, tracks: &Trajectories, first: usize, count: usize) -> AffinityBlock {
        let tracks = trajectories_from(tracks, first);
        AffinityBlock { tracks, first, count, params: self.params.clone(), radius: self.radius, seed: self.seed }
    }

    /// Adds the entries of the next `rows` rows from another thread. Returns true while rows are left.
    pub(crate) fn accept(&mut self, entries: Vec<(u32, u32, f32)>, rows: usize) -> bool {
        self.upper.extend(entries);
        self.num_done = self.num_done.saturating_add(rows).min(self.count);
        self.num_done < self.count
    }

    /// Builds the matrix once [`AffinityRows::advance`] has returned false.
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

/// Copies the trajectories from number `first` on.
fn trajectories_from(tracks: &Trajectories, first: usize) -> Trajectories {
    let first = first.min(tracks.len());
    let point = tracks.offset[first] as usize;
    Trajectories {
        num_frames: tracks.num_frames,
        size: tracks.size,
        start_frame: tracks.start_frame[first..].to_vec(),
        offset: tracks.offset[first..].iter().map(|&o| o - point as u32).collect(),
        x: tracks.x[point..].to_vec(),
        y: tracks.y[point..].to_vec(),
        variation: tracks.variation[point..].to_vec(),
    }
}

/// The comparison of pairs of trajectories.
struct Pairs<'a> {
    tracks: &'a Trajectories,
    velocities: &'a Velocities,
    /// Number of the first trajectory in the clip.
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
        velocities: &'a Velocities,
        first: usize,
        params: &AffinityParams,
        radius: f32,
        seed: u32,
    ) -> Self {
        Self {
            tracks,
            velocities,
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
            let distance_sq = (tracks.x[p] - tracks.x[q]).powi(2) + (tracks.y[p] - tracks.y[q]).powi(2);
            let (row, column) = (self.first + i, self.first + j);
            let weight = if distance_sq <= self.radius_sq {
                1.0
            } else if self.far_sampling > 0
                && mix(self.seed ^ ((row as u64) << 32 | column as u64)).is_multiple_of(self.far_sampling)
            {
                self.far_sampling as f32
            } else {
                continue;
            };
            let affinity = libm::expf(-self.lambda * self.velocities.distance_sq(tracks, i, j, start..end));
            if affinity >= MIN_AFFINITY {
                upper.push((row as u32, column as u32, affinity * weight));
            }
        }
    }
}

/// Velocity and inverse noise at every point that has a full horizon after it, laid out like the points.
#[derive(Debug, Clone)]
pub(crate) struct Velocities {
    /// Frames that a velocity spans.
    pub(crate) horizon: usize,
    floor_sq: f32,
    variation_weight: f32,
    vx: Vec<f32>,
    vy: Vec<f32>,
    /// `1 / s_t²`
    precision: Vec<f32>,
}

impl Velocities {
    /// Computes the velocities of all points.
    pub(crate) fn new(tracks: &Trajectories, params: &AffinityParams) -> Self {
        let num_points = tracks.x.len();
        let mut velocities = Self {
            horizon: params.horizon as usize,
            floor_sq: params.noise_floor * params.noise_floor,
            variation_weight: params.variation_weight,
            vx: vec![0.0; num_points],
            vy: vec![0.0; num_points],
            precision: vec![0.0; num_points],
        };
        for i in 0..tracks.len() {
            let range = tracks.points(i);
            for p in range.start..range.end.saturating_sub(velocities.horizon) {
                let (vx, vy, precision) = velocities.velocity(tracks, p, velocities.horizon);
                (velocities.vx[p], velocities.vy[p], velocities.precision[p]) = (vx, vy, precision);
            }
        }
        velocities
    }

    /// Computes the velocity over `horizon` frames from point `p` on, and `1 / s²`.
    fn velocity(&self, tracks: &Trajectories, p: usize, horizon: usize) -> (f32, f32, f32) {
        let inverse = 1.0 / horizon as f32;
        let sigma = self.variation_weight * tracks.variation[p..p + horizon].iter().sum::<f32>() * inverse;
        let (dx, dy) = (tracks.x[p + horizon] - tracks.x[p], tracks.y[p + horizon] - tracks.y[p]);
        (dx * inverse, dy * inverse, 1.0 / (sigma * sigma + self.floor_sq))
    }

    /// Returns the velocity at point `p` in pixels per frame and the inverse square of its noise; zeros without a full
    /// horizon after it.
    pub(crate) fn at(&self, p: usize) -> (f32, f32, f32) {
        (self.vx[p], self.vy[p], self.precision[p])
    }

    /// Computes `d²(i, j)` over the common frames, at least two.
    fn distance_sq(&self, tracks: &Trajectories, i: usize, j: usize, common: Range<usize>) -> f32 {
        let (p, q) = (tracks.point(i, common.start), tracks.point(j, common.start));
        let length = common.len();
        let [px, qx] = [p, q].map(|start| &tracks.x[start..][..length]);
        let [py, qy] = [p, q].map(|start| &tracks.y[start..][..length]);
        let mut distance_sum = 0.0;
        for k in 0..length {
            distance_sum += ((px[k] - qx[k]).powi(2) + (py[k] - qy[k]).powi(2)).sqrt();
        }
        let mut largest = 0.0_f32;
        if length > self.horizon {
            let n = length - self.horizon;
            let [avx, bvx] = [p, q].map(|start| &self.vx[start..][..n]);
            let [avy, bvy] = [p, q].map(|start| &self.vy[start..][..n]);
            let [a, b] = [p, q].map(|start| &self.precision[start..][..n]);
            for k in 0..n {
                let difference = (avx[k] - bvx[k]).powi(2) + (avy[k] - bvy[k]).powi(2);
                largest = larger(difference * larger(a[k], b[k]), largest);
            }
        } else {
            let (a, b) = (self.velocity(tracks, p, length - 1), self.velocity(tracks, q, length - 1));
            largest = ((a.0 - b.0).powi(2) + (a.1 - b.1).powi(2)) * a.2.max(b.2);
        }
        distance_sum / length as f32 * largest / self.horizon as f32
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
