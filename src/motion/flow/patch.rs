//! Inverse search: where each square patch of the first frame lies in the second.
//!
//! The cost of a displacement is the sum of squared differences less their mean, so a change of brightness does not
//! count. A step of the descent solves `H step = sum of slope * difference`, where `H` and the slopes belong to the
//! first frame and are made once a patch (Baker and Matthews, IJCV 2004). Cost: a few hundred operations a patch for
//! each displacement tried.

use super::field::FlowField;
use super::params::PATCH_SIDE as SIDE;
use super::pyramid::{Level, PAD, Padded};
use crate::image::sample_bilinear;
use wide::{CmpGt, f32x8};

/// Most steps of a patch's descent.
const DESCENTS: usize = 4;
/// Two candidates nearer than this (pixels, per axis) are taken as the same.
const SAME_CANDIDATE: f32 = 0.1;
/// A descent ends when its step is shorter than this, in pixels (squared).
const SMALL_STEP_SQ: f32 = 0.02 * 0.02;
/// A neighbour's displacement is taken over when it lowers the cost to this share. Higher lets repeated texture lead
/// astray.
const CLEARLY_BETTER: f32 = 0.8;
/// Least determinant of a patch's matrix; below it the patch is too flat or striped to be followed.
const MIN_DETERMINANT: f32 = 1e-3;

/// The patches of one level and the displacement found for each, row by row.
#[derive(Debug, Clone, Default)]
pub(super) struct PatchGrid {
    across: usize,
    down: usize,
    /// Pixel of the first patch's upper left corner.
    origin: (isize, isize),
    /// Pixels between patches.
    stride: usize,
    pub(super) u: Vec<f32>,
    pub(super) v: Vec<f32>,
    /// Sum of squared differences from the match, less its mean.
    cost: Vec<f32>,
}

impl PatchGrid {
    /// Lays patches over the level so that they cover it and hang over its border evenly on both sides.
    pub(super) fn lay(&mut self, width: usize, height: usize, stride: usize) {
        let (across, left) = cover(width, SIDE, stride);
        let (down, top) = cover(height, SIDE, stride);
        (self.across, self.down, self.origin, self.stride) = (across, down, (left, top), stride);
        for values in [&mut self.u, &mut self.v, &mut self.cost] {
            values.clear();
            values.resize(across * down, 0.0);
        }
    }

    /// Upper left corner of a patch; it may lie outside the level.
    fn corner(&self, patch: usize) -> (isize, isize) {
        let (column, row) = (patch % self.across, patch / self.across);
        (self.origin.0 + (column * self.stride) as isize, self.origin.1 + (row * self.stride) as isize)
    }

    /// Starts every patch from the flow of the level of half the size, twice as long here.
    pub(super) fn start_from(&mut self, coarser: &FlowField) {
        let middle = 0.5 * (SIDE as f32 - 1.0);
        for patch in 0..self.u.len() {
            let (x, y) = self.corner(patch);
            // A coarse pixel is centred between the two fine ones that it covers.
            let (x, y) = (0.5 * (x as f32 + middle) - 0.25, 0.5 * (y as f32 + middle) - 0.25);
            self.u[patch] = 2.0 * sample_bilinear(&coarser.u, x, y);
            self.v[patch] = 2.0 * sample_bilinear(&coarser.v, x, y);
        }
    }

    /// Searches every patch twice: with the results of its left and upper neighbours, then of its right and lower ones.
    pub(super) fn search(&mut self, from: &Level, to: &Level, reach: f32) {
        for patch in 0..self.u.len() {
            let template = Template::new(from, self.corner(patch));
            let start = template.compare(&to.image, (self.u[patch], self.v[patch]));
            let found = template.best_of(&to.image, start, self.candidates(patch, false));
            self.keep(patch, template.descend(&to.image, found, reach));
        }
        for patch in (0..self.u.len()).rev() {
            let present = Match { at: (self.u[patch], self.v[patch]), cost: self.cost[patch], pull: (0.0, 0.0) };
            let candidates = self.candidates(patch, true);
            if candidates.iter().all(|&candidate| is_same(candidate, present.at)) {
                continue;
            }
            let template = Template::new(from, self.corner(patch));
            let found = template.best_of(&to.image, present, candidates);
            if found.at != present.at {
                self.keep(patch, template.descend(&to.image, found, reach));
            }
        }
    }

    /// Compares every patch with the second frame at all whole displacements of up to `radius` pixels a component
    /// around its start; the best of them is taken over if it is clearly better than where the descent from the start
    /// leads.
    pub(super) fn scan(&mut self, from: &Level, to: &Level, radius: i16) {
        for patch in 0..self.u.len() {
            let template = Template::new(from, self.corner(patch));
            let start = template.compare(&to.image, (self.u[patch], self.v[patch]));
            let mut best = start;
            for (dy, dx) in (-radius..=radius).flat_map(|dy| (-radius..=radius).map(move |dx| (dy, dx))) {
                let at = (start.at.0 + f32::from(dx), start.at.1 + f32::from(dy));
                let other = template.compare(&to.image, at);
                if other.cost < best.cost {
                    best = other;
                }
            }
            let [near, far] = [start, best].map(|found| template.descend(&to.image, found, SIDE as f32));
            self.keep(patch, if far.cost < CLEARLY_BETTER * near.cost { far } else { near });
        }
    }

