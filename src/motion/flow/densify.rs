//! From patches to pixels: each pixel takes the mean of the patches over it, the well-matching ones counting more.

use super::field::FlowField;
use super::params::PATCH_SIDE as SIDE;
use super::patch::{Between, PatchGrid, eight, place};
use super::pyramid::{Level, PAD};
use wide::{CmpGt, f32x8};

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
/// The grid covers the level, so every pixel has a weight.
pub(super) fn densify(from: &Level, to: &Level, grid: &PatchGrid, votes: &mut Votes, flow: &mut FlowField) {
    for sums in [&mut votes.u, &mut votes.v, &mut votes.weight] {
        sums.clear();
        sums.resize(from.image.data().len(), 0.0);
    }
    for patch in 0..grid.u.len() {
        vote(from, to, grid, patch, votes);
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
fn vote(from: &Level, to: &Level, grid: &PatchGrid, patch: usize, votes: &mut Votes) {
    let (u, v) = (grid.u[patch], grid.v[patch]);
    let corner = grid.corner(patch);
    let (x, fx) = place(corner.0 as f32 + u, to.image.width);
    let (y, fy) = place(corner.1 as f32 + v, to.image.height);
    let (start, stride) = (from.image.index(corner.0, corner.1), from.image.stride);
    let part = start..start + (SIDE - 1) * stride + SIDE;
    let here = &from.image.data()[part.clone()];
    let Votes { u: sum_u, v: sum_v, weight: sum } = votes;
    let [sum_u, sum_v, sum] = [sum_u, sum_v, sum].map(|sums| &mut sums[part.clone()]);
    let (u, v, least) = (f32x8::splat(u), f32x8::splat(v), f32x8::splat(LEAST_DIFFERENCE));
    let rows = Between::new(&to.image, (x, y), fx);
    let (fy, mut upper) = (f32x8::splat(fy), rows.at(0));
    for k in 0..SIDE {
        let lower = rows.at(k + 1);
        let difference = (upper + fy * (lower - upper) - eight(&here[k * stride..])).abs();
        // Where it is no number, the least.
        let difference = difference.cmp_gt(least).blend(difference, least);
        let weight = f32x8::ONE / (difference * difference);
        add(&mut sum_u[k * stride..], weight * u);
        add(&mut sum_v[k * stride..], weight * v);
        add(&mut sum[k * stride..], weight);
        upper = lower;
    }
}

#[inline(always)]
fn add(sums: &mut [f32], values: f32x8) {
    let sums = &mut sums[..SIDE];
    sums.copy_from_slice(&(eight(sums) + values).to_array());
}
