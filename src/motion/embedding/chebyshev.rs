//! Refinement of approximate eigenpairs by a Chebyshev filter and one Rayleigh-Ritz step.
//!
//! In: a symmetric operator with its spectrum in `[-1, 1]`, and approximations of its leading eigenvectors. Out: better,
//! orthonormal ones. Where the leading eigenvalues are crowded, as in pixel graphs, this costs a small part of a Krylov
//! space from random vectors.
//!
//! 1. The smallest Rayleigh quotient of the given vectors is the cutoff `c`: smaller eigenvalues are unwanted.
//! 2. Each vector is multiplied by the Chebyshev polynomial of the operator that stays within ±1 on `[-1, c]` and grows
//!    fastest above `c`.
//! 3. Rayleigh-Ritz: the eigenvectors of the operator projected on the span of the results, made orthonormal by the inverse
//!    square root of their Gram matrix.
//!
//! **Source**: Zhou, Saad, Tiago and Chelikowsky, "Self-consistent-field calculations using Chebyshev-filtered subspace
//! iteration", 2006. **Cost**: `degree + 2` products with each vector, and about `8 n k²` operations. **Limits**:
//! eigenvectors that the given vectors do not contain stay missing.

use super::SymmetricOperator;
use super::dense::{add_combination, project, symmetric_eigen};
use super::eigen::{EigenInfo, Eigenpairs, WIDTH, to_columns, to_rows};

/// Smallest eigenvalue of the Gram matrix, relative to the largest, that counts towards the rank. Far above rounding
/// (1e-16), chosen by eye.
const MIN_GRAM_RATIO: f64 = 1e-10;

/// Refines eigenvectors of an operator whose spectrum lies in `[-1, 1]`; `vectors` are columns of length `n`, one after
/// the other.
///
/// Returns fewer pairs if the vectors are dependent, and `None` if a number is not finite. `info.converged` is true if all
/// residuals are within `tolerance`.
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
    // 1. The cutoff, kept off the ends of the spectrum.
    let cutoff = min_rayleigh_quotient(operator, &vectors, n).clamp(-0.5, 1.0 - 1e-9);
    // 2. The filter, a panel at a time.
    for columns in vectors.chunks_mut(n * WIDTH) {
        chebyshev_filter(operator, columns, n, cutoff, degree);
    }
    // 3. Rayleigh-Ritz.
    let mut pairs = rayleigh_ritz(operator, vectors, n, k)?;
    pairs.info.products = k as u32 * (degree + 2);
    pairs.info.converged = pairs.info.residual <= tolerance;
    Some(pairs)
}

/// Computes the smallest Rayleigh quotient of columns of length `n`.
fn min_rayleigh_quotient(operator: &dyn SymmetricOperator, columns: &[f64], n: usize) -> f64 {
    let mut smallest = 1.0_f64;
    for panel in columns.chunks(n * WIDTH) {
        let images = apply_to_columns(operator, panel, n);
        for (v, w) in panel.chunks_exact(n).zip(images.chunks_exact(n)) {
            let (product, length_sq) = (project(v, w, n)[0], project(v, v, n)[0]);
            smallest = if length_sq > 0.0 { smallest.min(product / length_sq) } else { smallest };
        }
    }
    smallest
}

/// Applies the operator to columns of length `n`.
fn apply_to_columns(operator: &dyn SymmetricOperator, columns: &[f64], n: usize) -> Vec<f64> {
    let mut images = Vec::with_capacity(columns.len());
    for panel in columns.chunks(n * WIDTH) {
        let rows = to_rows(panel, n);
        let mut out = vec![0.0; rows.len()];
        operator.apply(&rows, panel.len() / n, &mut out);
        images.extend(to_columns(&out, panel.len() / n));
    }
    images
}

