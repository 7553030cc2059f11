//! Dense linear algebra for wasm, in a few KiB. Matrices are column-major slices.
//!
//! Steps of the eigensolver (Golub and Van Loan, Matrix Computations, 4th ed., 8.3):
//!
//! 1. Householder reflections `H_k` make the matrix tridiagonal, `A = Q T Qᵀ` with `Q = H_0 H_1 …`.
//! 2. Implicit QR sweeps with Wilkinson's shift make `T` diagonal; each rotation is applied to two rows of `Vᵀ`,
//!    starting from `Qᵀ`, so that all inner loops run along rows.
//! 3. Pairs are sorted, the largest eigenvalue first.
//!
//! **Cost**: about `9 n³` operations and `2 n²` numbers. **Limits**: meant for a few hundred rows.

use super::DenseEigen;
use crate::order::{f64_key, sort_by_key};

/// Largest number of sweeps per eigenvalue; two are usual. Chosen by eye (LAPACK: 30).
const MAX_SWEEPS: usize = 40;

/// Computes the eigenpairs of a symmetric `n × n` matrix, of which the mean of both triangles counts.
///
/// Returns `None` if an entry is not finite or the iteration fails.
pub(super) fn symmetric_eigen(matrix: &[f64], n: usize) -> Option<DenseEigen> {
    if matrix.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let mut a: Vec<f64> = (0..n * n).map(|e| 0.5 * (matrix[e] + matrix[e % n * n + e / n])).collect();
    let (mut d, mut e, mut rows) = tridiagonalize(&mut a, n);
    diagonalize(&mut d, &mut e, &mut rows)?;
    let mut order: Vec<usize> = (0..n).collect();
    sort_by_key(&mut order, |&i| !f64_key(d[i]));
    let vectors = order.iter().flat_map(|&c| &rows[c * n..(c + 1) * n]).copied().collect();
    Some(DenseEigen { values: order.iter().map(|&c| d[c]).collect(), vectors })
}

/// Computes `vᵀ w` for columns of length `n`.
pub(super) fn project(v: &[f64], w: &[f64], n: usize) -> Vec<f64> {
    w.chunks_exact(n).flat_map(|y| v.chunks_exact(n).map(|x| dot(x, y))).collect()
}

/// Computes `w += factor · v · coefficients` for columns of length `n`.
pub(super) fn add_combination(w: &mut [f64], v: &[f64], coefficients: &[f64], factor: f64, n: usize) {
    let inner = v.len() / n;
    for (sum, coefficients) in w.chunks_exact_mut(n).zip(coefficients.chunks_exact(inner.max(1))) {
        // Four columns at a time, so that the sum is loaded and stored once for all of them.
        let (fours, rest) = v.split_at(inner / 4 * 4 * n);
        for (columns, c) in fours.chunks_exact(4 * n).zip(coefficients.chunks_exact(4)) {
            let (a, b) = columns.split_at(2 * n);
            let ((x0, x1), (x2, x3)) = (a.split_at(n), b.split_at(n));
            let c = [factor * c[0], factor * c[1], factor * c[2], factor * c[3]];
            for ((((s, x0), x1), x2), x3) in sum.iter_mut().zip(x0).zip(x1).zip(x2).zip(x3) {
                *s += (c[0] * x0 + c[1] * x1) + (c[2] * x2 + c[3] * x3);
            }
        }
        for (column, c) in rest.chunks_exact(n).zip(&coefficients[inner / 4 * 4..]) {
            add_scaled(sum, factor * c, column);
        }
    }
}

/// Step 1: returns the diagonal and off-diagonal of `T`, and `Qᵀ`. Destroys `a`.
fn tridiagonalize(a: &mut [f64], n: usize) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let mut e = vec![0.0; n.saturating_sub(1)];
    let mut reflections = Vec::with_capacity(n);
    for k in 0..n.saturating_sub(1) {
        let (v, beta, alpha) = reflection(&a[k * n + k + 1..(k + 1) * n]);
        e[k] = alpha;
        if beta > 0.0 {
            reflect_both_sides(a, n, k + 1, &v, beta);
        }
        reflections.push((v, beta));
    }
    let d = (0..n).map(|i| a[i * n + i]).collect();
    let mut q_transposed = vec![0.0; n * n];
    (0..n).for_each(|i| q_transposed[i * n + i] = 1.0);
    for (k, (v, beta)) in reflections.iter().enumerate().rev() {
        for row in q_transposed.chunks_exact_mut(n).skip(k + 1) {
            let part = &mut row[k + 1..];
            let projection = beta * dot(part, v);
            add_scaled(part, -projection, v);
        }
    }
    (d, e, q_transposed)
}

