//! Run-length coded planes, to keep superpixels and undo steps in little memory.

use super::Plane;
use std::ops::Range;

/// A plane as runs of equal values, row after row; a run may continue on the next row.
///
/// Invariants: ends increase to `width * height`; neighbouring runs differ in value.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Runs<T> {
    width: usize,
    height: usize,
    /// End of each run and its value.
    runs: Vec<(u32, T)>,
}

impl<T: Copy + PartialEq> Runs<T> {
    /// Encodes `plane`.
    pub(crate) fn from_plane(plane: &Plane<T>) -> Self {
        let mut end = 0;
        let ends = plane.data().chunk_by(|a, b| a == b).map(|run| {
            end += run.len() as u32;
            (end, run[0])
        });
        let mut runs: Vec<_> = ends.collect();
        runs.shrink_to_fit();
        Self { width: plane.width(), height: plane.height(), runs }
    }

    /// Creates a plane from the end and value of each run; `None` if they break the invariants.
    #[cfg(any(feature = "wasm", test))]
    pub(crate) fn from_vec(width: usize, height: usize, runs: Vec<(u32, T)>) -> Option<Self> {
        let is_valid = runs.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[0].1 != pair[1].1)
            && runs.first().is_none_or(|run| run.0 > 0)
            && runs.last().map_or(0, |run| run.0 as usize) == width * height;
        is_valid.then_some(Self { width, height, runs })
    }

    /// Returns width and height in pixels.
    pub(crate) fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Returns end and value of each run.
    pub(crate) fn ends(&self) -> &[(u32, T)] {
        &self.runs
    }

    /// Returns the runs of each row: row, columns, value.
    pub(crate) fn rows(&self) -> impl Iterator<Item = (usize, Range<usize>, T)> {
        let (width, mut begin) = (self.width.max(1), 0);
        self.runs.iter().flat_map(move |&(end, value)| {
            let (start, end) = (std::mem::replace(&mut begin, end as usize), end as usize);
            (start / width..end.div_ceil(width)).map(move |y| {
                let first = y * width;
                (y, start.max(first) - first..end.min(first + width) - first, value)
            })
        })
    }

    /// Decodes the plane with `f` applied to every value.
    pub(crate) fn map<U: Copy>(&self, mut f: impl FnMut(T) -> U) -> Plane<U> {
        let mut data = Vec::with_capacity(self.width * self.height);
        self.runs.iter().for_each(|&(end, value)| data.resize(end as usize, f(value)));
        Plane::from_vec(self.width, self.height, data).expect("runs end where the plane does")
    }

    /// Decodes the plane.
    pub(crate) fn to_plane(&self) -> Plane<T> {
        self.map(|value| value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decoding_returns_the_encoded_plane() {
        for (w, h) in [(1, 1), (7, 3), (64, 48)] {
            for stride in [1, 2, 5, 1000] {
                let plane = Plane::from_fn(w, h, |x, y| ((x * 3 + y * y) / stride % 4) as u8);
                let runs = Runs::from_plane(&plane);
                assert_eq!(runs.to_plane(), plane);
                let mut seen = 0;
                for (y, columns, value) in runs.rows() {
                    assert_eq!(y * w + columns.start, seen);
                    seen = y * w + columns.end;
                    assert!(columns.end <= w && plane.row(y)[columns].iter().all(|&v| v == value));
                }
                assert_eq!(seen, w * h);
                assert_eq!(Runs::from_vec(w, h, runs.ends().to_vec()), Some(runs));
            }
        }
        assert_eq!(Runs::from_plane(&Plane::<u32>::default()), Runs::default());
    }

    #[test]
    fn invalid_runs_are_refused() {
        for runs in [&[][..], &[(3, 1)], &[(0, 2), (4, 1)], &[(2, 1), (4, 1)], &[(3, 1), (2, 2), (4, 1)], &[(5, 1)]] {
            assert_eq!(Runs::from_vec(2, 2, runs.to_vec()), None, "{runs:?}");
        }
    }
}
