//! Discontinuities of a pixel embedding: `d` between the four neighbours of each pixel, and what it says of the pixels
//! themselves.
//!
//! `d_ij = 1 − Ŵ_ij / max(δ_i, δ_j)` belongs to the crack between two pixels. To a pixel, the greater `d` of the cracks
//! to its left and right says how much the embedding changes across, the greater `d` above and below how much it
//! changes downwards; the gradient of the eigenvectors says whether both go the same way. Together these are a tensor, and the
//! change along a direction is the root of its quadratic form: with one eigenvector the size of a slope, relative to
//! the density there.

use crate::contour::{ORIENTATIONS, normals};
use crate::discontinuity::discontinuity;

/// `d` of the cracks to the right of each pixel and below it; 0 on those to the outside.
///
/// Law: both have one value for each pixel, row by row, in `0.0..=1.0`.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Cracks {
    pub(super) right: Vec<f32>,
    pub(super) below: Vec<f32>,
}

/// A part of an embedding: these eigenvectors, and their slopes.
pub(super) struct Part<'a> {
    pub(super) width: usize,
    pub(super) eigenvalues: &'a [f64],
    pub(super) vectors: &'a [&'a [f32]],
}

/// `d` between all neighbours, by the embedding affinities `Ŵ = V Λ Vᵀ`.
pub(super) fn cracks(part: &Part) -> Cracks {
    let (w, n) = (part.width, part.vectors.first().map_or(0, |v| v.len()));
    let (mut right, mut below) = (vec![0.0_f32; n], vec![0.0_f32; n]);
    for (v, &lambda) in part.vectors.iter().zip(part.eigenvalues) {
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
    Cracks { right, below }
}

/// `δ`: the greatest affinity of each pixel to its neighbours.
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

/// Slopes of a plane of `width` columns by central differences, to the right and downwards.
pub(super) struct Slopes {
    pub(super) x: Vec<f32>,
    pub(super) y: Vec<f32>,
}

impl Slopes {
    pub(super) fn of(plane: &[f32], width: usize) -> Self {
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

/// Sums of products of slopes: how far the changes to the right and downwards go together.
pub(super) struct Products {
    xx: Vec<f32>,
    xy: Vec<f32>,
    yy: Vec<f32>,
}

impl Products {
    pub(super) fn zero(n: usize) -> Self {
        Self { xx: vec![0.0; n], xy: vec![0.0; n], yy: vec![0.0; n] }
    }

    pub(super) fn add(&mut self, slopes: &Slopes, weight: f32) {
        let sums = self.xx.iter_mut().zip(&mut self.xy).zip(&mut self.yy);
        for (((xx, xy), yy), (x, y)) in sums.zip(slopes.x.iter().zip(&slopes.y)) {
            *xx += weight * x * x;
            *xy += weight * x * y;
            *yy += weight * y * y;
        }
    }
}

/// Adds `weight` times the root of the change of `d` along each direction.
pub(super) fn add_change(
    cracks: &Cracks,
    products: &Products,
    width: usize,
    weight: f32,
    out: &mut [Vec<f32>; ORIENTATIONS],
) {
    let n = cracks.right.len();
    let (mut across, mut down, mut both) = (cracks.right.clone(), cracks.below.clone(), vec![0.0; n]);
    for (row, d) in across.chunks_exact_mut(width).zip(cracks.right.chunks_exact(width)) {
        row[1..].iter_mut().zip(d).for_each(|(o, &left)| *o = o.max(left));
    }
    down[width.min(n)..].iter_mut().zip(&cracks.below).for_each(|(o, &above)| *o = o.max(above));
    for i in 0..n {
        let scale = (products.xx[i] * products.yy[i]).sqrt();
        let correlation = if scale > 0.0 { (products.xy[i] / scale).clamp(-1.0, 1.0) } else { 0.0 };
        both[i] = correlation * (across[i] * down[i]).sqrt();
    }
    for (plane, (nx, ny)) in out.iter_mut().zip(normals()) {
        let (a, b, c) = (nx * nx, 2.0 * nx * ny, ny * ny);
        for (((o, x), xy), y) in plane.iter_mut().zip(&across).zip(&both).zip(&down) {
            *o += weight * (a * x + b * xy + c * y).max(0.0).sqrt();
        }
    }
}
