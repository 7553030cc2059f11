//! Times the eigensolver on graphs like those of real clips:
//! `cargo bench -p tracecut-bench --bench eigen [-- FOLDER | FILE.mtx...]`.
//!
//! With a folder, the normalised matrices are written there as MatrixMarket, to time other solvers on the same input.
//! With MatrixMarket files, such as `dump/affinity.mtx` of `tracecut segment --dump`, those are solved instead. Times
//! are the least of six runs, in processor time where the system tells it.

#[path = "support/clock.rs"]
mod clock;

use clock::seconds;
use std::fmt::Write as _;
use tracecut::embedding::{EigenInfo, EigenParams, EmbeddingParams, embed_within, largest_eigenpairs};
use tracecut::rng::{Rng, mix};
use tracecut::sparse::SymCsr;

/// Eigenpairs asked for.
const K: u32 = 24;

/// A trajectory as far as its affinities go: where it is, how it moves, how much the flow varies around it.
struct Point {
    x: f64,
    y: f64,
    u: f64,
    v: f64,
    sigma: f64,
}

/// Points scattered over 640x480, in the order of a tracker (by frame of birth, then by row), that move with a panning,
/// zooming background or one of `objects` turning discs.
fn points(n: usize, objects: usize, seed: u64) -> Vec<Point> {
    let mut rng = Rng::for_stage(seed, "bench");
    let discs: Vec<[f64; 6]> = (0..objects)
        .map(|_| {
            let (x, y) = (rng.range(60.0, 580.0), rng.range(60.0, 420.0));
            [x, y, rng.range(30.0, 90.0), rng.range(-2.0, 2.0), rng.range(-2.0, 2.0), rng.range(-0.01, 0.01)]
        })
        .collect();
    let mut places: Vec<(u32, u32, f64, f64)> = (0..n)
        .map(|_| {
            let born = rng.range(-30.0, 44.0).max(0.0) as u32;
            let (x, y) = (rng.range(0.0, 640.0), rng.range(0.0, 480.0));
            (born, (y / 8.0) as u32, x, y)
        })
        .collect();
    places.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
    places
        .into_iter()
        .map(|(_, _, x, y)| {
            let mut point = Point { x, y, u: 1.0 + 0.004 * (x - 320.0), v: 0.004 * (y - 240.0), sigma: 0.3 };
            for &[cx, cy, r, u, v, spin] in &discs {
                let distance = (x - cx).hypot(y - cy);
                point.sigma += 0.5 * (-((distance - r) / 6.0).powi(2)).exp();
                if distance < r {
                    (point.u, point.v) = (u - spin * (y - cy), v + spin * (x - cx));
                }
            }
            point.u += 0.15 * (rng.uniform() + rng.uniform() - 1.0);
            point.v += 0.15 * (rng.uniform() + rng.uniform() - 1.0);
            point
        })
        .collect()
}

/// Affinities exp(-0.02 dist (r / s)^2) of all pairs within `radius` and of one in 32 of the others, at 32 times the
/// weight.
fn graph(points: &[Point], radius: f64) -> SymCsr {
    let mut upper = Vec::new();
    for (i, p) in points.iter().enumerate() {
        for (j, q) in points.iter().enumerate().skip(i + 1) {
            let distance = (p.x - q.x).hypot(p.y - q.y);
            let far = distance > radius;
            if far && !mix((i as u64) << 32 | j as u64).is_multiple_of(32) {
                continue;
            }
            let ratio = (p.u - q.u).hypot(p.v - q.v) / p.sigma.min(q.sigma);
            let w = (-0.02 * distance * ratio * ratio).exp() * if far { 32.0 } else { 1.0 };
            if w > 1e-6 {
                upper.push((i as u32, j as u32, w as f32));
            }
        }
    }
    SymCsr::from_upper(points.len(), &upper)
}

fn matrix_market(a: &SymCsr) -> String {
    let scale: Vec<f64> = a.degrees().iter().map(|d| 1.0 / d.sqrt()).collect();
    let lower = (0..a.len()).map(|i| a.row(i).filter(|&(j, _)| j <= i).count()).sum::<usize>();
    let mut text = format!("%%MatrixMarket matrix coordinate real symmetric\n{0} {0} {lower}\n", a.len());
    for i in 0..a.len() {
        for (j, w) in a.row(i).filter(|&(j, _)| j <= i) {
            let _ = writeln!(text, "{} {} {:e}", i + 1, j + 1, w * scale[i] * scale[j]);
        }
    }
    text
}

/// A symmetric MatrixMarket file with a zero diagonal: one triangle, counted from 1.
fn read_matrix_market(path: &str) -> SymCsr {
    let text = std::fs::read_to_string(path).expect("the matrix can be read");
    let mut lines = text.lines().filter(|l| !l.starts_with('%')).map(|l| l.split_whitespace().collect::<Vec<_>>());
    let n = lines.next().and_then(|l| l[0].parse().ok()).expect("the sizes come first");
    let index = |word: &str| word.parse::<u32>().expect("an index is a whole number") - 1;
    let upper: Vec<_> = lines.map(|l| (index(l[1]), index(l[0]), l[2].parse().expect("a value is a number"))).collect();
    SymCsr::from_upper(n, &upper)
}

/// Runs `solve` six times and prints the least time.
fn report(name: &str, a: &SymCsr, mut solve: impl FnMut(f64) -> (EigenInfo, Vec<f64>)) {
    for tolerance in [1e-4, 1e-6] {
        let mut best = f64::MAX;
        let mut found = Default::default();
        for _ in 0..6 {
            let start = seconds();
            found = solve(tolerance);
            best = best.min(seconds() - start);
        }
        let (info, values) = found;
        println!(
            "{name}: n = {}, {} entries, K = {}, tolerance {tolerance:e}: {:.0} ms, {info:?}, last value {:.6}",
            a.len(),
            a.column.len(),
            values.len(),
            1e3 * best,
            values.last().copied().unwrap_or_default()
        );
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let (matrices, folders): (Vec<_>, Vec<_>) = arguments.iter().partition(|a| a.ends_with(".mtx"));
    for path in &matrices {
        let a = read_matrix_market(path);
        let solve = |tolerance| {
            let params = EigenParams { tolerance, max_products: 20_000, multiplicity: 1, seed: 0 };
            let pairs = largest_eigenpairs(&a, K as usize, &params);
            (pairs.info, pairs.values)
        };
        report(path, &a, solve);
    }
    if !matrices.is_empty() {
        return;
    }
    for (n, objects, radius) in [(2500, 3, 60.0), (10_000, 3, 25.0), (10_000, 3, 45.0)] {
        let a = graph(&points(n, objects, 7), radius);
        if let Some(folder) = folders.first() {
            let path = format!("{folder}/n{n}-r{radius}.mtx");
            std::fs::write(&path, matrix_market(&a)).expect("the folder can be written to");
            println!("{path}");
        }
        let solve = |tolerance| {
            let params = EmbeddingParams { min_dimensions: K, ..EmbeddingParams::default() };
            let embedding = embed_within(tolerance, &a, &params, 0);
            (embedding.info, embedding.eigenvalues)
        };
        report(&format!("radius {radius}"), &a, solve);
    }
}
