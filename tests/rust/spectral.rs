//! The eigensolver and the embedding against laws, closed forms and a dense reference written here.

use proptest::prelude::*;
use std::f64::consts::PI;
use tracecut::embedding::{EigenParams, Eigenpairs, Embedding, EmbeddingParams, SymmetricOperator};
use tracecut::embedding::{embed, embed_with_tolerance, largest_eigenpairs};
use tracecut::rng::Rng;
use tracecut::sparse::SymCsr;

const PARAMS: EigenParams = EigenParams { tolerance: 1e-9, max_products: 200_000, multiplicity: 0, seed: 1 };
/// Above it the solver leaves its dense path (for the small `k` used here).
const DENSE_LIMIT: usize = 200;

/// A sparse symmetric matrix with a diagonal.
#[derive(Clone, Debug)]
struct Matrix {
    diagonal: Vec<f64>,
    off: SymCsr,
}

impl Matrix {
    fn new(diagonal: Vec<f64>, upper: &[(u32, u32, f32)]) -> Self {
        Self { off: SymCsr::from_upper(diagonal.len(), upper), diagonal }
    }

    fn graph(n: usize, edges: impl Iterator<Item = (usize, usize)>) -> Self {
        Self::new(vec![0.0; n], &edges.map(|(i, j)| (i as u32, j as u32, 1.0)).collect::<Vec<_>>())
    }

    /// `copies` of the matrix along the diagonal.
    fn repeated(&self, copies: usize) -> Self {
        let n = self.diagonal.len();
        let mut upper = Vec::new();
        for c in 0..copies {
            for i in 0..n {
                let shift = |k: usize| (c * n + k) as u32;
                upper.extend(self.off.row(i).filter(|e| e.0 > i).map(|(j, w)| (shift(i), shift(j), w as f32)));
            }
        }
        Self::new(self.diagonal.repeat(copies), &upper)
    }

    fn dense(&self) -> Vec<Vec<f64>> {
        let n = self.diagonal.len();
        (0..n)
            .map(|i| {
                let mut row = vec![0.0; n];
                row[i] = self.diagonal[i];
                self.off.row(i).for_each(|(j, w)| row[j] = w);
                row
            })
            .collect()
    }
}

impl SymmetricOperator for Matrix {
    fn dimension(&self) -> usize {
        self.diagonal.len()
    }

    fn apply(&self, x: &[f64], columns: usize, out: &mut [f64]) {
        for i in 0..self.diagonal.len() {
            for c in 0..columns {
                let rest: f64 = self.off.row(i).map(|(j, w)| w * x[j * columns + c]).sum();
                out[i * columns + c] = self.diagonal[i] * x[i * columns + c] + rest;
            }
        }
    }
}

