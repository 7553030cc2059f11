//! Inverse search: where each square patch of the first frame lies in the second.
//!
//! The cost of a displacement is the sum of squared differences less their mean, so a change of brightness does not
//! count. A step of the descent solves `H step = sum of slope * difference`, where `H` and the slopes belong to the
//! first frame and are made once a patch (Baker and Matthews, IJCV 2004). Cost: a few hundred operations a patch for
//! each displacement tried.

use super::field::FlowField;
use super::pyramid::{Level, PAD, Padded};
use crate::image::sample_bilinear;

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
    /// Pixels between patches, and side of a patch.
    stride: usize,
    side: usize,
    pub(super) u: Vec<f32>,
    pub(super) v: Vec<f32>,
    /// Sum of squared differences from the match, less its mean.
    cost: Vec<f32>,
}

impl PatchGrid {
    /// Lays patches over the level so that they cover it and hang over its border evenly on both sides.
    pub(super) fn lay(&mut self, width: usize, height: usize, side: usize, stride: usize) {
        let (across, left) = cover(width, side, stride);
        let (down, top) = cover(height, side, stride);
        (self.across, self.down, self.origin, self.side, self.stride) = (across, down, (left, top), side, stride);
        for values in [&mut self.u, &mut self.v, &mut self.cost] {
            values.clear();
            values.resize(across * down, 0.0);
        }
    }

    /// Upper left corner of a patch; it may lie outside the level.
    pub(super) fn corner(&self, patch: usize) -> (isize, isize) {
        let (column, row) = (patch % self.across, patch / self.across);
        (self.origin.0 + (column * self.stride) as isize, self.origin.1 + (row * self.stride) as isize)
    }

    /// Starts every patch from the flow of the level of half the size, twice as long here.
    pub(super) fn start_from(&mut self, coarser: &FlowField) {
        let middle = 0.5 * (self.side as f32 - 1.0);
        for patch in 0..self.u.len() {
            let (x, y) = self.corner(patch);
            // A coarse pixel is centred between the two fine ones that it covers.
            let (x, y) = (0.5 * (x as f32 + middle) - 0.25, 0.5 * (y as f32 + middle) - 0.25);
            self.u[patch] = 2.0 * sample_bilinear(&coarser.u, x, y);
            self.v[patch] = 2.0 * sample_bilinear(&coarser.v, x, y);
        }
    }

    /// Searches every patch twice: with the results of its left and upper neighbours, then of its right and lower ones.
    /// `S` is the side of a patch.
    pub(super) fn search<const S: usize>(&mut self, from: &Level, to: &Level, descents: usize, reach: f32) {
        for patch in 0..self.u.len() {
            let template = Template::<S>::new(from, self.corner(patch));
            let start = template.compare(&to.image, (self.u[patch], self.v[patch]));
            let found = template.best_of(&to.image, start, self.candidates(patch, false));
            self.keep(patch, template.descend(&to.image, found, descents, reach));
        }
        for patch in (0..self.u.len()).rev() {
            let present = Match { at: (self.u[patch], self.v[patch]), cost: self.cost[patch], pull: (0.0, 0.0) };
            let candidates = self.candidates(patch, true);
            if candidates.iter().all(|&candidate| is_same(candidate, present.at)) {
                continue;
            }
            let template = Template::<S>::new(from, self.corner(patch));
            let found = template.best_of(&to.image, present, candidates);
            if found.at != present.at {
                self.keep(patch, template.descend(&to.image, found, descents, reach));
            }
        }
    }

