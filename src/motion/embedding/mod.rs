//! Spectral embedding: every trajectory becomes a point whose coordinates are the leading eigenvectors of the graph.
//!
//! In: the symmetric affinity matrix `A` (`n × n`, entries ≥ 0). Out: the `K` largest eigenvalues `Λ` of the random walk
//! `P = D^-1 A` (`D` the diagonal of row sums) and its right eigenvectors `V` (`n × K`). Later stages use the embedding
//! affinities `Ŵ = V Λ Vᵀ`, the part of the affinities in the leading spectrum (section 2.1 of the paper).
//!
//! 1. Trajectories without an affinity are left out, and so are connected components of fewer than `min_component`
//!    trajectories, as each component adds an eigenvalue 1.
//! 2. `P` is similar to the symmetric `N = D^-1/2 A D^-1/2`; the eigensolver works on `N`, scaled on the fly.
//! 3. `K` is the number of eigenvalues above a threshold, within bounds.
//! 4. `V = D^-1/2 U`, so that `Vᵀ D V = I`. Then `Ŵ` does not depend on the basis chosen for a repeated eigenvalue, and a
//!    block-diagonal graph has `Ŵ = 1 / volume` within a block and 0 across. The trivial eigenvector is kept.
//!
//! **Deviations**: the paper fixes neither `K` nor the scale of `V`. **Cost**: about 100 to 300 sparse products, and memory
//! for `100 n` numbers besides the matrix. **Limits**: a large uniform region takes several eigenvectors and is broken by
//! clustering in `V`; the discontinuities are the remedy.

mod chebyshev;
mod eigen;
mod normalize;
#[cfg(any(test, target_arch = "wasm32"))]
mod portable;
#[cfg(not(target_arch = "wasm32"))]
mod with_faer;

// Dense linear algebra for the eigensolver: by faer in native builds; by a few functions of our own in wasm, where faer would be a
// fifth of the file. Tests compare the two.
#[cfg(target_arch = "wasm32")]
use portable as dense;
#[cfg(not(target_arch = "wasm32"))]
use with_faer as dense;

pub(crate) use chebyshev::refine_eigenpairs;
pub use eigen::EigenInfo;
#[doc(hidden)]
pub use eigen::{EigenParams, Eigenpairs, largest_eigenpairs};

use crate::sparse::SymCsr;
use normalize::NormalizedGraph;

crate::params! {
    /// Spectral embedding.
    pub struct EmbeddingParams {
        /// Eigenvectors are kept while their eigenvalue is at least this. Lower keeps more of them and finds weaker
        /// motion differences, but breaks uniform regions sooner. The paper does not say.
        pub min_eigenvalue: f64 = 0.7, in 0.0..=1.0, expert;
        /// Smallest number of eigenvectors, whatever their eigenvalues.
        pub min_dimensions: u32 = 8, in 1..=64, expert;
        /// Largest number of eigenvectors; overrides a larger `minDimensions`. Higher is slower.
        pub max_dimensions: u32 = 24, in 2..=64, expert;
        /// Connected groups of fewer trajectories than this are not embedded (where no group is as large, the largest
        /// are).
        pub min_component: u32 = 1, in 1..=1000000, expert;
    }
}

/// The embedding of every trajectory: the rows of `V`, the leading right eigenvectors of `P = D^-1 A`.
///
/// Invariants: all numbers are finite; `Vᵀ D V = I` up to rounding, with rows that are not embedded being zero; the entry of
/// largest magnitude of every eigenvector is positive.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Embedding {
    /// Number of trajectories `n`.
    pub num_rows: usize,
    /// Number of eigenvectors `K`.
    pub dimensions: usize,
    /// The `K` eigenvalues, largest first.
    pub eigenvalues: Vec<f64>,
    /// `V`, `n × K`, row by row; the row of trajectory `i` is `vectors[i * K..(i + 1) * K]`.
    pub vectors: Vec<f64>,
    /// True for each trajectory of a connected group that is large enough; the rows of others are zero.
    pub embedded: Vec<bool>,
    /// The eigensolver's report.
    pub info: EigenInfo,
}

