//! `Plane<T>`: one channel of an image. Pixel centres lie at integer coordinates; rows are contiguous.

use std::ops::{Index, IndexMut};

/// A `width × height` grid of values, row by row without padding.
///
/// Invariants: `data.len() == width * height`. Either side may be zero only in a default plane.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plane<T> {
    data: Vec<T>,
    width: usize,
    height: usize,
}

impl<T: Copy> Plane<T> {
    /// Creates a plane with every value equal to `value`.
    pub fn filled(width: usize, height: usize, value: T) -> Self {
        Self { data: vec![value; width * height], width, height }
    }

    /// Creates a plane from values row by row; `None` if their number is not `width * height`.
    pub fn from_vec(width: usize, height: usize, data: Vec<T>) -> Option<Self> {
        (data.len() == width * height).then_some(Self { data, width, height })
    }

    /// Creates a plane whose value at `(x, y)` is `f(x, y)`.
    pub fn from_fn(width: usize, height: usize, mut f: impl FnMut(usize, usize) -> T) -> Self {
        let mut data = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                data.push(f(x, y));
            }
        }
        Self { data, width, height }
    }

    /// Returns a plane of the same size with `f` applied to every value.
    pub fn map<U: Copy>(&self, f: impl FnMut(T) -> U) -> Plane<U> {
        Plane { data: self.data.iter().copied().map(f).collect(), width: self.width, height: self.height }
    }

    /// Returns the width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Returns the height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Returns all values, row by row.
    pub fn data(&self) -> &[T] {
        &self.data
    }

    /// Returns all values mutably, row by row.
    #[doc(hidden)] // For benchmarks.
    pub fn data_mut(&mut self) -> &mut [T] {
        &mut self.data
    }

    /// Returns the values, row by row, and drops the plane.
    pub fn into_data(self) -> Vec<T> {
        self.data
    }

    /// Returns row `y`.
    pub fn row(&self, y: usize) -> &[T] {
        &self.data[y * self.width..(y + 1) * self.width]
    }

    /// Returns row `y` mutably.
    pub(crate) fn row_mut(&mut self, y: usize) -> &mut [T] {
        &mut self.data[y * self.width..(y + 1) * self.width]
    }
}

impl<T: Copy> Index<(usize, usize)> for Plane<T> {
    type Output = T;

    /// Returns the value at `(x, y)`.
    fn index(&self, (x, y): (usize, usize)) -> &T {
        &self.data[y * self.width + x]
    }
}

impl<T: Copy> IndexMut<(usize, usize)> for Plane<T> {
    fn index_mut(&mut self, (x, y): (usize, usize)) -> &mut T {
        &mut self.data[y * self.width + x]
    }
}
