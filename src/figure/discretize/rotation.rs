//! Eigenvector rotation: the multiclass spectral clustering of Yu and Shi (ICCV 2003), which the paper calls *rot*.
//!
//! Finds the rotation `R` of the row-normalised eigenvectors `Ṽ` that is nearest to a binary indicator matrix `X`,
//! minimising `‖X − Ṽ R‖`:
//!
//! 1. Start: nearly orthogonal rows of `Ṽ`, row_index greedily.
//! 2. `X` = row-wise maximum of `Ṽ R`.
//! 3. `R` = the orthogonal matrix nearest to `Ṽᵀ X`, by singular value decomposition; repeat from 2 while the fit
//!    improves.
//!
//! Several first rows are tried and the best fit is kept, ties to the first, since the start decides the local optimum.
//! Cost: O(starts · iterations · (rows · K² + K³)). It fails where two clusters differ in none of the eigenvectors.

use crate::embedding::Embedding;
use crate::evidence::UNLABELLED;
use crate::order::{f64_key, sort_by_key};

/// First rows tried, as fractions of the number of rows. Chosen by eye.
const START_ROWS: [f64; 3] = [0.5, 0.25, 0.75];
/// Most iterations of a start (published code of Yu and Shi).
const MAX_ITERATIONS: usize = 20;
/// Most sweeps of the Jacobi iteration, which converges in about ten.
const MAX_SWEEPS: usize = 60;

/// Labels every embedded trajectory in `0..count`, by the leading `count` eigenvectors; the others stay unlabelled. Labels
/// may be missing.
pub(crate) fn rotate(embedding: &Embedding, count: usize) -> Vec<u32> {
    label_embedded(embedding, NormalizedRows::new(embedding, count).rotate())
}

/// Extends the labels of the embedded trajectories to all of them.
pub(super) fn label_embedded(embedding: &Embedding, labels: Vec<u32>) -> Vec<u32> {
    let mut label = vec![UNLABELLED; embedding.num_rows];
    for (label, l) in label.iter_mut().zip(&embedding.embedded).filter(|(_, e)| **e).map(|(l, _)| l).zip(labels) {
        *label = l;
    }
    label
}

/// Leading eigenvectors of the embedded trajectories, with rows scaled to length one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NormalizedRows {
    /// Length of a row.
    pub(crate) k: usize,
    pub(crate) rows: Vec<f64>,
}

impl NormalizedRows {
    /// Takes the leading `count` eigenvectors, or all there are.
    pub(crate) fn new(embedding: &Embedding, count: usize) -> Self {
        let k = count.min(embedding.dimensions);
        let embedded: Vec<usize> = (0..embedding.num_rows).filter(|&i| embedding.embedded[i]).collect();
        Self { k, rows: normalised_rows(embedding, &embedded, k) }
    }

    /// Labels each row by the best rotation; empty without eigenvectors.
    pub(crate) fn rotate(&self) -> Vec<u32> {
        let Self { k, rows } = self;
        let count = rows.len().checked_div(*k).unwrap_or(0);
        let mut best: Option<(f64, Vec<u32>)> = None;
        for start in START_ROWS.iter().filter(|_| count > 0) {
            let first = ((count as f64 * start) as usize).min(count - 1);
            let (fit, labels) = fit_rotation(rows, *k, initial_rotation(rows, *k, first));
            if best.as_ref().is_none_or(|b| fit > b.0) {
                best = Some((fit, labels));
            }
        }
        best.map_or_else(Vec::new, |(_, labels)| labels)
    }
}

/// Scales the first `k` columns of the rows of `V` to length one; a zero row stays zero.
fn normalised_rows(embedding: &Embedding, embedded: &[usize], k: usize) -> Vec<f64> {
    let mut rows = Vec::with_capacity(embedded.len() * k);
    for &i in embedded {
        let row = &embedding.row(i)[..k];
        let length = row.iter().map(|v| v * v).sum::<f64>().sqrt();
        let scale = if length > 0.0 { 1.0 / length } else { 0.0 };
        rows.extend(row.iter().map(|v| v * scale));
    }
    rows
}

/// Builds the start `R`, `k × k` row by row: its columns are rows of `Ṽ`, each the least aligned with those before it.
fn initial_rotation(rows: &[f64], k: usize, first: usize) -> Vec<f64> {
    let n = rows.len() / k;
    let mut rotation = vec![0.0; k * k];
    let mut alignment = vec![0.0; n];
    let mut row_index = first;
    for column in 0..k {
        for c in 0..k {
            rotation[c * k + column] = rows[row_index * k + c];
        }
        for (i, row) in rows.chunks_exact(k).enumerate() {
            alignment[i] += row.iter().zip(&rows[row_index * k..]).map(|(a, b)| a * b).sum::<f64>().abs();
        }
        row_index = (0..n).fold(0, |low, i| if alignment[i] < alignment[low] { i } else { low });
    }
    rotation
}

