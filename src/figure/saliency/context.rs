//! From the saliency of points to the saliency of trajectories, alone and in the context of the embedding (section 3).

use super::params::{Neighborhood, SaliencyParams};
use crate::discontinuity::Discontinuities;
use crate::embedding::Embedding;
use crate::image::Plane;
use crate::trajectory::Trajectories;

/// Trajectories whose affinities to one are found in one go.
const BLOCK: usize = 1024;

/// Sums side by side, so that they fill vector registers.
const LANES: usize = 8;

/// How salient each trajectory is.
///
/// Law: the three have one entry for each trajectory; saliencies are in `0.0..=1.0`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Saliency {
    /// `s_i`: the greatest saliency of the trajectory's points.
    pub of_points: Vec<f32>,
    /// `s̄_i`: the mean of `s` over the trajectory's neighbourhood in the embedding.
    pub in_context: Vec<f32>,
    /// Whether `s̄_i` is above the threshold.
    pub foreground: Vec<bool>,
}

/// Notes the saliency of the points of frame `t`, whose map this is: of each the value of the pixel nearest to it.
/// `of_points` has one number for each point of `tracks`, and keeps those of other frames.
pub fn look_up(map: &Plane<f32>, tracks: &Trajectories, t: usize, of_points: &mut [f32]) {
    for (point, pixel) in pixels_at(tracks, t, (map.width(), map.height())) {
        of_points[point] = map[pixel];
    }
}

/// The points of frame `t`, of `size` pixels, and the pixel that each is nearest to.
pub(crate) fn pixels_at(
    tracks: &Trajectories,
    t: usize,
    size: (usize, usize),
) -> impl Iterator<Item = (usize, (usize, usize))> + '_ {
    let place = |v: f32, limit: usize| ((v + 0.5).max(0.0) as usize).min(limit - 1);
    tracks.alive(t).map(move |(i, x, y)| (tracks.point(i, t), (place(x, size.0), place(y, size.1))))
}

/// `s_i`: the greatest saliency of a trajectory's points (section 3).
///
/// `of_points` has one number for each point of `tracks`; points of a saliency below 0 are not known and do not count.
/// Trajectories without any known point have 0.
///
/// # Examples
/// ```
/// use tracecut::saliency::trajectory_saliency;
/// use tracecut::trajectory::Trajectories;
///
/// let mut tracks = Trajectories::empty(4, (8, 8));
/// tracks.push(0, [(1.0, 1.0, 0.0); 4]);
/// tracks.push(2, [(5.0, 5.0, 0.0); 2]);
/// let of_points = [0.125, 0.75, 0.5, -1.0, -1.0, -1.0]; // below 0: not known
/// assert_eq!(trajectory_saliency(&tracks, &of_points), [0.75, 0.0]);
/// ```
#[must_use]
pub fn trajectory_saliency(tracks: &Trajectories, of_points: &[f32]) -> Vec<f32> {
    (0..tracks.len()).map(|i| of_points[tracks.points(i)].iter().copied().fold(0.0, f32::max)).collect()
}

/// The context-aware saliency of each trajectory from its saliency alone.
///
/// The neighbourhood of `i` is all trajectories `j` of the clip, near or far, alive together or not, with
/// `Ŵ_ij > ℓ max(δ_i, δ_j)` (or `min`). The paper prints `max(Ŵ_ij / δ_i, Ŵ_ji / δ_j) < ℓ`, which would average over
/// all that is *unlike* `i`; with the sign turned it is the form `min`. Ŵ and δ are those of the discontinuities.
///
/// Trajectories that are not embedded, and those of no density, have no such neighbourhood and keep their own saliency.
/// Cost: O(n² K), in single precision and without branches, for vector registers: under 0.1 s in wasm for n = 5000, K =
/// 6.
///
/// # Examples
/// One of the right-hand trajectories of [`discontinuities`](crate::discontinuity::discontinuities)' example is not
/// salient alone; those that move like it are.
///
/// ```
/// # use tracecut::discontinuity::{DiscontinuityParams, discontinuities, neighborhoods};
/// # use tracecut::embedding::{EmbeddingParams, embed};
/// # use tracecut::sparse::SymCsr;
/// # use tracecut::trajectory::Trajectories;
/// #
/// # // A trajectory for each digit; those of equal digits move alike.
/// # let digits = ["00011", "00011", "00011"].concat().into_bytes();
/// # let mut tracks = Trajectories::empty(1, (50, 30));
/// # (0..15).for_each(|i| tracks.push(0, [(10.0 * (i % 5) as f32, 10.0 * (i / 5) as f32 + (i % 5 % 2) as f32, 0.0)]));
/// # let pairs = (0..15_u32).flat_map(|i| (i + 1..15).map(move |j| (i, j)));
/// # let alike = pairs.filter(|&(i, j)| digits[i as usize] == digits[j as usize]);
/// # let a = SymCsr::from_upper(15, &alike.map(|(i, j)| (i, j, 1.0)).collect::<Vec<_>>());
/// # let params = EmbeddingParams { min_component: 2, min_dimensions: 1, ..EmbeddingParams::default() };
/// # let embedding = embed(&a, &params, 0);
/// # let found = discontinuities(neighborhoods(&tracks), &embedding, &DiscontinuityParams::default());
/// use tracecut::saliency::{SaliencyParams, context_saliency};
///
/// let alone: Vec<f32> = (0..15).map(|i| if i % 5 >= 3 && i != 4 { 0.9 } else { 0.0 }).collect();
/// let saliency = context_saliency(alone, &embedding, &found, &SaliencyParams::default());
/// assert!(saliency.foreground[4] && (saliency.in_context[4] - 0.75).abs() < 1e-6);
/// assert!(!saliency.foreground[0]);
/// ```
#[must_use]
pub fn context_saliency(
    alone: Vec<f32>,
    embedding: &Embedding,
    discontinuities: &Discontinuities,
    params: &SaliencyParams,
) -> Saliency {
    let rows = Rows::new(&alone, embedding, discontinuities, params);
    let mut in_context = alone.clone();
    for (row, &i) in rows.ids.iter().enumerate() {
        in_context[i as usize] = rows.mean(row);
    }
    let foreground = in_context.iter().map(|&s| f64::from(s) > params.threshold).collect();
    Saliency { of_points: alone, in_context, foreground }
}

