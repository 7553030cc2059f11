//! The largest eigenpairs of a sparse symmetric operator by block Lanczos with thick restarts.
//!
//! In: a symmetric map of `R^n` that can be applied to a block of vectors, and the number `k` of pairs wanted. Out: the
//! `k` algebraically largest eigenvalues with orthonormal eigenvectors, and their largest residual.
//!
//! A Krylov space of a block of `b` vectors contains at most `b` eigenvectors of one eigenvalue. So an eigenvalue of
//! multiplicity `r` is found `min(b, r)` times, and one that was found fewer than `b` times is complete:
//!
//! 1. Block Lanczos from a random block of `b` (at first 4) vectors, restarted with the best Ritz vectors whenever the
//!    basis is full, until the `k` largest Ritz pairs have converged. See [`Lanczos`].
//! 2. If some eigenvalue turned up `b` times or more and `b < k`, there may be further copies: double `b` and go to 1.
//!
//! Small operators (a few hundred rows) are written out and solved densely.
//!
//! Blocks of four: one pass over the matrix serves all four for little more than one, while larger blocks need more
//! products for the same accuracy (measured on synthetic trajectory graphs of 10 000 nodes, `k = 24`, tolerance 1e-4: 118
//! products with blocks of one, 168 with four, 232 with eight).
//!
//! **Source**: Golub and Underwood 1977 (blocks); Wu and Simon, "Thick-restart Lanczos method", 2000; Ruhe 1979 (panel by
//! panel). **Cost**: 100 to 300 products on trajectory graphs, `O(n m)` numbers of memory for a basis of `m = k + 44`
//! vectors, and the operations of about a hundred passes over this basis. **Limits**: eigenvalues closer than the tolerance
//! resolves count as repeated; where the `k`-th eigenvalue is very close to the next ones, the budget of products ends
//! first, and `converged` is false.

use super::dense::{DenseEigen, add_combination, project, symmetric_eigen};
use super::operator::SymmetricOperator;
use super::panel::{IDENTITY, Square, WIDTH, lengths, multiply_squares, orthonormalize, to_columns, to_rows};
use crate::rng::Rng;
use serde::Serialize;

/// Settings of [`largest_eigenpairs`].
#[derive(Debug, Clone, PartialEq)]
pub struct EigenParams {
    /// Residual `‖A v − λ v‖` at which a pair counts as converged (vectors have length one). Raised to what rounding allows,
    /// about `1e-15 ‖A‖ √n`.
    pub tolerance: f64,
    /// Largest number of products with one vector, after which the best pairs so far are returned.
    pub max_products: u32,
    /// Expected multiplicity of the most repeated eigenvalue; 0 if unknown. It affects speed only: a larger multiplicity
    /// costs a second run with a larger block.
    pub multiplicity: u32,
    /// Seed of the start block.
    pub seed: u32,
}

/// The solver's report.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[serde(rename_all = "camelCase")]
#[non_exhaustive]
pub struct EigenInfo {
    /// True if every pair returned met the tolerance.
    pub converged: bool,
    /// Largest residual `‖A v − λ v‖` among the pairs returned.
    pub residual: f64,
    /// Products of the operator with one vector (a block of `b` counts `b`).
    pub products: u32,
    /// Restarts of the basis, and runs with a larger block.
    pub restarts: u32,
}

/// Eigenvalues, largest first, and orthonormal eigenvectors.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Eigenpairs {
    /// `k` values, largest first, repeated as often as their multiplicity.
    pub values: Vec<f64>,
    /// `n × k`, row by row: component `i` of vector `c` at `i * k + c`.
    pub vectors: Vec<f64>,
    /// The solver's report.
    pub info: EigenInfo,
}