    fn keep(&mut self, patch: usize, found: Match) {
        (self.u[patch], self.v[patch], self.cost[patch]) = (found.at.0, found.at.1, found.cost);
    }

    /// What the two neighbours found that this pass has visited already; the patch's own displacement where there is
    /// none.
    fn candidates(&self, patch: usize, backward: bool) -> [(f32, f32); 2] {
        let (column, row) = (patch % self.across, patch / self.across);
        let [beside, beyond] = if backward {
            [patch + usize::from(column + 1 < self.across), patch + if row + 1 < self.down { self.across } else { 0 }]
        } else {
            [patch - usize::from(column > 0), patch - if row > 0 { self.across } else { 0 }]
        };
        [beside, beyond].map(|neighbour| (self.u[neighbour], self.v[neighbour]))
    }
}

fn is_same(a: (f32, f32), b: (f32, f32)) -> bool {
    (a.0 - b.0).abs() <= SAME_CANDIDATE && (a.1 - b.1).abs() <= SAME_CANDIDATE
}

/// How many patches cover `length` pixels, and where the first begins.
fn cover(length: usize, side: usize, stride: usize) -> (usize, isize) {
    let count = length.saturating_sub(side).div_ceil(stride) + 1;
    let covered = (count - 1) * stride + side;
    (count, -((covered.saturating_sub(length) / 2) as isize))
}

/// A displacement tried, its cost and the pull of the patch there.
#[derive(Debug, Clone, Copy)]
struct Match {
    at: (f32, f32),
    cost: f32,
    pull: (f32, f32),
}

/// One patch of the first frame: brightness, slopes less their means, and the inverse of the slopes' matrix.
struct Template {
    corner: (f32, f32),
    value: [f32x8; SIDE],
    slope_x: [f32x8; SIDE],
    slope_y: [f32x8; SIDE],
    inverse: [f32; 3],
}

impl Template {
    #[inline(always)]
    fn new(level: &Level, corner: (isize, isize)) -> Self {
        let start = level.image.index(corner.0, corner.1);
        let slope_x = without_mean(copy_patch(&level.slope_x, start));
        let slope_y = without_mean(copy_patch(&level.slope_y, start));
        let [mut xx, mut xy, mut yy] = [f32x8::ZERO; 3];
        for (&x, &y) in slope_x.iter().zip(&slope_y) {
            xx += x * x;
            xy += x * y;
            yy += y * y;
        }
        let (xx, xy, yy) = (total(xx), total(xy), total(yy));
        let determinant = xx * yy - xy * xy;
        let inverse = if determinant > MIN_DETERMINANT {
            [yy / determinant, -xy / determinant, xx / determinant]
        } else {
            [0.0; 3]
        };
        let value = copy_patch(&level.image, start);
        Self { corner: (corner.0 as f32, corner.1 as f32), value, slope_x, slope_y, inverse }
    }

    /// Compares the patch with the second frame, displaced by `at`; brightness offsets do not count.
    // Not inlined: it is called from many places, and long.
    #[inline(never)]
    fn compare(&self, image: &Padded, at: (f32, f32)) -> Match {
        let (x, fx) = place(self.corner.0 + at.0, image.width);
        let (y, fy) = place(self.corner.1 + at.1, image.height);
        let rows = Between::new(image, (x, y), fx);
        let (fy, mut upper) = (f32x8::splat(fy), rows.at(0));
        let [mut sum, mut squares, mut pull_x, mut pull_y] = [f32x8::ZERO; 4];
        for k in 0..SIDE {
            let lower = rows.at(k + 1);
            let difference = upper + fy * (lower - upper) - self.value[k];
            sum += difference;
            squares += difference * difference;
            pull_x += difference * self.slope_x[k];
            pull_y += difference * self.slope_y[k];
            upper = lower;
        }
        let sum = total(sum);
        let cost = total(squares) - sum * sum / (SIDE * SIDE) as f32;
        Match { at, cost, pull: (total(pull_x), total(pull_y)) }
    }

    /// The best of `start` and the candidates; one of these has to be clearly better, or the coarser level's word
    /// stands.
    #[inline(always)]
    fn best_of(&self, image: &Padded, start: Match, candidates: [(f32, f32); 2]) -> Match {
        let mut best = start;
        for candidate in candidates {
            if !is_same(candidate, best.at) {
                let other = self.compare(image, candidate);
                if other.cost < CLEARLY_BETTER * best.cost {
                    best = other;
                }
            }
        }
        best
    }

