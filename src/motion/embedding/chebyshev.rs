//! Eigenpairs from approximations of them: a Chebyshev filter and one Rayleigh-Ritz step.
//!
//! In: a symmetric operator with its spectrum in `[-1, 1]`, and vectors near its leading eigenvectors. Out: as many
//! orthonormal vectors, nearer to them. Where the leading eigenvalues are crowded, as those of an image's pixels are,
//! this costs a small part of what a Krylov space from nothing does.
//!
//! 1. The smallest Rayleigh quotient of the given vectors is the cut: what belongs to eigenvalues below it is not
//!    wanted.
//! 2. Each vector is multiplied by the Chebyshev polynomial that stays within ±1 on `[-1, cut]` and grows fastest above
//!    it.
//! 3. In the space of the results the operator is a small matrix; its eigenvectors give the new vectors
//!    (Rayleigh-Ritz), made orthonormal by the inverse root of their Gram matrix.
//!
//! Source: Zhou, Saad, Tiago and Chelikowsky, "Self-consistent-field calculations using Chebyshev-filtered subspace
//! iteration", 2006. Cost: `degree + 2` products with each vector, and some `8 n k²` operations.

use super::dense::{add_combination, project, symmetric_eigen};
use super::eigen::{EigenInfo, Eigenpairs};
use super::operator::SymmetricOperator;
use super::panel::{WIDTH, to_columns, to_rows};

/// Directions whose part in the space of the vectors is smaller than this are rounding.
const DEPENDENT: f64 = 1e-10;

/// Eigenpairs near the given vectors, columns of length `n` one after the other, of an operator whose spectrum lies in
/// `[-1, 1]`.
///
/// Fewer come back where the start vectors are dependent, and `None` where something is not finite. `info.converged`
/// says whether the residuals are within `tolerance`.
pub(crate) fn refine_eigenpairs(
    operator: &dyn SymmetricOperator,
    mut vectors: Vec<f64>,
    degree: u32,
    tolerance: f64,
) -> Option<Eigenpairs> {
    let n = operator.dimension();
    if n == 0 || vectors.is_empty() {
        return Some(Eigenpairs {
            info: EigenInfo { converged: true, ..EigenInfo::default() },
            ..Eigenpairs::default()
        });
    }
    let k = vectors.len() / n;
    // 1. The cut.
    let cut = least_quotient(operator, &vectors, n).clamp(-0.5, 1.0 - 1e-9);
    // 2. The filter, a panel at a time.
    for columns in vectors.chunks_mut(n * WIDTH) {
        filter(operator, columns, n, cut, degree);
    }
    // 3. Rayleigh-Ritz.
    let mut pairs = rayleigh_ritz(operator, vectors, n, k)?;
    pairs.info.products = k as u32 * (degree + 2);
    pairs.info.converged = pairs.info.residual <= tolerance;
    Some(pairs)
}

/// The smallest Rayleigh quotient of columns of length `n`.
fn least_quotient(operator: &dyn SymmetricOperator, columns: &[f64], n: usize) -> f64 {
    let mut least = 1.0_f64;
    for panel in columns.chunks(n * WIDTH) {
        let images = image_of(operator, panel, n);
        for (v, w) in panel.chunks_exact(n).zip(images.chunks_exact(n)) {
            let (along, length) = (project(v, w, n)[0], project(v, v, n)[0]);
            least = if length > 0.0 { least.min(along / length) } else { least };
        }
    }
    least
}

/// The operator's images of columns of length `n`.
fn image_of(operator: &dyn SymmetricOperator, columns: &[f64], n: usize) -> Vec<f64> {
    let mut images = Vec::with_capacity(columns.len());
    for panel in columns.chunks(n * WIDTH) {
        let rows = to_rows(panel, n);
        let mut out = vec![0.0; rows.len()];
        operator.apply(&rows, panel.len() / n, &mut out);
        images.extend(to_columns(&out, panel.len() / n));
    }
    images
}

/// Multiplies columns of length `n` by the Chebyshev polynomial of `degree` on `[-1, cut]`.
fn filter(operator: &dyn SymmetricOperator, columns: &mut [f64], n: usize, cut: f64, degree: u32) {
    let count = columns.len() / n;
    let (centre, half) = (0.5 * (cut - 1.0), 0.5 * (cut + 1.0));
    let mut before = to_rows(columns, n);
    let mut now = before.clone();
    let mut image = vec![0.0; now.len()];
    for step in 0..degree {
        operator.apply(&now, count, &mut image);
        // T_1 = y, T_{j+1} = 2 y T_j - T_{j-1}, with y the operator moved and stretched so that [-1, cut] becomes [-1,
        // 1].
        let (factor, last) = if step == 0 { (1.0 / half, 0.0) } else { (2.0 / half, 1.0) };
        for ((b, x), y) in before.iter_mut().zip(&now).zip(&image) {
            *b = factor * (y - centre * x) - last * *b;
        }
        std::mem::swap(&mut before, &mut now);
    }
    columns.copy_from_slice(&to_columns(&now, count));
}

