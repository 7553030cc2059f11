//! Inverse search: finds each square patch of the first frame in the second.
//!
//! The cost of a displacement is the sum of squared differences without their mean, so that a change of brightness does not
//! count. A step of the descent solves `H step = Σ gradient · difference`, where `H` and the gradient belong to the first
//! frame and are computed once a patch (Baker and Matthews, IJCV 2004). Cost: a few hundred operations per patch and
//! displacement tried.

use super::PATCH_SIDE_PX as SIDE;
use super::field::FlowField;
use super::pyramid::{Level, PAD, PaddedPlane};
use crate::image::sample_bilinear;
use wide::{CmpGt, f32x8};

// Constants without a source were chosen by eye and checked on the Middlebury pairs, as the module `flow` reports.

/// Largest number of steps of a patch's descent.
const MAX_DESCENT_STEPS: usize = 4;
/// Candidates closer than this in both components count as the same, in pixels.
const SAME_CANDIDATE_PX: f32 = 0.1;
/// Length of the step at which a descent ends, in pixels, squared.
const MIN_STEP_PX_SQ: f32 = 0.02 * 0.02;
/// A neighbour's displacement is adopted if it lowers the cost to this share. Higher lets repeated texture mislead.
const ADOPTION_COST_RATIO: f32 = 0.8;
/// Smallest determinant of a patch's matrix; patches below it are too flat or striped to be tracked.
const MIN_DETERMINANT: f32 = 1e-3;

/// The search of patches at one level.
#[derive(Debug, Clone, Copy)]
pub(super) struct PatchSearch {
    /// Longest descent, in pixels.
    pub(super) max_descent: f32,
    /// Radius of the scan before the descent, in pixels; `None` for no scan.
    pub(super) scan_radius: Option<i16>,
}

/// Working memory of the search.
#[derive(Debug, Clone, Default)]
pub(super) struct PatchMatcher {
    grid: PatchGrid,
    sums: WeightedSums,
}

impl PatchMatcher {
    /// Computes the flow of a level by patches `stride` pixels apart that start from the `coarser` level's flow; without a
    /// `search` they stay there.
    pub(super) fn flow(
        &mut self,
        from: &Level,
        to: &Level,
        stride: usize,
        coarser: Option<&FlowField>,
        search: Option<PatchSearch>,
    ) -> FlowField {
        let (width, height) = (from.image.width, from.image.height);
        self.grid.lay(width, height, stride);
        if let Some(coarser) = coarser {
            self.grid.start_from(coarser);
        }
        if let Some(PatchSearch { max_descent, scan_radius }) = search {
            if let Some(radius) = scan_radius {
                self.grid.scan(from, to, radius);
            }
            self.grid.search(from, to, max_descent);
        }
        let mut flow = FlowField::zero(width, height);
        densify(from, to, &self.grid, &mut self.sums, &mut flow);
        flow
    }
}

/// The patches of one level and the displacement found for each, row by row.
#[derive(Debug, Clone, Default)]
struct PatchGrid {
    across: usize,
    down: usize,
    /// Upper left corner of the first patch.
    origin: (isize, isize),
    /// Pixels between patches.
    stride: usize,
    u: Vec<f32>,
    v: Vec<f32>,
    /// Sum of squared differences without their mean.
    cost: Vec<f32>,
}

impl PatchGrid {
    /// Lays patches over the level so that they cover it and hang over its border evenly on both sides.
    fn lay(&mut self, width: usize, height: usize, stride: usize) {
        let (across, origin_x) = cover(width, SIDE, stride);
        let (down, origin_y) = cover(height, SIDE, stride);
        (self.across, self.down, self.origin, self.stride) = (across, down, (origin_x, origin_y), stride);
        [&mut self.u, &mut self.v, &mut self.cost].into_iter().for_each(|values| fill_zeros(values, across * down));
    }

    /// Returns the upper left corner of a patch, which may lie outside the level.
    fn corner(&self, patch: usize) -> (isize, isize) {
        let (column, row) = (patch % self.across, patch / self.across);
        (self.origin.0 + (column * self.stride) as isize, self.origin.1 + (row * self.stride) as isize)
    }

    /// Starts every patch from the flow of the level of half the size, doubled.
    fn start_from(&mut self, coarser: &FlowField) {
        let middle = 0.5 * (SIDE as f32 - 1.0);
        for patch in 0..self.u.len() {
            let (x, y) = self.corner(patch);
            // A coarse pixel is centred between the two fine ones that it covers.
            let (x, y) = (0.5 * (x as f32 + middle) - 0.25, 0.5 * (y as f32 + middle) - 0.25);
            self.u[patch] = 2.0 * sample_bilinear(&coarser.u, x, y);
            self.v[patch] = 2.0 * sample_bilinear(&coarser.v, x, y);
        }
    }