/// Most rows of an operator that is solved densely. Measured: both ways cost about the same at this size.
const MAX_DENSE_ROWS: usize = 200;
/// Smallest number of Ritz vectors kept at a restart beyond the `k` wanted ones. Measured: bases of up to twice the size
/// are as fast on real graphs; they save products and cost orthogonalisation.
const MIN_SPARE_VECTORS: usize = 8;
/// Smallest number of vectors that a cycle adds (measured likewise).
const MIN_CYCLE_VECTORS: usize = 32;
/// Eigenvalues closer than this share of the tolerance count as repeated. The error of a converged eigenvalue is far
/// smaller, about the square of its residual. Chosen by eye.
const REPEATED_GAP_RATIO: f64 = 0.1;
/// Between restarts convergence is checked once the last residual is within this factor of the tolerance: often enough to
/// save the end of the last cycle, seldom enough for small graphs, where a check costs as much as a product. Chosen by eye.
const CHECK_RATIO: f64 = 100.0;

/// Computes the `min(k, n)` algebraically largest eigenpairs of `operator`.
///
/// Deterministic, never panics. If the operator returns numbers that are not finite, the eigenvalues are 0, the vectors unit
/// vectors, and `converged` is false. Costs `n³` operations where `n` is below a few hundred or a few times `k`.
pub fn largest_eigenpairs(operator: &dyn SymmetricOperator, k: usize, params: &EigenParams) -> Eigenpairs {
    let n = operator.dimension();
    let k = k.min(n);
    if k == 0 {
        return Eigenpairs { info: EigenInfo { converged: true, ..EigenInfo::default() }, ..Eigenpairs::default() };
    }
    let pairs = if n <= MAX_DENSE_ROWS { solve_densely(operator, k, params) } else { solve(operator, k, params) };
    pairs.unwrap_or_else(|| unit_pairs(n, k))
}

/// Returns finite, orthonormal pairs that are marked as not converged.
fn unit_pairs(n: usize, k: usize) -> Eigenpairs {
    let mut vectors = vec![0.0; n * k];
    for c in 0..k {
        vectors[c * k + c] = 1.0;
    }
    let info = EigenInfo { converged: false, residual: f64::MAX, ..EigenInfo::default() };
    Eigenpairs { values: vec![0.0; k], vectors, info }
}

/// Returns `tolerance`, raised to the smallest residual that rounding allows.
fn attainable_tolerance(tolerance: f64, norm: f64, n: usize) -> f64 {
    tolerance.max(16.0 * f64::EPSILON * norm * (n as f64).sqrt())
}

/// Computes the operator's matrix, eight columns at a time, and all its eigenpairs.
fn solve_densely(operator: &dyn SymmetricOperator, k: usize, params: &EigenParams) -> Option<Eigenpairs> {
    const STRIP_COLUMNS: usize = 8;
    let n = operator.dimension();
    let mut matrix = vec![0.0; n * n];
    for first in (0..n).step_by(STRIP_COLUMNS) {
        let p = STRIP_COLUMNS.min(n - first);
        let mut unit = vec![0.0; n * p];
        (0..p).for_each(|c| unit[(first + c) * p + c] = 1.0);
        let mut image = vec![0.0; n * p];
        operator.apply(&unit, p, &mut image);
        for (row, new) in matrix.chunks_exact_mut(n).zip(image.chunks_exact(p)) {
            row[first..first + p].copy_from_slice(new);
        }
    }
    let eigen = symmetric_eigen(&matrix, n)?;
    let values = eigen.values[..k].to_vec();
    let vectors = to_rows(&eigen.vectors[..n * k], n);
    let mut image = vec![0.0; n * k];
    operator.apply(&vectors, k, &mut image);
    let mut sums = vec![0.0; k];
    for (e, (v, av)) in vectors.iter().zip(&image).enumerate() {
        sums[e % k] += (av - values[e % k] * v).powi(2);
    }
    let residual = sums.into_iter().fold(0.0, f64::max).sqrt();
    let norm = eigen.values[0].abs().max(eigen.values[n - 1].abs());
    let converged = residual <= attainable_tolerance(params.tolerance, norm, n);
    let info = EigenInfo { converged, residual, products: (n + k) as u32, restarts: 0 };
    Some(Eigenpairs { values, vectors, info })
}

