//! Dense linear algebra by faer, for native builds; the only file that names faer. One thread; matrices are column-major
//! slices.
//!
//! faer chooses instructions at run time, so the last bits differ between kinds of processors, but not between runs.

use super::DenseEigen;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// Computes the eigenpairs of a symmetric `n × n` matrix, of which the mean of both triangles counts.
///
/// Returns `None` if an entry is not finite or the iteration fails.
pub(super) fn symmetric_eigen(matrix: &[f64], n: usize) -> Option<DenseEigen> {
    if matrix.iter().any(|x| !x.is_finite()) {
        return None;
    }
    if n == 0 {
        // faer subtracts 1 from the number of rows.
        return Some(DenseEigen { values: Vec::new(), vectors: Vec::new() });
    }
    let symmetric = Mat::from_fn(n, n, |i, j| 0.5 * (matrix[i * n + j] + matrix[j * n + i]));
    let mut vectors = Mat::<f64>::zeros(n, n);
    let mut values = Mat::<f64>::zeros(n, 1);
    let scratch = self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, Par::Seq, Default::default());
    self_adjoint_evd(
        symmetric.as_ref(),
        values.as_mut().col_mut(0).as_diagonal_mut(),
        Some(vectors.as_mut()),
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(scratch)),
        Default::default(),
    )
    .ok()?;
    // faer sorts ascending.
    let mut descending = DenseEigen { values: Vec::with_capacity(n), vectors: Vec::with_capacity(n * n) };
    for c in (0..n).rev() {
        descending.values.push(values[(c, 0)]);
        descending.vectors.extend((0..n).map(|i| vectors[(i, c)]));
    }
    let all_finite = descending.values.iter().chain(&descending.vectors).all(|x| x.is_finite());
    all_finite.then_some(descending)
}

/// Computes `vᵀ w` for columns of length `n`.
pub(super) fn project(v: &[f64], w: &[f64], n: usize) -> Vec<f64> {
    let (rows, columns) = (v.len() / n, w.len() / n);
    let mut product = vec![0.0; rows * columns];
    let v = MatRef::from_column_major_slice(v, n, rows);
    let w = MatRef::from_column_major_slice(w, n, columns);
    let out = MatMut::from_column_major_slice_mut(&mut product, rows, columns);
    matmul(out, Accum::Replace, v.transpose(), w, 1.0, Par::Seq);
    product
}

/// Computes `w += factor · v · coefficients` for columns of length `n`.
pub(super) fn add_combination(w: &mut [f64], v: &[f64], coefficients: &[f64], factor: f64, n: usize) {
    let (inner, columns) = (v.len() / n, w.len() / n);
    let v = MatRef::from_column_major_slice(v, n, inner);
    let coefficients = MatRef::from_column_major_slice(coefficients, inner, columns);
    matmul(MatMut::from_column_major_slice_mut(w, n, columns), Accum::Add, v, coefficients, factor, Par::Seq);
}