/// All eigenvalues, largest first, by Jacobi's cyclic rotations: slow, simple, and of full accuracy.
fn jacobi(mut a: Vec<Vec<f64>>) -> Vec<f64> {
    let n = a.len();
    for _ in 0..60 {
        let off: f64 = (0..n).map(|i| (0..i).map(|j| a[i][j] * a[i][j]).sum::<f64>()).sum();
        if off < 1e-26 {
            break;
        }
        for p in 0..n {
            for q in p + 1..n {
                if a[p][q].abs() < 1e-300 {
                    continue;
                }
                let angle = 0.5 * (2.0 * a[p][q]).atan2(a[q][q] - a[p][p]);
                let (s, c) = angle.sin_cos();
                for row in &mut a {
                    (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                }
                for k in 0..n {
                    (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
                }
            }
        }
    }
    let mut values: Vec<f64> = (0..n).map(|i| a[i][i]).collect();
    values.sort_by(|x, y| y.total_cmp(x));
    values
}

/// Residuals, orthonormality and order, all recomputed from what was returned.
fn assert_lawful(operator: &dyn SymmetricOperator, k: usize, pairs: &Eigenpairs, norm: f64) {
    let n = operator.dimension();
    assert_eq!((pairs.values.len(), pairs.vectors.len()), (k.min(n), k.min(n) * n));
    assert!(pairs.info.converged, "{:?}", pairs.info);
    assert!(pairs.values.is_sorted_by(|a, b| a >= b), "{:?}", pairs.values);
    let k = k.min(n);
    let mut image = vec![0.0; n * k];
    operator.apply(&pairs.vectors, k, &mut image);
    let column = |m: &[f64], c: usize| m.iter().skip(c).step_by(k).copied().collect::<Vec<f64>>();
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(a, b)| a * b).sum::<f64>();
    for c in 0..k {
        let (v, av) = (column(&pairs.vectors, c), column(&image, c));
        let r: Vec<f64> = v.iter().zip(&av).map(|(v, av)| av - pairs.values[c] * v).collect();
        let residual = dot(&r, &r).sqrt();
        assert!(residual <= 1.01 * PARAMS.tolerance.max(1e-14 * norm * n as f64), "residual {residual} of pair {c}");
        for d in 0..=c {
            let product = dot(&v, &column(&pairs.vectors, d));
            let error = (product - f64::from(u8::from(c == d))).abs();
            assert!(error <= 8.0 * f64::EPSILON * n as f64, "vectors {c} and {d}: {error}");
        }
    }
}

fn assert_values(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (c, (f, e)) in found.iter().zip(expected).enumerate() {
        assert!((f - e).abs() <= tolerance, "value {c}: {f}, expected {e}; all: {found:?} {expected:?}");
    }
}

fn path(n: usize) -> Matrix {
    Matrix::graph(n, (1..n).map(|i| (i - 1, i)))
}

fn hypercube(bits: usize) -> Matrix {
    Matrix::graph(
        1 << bits,
        (0..1 << bits).flat_map(move |i| (0..bits).map(move |b| (i, i ^ (1 << b)))).filter(|e| e.0 < e.1),
    )
}

/// A connected random graph with positive weights.
fn random_graph(n: usize, degree: usize, seed: u64) -> Vec<(u32, u32, f32)> {
    let mut rng = Rng::for_stage(seed, "test");
    let mut edges: Vec<(u32, u32)> = (1..n as u32).map(|i| (rng.below(i as usize) as u32, i)).collect();
    for _ in 0..n * degree / 2 {
        let (i, j) = (rng.below(n) as u32, rng.below(n) as u32);
        if i != j {
            edges.push((i.min(j), i.max(j)));
        }
    }
    edges.sort_unstable();
    edges.dedup();
    edges.into_iter().map(|(i, j)| (i, j, rng.range(0.05, 1.0) as f32)).collect()
}

#[test]
fn path_graph_has_its_closed_form_spectrum() {
    for n in [1, 2, 3, 63, 64, 65, DENSE_LIMIT, DENSE_LIMIT + 1, 600] {
        let a = path(n);
        let k = 12.min(n);
        let pairs = largest_eigenpairs(&a, k, &PARAMS);
        assert_lawful(&a, k, &pairs, 2.0);
        let expected: Vec<f64> = (1..=k).map(|j| 2.0 * (PI * j as f64 / (n + 1) as f64).cos()).collect();
        assert_values(&pairs.values, &expected, 1e-8);
    }
}

#[test]
fn hypercube_eigenvalues_come_with_their_multiplicities() {
    // bits - 2 r with multiplicity (bits choose r): for 10 bits 1, 10, 45.
    for (bits, k) in [(7, 20), (8, 37), (10, 30)] {
        let a = hypercube(bits);
        let pairs = largest_eigenpairs(&a, k, &PARAMS);
        assert_lawful(&a, k, &pairs, bits as f64);
        let level = |c: usize| {
            if c == 0 {
                0
            } else if c <= bits {
                1
            } else {
                2
            }
        };
        let expected: Vec<f64> = (0..k).map(|c| bits as f64 - 2.0 * level(c) as f64).collect();
        assert_values(&pairs.values, &expected, 1e-8);
    }
}

#[test]
fn copies_of_one_component_give_every_eigenvalue_as_often() {
    let one = Matrix::new(vec![0.0; 60], &random_graph(60, 6, 3));
    let expected = jacobi(one.dense());
    for (copies, k) in [(3, 24), (4, 24), (12, 24), (30, 40)] {
        let a = one.repeated(copies);
        let pairs = largest_eigenpairs(&a, k, &PARAMS);
        assert_lawful(&a, k, &pairs, 10.0);
        let expected: Vec<f64> = (0..k).map(|c| expected[c / copies]).collect();
        assert_values(&pairs.values, &expected, 1e-8);
    }
}

#[test]
fn complete_graph_has_one_large_eigenvalue_and_many_equal_ones() {
    for n in [5, 40, DENSE_LIMIT + 50] {
        let a = Matrix::graph(n, (0..n).flat_map(|j| (0..j).map(move |i| (i, j))));
        let k = 10.min(n);
        let pairs = largest_eigenpairs(&a, k, &PARAMS);
        assert_lawful(&a, k, &pairs, n as f64);
        let expected: Vec<f64> = (0..k).map(|c| if c == 0 { n as f64 - 1.0 } else { -1.0 }).collect();
        assert_values(&pairs.values, &expected, 1e-8);
    }
}

#[test]
fn zero_and_multiples_of_the_identity_are_solved_exactly() {
    for n in [0, 1, 2, DENSE_LIMIT, DENSE_LIMIT + 1, 1000] {
        for value in [0.0, 1.0, -3.0, 1e150, -1e-150] {
            let a = Matrix::new(vec![value; n], &[]);
            let pairs = largest_eigenpairs(&a, 9, &PARAMS);
            assert_lawful(&a, 9, &pairs, value.abs());
            assert_values(&pairs.values, &vec![value; 9.min(n)], 1e-12 * value.abs());
        }
    }
}

#[test]
fn diagonal_matrices_of_any_scale_and_spread_are_solved() {
    for scale in [1e-6, 1.0, 1e6] {
        let n = 500;
        let diagonal: Vec<f64> = (0..n).map(|i| scale * ((i * 37 % n) as f64 / n as f64 - 0.9)).collect();
        let a = Matrix::new(diagonal.clone(), &[]);
        let params = EigenParams { tolerance: 1e-9 * scale, ..PARAMS };
        let pairs = largest_eigenpairs(&a, 15, &params);
        assert!(pairs.info.converged, "{:?}", pairs.info);
        let expected: Vec<f64> = (0..15).map(|c| scale * ((n - 1 - c) as f64 / n as f64 - 0.9)).collect();
        assert_values(&pairs.values, &expected, 1e-10 * scale);
    }
}

#[test]
fn few_distinct_eigenvalues_are_found_though_the_rest_is_one_point() {
    let n = 700;
    let mut diagonal = vec![0.0; n];
    (diagonal[5], diagonal[77], diagonal[300]) = (3.0, 3.0, 1e-5);
    let pairs = largest_eigenpairs(&Matrix::new(diagonal, &[]), 6, &PARAMS);
    assert!(pairs.info.converged, "{:?}", pairs.info);
    assert_values(&pairs.values, &[3.0, 3.0, 1e-5, 0.0, 0.0, 0.0], 1e-8);
}

#[test]
fn as_many_pairs_as_rows_can_be_asked_for() {
    let a = Matrix::new(vec![0.0; 80], &random_graph(80, 5, 9));
    for k in [79, 80, 500] {
        let pairs = largest_eigenpairs(&a, k, &PARAMS);
        assert_lawful(&a, k, &pairs, 10.0);
        assert_values(&pairs.values, &jacobi(a.dense())[..k.min(80)], 1e-8);
    }
    assert!(largest_eigenpairs(&a, 0, &PARAMS).values.is_empty());
}

#[test]
fn entries_that_are_not_finite_give_a_finite_answer_that_says_so() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for n in [1, 5, 300] {
            let mut a = Matrix::new(vec![1.0; n], &[]);
            a.diagonal[n / 2] = bad;
            let pairs = largest_eigenpairs(&a, 4, &PARAMS);
            assert!(!pairs.info.converged);
            assert!(pairs.values.iter().chain(&pairs.vectors).all(|x| x.is_finite()));
            assert_eq!(pairs.vectors.len(), n * 4.min(n));

            let mut upper = random_graph(n.max(2), 4, 1);
            upper[0].2 = bad as f32;
            let embedding = embed(&SymCsr::from_upper(n.max(2), &upper), &EmbeddingParams::default(), 0);
            assert!(!embedding.info.converged);
            assert!(embedding.vectors.iter().chain(&embedding.eigenvalues).all(|x| x.is_finite()));
        }
    }
}

