//! What the eigensolver solves.

/// A symmetric linear map of `R^n`.
pub trait SymmetricOperator {
    /// The dimension `n`.
    fn dimension(&self) -> usize;

    /// `out = self · x` for a block of `columns` vectors stored row by row: entry `(i, c)` at `i * columns + c`.
    fn apply(&self, x: &[f64], columns: usize, out: &mut [f64]);
}