/// Returns `v`, `beta` and `alpha` with `(I - beta v vᵀ) x = alpha e_1`; `beta` is 0 if `x` has this form already.
fn reflection(x: &[f64]) -> (Vec<f64>, f64, f64) {
    let scale = x.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    if x[1..].iter().all(|&v| v == 0.0) {
        return (x.to_vec(), 0.0, x[0]);
    }
    let mut v: Vec<f64> = x.iter().map(|value| value / scale).collect();
    let length = dot(&v, &v).sqrt().copysign(-v[0]);
    v[0] -= length;
    let beta = 2.0 / dot(&v, &v);
    (v, beta, length * scale)
}

/// Computes `B ← (I - beta v vᵀ) B (I - beta v vᵀ)` for the block `B` of rows and columns from `first` on.
fn reflect_both_sides(a: &mut [f64], n: usize, first: usize, v: &[f64], beta: f64) {
    let mut w: Vec<f64> = a.chunks_exact(n).skip(first).map(|row| beta * dot(&row[first..], v)).collect();
    let half = 0.5 * beta * dot(&w, v);
    add_scaled(&mut w, -half, v);
    for (row, (&v_i, &w_i)) in a.chunks_exact_mut(n).skip(first).zip(v.iter().zip(&w)) {
        for (entry, (&v_j, &w_j)) in row[first..].iter_mut().zip(v.iter().zip(&w)) {
            *entry -= v_i * w_j + w_i * v_j;
        }
    }
}

/// Step 2: leaves the eigenvalues in `d` and the eigenvectors in the rows of `rows`. Returns `None` if it does not converge.
fn diagonalize(d: &mut [f64], e: &mut [f64], rows: &mut [f64]) -> Option<()> {
    let n = d.len();
    let norm = d.iter().chain(e.iter()).fold(0.0_f64, |m, v| m.max(v.abs()));
    let negligible = |e: f64, d0: f64, d1: f64| e.abs() <= f64::EPSILON * (d0.abs() + d1.abs() + f64::EPSILON * norm);
    let mut last = n.saturating_sub(1);
    for _ in 0..MAX_SWEEPS * n {
        while last > 0 && negligible(e[last - 1], d[last - 1], d[last]) {
            last -= 1;
        }
        if last == 0 {
            return Some(());
        }
        let mut first = last - 1;
        while first > 0 && !negligible(e[first - 1], d[first - 1], d[first]) {
            first -= 1;
        }
        sweep(d, e, rows, first, last);
    }
    (last == 0).then_some(())
}

/// Makes one QR sweep over rows and columns `first..=last`.
fn sweep(d: &mut [f64], e: &mut [f64], rows: &mut [f64], first: usize, last: usize) {
    let n = d.len();
    let (half, off) = (0.5 * (d[last - 1] - d[last]), e[last - 1]);
    let shift = d[last] - off * (off / (half + libm::hypot(half, off).copysign(half)));
    let (mut x, mut z) = (d[first] - shift, e[first]);
    for k in first..last {
        let r = libm::hypot(x, z);
        let (c, s) = if r > 0.0 { (x / r, z / r) } else { (1.0, 0.0) };
        if k > first {
            e[k - 1] = r;
        }
        let (a, b, g) = (d[k], e[k], d[k + 1]);
        d[k] = c * (c * a + s * b) + s * (c * b + s * g);
        d[k + 1] = s * (s * a - c * b) - c * (s * b - c * g);
        e[k] = c * (c * b - s * a) - s * (s * b - c * g);
        if k + 1 < last {
            x = e[k];
            z = s * e[k + 1];
            e[k + 1] *= c;
        }
        let (upper, lower) = rows[k * n..(k + 2) * n].split_at_mut(n);
        for (p, q) in upper.iter_mut().zip(lower) {
            (*p, *q) = (c * *p + s * *q, c * *q - s * *p);
        }
    }
}

fn dot(x: &[f64], y: &[f64]) -> f64 {
    // Two sums, as additions to one sum wait for each other.
    let (mut even, mut odd) = (0.0, 0.0);
    let pairs = x.chunks_exact(2).zip(y.chunks_exact(2));
    for (a, b) in pairs {
        even += a[0] * b[0];
        odd += a[1] * b[1];
    }
    let rest = if x.len() % 2 == 1 { x[x.len() - 1] * y[x.len() - 1] } else { 0.0 };
    even + odd + rest
}

