//! The largest eigenpairs of a sparse symmetric operator by Chebyshev-filtered subspace iteration.
//!
//! In: a symmetric map of `R^n` that can be applied to a block of vectors, and the number `k` of pairs wanted. Out: the
//! `k` algebraically largest eigenvalues with orthonormal eigenvectors, and an account of how good they are.
//!
//! The idea: a block `X` of `w > k` vectors, random at first, is multiplied by a polynomial of the operator that is
//! small on the part of the spectrum that is not wanted and large above it (a Chebyshev polynomial does this best);
//! then the best approximations within the span of the block are taken (Rayleigh-Ritz), which also tell where the
//! wanted part begins. Because the block is wider than `k`, an eigenvalue repeated up to `k` times is found as often as
//! it occurs, which a Krylov space grown from one vector, or from few, cannot promise: it sees one copy per vector.
//! The price is more products than Lanczos needs; since eight vectors share one pass over the matrix, they cost little.
//!
//! 1. A short Lanczos run bounds the spectrum from below and above.
//! 2. Filter: `X <- p(A) X` for all columns that have not converged.
//! 3. Rayleigh-Ritz on the whole block; residuals `‖A x − θ x‖` of every column.
//! 4. Converged leading columns are no longer filtered, but stay in the Rayleigh-Ritz step.
//! 5. Until `k` columns have converged, go to 2 with an interval that now ends at the smallest Ritz value.
//!
//! Small operators (a few hundred rows) are written out and solved densely.
//!
//! Source: Zhou, Saad, Tiago and Chelikowsky, "Self-consistent-field calculations using Chebyshev-filtered subspace
//! iteration", 2006; the soft treatment of converged columns and the choice of degrees are ours.
//! Cost: a few hundred to about a thousand products with one vector; memory of about `3 n w` numbers.
//! Limits: when `k` eigenvalues must be told from others that are closer than about `1e-6` of the spectrum's width, the
//! budget of products ends first and the result says so.

use super::dense::{gram, multiply, symmetric_eigen};
use crate::rng::Rng;
use serde::Serialize;

/// A symmetric linear map of `R^n`.
pub trait SymmetricOperator {
    /// The dimension `n`.
    fn dimension(&self) -> usize;

    /// `out = self · x` for a block of `columns` vectors stored row by row: entry `(i, c)` at `i * columns + c`.
    fn apply(&self, x: &[f64], columns: usize, out: &mut [f64]);
}

/// How [`largest_eigenpairs`] works.
#[derive(Debug, Clone, PartialEq)]
pub struct EigenParams {
    /// Residual `‖A v − λ v‖` at which a pair counts as converged (vectors have length one). What rounding allows
    /// (about `1e-15 ‖A‖ √n`) is a lower bound to it.
    pub tolerance: f64,
    /// Most products with one vector before it gives up and returns the best so far.
    pub max_products: u32,
    /// Seed of the start block.
    pub seed: u32,
}

/// What happened inside the solver.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct EigenInfo {
    /// Whether every pair returned met the tolerance.
    pub converged: bool,
    /// Largest residual `‖A v − λ v‖` among the pairs returned.
    pub residual: f64,
    /// Products of the operator with one vector (a block of `b` counts `b`).
    pub products: u32,
    /// Rounds of filter and Rayleigh-Ritz.
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
/// Columns that share one pass over the matrix.
const PANEL: usize = 8;
/// Converged columns leave the filter in groups of this many, so that panels stay full.
const GROUP: usize = 4;
/// Steps of the Lanczos run that bounds the spectrum.
const BOUND_STEPS: usize = 10;
/// Highest degree of one filter: beyond it the Rayleigh-Ritz step between two filters costs next to nothing.
const MAX_DEGREE: usize = 80;
/// Most that one filter may magnify the first eigenvector over the unwanted ones. Larger, and the columns of a random
/// block become parallel to rounding; Ritz vectors are nearly separated and bear more.
const SPREAD_RANDOM: f64 = 1e4;
const SPREAD_RITZ: f64 = 1e7;
/// How far below the last wanted Ritz value the filtered interval must end, in parts of the spectrum's width. The smallest
/// Ritz value of the block is the natural end, but where one eigenvalue fills the rest of the block and more, no filter
/// with that end can tell it from what lies below; so each round that hardly helps moves on to the next of these.
const MARGINS: [f64; 4] = [0.0, 0.003, 0.02, 0.1];
/// Directions of the block whose squared length falls below this part of the whole are replaced.
const DEPENDENT: f64 = 1e-11;

