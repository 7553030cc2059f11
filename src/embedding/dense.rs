//! Dense kernels: the only file that names faer. Matrices are row-major slices; everything runs on one thread.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// All eigenpairs of a dense symmetric matrix.
pub(super) struct DenseEigen {
    /// Largest first.
    pub(super) values: Vec<f64>,
    /// `n × n` row-major; column `c` belongs to `values[c]`.
    pub(super) vectors: Vec<f64>,
}

/// The eigenpairs of the symmetric row-major `n × n` matrix; the mean of both triangles counts.
///
/// `None` when an entry is not finite or the iteration fails.
pub(super) fn symmetric_eigen(matrix: &[f64], n: usize) -> Option<DenseEigen> {
    if matrix.iter().any(|x| !x.is_finite()) {
        return None;
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
    // faer sorts upwards; the largest come first here.
    let mut descending = DenseEigen { values: Vec::with_capacity(n), vectors: Vec::with_capacity(n * n) };
    descending.values.extend((0..n).rev().map(|c| values[(c, 0)]));
    for i in 0..n {
        descending.vectors.extend((0..n).rev().map(|c| vectors[(i, c)]));
    }
    Some(descending)
}

/// `xᵀ y` (`p × q`) of the row-major `n × p` matrix `x` and the `n × q` matrix `y`.
pub(super) fn gram(x: &[f64], p: usize, y: &[f64], q: usize) -> Vec<f64> {
    let n = x.len().checked_div(p).unwrap_or(0);
    let mut product = vec![0.0; p * q];
    matmul(
        MatMut::from_row_major_slice_mut(&mut product, p, q),
        Accum::Replace,
        MatRef::from_row_major_slice(x, n, p).transpose(),
        MatRef::from_row_major_slice(y, n, q),
        1.0,
        Par::Seq,
    );
    product
}

/// `x c` (`n × q`) of the row-major `n × p` matrix `x` and the `p × q` matrix `c`.
pub(super) fn multiply(x: &[f64], p: usize, c: &[f64], q: usize) -> Vec<f64> {
    let n = x.len().checked_div(p).unwrap_or(0);
    let mut product = vec![0.0; n * q];
    matmul(
        MatMut::from_row_major_slice_mut(&mut product, n, q),
        Accum::Replace,
        MatRef::from_row_major_slice(x, n, p),
        MatRef::from_row_major_slice(c, p, q),
        1.0,
        Par::Seq,
    );
    product
}
