//! A plane stored for checkerboard sweeps: each row as its even columns, then its odd ones.
//!
//! ```text
//! row y:  | margin  x=0  x=2  x=4 .. margin | margin  x=1  x=3  x=5 .. margin |
//! ```
//!
//! All pixels of one colour in a row are then neighbours in memory, and so are the pixels to the left of them, to the
//! right, above and below: a sweep over one colour is a plain loop over slices of equal length, which compiles to
//! vector instructions.

/// Empty cells before and after each half row.
const MARGIN: usize = 1;

/// A plane in the order above, with one empty row above and below; or as many rows of it as are needed at a time, each in
/// the place of one that is needed no more.
///
/// Law: margins, the rows outside, and the last odd cell of an odd width are zero; a solver that gives them no equation
/// and no edge leaves them so.
#[derive(Debug, Clone, Default)]
pub(super) struct Checkerboard {
    data: Vec<f32>,
    width: usize,
    /// Rows that are held: row `y` lies at `y + 1`, modulo this.
    rows: usize,
    /// Cells of a half row, margins included.
    half: usize,
}

/// The four neighbours of each pixel of a half row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Around<'a> {
    pub(super) left: &'a [f32],
    pub(super) right: &'a [f32],
    pub(super) up: &'a [f32],
    pub(super) down: &'a [f32],
}

// Called once a row: copies of them wherever they are called would only make the file larger.
impl Checkerboard {
    /// Gives the plane this size. A plane that has it already keeps its values.
    pub(super) fn resize(&mut self, width: usize, height: usize) {
        self.hold(width, height + 2);
    }

    /// Gives the plane this width, and room for this number of `rows`, those above and below counted.
    #[inline(never)]
    pub(super) fn hold(&mut self, width: usize, rows: usize) {
        let half = width.div_ceil(2) + 2 * MARGIN;
        let length = 2 * half * rows;
        if (self.width, self.rows) != (width, rows) {
            (self.width, self.rows, self.half) = (width, rows, half);
            self.data.clear();
            self.data.resize(length, 0.0);
        }
    }

    /// Pixels of a half row; for an odd width the last odd one is empty.
    pub(super) fn cells(&self) -> usize {
        self.half - 2 * MARGIN
    }

    /// The columns of `parity` in row `y`, which counts from -1.
    #[inline(never)]
    pub(super) fn row(&self, y: isize, parity: usize) -> &[f32] {
        &self.data[self.start(y, parity)..][..self.half - 2 * MARGIN]
    }

    /// The same, to write.
    #[inline(never)]
    pub(super) fn row_mut(&mut self, y: usize, parity: usize) -> &mut [f32] {
        let (start, cells) = (self.start(y as isize, parity), self.cells());
        &mut self.data[start..][..cells]
    }

    /// The pixels to the left of those of `parity`. Even pixel `k` has the odd `k - 1` there, odd pixel `k` the even
    /// `k`.
    #[inline(never)]
    pub(super) fn left_of(&self, y: isize, parity: usize) -> &[f32] {
        &self.data[self.start(y, 1 - parity) + parity - 1..][..self.half - 2 * MARGIN]
    }

    /// The pixels to the right of those of `parity`.
    #[inline(never)]
    pub(super) fn right_of(&self, y: isize, parity: usize) -> &[f32] {
        &self.data[self.start(y, 1 - parity) + parity..][..self.half - 2 * MARGIN]
    }

    /// The columns of `parity` in row `y` to write, and their neighbours, in a plane that holds all rows.
    pub(super) fn around_mut(&mut self, y: usize, parity: usize) -> (Around<'_>, &mut [f32]) {
        let (half, cells) = (self.half, self.cells());
        let (above, rest) = self.data.split_at_mut((y + 1) * 2 * half);
        let (here, below) = rest.split_at_mut(2 * half);
        let (even, odd) = here.split_at_mut(half);
        let (own, other) = if parity == 0 { (even, odd) } else { (odd, even) };
        let around = Around {
            left: &other[MARGIN + parity - 1..][..cells],
            right: &other[MARGIN + parity..][..cells],
            up: &above[y * 2 * half + parity * half + MARGIN..][..cells],
            down: &below[parity * half + MARGIN..][..cells],
        };
        (around, &mut own[MARGIN..][..cells])
    }

    /// Fills row `y` from values in the usual order.
    #[inline(never)]
    pub(super) fn write(&mut self, y: usize, values: &[f32]) {
        let half = self.half;
        let start = self.start(y as isize, 0) - MARGIN;
        let (even, odd) = self.data[start..][..2 * half].split_at_mut(half);
        let pairs = values.chunks_exact(2);
        if let [last] = pairs.remainder() {
            even[half - MARGIN - 1] = *last;
        }
        for ((e, o), pair) in even[MARGIN..].iter_mut().zip(&mut odd[MARGIN..]).zip(pairs) {
            (*e, *o) = (pair[0], pair[1]);
        }
    }

    /// Row `y` in the usual order.
    pub(super) fn read(&self, y: usize, values: &mut [f32]) {
        let (even, odd) = (self.row(y as isize, 0), self.row(y as isize, 1));
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

    #[inline(never)]
    fn start(&self, y: isize, parity: usize) -> usize {
        ((y + 1) as usize % self.rows * 2 + parity) * self.half + MARGIN
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
            plane.resize(width, height);
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
                assert_eq!(own[x / 2], value(x, y));
                let expected = |inside: bool, v: f32| if inside { v } else { 0.0 };
                assert_eq!(around.left[x / 2], expected(x > 0, value(x, y) - 1.0));
                assert_eq!(around.right[x / 2], expected(x + 1 < width, value(x, y) + 1.0));
                assert_eq!(around.up[x / 2], expected(y > 0, value(x, y) - 100.0));
                assert_eq!(around.down[x / 2], expected(y + 1 < height, value(x, y) + 100.0));
                let (left, right) = (around.left[x / 2], around.right[x / 2]);
                assert_eq!(
                    (plane.left_of(y as isize, x % 2)[x / 2], plane.right_of(y as isize, x % 2)[x / 2]),
                    (left, right)
                );
            }
        }
    }
}
