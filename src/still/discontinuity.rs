//! Changes of a pixel embedding along each direction: the roots of its discontinuities, and gradients of its eigenvectors.
//!
//! `d_ij = 1 − Ŵ_ij / max(δ_i, δ_j)` belongs to the crack between two pixels. The larger `d` of the cracks left and right of
//! a pixel measures the horizontal change of the embedding, the larger `d` above and below the vertical one, and the
//! correlation of the eigenvectors' slopes tells whether both have the same sign. Together they are a tensor `T`, and the
//! change along a normal `n` is `sqrt(nᵀ T n)`: with one eigenvector the length of a slope, relative to the density.

use super::Grouping;
use super::graph::PixelEmbedding;
use crate::contour::{ORIENTATIONS, mean_along_boundary, normals};
use crate::discontinuity::discontinuity;
use crate::image::{Plane, gaussian_blur};

/// Standard deviation of the blur before gradients are taken, in pixels (Arbelaez et al., PAMI 2011: 1).
const GRADIENT_SIGMA_PX: f32 = 1.0;
/// Smallest `1 - λ` in the weights of eigenvectors, which would grow without bound. Chosen by eye.
const MIN_EIGENVALUE_GAP: f64 = 1e-6;

/// Changes of an embedding along each direction.
pub(super) struct Changes {
    /// Roots of `d`, `0.0..=1.0`.
    pub(super) d: [Vec<f32>; ORIENTATIONS],
    /// Weighted gradients of the eigenvectors.
    pub(super) spectral: [Vec<f32>; ORIENTATIONS],
}

/// Computes the changes of `embedding`, averaged along boundaries.
pub(super) fn changes(embedding: &PixelEmbedding, grouping: Grouping) -> Changes {
    let PixelEmbedding { width, height, eigenvalues, vectors, .. } = embedding;
    let n = width * height;
    let zeros = || std::array::from_fn(|_| vec![0.0_f32; n]);
    let mut changes = Changes { d: zeros(), spectral: zeros() };
    let weights = eigenvector_weights(eigenvalues);
    let total_weight: f32 = weights.iter().sum();
    let mut joint_products = SlopeProducts::zero(n);
    for (k, vector) in vectors.iter().enumerate() {
        let slopes = smooth_slopes(vector, *width);
        joint_products.add(&slopes, eigenvalues[k] as f32);
        if k == 0 {
            continue;
        }
        add_gradient(&slopes, weights[k - 1] / root_mean_square(vector), &mut changes.spectral);
        if grouping == Grouping::Single {
            let mut products = SlopeProducts::zero(n);
            products.add(&slopes, 1.0);
            let pair = [vectors[0].as_slice(), vector.as_slice()];
            let d = crack_discontinuities(&pair, &[eigenvalues[0], eigenvalues[k]], *width);
            add_change(&d, &products, *width, weights[k - 1] / total_weight, &mut changes.d);
        }
    }
    if grouping == Grouping::Joint && vectors.len() > 1 {
        let vectors: Vec<&[f32]> = vectors.iter().map(Vec::as_slice).collect();
        let d = crack_discontinuities(&vectors, eigenvalues, *width);
        add_change(&d, &joint_products, *width, 1.0, &mut changes.d);
    }
    for planes in [&mut changes.d, &mut changes.spectral] {
        for (plane, normal) in planes.iter_mut().zip(normals()) {
            *plane = mean_along_boundary(plane, *width, normal, 1.0);
        }
    }
    changes
}

/// Returns `1 / sqrt(1 - λ)` of all eigenvalues but the first.
fn eigenvector_weights(eigenvalues: &[f64]) -> Vec<f32> {
    eigenvalues.iter().skip(1).map(|l| 1.0 / (1.0 - l).max(MIN_EIGENVALUE_GAP).sqrt() as f32).collect()
}

fn smooth_slopes(vector: &[f32], width: usize) -> PlaneSlopes {
    let plane = Plane::from_vec(width, vector.len() / width, vector.to_vec()).unwrap_or_default();
    PlaneSlopes::new(gaussian_blur(&plane, GRADIENT_SIGMA_PX).data(), width)
}

fn root_mean_square(vector: &[f32]) -> f32 {
    let sum: f64 = vector.iter().map(|&v| f64::from(v) * f64::from(v)).sum();
    ((sum / vector.len().max(1) as f64).sqrt() as f32).max(f32::MIN_POSITIVE)
}

/// Adds `weight` times the absolute slope along each direction.
fn add_gradient(slopes: &PlaneSlopes, weight: f32, out: &mut [Vec<f32>; ORIENTATIONS]) {
    for (plane, (nx, ny)) in out.iter_mut().zip(normals()) {
        for ((o, x), y) in plane.iter_mut().zip(&slopes.x).zip(&slopes.y) {
            *o += weight * (nx * x + ny * y).abs();
        }
    }
}

/// `d` of the cracks to the right of each pixel and below it, one value a pixel in `0.0..=1.0`; 0 on the frame border.
struct CrackDiscontinuities {
    right: Vec<f32>,
    below: Vec<f32>,
}

