//! Where the points of one frame are in another, smoothly over the frame: what a camera does before a scene that is not
//! flat, known at a few points.
//!
//! What the points do besides a homography is averaged in square cells, and cells without points take the average of
//! larger and larger cells around them, down to nothing besides the homography.

use super::Homography;
use crate::image::{Plane, sample_bilinear};

/// Side of the smallest cells, in pixels.
const CELL: usize = 16;
/// How many points the average of a cell four times as large counts as.
const COARSE: f32 = 0.5;

/// A smooth map of one frame's points to another frame.
#[derive(Debug, Clone)]
pub(crate) struct Warp {
    way: Homography,
    /// What is added to the homography, by cells.
    besides: [Plane<f32>; 2],
}

/// Sums over the points of a cell: what they do besides the homography, and how many they are.
type Sums = [f32; 3];

impl Warp {
    /// For frames of `size` pixels. Each point is given in the one frame and in the other.
    pub(crate) fn new(
        size: (usize, usize),
        way: Homography,
        points: impl Iterator<Item = ((f32, f32), (f32, f32))>,
    ) -> Self {
        let mut cells = Plane::filled(size.0.div_ceil(CELL).max(1), size.1.div_ceil(CELL).max(1), [0.0; 3]);
        for ((x, y), (to_x, to_y)) in points {
            let (by_x, by_y) = way.apply(f64::from(x), f64::from(y));
            let place = |v: f32, side: usize| ((v + 0.5).max(0.0) as usize / CELL).min(side - 1);
            let (column, row) = (place(x, cells.width()), place(y, cells.height()));
            let sum: &mut Sums = &mut cells.row_mut(row)[column];
            *sum = [sum[0] + to_x - by_x as f32, sum[1] + to_y - by_y as f32, sum[2] + 1.0];
        }
        let filled = filled(&cells);
        Self { way, besides: [filled.map(|(x, _)| x), filled.map(|(_, y)| y)] }
    }

    /// Where a point goes.
    pub(crate) fn apply(&self, x: f32, y: f32) -> (f32, f32) {
        let (to_x, to_y) = self.way.apply(f64::from(x), f64::from(y));
        let place = |v: f32| (v + 0.5) / CELL as f32 - 0.5;
        let (column, row) = (place(x), place(y));
        (
            to_x as f32 + sample_bilinear(&self.besides[0], column, row),
            to_y as f32 + sample_bilinear(&self.besides[1], column, row),
        )
    }
}

/// The average of each cell, drawn to that of the four times as large cell around it.
fn filled(cells: &Plane<Sums>) -> Plane<(f32, f32)> {
    let (w, h) = (cells.width(), cells.height());
    let coarse = (w > 1 || h > 1).then(|| filled(&halved(cells)));
    Plane::from_fn(w, h, |x, y| {
        let [sum_x, sum_y, count] = cells[(x, y)];
        let (around_x, around_y) = coarse.as_ref().map_or((0.0, 0.0), |coarse| coarse[(x / 2, y / 2)]);
        let all = count + COARSE;
        ((sum_x + COARSE * around_x) / all, (sum_y + COARSE * around_y) / all)
    })
}

fn halved(cells: &Plane<Sums>) -> Plane<Sums> {
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
        let by = |x: f32| warp.apply(x, 32.0).0 - x;
        assert!(by(12.0) > 3.3 && by(90.0) < 0.5 && by(48.0) > by(90.0) && by(48.0) < by(12.0));
    }
}