/// Runs block Lanczos with doubled blocks until no eigenvalue can have more copies than were found.
fn solve(operator: &dyn SymmetricOperator, k: usize, params: &EigenParams) -> Option<Eigenpairs> {
    let mut block = (params.multiplicity as usize + 1).min(k).next_multiple_of(WIDTH);
    let mut earlier = EigenInfo::default();
    loop {
        let Some(sizes) = BasisSizes::new(operator.dimension(), k, block) else {
            return solve_densely(operator, k, params);
        };
        let mut pairs = run(operator, &sizes, params, earlier.products)?;
        pairs.info.products += earlier.products;
        pairs.info.restarts += earlier.restarts;
        let gap = REPEATED_GAP_RATIO * params.tolerance;
        let is_repeated = pairs.values.windows(block).any(|w| w[0] - w[block - 1] <= gap);
        if block >= k || !pairs.info.converged || !is_repeated {
            return Some(pairs);
        }
        earlier = EigenInfo { restarts: pairs.info.restarts + 1, ..pairs.info };
        block *= 2;
    }
}

/// Sizes of the basis in one run, all but `k` multiples of the panel's width.
struct BasisSizes {
    k: usize,
    block: usize,
    /// Ritz vectors kept at a restart.
    keep: usize,
    /// Vectors multiplied before a restart.
    capacity: usize,
}

impl BasisSizes {
    /// Returns `None` if the basis does not fit into `n` dimensions.
    fn new(n: usize, k: usize, block: usize) -> Option<Self> {
        let keep = (k + MIN_SPARE_VECTORS.max(block)).next_multiple_of(WIDTH);
        let capacity = keep + MIN_CYCLE_VECTORS.max(3 * block);
        (capacity + block <= n).then_some(Self { k, block, keep, capacity })
    }
}

/// Runs block Lanczos until convergence or the end of the budget; `earlier_products` are spent already.
fn run(
    operator: &dyn SymmetricOperator,
    sizes: &BasisSizes,
    params: &EigenParams,
    earlier_products: u32,
) -> Option<Eigenpairs> {
    let n = operator.dimension();
    let mut lanczos = Lanczos::new(operator, sizes.block, sizes.capacity, params.seed);
    let mut restarts = 0;
    let mut last_residual = f64::MAX;
    loop {
        lanczos.step()?;
        let is_full = lanczos.num_multiplied >= sizes.capacity;
        let tolerance = attainable_tolerance(params.tolerance, lanczos.norm, n);
        let is_close = last_residual <= CHECK_RATIO * tolerance && lanczos.num_multiplied > sizes.keep;
        if !is_full && !is_close {
            continue;
        }
        let ritz = lanczos.ritz()?;
        let residual = ritz.residual[..sizes.k].iter().copied().fold(0.0, f64::max);
        if residual <= tolerance || earlier_products + lanczos.products >= params.max_products {
            let converged = residual <= tolerance;
            let info = EigenInfo { converged, residual, products: lanczos.products, restarts };
            let vectors = to_rows(&lanczos.vectors(&ritz, sizes.k), n);
            return Some(Eigenpairs { values: ritz.eigen.values[..sizes.k].to_vec(), vectors, info });
        }
        last_residual = residual;
        if is_full {
            lanczos.restart(&ritz, sizes.keep);
            restarts += 1;
        }
    }
}

// Block Lanczos with full orthogonalisation and thick restarts, panel by panel.
//
// The basis is a sequence of panels of four vectors. The first `num_multiplied` vectors have been multiplied by `A`, the
// others are waiting. A step multiplies the next waiting panel, subtracts the product's projection on the basis, and
// appends the rest as a new panel. So `A V_multiplied = V T`, with the coefficients of the projections in `T`:
//
// ```text
//          multiplied  waiting           The block size is the number of waiting vectors. It is constant, as every
//   T^T = [    H     |    Eᵀ   ]         step takes one panel from the queue and appends one.
// ```
//
// Ritz pairs `(θ, y)` of `H` approximate eigenpairs `(θ, V_multiplied y)` with residual `‖E y‖`. When the basis is full, the
// best Ritz vectors become its first panels and everything else but the waiting panels is dropped (Wu and Simon 2000).

