//! The graph of an image's pixels: affinities by intervening contours, stored as one plane for each offset to a neighbour.
//!
//! Pixels at most `r` apart have the affinity `exp(-max Pb / σ)`, the maximum over the boundaries that the line between them
//! crosses. A boundary lies between pixels: a pixel of the thin map is assigned to the cracks to its left and above it, so
//! that each pixel is on one side. As `exp` is monotone, the maximum of Pb is the minimum of `exp(-Pb / σ)`, which is
//! computed once a pixel, not once a pair. Where a line crosses a corner, all four cracks around it count: thin lines must
//! not leak where they run diagonally.
//!
//! As a matrix the graph would have 80 entries a pixel at `r = 5`, each with its column. As planes, one for each of the 40
//! offsets to the right or down, it needs half of the entries and no columns, and a product is a sum of shifted rows.

use super::StillParams;
use crate::embedding::{EigenInfo, EigenParams, Eigenpairs, SymmetricOperator, largest_eigenpairs, refine_eigenpairs};
use crate::image::Plane;
use std::cell::RefCell;

/// The symmetric, normalised affinities `N = D^-1/2 W D^-1/2` of the pixels of an image.
#[derive(Debug, Clone)]
pub(super) struct PixelGraph {
    width: usize,
    height: usize,
    /// Number of zeros on either side of a row, and of rows of zeros above and below: the radius.
    margin: usize,
    offsets: Vec<PixelOffset>,
    /// For each offset a padded plane of the weights to the neighbours there, 0 where the neighbour lies outside.
    weights: Vec<Vec<f32>>,
    /// `d^-1/2` of each pixel, 0 for one without neighbours.
    pub(super) scale: Vec<f32>,
    /// Scratch: padded planes of the vectors of a block.
    padded: RefCell<Vec<f32>>,
}

/// The offset from a pixel to one on its right or below it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct PixelOffset {
    dx: isize,
    dy: usize,
}

/// A crack that a line crosses, between pixel `(x, y)`, relative to the line's start, and the one to its right or below.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Crack {
    x: isize,
    y: usize,
    is_below: bool,
}

/// Number of vectors multiplied together, as in the panels of the eigensolver.
const BLOCK_VECTORS: usize = 4;

impl PixelGraph {
    /// Builds the graph over the boundary strengths `pb` with radius `radius` in pixels and scale `sigma`.
    pub(super) fn new(pb: &Plane<f32>, radius: u32, sigma: f32) -> Self {
        let (width, height, margin) = (pb.width(), pb.height(), radius as usize);
        let cracks = CrackAffinities::new(pb, sigma);
        let mut graph = Self {
            width,
            height,
            margin,
            offsets: half_disc(radius),
            weights: Vec::new(),
            scale: Vec::new(),
            padded: RefCell::default(),
        };
        graph.weights = graph.offsets.iter().map(|&o| graph.weight_plane(o, &cracks)).collect();
        graph.scale = graph.degrees().iter().map(|&d| if d > 0.0 { 1.0 / d.sqrt() } else { 0.0 }).collect();
        graph
    }

    fn stride(&self) -> usize {
        self.width + 2 * self.margin
    }

    /// Returns the index of row `y` in a padded plane.
    fn start(&self, y: usize) -> usize {
        (y + self.margin) * self.stride() + self.margin
    }

    /// Returns the columns from which `offset` stays inside a row.
    fn columns_inside(&self, offset: PixelOffset) -> std::ops::Range<usize> {
        let begin = offset.dx.min(0).unsigned_abs().min(self.width);
        let end = self.width.saturating_sub(offset.dx.max(0) as usize);
        begin..end.max(begin)
    }

    /// Computes the padded plane of weights for `offset`.
    fn weight_plane(&self, offset: PixelOffset, cracks: &CrackAffinities) -> Vec<f32> {
        let mut plane = vec![0.0; self.stride() * (self.height + 2 * self.margin)];
        let range = self.columns_inside(offset);
        if range.is_empty() {
            return plane;
        }
        for y in 0..self.height.saturating_sub(offset.dy) {
            let row = &mut plane[self.start(y)..][range.clone()];
            row.fill(1.0);
            for crack in cracks_on(offset) {
                let from = (range.start as isize + crack.x) as usize;
                let source = &cracks.plane(crack.is_below)[(y + crack.y) * self.width + from..][..row.len()];
                for (w, &c) in row.iter_mut().zip(source) {
                    *w = if c < *w { c } else { *w };
                }
            }
        }
        plane
    }

