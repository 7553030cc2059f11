//! Inverse search: where each square patch of the first frame lies in the second.

use super::pyramid::{Level, PAD, Padded};
use crate::image::Plane;

/// Largest patch side.
const MAX_SIDE: usize = 16;
/// Two candidates nearer than this (pixels, per axis) are taken as the same.
const SAME_CANDIDATE: f32 = 0.1;
/// A descent ends when its step is shorter than this, in pixels (squared).
const SMALL_STEP_SQ: f32 = 0.02 * 0.02;
/// Least determinant of a patch's matrix; below it the patch is too flat or striped to be followed.
const MIN_DETERMINANT: f32 = 1e-3;

/// The patches of one level and the displacement found for each.
#[derive(Debug, Clone, Default)]
pub(super) struct PatchGrid {
    /// Patches across and down.
    pub(super) across: usize,
    pub(super) down: usize,
    /// Pixel of the first patch's upper left corner (may be negative), pixels between patches, side of a patch.
    pub(super) origin: (isize, isize),
    pub(super) stride: usize,
    pub(super) side: usize,
    /// Displacement and mean-normalised squared difference of each patch, row by row.
    pub(super) u: Vec<f32>,
    pub(super) v: Vec<f32>,
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

    /// Upper left corner of patch `(column, row)`.
    pub(super) fn corner(&self, column: usize, row: usize) -> (isize, isize) {
        (self.origin.0 + (column * self.stride) as isize, self.origin.1 + (row * self.stride) as isize)
    }

    /// Starts every patch from the coarser level's flow (twice as long here), or from rest.
    pub(super) fn start(&mut self, coarser: Option<(&Plane<f32>, &Plane<f32>)>) {
        let Some((u, v)) = coarser else { return };
        let middle = 0.5 * (self.side as f32 - 1.0);
        for row in 0..self.down {
            for column in 0..self.across {
                let (x, y) = self.corner(column, row);
                // A coarse pixel is centred between the two fine ones that it covers.
                let (x, y) = (0.5 * (x as f32 + middle) - 0.25, 0.5 * (y as f32 + middle) - 0.25);
                let patch = row * self.across + column;
                self.u[patch] = 2.0 * crate::image::sample_bilinear(u, x, y);
                self.v[patch] = 2.0 * crate::image::sample_bilinear(v, x, y);
            }
        }
    }

    /// Searches every patch twice: with the results of its left and upper neighbours, then of its right and lower ones.
    pub(super) fn search(&mut self, from: &Level, to: &Level, descents: usize) {
        for backward in [false, true] {
            for step in 0..self.u.len() {
                let patch = if backward { self.u.len() - 1 - step } else { step };
                if self.side == 8 {
                    // The usual side as a constant: loops of known length become vector instructions.
                    self.search_patch(from, to, patch, backward, descents, 8);
                } else {
                    self.search_patch(from, to, patch, backward, descents, self.side);
                }
            }
        }
    }

    #[inline(always)]
    fn search_patch(&mut self, from: &Level, to: &Level, patch: usize, backward: bool, descents: usize, side: usize) {
        let (column, row) = (patch % self.across, patch / self.across);
        let corner = self.corner(column, row);
        let template = Template::new(from, corner, side);
        let initial = (self.u[patch], self.v[patch]);
        let mut best = template.compare(&to.image, initial, side);
        for neighbour in self.neighbours(column, row, backward).into_iter().flatten() {
            let candidate = (self.u[neighbour], self.v[neighbour]);
            let distance = (candidate.0 - best.at.0).abs().max((candidate.1 - best.at.1).abs());
            if distance > SAME_CANDIDATE {
                let other = template.compare(&to.image, candidate, side);
                if other.cost < best.cost {
                    best = other;
                }
            }
        }
        best = template.descend(&to.image, best, descents, side);
        (self.u[patch], self.v[patch], self.cost[patch]) = (best.at.0, best.at.1, best.cost);
    }

    /// The two neighbours that this pass has visited already.
    fn neighbours(&self, column: usize, row: usize, backward: bool) -> [Option<usize>; 2] {
        let patch = row * self.across + column;
        if backward {
            [(column + 1 < self.across).then(|| patch + 1), (row + 1 < self.down).then(|| patch + self.across)]
        } else {
            [(column > 0).then(|| patch - 1), (row > 0).then(|| patch - self.across)]
        }
    }
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
    value: [f32; MAX_SIDE * MAX_SIDE],
    slope_x: [f32; MAX_SIDE * MAX_SIDE],
    slope_y: [f32; MAX_SIDE * MAX_SIDE],
    inverse: [f32; 3],
}

impl Template {
    #[inline(always)]
    fn new(level: &Level, corner: (isize, isize), side: usize) -> Self {
        let mut template = Self {
            corner: (corner.0 as f32, corner.1 as f32),
            value: [0.0; MAX_SIDE * MAX_SIDE],
            slope_x: [0.0; MAX_SIDE * MAX_SIDE],
            slope_y: [0.0; MAX_SIDE * MAX_SIDE],
            inverse: [0.0; 3],
        };
        let start = level.image.index(corner.0, corner.1);
        copy_patch(&level.image, start, &mut template.value, side);
        copy_patch(&level.slope_x, start, &mut template.slope_x, side);
        copy_patch(&level.slope_y, start, &mut template.slope_y, side);
        let (xs, ys) = (&mut template.slope_x[..side * side], &mut template.slope_y[..side * side]);
        subtract_mean(xs);
        subtract_mean(ys);
        let (xx, xy, yy) = (dot(xs, xs), dot(xs, ys), dot(ys, ys));
        let determinant = xx * yy - xy * xy;
        if determinant > MIN_DETERMINANT {
            template.inverse = [yy / determinant, -xy / determinant, xx / determinant];
        }
        template
    }

