//! The graph of an image's pixels: affinities by intervening contours, kept as one plane for each step to a neighbour.
//!
//! Pixels at most `r` apart are joined by `exp(-max Pb / σ)`, the maximum being over the boundaries that the line
//! between them crosses. A boundary lies between pixels: a pixel of the thin map stands on the cracks to its left and
//! above it, so that each pixel is on one side. As `exp` falls, the greatest Pb is the smallest of `exp(-Pb / σ)`,
//! which is made once for each pixel and not for each pair. Where a line goes through a corner, all four cracks around
//! it count: thin lines must not leak where they run diagonally.
//!
//! As a matrix the graph would have 80 entries a pixel at `r = 5`, each with its column. As planes, one for each of the
//! 40 steps to the right or down, it needs half of them and no columns, and a product is a sum of shifted rows.

use super::params::StillParams;
use crate::embedding::{EigenInfo, EigenParams, SymmetricOperator, largest_eigenpairs, refine_eigenpairs};
use crate::image::Plane;
use std::cell::RefCell;

/// The symmetric, normalised affinities `N = D^-1/2 W D^-1/2` of the pixels of an image.
#[derive(Debug, Clone)]
pub(super) struct PixelGraph {
    width: usize,
    height: usize,
    /// Zeros on either side of a row, and rows of zeros above and below: as many as the longest step has.
    margin: usize,
    steps: Vec<Step>,
    /// The weights to the neighbours one step away; for each step a padded plane, 0 where the neighbour lies outside.
    weights: Vec<Vec<f32>>,
    /// `d^-1/2` of each pixel, 0 for one without neighbours.
    pub(super) scale: Vec<f32>,
    /// Scratch: padded planes of the vectors of a block.
    padded: RefCell<Vec<f32>>,
}

/// From a pixel to one to its right or below it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Step {
    dx: isize,
    dy: usize,
}

/// A crack that a line crosses: between pixel `(x, y)`, seen from the line's start, and the one to its right or below.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Crack {
    x: isize,
    y: usize,
    below: bool,
}

/// Vectors that go through the planes together.
const BLOCK: usize = 4;

impl PixelGraph {
    /// The graph over the boundary strengths `pb` with radius `radius` in pixels and scale `sigma`.
    pub(super) fn new(pb: &Plane<f32>, radius: u32, sigma: f32) -> Self {
        let (width, height, margin) = (pb.width(), pb.height(), radius as usize);
        let cracks = Cracks::new(pb, sigma);
        let mut graph = Self {
            width,
            height,
            margin,
            steps: steps(radius),
            weights: Vec::new(),
            scale: Vec::new(),
            padded: RefCell::default(),
        };
        graph.weights = graph.steps.iter().map(|&s| graph.plane_of(s, &cracks)).collect();
        graph.scale = graph.degrees().iter().map(|&d| if d > 0.0 { 1.0 / d.sqrt() } else { 0.0 }).collect();
        graph
    }

    fn stride(&self) -> usize {
        self.width + 2 * self.margin
    }

    /// Where row `y` begins in a padded plane.
    fn start(&self, y: usize) -> usize {
        (y + self.margin) * self.stride() + self.margin
    }

    /// Pixels from which `step` stays inside a row.
    fn inside(&self, step: Step) -> std::ops::Range<usize> {
        let left = step.dx.min(0).unsigned_abs().min(self.width);
        let right = self.width.saturating_sub(step.dx.max(0) as usize);
        left..right.max(left)
    }

    fn plane_of(&self, step: Step, cracks: &Cracks) -> Vec<f32> {
        let mut plane = vec![0.0; self.stride() * (self.height + 2 * self.margin)];
        let range = self.inside(step);
        if range.is_empty() {
            return plane;
        }
        for y in 0..self.height.saturating_sub(step.dy) {
            let row = &mut plane[self.start(y)..][range.clone()];
            row.fill(1.0);
            for crack in cracks_on(step) {
                let from = (range.start as isize + crack.x) as usize;
                let source = &cracks.plane(crack.below)[(y + crack.y) * self.width + from..][..row.len()];
                for (w, &c) in row.iter_mut().zip(source) {
                    *w = if c < *w { c } else { *w };
                }
            }
        }
        plane
    }