/// The `min(k, n)` algebraically largest eigenpairs of `operator`.
///
/// Deterministic and free of panics; for an operator that yields values that are not finite the result is all zeros with
/// unit vectors, and not converged. `n` below a few hundred (or below about `3 k`) is solved densely, at a cost of `n³`.
pub fn largest_eigenpairs(operator: &dyn SymmetricOperator, k: usize, params: &EigenParams) -> Eigenpairs {
    let n = operator.dimension();
    let k = k.min(n);
    if k == 0 {
        return Eigenpairs { info: EigenInfo { converged: true, ..EigenInfo::default() }, ..Eigenpairs::default() };
    }
    let width = block_width(k);
    let pairs = if n <= DENSE_LIMIT.max(3 * width) {
        solve_densely(operator, k, params)
    } else {
        Subspace::new(operator, k, width, params).solve(params)
    };
    pairs.unwrap_or_else(|| not_finite(n, k))
}

/// Columns of the block for `k` wanted pairs: the more there are to spare, the faster the last pairs converge.
fn block_width(k: usize) -> usize {
    (k + 8).next_multiple_of(PANEL)
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

fn solve_densely(operator: &dyn SymmetricOperator, k: usize, params: &EigenParams) -> Option<Eigenpairs> {
    let n = operator.dimension();
    let mut matrix = vec![0.0; n * n];
    for first in (0..n).step_by(PANEL) {
        let p = PANEL.min(n - first);
        let mut unit = vec![0.0; n * p];
        (0..p).for_each(|c| unit[(first + c) * p + c] = 1.0);
        let mut image = vec![0.0; n * p];
        operator.apply(&unit, p, &mut image);
        paste(&mut matrix, n, first, &image, p);
    }
    let eigen = symmetric_eigen(&matrix, n)?;
    let vectors = columns(&eigen.vectors, n, 0, k);
    let mut image = vec![0.0; n * k];
    operator.apply(&vectors, k, &mut image);
    let residual = residuals(&vectors, &image, &eigen.values[..k]).into_iter().fold(0.0, f64::max);
    let norm = eigen.values[0].abs().max(eigen.values[n - 1].abs());
    let info = EigenInfo {
        converged: residual <= reachable(params.tolerance, norm, n),
        residual,
        products: (n + k) as u32,
        restarts: 0,
    };
    Some(Eigenpairs { values: eigen.values[..k].to_vec(), vectors, info })
}

/// The block and all that is known of it.
struct Subspace<'a> {
    operator: &'a dyn SymmetricOperator,
    n: usize,
    k: usize,
    width: usize,
    /// `n × width`, row by row: the Ritz vectors, and `ax = A x`.
    x: Vec<f64>,
    ax: Vec<f64>,
    /// Ritz values, largest first, and the residual of each.
    theta: Vec<f64>,
    residual: Vec<f64>,
    products: u32,
    rng: Rng,
}

impl<'a> Subspace<'a> {
    fn new(operator: &'a dyn SymmetricOperator, k: usize, width: usize, params: &EigenParams) -> Self {
        let n = operator.dimension();
        let mut rng = Rng::for_stage(u64::from(params.seed), "eigen");
        let x = (0..n * width).map(|_| rng.range(-1.0, 1.0)).collect();
        let ax = vec![0.0; n * width];
        Self { operator, n, k, width, x, ax, theta: Vec::new(), residual: Vec::new(), products: 0, rng }
    }

    /// `None` if something is not finite.
    fn solve(mut self, params: &EigenParams) -> Option<Eigenpairs> {
        // 1. Bounds of the spectrum.
        let (low, high) = self.bounds()?;
        let tolerance = reachable(params.tolerance, low.abs().max(high.abs()), self.n);
        let mut frozen = 0;
        let mut restarts = 0;
        let (mut margin, mut last_worst) = (0, f64::MAX);
        let mut filter = Filter::new(low, low + 0.5 * (high - low), high, SPREAD_RANDOM);
        loop {
            // 2. and 3.
            self.filter(frozen, &filter);
            self.rayleigh_ritz()?;
            restarts += 1;
            // 4. and 5.
            let done = self.residual.iter().take_while(|&&r| r <= tolerance).count();
            if done >= self.k || self.products >= params.max_products {
                break;
            }
            frozen = done / GROUP * GROUP;
            let worst = self.residual[frozen..self.k].iter().copied().fold(0.0, f64::max);
            if worst > 0.25 * last_worst {
                margin = (margin + 1) % MARGINS.len();
            }
            last_worst = worst;
            let (first, kth, last) = (self.theta[0], self.theta[self.k - 1], self.theta[self.width - 1]);
            let cut = last.min(kth - MARGINS[margin] * (first - low)).max(low);
            filter = Filter::new(low, cut, first, SPREAD_RITZ);
            filter.limit_degree(self.theta[self.k - 1], worst / tolerance);
        }
        Some(self.finish(tolerance, restarts))
    }

