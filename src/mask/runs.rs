//! Masks in little memory: runs of equal pixels. What undoing needs is kept so.

use crate::image::Plane;

/// A mask as runs, row after row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Runs {
    width: usize,
    height: usize,
    /// End of each run and its label.
    runs: Vec<(u32, u8)>,
}

impl Runs {
    /// The runs of `mask`.
    pub(crate) fn of(mask: &Plane<u8>) -> Self {
        let mut runs = Vec::new();
        let mut end = 0;
        for same in mask.data().chunk_by(|a, b| a == b) {
            end += same.len() as u32;
            runs.push((end, same[0]));
        }
        Self { width: mask.width(), height: mask.height(), runs }
    }

    /// The mask again.
    pub(crate) fn mask(&self) -> Plane<u8> {
        let mut run = 0;
        Plane::from_fn(self.width, self.height, |x, y| {
            let pixel = (y * self.width + x) as u32;
            while self.runs.get(run).is_some_and(|r| r.0 <= pixel) {
                run += 1;
            }
            self.runs.get(run).map_or(0, |r| r.1)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mask_comes_back_as_it_was() {
        for (w, h) in [(1, 1), (7, 3), (64, 48)] {
            for stride in [1, 2, 5, 1000] {
                let mask = Plane::from_fn(w, h, |x, y| ((x * 3 + y * y) / stride % 4) as u8);
                assert_eq!(Runs::of(&mask).mask(), mask);
            }
        }
    }
}