    /// How many others a pixel has an affinity to.
    fn neighbours(&self) -> usize {
        2 * self.steps.len()
    }

    /// The affinity of each pixel to all others together.
    fn degrees(&self) -> Vec<f32> {
        let mut degrees = vec![0.0; self.width * self.height];
        let inside: Vec<f32> = vec![1.0; degrees.len()];
        let mut planes = vec![0.0; self.stride() * (self.height + 2 * self.margin)];
        self.spread(inside.into_iter(), &mut planes);
        for (y, row) in degrees.chunks_exact_mut(self.width.max(1)).enumerate() {
            self.gather(&planes, y, row);
        }
        degrees
    }

    /// Writes the values of all pixels into a padded plane.
    fn spread(&self, mut values: impl Iterator<Item = f32>, plane: &mut [f32]) {
        for y in 0..self.height {
            let row = &mut plane[self.start(y)..][..self.width];
            row.iter_mut().zip(&mut values).for_each(|(p, v)| *p = v);
        }
    }

    /// `out = W x` in row `y`, for a padded plane `x`: the neighbours that each step leads to, and those from which it
    /// leads here.
    fn gather(&self, x: &[f32], y: usize, out: &mut [f32]) {
        out.fill(0.0);
        let (n, here) = (self.width, self.start(y) as isize);
        let slice = |plane: &'_ [f32], at: isize| -> std::ops::Range<usize> {
            debug_assert!(at as usize + n <= plane.len());
            at as usize..at as usize + n
        };
        let shift = |s: Step| s.dy as isize * self.stride() as isize + s.dx;
        let mut pairs = self.steps.chunks_exact(2).zip(self.weights.chunks_exact(2));
        for (steps, weights) in &mut pairs {
            let (p, q) = (shift(steps[0]), shift(steps[1]));
            let (wp, wq) = (&weights[0], &weights[1]);
            let (w0, x0) = (&wp[slice(wp, here)], &x[slice(x, here + p)]);
            let (w1, x1) = (&wp[slice(wp, here - p)], &x[slice(x, here - p)]);
            let (w2, x2) = (&wq[slice(wq, here)], &x[slice(x, here + q)]);
            let (w3, x3) = (&wq[slice(wq, here - q)], &x[slice(x, here - q)]);
            let (w1, x1, w2, x2, w3, x3) = (&w1[..n], &x1[..n], &w2[..n], &x2[..n], &w3[..n], &x3[..n]);
            let (w0, x0, out) = (&w0[..n], &x0[..n], &mut out[..n]);
            for i in 0..n {
                out[i] += (w0[i] * x0[i] + w1[i] * x1[i]) + (w2[i] * x2[i] + w3[i] * x3[i]);
            }
        }
        if self.steps.len() % 2 == 1 {
            let (s, w) = (shift(self.steps[self.steps.len() - 1]), &self.weights[self.steps.len() - 1]);
            let (w0, x0) = (&w[slice(w, here)], &x[slice(x, here + s)]);
            let (w1, x1) = (&w[slice(w, here - s)], &x[slice(x, here - s)]);
            for ((((o, w0), x0), w1), x1) in out.iter_mut().zip(w0).zip(x0).zip(w1).zip(x1) {
                *o += w0 * x0 + w1 * x1;
            }
        }
    }
}

impl SymmetricOperator for PixelGraph {
    fn dimension(&self) -> usize {
        self.width * self.height
    }

