//! A plane stored for checkerboard sweeps: each row as its even columns, then its odd ones.
//!
//! ```text
//! row y:  | margin  x=0  x=2  x=4 .. margin | margin  x=1  x=3  x=5 .. margin |
//! ```
//!
//! All pixels of one colour in a row are then neighbours in memory, and so are the pixels to the left of them, to the
//! right, above and below: a sweep over one colour is a loop over slices of equal length, [`LANES`] numbers at a time.

use std::iter;

/// Numbers that a kernel takes at a time; the cells of a half row are a multiple of it.
pub(super) const LANES: usize = 8;
/// These numbers.
pub(super) type Lanes = [f32; LANES];

/// Empty cells before and after each half row.
const MARGIN: usize = 1;

/// A plane in the order above, with one empty row above and below; or as many rows of it as are needed at a time, each in
/// the place of one that is needed no more.
///
/// Law: margins, the rows outside, and the cells beyond the width are zero; a solver that gives them no equation and no
/// edge leaves them so.
#[derive(Debug, Clone, Default)]
pub(super) struct Checkerboard {
    data: Vec<f32>,
    width: usize,
    rows: Rows,
    /// Cells of a half row, margins included.
    half: usize,
}

/// The four neighbours of each pixel of a half row, [`LANES`] at a time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Around<'a> {
    pub(super) left: &'a [Lanes],
    pub(super) right: &'a [Lanes],
    pub(super) up: &'a [Lanes],
    pub(super) down: &'a [Lanes],
}

// Called once a row: copies of them wherever they are called would only make the file larger.
impl Checkerboard {
    /// Gives the plane this width, and room for these `rows`. A plane that has both already keeps its values.
    #[inline(never)]
    pub(super) fn hold(&mut self, width: usize, rows: Rows) {
        if (self.width, self.rows) != (width, rows) {
            let half = blocks(width) * LANES + 2 * MARGIN;
            (self.width, self.rows, self.half) = (width, rows, half);
            self.data.clear();
            self.data.resize(2 * half * rows.held, 0.0);
        }
    }

    /// The columns of `parity` in row `y`, which counts from -1.
    #[inline(never)]
    pub(super) fn row(&self, y: isize, parity: usize) -> &[Lanes] {
        self.cells(self.start(y, parity))
    }

    /// The same, to write.
    #[inline(never)]
    pub(super) fn row_mut(&mut self, y: usize, parity: usize) -> &mut [Lanes] {
        let (start, cells) = (self.start(y as isize, parity), self.half - 2 * MARGIN);
        self.data[start..][..cells].as_chunks_mut().0
    }

    /// The pixels to the left of those of `parity`. Even pixel `k` has the odd `k - 1` there, odd pixel `k` the even
    /// `k`.
    #[inline(never)]
    pub(super) fn left_of(&self, y: isize, parity: usize) -> &[Lanes] {
        self.cells(self.start(y, 1 - parity) + parity - 1)
    }

    /// The pixels to the right of those of `parity`.
    #[inline(never)]
    pub(super) fn right_of(&self, y: isize, parity: usize) -> &[Lanes] {
        self.cells(self.start(y, 1 - parity) + parity)
    }

    /// The columns of `parity` in row `y` to write, and their neighbours, in a plane that holds all rows.
    #[inline(never)]
    pub(super) fn around_mut(&mut self, y: usize, parity: usize) -> (Around<'_>, &mut [Lanes]) {
        let (half, cells) = (self.half, self.half - 2 * MARGIN);
        let (above, rest) = self.data.split_at_mut((y + 1) * 2 * half);
        let (here, below) = rest.split_at_mut(2 * half);
        let (even, odd) = here.split_at_mut(half);
        let (own, other) = if parity == 0 { (even, odd) } else { (odd, even) };
        let around = Around {
            left: other[MARGIN + parity - 1..][..cells].as_chunks().0,
            right: other[MARGIN + parity..][..cells].as_chunks().0,
            up: above[y * 2 * half + parity * half + MARGIN..][..cells].as_chunks().0,
            down: below[parity * half + MARGIN..][..cells].as_chunks().0,
        };
        (around, own[MARGIN..][..cells].as_chunks_mut().0)
    }

    /// The cells of `parity` in row `y` from the first that has no right neighbour on.
    pub(super) fn beyond_right(&mut self, y: usize, parity: usize) -> &mut [f32] {
        let width = self.width;
        &mut self.row_mut(y, parity).as_flattened_mut()[(width - parity) / 2..]
    }

    /// Fills row `y` from values in the usual order.
    #[inline(never)]
    pub(super) fn write(&mut self, y: usize, values: &[f32]) {
        let half = self.half;
        let start = self.start(y as isize, 0) - MARGIN;
        let (even, odd) = self.data[start..][..2 * half].split_at_mut(half);
        let pairs = values.chunks_exact(2);
        if let [last] = pairs.remainder() {
            even[MARGIN + values.len() / 2] = *last;
        }
        for ((e, o), pair) in even[MARGIN..].iter_mut().zip(&mut odd[MARGIN..]).zip(pairs) {
            (*e, *o) = (pair[0], pair[1]);
        }
    }

    /// Row `y` in the usual order.
    pub(super) fn read(&self, y: usize, values: &mut [f32]) {
        let [even, odd] = [0, 1].map(|parity| self.row(y as isize, parity).as_flattened());
        let middle = values.len() / 2;
        let mut pairs = values.chunks_exact_mut(2);
        for ((e, o), pair) in even.iter().zip(odd).zip(&mut pairs) {
            (pair[0], pair[1]) = (*e, *o);
        }
        if let [last] = pairs.into_remainder() {
            *last = even[middle];
        }
    }