#[test]
fn an_exhausted_budget_returns_the_best_so_far_and_says_so() {
    let a = path(3000);
    let pairs = largest_eigenpairs(&a, 10, &EigenParams { max_products: 300, ..PARAMS });
    assert!(!pairs.info.converged && pairs.info.residual > PARAMS.tolerance, "{:?}", pairs.info);
    assert!(pairs.info.products < 3000, "{:?}", pairs.info);
    assert!(pairs.values.iter().all(|&v| v < 2.0 && v > 1.0), "{:?}", pairs.values);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn sparse_and_dense_agree_on_random_graphs(
        n in 2_usize..90, copies in 1_usize..8, degree in 1_usize..8, k in 1_usize..30, seed in 0_u64..1000,
    ) {
        let one = Matrix::new(vec![0.25; n], &random_graph(n, degree, seed));
        let a = one.repeated(copies);
        let mut expected: Vec<f64> = jacobi(one.dense()).into_iter().flat_map(|v| vec![v; copies]).collect();
        expected.truncate(k);
        let pairs = largest_eigenpairs(&a, k, &PARAMS);
        assert_lawful(&a, k, &pairs, 10.0);
        assert_values(&pairs.values, &expected, 1e-8);
    }
}

/// Ŵ = V Λ Vᵀ.
fn w_hat(e: &Embedding, i: usize, j: usize) -> f64 {
    let k = e.dimensions;
    (0..k).map(|c| e.vectors[i * k + c] * e.eigenvalues[c] * e.vectors[j * k + c]).sum()
}