    /// Searches every patch twice: from the displacements of its left and upper neighbours, then of its right and lower ones.
    fn search(&mut self, from: &Level, to: &Level, max_descent: f32) {
        for patch in 0..self.u.len() {
            let template = Template::new(from, self.corner(patch));
            let start = template.compare(&to.image, (self.u[patch], self.v[patch]));
            let best = template.best_of(&to.image, start, self.candidates(patch, false));
            self.set(patch, template.descend(&to.image, best, max_descent));
        }
        for patch in (0..self.u.len()).rev() {
            let current = Match { at: (self.u[patch], self.v[patch]), cost: self.cost[patch], gradient: (0.0, 0.0) };
            let candidates = self.candidates(patch, true);
            if candidates.iter().all(|&candidate| is_same(candidate, current.at)) {
                continue;
            }
            let template = Template::new(from, self.corner(patch));
            let best = template.best_of(&to.image, current, candidates);
            if best.at != current.at {
                self.set(patch, template.descend(&to.image, best, max_descent));
            }
        }
    }

    /// Compares every patch with the second frame at all whole-pixel displacements of up to `radius` in each component
    /// around its start. The descent from the best one is adopted if it ends clearly better than the descent from the start.
    fn scan(&mut self, from: &Level, to: &Level, radius: i16) {
        for patch in 0..self.u.len() {
            let template = Template::new(from, self.corner(patch));
            let start = template.compare(&to.image, (self.u[patch], self.v[patch]));
            let mut best = start;
            for (dy, dx) in (-radius..=radius).flat_map(|dy| (-radius..=radius).map(move |dx| (dy, dx))) {
                let at = (start.at.0 + f32::from(dx), start.at.1 + f32::from(dy));
                let candidate = template.compare(&to.image, at);
                if candidate.cost < best.cost {
                    best = candidate;
                }
            }
            let [from_start, from_best] = [start, best].map(|m| template.descend(&to.image, m, SIDE as f32));
            let is_better = from_best.cost < ADOPTION_COST_RATIO * from_start.cost;
            self.set(patch, if is_better { from_best } else { from_start });
        }
    }

    fn set(&mut self, patch: usize, result: Match) {
        (self.u[patch], self.v[patch], self.cost[patch]) = (result.at.0, result.at.1, result.cost);
    }

    /// Returns the displacements of the two neighbours that this pass has visited, or the patch's own on the border.
    fn candidates(&self, patch: usize, is_backward: bool) -> [(f32, f32); 2] {
        let (column, row) = (patch % self.across, patch / self.across);
        let neighbours = if is_backward {
            [patch + usize::from(column + 1 < self.across), patch + if row + 1 < self.down { self.across } else { 0 }]
        } else {
            [patch - usize::from(column > 0), patch - if row > 0 { self.across } else { 0 }]
        };
        neighbours.map(|neighbour| (self.u[neighbour], self.v[neighbour]))
    }
}

fn is_same(a: (f32, f32), b: (f32, f32)) -> bool {
    (a.0 - b.0).abs() <= SAME_CANDIDATE_PX && (a.1 - b.1).abs() <= SAME_CANDIDATE_PX
}

/// Returns the number of patches that cover `length` pixels, and the first one's position.
fn cover(length: usize, side: usize, stride: usize) -> (usize, isize) {
    let count = length.saturating_sub(side).div_ceil(stride) + 1;
    let covered = (count - 1) * stride + side;
    (count, -((covered.saturating_sub(length) / 2) as isize))
}

/// A displacement, its cost and half the gradient of the cost.
#[derive(Debug, Clone, Copy)]
struct Match {
    at: (f32, f32),
    cost: f32,
    gradient: (f32, f32),
}

/// One patch of the first frame.
struct Template {
    corner: (f32, f32),
    /// Brightness.
    value: [f32x8; SIDE],
    /// Gradient of brightness without its mean.
    slope_x: [f32x8; SIDE],
    slope_y: [f32x8; SIDE],
    /// Entries xx, xy, yy of the inverse of `H = Σ gradient gradientᵀ`; zeros where it is near-singular.
    inverse: [f32; 3],
}

