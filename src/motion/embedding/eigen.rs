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
//!    basis is full, until the `k` largest Ritz pairs have converged. See `lanczos.rs`.
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

use super::dense::symmetric_eigen;
use super::lanczos::{Lanczos, Ritz};
use super::operator::SymmetricOperator;
use super::panel::{WIDTH, to_rows};
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
