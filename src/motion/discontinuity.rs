//! Delaunay neighbourhoods, densities and embedding discontinuities (section 2.2).
//!
//! In: trajectories and their embedding. Out: the embedding affinity `Ŵ_ij` and the discontinuity `d_ij` of every pair that
//! is joined in the Delaunay graph of some frame; the edges of each frame.
//!
//! 1. Per frame, the Delaunay graph of the points alive in it; `N_i` is the set of `i`'s neighbours in any frame.
//! 2. `Ŵ_ij = Σ_k λ_k V_ik V_jk` over the leading eigenvectors.
//! 3. Density `δ_i = max_{j ∈ N_i} Ŵ_ij`.
//! 4. `d_ij = 1 − Ŵ_ij / max(δ_i, δ_j)`, clamped to `[0, 1]` since `Ŵ` may be slightly negative.
//!
//! **Deviation**: the paper has one `K`. Here `d` is computed from few smooth eigenvectors while the rotation uses many:
//! with all of them the embedding inside an object is so uneven that `d` rises there too.
//!
//! **Cost**: O(frames · n log n + pairs · K). **Limits**: a trajectory much denser than its neighbours inflates `d` on its
//! edges; long edges across areas without trajectories count like short ones.

use crate::delaunay::delaunay_edges;
use crate::embedding::Embedding;
use crate::order;
use crate::trajectory::Trajectories;

crate::params! {
    /// Embedding discontinuities.
    pub struct DiscontinuityParams {
        /// d_ij above which an edge lies on an object boundary (section 2.2: 0.6). Used by the thresholded segmentation
        /// of Figure 1(c).
        pub threshold: f64 = 0.6, in 0.0..=1.0, expert;
        /// Smallest number of eigenvectors for d.
        pub min_dimensions: u32 = 6, in 1..=64, expert;
        /// Eigenvectors with at least this eigenvalue are used for d beyond the smallest number.
        pub min_eigenvalue: f64 = 0.96, in 0.0..=1.0, expert;
    }
}

/// The Delaunay graphs of all frames over the trajectories.
///
/// Invariants: `pairs` are unique, sorted, each `(i, j)` with `i < j`; `frame_offset` has `num_frames + 1` increasing numbers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Neighborhoods {
    /// Pairs of trajectories that are neighbours in some frame.
    pub pairs: Vec<(u32, u32)>,
    /// Start of each frame's edges in `frame_edges`; `num_frames + 1` numbers.
    pub frame_offset: Vec<u32>,
    /// Indices into `pairs`: the Delaunay edges of frame `t` are `frame_offset[t]..frame_offset[t + 1]`.
    pub frame_edges: Vec<u32>,
}

impl Neighborhoods {
    /// Returns the Delaunay edges of `frame`, as indices into `pairs`.
    #[doc(hidden)] // For benchmarks.
    pub fn frame(&self, frame: usize) -> &[u32] {
        &self.frame_edges[self.frame_offset[frame] as usize..self.frame_offset[frame + 1] as usize]
    }
}

/// The spatial neighbour pairs of all frames with their discontinuities.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Discontinuities {
    /// The neighbour pairs and the frames in which they are neighbours.
    pub neighborhoods: Neighborhoods,
    /// Number of eigenvectors used.
    pub dimensions: usize,
    /// Embedding affinity `Ŵ_ij` of each pair.
    pub affinity: Vec<f64>,
    /// Discontinuity `d_ij` of each pair, in `0.0..=1.0`; 1 where either trajectory is not embedded.
    pub d: Vec<f64>,
    /// Density `δ_i` of each trajectory; 0 without neighbours.
    pub density: Vec<f64>,
}

/// Computes the Delaunay graphs of all frames.
///
/// # Examples
/// Four trajectories in a square are neighbours along its sides and one diagonal.
///
/// ```
/// use tracecut::discontinuity::neighborhoods;
/// use tracecut::trajectory::Trajectories;
///
/// let mut tracks = Trajectories::empty(1, (32, 32));
/// for (x, y) in [(8.0, 8.0), (24.0, 9.0), (8.0, 24.0), (23.0, 23.0)] {
///     tracks.push(0, [(x, y, 0.0)]);
/// }
/// let graph = neighborhoods(&tracks);
/// assert_eq!(graph.frame(0).len(), 5);
/// assert!([(0, 1), (0, 2), (1, 3), (2, 3)].iter().all(|side| graph.pairs.contains(side)));
/// ```
#[must_use]
pub fn neighborhoods(tracks: &Trajectories) -> Neighborhoods {
    neighborhoods_from_edges(tracks, &mut |frame| delaunay_edges(&alive_points(tracks, frame)))
}