    /// Lower and upper bound of the spectrum: the outermost Ritz values of a short Lanczos run, moved outwards by the last
    /// off-diagonal entry. Safe in practice, not in theory; a bound that is a little too tight only slows the iteration.
    fn bounds(&mut self) -> Option<(f64, f64)> {
        let n = self.n;
        let steps = BOUND_STEPS.min(n);
        let mut basis: Vec<Vec<f64>> = Vec::with_capacity(steps);
        let mut tridiagonal = vec![0.0; steps * steps];
        let mut next: Vec<f64> = (0..n).map(|_| self.rng.range(-1.0, 1.0)).collect();
        let mut beta = dot(&next, &next).sqrt();
        for s in 0..steps {
            next.iter_mut().for_each(|x| *x /= beta);
            basis.push(next.clone());
            self.operator.apply(&basis[s], 1, &mut next);
            self.products += 1;
            tridiagonal[s * steps + s] = dot(&basis[s], &next);
            for v in basis.iter().rev() {
                let overlap = dot(v, &next);
                subtract(&mut next, overlap, v);
            }
            beta = dot(&next, &next).sqrt();
            if !beta.is_finite() {
                return None;
            }
            if beta <= 1e-10 * tridiagonal[s * steps + s].abs() || s + 1 == steps {
                return ritz_range(&tridiagonal, steps, s + 1, beta);
            }
            tridiagonal[s * steps + s + 1] = beta;
            tridiagonal[(s + 1) * steps + s] = beta;
        }
        None
    }

    /// Filters the columns from `frozen` on, panel by panel, and refreshes their images.
    fn filter(&mut self, frozen: usize, filter: &Filter) {
        for first in (frozen..self.width).step_by(PANEL) {
            let p = PANEL.min(self.width - first);
            let panel = filter.apply(self.operator, columns(&self.x, self.width, first, p), p);
            self.products += (filter.degree * p) as u32;
            self.replace(first, &panel, p);
        }
    }

    /// Puts `p` new columns from `first` on into the block and computes their images.
    fn replace(&mut self, first: usize, panel: &[f64], p: usize) {
        let mut image = vec![0.0; panel.len()];
        self.operator.apply(panel, p, &mut image);
        self.products += p as u32;
        paste(&mut self.x, self.width, first, panel, p);
        paste(&mut self.ax, self.width, first, &image, p);
    }

    /// Turns the block into Ritz vectors, sorted by Ritz value, and measures their residuals.
    fn rayleigh_ritz(&mut self) -> Option<()> {
        let w = self.width;
        // One round does unless directions of the block have become dependent and must be replaced.
        for _ in 0..4 {
            let basis = orthonormal_combination(&gram(&self.x, w, &self.x, w), w)?;
            let rank = basis.len() / w;
            let projected = gram(&self.x, w, &self.ax, w);
            let projected = multiply(&projected, w, &basis, rank);
            let eigen = symmetric_eigen(&gram(&basis, rank, &projected, rank), rank)?;
            let combination = multiply(&basis, rank, &eigen.vectors, rank);
            let (x, ax) = (multiply(&self.x, w, &combination, rank), multiply(&self.ax, w, &combination, rank));
            if rank == w {
                self.residual = residuals(&x, &ax, &eigen.values);
                (self.x, self.ax, self.theta) = (x, ax, eigen.values);
                return Some(());
            }
            paste(&mut self.x, w, 0, &x, rank);
            paste(&mut self.ax, w, 0, &ax, rank);
            let fresh: Vec<f64> = (0..self.n * (w - rank)).map(|_| self.rng.range(-1.0, 1.0)).collect();
            self.replace(rank, &fresh, w - rank);
        }
        None
    }

    /// The first `k` columns, orthonormal to rounding.
    fn finish(self, tolerance: f64, restarts: u32) -> Eigenpairs {
        let k = self.k;
        let mut vectors = columns(&self.x, self.width, 0, k);
        for _ in 0..2 {
            // One Newton step towards the nearest orthonormal matrix, X (3 I − XᵀX) / 2, squares the distance from it.
            let mut step = gram(&vectors, k, &vectors, k);
            let off = step.iter().enumerate().map(|(e, g)| (g - f64::from(e / k == e % k)).abs()).fold(0.0, f64::max);
            if off <= f64::EPSILON * (self.n as f64).sqrt() {
                break;
            }
            step.iter_mut().enumerate().for_each(|(e, g)| *g = 1.5 * f64::from(e / k == e % k) - 0.5 * *g);
            vectors = multiply(&vectors, k, &step, k);
        }
        let residual = self.residual[..k].iter().copied().fold(0.0, f64::max);
        let info = EigenInfo { converged: residual <= tolerance, residual, products: self.products, restarts };
        Eigenpairs { values: self.theta[..k].to_vec(), vectors, info }
    }
}

/// The Chebyshev polynomial of some degree on the interval of unwanted eigenvalues.
struct Filter {
    centre: f64,
    /// Half the interval's length.
    half: f64,
    degree: usize,
}