fn params(dimensions: u32) -> EmbeddingParams {
    with(|params| (params.min_dimensions, params.max_dimensions, params.min_component) = (dimensions, dimensions, 1))
}

/// The default parameters changed by `change`.
fn with(change: impl FnOnce(&mut EmbeddingParams)) -> EmbeddingParams {
    let mut params = EmbeddingParams::default();
    change(&mut params);
    params
}

#[test]
fn blocks_have_one_over_volume_within_and_nothing_across() {
    // Complete graphs of 120, 80, 50 and 30 nodes: four eigenvalues 1, the others far below.
    let sizes = [120, 80, 50, 30];
    let block: Vec<usize> = sizes.iter().enumerate().flat_map(|(b, &s)| vec![b; s]).collect();
    let mut upper = Vec::new();
    for j in 0..block.len() {
        upper.extend((0..j).filter(|&i| block[i] == block[j]).map(|i| (i as u32, j as u32, 1.0)));
    }
    let a = SymCsr::from_upper(block.len(), &upper);
    let e = embed_with_tolerance(1e-9, &a, &params(4), 0);
    assert_values(&e.eigenvalues, &[1.0; 4], 1e-9);
    for i in (0..block.len()).step_by(7) {
        for j in 0..block.len() {
            let s = sizes[block[i]] as f64;
            let expected = if block[i] == block[j] { 1.0 / (s * (s - 1.0)) } else { 0.0 };
            assert!((w_hat(&e, i, j) - expected).abs() < 1e-11, "{i} {j}: {} {expected}", w_hat(&e, i, j));
        }
    }
}

#[test]
fn eigenvectors_of_the_random_walk_are_orthonormal_under_the_degrees() {
    let n = 900;
    let a = SymCsr::from_upper(n, &random_graph(n, 12, 5));
    let e = embed_with_tolerance(1e-9, &a, &params(10), 0);
    let (d, k) = (a.degrees(), e.dimensions);
    assert_eq!((k, e.embedded.iter().filter(|&&b| b).count()), (10, n));
    assert!((e.eigenvalues[0] - 1.0).abs() < 1e-12, "{:?}", e.eigenvalues);
    for c in 0..k {
        for b in 0..k {
            let product: f64 = (0..n).map(|i| d[i] * e.vectors[i * k + c] * e.vectors[i * k + b]).sum();
            assert!((product - f64::from(u8::from(b == c))).abs() < 1e-11, "{b} {c}: {product}");
        }
        for i in 0..n {
            let walk: f64 = a.row(i).map(|(j, w)| w / d[i] * e.vectors[j * k + c]).sum();
            assert!((walk - e.eigenvalues[c] * e.vectors[i * k + c]).abs() < 1e-8);
        }
        let column = (0..n).map(|i| e.vectors[i * k + c]);
        let largest = column.fold(0.0_f64, |m, v| if v.abs() > m.abs() { v } else { m });
        assert!(largest > 0.0);
    }
}

#[test]
fn w_hat_follows_a_permutation_of_the_trajectories() {
    let n = 320;
    let upper = random_graph(n, 10, 8);
    // 7 and 320 have no common factor, so this is a permutation.
    let to = |i: u32| (i * 7 + 3) % n as u32;
    let moved: Vec<_> = upper.iter().map(|&(i, j, w)| (to(i).min(to(j)), to(i).max(to(j)), w)).collect();
    let e = embed_with_tolerance(1e-10, &SymCsr::from_upper(n, &upper), &params(8), 0);
    let f = embed_with_tolerance(1e-10, &SymCsr::from_upper(n, &moved), &params(8), 0);
    for i in 0..n {
        for j in [0, 5, 311] {
            let (p, q) = (w_hat(&e, i, j), w_hat(&f, to(i as u32) as usize, to(j as u32) as usize));
            assert!((p - q).abs() < 1e-9, "{i} {j}: {p} {q}");
        }
    }
}