/// Returns the positions of the trajectories alive in `frame`, in the order of the trajectories.
pub(crate) fn alive_points(tracks: &Trajectories, frame: usize) -> Vec<(f32, f32)> {
    tracks.alive(frame).map(|(_, x, y)| (x, y)).collect()
}

/// Builds [`Neighborhoods`] from the Delaunay edges of each frame's [`alive_points`].
pub(crate) fn neighborhoods_from_edges(
    tracks: &Trajectories,
    frame_edges: &mut dyn FnMut(usize) -> Vec<(u32, u32)>,
) -> Neighborhoods {
    let mut edges: Vec<(u32, u32)> = Vec::new();
    let mut frame_offset = vec![0_u32];
    for (frame, ids) in alive_by_frame(tracks).iter().enumerate() {
        // Ids increase, so the order of an edge's ends is kept.
        edges.extend(frame_edges(frame).iter().map(|&(a, b)| (ids[a as usize], ids[b as usize])));
        frame_offset.push(edges.len() as u32);
    }
    // The neighbours `j > i` of each trajectory `i`. They are few: a list is faster than a set.
    let mut neighbors: Vec<Vec<u32>> = vec![Vec::new(); tracks.len()];
    for &(i, j) in &edges {
        let list = &mut neighbors[i as usize];
        if !list.contains(&j) {
            list.push(j);
        }
    }
    let mut pairs = Vec::new();
    let mut first = Vec::with_capacity(neighbors.len());
    for (i, list) in (0..).zip(&mut neighbors) {
        order::sort_by_key(list, |&j| u64::from(j));
        first.push(pairs.len() as u32);
        pairs.extend(list.iter().map(|&j| (i, j)));
    }
    let pair_index =
        |&(i, j): &(u32, u32)| Some(first[i as usize] + neighbors[i as usize].binary_search(&j).ok()? as u32);
    let frame_edges = edges.iter().filter_map(pair_index).collect();
    Neighborhoods { pairs, frame_offset, frame_edges }
}

/// Lists the trajectories alive in each frame, in increasing order.
fn alive_by_frame(tracks: &Trajectories) -> Vec<Vec<u32>> {
    let mut alive = vec![Vec::new(); tracks.num_frames];
    for i in 0..tracks.len() {
        for frame in tracks.frames(i) {
            alive[frame].push(i as u32);
        }
    }
    alive
}

/// Computes embedding affinities, densities and discontinuities of all neighbour pairs.
///
/// # Examples
/// Between the two groups `d` is 1, within them 0.
///
/// ```
/// use tracecut::discontinuity::{DiscontinuityParams, discontinuities, neighborhoods};
/// use tracecut::embedding::{EmbeddingParams, embed};
/// use tracecut::sparse::SymCsr;
/// use tracecut::trajectory::Trajectories;
///
/// // A trajectory for each digit; trajectories of equal digits move alike.
/// let digits = ["00011", "00011", "00011"].concat().into_bytes();
/// let mut tracks = Trajectories::empty(1, (50, 30));
/// (0..15).for_each(|i| tracks.push(0, [(10.0 * (i % 5) as f32, 10.0 * (i / 5) as f32 + (i % 5 % 2) as f32, 0.0)]));
/// let pairs = (0..15_u32).flat_map(|i| (i + 1..15).map(move |j| (i, j)));
/// let alike = pairs.filter(|&(i, j)| digits[i as usize] == digits[j as usize]);
/// let a = SymCsr::from_upper(15, &alike.map(|(i, j)| (i, j, 1.0)).collect::<Vec<_>>());
/// let mut params = EmbeddingParams::default();
/// params.min_component = 2;
/// params.min_dimensions = 1;
/// let embedding = embed(&a, &params, 0);
/// let result = discontinuities(neighborhoods(&tracks), &embedding, &DiscontinuityParams::default());
/// for (&(i, j), &d) in result.neighborhoods.pairs.iter().zip(&result.d) {
///     let expected = if digits[i as usize] == digits[j as usize] { 0.0 } else { 1.0 };
///     assert!((d - expected).abs() < 1e-6);
/// }
/// ```
#[must_use]
pub fn discontinuities(
    neighborhoods: Neighborhoods,
    embedding: &Embedding,
    params: &DiscontinuityParams,
) -> Discontinuities {
    let num_smooth = embedding.eigenvalues.iter().filter(|&&l| l >= params.min_eigenvalue).count();
    let dimensions = num_smooth.max(params.min_dimensions as usize).min(embedding.dimensions);
    let n = embedding.num_rows;
    let mut affinity = Vec::with_capacity(neighborhoods.pairs.len());
    let mut density = vec![0.0_f64; n];
    for &(i, j) in &neighborhoods.pairs {
        let (a, b) = (embedding.row(i as usize), embedding.row(j as usize));
        let w: f64 = (0..dimensions).map(|k| embedding.eigenvalues[k] * a[k] * b[k]).sum();
        density[i as usize] = density[i as usize].max(w);
        density[j as usize] = density[j as usize].max(w);
        affinity.push(w);
    }
    let d = neighborhoods
        .pairs
        .iter()
        .zip(&affinity)
        .map(|(&(i, j), &w)| discontinuity(w, density[i as usize].max(density[j as usize])))
        .collect();
    Discontinuities { neighborhoods, dimensions, affinity, d, density }
}

