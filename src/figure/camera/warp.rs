//! Smooth warp of one frame to another, for a camera that moves before a scene that is not flat.
//!
//! Known point matches are compared with a homography. Their residuals are averaged in square cells; cells with few points
//! lean on the average of ever larger cells around them, at last on the homography alone. Cost: O(points + cells).

use crate::image::{Plane, sample_bilinear};

/// Side of the smallest cells. Chosen by eye.
const CELL_PX: usize = 16;
/// Weight of the average of the next larger cell, in points. Chosen by eye.
const COARSE_WEIGHT: f32 = 0.5;

/// A smooth map of one frame's points to another frame.
#[derive(Debug, Clone)]
pub(crate) struct Warp {
    homography: Homography,
    /// Displacement in x and y that is added to the homography, by cells.
    residual: [Plane<f32>; 2],
}

/// Sums over the points of a cell: residual in x and y, and number of points.
type CellSums = [f32; 3];

impl Warp {
    /// Fits the warp of frames of `size` pixels to matched points, each in the one frame and in the other.
    pub(crate) fn new(
        size: (usize, usize),
        homography: Homography,
        matches: impl Iterator<Item = ((f32, f32), (f32, f32))>,
    ) -> Self {
        let mut cells = Plane::filled(size.0.div_ceil(CELL_PX).max(1), size.1.div_ceil(CELL_PX).max(1), [0.0; 3]);
        for ((x, y), (to_x, to_y)) in matches {
            let (predicted_x, predicted_y) = homography.apply(f64::from(x), f64::from(y));
            let cell = |v: f32, side: usize| ((v + 0.5).max(0.0) as usize / CELL_PX).min(side - 1);
            let (column, row) = (cell(x, cells.width()), cell(y, cells.height()));
            let sum: &mut CellSums = &mut cells.row_mut(row)[column];
            *sum = [sum[0] + to_x - predicted_x as f32, sum[1] + to_y - predicted_y as f32, sum[2] + 1.0];
        }
        let means = smooth_means(&cells);
        Self { homography, residual: [means.map(|(x, _)| x), means.map(|(_, y)| y)] }
    }

    /// Maps a point.
    pub(crate) fn apply(&self, x: f32, y: f32) -> (f32, f32) {
        let (to_x, to_y) = self.homography.apply(f64::from(x), f64::from(y));
        let cell = |v: f32| (v + 0.5) / CELL_PX as f32 - 0.5;
        let [dx, dy] = self.residual.each_ref().map(|plane| sample_bilinear(plane, cell(x), cell(y)));
        (to_x as f32 + dx, to_y as f32 + dy)
    }
}

/// Mean residual of each cell, drawn towards the mean of the four times as large cell around it.
fn smooth_means(cells: &Plane<CellSums>) -> Plane<(f32, f32)> {
    let (w, h) = (cells.width(), cells.height());
    let coarse = (w > 1 || h > 1).then(|| smooth_means(&halve(cells)));
    Plane::from_fn(w, h, |x, y| {
        let [sum_x, sum_y, count] = cells[(x, y)];
        let (coarse_x, coarse_y) = coarse.as_ref().map_or((0.0, 0.0), |coarse| coarse[(x / 2, y / 2)]);
        let weight = count + COARSE_WEIGHT;
        ((sum_x + COARSE_WEIGHT * coarse_x) / weight, (sum_y + COARSE_WEIGHT * coarse_y) / weight)
    })
}

fn halve(cells: &Plane<CellSums>) -> Plane<CellSums> {
    let (w, h) = (cells.width(), cells.height());
    Plane::from_fn(w.div_ceil(2), h.div_ceil(2), |x, y| {
        let mut sum = [0.0; 3];
        for row in 2 * y..(2 * y + 2).min(h) {
            for column in 2 * x..(2 * x + 2).min(w) {
                (0..3).for_each(|k| sum[k] += cells[(column, row)][k]);
            }
        }
        sum
    })
}

/// Maps `(x, y)` to `(a x + b y + c, d x + e y + f) / (g x + h y + i)`; holds the nine numbers row by row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Homography(pub(super) [f64; 9]);

