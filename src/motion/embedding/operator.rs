//! The operator that the eigensolver solves, and the result of its small dense problems.

/// A symmetric linear map of `R^n`.
pub trait SymmetricOperator {
    /// Returns the dimension `n`.
    fn dimension(&self) -> usize;

    /// Computes `out = self · x` for a block of `columns` vectors stored row by row: entry `(i, c)` at `i * columns + c`.
    fn apply(&self, x: &[f64], columns: usize, out: &mut [f64]);
}

/// All eigenpairs of a dense symmetric matrix.
pub(super) struct DenseEigen {
    /// Eigenvalues, largest first.
    pub(super) values: Vec<f64>,
    /// `n × n`; column `c`, the entries `c * n..(c + 1) * n`, belongs to `values[c]`.
    pub(super) vectors: Vec<f64>,
}