impl Template {
    #[inline(always)]
    fn new(level: &Level, corner: (isize, isize)) -> Self {
        let start = level.image.index(corner.0, corner.1);
        let slope_x = subtract_mean(copy_patch(&level.slope_x, start));
        let slope_y = subtract_mean(copy_patch(&level.slope_y, start));
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
    // Not inlined: it is long and called from many places.
    #[inline(never)]
    fn compare(&self, image: &PaddedPlane, at: (f32, f32)) -> Match {
        let (x, fx) = split_position(self.corner.0 + at.0, image.width);
        let (y, fy) = split_position(self.corner.1 + at.1, image.height);
        let rows = InterpolatedRows::new(image, x, y, fx);
        let (fy, mut upper) = (f32x8::splat(fy), rows.at(0));
        let [mut sum, mut squares, mut gradient_x, mut gradient_y] = [f32x8::ZERO; 4];
        for k in 0..SIDE {
            let lower = rows.at(k + 1);
            let difference = upper + fy * (lower - upper) - self.value[k];
            sum += difference;
            squares += difference * difference;
            gradient_x += difference * self.slope_x[k];
            gradient_y += difference * self.slope_y[k];
            upper = lower;
        }
        let sum = total(sum);
        let cost = total(squares) - sum * sum / (SIDE * SIDE) as f32;
        Match { at, cost, gradient: (total(gradient_x), total(gradient_y)) }
    }

    /// Returns the best of `start` and the candidates, which must be clearly better than the coarser level's displacement.
    #[inline(always)]
    fn best_of(&self, image: &PaddedPlane, start: Match, candidates: [(f32, f32); 2]) -> Match {
        let mut best = start;
        for candidate in candidates {
            if !is_same(candidate, best.at) {
                let candidate = self.compare(image, candidate);
                if candidate.cost < ADOPTION_COST_RATIO * best.cost {
                    best = candidate;
                }
            }
        }
        best
    }

    /// Descends from `start` for at most [`MAX_DESCENT_STEPS`] steps while the cost falls. A patch that moves more than
    /// `max_descent` pixels in a component has probably matched something else, and stays at `start`.
    #[inline(always)]
    fn descend(&self, image: &PaddedPlane, start: Match, max_descent: f32) -> Match {
        let [xx, xy, yy] = self.inverse;
        let mut best = start;
        for _ in 0..MAX_DESCENT_STEPS {
            let (gx, gy) = best.gradient;
            let step = (xx * gx + xy * gy, xy * gx + yy * gy);
            if step.0 * step.0 + step.1 * step.1 < MIN_STEP_PX_SQ {
                break;
            }
            let next = self.compare(image, (best.at.0 - step.0, best.at.1 - step.1));
            if next.cost >= best.cost || next.cost.is_nan() {
                break;
            }
            best = next;
        }
        let distance = (best.at.0 - start.at.0).abs().max((best.at.1 - start.at.1).abs());
        if distance <= max_descent { best } else { start }
    }
}

/// Splits the position of a patch's corner into pixel and fraction, clamped so that the border has room for the patch.
#[inline(always)]
fn split_position(position: f32, length: usize) -> (isize, f32) {
    let lowest = -(PAD as f32);
    let highest = (length + PAD - SIDE - 2) as f32;
    // In this order NaN becomes the lowest position.
    let clamped = if position > lowest { position } else { lowest };
    let clamped = if clamped < highest { clamped } else { highest };
    // Not `floor`, which is a call on some processors.
    let pixel = (clamped - lowest) as i32 as f32 + lowest;
    (pixel as isize, clamped - pixel)
}

/// Rows of a patch of an image, interpolated at a fraction of a pixel to the right.
struct InterpolatedRows<'a> {
    data: &'a [f32],
    stride: usize,
    fraction: f32x8,
}

impl<'a> InterpolatedRows<'a> {
    /// Creates the rows from pixel `(x, y)` on.
    #[inline(always)]
    fn new(image: &'a PaddedPlane, x: isize, y: isize, fraction: f32) -> Self {
        // One bounds check for the whole patch.
        let data = &image.data[image.index(x, y)..][..SIDE * image.stride + SIDE + 1];
        Self { data, stride: image.stride, fraction: f32x8::splat(fraction) }
    }

    /// Returns row `k`, `0..=SIDE`.
    #[inline(always)]
    fn at(&self, k: usize) -> f32x8 {
        let row = &self.data[k * self.stride..][..SIDE + 1];
        let (value, next) = (load(row), load(&row[1..]));
        value + self.fraction * (next - value)
    }
}

/// Loads the first eight values.
#[inline(always)]
fn load(data: &[f32]) -> f32x8 {
    f32x8::new(*data.first_chunk().expect("the border has room for every patch"))
}

#[inline(always)]
fn copy_patch(plane: &PaddedPlane, start: usize) -> [f32x8; SIDE] {
    let data = &plane.data[start..];
    let mut patch = [f32x8::ZERO; SIDE];
    for (k, row) in patch.iter_mut().enumerate() {
        *row = load(&data[k * plane.stride..]);
    }
    patch
}

#[inline(always)]
fn subtract_mean(mut patch: [f32x8; SIDE]) -> [f32x8; SIDE] {
    let mut sum = f32x8::ZERO;
    patch.iter().for_each(|&row| sum += row);
    let mean = f32x8::splat(total(sum) / (SIDE * SIDE) as f32);
    patch.iter_mut().for_each(|row| *row -= mean);
    patch
}

