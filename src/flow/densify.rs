//! From patches to pixels: each pixel takes the mean of the patches over it, the well-matching ones counting more.

use super::field::FlowField;
use super::patch::{PatchGrid, blend, chunk, place};
use super::pyramid::{Level, PAD};

/// Differences in brightness below this (grey levels) all count the same: they are noise.
const LEAST_DIFFERENCE: f32 = 1.0;

/// Sums over the patches that cover a pixel, padded because patches hang over the border.
#[derive(Debug, Clone, Default)]
pub(super) struct Votes {
    u: Vec<f32>,
    v: Vec<f32>,
    weight: Vec<f32>,
}

/// The mean displacement at every pixel, each patch weighted by `1 / max(1, difference)²` at that pixel (DIS: not
/// squared).
///
/// `S` is the side of a patch. The grid covers the level, so every pixel has a weight.
pub(super) fn densify<const S: usize>(
    from: &Level,
    to: &Level,
    grid: &PatchGrid,
    votes: &mut Votes,
    flow: &mut FlowField,
) {
    for sums in [&mut votes.u, &mut votes.v, &mut votes.weight] {
        sums.clear();
        sums.resize(from.image.data().len(), 0.0);
    }
    for patch in 0..grid.u.len() {
        vote::<S>(from, to, grid, patch, votes);
    }
    for y in 0..from.image.height {
        let row = (y + PAD) * from.image.stride + PAD..;
        let weight = &votes.weight[row.clone()];
        for (out, sums) in [(&mut flow.u, &votes.u[row.clone()]), (&mut flow.v, &votes.v[row.clone()])] {
            for ((value, sum), weight) in out.row_mut(y).iter_mut().zip(sums).zip(weight) {
                *value = sum / weight;
            }
        }
    }
}

/// Adds one patch to the sums.
#[inline(always)]
fn vote<const S: usize>(from: &Level, to: &Level, grid: &PatchGrid, patch: usize, votes: &mut Votes) {
    let (u, v) = (grid.u[patch], grid.v[patch]);
    let corner = grid.corner(patch);
    let (x, fx) = place(corner.0 as f32 + u, to.image.width, S);
    let (y, fy) = place(corner.1 as f32 + v, to.image.height, S);
    let (source, target, stride) = (from.image.index(corner.0, corner.1), to.image.index(x, y), to.image.stride);
    let mut upper = blend::<S>(to.image.data(), target, fx);
    for k in 0..S {
        let lower = blend::<S>(to.image.data(), target + (k + 1) * stride, fx);
        let here = chunk::<S>(from.image.data(), source + k * stride);
        let mut weight = [0.0_f32; S];
        for i in 0..S {
            let difference = (upper[i] + fy * (lower[i] - upper[i]) - here[i]).abs();
            let difference = if difference > LEAST_DIFFERENCE { difference } else { LEAST_DIFFERENCE };
            weight[i] = 1.0 / (difference * difference);
        }
        add_scaled(&mut votes.u, source + k * stride, &weight, u);
        add_scaled(&mut votes.v, source + k * stride, &weight, v);
        add_scaled(&mut votes.weight, source + k * stride, &weight, 1.0);
        upper = lower;
    }
}

#[inline(always)]
fn add_scaled<const S: usize>(sums: &mut [f32], start: usize, weight: &[f32; S], value: f32) {
    let sums = &mut sums[start..start + S];
    for i in 0..S {
        sums[i] += weight[i] * value;
    }
}