/// Computes `d` between all neighbours from the embedding affinities `Ŵ = V Λ Vᵀ` of these eigenvectors.
fn crack_discontinuities(vectors: &[&[f32]], eigenvalues: &[f64], w: usize) -> CrackDiscontinuities {
    let n = vectors.first().map_or(0, |v| v.len());
    let (mut right, mut below) = (vec![0.0_f32; n], vec![0.0_f32; n]);
    for (v, &lambda) in vectors.iter().zip(eigenvalues) {
        let lambda = lambda as f32;
        for (sums, v) in right.chunks_exact_mut(w).zip(v.chunks_exact(w)) {
            for (s, pair) in sums.iter_mut().zip(v.windows(2)) {
                *s += lambda * pair[0] * pair[1];
            }
        }
        for ((s, a), b) in below.iter_mut().zip(*v).zip(&v[w..]) {
            *s += lambda * a * b;
        }
    }
    let density = densities(&right, &below, w);
    for (sums, density) in right.chunks_exact_mut(w).zip(density.chunks_exact(w)) {
        for (s, pair) in sums.iter_mut().zip(density.windows(2)) {
            *s = discontinuity(*s, pair[0].max(pair[1]));
        }
    }
    for ((s, a), b) in below.iter_mut().zip(&density).zip(&density[w..]) {
        *s = discontinuity(*s, a.max(*b));
    }
    CrackDiscontinuities { right, below }
}

/// Computes `δ`, the largest affinity of each pixel to its neighbours.
fn densities(right: &[f32], below: &[f32], w: usize) -> Vec<f32> {
    let mut density = vec![0.0_f32; right.len()];
    for (row, affinity) in density.chunks_exact_mut(w).zip(right.chunks_exact(w)) {
        for (x, &a) in affinity[..w - 1].iter().enumerate() {
            row[x] = row[x].max(a);
            row[x + 1] = row[x + 1].max(a);
        }
    }
    let n = density.len();
    for (i, &a) in below[..n.saturating_sub(w)].iter().enumerate() {
        density[i] = density[i].max(a);
        density[i + w] = density[i + w].max(a);
    }
    density
}

/// The gradient of a plane.
struct PlaneSlopes {
    x: Vec<f32>,
    y: Vec<f32>,
}

impl PlaneSlopes {
    /// Differentiates a plane of `width` columns by central differences.
    fn new(plane: &[f32], width: usize) -> Self {
        let height = plane.len() / width;
        let mut slopes = Self { x: vec![0.0; plane.len()], y: vec![0.0; plane.len()] };
        for (out, row) in slopes.x.chunks_exact_mut(width).zip(plane.chunks_exact(width)) {
            for x in 0..width {
                out[x] = 0.5 * (row[(x + 1).min(width - 1)] - row[x.saturating_sub(1)]);
            }
        }
        for (y, out) in slopes.y.chunks_exact_mut(width).enumerate() {
            let (above, below) = (y.saturating_sub(1) * width, (y + 1).min(height - 1) * width);
            for ((o, a), b) in out.iter_mut().zip(&plane[above..]).zip(&plane[below..]) {
                *o = 0.5 * (b - a);
            }
        }
        slopes
    }
}

/// Weighted sums of products of slopes: a structure tensor without smoothing.
struct SlopeProducts {
    xx: Vec<f32>,
    xy: Vec<f32>,
    yy: Vec<f32>,
}

impl SlopeProducts {
    fn zero(n: usize) -> Self {
        Self { xx: vec![0.0; n], xy: vec![0.0; n], yy: vec![0.0; n] }
    }

    fn add(&mut self, slopes: &PlaneSlopes, weight: f32) {
        let sums = self.xx.iter_mut().zip(&mut self.xy).zip(&mut self.yy);
        for (((xx, xy), yy), (x, y)) in sums.zip(slopes.x.iter().zip(&slopes.y)) {
            *xx += weight * x * x;
            *xy += weight * x * y;
            *yy += weight * y * y;
        }
    }
}

/// Adds `weight` times the root of the quadratic form of `d` along each direction.
fn add_change(
    d: &CrackDiscontinuities,
    products: &SlopeProducts,
    width: usize,
    weight: f32,
    out: &mut [Vec<f32>; ORIENTATIONS],
) {
    let n = d.right.len();
    let (mut across, mut down, mut mixed) = (d.right.clone(), d.below.clone(), vec![0.0; n]);
    for (row, d) in across.chunks_exact_mut(width).zip(d.right.chunks_exact(width)) {
        row[1..].iter_mut().zip(d).for_each(|(o, &d_left)| *o = o.max(d_left));
    }
    down[width.min(n)..].iter_mut().zip(&d.below).for_each(|(o, &d_above)| *o = o.max(d_above));
    for i in 0..n {
        let scale = (products.xx[i] * products.yy[i]).sqrt();
        let correlation = if scale > 0.0 { (products.xy[i] / scale).clamp(-1.0, 1.0) } else { 0.0 };
        mixed[i] = correlation * (across[i] * down[i]).sqrt();
    }
    for (plane, (nx, ny)) in out.iter_mut().zip(normals()) {
        let (a, b, c) = (nx * nx, 2.0 * nx * ny, ny * ny);
        for (((o, x), xy), y) in plane.iter_mut().zip(&across).zip(&mixed).zip(&down) {
            *o += weight * (a * x + b * xy + c * y).max(0.0).sqrt();
        }
    }
}