impl Embedding {
    /// Returns the `K` coordinates of trajectory `i`.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.vectors[i * self.dimensions..(i + 1) * self.dimensions]
    }
}

/// Residual at which an eigenpair counts as converged. Chosen by eye (published normalized-cut code: 1e-6). Lower is
/// slower.
const RESIDUAL_TOLERANCE: f64 = 1e-4;
/// Largest number of products with one vector: about ten times the need of trajectory graphs.
const MAX_PRODUCTS: f64 = 20_000.0;
/// Number of products that every graph may take. Chosen by eye.
const MIN_PRODUCTS: f64 = 128.0;
/// Number of multiplications that every graph may take: about half a second.
const MIN_WORK: f64 = 2e9;
/// Multiplications per row and product for orthogonalisation, estimated: about four for each vector of the basis.
const BASIS_WORK_PER_ROW: f64 = 300.0;
/// Graphs of `n` rows may take `n³` multiplications divided by this beyond [`MIN_WORK`]. Chosen by eye.
const CUBIC_WORK_DIVISOR: f64 = 50.0;

/// Limits the products with one vector for a matrix of `n` rows and this number of entries.
///
/// A few trajectories take a few seconds at most, even with a dense matrix or a tiny tolerance; from about 7000 rows on
/// ordinary graphs may take all of [`MAX_PRODUCTS`].
fn max_products(n: usize, entries: usize) -> u32 {
    let n = n as f64;
    let work_per_product = entries as f64 + BASIS_WORK_PER_ROW * n;
    ((MIN_WORK + n * n * n / CUBIC_WORK_DIVISOR) / work_per_product).clamp(MIN_PRODUCTS, MAX_PRODUCTS) as u32
}

/// Embeds the graph of `affinities`.
///
/// A graph without edges has an embedding of no dimensions. So has one with entries that are not finite (a breach of
/// `SymCsr`'s law), with `info.converged == false`.
///
/// # Examples
/// Two groups of trajectories without an affinity between them: two eigenvalues of 1, and eigenvectors that are
/// constant on each group.
///
/// ```
/// use tracecut::embedding::{EmbeddingParams, embed};
/// use tracecut::sparse::SymCsr;
///
/// let group = b"000011111";
/// let pairs = (0..9_u32).flat_map(|i| (i + 1..9).map(move |j| (i, j)));
/// let alike = pairs.filter(|&(i, j)| group[i as usize] == group[j as usize]);
/// let a = SymCsr::from_upper(9, &alike.map(|(i, j)| (i, j, 1.0)).collect::<Vec<_>>());
/// let mut params = EmbeddingParams::default();
/// params.min_component = 2;
/// params.min_dimensions = 1;
/// let embedding = embed(&a, &params, 0);
/// assert_eq!(embedding.dimensions, 2);
/// assert!(embedding.eigenvalues.iter().all(|&l| (l - 1.0).abs() < 1e-6));
/// let same = |i: usize, j: usize| embedding.row(i).iter().zip(embedding.row(j)).all(|(a, b)| (a - b).abs() < 1e-6);
/// assert!(same(0, 3) && same(4, 8) && !same(3, 4));
/// ```
#[must_use]
pub fn embed(affinities: &SymCsr, params: &EmbeddingParams, seed: u32) -> Embedding {
    embed_with_tolerance(RESIDUAL_TOLERANCE, affinities, params, seed)
}

