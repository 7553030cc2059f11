//! Eigenpairs of dense symmetric matrices: the only file that names faer. One thread.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::{Mat, Par};

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
    let all_finite = descending.values.iter().chain(&descending.vectors).all(|x| x.is_finite());
    all_finite.then_some(descending)
}
