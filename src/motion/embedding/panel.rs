//! Panels of four vectors that go through the sparse product together, and the operations on them that Lanczos needs.
//!
//! A panel is stored column by column, like the basis, and row by row for the operator, so that one pass over a sparse
//! matrix serves four vectors.

use pulp::{Arch, Simd, WithSimd};

/// Number of vectors in a panel; see `eigen` for the measurement.
pub(super) const WIDTH: usize = 4;
/// A `4 × 4` matrix by columns: entry `(i, j)` is `[j][i]`.
pub(super) type Square = [[f64; WIDTH]; WIDTH];

/// The identity matrix.
pub(super) const IDENTITY: Square =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// Computes `a b`.
pub(super) fn multiply_squares(a: &Square, b: &Square) -> Square {
    b.map(|column| std::array::from_fn(|i| (0..WIDTH).map(|k| a[k][i] * column[k]).sum()))
}

/// Converts columns of length `n` to storage row by row.
pub(super) fn to_rows(columns: &[f64], n: usize) -> Vec<f64> {
    let count = columns.len() / n;
    let mut rows = vec![0.0; columns.len()];
    for (c, column) in columns.chunks_exact(n).enumerate() {
        rows.iter_mut().skip(c).step_by(count).zip(column).for_each(|(r, x)| *r = *x);
    }
    rows
}

/// Converts `count` columns stored row by row to storage column by column.
pub(super) fn to_columns(rows: &[f64], count: usize) -> Vec<f64> {
    let mut columns = Vec::with_capacity(rows.len());
    for c in 0..count {
        columns.extend(rows.iter().skip(c).step_by(count));
    }
    columns
}

/// Computes the lengths of a panel's columns.
pub(super) fn lengths(w: &[f64], n: usize) -> [f64; WIDTH] {
    std::array::from_fn(|c| length(&w[c * n..(c + 1) * n]))
}

fn length(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// Makes the vectors of `w` orthonormal by modified Gram-Schmidt and returns the upper triangular `s` with
/// `w_before = w s`.
///
/// A vector not longer than `negligible` is replaced by numbers from `random`; its row of `s` is zero. As it is neither
/// orthogonal to the others nor of length one, the caller must orthonormalise again.
pub(super) fn orthonormalize(w: &mut [f64], n: usize, negligible: f64, random: &mut dyn FnMut() -> f64) -> Square {
    let mut s = Square::default();
    for c in 0..WIDTH {
        let (head, tail) = w.split_at_mut((c + 1) * n);
        let column = &mut head[c * n..];
        let length = length(column);
        if length <= negligible {
            column.iter_mut().for_each(|x| *x = random());
            continue;
        }
        s[c][c] = length;
        column.iter_mut().for_each(|x| *x /= length);
        for (d, later) in (c + 1..).zip(tail.chunks_exact_mut(n)) {
            let overlap = dot(column, later);
            s[d][c] = overlap;
            later.iter_mut().zip(&*column).for_each(|(y, x)| *y -= overlap * x);
        }
    }
    s
}

/// Computes `xᵀ y` with the widest instructions of the machine. The order of the sums, and so the result, is the same on
/// all machines.
fn dot(x: &[f64], y: &[f64]) -> f64 {
    Arch::new().dispatch(Dot(x, y))
}

struct Dot<'a>(&'a [f64], &'a [f64]);

impl WithSimd for Dot<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let mut sums = [0.0; 16];
        let ((x, x_rest), (y, y_rest)) = (self.0.as_chunks::<16>(), self.1.as_chunks::<16>());
        for (x, y) in x.iter().zip(y) {
            for c in 0..16 {
                sums[c] += x[c] * y[c];
            }
        }
        let rest: f64 = x_rest.iter().zip(y_rest).map(|(x, y)| x * y).sum();
        sums.iter().sum::<f64>() + rest
    }
}

#[cfg(test)]
mod tests {
    use super::super::dense::{add_combination, project};
    use super::*;
    use crate::rng::Rng;

    const N: usize = 53;

    fn random_panel(seed: u64) -> Vec<f64> {
        let mut rng = Rng::for_stage(seed, "test");
        (0..N * WIDTH).map(|_| rng.range(-1.0, 1.0)).collect()
    }

    #[test]
    fn products_equal_plain_sums() {
        let (basis, w) = ([random_panel(1), random_panel(2)].concat(), random_panel(3));
        let products = project(&basis, &w, N);
        let mut rest = w.clone();
        add_combination(&mut rest, &basis, &products, -1.0, N);
        for (p, q) in [(0, 0), (1, 3), (7, 2)] {
            let plain: f64 = (0..N).map(|i| basis[p * N + i] * w[q * N + i]).sum();
            assert!((plain - products[q * 8 + p]).abs() < 1e-12, "{plain} {}", products[q * 8 + p]);
            assert!((plain - dot(&basis[p * N..(p + 1) * N], &w[q * N..(q + 1) * N])).abs() < 1e-12);
        }
        for i in [0, 17, N - 1] {
            let sum: f64 = (0..8).map(|p| basis[p * N + i] * products[2 * 8 + p]).sum();
            assert!((w[2 * N + i] - sum - rest[2 * N + i]).abs() < 1e-11);
        }
    }

    #[test]
    fn scalar_and_widest_instructions_give_the_same_bits() {
        for seed in 0..20 {
            let (x, y) = (random_panel(seed), random_panel(seed + 100));
            let scalar = pulp::Scalar.vectorize(Dot(&x, &y));
            assert_eq!(dot(&x, &y).to_bits(), scalar.to_bits());
        }
    }

    #[test]
    fn rows_and_columns_are_each_others_inverse() {
        assert_eq!(to_rows(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 3), [1.0, 4.0, 2.0, 5.0, 3.0, 6.0]);
        let w = random_panel(5);
        assert_eq!(to_columns(&to_rows(&w, N), WIDTH), w);
    }

    #[test]
    fn orthonormal_factors_multiply_back_and_dependent_vectors_are_replaced() {
        let before = random_panel(4);
        let mut q = before.clone();
        let s = orthonormalize(&mut q, N, 0.0, &mut || 0.0);
        let mut back = vec![0.0; N * WIDTH];
        add_combination(&mut back, &q, s.as_flattened(), 1.0, N);
        for (found, expected) in project(&q, &q, N).iter().zip(IDENTITY.as_flattened()) {
            assert!((found - expected).abs() < 1e-14);
        }
        assert!(back.iter().zip(&before).all(|(a, b)| (a - b).abs() < 1e-14));
        let mut dependent = before.clone();
        (0..N).for_each(|i| dependent[2 * N + i] = before[i] - before[N + i]);
        let s = orthonormalize(&mut dependent, N, 1e-12, &mut || 0.5);
        assert!(s.iter().all(|column| column[2] == 0.0));
        assert!(dependent[2 * N..3 * N].iter().all(|&x| x == 0.5));
    }
}