/// Alternates labels and rotation. Returns the fit (the sum of singular values, larger is better) and the labels.
fn fit_rotation(rows: &[f64], k: usize, mut rotation: Vec<f64>) -> (f64, Vec<u32>) {
    let mut best = (f64::NEG_INFINITY, vec![0; rows.len() / k]);
    let mut rotated = vec![0.0; k];
    for _ in 0..MAX_ITERATIONS {
        let mut labels = Vec::with_capacity(rows.len() / k);
        let mut moment = vec![0.0; k * k];
        for row in rows.chunks_exact(k) {
            rotated.fill(0.0);
            for (value, line) in row.iter().zip(rotation.chunks_exact(k)) {
                for (sum, r) in rotated.iter_mut().zip(line) {
                    *sum += value * r;
                }
            }
            let label = (0..k).fold(0, |top, c| if rotated[c] > rotated[top] { c } else { top });
            for (sum, value) in moment[label * k..(label + 1) * k].iter_mut().zip(row) {
                *sum += value;
            }
            labels.push(label as u32);
        }
        let (nearest, fit) = polar_factor(&moment, k);
        if fit <= best.0 * (1.0 + 1e-12) {
            break;
        }
        best = (fit, labels);
        rotation = nearest;
    }
    best
}

/// Computes the rotation `B Aᵀ` and the trace of `Ω` for `M = Xᵀ Ṽ = A Ω Bᵀ` (`k × k`, row by row), by one-sided Jacobi
/// iteration.
fn polar_factor(moment: &[f64], k: usize) -> (Vec<f64>, f64) {
    // Rows of `g` become Ω_c A_cᵀ, rows of `b` become B_cᵀ: rotations of the columns of M, kept transposed for
    // locality.
    let mut g: Vec<f64> = (0..k * k).map(|e| moment[(e % k) * k + e / k]).collect();
    let mut b: Vec<f64> = (0..k * k).map(|e| if e / k == e % k { 1.0 } else { 0.0 }).collect();
    for _ in 0..MAX_SWEEPS {
        let mut is_diagonal = true;
        for p in 0..k {
            for q in p + 1..k {
                let [alpha, beta, gamma] = products(&g[p * k..][..k], &g[q * k..][..k]);
                if gamma * gamma <= 1e-30 * alpha * beta || gamma == 0.0 {
                    continue;
                }
                is_diagonal = false;
                let zeta = (beta - alpha) / (2.0 * gamma);
                let t = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
                let cos = 1.0 / (1.0 + t * t).sqrt();
                rotate_rows(&mut g, k, p, q, cos, cos * t);
                rotate_rows(&mut b, k, p, q, cos, cos * t);
            }
        }
        if is_diagonal {
            break;
        }
    }
    orthogonal_product(&g, &b, k)
}