    fn apply(&self, x: &[f64], columns: usize, out: &mut [f64]) {
        let size = self.stride() * (self.height + 2 * self.margin);
        let mut padded = self.padded.borrow_mut();
        padded.resize(size * BLOCK, 0.0);
        let mut sums = vec![0.0; self.width];
        for first in (0..columns).step_by(BLOCK) {
            let count = BLOCK.min(columns - first);
            for (c, plane) in padded.chunks_exact_mut(size).take(count).enumerate() {
                let column = x.iter().skip(first + c).step_by(columns);
                self.spread(column.zip(&self.scale).map(|(&v, &s)| v as f32 * s), plane);
            }
            // Row by row through all vectors: the weights of a row are then in the cache for all but the first.
            for y in 0..self.height {
                let scale = &self.scale[y * self.width..][..self.width];
                for (c, plane) in padded.chunks_exact(size).take(count).enumerate() {
                    self.gather(plane, y, &mut sums);
                    let row = &mut out[y * self.width * columns..][..self.width * columns];
                    for ((o, &v), &s) in row[first + c..].iter_mut().step_by(columns).zip(&sums).zip(scale) {
                        *o = f64::from(v * s);
                    }
                }
            }
        }
    }
}

/// The steps of at most `radius` to the right or downwards: one for each pair of opposite directions.
fn steps(radius: u32) -> Vec<Step> {
    let r = radius as isize;
    let half = (0..=r).flat_map(|dy| (-r..=r).map(move |dx| (dx, dy)));
    half.filter(|&(dx, dy)| (dy > 0 || dx > 0) && dx * dx + dy * dy <= r * r)
        .map(|(dx, dy)| Step { dx, dy: dy as usize })
        .collect()
}

/// The cracks that the line to the pixel at `step` crosses.
///
/// The line crosses the middle between columns `k` and `k + 1` at the row `(2 k + 1) dy / (2 |dx|)`, which is a corner
/// where this is half of an odd number; likewise between rows. In whole numbers, so that nothing depends on rounding.
fn cracks_on(step: Step) -> Vec<Crack> {
    let (across, down, side) = (step.dx.unsigned_abs(), step.dy, step.dx.signum());
    // The crack between columns k and k + 1 of a line that goes to the right, in row y.
    let right =
        |k: usize, y: usize| Crack { x: if side >= 0 { k as isize } else { -(k as isize) - 1 }, y, below: false };
    let below = |x: usize, k: usize| Crack { x: side * x as isize, y: k, below: true };
    let mut cracks = Vec::new();
    for k in 0..across {
        let (y, corner) = nearest((2 * k + 1) * down, 2 * across);
        cracks.push(right(k, y));
        if corner {
            cracks.extend([right(k, y + 1), below(k, y), below(k + 1, y)]);
        }
    }
    for k in 0..down {
        let (x, corner) = nearest((2 * k + 1) * across, 2 * down);
        if !corner {
            cracks.push(below(x, k));
        }
    }
    cracks
}

/// The whole number nearest to `a / b`, and whether it lies in the middle between this and the next.
fn nearest(a: usize, b: usize) -> (usize, bool) {
    let rest = a % b;
    (a / b + usize::from(2 * rest > b), 2 * rest == b)
}

/// `exp(-Pb / σ)` on the cracks to the right of each pixel and below it; 1 on those to the outside.
///
/// ```text
///   ┌──      A pixel's own cracks join those of the pixels beside it on a line, but for the one to its lower right: there
///   │ ┌──    the line goes on along the crack between, below the upper pixel.
///     │
/// ```
struct Cracks {
    right: Vec<f32>,
    below: Vec<f32>,
}

