//! The largest eigenpairs of a sparse symmetric operator by block Lanczos with thick restarts.
//!
//! In: a symmetric map of `R^n` that can be applied to a block of vectors, and the number `k` of pairs wanted. Out: the
//! `k` algebraically largest eigenvalues with orthonormal eigenvectors, and an account of how good they are.
//!
//! A Krylov space grown from a block of `b` vectors holds at most `b` eigenvectors of one eigenvalue. So with `b`
//! vectors an eigenvalue that is repeated `r` times is found `min(b, r)` times, and one that was found fewer than `b`
//! times is complete. That gives the method its outer loop:
//!
//! 1. Block Lanczos from a random block of `b` (at first 4) vectors, restarted with the best Ritz vectors whenever the
//!    basis is full, until the `k` largest Ritz pairs have converged. See [`Lanczos`].
//! 2. If some eigenvalue turned up `b` times or more and `b < k`, there may be further copies: double `b` and go to 1.
//!
//! Small operators (a few hundred rows) are written out and solved densely.
//!
//! Why four vectors: one pass over the matrix serves all four for little more than the price of one, while larger
//! blocks need more products for the same accuracy (measured on imitated trajectory graphs of 10 000 nodes, `k = 24`,
//! tolerance 1e-4: 118 products with blocks of one, 168 with four, 232 with eight). Source: Golub and Underwood 1977
//! (blocks); Wu and Simon, "Thick-restart Lanczos method", 2000; Ruhe 1979 (panel by panel). Cost: 100 to 300 products
//! on trajectory graphs, `O(n m)` numbers of memory for a basis of `m = k + 44` vectors, and as many operations as some
//! hundred passes over that basis. Limits: eigenvalues that agree to more digits than the tolerance resolves count as
//! repeated; where `k` pairs must be told from others that are very close, the budget of products ends first and the
//! result says so.

use super::dense::{DenseEigen, add_combination, project, symmetric_eigen};
use super::operator::SymmetricOperator;
use super::panel::{IDENTITY, Square, WIDTH, lengths, multiply, orthonormalize, to_columns, to_rows};
use crate::rng::Rng;
use serde::Serialize;

/// How [`largest_eigenpairs`] works.
#[derive(Debug, Clone, PartialEq)]
pub struct EigenParams {
    /// Residual `‖A v − λ v‖` at which a pair counts as converged (vectors have length one). What rounding allows
    /// (about `1e-15 ‖A‖ √n`) is a lower bound to it.
    pub tolerance: f64,
    /// Most products with one vector before it gives up and returns the best so far.
    pub max_products: u32,
    /// How often the caller knows some eigenvalue to be repeated; 0 where nothing is known. Only a matter of speed: an
    /// eigenvalue found to be repeated more often than this costs a second run with a larger block.
    pub multiplicity: u32,
    /// Seed of the start block.
    pub seed: u32,
}

/// What happened inside the solver.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[serde(rename_all = "camelCase")]
#[non_exhaustive]
pub struct EigenInfo {
    /// Whether every pair returned met the tolerance.
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
    /// What happened.
    pub info: EigenInfo,
}

/// Operators of at most this many rows are solved densely; at this size both ways cost about the same.
const DENSE_LIMIT: usize = 200;
/// Ritz vectors kept at a restart beyond the `k` wanted ones, and vectors that a cycle adds to them. Bases of up to
/// twice the size were as fast on real graphs: what they save in products they cost in orthogonalisation.
const SPARE: usize = 8;
const CYCLE: usize = 32;
/// Eigenvalues closer than this part of the tolerance count as one that is repeated. The error of a converged value is
/// far smaller: about the square of its residual.
const SAME: f64 = 0.1;
/// Between restarts, convergence is looked at once the residual has come within this factor of the tolerance: often
/// enough to save the end of the last cycle, seldom enough for small graphs, where a look costs as much as a product.
const NEAR: f64 = 100.0;