/// Share of the operator's norm below which the rest of a vector is rounding: about 50 times the machine's precision.
const ROUNDING_RATIO: f64 = 1e-14;
/// A vector of which less than this share remains after orthogonalisation is orthogonalised again. Chosen by eye.
const CANCELLATION_RATIO: f64 = 0.02;

/// The basis `V` and the projected matrix `T`; both column-major.
struct Lanczos<'a> {
    operator: &'a dyn SymmetricOperator,
    rng: Rng,
    /// Rows of the basis.
    n: usize,
    basis: Vec<f64>,
    /// Number of columns of the basis that have been multiplied.
    num_multiplied: usize,
    /// `T`, with room for `side` rows and columns; zero where not computed.
    t: Vec<f64>,
    side: usize,
    /// Length of the longest image of a unit vector so far: a lower bound of `‖A‖`.
    norm: f64,
    /// Products with one vector.
    products: u32,
}

/// Current Ritz pairs: values largest first, vectors in the coordinates of the basis.
struct Ritz {
    eigen: DenseEigen,
    /// `E Y`: components of each Ritz vector's image along the waiting vectors.
    coupling: Vec<f64>,
    residual: Vec<f64>,
}

impl<'a> Lanczos<'a> {
    /// Starts from `block` random vectors; `capacity` more can be appended, and the operator's dimension must exceed
    /// both together. All sizes are multiples of a panel's width.
    fn new(operator: &'a dyn SymmetricOperator, block: usize, capacity: usize, seed: u32) -> Self {
        let (n, side) = (operator.dimension(), capacity + block);
        let mut start = Self {
            operator,
            rng: Rng::for_stage(u64::from(seed), "eigen"),
            n,
            basis: Vec::with_capacity(n * side),
            num_multiplied: 0,
            t: vec![0.0; side * side],
            side,
            norm: 0.0,
            products: 0,
        };
        for _ in 0..block / WIDTH {
            let panel = (0..n * WIDTH).map(|_| start.rng.range(-1.0, 1.0)).collect();
            start.append(panel, 1.0);
        }
        start
    }

    /// Returns the number of columns of the basis.
    fn num_columns(&self) -> usize {
        self.basis.len() / self.n
    }

    /// Multiplies the next waiting panel. Returns `None` if the product is not finite.
    fn step(&mut self) -> Option<()> {
        let (n, j, total) = (self.n, self.num_multiplied, self.num_columns());
        let mut w = self.product(j);
        let image_lengths = lengths(&w, n);
        // The sum propagates NaN, a maximum does not.
        if !image_lengths.iter().sum::<f64>().is_finite() {
            return None;
        }
        let length = image_lengths.into_iter().fold(0.0, f64::max);
        self.norm = self.norm.max(length);
        // Subtracts the known coefficients (T is symmetric), then the projection on the waiting panels. The full pass in
        // `append` then removes rounding only and need not be repeated.
        let first = (0..j).find(|&i| (0..WIDTH).any(|c| self.t[i * self.side + j + c] != 0.0)).unwrap_or(j);
        let coefficients: Vec<f64> = (j..j + WIDTH)
            .flat_map(|c| (first..j).map(move |i| (i, c)))
            .map(|(i, c)| self.t[i * self.side + c])
            .collect();
        if first < j {
            add_combination(&mut w, &self.basis[first * n..j * n], &coefficients, -1.0, n);
        }
        let projection = project(&self.basis[j * n..], &w, n);
        add_combination(&mut w, &self.basis[j * n..], &projection, -1.0, n);
        let next = self.append(w, length);
        for c in 0..WIDTH {
            let column = &mut self.t[(j + c) * self.side..][..self.side];
            column[first..j].copy_from_slice(&coefficients[c * (j - first)..(c + 1) * (j - first)]);
            column[j..total].copy_from_slice(&projection[c * (total - j)..(c + 1) * (total - j)]);
            column[total..total + WIDTH].copy_from_slice(&next[c]);
        }
        self.num_multiplied += WIDTH;
        Some(())
    }