impl Cracks {
    fn new(pb: &Plane<f32>, sigma: f32) -> Self {
        let (w, h) = (pb.width(), pb.height());
        let pass: Vec<f32> = pb.data().iter().map(|&v| libm::expf(-v / sigma)).collect();
        let mut right = vec![1.0; w * h];
        let mut below = vec![1.0; w * h];
        for y in 0..h {
            right[y * w..][..w - 1].copy_from_slice(&pass[y * w + 1..][..w - 1]);
        }
        below[..(h - 1) * w].copy_from_slice(&pass[w..]);
        for y in 1..h {
            let (upper, lower) = (&pass[(y - 1) * w..][..w], &pass[y * w..][..w]);
            for ((crack, &a), &b) in below[(y - 1) * w..].iter_mut().zip(upper).zip(&lower[1..]) {
                *crack = crack.min(a.max(b));
            }
        }
        Self { right, below }
    }

    fn plane(&self, below: bool) -> &[f32] {
        if below { &self.below } else { &self.right }
    }
}

// Leading eigenvectors of an image's pixel graph, from coarse to fine.
//
// Eigenvalues of such graphs are crowded below 1: the larger the image, the closer. So the image is halved until it is
// small, solved there by block Lanczos, and each finer level starts from the coarser one's vectors, doubled in size.
// There a Chebyshev filter does what is left: it moves what doubling smeared across contours to the side where it
// belongs.

/// Images of at most this many pixels are solved directly.
const COARSEST: usize = 12_000;
/// Products with each eigenvector on the finer levels. Higher is slower and nearer to the exact eigenvectors.
const DEGREE: u32 = 10;
/// Residual at which an eigenpair of the coarsest level is good enough. Lower is slower.
const TOLERANCE: f64 = 1e-3;
/// Products after which the coarsest level is good enough as it is.
const MAX_PRODUCTS: f64 = 4000.0;
/// The same in multiplications, about two seconds.
const MOST_WORK: f64 = 8e9;
/// Multiplications for each pixel and product that go into the basis of the eigensolver.
const OF_BASIS: f64 = 300.0;

/// Leading eigenvectors of `P = D^-1 W`.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct PixelEmbedding {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Largest first.
    pub(super) eigenvalues: Vec<f64>,
    /// `V = D^-1/2 U`, so that `Vᵀ D V = 1`; a plane for each eigenvalue.
    pub(super) vectors: Vec<Vec<f32>>,
    pub(super) info: EigenInfo,
}

/// The embedding of the pixels of an image with the boundary strengths `pb`, thin lines.
pub(super) fn embed_pixels(pb: &Plane<f32>, params: &StillParams, seed: u32) -> PixelEmbedding {
    if pb.width() * pb.height() <= COARSEST {
        return solve(pb, params, seed);
    }
    let coarse = embed_pixels(&halved(pb), params, seed);
    refine(pb, &coarse, params)
}

fn solve(pb: &Plane<f32>, params: &StillParams, seed: u32) -> PixelEmbedding {
    let graph = PixelGraph::new(pb, params.radius, params.sigma);
    let settings = EigenParams { tolerance: TOLERANCE, max_products: most_products(&graph), multiplicity: 0, seed };
    let pairs = largest_eigenpairs(&graph, params.dimensions as usize, &settings);
    let k = pairs.values.len();
    unscaled(&graph, pb, pairs.values, &pairs.vectors, k, pairs.info)
}

/// Fewer where each takes long: large radii.
fn most_products(graph: &PixelGraph) -> u32 {
    let of_one = (graph.neighbours() as f64 + OF_BASIS) * graph.scale.len() as f64;
    (MOST_WORK / of_one).min(MAX_PRODUCTS) as u32
}

fn refine(pb: &Plane<f32>, coarse: &PixelEmbedding, params: &StillParams) -> PixelEmbedding {
    let graph = PixelGraph::new(pb, params.radius, params.sigma);
    let mut start = Vec::with_capacity(pb.data().len() * coarse.vectors.len());
    for vector in &coarse.vectors {
        let large = doubled(vector, coarse.width, (pb.width(), pb.height()));
        // U = D^1/2 V.
        start.extend(large.iter().zip(&graph.scale).map(|(v, &s)| if s > 0.0 { f64::from(v / s) } else { 0.0 }));
    }
    match refine_eigenpairs(&graph, start, DEGREE, TOLERANCE) {
        Some(pairs) => {
            let k = pairs.values.len();
            unscaled(&graph, pb, pairs.values, &pairs.vectors, k, pairs.info)
        }
        None => PixelEmbedding { width: pb.width(), height: pb.height(), ..PixelEmbedding::default() },
    }
}