fn add_scaled(out: &mut [f64], factor: f64, x: &[f64]) {
    for (o, v) in out.iter_mut().zip(x) {
        *o += factor * v;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::embedding::with_faer;
    use crate::rng::Rng;

    /// Builds a symmetric matrix with these eigenvalues and random eigenvectors.
    fn with_spectrum(values: &[f64], rng: &mut Rng) -> Vec<f64> {
        let n = values.len();
        let mut a: Vec<f64> = (0..n * n).map(|e| if e / n == e % n { values[e / n] } else { 0.0 }).collect();
        for _ in 0..3 {
            let v: Vec<f64> = (0..n).map(|_| rng.range(-0.5, 0.5)).collect();
            reflect_both_sides(&mut a, n, 0, &v, 2.0 / dot(&v, &v));
        }
        a
    }

    fn check(a: &[f64], n: usize, tolerance: f64) {
        let own = symmetric_eigen(a, n).expect("converges");
        let faer = with_faer::symmetric_eigen(a, n).expect("converges");
        let scale = a.iter().fold(1e-300_f64, |m, v| m.max(v.abs())) * n as f64;
        for (value, other) in own.values.iter().zip(&faer.values) {
            assert!((value - other).abs() <= tolerance * scale, "{value} against {other}");
        }
        for (vector, lambda) in own.vectors.chunks_exact(n).zip(&own.values) {
            for (row, component) in a.chunks_exact(n).zip(vector) {
                let av: f64 = row.iter().zip(vector).map(|(x, y)| x * y).sum();
                let expected = lambda * component;
                assert!((av - expected).abs() <= tolerance * scale, "A v = {av}, lambda v = {expected}");
            }
        }
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let product = dot(&own.vectors[i * n..(i + 1) * n], &own.vectors[j * n..(j + 1) * n]);
            let expected = f64::from(u8::from(i == j));
            assert!((product - expected).abs() <= tolerance * n as f64, "VᵀV has {product} at {i}, {j}");
        }
    }

    #[test]
    fn eigenpairs_agree_with_faer_also_where_eigenvalues_repeat() {
        let mut rng = Rng::for_stage(1, "kernels");
        for n in [1_usize, 2, 3, 5, 17, 64, 65, 130] {
            let spread: Vec<f64> = (0..n).map(|i| 1.0 - i as f64 / n as f64).collect();
            let repeated: Vec<f64> = (0..n).map(|i| (i / 4) as f64).collect();
            let graded: Vec<f64> = (0..n as i32).map(|i| 10.0_f64.powi(-i)).collect();
            for spectrum in [spread, repeated, graded, vec![0.0; n], vec![1.0; n]] {
                check(&with_spectrum(&spectrum, &mut rng), n, 1e-14);
            }
        }
    }

    #[test]
    fn the_path_graph_has_its_known_spectrum() {
        let n = 50_usize;
        let path: Vec<f64> = (0..n * n).map(|e| if (e / n).abs_diff(e % n) == 1 { 1.0 } else { 0.0 }).collect();
        let values = symmetric_eigen(&path, n).unwrap().values;
        for (k, value) in values.iter().enumerate() {
            let expected = 2.0 * (std::f64::consts::PI * (k + 1) as f64 / (n + 1) as f64).cos();
            assert!((value - expected).abs() < 1e-13, "{value}, expected {expected}");
        }
    }

    #[test]
    fn products_with_a_basis_agree_with_faer() {
        let mut rng = Rng::for_stage(3, "kernels");
        for (n, inner, columns) in [(1, 1, 1), (7, 4, 4), (50, 9, 4), (33, 3, 2)] {
            let mut random = |size: usize| -> Vec<f64> { (0..size).map(|_| rng.range(-1.0, 1.0)).collect() };
            let (v, w, coefficients) = (random(n * inner), random(n * columns), random(inner * columns));
            let near = |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-12);
            assert!(near(&project(&v, &w, n), &with_faer::project(&v, &w, n)));
            let (mut own, mut other) = (w.clone(), w);
            add_combination(&mut own, &v, &coefficients, -0.5, n);
            with_faer::add_combination(&mut other, &v, &coefficients, -0.5, n);
            assert!(near(&own, &other));
        }
    }

    #[test]
    fn tiny_huge_and_illegal_entries() {
        let mut rng = Rng::for_stage(2, "kernels");
        let a = with_spectrum(&[3.0, 2.0, 2.0, -1.0, 0.0], &mut rng);
        for factor in [1e-150_f64, 1e150] {
            check(&a.iter().map(|v| v * factor).collect::<Vec<_>>(), 5, 1e-14);
        }
        assert!(symmetric_eigen(&[f64::NAN], 1).is_none());
        assert!(symmetric_eigen(&[1.0, f64::INFINITY, f64::INFINITY, 1.0], 2).is_none());
        assert!(symmetric_eigen(&[], 0).unwrap().values.is_empty());
    }
}
