//! From patches to pixels: each pixel takes the mean of the patches over it, the well-matching ones counting more.

use super::patch::{PatchGrid, place};
use super::pyramid::{Level, PAD};
use crate::image::Plane;

/// Differences in brightness below this (grey levels) all count the same.
const LEAST_DIFFERENCE: f32 = 1.0;

/// Sums over the patches that cover a pixel, padded because patches hang over the border.
#[derive(Debug, Clone, Default)]
pub(super) struct Votes {
    u: Vec<f32>,
    v: Vec<f32>,
    weight: Vec<f32>,
}

/// The mean displacement at every pixel, each patch weighted by `1 / max(1, |difference|)` at that pixel.
pub(super) fn densify(
    from: &Level,
    to: &Level,
    grid: &PatchGrid,
    votes: &mut Votes,
    flow: (&mut Plane<f32>, &mut Plane<f32>),
) {
    let (width, height, stride) = (from.image.width, from.image.height, from.image.stride);
    for sums in [&mut votes.u, &mut votes.v, &mut votes.weight] {
        sums.clear();
        sums.resize(from.image.data().len(), 0.0);
    }
    for row in 0..grid.down {
        for column in 0..grid.across {
            if grid.side == 8 {
                vote(from, to, grid, (column, row), votes, 8);
            } else {
                vote(from, to, grid, (column, row), votes, grid.side);
            }
        }
    }
    for y in 0..height {
        let start = (y + PAD) * stride + PAD;
        let weight = &votes.weight[start..][..width];
        for (out, sums) in [(&mut *flow.0, &votes.u), (&mut *flow.1, &votes.v)] {
            for ((value, sum), weight) in out.row_mut(y).iter_mut().zip(&sums[start..][..width]).zip(weight) {
                *value = sum / weight;
            }
        }
    }
}

#[inline(always)]
fn vote(from: &Level, to: &Level, grid: &PatchGrid, (column, row): (usize, usize), votes: &mut Votes, side: usize) {
    let patch = row * grid.across + column;
    let (u, v) = (grid.u[patch], grid.v[patch]);
    let corner = grid.corner(column, row);
    let (x, fx) = place(corner.0 as f32 + u, to.image.width, side);
    let (y, fy) = place(corner.1 as f32 + v, to.image.height, side);
    let (source, target) = (from.image.index(corner.0, corner.1), to.image.index(x, y));
    let stride = to.image.stride;
    for k in 0..side {
        let here = &from.image.data()[source + k * stride..][..side];
        let upper = &to.image.data()[target + k * stride..][..side + 1];
        let lower = &to.image.data()[target + (k + 1) * stride..][..side + 1];
        let sums_u = &mut votes.u[source + k * stride..][..side];
        let sums_v = &mut votes.v[source + k * stride..][..side];
        let sums_w = &mut votes.weight[source + k * stride..][..side];
        for i in 0..side {
            let above = upper[i] + fx * (upper[i + 1] - upper[i]);
            let below = lower[i] + fx * (lower[i + 1] - lower[i]);
            let difference = (above + fy * (below - above) - here[i]).abs();
            let weight = 1.0 / if difference > LEAST_DIFFERENCE { difference } else { LEAST_DIFFERENCE };
            sums_u[i] += weight * u;
            sums_v[i] += weight * v;
            sums_w[i] += weight;
        }
    }
}