#[doc(hidden)]
/// Embeds as [`embed`] does, with this tolerance of the residuals.
#[must_use]
pub fn embed_with_tolerance(tolerance: f64, affinities: &SymCsr, params: &EmbeddingParams, seed: u32) -> Embedding {
    let n = affinities.len();
    if affinities.value.iter().any(|w| !w.is_finite()) {
        return Embedding { num_rows: n, embedded: vec![false; n], ..Embedding::default() };
    }
    // 1. The nodes to embed.
    let graph = NormalizedGraph::new(affinities, params.min_component as usize);
    let mut embedded = vec![false; n];
    graph.nodes.iter().for_each(|&i| embedded[i as usize] = true);
    // 2. Eigenpairs of N.
    let settings = EigenParams {
        tolerance,
        max_products: max_products(graph.nodes.len(), affinities.value.len()),
        multiplicity: graph.num_components,
        seed,
    };
    let pairs = largest_eigenpairs(&graph, params.max_dimensions as usize, &settings);
    // 3. The number of dimensions.
    let num_pairs = pairs.values.len();
    let num_strong = pairs.values.iter().take_while(|&&v| v >= params.min_eigenvalue).count();
    let dimensions = num_strong.max(params.min_dimensions as usize).min(num_pairs);
    // 4. From eigenvectors of N to eigenvectors of P.
    let mut vectors = vec![0.0; n * dimensions];
    for ((&i, &s), row) in graph.nodes.iter().zip(&graph.scale).zip(pairs.vectors.chunks_exact(num_pairs.max(1))) {
        for c in 0..dimensions {
            vectors[i as usize * dimensions + c] = s * row[c];
        }
    }
    fix_signs(&mut vectors, dimensions);
    let eigenvalues = pairs.values[..dimensions].to_vec();
    Embedding { num_rows: n, dimensions, eigenvalues, vectors, embedded, info: pairs.info }
}

/// Flips columns so that the entry of largest magnitude (the first of equal ones) is positive.
fn fix_signs(vectors: &mut [f64], dimensions: usize) {
    for c in 0..dimensions {
        let column = || vectors.iter().skip(c).step_by(dimensions);
        let largest = column().fold(0.0_f64, |m, &v| if v.abs() > m.abs() { v } else { m });
        if largest < 0.0 {
            vectors.iter_mut().skip(c).step_by(dimensions).for_each(|v| *v = -*v);
        }
    }
}

/// A symmetric linear map of `R^n`.
#[doc(hidden)]
pub trait SymmetricOperator {
    /// Returns the dimension `n`.
    fn dimension(&self) -> usize;

    /// Computes `out = self · x` for a block of `columns` vectors stored row by row: entry `(i, c)` at `i * columns + c`.
    fn apply(&self, x: &[f64], columns: usize, out: &mut [f64]);
}

/// All eigenpairs of a dense symmetric matrix.
struct DenseEigen {
    /// Eigenvalues, largest first.
    values: Vec<f64>,
    /// `n × n`; column `c`, the entries `c * n..(c + 1) * n`, belongs to `values[c]`.
    vectors: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn a_small_dense_graph_takes_bounded_work_and_an_ordinary_one_as_much_as_it_needs() {
        for n in [300, 1000, 2500, 5000] {
            let work = f64::from(max_products(n, n * n)) * (n * n + 300 * n) as f64;
            assert!(work < 5e9, "{n} rows: {work:e}");
        }
        // 180 neighbours within the radius, and one in 32 of the others: a few hundred products suffice.
        for n in [100, 1000, 3000, 6000, 10_000, 40_000] {
            assert!(max_products(n, n * (180 + n / 32)) > 1400, "{n} rows");
        }
        assert_eq!(max_products(50_000, 50_000 * 1742), 20_000);
        assert_eq!(max_products(0, 0), 20_000);
    }

    #[test]
    fn the_embedding_stops_at_its_bound() {
        let (n, mut rng) = (2000_u32, Rng::for_stage(4, "dense"));
        let pairs = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j)));
        let upper: Vec<_> = pairs.map(|(i, j)| (i, j, rng.range(0.0, 1.0) as f32)).collect();
        let matrix = SymCsr::from_upper(n as usize, &upper);
        let params = EmbeddingParams { max_dimensions: 64, ..EmbeddingParams::default() };
        let most = max_products(n as usize, matrix.value.len());
        let info = embed_with_tolerance(1e-10, &matrix, &params, 0).info;
        assert!(!info.converged && (most..most + 200).contains(&info.products), "{info:?}, at most {most}");
    }
}
