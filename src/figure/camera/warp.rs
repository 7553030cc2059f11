//! Smooth warp of one frame to another, for a camera that moves before a scene that is not flat.
//!
//! Known point matches are compared with a homography. Their residuals are averaged in square cells; cells with few points
//! lean on the average of ever larger cells around them, at last on the homography alone. Cost: O(points + cells).

use super::Homography;
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
}
