//! Saliency of trajectories, by their points and in the context of the embedding (section 3).

use super::{Neighborhood, SaliencyParams};
use crate::discontinuity::Discontinuities;
use crate::embedding::Embedding;
use crate::image::Plane;
use crate::trajectory::Trajectories;

/// Trajectories whose affinities to one are computed together: they fit into the first cache.
const BLOCK: usize = 1024;

/// Sums in parallel: the width of vector registers.
const LANES: usize = 8;

/// Saliency of each trajectory.
///
/// Law: all three have one entry for each trajectory; saliencies are in `0.0..=1.0`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Saliency {
    /// `s_i`: the greatest saliency of the trajectory's points.
    pub of_points: Vec<f32>,
    /// `s̄_i`: the mean of `s` over the trajectory's neighbourhood in the embedding.
    pub in_context: Vec<f32>,
    /// `true` where `s̄_i` is above the threshold.
    pub foreground: Vec<bool>,
}

/// The points of frame `t`, of `size` pixels, each with the nearest pixel.
pub(crate) fn point_pixels(
    tracks: &Trajectories,
    t: usize,
    size: (usize, usize),
) -> impl Iterator<Item = (usize, (usize, usize))> + '_ {
    let nearest = |v: f32, side: usize| ((v + 0.5).max(0.0) as usize).min(side - 1);
    tracks.alive(t).map(move |(i, x, y)| (tracks.point(i, t), (nearest(x, size.0), nearest(y, size.1))))
}

/// `s_i`: the greatest saliency of a trajectory's points (section 3), at the pixels nearest to them.
///
/// `maps` has the saliency maps of the frames from the first on. Trajectories without a point in these frames have 0.
///
/// # Examples
/// ```
/// use tracecut::image::Plane;
/// use tracecut::saliency::trajectory_saliency;
/// use tracecut::trajectory::Trajectories;
///
/// let mut tracks = Trajectories::empty(4, (8, 8));
/// tracks.push(0, [(1.0, 1.0, 0.0); 4]);
/// tracks.push(2, [(5.0, 5.0, 0.0); 2]);
/// let maps = [0.125, 0.75].map(|saliency| Plane::filled(8, 8, saliency));
/// assert_eq!(trajectory_saliency(&tracks, &maps), [0.75, 0.0]);
/// ```
#[must_use]
pub fn trajectory_saliency(tracks: &Trajectories, maps: &[Plane<f32>]) -> Vec<f32> {
    let mut of_points = vec![-1.0; tracks.x.len()];
    for (t, map) in maps.iter().enumerate() {
        for (point, pixel) in point_pixels(tracks, t, (map.width(), map.height())) {
            of_points[point] = map[pixel];
        }
    }
    greatest_of_points(tracks, &of_points)
}

/// Returns the greatest saliency of each trajectory's points. `of_points` has one number for each point of `tracks`, below 0 if
/// unknown. Trajectories without a known point have 0.
pub(crate) fn greatest_of_points(tracks: &Trajectories, of_points: &[f32]) -> Vec<f32> {
    (0..tracks.len()).map(|i| of_points[tracks.points(i)].iter().copied().fold(0.0, f32::max)).collect()
}

/// Computes the context-aware saliency of each trajectory from its own saliency.
///
/// The neighbourhood of `i` is all trajectories `j` of the clip, at any distance in space and time, with
/// `Ŵ_ij > ℓ max(δ_i, δ_j)` (or `min`). The paper prints `max(Ŵ_ij / δ_i, Ŵ_ji / δ_j) < ℓ`, which would average over
/// the trajectories *unlike* `i`; with the sign reversed it is the form `min`. Ŵ and δ are as in the discontinuities.
///
/// Trajectories that are not embedded or have no density keep their own saliency. Cost: O(n² K), in single precision
/// without branches: under 0.1 s in wasm for n = 5000, K = 6.
///
/// # Examples
/// One of the right-hand trajectories of [`discontinuities`](crate::discontinuity::discontinuities)' example is not
/// salient alone, while trajectories that move like it are.
///
/// ```
/// # use tracecut::discontinuity::{DiscontinuityParams, discontinuities, neighborhoods};
/// # use tracecut::embedding::{EmbeddingParams, embed};
/// # use tracecut::sparse::SymCsr;
/// # use tracecut::trajectory::Trajectories;
/// #
/// # // A trajectory for each digit; equal digits move alike.
/// # let digits = ["00011", "00011", "00011"].concat().into_bytes();
/// # let mut tracks = Trajectories::empty(1, (50, 30));
/// # (0..15).for_each(|i| tracks.push(0, [(10.0 * (i % 5) as f32, 10.0 * (i / 5) as f32 + (i % 5 % 2) as f32, 0.0)]));
/// # let pairs = (0..15_u32).flat_map(|i| (i + 1..15).map(move |j| (i, j)));
/// # let alike = pairs.filter(|&(i, j)| digits[i as usize] == digits[j as usize]);
/// # let a = SymCsr::from_upper(15, &alike.map(|(i, j)| (i, j, 1.0)).collect::<Vec<_>>());
/// # let mut params = EmbeddingParams::default();
/// # params.min_component = 2;
/// # params.min_dimensions = 1;
/// # let embedding = embed(&a, &params, 0);
/// # let d = discontinuities(neighborhoods(&tracks), &embedding, &DiscontinuityParams::default());
/// use tracecut::saliency::{SaliencyParams, context_saliency};
///
/// let own: Vec<f32> = (0..15).map(|i| if i % 5 >= 3 && i != 4 { 0.9 } else { 0.0 }).collect();
/// let saliency = context_saliency(own, &embedding, &d, &SaliencyParams::default());
/// assert!(saliency.foreground[4] && (saliency.in_context[4] - 0.75).abs() < 1e-6);
/// assert!(!saliency.foreground[0]);
/// ```
#[must_use]
pub fn context_saliency(
    of_points: Vec<f32>,
    embedding: &Embedding,
    discontinuities: &Discontinuities,
    params: &SaliencyParams,
) -> Saliency {
    let rows = EmbeddedRows::new(&of_points, embedding, discontinuities, params);
    let mut in_context = of_points.clone();
    for (row, &i) in rows.ids.iter().enumerate() {
        in_context[i as usize] = rows.neighbourhood_mean(row);
    }
    let foreground = in_context.iter().map(|&s| f64::from(s) > params.threshold).collect();
    Saliency { of_points, in_context, foreground }
}

