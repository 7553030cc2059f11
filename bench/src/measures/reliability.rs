//! Whether probabilities are true: of the pixels that are said to be right with .9, nine in ten should be.
//!
//! **In:** masks, what is said of each of their pixels, and a [`Truth`]. **Out:** for each tenth of the probabilities what
//! was said on average, and how many pixels were right in that they are on an object or are not. Pixels that the
//! truth leaves open count nowhere. Every clip counts alike, however long and large it is.

use super::masks::Truth;
use serde::Serialize;
use tracecut::Error;
use tracecut::image::Plane;

/// Tenths.
const BINS: usize = 10;

/// Sums of confidences and of right pixels, in bins of confidence.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Bin {
    /// The mean of what was said.
    pub said: f64,
    /// Share of the pixels that were right.
    pub right: f64,
    /// Share of all pixels that are in this bin.
    pub share: f64,
}

/// Sums over pixels, bin by bin: of what was said, of the right ones, of all.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Reliability {
    bins: [[f64; 3]; BINS],
}

impl Reliability {
    /// Counts a frame; all of one size.
    ///
    /// # Errors
    /// [`Error::Data`] when the sizes differ.
    pub fn add(&mut self, labels: &Plane<u8>, said: &Plane<f32>, truth: &Plane<Truth>) -> Result<(), Error> {
        super::davis::check_sizes((labels.width(), labels.height()), truth)?;
        super::davis::check_sizes((said.width(), said.height()), truth)?;
        for ((&label, &said), &truth) in labels.data().iter().zip(said.data()).zip(truth.data()) {
            let right = match truth {
                Truth::Ignored => continue,
                Truth::Object => label > 0,
                Truth::Background => label == 0,
            };
            let bin = &mut self.bins[((said * BINS as f32) as usize).min(BINS - 1)];
            let add = [f64::from(said), f64::from(u8::from(right)), 1.0];
            bin.iter_mut().zip(add).for_each(|(sum, add)| *sum += add);
        }
        Ok(())
    }

    /// The clips together, each with the same weight.
    pub fn of_clips<'a>(clips: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut total = Self::default();
        for clip in clips {
            let pixels: f64 = clip.bins.iter().map(|bin| bin[2]).sum();
            let sums = total.bins.iter_mut().flatten().zip(clip.bins.iter().flatten());
            sums.for_each(|(sum, add)| *sum += add / pixels.max(1.0));
        }
        total
    }

    /// The tenths from 0 to 1; `None` where nothing is in one.
    pub fn curve(&self) -> Vec<Option<Bin>> {
        let total: f64 = self.bins.iter().map(|bin| bin[2]).sum();
        let bin = |&[said, right, count]: &[f64; 3]| {
            (count > 0.0).then(|| Bin { said: said / count, right: right / count, share: count / total })
        };
        self.bins.iter().map(bin).collect()
    }

    /// Returns the largest distance of the curve from the diagonal, in bins with at least this share of the pixels.
    pub fn furthest(&self, share: f64) -> f64 {
        let fair = self.curve().into_iter().flatten().filter(|bin| bin.share >= share);
        fair.map(|bin| (bin.said - bin.right).abs()).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row<T: Copy>(values: &[T]) -> Plane<T> {
        Plane::from_vec(values.len(), 1, values.to_vec()).unwrap()
    }

    #[test]
    fn bins_hold_what_was_said_and_what_was_right() {
        use Truth::{Background as B, Ignored as I, Object as O};
        let mut found = Reliability::default();
        let truth = row(&[O, B, B, O, I]);
        found.add(&row(&[2, 0, 1, 1, 1]), &row(&[0.95, 0.91, 0.97, 0.25, 0.5]), &truth).unwrap();
        let curve = found.curve();
        let [low, high] = [curve[2].unwrap(), curve[9].unwrap()];
        assert!((high.said - 2.83 / 3.0).abs() < 1e-6 && (high.right - 2.0 / 3.0).abs() < 1e-9, "{high:?}");
        assert_eq!((low.right, low.share, curve[5]), (1.0, 0.25, None));
        assert!((found.furthest(0.3) - (2.83 / 3.0 - 2.0 / 3.0)).abs() < 1e-6);
        assert!((found.furthest(0.2) - 0.75).abs() < 1e-6);
        assert!(found.add(&row(&[1]), &row(&[1.0]), &truth).is_err());
    }

    #[test]
    fn a_long_clip_counts_no_more_than_a_short_one() {
        let mut clips = [Reliability::default(), Reliability::default()];
        for _ in 0..9 {
            clips[0].add(&row(&[1]), &row(&[0.85]), &row(&[Truth::Object])).unwrap();
        }
        clips[1].add(&row(&[1]), &row(&[0.85]), &row(&[Truth::Background])).unwrap();
        let bin = Reliability::of_clips(&clips).curve()[8].unwrap();
        assert_eq!((bin.right, bin.share), (0.5, 1.0));
    }
}