#[test]
fn w_hat_does_not_depend_on_the_basis_of_a_repeated_eigenvalue() {
    // A hypercube of 9 bits; 10 dimensions are exactly its two largest eigenvalues, of multiplicity 1 and 9.
    let cube = hypercube(9).off;
    let (e, f) =
        (embed_with_tolerance(1e-10, &cube, &params(10), 0), embed_with_tolerance(1e-10, &cube, &params(10), 77));
    assert_ne!(e.vectors, f.vectors);
    for i in 0..e.num_rows {
        for j in [0, 100, 511] {
            // Sum over the eigenspaces: (1 + 7/9 (9 - 2 hamming)) / (n d).
            let hamming = (i ^ j).count_ones() as f64;
            let expected = (1.0 + 7.0 / 9.0 * (9.0 - 2.0 * hamming)) / (512.0 * 9.0);
            assert!((w_hat(&e, i, j) - expected).abs() < 1e-11);
            assert!((w_hat(&f, i, j) - expected).abs() < 1e-11);
        }
    }
}

#[test]
fn the_same_graph_gives_the_same_bytes_twice() {
    for n in [50, 1500] {
        let a = SymCsr::from_upper(n, &random_graph(n, 10, 2));
        let bytes =
            |e: Embedding| e.vectors.iter().chain(&e.eigenvalues).flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>();
        let run = || bytes(embed(&a, &EmbeddingParams::default(), 5));
        assert_eq!(run(), run());
    }
}

#[test]
fn small_components_and_lone_trajectories_are_left_out() {
    // 300 nodes in one component, 20 in another, 3 alone.
    let mut upper = random_graph(300, 8, 4);
    upper.extend(random_graph(20, 8, 4).into_iter().map(|(i, j, w)| (i + 301, j + 301, w)));
    let a = SymCsr::from_upper(323, &upper);
    let e = embed(&a, &with(|params| params.min_component = 50), 0);
    for i in 0..323 {
        assert_eq!(e.embedded[i], i < 300, "{i}");
        let row = &e.vectors[i * e.dimensions..(i + 1) * e.dimensions];
        assert_eq!(row.iter().any(|&x| x != 0.0), i < 300, "{i}");
    }
    assert!(e.eigenvalues[1] < 0.99, "{:?}", e.eigenvalues);
    let both = embed(&a, &with(|params| params.min_component = 20), 0);
    assert_eq!(both.embedded.iter().filter(|&&b| b).count(), 320);
    assert!((both.eigenvalues[1] - 1.0).abs() < 1e-7, "{:?}", both.eigenvalues);
}

#[test]
fn where_every_component_is_small_the_largest_are_embedded() {
    // Three triangles, a pair and a lone node.
    let mut upper = vec![(9, 10, 1.0)];
    for t in [0, 3, 6] {
        upper.extend([(t, t + 1, 1.0), (t, t + 2, 1.0), (t + 1, t + 2, 1.0)]);
    }
    let mut params = EmbeddingParams::default();
    params.min_component = 50;
    let e = embed(&SymCsr::from_upper(12, &upper), &params, 0);
    assert_eq!(e.embedded, [true, true, true, true, true, true, true, true, true, false, false, false]);
    assert_eq!(e.dimensions, 8);
    assert_values(&e.eigenvalues[..3], &[1.0; 3], 1e-12);
}

#[test]
fn graphs_without_edges_and_without_nodes_are_embedded_nowhere() {
    for n in [0, 1, 2, 500] {
        let e = embed(&SymCsr::from_upper(n, &[]), &EmbeddingParams::default(), 0);
        assert_eq!((e.num_rows, e.dimensions, e.vectors.len()), (n, 0, 0));
        assert_eq!(e.embedded, vec![false; n]);
        assert!(e.info.converged);
    }
}

#[test]
fn the_number_of_dimensions_follows_the_eigenvalues_within_its_bounds() {
    // A chain of twelve dense groups with weak links: about twelve eigenvalues near 1.
    let mut upper = Vec::new();
    for g in 0..12_u32 {
        upper.extend(random_graph(60, 30, u64::from(g)).into_iter().map(|(i, j, w)| (60 * g + i, 60 * g + j, w)));
        if g > 0 {
            upper.push((60 * g - 1, 60 * g, 0.5));
        }
    }
    let a = SymCsr::from_upper(720, &upper);
    let dimensions = |p: EmbeddingParams| embed(&a, &p, 0).dimensions;
    assert_eq!(dimensions(EmbeddingParams::default()), 12);
    assert_eq!(dimensions(with(|params| params.max_dimensions = 10)), 10);
    assert_eq!(dimensions(with(|params| params.min_dimensions = 14)), 14);
    assert_eq!(dimensions(with(|params| params.min_eigenvalue = 1.0)), 8);
}
