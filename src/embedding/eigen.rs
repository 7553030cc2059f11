//! The largest eigenpairs of a sparse symmetric operator. (Stub: see the eigensolver work item.)

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
    /// Residual `‖A v − λ v‖` at which a pair counts as converged (vectors have length one).
    pub tolerance: f64,
    /// Most block products before it gives up and returns the best so far.
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
    /// Restarts of the basis.
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

/// The `min(k, n)` algebraically largest eigenpairs of `operator`.
pub fn largest_eigenpairs(_operator: &dyn SymmetricOperator, _k: usize, _params: &EigenParams) -> Eigenpairs {
    Eigenpairs::default()
}