    /// Applies the operator to the panel that begins at column `j`.
    fn product(&mut self, j: usize) -> Vec<f64> {
        let x = to_rows(&self.basis[j * self.n..(j + WIDTH) * self.n], self.n);
        let mut image = vec![0.0; x.len()];
        self.operator.apply(&x, WIDTH, &mut image);
        self.products += WIDTH as u32;
        to_columns(&image, WIDTH)
    }

    /// Appends `w`, orthonormalised against the basis and within, and returns its factor `s`: the part of `w` orthogonal to
    /// the basis is `panel · s`. Vanishing directions are replaced by random ones, as the Krylov space is exhausted there.
    /// `length` is the length of `w` before any projection was subtracted.
    fn append(&mut self, mut w: Vec<f64>, length: f64) -> Square {
        let mut s = IDENTITY;
        let (mut min_length, mut negligible) = (CANCELLATION_RATIO * length, ROUNDING_RATIO * self.norm);
        // Two passes suffice, and one more for random replacements.
        for _ in 0..4 {
            if !self.basis.is_empty() {
                let projection = project(&self.basis, &w, self.n);
                add_combination(&mut w, &self.basis, &projection, -1.0, self.n);
            }
            let rng = &mut self.rng;
            let factor = orthonormalize(&mut w, self.n, negligible, &mut || rng.range(-1.0, 1.0));
            s = multiply_squares(&factor, &s);
            if (0..WIDTH).all(|c| factor[c][c] > min_length) {
                break;
            }
            // From now on the vectors have length 1, or more if they are new.
            (min_length, negligible) = (0.5, ROUNDING_RATIO);
        }
        self.basis.extend(w);
        s
    }

    /// Computes the Ritz pairs of the multiplied part of the basis.
    fn ritz(&self) -> Option<Ritz> {
        let (m, waiting) = (self.num_multiplied, self.num_columns() - self.num_multiplied);
        // The lower triangle is complete for every pair of panels.
        let entry = |i: usize, j: usize| self.t[i.min(j) * self.side + i.max(j)];
        let projected: Vec<f64> = (0..m * m).map(|e| entry(e / m, e % m)).collect();
        let eigen = symmetric_eigen(&projected, m)?;
        let e: Vec<f64> = (0..m).flat_map(|j| &self.t[j * self.side + m..][..waiting]).copied().collect();
        let mut coupling = vec![0.0; waiting * m];
        add_combination(&mut coupling, &e, &eigen.vectors, 1.0, waiting);
        let residual = coupling.chunks_exact(waiting).map(|x| x.iter().map(|x| x * x).sum::<f64>().sqrt()).collect();
        Some(Ritz { eigen, coupling, residual })
    }

    /// Computes the first `count` Ritz vectors, column by column.
    fn vectors(&self, ritz: &Ritz, count: usize) -> Vec<f64> {
        // Reserves room for the panels appended after a restart.
        let mut vectors = Vec::with_capacity(self.n * self.side);
        vectors.resize(self.n * count, 0.0);
        let coordinates = &ritz.eigen.vectors[..self.num_multiplied * count];
        add_combination(&mut vectors, &self.basis[..self.num_multiplied * self.n], coordinates, 1.0, self.n);
        vectors
    }

    /// Shrinks the basis to the first `keep` Ritz vectors and the waiting ones.
    fn restart(&mut self, ritz: &Ritz, keep: usize) {
        let mut basis = self.vectors(ritz, keep);
        basis.extend_from_slice(&self.basis[self.num_multiplied * self.n..]);
        let waiting = self.num_columns() - self.num_multiplied;
        self.t.fill(0.0);
        for (q, coupling) in ritz.coupling.chunks_exact(waiting).take(keep).enumerate() {
            let column = &mut self.t[q * self.side..][..self.side];
            column[q] = ritz.eigen.values[q];
            column[keep..keep + waiting].copy_from_slice(coupling);
        }
        self.basis = basis;
        self.num_multiplied = keep;
    }
}