/// The embedded trajectories, by column: eigenvector after eigenvector.
struct Rows {
    ids: Vec<u32>,
    dimensions: usize,
    /// `V` and `V Λ`, `K × n`.
    plain: Vec<f32>,
    scaled: Vec<f32>,
    /// `ℓ δ`.
    bound: Vec<f32>,
    saliency: Vec<f32>,
    strict: bool,
}

impl Rows {
    fn new(alone: &[f32], embedding: &Embedding, found: &Discontinuities, params: &SaliencyParams) -> Self {
        let takes_part = |&i: &u32| embedding.embedded[i as usize] && found.density[i as usize] > 0.0;
        let ids: Vec<u32> = (0..alone.len() as u32).filter(takes_part).collect();
        let dimensions = found.dimensions;
        let column = |k: usize, factor: f64| {
            let value = move |&i: &u32| (embedding.row(i as usize)[k] * factor) as f32;
            ids.iter().map(value).collect::<Vec<f32>>()
        };
        let plain = (0..dimensions).flat_map(|k| column(k, 1.0)).collect();
        let scaled = (0..dimensions).flat_map(|k| column(k, embedding.eigenvalues[k])).collect();
        let bound = ids.iter().map(|&i| (params.neighborhood * found.density[i as usize]) as f32).collect();
        let saliency = ids.iter().map(|&i| alone[i as usize]).collect();
        Self { dimensions, plain, scaled, bound, saliency, strict: params.form == Neighborhood::Max, ids }
    }

    /// The mean over the neighbourhood of row `i`.
    fn mean(&self, i: usize) -> f32 {
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
            let (s, c) = self.neighbours(i, affinity, block);
            sum += s;
            count += c;
        }
        // A trajectory may lie further from itself than its bound, where another is much denser.
        if count > 0.0 { (sum / count).clamp(0.0, 1.0) } else { self.saliency[i] }
    }

    /// Sum of the saliency of those of a block that are neighbours of `i`, and how many they are.
    fn neighbours(&self, i: usize, affinity: &[f32], block: std::ops::Range<usize>) -> (f32, f32) {
        let own = self.bound[i];
        let (mut sums, mut counts) = ([0.0_f32; LANES], [0.0_f32; LANES]);
        let (bounds, saliency) = (&self.bound[block.clone()], &self.saliency[block]);
        let mut add = |w: &[f32], bounds: &[f32], saliency: &[f32]| {
            for l in 0..w.len() {
                let exceeds = bounds[l] > own;
                let least = if exceeds == self.strict { bounds[l] } else { own };
                let is_near = if w[l] > least { 1.0 } else { 0.0 };
                sums[l] += is_near * saliency[l];
                counts[l] += is_near;
            }
        };
        let whole = affinity.len() / LANES * LANES;
        for at in (0..whole).step_by(LANES) {
            add(&affinity[at..][..LANES], &bounds[at..][..LANES], &saliency[at..][..LANES]);
        }
        add(&affinity[whole..], &bounds[whole..], &saliency[whole..]);
        (sums.iter().sum(), counts.iter().sum())
    }
}