/// The `min(k, n)` algebraically largest eigenpairs of `operator`.
///
/// Deterministic and free of panics; for an operator that yields values that are not finite the result is all zeros
/// with unit vectors, and not converged. Where `n` is below a few hundred or a few times `k`, it costs as much
/// as a dense solution, `n³`.
pub fn largest_eigenpairs(operator: &dyn SymmetricOperator, k: usize, params: &EigenParams) -> Eigenpairs {
    let n = operator.dimension();
    let k = k.min(n);
    if k == 0 {
        return Eigenpairs { info: EigenInfo { converged: true, ..EigenInfo::default() }, ..Eigenpairs::default() };
    }
    let pairs = if n <= DENSE_LIMIT { solve_densely(operator, k, params) } else { solve(operator, k, params) };
    pairs.unwrap_or_else(|| not_finite(n, k))
}

/// The answer where there is none: finite, orthonormal, and marked.
fn not_finite(n: usize, k: usize) -> Eigenpairs {
    let mut vectors = vec![0.0; n * k];
    for c in 0..k {
        vectors[c * k + c] = 1.0;
    }
    let info = EigenInfo { converged: false, residual: f64::MAX, ..EigenInfo::default() };
    Eigenpairs { values: vec![0.0; k], vectors, info }
}

/// The smallest residual that rounding lets one ask for, or `tolerance` if that is larger.
fn reachable(tolerance: f64, norm: f64, n: usize) -> f64 {
    tolerance.max(16.0 * f64::EPSILON * norm * (n as f64).sqrt())
}

/// Writes the operator out as a matrix, eight columns at a time.
fn solve_densely(operator: &dyn SymmetricOperator, k: usize, params: &EigenParams) -> Option<Eigenpairs> {
    const STRIP: usize = 8;
    let n = operator.dimension();
    let mut matrix = vec![0.0; n * n];
    for first in (0..n).step_by(STRIP) {
        let p = STRIP.min(n - first);
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
    let converged = residual <= reachable(params.tolerance, norm, n);
    let info = EigenInfo { converged, residual, products: (n + k) as u32, restarts: 0 };
    Some(Eigenpairs { values, vectors, info })
}

/// Runs with larger and larger blocks until no eigenvalue can have more copies than were found.
fn solve(operator: &dyn SymmetricOperator, k: usize, params: &EigenParams) -> Option<Eigenpairs> {
    let mut block = (params.multiplicity as usize + 1).min(k).next_multiple_of(WIDTH);
    let mut spent = EigenInfo::default();
    loop {
        let Some(plan) = Plan::new(operator.dimension(), k, block) else {
            return solve_densely(operator, k, params);
        };
        let mut pairs = run(operator, &plan, params, spent.products)?;
        pairs.info.products += spent.products;
        pairs.info.restarts += spent.restarts;
        let repeated = pairs.values.windows(block).any(|w| w[0] - w[block - 1] <= SAME * params.tolerance);
        if block >= k || !pairs.info.converged || !repeated {
            return Some(pairs);
        }
        spent = EigenInfo { restarts: pairs.info.restarts + 1, ..pairs.info };
        block *= 2;
    }
}

/// Sizes of one run, all but `k` multiples of the panel's width.
struct Plan {
    k: usize,
    block: usize,
    /// Ritz vectors kept at a restart.
    keep: usize,
    /// Vectors multiplied before a restart.
    capacity: usize,
}

impl Plan {
    /// `None` where the basis would not fit into `n` dimensions.
    fn new(n: usize, k: usize, block: usize) -> Option<Self> {
        let keep = (k + SPARE.max(block)).next_multiple_of(WIDTH);
        let capacity = keep + CYCLE.max(3 * block);
        (capacity + block <= n).then_some(Self { k, block, keep, capacity })
    }
}

/// One run of block Lanczos until convergence or the end of the budget.
fn run(operator: &dyn SymmetricOperator, plan: &Plan, params: &EigenParams, spent: u32) -> Option<Eigenpairs> {
    let n = operator.dimension();
    let mut lanczos = Lanczos::new(operator, plan.block, plan.capacity, params.seed);
    let mut restarts = 0;
    let mut last = f64::MAX;
    loop {
        lanczos.step()?;
        let full = lanczos.size() >= plan.capacity;
        let tolerance = reachable(params.tolerance, lanczos.norm, n);
        let look = last <= NEAR * tolerance && lanczos.size() > plan.keep;
        if !full && !look {
            continue;
        }
        let ritz = lanczos.ritz()?;
        let residual = ritz.residual[..plan.k].iter().copied().fold(0.0, f64::max);
        if residual <= tolerance || spent + lanczos.products >= params.max_products {
            let converged = residual <= tolerance;
            let info = EigenInfo { converged, residual, products: lanczos.products, restarts };
            return Some(finish(&lanczos, &ritz, plan.k, info));
        }
        last = residual;
        if full {
            lanczos.restart(&ritz, plan.keep);
            restarts += 1;
        }
    }
}

/// The first `k` Ritz pairs, row by row.
fn finish(lanczos: &Lanczos, ritz: &Ritz, k: usize, info: EigenInfo) -> Eigenpairs {
    let vectors = to_rows(&lanczos.vectors(ritz, k), lanczos.n);
    Eigenpairs { values: ritz.eigen.values[..k].to_vec(), vectors, info }
}

// Block Lanczos with full orthogonalisation and thick restarts, panel by panel.
//
// The basis is a row of panels of four vectors, of which the first `done` vectors have been multiplied by `A`; the
// others are waiting. A step multiplies the next waiting panel, takes out of the product all that lies along the
// basis, and appends what remains as a new panel. So `A V_done = V T`, where `T` (all panels × done panels) holds what
// was taken out:
//
// ```text
//            done     waiting            The block size is the number of waiting vectors: it stays what it was at the
//   T^T = [   H    |    Eᵀ   ]           start, as every step takes one panel from the queue and appends one.
// ```
//
// Ritz pairs `(θ, y)` of `H` approximate eigenpairs `(θ, V_done y)` with residual `‖E y‖`. When the basis is full, the
// best Ritz vectors become its first panels and everything else but the waiting panels is dropped (Wu and Simon 2000).

/// Parts of the operator's norm below which what remains of a vector is rounding.
const ROUNDING: f64 = 1e-14;
/// When less than this part of a vector remains after orthogonalisation, it is orthogonalised again.
const CANCELLED: f64 = 0.02;

/// The basis `V` and the projected matrix `T`; both column-major.
struct Lanczos<'a> {
    operator: &'a dyn SymmetricOperator,
    rng: Rng,
    /// Rows of the basis.
    n: usize,
    basis: Vec<f64>,
    /// How many columns have been multiplied.
    done: usize,
    /// `T`, with room for `side` rows and columns; zero where nothing is known.
    t: Vec<f64>,
    side: usize,
    /// Longest image of a unit vector so far: an estimate of `‖A‖` from below.
    norm: f64,
    /// Products with one vector.
    products: u32,
}

