//! How well superpixels keep to the regions that people drew.
//!
//! With regions g of one annotator, superpixels s and N pixels:
//!
//! - boundary recall: share of the boundary pixels of the regions with a boundary pixel of the superpixels within 2
//!   pixels;
//! - under-segmentation error: (1/N) Σ_g Σ_{s touching g} min(|s ∩ g|, |s \ g|), the smaller part of each superpixel
//!   that a region cuts in two (Neubert and Protzel, "Superpixel Benchmark and Comparison", 2012);
//! - leak: (1/N) Σ_g Σ_{|s ∩ g| > 5 % of |s|} |s| − 1, the older form of that error (Achanta et al., "SLIC
//!   Superpixels", 2012);
//! - achievable segmentation accuracy: (1/N) Σ_s max_g |s ∩ g| (Liu et al., "Entropy Rate Superpixel Segmentation",
//!   2011).
//!
//! A boundary pixel differs from the one to its right or the one below.

use tracecut::Error;
use tracecut::image::Plane;

/// Tolerance of matching boundaries, in pixels.
const TOLERANCE: isize = 2;
/// Share of a superpixel that may lie in a region without counting as leaked into it.
const MAY_OVERLAP: f64 = 0.05;

/// The measures of one label map against one annotator, or their means; 0 to 1, `leak` from 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SuperpixelScores {
    /// Boundary recall.
    pub recall: f64,
    /// Under-segmentation error.
    pub under: f64,
    /// Under-segmentation error in its older form.
    pub leak: f64,
    /// Achievable segmentation accuracy.
    pub accuracy: f64,
}

impl SuperpixelScores {
    /// The mean of `scores`; all 0 if there are none.
    pub fn mean(scores: &[Self]) -> Self {
        let mean = |value: fn(&Self) -> f64| scores.iter().map(value).sum::<f64>() / scores.len().max(1) as f64;
        Self {
            recall: mean(|s| s.recall),
            under: mean(|s| s.under),
            leak: mean(|s| s.leak),
            accuracy: mean(|s| s.accuracy),
        }
    }
}

/// Scores the superpixels `label` against the `regions` of one annotator.
///
/// # Errors
/// [`Error::Data`] when the sizes differ.
pub fn score_superpixels(label: &Plane<u32>, regions: &Plane<u16>) -> Result<SuperpixelScores, Error> {
    let size = (label.width(), label.height());
    let expected = (regions.width(), regions.height());
    if size != expected {
        let reason = format!("labels are {}x{} (expected {}x{})", size.0, size.1, expected.0, expected.1);
        return Err(Error::Data { reason });
    }
    let mut scores = overlap_scores(label, regions);
    scores.recall = boundary_recall(label, regions);
    Ok(scores)
}

/// All but the recall, from the sizes of the common parts of superpixels and regions.
fn overlap_scores(label: &Plane<u32>, regions: &Plane<u16>) -> SuperpixelScores {
    let mut pairs: Vec<(u32, u16)> = label.data().iter().copied().zip(regions.data().iter().copied()).collect();
    pairs.sort_unstable();
    let (mut under, mut leak, mut accurate) = (0, 0, 0);
    for superpixel in pairs.chunk_by(|p, q| p.0 == q.0) {
        let size = superpixel.len();
        let mut largest = 0;
        for part in superpixel.chunk_by(|p, q| p.1 == q.1) {
            under += part.len().min(size - part.len());
            if part.len() as f64 > MAY_OVERLAP * size as f64 {
                leak += size;
            }
            largest = largest.max(part.len());
        }
        accurate += largest;
    }
    let share = |count: usize| count as f64 / pairs.len().max(1) as f64;
    SuperpixelScores {
        recall: 0.0,
        under: share(under),
        // Parts that are all small leave a superpixel uncounted; more than none cannot be made up for by fewer.
        leak: (share(leak) - 1.0).max(0.0),
        accuracy: share(accurate),
    }
}

fn boundary_recall(label: &Plane<u32>, regions: &Plane<u16>) -> f64 {
    let (boundary_found, boundary_true) = (boundary(label), boundary(regions));
    let (width, height) = (label.width() as isize, label.height() as isize);
    let is_near = |x: isize, y: isize| {
        (-TOLERANCE..=TOLERANCE).any(|dy| {
            (-TOLERANCE..=TOLERANCE).any(|dx| {
                dx * dx + dy * dy <= TOLERANCE * TOLERANCE
                    && (0..width).contains(&(x + dx))
                    && (0..height).contains(&(y + dy))
                    && boundary_found[((x + dx) as usize, (y + dy) as usize)]
            })
        })
    };
    let (mut hits, mut total) = (0, 0);
    for y in 0..height {
        for x in 0..width {
            if boundary_true[(x as usize, y as usize)] {
                total += 1;
                hits += usize::from(is_near(x, y));
            }
        }
    }
    // Nothing to be found is found wholly.
    if total == 0 { 1.0 } else { hits as f64 / total as f64 }
}

fn boundary<T: Copy + PartialEq>(plane: &Plane<T>) -> Plane<bool> {
    Plane::from_fn(plane.width(), plane.height(), |x, y| {
        let label = plane[(x, y)];
        (x + 1 < plane.width() && plane[(x + 1, y)] != label) || (y + 1 < plane.height() && plane[(x, y + 1)] != label)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Halves of a 12×6 image, parted before column `at`.
    fn halves(at: usize) -> Plane<u16> {
        Plane::from_fn(12, 6, |x, _| u16::from(x >= at))
    }

    #[test]
    fn regions_themselves_are_perfect_superpixels() {
        let s = score_superpixels(&halves(5).map(u32::from), &halves(5)).unwrap();
        assert_eq!(s, SuperpixelScores { recall: 1.0, under: 0.0, leak: 0.0, accuracy: 1.0 });
    }

    #[test]
    fn one_superpixel_for_all_pays_the_smaller_part_twice() {
        let s = score_superpixels(&Plane::filled(12, 6, 0), &halves(3)).unwrap();
        // A quarter of the superpixel lies in the first region: it counts there, and as the part outside of the second.
        assert_eq!(s, SuperpixelScores { recall: 0.0, under: 0.5, leak: 1.0, accuracy: 0.75 });
    }

    #[test]
    fn boundaries_are_found_two_pixels_away_but_not_three() {
        let recall = |at| score_superpixels(&halves(at).map(u32::from), &halves(5)).unwrap().recall;
        assert_eq!([recall(3), recall(7), recall(2), recall(8)], [1.0, 1.0, 0.0, 0.0]);
    }

    #[test]
    fn a_sliver_of_a_superpixel_does_not_count_as_leak() {
        let label = Plane::from_fn(100, 1, |x, _| u32::from((4..50).contains(&x)) + 2 * u32::from(x >= 50));
        let regions = Plane::from_fn(100, 1, |x, _| u16::from(x >= 52));
        let s = score_superpixels(&label, &regions).unwrap();
        assert_eq!((s.under, s.leak, s.accuracy), (0.04, 0.0, 0.98));
    }

    #[test]
    fn sizes_must_agree_and_nothing_scores_nothing() {
        assert_eq!(score_superpixels(&Plane::filled(3, 2, 0), &halves(1)).unwrap_err().code(), "data");
        assert_eq!(SuperpixelScores::mean(&[]), SuperpixelScores::default());
    }
}