/// Sums eight values in an order that is the same on every machine.
#[inline(always)]
fn total(values: f32x8) -> f32 {
    let [a, b, c, d, e, f, g, h] = values.to_array();
    ((a + e) + (b + f)) + ((c + g) + (d + h))
}

// From patches to pixels: each pixel takes the weighted mean of the patches over it.

/// Smallest difference of brightness that lowers a patch's weight, in grey levels; smaller ones are noise (DIS).
const MIN_DIFFERENCE: f32 = 1.0;

/// Sums over the patches that cover each pixel, padded because patches hang over the border.
#[derive(Debug, Clone, Default)]
struct WeightedSums {
    u: Vec<f32>,
    v: Vec<f32>,
    weight: Vec<f32>,
}

/// Computes the mean displacement at every pixel, each patch weighted by `1 / max(1, difference)²` at this pixel (DIS: not
/// squared).
///
/// The grid covers the level, so every pixel has a weight.
fn densify(from: &Level, to: &Level, grid: &PatchGrid, sums: &mut WeightedSums, flow: &mut FlowField) {
    let length = from.image.data.len();
    [&mut sums.u, &mut sums.v, &mut sums.weight].into_iter().for_each(|plane| fill_zeros(plane, length));
    for patch in 0..grid.u.len() {
        add_patch(from, to, grid, patch, sums);
    }
    for y in 0..from.image.height {
        let row = (y + PAD) * from.image.stride + PAD..;
        let weight = &sums.weight[row.clone()];
        for (out, plane) in [(&mut flow.u, &sums.u[row.clone()]), (&mut flow.v, &sums.v[row.clone()])] {
            for ((value, sum), weight) in out.row_mut(y).iter_mut().zip(plane).zip(weight) {
                *value = sum / weight;
            }
        }
    }
}

/// Sets the length, and all values to zero; faster than `resize` of a cleared vector.
fn fill_zeros(values: &mut Vec<f32>, length: usize) {
    values.resize(length, 0.0);
    values.fill(0.0);
}

/// Adds one patch to the sums.
#[inline(always)]
fn add_patch(from: &Level, to: &Level, grid: &PatchGrid, patch: usize, sums: &mut WeightedSums) {
    let (u, v) = (grid.u[patch], grid.v[patch]);
    let corner = grid.corner(patch);
    let (x, fx) = split_position(corner.0 as f32 + u, to.image.width);
    let (y, fy) = split_position(corner.1 as f32 + v, to.image.height);
    let (start, stride) = (from.image.index(corner.0, corner.1), from.image.stride);
    let span = start..start + (SIDE - 1) * stride + SIDE;
    let template = &from.image.data[span.clone()];
    let WeightedSums { u: sum_u, v: sum_v, weight: sum_weight } = sums;
    let [sum_u, sum_v, sum_weight] = [sum_u, sum_v, sum_weight].map(|plane| &mut plane[span.clone()]);
    let (u, v, min) = (f32x8::splat(u), f32x8::splat(v), f32x8::splat(MIN_DIFFERENCE));
    let rows = InterpolatedRows::new(&to.image, x, y, fx);
    let (fy, mut upper) = (f32x8::splat(fy), rows.at(0));
    for k in 0..SIDE {
        let lower = rows.at(k + 1);
        let difference = (upper + fy * (lower - upper) - load(&template[k * stride..])).abs();
        // NaN becomes the minimum.
        let difference = difference.cmp_gt(min).blend(difference, min);
        let weight = f32x8::ONE / (difference * difference);
        add(&mut sum_u[k * stride..], weight * u);
        add(&mut sum_v[k * stride..], weight * v);
        add(&mut sum_weight[k * stride..], weight);
        upper = lower;
    }
}

#[inline(always)]
fn add(sums: &mut [f32], values: f32x8) {
    let sums = &mut sums[..SIDE];
    sums.copy_from_slice(&(load(sums) + values).to_array());
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
            super::super::FlowPyramid::from_smooth(&luma)
        };
        let (from, to) = (pyramid(0.0, 0.0), pyramid(1.3, -0.8));
        let template = Template::new(&from.levels[0], (16, 12));
        let image = &to.levels[0].image;
        let start = template.compare(image, (0.0, 0.0));
        let end = (0..4).fold(start, |m, _| template.descend(image, m, 8.0));
        assert!((end.at.0 - 1.3).abs() < 0.05 && (end.at.1 + 0.8).abs() < 0.05, "{:?}", end.at);
        let limited = template.descend(image, start, 0.5);
        assert_eq!(limited.at, (0.0, 0.0), "beyond its longest descent a patch stays");
    }
}
