//! `Plane<T>`: one channel of an image. Pixel centres lie at integer coordinates; rows are contiguous.

use std::ops::{Index, IndexMut};

/// A `width × height` grid of values, row by row without padding.
///
/// Law: `data.len() == width * height`. Either side may be zero only in a default plane.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plane<T> {
    data: Vec<T>,
    width: usize,
    height: usize,
}

impl<T: Copy> Plane<T> {
    /// A plane with every value equal to `value`.
    pub fn filled(width: usize, height: usize, value: T) -> Self {
        Self { data: vec![value; width * height], width, height }
    }

    /// Takes over `data`, row by row; `None` if its length is not `width * height`.
    pub fn from_vec(width: usize, height: usize, data: Vec<T>) -> Option<Self> {
        (data.len() == width * height).then_some(Self { data, width, height })
    }

    /// A plane whose value at `(x, y)` is `f(x, y)`.
    pub fn from_fn(width: usize, height: usize, mut f: impl FnMut(usize, usize) -> T) -> Self {
        let mut data = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                data.push(f(x, y));
            }
        }
        Self { data, width, height }
    }

    /// A plane of the same size with `f` applied to every value.
    pub fn map<U: Copy>(&self, f: impl FnMut(T) -> U) -> Plane<U> {
        Plane { data: self.data.iter().copied().map(f).collect(), width: self.width, height: self.height }
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All values, row by row.
    pub fn data(&self) -> &[T] {
        &self.data
    }

    /// All values, row by row, to write.
    pub fn data_mut(&mut self) -> &mut [T] {
        &mut self.data
    }

    /// The values themselves.
    pub fn into_data(self) -> Vec<T> {
        self.data
    }

    /// Row `y`.
    pub fn row(&self, y: usize) -> &[T] {
        &self.data[y * self.width..(y + 1) * self.width]
    }

    /// Row `y`, to write.
    pub(crate) fn row_mut(&mut self, y: usize) -> &mut [T] {
        &mut self.data[y * self.width..(y + 1) * self.width]
    }
}

impl<T: Copy> Index<(usize, usize)> for Plane<T> {
    type Output = T;

    /// The value at `(x, y)`.
    fn index(&self, (x, y): (usize, usize)) -> &T {
        &self.data[y * self.width + x]
    }
}

impl<T: Copy> IndexMut<(usize, usize)> for Plane<T> {
    fn index_mut(&mut self, (x, y): (usize, usize)) -> &mut T {
        &mut self.data[y * self.width + x]
    }
}