/// Multiplies columns of length `n` by the Chebyshev polynomial of `degree` on `[-1, cutoff]`.
fn chebyshev_filter(operator: &dyn SymmetricOperator, columns: &mut [f64], n: usize, cutoff: f64, degree: u32) {
    let count = columns.len() / n;
    let (centre, radius) = (0.5 * (cutoff - 1.0), 0.5 * (cutoff + 1.0));
    let mut previous = to_rows(columns, n);
    let mut current = previous.clone();
    let mut image = vec![0.0; current.len()];
    for step in 0..degree {
        operator.apply(&current, count, &mut image);
        // T_1 = y, T_{j+1} = 2 y T_j - T_{j-1}, with y the operator mapped so that [-1, cutoff] becomes [-1, 1].
        let (factor, last) = if step == 0 { (1.0 / radius, 0.0) } else { (2.0 / radius, 1.0) };
        for ((p, x), y) in previous.iter_mut().zip(&current).zip(&image) {
            *p = factor * (y - centre * x) - last * *p;
        }
        std::mem::swap(&mut previous, &mut current);
    }
    columns.copy_from_slice(&to_columns(&current, count));
}

/// Computes the Ritz pairs in the span of the `k` columns `vectors`, and the largest residual.
fn rayleigh_ritz(operator: &dyn SymmetricOperator, vectors: Vec<f64>, n: usize, k: usize) -> Option<Eigenpairs> {
    let images = apply_to_columns(operator, &vectors, n);
    let (products, image_products) = (project(&vectors, &images, n), project(&images, &images, n));
    drop(images);
    let gram = symmetric_eigen(&project(&vectors, &vectors, n), k)?;
    let largest = gram.values[0];
    let rank = gram.values.iter().take_while(|&&v| v > MIN_GRAM_RATIO * largest).count();
    // The columns of `root` are an orthonormal basis of the span, in the coordinates of `vectors`.
    let mut root = gram.vectors[..k * rank].to_vec();
    for (column, v) in root.chunks_exact_mut(k).zip(&gram.values) {
        column.iter_mut().for_each(|x| *x /= v.sqrt());
    }
    let matrix = congruent(&products, &root, k, rank);
    let eigen = symmetric_eigen(&matrix, rank)?;
    let mut coordinates = vec![0.0; k * rank];
    add_combination(&mut coordinates, &root, &eigen.vectors, 1.0, k);
    let mut ritz_vectors = vec![0.0; n * rank];
    add_combination(&mut ritz_vectors, &vectors, &coordinates, 1.0, n);
    drop(vectors);
    // ‖A u - λ u‖² = (A u)ᵀ(A u) - λ².
    let image_products = congruent(&image_products, &coordinates, k, rank);
    let residual_sq = |c: usize| (image_products[c * rank + c] - eigen.values[c] * eigen.values[c]).max(0.0);
    let residual = (0..rank).map(residual_sq).fold(0.0, f64::max).sqrt();
    let info = EigenInfo { residual, ..EigenInfo::default() };
    Some(Eigenpairs { values: eigen.values, vectors: to_rows(&ritz_vectors, n), info })
}

/// Computes `rootᵀ a root` for `a` of `k × k` and `root` of `k × rank`, column-major.
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

    /// Builds the normalised path graph of `n` nodes: eigenvalues cos(πk / (n + 1)).
    fn path(n: u32) -> SymCsr {
        SymCsr::from_upper(n as usize, &(1..n).map(|i| (i - 1, i, 0.5)).collect::<Vec<_>>())
    }

    #[test]
    fn perturbed_eigenvectors_converge_and_stay_orthonormal() {
        let (n, k) = (300, 6);
        let matrix = path(n as u32);
        let settings = EigenParams { tolerance: 1e-8, max_products: 20_000, multiplicity: 0, seed: 0 };
        let exact = largest_eigenpairs(&matrix, k, &settings);
        let mut rng = Rng::for_stage(2, "refine");
        let perturbed: Vec<f64> = to_columns(&exact.vectors, k).iter().map(|v| v + rng.range(-0.05, 0.05)).collect();
        let mut last = f64::MAX;
        for degree in [0, 8, 60] {
            let pairs = refine_eigenpairs(&matrix, perturbed.clone(), degree, 1e-3).unwrap();
            assert!(pairs.info.residual < last, "{} after {last} by degree {degree}", pairs.info.residual);
            last = pairs.info.residual;
            let columns = to_columns(&pairs.vectors, k);
            for (e, product) in project(&columns, &columns, n).iter().enumerate() {
                assert!((product - f64::from(u8::from(e / k == e % k))).abs() < 1e-10, "VᵀV has {product} at {e}");
            }
        }
        let pairs = refine_eigenpairs(&matrix, perturbed.clone(), 400, 1e-3).unwrap();
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
