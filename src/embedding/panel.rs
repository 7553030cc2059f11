//! Blocks of four vectors, stored row by row, and the few dense operations on them that Lanczos needs.
//!
//! Four numbers of a row stand side by side, so one pass over a sparse matrix serves four vectors and every inner loop is
//! as wide as the machine. Long panels are walked in chunks of rows, so that one panel stays in the nearest cache while
//! many others stream past it.

/// Vectors in a panel.
pub(super) const WIDTH: usize = 4;
/// One component of each vector.
pub(super) type Row = [f64; WIDTH];
/// A `4 × 4` matrix.
pub(super) type Square = [Row; WIDTH];
/// Four vectors of `R^n`: `n` rows.
pub(super) type Panel = Vec<Row>;

/// Rows per chunk: 8 KiB of a panel, so that a chunk and its partner fit the nearest cache, and one of each panel of a
/// basis the next.
const CHUNK: usize = 256;

/// `basisᵀ w`: the `4 × 4` products of every panel with `w`.
pub(super) fn project(basis: &[Panel], w: &[Row]) -> Vec<Square> {
    let mut products = vec![Square::default(); basis.len()];
    for (c, rows) in w.chunks(CHUNK).enumerate() {
        for (panel, product) in basis.iter().zip(&mut products) {
            add_gram(&panel[c * CHUNK..c * CHUNK + rows.len()], rows, product);
        }
    }
    products
}

/// `w += factor · basis · coefficients`; panels whose coefficients are all zero are skipped.
pub(super) fn add_combination(w: &mut [Row], basis: &[Panel], coefficients: &[Square], factor: f64) {
    let terms: Vec<(&Panel, Square)> = basis
        .iter()
        .zip(coefficients)
        .filter(|(_, c)| c.as_flattened().iter().any(|&x| x != 0.0))
        .map(|(panel, c)| (panel, c.map(|row| row.map(|x| factor * x))))
        .collect();
    for (c, rows) in w.chunks_mut(CHUNK).enumerate() {
        for (panel, coefficients) in &terms {
            let panel = &panel[c * CHUNK..c * CHUNK + rows.len()];
            add_product(rows, panel, coefficients);
        }
    }
}

/// `basis · coefficients`: `coefficients[q][p]` is what panel `p` of the basis contributes to panel `q` of the result.
///
/// All results of a chunk of rows are made before the next chunk, so that the basis is read from far memory once.
pub(super) fn combinations(basis: &[Panel], coefficients: &[Vec<Square>]) -> Vec<Panel> {
    let n = basis.first().map_or(0, Vec::len);
    let mut results = vec![vec![Row::default(); n]; coefficients.len()];
    for first in (0..n).step_by(CHUNK) {
        let rows = first..n.min(first + CHUNK);
        for (result, coefficients) in results.iter_mut().zip(coefficients) {
            for (panel, c) in basis.iter().zip(coefficients) {
                add_product(&mut result[rows.clone()], &panel[rows.clone()], c);
            }
        }
    }
    results
}

/// `sum += vᵀ w`.
#[inline(never)]
fn add_gram(v: &[Row], w: &[Row], sum: &mut Square) {
    let mut s = *sum;
    for (v, w) in v.iter().zip(w) {
        for p in 0..WIDTH {
            for q in 0..WIDTH {
                s[p][q] += v[p] * w[q];
            }
        }
    }
    *sum = s;
}

/// `w += v c`. Kept out of line: inlined, its sixteen coefficients no longer stay in registers, at half the speed.
#[inline(never)]
fn add_product(w: &mut [Row], v: &[Row], c: &Square) {
    let c = *c;
    for (w, v) in w.iter_mut().zip(v) {
        let mut sum = *w;
        for p in 0..WIDTH {
            for q in 0..WIDTH {
                sum[q] += v[p] * c[p][q];
            }
        }
        *w = sum;
    }
}

