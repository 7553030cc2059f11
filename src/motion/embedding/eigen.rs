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

use super::dense::{add_combination, project, symmetric_eigen};
use super::{DenseEigen, SymmetricOperator};
use crate::rng::Rng;
use pulp::{Arch, Simd, WithSimd};
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

// Panels: four vectors that go through the sparse product together.
//
// A panel is stored column by column, like the basis, and row by row for the operator, so that one pass over a sparse matrix
// serves four vectors.

/// Number of vectors in a panel; see above for the measurement.
pub(super) const WIDTH: usize = 4;
/// A `4 × 4` matrix by columns: entry `(i, j)` is `[j][i]`.
type Square = [[f64; WIDTH]; WIDTH];

/// The identity matrix.
const IDENTITY: Square = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// Computes `a b`.
fn multiply_squares(a: &Square, b: &Square) -> Square {
    b.map(|column| std::array::from_fn(|i| (0..WIDTH).map(|k| a[k][i] * column[k]).sum()))
}

/// Converts columns of length `n` to storage row by row.
pub(super) fn to_rows(columns: &[f64], n: usize) -> Vec<f64> {
    let count = columns.len() / n;
    let mut rows = vec![0.0; columns.len()];
    for (c, column) in columns.chunks_exact(n).enumerate() {
        rows.iter_mut().skip(c).step_by(count).zip(column).for_each(|(r, x)| *r = *x);
    }
    rows
}

/// Converts `count` columns stored row by row to storage column by column.
pub(super) fn to_columns(rows: &[f64], count: usize) -> Vec<f64> {
    let mut columns = Vec::with_capacity(rows.len());
    for c in 0..count {
        columns.extend(rows.iter().skip(c).step_by(count));
    }
    columns
}

/// Computes the lengths of a panel's columns.
fn lengths(w: &[f64], n: usize) -> [f64; WIDTH] {
    std::array::from_fn(|c| length(&w[c * n..(c + 1) * n]))
}

fn length(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// Makes the vectors of `w` orthonormal by modified Gram-Schmidt and returns the upper triangular `s` with
/// `w_before = w s`.
///
/// A vector not longer than `negligible` is replaced by numbers from `random`; its row of `s` is zero. As it is neither
/// orthogonal to the others nor of length one, the caller must orthonormalise again.
fn orthonormalize(w: &mut [f64], n: usize, negligible: f64, random: &mut dyn FnMut() -> f64) -> Square {
    let mut s = Square::default();
    for c in 0..WIDTH {
        let (head, tail) = w.split_at_mut((c + 1) * n);
        let column = &mut head[c * n..];
        let length = length(column);
        if length <= negligible {
            column.iter_mut().for_each(|x| *x = random());
            continue;
        }
        s[c][c] = length;
        column.iter_mut().for_each(|x| *x /= length);
        for (d, later) in (c + 1..).zip(tail.chunks_exact_mut(n)) {
            let overlap = dot(column, later);
            s[d][c] = overlap;
            later.iter_mut().zip(&*column).for_each(|(y, x)| *y -= overlap * x);
        }
    }
    s
}

/// Computes `xᵀ y` with the widest instructions of the machine. The order of the sums, and so the result, is the same on
/// all machines.
fn dot(x: &[f64], y: &[f64]) -> f64 {
    Arch::new().dispatch(Dot(x, y))
}

struct Dot<'a>(&'a [f64], &'a [f64]);

impl WithSimd for Dot<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let mut sums = [0.0; 16];
        let ((x, x_rest), (y, y_rest)) = (self.0.as_chunks::<16>(), self.1.as_chunks::<16>());
        for (x, y) in x.iter().zip(y) {
            for c in 0..16 {
                sums[c] += x[c] * y[c];
            }
        }
        let rest: f64 = x_rest.iter().zip(y_rest).map(|(x, y)| x * y).sum();
        sums.iter().sum::<f64>() + rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    const N: usize = 53;

    fn random_panel(seed: u64) -> Vec<f64> {
        let mut rng = Rng::for_stage(seed, "test");
        (0..N * WIDTH).map(|_| rng.range(-1.0, 1.0)).collect()
    }

    #[test]
    fn products_equal_plain_sums() {
        let (basis, w) = ([random_panel(1), random_panel(2)].concat(), random_panel(3));
        let products = project(&basis, &w, N);
        let mut rest = w.clone();
        add_combination(&mut rest, &basis, &products, -1.0, N);
        for (p, q) in [(0, 0), (1, 3), (7, 2)] {
            let plain: f64 = (0..N).map(|i| basis[p * N + i] * w[q * N + i]).sum();
            assert!((plain - products[q * 8 + p]).abs() < 1e-12, "{plain} {}", products[q * 8 + p]);
            assert!((plain - dot(&basis[p * N..(p + 1) * N], &w[q * N..(q + 1) * N])).abs() < 1e-12);
        }
        for i in [0, 17, N - 1] {
            let sum: f64 = (0..8).map(|p| basis[p * N + i] * products[2 * 8 + p]).sum();
            assert!((w[2 * N + i] - sum - rest[2 * N + i]).abs() < 1e-11);
        }
    }

    #[test]
    fn scalar_and_widest_instructions_give_the_same_bits() {
        for seed in 0..20 {
            let (x, y) = (random_panel(seed), random_panel(seed + 100));
            let scalar = pulp::Scalar.vectorize(Dot(&x, &y));
            assert_eq!(dot(&x, &y).to_bits(), scalar.to_bits());
        }
    }

    #[test]
    fn rows_and_columns_are_each_others_inverse() {
        assert_eq!(to_rows(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 3), [1.0, 4.0, 2.0, 5.0, 3.0, 6.0]);
        let w = random_panel(5);
        assert_eq!(to_columns(&to_rows(&w, N), WIDTH), w);
    }

    #[test]
    fn orthonormal_factors_multiply_back_and_dependent_vectors_are_replaced() {
        let before = random_panel(4);
        let mut q = before.clone();
        let s = orthonormalize(&mut q, N, 0.0, &mut || 0.0);
        let mut back = vec![0.0; N * WIDTH];
        add_combination(&mut back, &q, s.as_flattened(), 1.0, N);
        for (found, expected) in project(&q, &q, N).iter().zip(IDENTITY.as_flattened()) {
            assert!((found - expected).abs() < 1e-14);
        }
        assert!(back.iter().zip(&before).all(|(a, b)| (a - b).abs() < 1e-14));
        let mut dependent = before.clone();
        (0..N).for_each(|i| dependent[2 * N + i] = before[i] - before[N + i]);
        let s = orthonormalize(&mut dependent, N, 1e-12, &mut || 0.5);
        assert!(s.iter().all(|column| column[2] == 0.0));
        assert!(dependent[2 * N..3 * N].iter().all(|&x| x == 0.5));
    }
}