/// Computes `a·a`, `b·b` and `a·b` of two rows, four terms in parallel.
fn products(a: &[f64], b: &[f64]) -> [f64; 3] {
    let ((a, rest_a), (b, rest_b)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sums = [[0.0; 4]; 3];
    for (a, b) in a.iter().zip(b) {
        for k in 0..4 {
            sums[0][k] += a[k] * a[k];
            sums[1][k] += b[k] * b[k];
            sums[2][k] += a[k] * b[k];
        }
    }
    let mut sums = sums.map(|[a, b, c, d]| (a + b) + (c + d));
    for (a, b) in rest_a.iter().zip(rest_b) {
        sums = [sums[0] + a * a, sums[1] + b * b, sums[2] + a * b];
    }
    sums
}

/// Applies a Givens rotation to rows `p < q` of a matrix of `k` columns.
fn rotate_rows(m: &mut [f64], k: usize, p: usize, q: usize, cos: f64, sin: f64) {
    let (upper, lower) = m.split_at_mut(q * k);
    for (x, y) in upper[p * k..][..k].iter_mut().zip(&mut lower[..k]) {
        let (a, b) = (*x, *y);
        *x = cos * a - sin * b;
        *y = sin * a + cos * b;
    }
}

/// Computes `B Aᵀ` from the rows `Ω_c A_cᵀ` of `g` and `B_cᵀ` of `b`. Where Ω_c vanishes (an empty cluster) any direction
/// orthogonal to the other `A` will do; unit vectors are tried in order.
fn orthogonal_product(g: &[f64], b: &[f64], k: usize) -> (Vec<f64>, f64) {
    let omega: Vec<f64> = g.chunks_exact(k).map(|row| row.iter().map(|v| v * v).sum::<f64>().sqrt()).collect();
    let tiny = 1e-12 * omega.iter().fold(0.0_f64, |a, &v| a.max(v));
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(k);
    let mut order: Vec<usize> = (0..k).collect();
    sort_by_key(&mut order, |&c| !f64_key(omega[c]));
    let mut rotation = vec![0.0; k * k];
    for &c in &order {
        let row = if omega[c] > tiny && omega[c] > 0.0 {
            g[c * k..(c + 1) * k].iter().map(|v| v / omega[c]).collect()
        } else {
            completing_vector(&basis, k)
        };
        for i in 0..k {
            for j in 0..k {
                rotation[i * k + j] += b[c * k + i] * row[j];
            }
        }
        basis.push(row);
    }
    (rotation, omega.iter().sum())
}

/// Returns a unit vector orthogonal to `basis`, which has fewer than `k` members.
fn completing_vector(basis: &[Vec<f64>], k: usize) -> Vec<f64> {
    let mut longest = (0.0, vec![0.0; k]);
    for axis in 0..k {
        let mut v = vec![0.0; k];
        v[axis] = 1.0;
        for _ in 0..2 {
            for u in basis {
                let along: f64 = u.iter().zip(&v).map(|(a, b)| a * b).sum();
                v.iter_mut().zip(u).for_each(|(x, a)| *x -= along * a);
            }
        }
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length > longest.0 {
            longest = (length, v.iter().map(|x| x / length).collect());
        }
        if length > 0.5 {
            break;
        }
    }
    longest.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    fn embedding(k: usize, rows: &[Vec<f64>]) -> Embedding {
        Embedding {
            num_rows: rows.len(),
            dimensions: k,
            eigenvalues: vec![1.0; k],
            vectors: rows.concat(),
            embedded: vec![true; rows.len()],
            ..Embedding::default()
        }
    }

    #[test]
    fn rotated_indicator_vectors_are_recovered() {
        // Three groups on three orthogonal directions, turned by a fixed rotation, with a little noise.
        let turn = [[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]];
        let mut rng = Rng::for_stage(3, "rotation");
        let group = |i: usize| (i * 7 / 5) % 3;
        let rows: Vec<Vec<f64>> = (0..60)
            .map(|i| turn[group(i)].iter().map(|v| (1.0 + i as f64) * (v + rng.range(-0.05, 0.05))).collect())
            .collect();
        let labels = rotate(&embedding(3, &rows), 3);
        for i in 0..60 {
            for j in 0..60 {
                assert_eq!(labels[i] == labels[j], group(i) == group(j), "{i} {j}");
            }
        }
    }

    #[test]
    fn polar_factor_is_orthogonal_even_for_singular_moments() {
        let mut rng = Rng::for_stage(4, "polar");
        for (k, rank) in [(1, 1), (3, 3), (5, 2), (4, 0), (12, 12)] {
            let mut moment = vec![0.0; k * k];
            for row in moment.chunks_exact_mut(k).take(rank) {
                row.iter_mut().for_each(|v| *v = rng.range(-1.0, 1.0));
            }
            let (r, fit) = polar_factor(&moment, k);
            for i in 0..k {
                for j in 0..k {
                    let dot: f64 = (0..k).map(|c| r[i * k + c] * r[j * k + c]).sum();
                    assert!((dot - f64::from(u8::from(i == j))).abs() < 1e-9, "k {k} rank {rank}: {dot}");
                }
            }
            // trace(M R) equals the sum of singular values exactly when R = B Aᵀ.
            let trace: f64 = (0..k).map(|i| (0..k).map(|c| moment[i * k + c] * r[c * k + i]).sum::<f64>()).sum();
            assert!((trace - fit).abs() < 1e-9, "{trace} {fit}");
        }
    }

    #[test]
    fn only_the_leading_eigenvectors_asked_for_count() {
        let mut rng = Rng::for_stage(5, "leading");
        let rows: Vec<Vec<f64>> = (0..50).map(|_| (0..4).map(|_| rng.range(-1.0, 1.0)).collect()).collect();
        let leading: Vec<Vec<f64>> = rows.iter().map(|r| r[..2].to_vec()).collect();
        assert_eq!(rotate(&embedding(4, &rows), 2), rotate(&embedding(2, &leading), 2));
        assert_eq!(rotate(&embedding(4, &rows), 9), rotate(&embedding(4, &rows), 4));
        assert_eq!(rotate(&embedding(4, &rows), 0), [UNLABELLED; 50]);
    }

    #[test]
    fn trajectories_outside_the_embedding_stay_unlabelled() {
        let mut e = embedding(2, &[vec![1.0, 0.0], vec![0.0, 0.0], vec![0.0, 1.0]]);
        e.embedded[1] = false;
        let labels = rotate(&e, 2);
        assert_eq!(labels[1], UNLABELLED);
        assert_ne!(labels[0], labels[2]);
    }
}