    /// Compares the patch with the second frame, displaced by `at`; brightness offsets do not count.
    #[inline(always)]
    fn compare(&self, image: &Padded, at: (f32, f32), side: usize) -> Match {
        let (x, fx) = place(self.corner.0 + at.0, image.width, side);
        let (y, fy) = place(self.corner.1 + at.1, image.height, side);
        let start = image.index(x, y);
        let rows = &image.data()[start..start + side * image.stride + side + 1];
        let mut sums = [[0.0_f32; MAX_SIDE]; 4];
        let mut upper = [0.0_f32; MAX_SIDE];
        let mut lower = [0.0_f32; MAX_SIDE];
        blend(&rows[..side + 1], fx, &mut upper, side);
        for k in 0..side {
            blend(&rows[(k + 1) * image.stride..][..side + 1], fx, &mut lower, side);
            let value = &self.value[k * side..][..side];
            let slope_x = &self.slope_x[k * side..][..side];
            let slope_y = &self.slope_y[k * side..][..side];
            for i in 0..side {
                let difference = upper[i] + fy * (lower[i] - upper[i]) - value[i];
                sums[0][i] += difference;
                sums[1][i] += difference * difference;
                sums[2][i] += difference * slope_x[i];
                sums[3][i] += difference * slope_y[i];
            }
            upper = lower;
        }
        let [total, squares, along_x, along_y] = sums.map(|lanes| total(&lanes[..side]));
        Match { at, cost: squares - total * total / (side * side) as f32, pull: (along_x, along_y) }
    }

    /// Follows the slope of the cost from `start` for at most `descents` steps, as long as the cost falls.
    #[inline(always)]
    fn descend(&self, image: &Padded, start: Match, descents: usize, side: usize) -> Match {
        let [xx, xy, yy] = self.inverse;
        let mut best = start;
        for _ in 0..descents {
            let step = (xx * best.pull.0 + xy * best.pull.1, xy * best.pull.0 + yy * best.pull.1);
            if step.0 * step.0 + step.1 * step.1 < SMALL_STEP_SQ {
                break;
            }
            let next = self.compare(image, (best.at.0 - step.0, best.at.1 - step.1), side);
            // Written so that a cost that is not a number ends the descent too.
            if !(next.cost < best.cost) {
                break;
            }
            best = next;
        }
        // A patch that ran further than its side has most likely found another thing that looks the same.
        let moved = (best.at.0 - start.at.0).abs().max((best.at.1 - start.at.1).abs());
        if moved <= side as f32 { best } else { start }
    }
}

/// Whole pixel and fraction of a patch's corner, held where the border still has room for the patch.
#[inline(always)]
pub(super) fn place(position: f32, length: usize, side: usize) -> (isize, f32) {
    let highest = (length + PAD - side - 1) as f32;
    let held = position.max(-(PAD as f32)).min(highest);
    let whole = held.floor();
    let whole = whole.min(highest - 1.0).max(-(PAD as f32));
    (whole as isize, held - whole)
}

#[inline(always)]
fn blend(row: &[f32], fraction: f32, out: &mut [f32; MAX_SIDE], side: usize) {
    for i in 0..side {
        out[i] = row[i] + fraction * (row[i + 1] - row[i]);
    }
}

#[inline(always)]
fn copy_patch(plane: &Padded, start: usize, out: &mut [f32; MAX_SIDE * MAX_SIDE], side: usize) {
    for k in 0..side {
        out[k * side..][..side].copy_from_slice(&plane.data()[start + k * plane.stride..][..side]);
    }
}

#[inline(always)]
fn subtract_mean(values: &mut [f32]) {
    let mean = total(values) / values.len() as f32;
    values.iter_mut().for_each(|v| *v -= mean);
}

/// The sum in four interleaved parts, an order that vector instructions keep.
#[inline(always)]
fn total(values: &[f32]) -> f32 {
    let mut parts = [0.0_f32; 4];
    let chunks = values.chunks_exact(4);
    let rest: f32 = chunks.remainder().iter().sum();
    for chunk in chunks {
        for (part, value) in parts.iter_mut().zip(chunk) {
            *part += value;
        }
    }
    (parts[0] + parts[1]) + (parts[2] + parts[3]) + rest
}

#[inline(always)]
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut parts = [0.0_f32; 4];
    let chunks = a.chunks_exact(4).zip(b.chunks_exact(4));
    for (p, q) in chunks {
        for i in 0..4 {
            parts[i] += p[i] * q[i];
        }
    }
    let tail = a.len() / 4 * 4;
    let rest: f32 = a[tail..].iter().zip(&b[tail..]).map(|(p, q)| p * q).sum();
    (parts[0] + parts[1]) + (parts[2] + parts[3]) + rest
}