    /// The row above the first becomes zero again.
    pub(super) fn clear_above(&mut self) {
        self.data[..2 * self.half].fill(0.0);
    }

    fn cells(&self, start: usize) -> &[Lanes] {
        self.data[start..][..self.half - 2 * MARGIN].as_chunks().0
    }

    fn start(&self, y: isize, parity: usize) -> usize {
        (self.rows.place(y) * 2 + parity) * self.half + MARGIN
    }
}

/// Blocks of [`LANES`] pixels of one colour in a row.
fn blocks(width: usize) -> usize {
    width.div_ceil(2).div_ceil(LANES)
}

/// Which rows of a plane are held, those above the first and below the last counted.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Rows {
    held: usize,
    /// Row `y` lies at `y + 1`, of which these bits count: a division would cost as much as half of a row's sweep.
    mask: usize,
}

impl Rows {
    /// All of a plane.
    pub(super) fn all(height: usize) -> Self {
        Self { held: height + 2, mask: usize::MAX }
    }

    /// At least the last `rows` of a plane.
    pub(super) fn last(rows: usize, height: usize) -> Self {
        let held = rows.next_power_of_two();
        if held < height + 2 { Self { held, mask: held - 1 } } else { Self::all(height) }
    }

    fn place(self, y: isize) -> usize {
        (y + 1) as usize & self.mask
    }
}

/// `N` numbers a pixel in the same order, [`LANES`] pixels of one and then of the next: they are always read together, and
/// one address serves all.
#[derive(Debug, Clone)]
pub(super) struct Bundle<const N: usize> {
    data: Vec<[Lanes; N]>,
    rows: Rows,
    half: usize,
}

impl<const N: usize> Default for Bundle<N> {
    fn default() -> Self {
        Self { data: Vec::new(), rows: Rows::default(), half: 0 }
    }
}

impl<const N: usize> Bundle<N> {
    /// Gives the bundle this width, and room for these `rows`. A bundle that has both already keeps its values.
    pub(super) fn hold(&mut self, width: usize, rows: Rows) {
        let half = blocks(width);
        if (self.half, self.rows) != (half, rows) {
            (self.half, self.rows) = (half, rows);
            self.data.clear();
            self.data.resize(2 * half * rows.held, [[0.0; LANES]; N]);
        }
    }

    /// The columns of `parity` in row `y`.
    pub(super) fn row(&self, y: usize, parity: usize) -> &[[Lanes; N]] {
        &self.data[(self.rows.place(y as isize) * 2 + parity) * self.half..][..self.half]
    }

    /// The same, to write.
    pub(super) fn row_mut(&mut self, y: usize, parity: usize) -> &mut [[Lanes; N]] {
        &mut self.data[(self.rows.place(y as isize) * 2 + parity) * self.half..][..self.half]
    }

    /// Fills row `y` from `N` rows of values in the usual order; the cells beyond their length become zero.
    #[inline(never)]
    pub(super) fn write(&mut self, y: usize, values: &[Vec<f32>; N]) {
        for parity in 0..2 {
            for (block, cells) in self.row_mut(y, parity).iter_mut().enumerate() {
                let start = 2 * LANES * block + parity;
                for (cells, values) in cells.iter_mut().zip(values) {
                    let part = &values[start.min(values.len())..];
                    if let Some(part) = part.first_chunk::<{ 2 * LANES - 1 }>() {
                        for k in 0..LANES {
                            cells[k] = part[2 * k];
                        }
                    } else {
                        let rest = part.iter().step_by(2).copied().chain(iter::repeat(0.0));
                        cells.iter_mut().zip(rest).for_each(|(cell, value)| *cell = value);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_return_as_written_and_neighbours_are_the_four_beside_a_pixel() {
        for (width, height) in [(7, 3), (8, 4), (1, 1), (2, 1)] {
            let value = |x: usize, y: usize| (1 + x + 100 * y) as f32;
            let mut plane = Checkerboard::default();
            plane.hold(width, Rows::all(height));
            for y in 0..height {
                plane.write(y, &(0..width).map(|x| value(x, y)).collect::<Vec<_>>());
            }
            let mut row = vec![0.0; width];
            for y in 0..height {
                plane.read(y, &mut row);
                assert_eq!(row, (0..width).map(|x| value(x, y)).collect::<Vec<_>>());
            }
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                let (around, own) = plane.around_mut(y, x % 2);
                assert_eq!(own.as_flattened()[x / 2], value(x, y));
                let at = |cells: &[Lanes]| cells.as_flattened()[x / 2];
                let expected = |inside: bool, v: f32| if inside { v } else { 0.0 };
                assert_eq!(at(around.left), expected(x > 0, value(x, y) - 1.0));
                assert_eq!(at(around.right), expected(x + 1 < width, value(x, y) + 1.0));
                assert_eq!(at(around.up), expected(y > 0, value(x, y) - 100.0));
                assert_eq!(at(around.down), expected(y + 1 < height, value(x, y) + 100.0));
                let beside = (at(around.left), at(around.right));
                assert_eq!((at(plane.left_of(y as isize, x % 2)), at(plane.right_of(y as isize, x % 2))), beside);
            }
        }
    }
}