    /// Follows the slope of the cost from `start` for at most [`DESCENTS`] steps, as long as the cost falls; a patch
    /// that runs further than `reach` pixels has most likely found another thing that looks the same, and stays.
    #[inline(always)]
    fn descend(&self, image: &Padded, start: Match, reach: f32) -> Match {
        let [xx, xy, yy] = self.inverse;
        let mut best = start;
        for _ in 0..DESCENTS {
            let step = (xx * best.pull.0 + xy * best.pull.1, xy * best.pull.0 + yy * best.pull.1);
            if step.0 * step.0 + step.1 * step.1 < SMALL_STEP_SQ {
                break;
            }
            let next = self.compare(image, (best.at.0 - step.0, best.at.1 - step.1));
            if next.cost >= best.cost || next.cost.is_nan() {
                break;
            }
            best = next;
        }
        let moved = (best.at.0 - start.at.0).abs().max((best.at.1 - start.at.1).abs());
        if moved <= reach { best } else { start }
    }
}

/// Whole pixel and fraction of a patch's corner, held where the border still has room for the patch.
#[inline(always)]
fn place(position: f32, length: usize) -> (isize, f32) {
    let lowest = -(PAD as f32);
    let highest = (length + PAD - SIDE - 2) as f32;
    // In this order, a position that is not a number becomes the lowest.
    let held = if position > lowest { position } else { lowest };
    let held = if held < highest { held } else { highest };
    // Not `floor`, which is a call on some processors.
    let whole = (held - lowest) as i32 as f32 + lowest;
    (whole as isize, held - whole)
}

/// Rows of a patch of an image at a fraction of a pixel to the right.
struct Between<'a> {
    data: &'a [f32],
    stride: usize,
    fraction: f32x8,
}

impl<'a> Between<'a> {
    /// From pixel `(x, y)` on.
    #[inline(always)]
    fn new(image: &'a Padded, (x, y): (isize, isize), fraction: f32) -> Self {
        // One check of bounds for the whole patch.
        let data = &image.data()[image.index(x, y)..][..SIDE * image.stride + SIDE + 1];
        Self { data, stride: image.stride, fraction: f32x8::splat(fraction) }
    }

    /// Row `k`, 0 to the side.
    #[inline(always)]
    fn at(&self, k: usize) -> f32x8 {
        let row = &self.data[k * self.stride..][..SIDE + 1];
        let (left, right) = (eight(row), eight(&row[1..]));
        left + self.fraction * (right - left)
    }
}

/// The first eight values.
#[inline(always)]
fn eight(data: &[f32]) -> f32x8 {
    f32x8::new(*data.first_chunk().expect("the border has room for every patch"))
}

#[inline(always)]
fn copy_patch(plane: &Padded, start: usize) -> [f32x8; SIDE] {
    let data = &plane.data()[start..];
    let mut patch = [f32x8::ZERO; SIDE];
    for (k, row) in patch.iter_mut().enumerate() {
        *row = eight(&data[k * plane.stride..]);
    }
    patch
}

#[inline(always)]
fn without_mean(mut patch: [f32x8; SIDE]) -> [f32x8; SIDE] {
    let mut sum = f32x8::ZERO;
    patch.iter().for_each(|&row| sum += row);
    let mean = f32x8::splat(total(sum) / (SIDE * SIDE) as f32);
    patch.iter_mut().for_each(|row| *row -= mean);
    patch
}

/// The sum, in an order that is the same on every machine.
#[inline(always)]
fn total(values: f32x8) -> f32 {
    let [a, b, c, d, e, f, g, h] = values.to_array();
    ((a + e) + (b + f)) + ((c + g) + (d + h))
}

// From patches to pixels: each pixel takes the mean of the patches over it, the well-matching ones counting more.

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_cover_every_length_and_hang_over_evenly() {
        for (length, side, stride) in [(1, 8, 4), (8, 8, 4), (9, 8, 4), (37, 8, 3), (50, 16, 16), (270, 12, 5)] {
            let (count, first) = cover(length, side, stride);
            let end = first + ((count - 1) * stride + side) as isize;
            let over = end - length as isize;
            assert!(first <= 0 && over >= 0, "{length}: {first}..{end}");
            assert!((over + first).abs() <= 1 && stride <= side, "{length}: {first}..{end}");
        }
    }

    #[test]
    fn a_shifted_patch_is_found_exactly() {
        let wave = |x: f32, y: f32| 100.0 + 40.0 * (0.3 * x + 0.1 * y).sin() + 30.0 * (0.25 * y - 0.15 * x).cos();
        let pyramid = |dx: f32, dy: f32| {
            let luma = crate::image::Plane::from_fn(40, 40, |x, y| wave(x as f32 - dx, y as f32 - dy) + 9.0 * dx);
            super::super::FlowPyramid::of_smooth(&luma)
        };
        let (from, to) = (pyramid(0.0, 0.0), pyramid(1.3, -0.8));
        let template = Template::new(&from.levels[0], (16, 12));
        let image = &to.levels[0].image;
        let start = template.compare(image, (0.0, 0.0));
        let found = (0..4).fold(start, |found, _| template.descend(image, found, 8.0));
        assert!((found.at.0 - 1.3).abs() < 0.05 && (found.at.1 + 0.8).abs() < 0.05, "{:?}", found.at);
        let held = template.descend(image, start, 0.5);
        assert_eq!(held.at, (0.0, 0.0), "beyond its reach a patch stays");
    }
}