impl Filter {
    /// Small on `low..cut`, and at `top` at most `spread` times larger than there.
    fn new(low: f64, cut: f64, top: f64, spread: f64) -> Self {
        // Where all unwanted eigenvalues are one (the zero matrix, few distinct values), any small interval will do.
        let half = (0.5 * (cut - low)).max(1e-9 * (top - low).abs()).max(f64::MIN_POSITIVE.sqrt());
        let centre = 0.5 * (low + cut);
        let growth = ((top - centre) / half).max(1.0).acosh();
        let degree = ((2.0 * spread).ln() / growth).floor().clamp(1.0, MAX_DEGREE as f64) as usize;
        Self { centre, half, degree }
    }

    /// No higher degree than magnifies an eigenvector of `value` by `gain`.
    fn limit_degree(&mut self, value: f64, gain: f64) {
        let growth = ((value - self.centre) / self.half).max(1.0).acosh();
        let needed = ((4.0 * gain.max(1.0)).ln() / growth).ceil();
        self.degree = self.degree.min(needed.clamp(1.0, MAX_DEGREE as f64) as usize);
    }

    /// `p(A) x` for a block of `columns` vectors, by the three-term recurrence.
    fn apply(&self, operator: &dyn SymmetricOperator, x: Vec<f64>, columns: usize) -> Vec<f64> {
        let mut before = x;
        let mut now = vec![0.0; before.len()];
        let mut image = vec![0.0; before.len()];
        operator.apply(&before, columns, &mut now);
        for (y, x) in now.iter_mut().zip(&before) {
            *y = (*y - self.centre * x) / self.half;
        }
        for _ in 1..self.degree {
            operator.apply(&now, columns, &mut image);
            let twice = 2.0 / self.half;
            for ((old, y), ay) in before.iter_mut().zip(&now).zip(&image) {
                *old = twice * (ay - self.centre * y) - *old;
            }
            std::mem::swap(&mut before, &mut now);
        }
        now
    }
}

/// Smallest and largest eigenvalue of the leading `size × size` part of a tridiagonal matrix, moved outwards by `margin`.
fn ritz_range(tridiagonal: &[f64], stride: usize, size: usize, margin: f64) -> Option<(f64, f64)> {
    let leading: Vec<f64> = (0..size * size).map(|e| tridiagonal[e / size * stride + e % size]).collect();
    let values = symmetric_eigen(&leading, size)?.values;
    Some((values[size - 1] - margin, values[0] + margin))
}

/// The `w × r` combination of a block's columns that is orthonormal, from the block's Gram matrix; `r` is its rank.
fn orthonormal_combination(gram: &[f64], w: usize) -> Option<Vec<f64>> {
    // Columns of length one first: after a filter their lengths differ by many orders of magnitude.
    let scale: Vec<f64> = (0..w).map(|c| gram[c * w + c].sqrt()).map(|l| if l > 0.0 { 1.0 / l } else { 0.0 }).collect();
    let scaled: Vec<f64> = (0..w * w).map(|e| gram[e] * scale[e / w] * scale[e % w]).collect();
    let eigen = symmetric_eigen(&scaled, w)?;
    let rank = eigen.values.iter().take_while(|&&v| v > DEPENDENT * w as f64).count();
    let entry = |e: usize| scale[e / rank] * eigen.vectors[e / rank * w + e % rank] / eigen.values[e % rank].sqrt();
    Some((0..w * rank).map(entry).collect())
}

/// `‖A x − θ x‖` of every column.
fn residuals(x: &[f64], ax: &[f64], theta: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; theta.len()];
    for (row, image) in x.chunks_exact(theta.len()).zip(ax.chunks_exact(theta.len())) {
        for c in 0..theta.len() {
            let r = image[c] - theta[c] * row[c];
            sums[c] += r * r;
        }
    }
    sums.into_iter().map(f64::sqrt).collect()
}

/// The columns `first..first + count` of a row-major matrix `width` wide.
fn columns(matrix: &[f64], width: usize, first: usize, count: usize) -> Vec<f64> {
    matrix.chunks_exact(width).flat_map(|row| &row[first..first + count]).copied().collect()
}

/// Writes `count` columns over the columns from `first` on of a row-major matrix `width` wide.
fn paste(matrix: &mut [f64], width: usize, first: usize, panel: &[f64], count: usize) {
    for (row, new) in matrix.chunks_exact_mut(width).zip(panel.chunks_exact(count)) {
        row[first..first + count].copy_from_slice(new);
    }
}

fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(a, b)| a * b).sum()
}

/// `x -= c y`.
fn subtract(x: &mut [f64], c: f64, y: &[f64]) {
    x.iter_mut().zip(y).for_each(|(a, b)| *a -= c * b);
}