/// From eigenvectors of N, row by row, to planes of those of P.
fn unscaled(
    graph: &PixelGraph,
    pb: &Plane<f32>,
    eigenvalues: Vec<f64>,
    rows: &[f64],
    k: usize,
    info: EigenInfo,
) -> PixelEmbedding {
    let plane = |c: usize| -> Vec<f32> {
        rows.iter().skip(c).step_by(k).zip(&graph.scale).map(|(&u, &s)| u as f32 * s).collect()
    };
    let vectors = (0..k).map(plane).collect();
    PixelEmbedding { width: pb.width(), height: pb.height(), eigenvalues, vectors, info }
}

/// The largest of each 2x2 pixels.
fn halved(pb: &Plane<f32>) -> Plane<f32> {
    let (w, h) = (pb.width(), pb.height());
    Plane::from_fn(w.div_ceil(2), h.div_ceil(2), |x, y| {
        let (x1, y1) = ((2 * x + 1).min(w - 1), (2 * y + 1).min(h - 1));
        pb[(2 * x, 2 * y)].max(pb[(x1, 2 * y)]).max(pb[(2 * x, y1)]).max(pb[(x1, y1)])
    })
}

/// Twice as large: each pixel is copied.
fn doubled(small: &[f32], small_width: usize, (w, h): (usize, usize)) -> Vec<f32> {
    (0..h).flat_map(|y| (0..w).map(move |x| small[y / 2 * small_width + x / 2])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::embedding::SymmetricOperator;
    use crate::rng::Rng;
    use crate::sparse::SymCsr;

    const RADIUS: u32 = 5;

    fn random_map(w: usize, h: usize, seed: u64) -> Plane<f32> {
        let mut rng = Rng::for_stage(seed, "still");
        Plane::from_fn(w, h, |_, _| if rng.uniform() < 0.3 { rng.uniform() as f32 } else { 0.0 })
    }

    /// The affinity that the graph holds for two pixels.
    fn held(graph: &PixelGraph, a: (usize, usize), b: (usize, usize)) -> f32 {
        let (a, b) = if (a.1, a.0) < (b.1, b.0) { (a, b) } else { (b, a) };
        let step = Step { dx: b.0 as isize - a.0 as isize, dy: b.1 - a.1 };
        graph.steps.iter().position(|&s| s == step).map_or(0.0, |k| graph.weights[k][graph.start(a.1) + a.0])
    }

    /// The strength of the strongest crack that touches the segment between two pixel centres, by trying all cracks of
    /// the image.
    fn strongest_between(pb: &Plane<f32>, a: (usize, usize), b: (usize, usize)) -> f32 {
        let (ax, ay, bx, by) = (a.0 as i64, a.1 as i64, b.0 as i64, b.1 as i64);
        // Whether a crack of length 1 around `(2 along, 2 across)` / 2 touches the line, in coordinates along the side
        // it cuts.
        let touches = |from: i64, to: i64, start: i64, end: i64, at: i64, centre: i64| {
            let (run, rise) = (to - from, end - start);
            let inside = (2 * at + 1 - 2 * from) * run.signum() > 0 && (2 * to - 2 * at - 1) * run.signum() > 0;
            // | start + (at + 1/2 - from) rise / run - centre | <= 1/2, times 2 run.
            inside && (2 * run * (start - centre) + (2 * at + 1 - 2 * from) * rise).abs() <= run.abs()
        };
        let mut most = 0.0_f32;
        for y in 0..pb.height() as i64 {
            for x in 0..pb.width() as i64 {
                let at = |x: i64, y: i64| if x < pb.width() as i64 { pb[(x as usize, y as usize)] } else { 0.0 };
                if x > 0 && touches(ax, bx, ay, by, x - 1, y) {
                    most = most.max(at(x, y));
                }
                if y > 0 && touches(ay, by, ax, bx, y - 1, x) {
                    most = most.max(at(x, y)).max(at(x, y - 1).min(at(x + 1, y)));
                }
            }
        }
        most
    }

    #[test]
    fn affinities_equal_those_of_a_search_through_all_cracks() {
        for (w, h) in [(9, 8), (1, 7), (7, 1), (3, 12), (1, 1), (6, 2)] {
            let pb = random_map(w, h, 3);
            let graph = PixelGraph::new(&pb, RADIUS, 0.2);
            for (i, j) in (0..w * h).flat_map(|i| (0..i).map(move |j| (i, j))) {
                let (a, b) = ((i % w, i / w), (j % w, j / w));
                let near = a.0.abs_diff(b.0).pow(2) + a.1.abs_diff(b.1).pow(2) <= 25;
                let expected = if near { libm::expf(-strongest_between(&pb, a, b) / 0.2) } else { 0.0 };
                assert_eq!(held(&graph, a, b), expected, "{a:?} and {b:?} of {w}x{h}");
            }
        }
    }

    #[test]
    fn products_equal_those_of_the_sparse_matrix() {
        for (w, h, radius) in [(13, 9, 5), (1, 20, 5), (20, 1, 3), (4, 4, 1), (3, 3, 10)] {
            let graph = PixelGraph::new(&random_map(w, h, 8), radius, 0.1);
            let n = w * h;
            let mut entries = Vec::new();
            for (i, j) in (0..n).flat_map(|j| (0..j).map(move |i| (i, j))) {
                let weight = held(&graph, (i % w, i / w), (j % w, j / w));
                if weight > 0.0 {
                    entries.push((i as u32, j as u32, weight));
                }
            }
            let matrix = SymCsr::from_upper(n, &entries);
            let scale: Vec<f64> =
                matrix.degrees().iter().map(|&d| if d > 0.0 { 1.0 / d.sqrt() } else { 0.0 }).collect();
            let mut rng = Rng::for_stage(4, "still");
            for columns in [1, 4, 6] {
                let x: Vec<f64> = (0..n * columns).map(|_| rng.range(-1.0, 1.0)).collect();
                let scaled: Vec<f64> = x.iter().enumerate().map(|(e, v)| v * scale[e / columns]).collect();
                let (mut expected, mut found) = (vec![0.0; n * columns], vec![0.0; n * columns]);
                matrix.apply(&scaled, columns, &mut expected);
                graph.apply(&x, columns, &mut found);
                for (e, (f, v)) in found.iter().zip(&expected).enumerate() {
                    assert!((f - v * scale[e / columns]).abs() < 1e-5, "{f} at {e} of {w}x{h}, {columns} columns");
                }
            }
        }
    }

    #[test]
    fn thin_diagonal_lines_do_not_leak() {
        let pb = Plane::from_fn(12, 12, |x, y| if x == y { 0.8 } else { 0.0 });
        let graph = PixelGraph::new(&pb, RADIUS, 0.1);
        for (x, y) in (0..12).flat_map(|y| (0..12).map(move |x| (x, y))).filter(|(x, y)| x < y) {
            for (dx, dy) in [(1, 0), (0, -1), (1, -1), (2, -1)] {
                let (u, v) = (x as isize + dx, y as isize + dy);
                if (0..12).contains(&u) && (0..12).contains(&v) && u > v {
                    assert!(held(&graph, (x, y), (u as usize, v as usize)) < 0.01, "{x}, {y} to {u}, {v}");
                }
            }
        }
    }
}