/// Computes `d = 1 − Ŵ / δ` of two neighbours from their embedding affinity and the larger of their densities, clamped to
/// `[0, 1]`; 1 without density.
pub(crate) fn discontinuity<T>(affinity: T, density: T) -> T
where
    T: Copy + PartialOrd + From<u8> + std::ops::Sub<Output = T> + std::ops::Div<Output = T>,
{
    let (zero, one) = (T::from(0), T::from(1));
    if density > zero {
        let d = one - affinity / density;
        if d > one {
            one
        } else if d < zero {
            zero
        } else {
            d
        }
    } else {
        one
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six still trajectories in two rows of three, three frames.
    fn grid() -> Trajectories {
        let mut tracks = Trajectories::empty(3, (100, 100));
        for k in 0..6 {
            tracks.push(0, (0..3).map(|_| ((k % 3) as f32 * 10.0 + (k / 3) as f32, (k / 3) as f32 * 10.0, 0.0)));
        }
        tracks
    }

    fn two_blocks() -> Embedding {
        // Columns 0 and 1 belong together, column 2 apart: V of an ideal two-block graph.
        let vectors = (0..6).flat_map(|i| if i % 3 < 2 { [0.5, 0.0] } else { [0.0, 0.7] }).collect();
        Embedding {
            num_rows: 6,
            dimensions: 2,
            eigenvalues: vec![1.0, 1.0],
            vectors,
            embedded: vec![true; 6],
            ..Embedding::default()
        }
    }

    #[test]
    fn ideal_blocks_have_no_discontinuity_inside_and_full_across() {
        let result = discontinuities(neighborhoods(&grid()), &two_blocks(), &DiscontinuityParams::default());
        for (&(i, j), &d) in result.neighborhoods.pairs.iter().zip(&result.d) {
            let same = (i % 3 < 2) == (j % 3 < 2);
            assert_eq!(d, if same { 0.0 } else { 1.0 }, "pair {i} {j}");
        }
        assert!((result.density[0] - 0.25).abs() < 1e-12 && (result.density[2] - 0.49).abs() < 1e-12);
    }

    #[test]
    fn each_frame_has_its_delaunay_edges_and_pairs_are_unique() {
        let hoods = neighborhoods(&grid());
        assert_eq!(hoods.frame_offset.len(), 4);
        assert!(hoods.pairs.is_sorted_by(|a, b| a < b));
        for frame in 0..3 {
            assert_eq!(hoods.frame(frame).len(), hoods.pairs.len());
        }
    }

    #[test]
    fn trajectories_that_never_meet_are_not_neighbours() {
        let mut tracks = Trajectories::empty(4, (50, 50));
        tracks.push(0, [(1.0, 1.0, 0.0), (1.0, 1.0, 0.0)]);
        tracks.push(2, [(2.0, 1.0, 0.0), (2.0, 1.0, 0.0)]);
        let hoods = neighborhoods(&tracks);
        assert!(hoods.pairs.is_empty());
        let flat = Embedding { num_rows: 2, ..Embedding::default() };
        assert_eq!(discontinuities(hoods, &flat, &DiscontinuityParams::default()).density, [0.0, 0.0]);
    }
}
