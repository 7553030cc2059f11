//! A uniform grid over points of the plane: neighbours within a radius in time proportional to their number.

/// Numbered points of one frame, sorted into square cells.
pub(crate) struct Grid {
    side: f32,
    columns: usize,
    rows: usize,
    /// First and last point of each cell, [`NONE`] in empty cells.
    cells: Vec<(u32, u32)>,
    points: Vec<Point>,
}

/// A point, and the next one in its cell.
struct Point {
    number: u32,
    x: f32,
    y: f32,
    next: u32,
}

const NONE: u32 = u32::MAX;

impl Grid {
    /// Creates an empty grid over a frame of `width × height` pixels. `side` is the side of a cell in pixels, which is the largest
    /// radius of a query.
    pub(crate) fn new(width: usize, height: usize, side: f32) -> Self {
        let cells = |length: usize| (length as f32 / side) as usize + 1;
        let (columns, rows) = (cells(width), cells(height));
        Self { side, columns, rows, cells: vec![(NONE, NONE); columns * rows], points: Vec::new() }
    }

    /// Returns column and row of a point; points outside belong to the outermost cells.
    fn cell(&self, x: f32, y: f32) -> (usize, usize) {
        let index = |v: f32, cells: usize| ((v / self.side) as usize).min(cells - 1);
        (index(x, self.columns), index(y, self.rows))
    }

    pub(crate) fn add(&mut self, number: u32, x: f32, y: f32) {
        let (column, row) = self.cell(x, y);
        let (first, last) = &mut self.cells[row * self.columns + column];
        let index = self.points.len() as u32;
        match self.points.get_mut(*last as usize) {
            Some(previous) => previous.next = index,
            None => *first = index,
        }
        *last = index;
        self.points.push(Point { number, x, y, next: NONE });
    }

    pub(crate) fn clear(&mut self) {
        self.cells.fill((NONE, NONE));
        self.points.clear();
    }

    /// Returns number and squared distance of all points nearer than the side of a cell, and of some that are farther:
    /// by cell, row after row, and within a cell in the order of insertion.
    pub(crate) fn nearby(&self, x: f32, y: f32) -> impl Iterator<Item = (u32, f32)> + '_ {
        let (column, row) = self.cell(x, y);
        let columns = column.saturating_sub(1)..(column + 2).min(self.columns);
        let rows = row.saturating_sub(1)..(row + 2).min(self.rows);
        rows.flat_map(move |r| &self.cells[r * self.columns..][columns.clone()])
            .flat_map(|&(first, _)| self.chain(first))
            .map(move |p| (p.number, (p.x - x) * (p.x - x) + (p.y - y) * (p.y - y)))
    }

    /// Returns a point and all later ones of its cell.
    fn chain(&self, first: u32) -> impl Iterator<Item = &Point> {
        std::iter::successors(self.points.get(first as usize), |p| self.points.get(p.next as usize))
    }

    /// Returns true if no point is nearer than the side of a cell.
    pub(crate) fn is_free(&self, x: f32, y: f32) -> bool {
        let is_far = |distance_sq: f32| distance_sq >= self.side * self.side;
        // The cell of the place itself is the most likely to hold one.
        let (column, row) = self.cell(x, y);
        let mut same_cell = self.chain(self.cells[row * self.columns + column].0);
        same_cell.all(|p| is_far((p.x - x) * (p.x - x) + (p.y - y) * (p.y - y)))
            && self.nearby(x, y).all(|(_, distance_sq)| is_far(distance_sq))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn the_grid_finds_what_comparing_all_finds() {
        let mut rng = Rng::for_stage(1, "votes");
        let points: Vec<_> =
            (0..300).map(|i| (i, rng.range(-2.0, 102.0) as f32, rng.range(-2.0, 82.0) as f32)).collect();
        for side in [0.5_f32, 7.0, 16.0, 500.0] {
            let mut grid = Grid::new(100, 80, side);
            grid.add(7, 1.0, 1.0);
            grid.clear();
            points.iter().for_each(|&(i, x, y)| grid.add(i, x, y));
            for &(_, x, y) in &points {
                let mut found: Vec<u32> =
                    grid.nearby(x, y).filter(|&(_, d_sq)| d_sq <= side * side).map(|(i, _)| i).collect();
                found.sort_unstable();
                let within = |p: &&(u32, f32, f32)| (p.1 - x) * (p.1 - x) + (p.2 - y) * (p.2 - y) <= side * side;
                let naive: Vec<u32> = points.iter().filter(within).map(|p| p.0).collect();
                assert_eq!(found, naive);
            }
        }
    }
}
