//! Points in square cells, to ask which lie near a place.

/// Points of one frame by the cell that they lie in; each has a number.
pub(crate) struct Grid {
    side: f32,
    columns: usize,
    rows: usize,
    /// The first and the last point of each cell, [`NONE`] in empty ones.
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
    /// Without points, over `size` pixels. `side` is the side of a cell, in pixels: the largest distance that can be
    /// asked for.
    pub(crate) fn new(size: (usize, usize), side: f32) -> Self {
        let cells = |length: usize| (length as f32 / side) as usize + 1;
        let (columns, rows) = (cells(size.0), cells(size.1));
        Self { side, columns, rows, cells: vec![(NONE, NONE); columns * rows], points: Vec::new() }
    }

    /// Column and row of a point; those outside belong to the outermost cells.
    fn cell(&self, x: f32, y: f32) -> (usize, usize) {
        let place = |v: f32, cells: usize| ((v / self.side) as usize).min(cells - 1);
        (place(x, self.columns), place(y, self.rows))
    }

    pub(crate) fn add(&mut self, number: u32, x: f32, y: f32) {
        let (column, row) = self.cell(x, y);
        let (first, last) = &mut self.cells[row * self.columns + column];
        let place = self.points.len() as u32;
        match self.points.get_mut(*last as usize) {
            Some(before) => before.next = place,
            None => *first = place,
        }
        *last = place;
        self.points.push(Point { number, x, y, next: NONE });
    }

    pub(crate) fn clear(&mut self) {
        self.cells.fill((NONE, NONE));
        self.points.clear();
    }

    /// All points nearer than the side of a cell, and some that are not: the number of each and its squared distance.
    /// By cell, row after row; in a cell in the order in which they came.
    pub(crate) fn around(&self, x: f32, y: f32) -> impl Iterator<Item = (u32, f32)> + '_ {
        let (column, row) = self.cell(x, y);
        let columns = column.saturating_sub(1)..(column + 2).min(self.columns);
        let rows = row.saturating_sub(1)..(row + 2).min(self.rows);
        rows.flat_map(move |r| &self.cells[r * self.columns..][columns.clone()])
            .flat_map(|&(first, _)| self.chain(first))
            .map(move |p| (p.number, (p.x - x) * (p.x - x) + (p.y - y) * (p.y - y)))
    }

    /// A point and all after it in its cell.
    fn chain(&self, first: u32) -> impl Iterator<Item = &Point> {
        std::iter::successors(self.points.get(first as usize), |p| self.points.get(p.next as usize))
    }

    /// Whether no point is nearer than the side of a cell.
    pub(crate) fn is_free(&self, x: f32, y: f32) -> bool {
        let is_far = |distance_sq: f32| distance_sq >= self.side * self.side;
        // In its own cell there most likely is one.
        let (column, row) = self.cell(x, y);
        let mut own = self.chain(self.cells[row * self.columns + column].0);
        own.all(|p| is_far((p.x - x) * (p.x - x) + (p.y - y) * (p.y - y)))
            && self.around(x, y).all(|(_, distance_sq)| is_far(distance_sq))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    const SIZE: (usize, usize) = (100, 80);

    #[test]
    fn the_grid_finds_what_comparing_all_finds() {
        let mut rng = Rng::for_stage(1, "votes");
        let points: Vec<_> =
            (0..300).map(|i| (i, rng.range(-2.0, 102.0) as f32, rng.range(-2.0, 82.0) as f32)).collect();
        for side in [0.5_f32, 7.0, 16.0, 500.0] {
            let mut grid = Grid::new(SIZE, side);
            grid.add(7, 1.0, 1.0);
            grid.clear();
            points.iter().for_each(|&(i, x, y)| grid.add(i, x, y));
            for &(_, x, y) in &points {
                let mut found: Vec<u32> =
                    grid.around(x, y).filter(|&(_, d_sq)| d_sq <= side * side).map(|(i, _)| i).collect();
                found.sort_unstable();
                let within = |p: &&(u32, f32, f32)| (p.1 - x) * (p.1 - x) + (p.2 - y) * (p.2 - y) <= side * side;
                let naive: Vec<u32> = points.iter().filter(within).map(|p| p.0).collect();
                assert_eq!(found, naive);
            }
        }
    }
}