impl Homography {
    pub(crate) const IDENTITY: Self = Self([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);

    /// Maps a point.
    pub(crate) fn apply(&self, x: f64, y: f64) -> (f64, f64) {
        let m = &self.0;
        let w = 1.0 / (m[6] * x + m[7] * y + m[8]);
        ((m[0] * x + m[1] * y + m[2]) * w, (m[3] * x + m[4] * y + m[5]) * w)
    }

    /// Returns the map that applies `before` and then `self`.
    pub(super) fn after(&self, before: &Self) -> Self {
        let (a, b) = (&self.0, &before.0);
        let entry = |k: usize| (0..3).map(|j| a[k / 3 * 3 + j] * b[j * 3 + k % 3]).sum();
        Self(std::array::from_fn(entry)).normalized()
    }

    /// Returns the inverse map, or the identity if it is singular.
    pub(super) fn inverse(&self) -> Self {
        let m = &self.0;
        let minor = |a: usize, b: usize, c: usize, d: usize| m[a] * m[d] - m[b] * m[c];
        let adjugate = [
            minor(4, 5, 7, 8),
            -minor(1, 2, 7, 8),
            minor(1, 2, 4, 5),
            -minor(3, 5, 6, 8),
            minor(0, 2, 6, 8),
            -minor(0, 2, 3, 5),
            minor(3, 4, 6, 7),
            -minor(0, 1, 6, 7),
            minor(0, 1, 3, 4),
        ];
        let determinant = m[0] * adjugate[0] + m[1] * adjugate[3] + m[2] * adjugate[6];
        if determinant == 0.0 || !determinant.is_finite() { Self::IDENTITY } else { Self(adjugate).normalized() }
    }

    /// Returns the same map for images reduced by `scale`.
    pub(super) fn rescaled(&self, scale: f64) -> Self {
        // Pixel centres are at whole numbers.
        let shift = 0.5 * (scale - 1.0);
        let up = Self([scale, 0.0, shift, 0.0, scale, shift, 0.0, 0.0, 1.0]);
        up.inverse().after(&self.after(&up))
    }

    fn normalized(self) -> Self {
        let w = self.0[8];
        if w == 0.0 { self } else { Self(self.0.map(|v| v / w)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(to: impl Fn(f32, f32) -> (f32, f32)) -> Vec<((f32, f32), (f32, f32))> {
        let at = |k: usize| (4.0 + 8.0 * (k % 12) as f32, 4.0 + 8.0 * (k / 12) as f32);
        (0..96).map(at).map(|(x, y)| ((x, y), to(x, y))).collect()
    }

    #[test]
    fn without_points_it_is_the_homography() {
        let warp = Warp::new((96, 64), Homography::IDENTITY, std::iter::empty());
        assert_eq!(warp.apply(30.0, 20.5), (30.0, 20.5));
    }

    #[test]
    fn points_that_move_alike_move_all() {
        let points = grid(|x, y| (x + 3.0, y - 1.0));
        let warp = Warp::new((96, 64), Homography::IDENTITY, points.into_iter());
        let (x, y) = warp.apply(50.0, 30.0);
        assert!((x - 53.0).abs() < 0.5 && (y - 29.0).abs() < 0.3, "{x} {y}");
    }

    #[test]
    fn what_is_near_moves_by_its_own_points_and_what_is_unknown_by_those_around() {
        let points = grid(|x, y| (if x < 48.0 { x + 4.0 } else { x }, y));
        let warp =
            Warp::new((96, 64), Homography::IDENTITY, points.into_iter().filter(|((x, _), _)| *x < 40.0 || *x > 56.0));
        let shift = |x: f32| warp.apply(x, 32.0).0 - x;
        assert!(shift(12.0) > 3.3 && shift(90.0) < 0.5 && shift(48.0) > shift(90.0) && shift(48.0) < shift(12.0));
    }

    const MAP: Homography = Homography([1.1, 0.1, 3.0, -0.05, 0.9, -2.0, 1e-4, -2e-4, 1.0]);

    fn is_near(a: (f64, f64), b: (f64, f64)) -> bool {
        (a.0 - b.0).abs() < 1e-9 && (a.1 - b.1).abs() < 1e-9
    }

    #[test]
    fn one_after_the_other_and_back() {
        let second = Homography([0.8, 0.0, 1.0, 0.2, 1.2, 0.0, 0.0, 1e-3, 1.0]);
        for (x, y) in [(0.0, 0.0), (10.0, 5.0), (120.0, 90.0)] {
            let (u, v) = MAP.apply(x, y);
            assert!(is_near(second.after(&MAP).apply(x, y), second.apply(u, v)));
            assert!(is_near(MAP.inverse().apply(u, v), (x, y)));
        }
        assert_eq!(Homography([0.0; 9]).inverse(), Homography::IDENTITY);
    }

    #[test]
    fn in_reduced_images_points_go_where_their_pixels_go() {
        let small = MAP.rescaled(4.0);
        for (x, y) in [(0.0, 0.0), (7.0, 3.0)] {
            let (u, v) = MAP.apply(4.0 * x + 1.5, 4.0 * y + 1.5);
            assert!(is_near(small.apply(x, y), ((u - 1.5) / 4.0, (v - 1.5) / 4.0)));
        }
    }
}