/// The best eigenpairs in the space of the `k` columns `vectors`, and how good the worst of them is.
fn rayleigh_ritz(operator: &dyn SymmetricOperator, vectors: Vec<f64>, n: usize, k: usize) -> Option<Eigenpairs> {
    let images = image_of(operator, &vectors, n);
    let (along, lengths) = (project(&vectors, &images, n), project(&images, &images, n));
    drop(images);
    let gram = symmetric_eigen(&project(&vectors, &vectors, n), k)?;
    let largest = gram.values[0];
    let rank = gram.values.iter().take_while(|&&v| v > DEPENDENT * largest).count();
    // Columns of `root`: an orthonormal basis of the space, in the coordinates of `vectors`.
    let mut root = gram.vectors[..k * rank].to_vec();
    for (column, v) in root.chunks_exact_mut(k).zip(&gram.values) {
        column.iter_mut().for_each(|x| *x /= v.sqrt());
    }
    let matrix = congruent(&along, &root, k, rank);
    let eigen = symmetric_eigen(&matrix, rank)?;
    let mut coordinates = vec![0.0; k * rank];
    add_combination(&mut coordinates, &root, &eigen.vectors, 1.0, k);
    let mut found = vec![0.0; n * rank];
    add_combination(&mut found, &vectors, &coordinates, 1.0, n);
    drop(vectors);
    // ‖A u - λ u‖² = (A u)ᵀ(A u) - λ².
    let lengths = congruent(&lengths, &coordinates, k, rank);
    let square = |c: usize| (lengths[c * rank + c] - eigen.values[c] * eigen.values[c]).max(0.0);
    let residual = (0..rank).map(square).fold(0.0, f64::max).sqrt();
    let info = EigenInfo { residual, ..EigenInfo::default() };
    Some(Eigenpairs { values: eigen.values, vectors: to_rows(&found, n), info })
}

/// `rootᵀ a root` for `a` of `k × k` and `root` of `k × rank`, column-major.
fn congruent(a: &[f64], root: &[f64], k: usize, rank: usize) -> Vec<f64> {
    let mut right = vec![0.0; k * rank];
    add_combination(&mut right, a, root, 1.0, k);
    project(root, &right, k)
}

#[cfg(test)]
mod tests {
    use super::super::eigen::{EigenParams, largest_eigenpairs};
    use super::*;
    use crate::rng::Rng;
    use crate::sparse::SymCsr;

    /// The normalised path graph of `n` nodes: eigenvalues cos(πk / (n + 1)).
    fn path(n: u32) -> SymCsr {
        SymCsr::from_upper(n as usize, &(1..n).map(|i| (i - 1, i, 0.5)).collect::<Vec<_>>())
    }

    #[test]
    fn disturbed_eigenvectors_find_back_and_stay_orthonormal() {
        let (n, k) = (300, 6);
        let matrix = path(n as u32);
        let settings = EigenParams { tolerance: 1e-8, max_products: 20_000, multiplicity: 0, seed: 0 };
        let exact = largest_eigenpairs(&matrix, k, &settings);
        let mut rng = Rng::for_stage(2, "refine");
        let disturbed: Vec<f64> = to_columns(&exact.vectors, k).iter().map(|v| v + rng.range(-0.05, 0.05)).collect();
        let mut last = f64::MAX;
        for degree in [0, 8, 60] {
            let pairs = refine_eigenpairs(&matrix, disturbed.clone(), degree, 1e-3).unwrap();
            assert!(pairs.info.residual < last, "{} after {last} by degree {degree}", pairs.info.residual);
            last = pairs.info.residual;
            let columns = to_columns(&pairs.vectors, k);
            for (e, product) in project(&columns, &columns, n).iter().enumerate() {
                assert!((product - f64::from(u8::from(e / k == e % k))).abs() < 1e-10, "VᵀV has {product} at {e}");
            }
        }
        let pairs = refine_eigenpairs(&matrix, disturbed.clone(), 400, 1e-3).unwrap();
        assert!(pairs.info.converged, "{:?}", pairs.info);
        for (c, value) in pairs.values.iter().enumerate() {
            let expected = (std::f64::consts::PI * (c + 1) as f64 / (n + 1) as f64).cos();
            assert!((value - expected).abs() < 1e-6, "{value}, expected {expected}");
        }
    }

    #[test]
    fn dependent_vectors_are_dropped_and_illegal_numbers_refused() {
        let matrix = path(20);
        let twice: Vec<f64> = (0..40).map(|e| f64::from(e % 20 * (1 + e / 20))).collect();
        assert_eq!(refine_eigenpairs(&matrix, twice, 3, 0.1).unwrap().values.len(), 1);
        assert!(refine_eigenpairs(&matrix, vec![f64::NAN; 20], 3, 0.1).is_none());
        assert_eq!(refine_eigenpairs(&matrix, vec![0.0; 20], 3, 0.1).unwrap().values.len(), 0);
    }
}