/// Ritz pairs of the moment: values largest first, vectors in the coordinates of the basis.
struct Ritz {
    eigen: DenseEigen,
    /// `E Y`: what the waiting vectors get of the image of each Ritz vector.
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
            done: 0,
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

    /// Columns of the basis that have been multiplied.
    fn size(&self) -> usize {
        self.done
    }

    /// All columns of the basis.
    fn total(&self) -> usize {
        self.basis.len() / self.n
    }

    /// Multiplies the next waiting panel. `None` if the product is not finite.
    fn step(&mut self) -> Option<()> {
        let (n, j, total) = (self.n, self.done, self.total());
        let mut w = self.product(j);
        let before = lengths(&w, n);
        // A maximum passes over NaN; a sum does not.
        if !before.iter().sum::<f64>().is_finite() {
            return None;
        }
        let length = before.into_iter().fold(0.0, f64::max);
        self.norm = self.norm.max(length);
        // What is known already (T is symmetric), then the part along the waiting panels; both before the full pass,
        // which so has only rounding to remove and needs no second one.
        let first = (0..j).find(|&i| (0..WIDTH).any(|c| self.t[i * self.side + j + c] != 0.0)).unwrap_or(j);
        let known: Vec<f64> = (j..j + WIDTH)
            .flat_map(|c| (first..j).map(move |i| (i, c)))
            .map(|(i, c)| self.t[i * self.side + c])
            .collect();
        if first < j {
            add_combination(&mut w, &self.basis[first * n..j * n], &known, -1.0, n);
        }
        let along = project(&self.basis[j * n..], &w, n);
        add_combination(&mut w, &self.basis[j * n..], &along, -1.0, n);
        let next = self.append(w, length);
        for c in 0..WIDTH {
            let column = &mut self.t[(j + c) * self.side..][..self.side];
            column[first..j].copy_from_slice(&known[c * (j - first)..(c + 1) * (j - first)]);
            column[j..total].copy_from_slice(&along[c * (total - j)..(c + 1) * (total - j)]);
            column[total..total + WIDTH].copy_from_slice(&next[c]);
        }
        self.done += WIDTH;
        Some(())
    }