/// The lengths of the four vectors.
pub(super) fn lengths(w: &[Row]) -> Row {
    let mut sums = Row::default();
    for row in w {
        for c in 0..WIDTH {
            sums[c] += row[c] * row[c];
        }
    }
    sums.map(f64::sqrt)
}

/// Makes the vectors of `w` orthonormal by modified Gram-Schmidt and returns the upper triangular `s` with
/// `w_before = w s`. A vector no longer than `negligible` is replaced through `random`; its row of `s` is zero, and it is
/// neither orthogonal to the others nor of length one, so that the caller must come back.
pub(super) fn orthonormalize(w: &mut [Row], negligible: f64, random: &mut dyn FnMut() -> f64) -> Square {
    let mut s = Square::default();
    for c in 0..WIDTH {
        let length = lengths(w)[c];
        if length <= negligible {
            w.iter_mut().for_each(|row| row[c] = random());
            continue;
        }
        s[c][c] = length;
        let mut overlap = Row::default();
        for row in w.iter_mut() {
            row[c] /= length;
            for d in c + 1..WIDTH {
                overlap[d] += row[c] * row[d];
            }
        }
        s[c][c + 1..].copy_from_slice(&overlap[c + 1..]);
        for row in w.iter_mut() {
            for d in c + 1..WIDTH {
                row[d] -= overlap[d] * row[c];
            }
        }
    }
    s
}

/// `a b`.
pub(super) fn multiply(a: &Square, b: &Square) -> Square {
    let mut product = Square::default();
    for i in 0..WIDTH {
        for k in 0..WIDTH {
            for j in 0..WIDTH {
                product[i][j] += a[i][k] * b[k][j];
            }
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    fn random_panel(n: usize, rng: &mut Rng) -> Panel {
        (0..n).map(|_| [(); WIDTH].map(|()| rng.range(-1.0, 1.0))).collect()
    }

    #[test]
    fn chunked_products_equal_plain_sums() {
        let mut rng = Rng::for_stage(3, "test");
        let n = 2 * CHUNK + 7;
        let basis: Vec<Panel> = (0..3).map(|_| random_panel(n, &mut rng)).collect();
        let w = random_panel(n, &mut rng);
        let products = project(&basis, &w);
        let mut rest = w.clone();
        add_combination(&mut rest, &basis, &products, -1.0);
        for (panel, product) in basis.iter().zip(&products) {
            for (p, q) in [(0, 0), (1, 3), (3, 2)] {
                let plain: f64 = (0..n).map(|i| panel[i][p] * w[i][q]).sum();
                assert!((plain - product[p][q]).abs() < 1e-10, "{plain} {}", product[p][q]);
            }
        }
        for i in [0, CHUNK, n - 1] {
            let sum: f64 = (0..3).map(|b| (0..WIDTH).map(|p| basis[b][i][p] * products[b][p][2]).sum::<f64>()).sum();
            assert!((w[i][2] - sum - rest[i][2]).abs() < 1e-10);
        }
    }

    #[test]
    fn orthonormal_factors_multiply_back_and_dependent_vectors_are_replaced() {
        let mut rng = Rng::for_stage(4, "test");
        let before = random_panel(50, &mut rng);
        let mut q = before.clone();
        let s = orthonormalize(&mut q, 0.0, &mut || 0.0);
        let gram = project(std::slice::from_ref(&q), &q)[0];
        let mut back = vec![Row::default(); 50];
        add_combination(&mut back, std::slice::from_ref(&q), &[s], 1.0);
        for a in 0..WIDTH {
            for b in 0..WIDTH {
                assert!((gram[a][b] - f64::from(u8::from(a == b))).abs() < 1e-14);
                assert!((back[7 * a][b] - before[7 * a][b]).abs() < 1e-14);
            }
        }
        let mut dependent: Panel = before.iter().map(|r| [r[0], r[1], r[0] - r[1], r[3]]).collect();
        let s = orthonormalize(&mut dependent, 1e-12, &mut || 0.5);
        assert_eq!(s[2], [0.0; 4]);
        assert!(dependent.iter().all(|row| row[2] == 0.5));
    }
}