    /// Computes the sum of each pixel's affinities.
    fn degrees(&self) -> Vec<f32> {
        let mut degrees = vec![0.0; self.width * self.height];
        let mut ones = vec![0.0; self.stride() * (self.height + 2 * self.margin)];
        self.spread(std::iter::repeat(1.0), &mut ones);
        for (y, row) in degrees.chunks_exact_mut(self.width.max(1)).enumerate() {
            self.gather(&ones, y, row);
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

    /// Computes row `y` of `out = W x` for a padded plane `x`, from the neighbours at each offset and at its opposite.
    fn gather(&self, x: &[f32], y: usize, out: &mut [f32]) {
        out.fill(0.0);
        let (n, start) = (self.width, self.start(y) as isize);
        let slice = |plane: &'_ [f32], at: isize| -> std::ops::Range<usize> {
            debug_assert!(at as usize + n <= plane.len());
            at as usize..at as usize + n
        };
        let shift = |s: PixelOffset| s.dy as isize * self.stride() as isize + s.dx;
        for (offsets, weights) in self.offsets.chunks_exact(2).zip(self.weights.chunks_exact(2)) {
            let (p, q) = (shift(offsets[0]), shift(offsets[1]));
            let (wp, wq) = (&weights[0], &weights[1]);
            let (w0, x0) = (&wp[slice(wp, start)], &x[slice(x, start + p)]);
            let (w1, x1) = (&wp[slice(wp, start - p)], &x[slice(x, start - p)]);
            let (w2, x2) = (&wq[slice(wq, start)], &x[slice(x, start + q)]);
            let (w3, x3) = (&wq[slice(wq, start - q)], &x[slice(x, start - q)]);
            let (w1, x1, w2, x2, w3, x3) = (&w1[..n], &x1[..n], &w2[..n], &x2[..n], &w3[..n], &x3[..n]);
            let (w0, x0, out) = (&w0[..n], &x0[..n], &mut out[..n]);
            for i in 0..n {
                out[i] += (w0[i] * x0[i] + w1[i] * x1[i]) + (w2[i] * x2[i] + w3[i] * x3[i]);
            }
        }
        if let ([offset], [w]) = (self.offsets.as_chunks::<2>().1, self.weights.as_chunks::<2>().1) {
            let s = shift(*offset);
            let (w0, x0) = (&w[slice(w, start)], &x[slice(x, start + s)]);
            let (w1, x1) = (&w[slice(w, start - s)], &x[slice(x, start - s)]);
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
        padded.resize(size * BLOCK_VECTORS, 0.0);
        let mut sums = vec![0.0; self.width];
        for first in (0..columns).step_by(BLOCK_VECTORS) {
            let count = BLOCK_VECTORS.min(columns - first);
            for (c, plane) in padded.chunks_exact_mut(size).take(count).enumerate() {
                let column = x.iter().skip(first + c).step_by(columns);
                self.spread(column.zip(&self.scale).map(|(&v, &s)| v as f32 * s), plane);
            }
            // Row by row for all vectors, so that a row's weights stay in the cache.
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

/// Returns the offsets of length at most `radius`, one of each pair of opposite ones.
fn half_disc(radius: u32) -> Vec<PixelOffset> {
    let r = radius as isize;
    let half = (0..=r).flat_map(|dy| (-r..=r).map(move |dx| (dx, dy)));
    half.filter(|&(dx, dy)| (dy > 0 || dx > 0) && dx * dx + dy * dy <= r * r)
        .map(|(dx, dy)| PixelOffset { dx, dy: dy as usize })
        .collect()
}

/// Returns the cracks that the line to the pixel at `offset` crosses.
///
/// The line crosses the middle between columns `k` and `k + 1` at row `(2 k + 1) dy / (2 |dx|)`, which is a corner if this is
/// half an odd number; likewise between rows. In integers, so that nothing depends on rounding.
fn cracks_on(offset: PixelOffset) -> Vec<Crack> {
    let (across, down, side) = (offset.dx.unsigned_abs(), offset.dy, offset.dx.signum());
    // The crack between columns k and k + 1 of the line, mirrored if it goes to the left.
    let right =
        |k: usize, y: usize| Crack { x: if side >= 0 { k as isize } else { -(k as isize) - 1 }, y, is_below: false };
    let below = |x: usize, k: usize| Crack { x: side * x as isize, y: k, is_below: true };
    let mut cracks = Vec::new();
    for k in 0..across {
        let (y, is_corner) = nearest((2 * k + 1) * down, 2 * across);
        cracks.push(right(k, y));
        if is_corner {
            cracks.extend([right(k, y + 1), below(k, y), below(k + 1, y)]);
        }
    }
    for k in 0..down {
        let (x, is_corner) = nearest((2 * k + 1) * across, 2 * down);
        if !is_corner {
            cracks.push(below(x, k));
        }
    }
    cracks
}

/// Rounds `a / b` to the nearest integer, halves down; returns also true for a half.
fn nearest(a: usize, b: usize) -> (usize, bool) {
    let remainder = a % b;
    (a / b + usize::from(2 * remainder > b), 2 * remainder == b)
}

/// `exp(-Pb / σ)` on the cracks to the right of each pixel and below it; 1 on the frame border.
///
/// ```text
///   ┌──      The cracks of neighbouring pixels on a thin line connect, except from a pixel to its lower right neighbour:
///   │ ┌──    there the crack below the upper pixel closes the gap.
///     │
/// ```
struct CrackAffinities {
    right: Vec<f32>,
    below: Vec<f32>,
}

impl CrackAffinities {
    fn new(pb: &Plane<f32>, sigma: f32) -> Self {
        let (w, h) = (pb.width(), pb.height());
        let affinity: Vec<f32> = pb.data().iter().map(|&v| libm::expf(-v / sigma)).collect();
        let mut right = vec![1.0; w * h];
        let mut below = vec![1.0; w * h];
        for y in 0..h {
            right[y * w..][..w - 1].copy_from_slice(&affinity[y * w + 1..][..w - 1]);
        }
        below[..(h - 1) * w].copy_from_slice(&affinity[w..]);
        for y in 1..h {
            let (upper, lower) = (&affinity[(y - 1) * w..][..w], &affinity[y * w..][..w]);
            for ((crack, &a), &b) in below[(y - 1) * w..].iter_mut().zip(upper).zip(&lower[1..]) {
                *crack = crack.min(a.max(b));
            }
        }
        Self { right, below }
    }

    fn plane(&self, is_below: bool) -> &[f32] {
        if is_below { &self.below } else { &self.right }
    }
}

// Leading eigenvectors of an image's pixel graph, from coarse to fine.
//
// Eigenvalues of such graphs are crowded below 1, and more so in larger images. So the image is halved until it is small and
// solved by block Lanczos; each finer level starts from the coarser one's vectors, doubled in size, and corrects them at
// contours by a Chebyshev filter.

/// Most pixels of the coarsest level. Chosen by eye.
const MAX_COARSEST_PIXELS: usize = 12_000;
/// Degree of the filter: products with each eigenvector on the finer levels. Higher is slower and more exact (measured: twice
/// as many change F by 0.002, see the module's limits).
const FILTER_DEGREE: u32 = 10;
/// Residual at which an eigenpair of the coarsest level counts as converged. Chosen by eye. Lower is slower.
const COARSEST_TOLERANCE: f64 = 1e-3;
/// Largest number of products with one vector on the coarsest level. Chosen by eye.
const MAX_COARSEST_PRODUCTS: f64 = 4000.0;
/// Largest number of multiplications on the coarsest level: about two seconds.
const MAX_COARSEST_WORK: f64 = 8e9;
/// Multiplications per pixel and product for orthogonalisation, estimated as in `embedding`.
const BASIS_WORK_PER_PIXEL: f64 = 300.0;

/// Leading eigenvectors of `P = D^-1 W`.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct PixelEmbedding {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Eigenvalues, largest first.
    pub(super) eigenvalues: Vec<f64>,
    /// `V = D^-1/2 U`, so that `Vᵀ D V = 1`; a plane for each eigenvalue.
    pub(super) vectors: Vec<Vec<f32>>,
    pub(super) info: EigenInfo,
}

/// Embeds the pixels of an image with the thin boundary strengths `pb`.
pub(super) fn embed_pixels(pb: &Plane<f32>, params: &StillParams, seed: u32) -> PixelEmbedding {
    if pb.width() * pb.height() <= MAX_COARSEST_PIXELS {
        return solve(pb, params, seed);
    }
    let coarse = embed_pixels(&halve(pb), params, seed);
    refine(pb, &coarse, params)
}

fn solve(pb: &Plane<f32>, params: &StillParams, seed: u32) -> PixelEmbedding {
    let graph = PixelGraph::new(pb, params.radius, params.sigma);
    let settings =
        EigenParams { tolerance: COARSEST_TOLERANCE, max_products: max_products(&graph), multiplicity: 0, seed };
    let pairs = largest_eigenpairs(&graph, params.dimensions as usize, &settings);
    to_embedding(&graph, pairs)
}

/// Limits the number of products by their cost, which grows with the radius.
fn max_products(graph: &PixelGraph) -> u32 {
    let neighbours = 2 * graph.offsets.len();
    let work_per_product = (neighbours as f64 + BASIS_WORK_PER_PIXEL) * graph.scale.len() as f64;
    (MAX_COARSEST_WORK / work_per_product).min(MAX_COARSEST_PRODUCTS) as u32
}

fn refine(pb: &Plane<f32>, coarse: &PixelEmbedding, params: &StillParams) -> PixelEmbedding {
    let graph = PixelGraph::new(pb, params.radius, params.sigma);
    let mut start = Vec::with_capacity(pb.data().len() * coarse.vectors.len());
    for vector in &coarse.vectors {
        let large = double(vector, coarse.width, pb.width(), pb.height());
        // U = D^1/2 V.
        start.extend(large.iter().zip(&graph.scale).map(|(v, &s)| if s > 0.0 { f64::from(v / s) } else { 0.0 }));
    }
    match refine_eigenpairs(&graph, start, FILTER_DEGREE, COARSEST_TOLERANCE) {
        Some(pairs) => to_embedding(&graph, pairs),
        None => PixelEmbedding { width: pb.width(), height: pb.height(), ..PixelEmbedding::default() },
    }
}

/// Converts eigenvectors of N, row by row, to planes of eigenvectors of P.
fn to_embedding(graph: &PixelGraph, pairs: Eigenpairs) -> PixelEmbedding {
    let k = pairs.values.len();
    let plane = |c: usize| -> Vec<f32> {
        pairs.vectors.iter().skip(c).step_by(k).zip(&graph.scale).map(|(&u, &s)| u as f32 * s).collect()
    };
    let vectors = (0..k).map(plane).collect();
    PixelEmbedding { width: graph.width, height: graph.height, eigenvalues: pairs.values, vectors, info: pairs.info }
}

/// Halves a plane by the maximum of 2×2 pixels.
fn halve(pb: &Plane<f32>) -> Plane<f32> {
    let (w, h) = (pb.width(), pb.height());
    Plane::from_fn(w.div_ceil(2), h.div_ceil(2), |x, y| {
        let (x1, y1) = ((2 * x + 1).min(w - 1), (2 * y + 1).min(h - 1));
        pb[(2 * x, 2 * y)].max(pb[(x1, 2 * y)]).max(pb[(2 * x, y1)]).max(pb[(x1, y1)])
    })
}

/// Doubles a plane of `small_width` columns to `w × h` pixels by repeating pixels.
fn double(small: &[f32], small_width: usize, w: usize, h: usize) -> Vec<f32> {
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

    /// Returns the affinity of two pixels in the graph.
    fn affinity(graph: &PixelGraph, a: (usize, usize), b: (usize, usize)) -> f32 {
        let (a, b) = if (a.1, a.0) < (b.1, b.0) { (a, b) } else { (b, a) };
        let offset = PixelOffset { dx: b.0 as isize - a.0 as isize, dy: b.1 - a.1 };
        graph.offsets.iter().position(|&o| o == offset).map_or(0.0, |k| graph.weights[k][graph.start(a.1) + a.0])
    }

    /// Finds the strength of the strongest crack that touches the segment between two pixel centres, by trying all cracks.
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
                assert_eq!(affinity(&graph, a, b), expected, "{a:?} and {b:?} of {w}x{h}");
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
                let weight = affinity(&graph, (i % w, i / w), (j % w, j / w));
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
                    assert!(affinity(&graph, (x, y), (u as usize, v as usize)) < 0.01, "{x}, {y} to {u}, {v}");
                }
            }
        }
    }
}