    /// The image of the panel that begins at column `j`.
    fn product(&mut self, j: usize) -> Vec<f64> {
        let x = to_rows(&self.basis[j * self.n..(j + WIDTH) * self.n], self.n);
        let mut image = vec![0.0; x.len()];
        self.operator.apply(&x, WIDTH, &mut image);
        self.products += WIDTH as u32;
        to_columns(&image, WIDTH)
    }

    /// Appends `w`, orthonormalised against the basis and within, and returns its factor `s`: what was orthogonal to
    /// the basis in `w` is `panel · s`. Directions that vanish are replaced by random ones: the Krylov space is
    /// exhausted there, and only a new direction can lead on. `length` is the length of `w` before anything was taken
    /// out of it.
    fn append(&mut self, mut w: Vec<f64>, length: f64) -> Square {
        let mut s = IDENTITY;
        let (mut least, mut negligible) = (CANCELLED * length, ROUNDING * self.norm);
        // Twice is enough, and once more for random replacements.
        for _ in 0..4 {
            if !self.basis.is_empty() {
                let along = project(&self.basis, &w, self.n);
                add_combination(&mut w, &self.basis, &along, -1.0, self.n);
            }
            let rng = &mut self.rng;
            let factor = orthonormalize(&mut w, self.n, negligible, &mut || rng.range(-1.0, 1.0));
            s = multiply(&factor, &s);
            if (0..WIDTH).all(|c| factor[c][c] > least) {
                break;
            }
            // From here on the vectors have length one, or more where they are new.
            (least, negligible) = (0.5, ROUNDING);
        }
        self.basis.extend(w);
        s
    }

    /// The Ritz pairs of the multiplied part of the basis.
    fn ritz(&self) -> Option<Ritz> {
        let (m, waiting) = (self.done, self.total() - self.done);
        // The lower triangle is the one computed at full length for every pair of panels.
        let entry = |i: usize, j: usize| self.t[i.min(j) * self.side + i.max(j)];
        let projected: Vec<f64> = (0..m * m).map(|e| entry(e / m, e % m)).collect();
        let eigen = symmetric_eigen(&projected, m)?;
        let e: Vec<f64> = (0..m).flat_map(|j| &self.t[j * self.side + m..][..waiting]).copied().collect();
        let mut coupling = vec![0.0; waiting * m];
        add_combination(&mut coupling, &e, &eigen.vectors, 1.0, waiting);
        let residual = coupling.chunks_exact(waiting).map(|x| x.iter().map(|x| x * x).sum::<f64>().sqrt()).collect();
        Some(Ritz { eigen, coupling, residual })
    }

    /// The first `count` Ritz vectors, column by column.
    fn vectors(&self, ritz: &Ritz, count: usize) -> Vec<f64> {
        // Room for what a restart appends.
        let mut vectors = Vec::with_capacity(self.n * self.side);
        vectors.resize(self.n * count, 0.0);
        let coordinates = &ritz.eigen.vectors[..self.done * count];
        add_combination(&mut vectors, &self.basis[..self.done * self.n], coordinates, 1.0, self.n);
        vectors
    }

    /// Shrinks the basis to the first `keep` Ritz vectors and the waiting ones.
    fn restart(&mut self, ritz: &Ritz, keep: usize) {
        let mut basis = self.vectors(ritz, keep);
        basis.extend_from_slice(&self.basis[self.done * self.n..]);
        let waiting = self.total() - self.done;
        self.t.fill(0.0);
        for (q, coupling) in ritz.coupling.chunks_exact(waiting).take(keep).enumerate() {
            let column = &mut self.t[q * self.side..][..self.side];
            column[q] = ritz.eigen.values[q];
            column[keep..keep + waiting].copy_from_slice(coupling);
        }
        self.basis = basis;
        self.done = keep;
    }
}