    /// Compares every patch with the second frame at all whole displacements of up to `radius` pixels a component
    /// around its start; the best of them is taken over if it is clearly better than where the descent from the start
    /// leads.
    pub(super) fn scan<const S: usize>(&mut self, from: &Level, to: &Level, descents: usize, radius: i16) {
        for patch in 0..self.u.len() {
            let template = Template::<S>::new(from, self.corner(patch));
            let start = template.compare(&to.image, (self.u[patch], self.v[patch]));
            let mut best = start;
            for (dy, dx) in (-radius..=radius).flat_map(|dy| (-radius..=radius).map(move |dx| (dy, dx))) {
                let at = (start.at.0 + f32::from(dx), start.at.1 + f32::from(dy));
                let other = template.compare(&to.image, at);
                if other.cost < best.cost {
                    best = other;
                }
            }
            let [near, far] = [start, best].map(|found| template.descend(&to.image, found, descents, S as f32));
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
struct Template<const S: usize> {
    corner: (f32, f32),
    value: [[f32; S]; S],
    slope_x: [[f32; S]; S],
    slope_y: [[f32; S]; S],
    inverse: [f32; 3],
}

impl<const S: usize> Template<S> {
    #[inline(always)]
    fn new(level: &Level, corner: (isize, isize)) -> Self {
        let start = level.image.index(corner.0, corner.1);
        let mut slope_x = copy_patch(&level.slope_x, start);
        let mut slope_y = copy_patch(&level.slope_y, start);
        subtract_mean(&mut slope_x);
        subtract_mean(&mut slope_y);
        let [mut xx, mut xy, mut yy] = [[0.0_f32; S]; 3];
        for (x, y) in slope_x.iter().zip(&slope_y) {
            for i in 0..S {
                xx[i] += x[i] * x[i];
                xy[i] += x[i] * y[i];
                yy[i] += y[i] * y[i];
            }
        }
        let (xx, xy, yy) = (total(&xx), total(&xy), total(&yy));
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
    #[inline(always)]
    fn compare(&self, image: &Padded, at: (f32, f32)) -> Match {
        let (x, fx) = place(self.corner.0 + at.0, image.width, S);
        let (y, fy) = place(self.corner.1 + at.1, image.height, S);
        let start = image.index(x, y);
        // Differences first, sums after: apart, both loops become vector instructions.
        let mut difference = [[0.0_f32; S]; S];
        let mut upper = blend::<S>(image.data(), start, fx);
        for k in 0..S {
            let lower = blend::<S>(image.data(), start + (k + 1) * image.stride, fx);
            for i in 0..S {
                difference[k][i] = upper[i] + fy * (lower[i] - upper[i]) - self.value[k][i];
            }
            upper = lower;
        }
        let mut sums = [[0.0_f32; 4]; 4];
        for ((d, x), y) in fours(&difference).zip(fours(&self.slope_x)).zip(fours(&self.slope_y)) {
            for i in 0..4 {
                sums[0][i] += d[i];
                sums[1][i] += d[i] * d[i];
                sums[2][i] += d[i] * x[i];
                sums[3][i] += d[i] * y[i];
            }
        }
        let sum = total(&sums[0]);
        Match { at, cost: total(&sums[1]) - sum * sum / (S * S) as f32, pull: (total(&sums[2]), total(&sums[3])) }
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

    /// Follows the slope of the cost from `start` for at most `descents` steps, as long as the cost falls; a patch that
    /// runs further than `reach` pixels has most likely found another thing that looks the same, and stays.
    #[inline(always)]
    fn descend(&self, image: &Padded, start: Match, descents: usize, reach: f32) -> Match {
        let [xx, xy, yy] = self.inverse;
        let mut best = start;
        for _ in 0..descents {
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
pub(super) fn place(position: f32, length: usize, side: usize) -> (isize, f32) {
    let lowest = -(PAD as f32);
    let highest = (length + PAD - side - 2) as f32;
    // In this order, a position that is not a number becomes the lowest.
    let held = if position > lowest { position } else { lowest };
    let held = if held < highest { held } else { highest };
    let whole = held.floor();
    (whole as isize, held - whole)
}

/// `S` values between those from `start` on and their right neighbours.
#[inline(always)]
pub(super) fn blend<const S: usize>(data: &[f32], start: usize, fraction: f32) -> [f32; S] {
    let (left, right) = (chunk::<S>(data, start), chunk::<S>(data, start + 1));
    let mut between = [0.0; S];
    for i in 0..S {
        between[i] = left[i] + fraction * (right[i] - left[i]);
    }
    between
}

/// The `S` values from `start` on, as an array: one check of bounds in place of `S`.
#[inline(always)]
pub(super) fn chunk<const S: usize>(data: &[f32], start: usize) -> &[f32; S] {
    data[start..].first_chunk().expect("the border has room for every patch")
}

#[inline(always)]
fn copy_patch<const S: usize>(plane: &Padded, start: usize) -> [[f32; S]; S] {
    let mut patch = [[0.0; S]; S];
    for k in 0..S {
        patch[k] = *chunk(plane.data(), start + k * plane.stride);
    }
    patch
}

#[inline(always)]
fn subtract_mean<const S: usize>(patch: &mut [[f32; S]; S]) {
    let mut sums = [0.0_f32; S];
    for row in patch.iter() {
        for i in 0..S {
            sums[i] += row[i];
        }
    }
    let mean = total(&sums) / (S * S) as f32;
    patch.iter_mut().flatten().for_each(|v| *v -= mean);
}

/// The values of a patch, four at a time.
#[inline(always)]
fn fours<const S: usize>(patch: &[[f32; S]; S]) -> std::slice::Iter<'_, [f32; 4]> {
    patch.as_flattened().as_chunks().0.iter()
}

/// The sum, halves first: an order that vector instructions keep. `S` is a multiple of four.
#[inline(always)]
fn total<const S: usize>(values: &[f32; S]) -> f32 {
    let mut parts = [0.0_f32; 4];
    for four in values.chunks_exact(4) {
        for i in 0..4 {
            parts[i] += four[i];
        }
    }
    parts[0] + parts[1] + parts[2] + parts[3]
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
        let params = super::super::FlowParams { presmoothing: 0.0, ..Default::default() };
        let pyramid = |dx: f32, dy: f32| {
            let luma = crate::image::Plane::from_fn(40, 40, |x, y| wave(x as f32 - dx, y as f32 - dy) + 9.0 * dx);
            super::super::FlowPyramid::new(&luma, &params)
        };
        let (from, to) = (pyramid(0.0, 0.0), pyramid(1.3, -0.8));
        let template = Template::<8>::new(&from.levels[0], (16, 12));
        let image = &to.levels[0].image;
        let found = template.descend(image, template.compare(image, (0.0, 0.0)), 16, 8.0);
        assert!((found.at.0 - 1.3).abs() < 0.05 && (found.at.1 + 0.8).abs() < 0.05, "{:?}", found.at);
        let held = template.descend(image, template.compare(image, (0.0, 0.0)), 16, 0.5);
        assert_eq!(held.at, (0.0, 0.0), "beyond its reach a patch stays");
    }
}