/// The embedded trajectories, column by column.
struct EmbeddedRows {
    ids: Vec<u32>,
    dimensions: usize,
    /// `V` and `V Λ`, `K × n`.
    plain: Vec<f32>,
    scaled: Vec<f32>,
    /// `ℓ δ`.
    bound: Vec<f32>,
    saliency: Vec<f32>,
    /// Compares with the greater of two bounds, not the smaller.
    is_max: bool,
}

impl EmbeddedRows {
    fn new(saliency: &[f32], embedding: &Embedding, d: &Discontinuities, params: &SaliencyParams) -> Self {
        let has_context = |&i: &u32| embedding.embedded[i as usize] && d.density[i as usize] > 0.0;
        let ids: Vec<u32> = (0..saliency.len() as u32).filter(has_context).collect();
        let dimensions = d.dimensions;
        let column = |k: usize, factor: f64| {
            let value = move |&i: &u32| (embedding.row(i as usize)[k] * factor) as f32;
            ids.iter().map(value).collect::<Vec<f32>>()
        };
        let plain = (0..dimensions).flat_map(|k| column(k, 1.0)).collect();
        let scaled = (0..dimensions).flat_map(|k| column(k, embedding.eigenvalues[k])).collect();
        let bound = ids.iter().map(|&i| (params.neighborhood * d.density[i as usize]) as f32).collect();
        let saliency = ids.iter().map(|&i| saliency[i as usize]).collect();
        Self { dimensions, plain, scaled, bound, saliency, is_max: params.form == Neighborhood::Max, ids }
    }

    /// Mean saliency over the neighbourhood of row `i`.
    fn neighbourhood_mean(&self, i: usize) -> f32 {
        let n = self.ids.len();
        let mut affinity = [0.0_f32; BLOCK];
        let (mut sum, mut count) = (0.0, 0.0);
        for begin in (0..n).step_by(BLOCK) {
            let block = begin..(begin + BLOCK).min(n);
            let affinity = &mut affinity[..block.len()];
            affinity.fill(0.0);
            for k in 0..self.dimensions {
                let v = self.scaled[k * n + i];
                let column = &self.plain[k * n..][block.clone()];
                affinity.iter_mut().zip(column).for_each(|(a, c)| *a += v * c);
            }
            let (block_sum, block_count) = self.sum_neighbours(i, affinity, block);
            sum += block_sum;
            count += block_count;
        }
        // A trajectory may be no neighbour of itself.
        if count > 0.0 { (sum / count).clamp(0.0, 1.0) } else { self.saliency[i] }
    }

    /// Sums the saliency of the neighbours of `i` in a block. Returns the sum and their number.
    fn sum_neighbours(&self, i: usize, affinity: &[f32], block: std::ops::Range<usize>) -> (f32, f32) {
        let bound = self.bound[i];
        let (mut sums, mut counts) = ([0.0_f32; LANES], [0.0_f32; LANES]);
        let (bounds, saliency) = (&self.bound[block.clone()], &self.saliency[block]);
        let mut add = |w: &[f32], bounds: &[f32], saliency: &[f32]| {
            for l in 0..w.len() {
                let exceeds = bounds[l] > bound;
                let threshold = if exceeds == self.is_max { bounds[l] } else { bound };
                let is_neighbour = if w[l] > threshold { 1.0 } else { 0.0 };
                sums[l] += is_neighbour * saliency[l];
                counts[l] += is_neighbour;
            }
        };
        let tail = affinity.len() / LANES * LANES;
        for start in (0..tail).step_by(LANES) {
            add(&affinity[start..][..LANES], &bounds[start..][..LANES], &saliency[start..][..LANES]);
        }
        add(&affinity[tail..], &bounds[tail..], &saliency[tail..]);
        (sums.iter().sum(), counts.iter().sum())
    }
}
