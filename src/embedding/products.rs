//! Products of tall matrices for wasm, where faer is left out; native builds use faer's, tests hold these against it.
//!
//! Matrices are column-major. Long columns are walked in chunks, so that one chunk of all of `w` stays in the nearest cache.

/// Rows per chunk.
const CHUNK: usize = 256;
/// Numbers in a register.
const LANES: usize = 2;

/// `vᵀ w` for columns of length `n`.
pub(super) fn project(v: &[f64], w: &[f64], n: usize) -> Vec<f64> {
    let (rows, columns) = (v.len() / n, w.len() / n);
    let mut product = vec![0.0; rows * columns];
    for first in (0..n).step_by(CHUNK) {
        let end = n.min(first + CHUNK);
        for (p, v) in v.chunks_exact(n).map(|v| &v[first..end]).enumerate() {
            let mut q = 0;
            while q + 4 <= columns {
                let sums = dot_four(v, std::array::from_fn(|c| &w[(q + c) * n + first..(q + c) * n + end]));
                (0..4).for_each(|c| product[(q + c) * rows + p] += sums[c]);
                q += 4;
            }
            for q in q..columns {
                product[q * rows + p] += v.iter().zip(&w[q * n + first..q * n + end]).map(|(x, y)| x * y).sum::<f64>();
            }
        }
    }
    product
}

/// The products of `v` with four others of its length.
fn dot_four(v: &[f64], w: [&[f64]; 4]) -> [f64; 4] {
    let mut sums = [[0.0; LANES]; 4];
    let (pairs, last) = v.as_chunks::<LANES>();
    let others = w.map(|w| w.as_chunks::<LANES>().0);
    for (i, v) in pairs.iter().enumerate() {
        for c in 0..4 {
            let w = &others[c][i];
            (0..LANES).for_each(|l| sums[c][l] += v[l] * w[l]);
        }
    }
    let rest = pairs.len() * LANES;
    std::array::from_fn(|c| {
        sums[c].iter().sum::<f64>() + last.iter().zip(&w[c][rest..]).map(|(x, y)| x * y).sum::<f64>()
    })
}

/// `w += factor · v · coefficients` for columns of length `n`.
pub(super) fn add_combination(w: &mut [f64], v: &[f64], coefficients: &[f64], factor: f64, n: usize) {
    let inner = v.len() / n;
    for first in (0..n).step_by(CHUNK) {
        let end = n.min(first + CHUNK);
        for (w, coefficients) in w.chunks_exact_mut(n).zip(coefficients.chunks_exact(inner)) {
            let w = &mut w[first..end];
            let mut p = 0;
            while p + 4 <= inner {
                let c = std::array::from_fn(|d| factor * coefficients[p + d]);
                add_four(w, std::array::from_fn(|d| &v[(p + d) * n + first..(p + d) * n + end]), c);
                p += 4;
            }
            for p in p..inner {
                let c = factor * coefficients[p];
                w.iter_mut().zip(&v[p * n + first..p * n + end]).for_each(|(w, v)| *w += c * v);
            }
        }
    }
}

/// Adds `c[0] v[0] + … + c[3] v[3]`; all of one length.
fn add_four(w: &mut [f64], v: [&[f64]; 4], c: [f64; 4]) {
    let n = w.len();
    let [s, t, u, v] = v.map(|v| &v[..n]);
    for i in 0..n {
        w[i] += (c[0] * s[i] + c[1] * t[i]) + (c[2] * u[i] + c[3] * v[i]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::dense;
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn products_agree_with_faer() {
        let mut rng = Rng::for_stage(1, "test");
        let mut random = |count: usize| (0..count).map(|_| rng.range(-1.0, 1.0)).collect::<Vec<_>>();
        for (n, inner, columns) in [(1, 1, 1), (7, 3, 5), (256, 8, 4), (519, 6, 9)] {
            let (v, w, coefficients) = (random(n * inner), random(n * columns), random(inner * columns));
            let (ours, theirs) = (project(&v, &w, n), dense::project(&v, &w, n));
            assert!(ours.iter().zip(&theirs).all(|(a, b)| (a - b).abs() < 1e-12), "{ours:?} {theirs:?}");
            let (mut ours, mut theirs) = (w.clone(), w);
            add_combination(&mut ours, &v, &coefficients, -0.5, n);
            dense::add_combination(&mut theirs, &v, &coefficients, -0.5, n);
            assert!(ours.iter().zip(&theirs).all(|(a, b)| (a - b).abs() < 1e-12));
        }
    }
}
