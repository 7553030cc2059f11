//! The numbers of the DAVIS 2016 benchmark: region similarity J, boundary measure F, and their summary over a clip.
//!
//! **In:** a mask and the true mask of one frame, as planes that are true on the foreground; for the summary one number
//! a frame. **Out:** [`region_similarity`] and [`boundary_measure`] in `0.0..=1.0`, 1 best; [`Summary`].
//!
//! 1. J is intersection over union.
//! 2. The boundary of a mask are the pixels that differ from their right, lower or lower right neighbour. A boundary
//!    pixel is matched if the other mask has a boundary pixel no farther off than 0.008 of the image's diagonal,
//!    rounded up to whole pixels. Precision is the matched share of the mask's boundary, recall the matched share of the true one, F
//!    their harmonic mean.
//! 3. The benchmark leaves out the first and the last frame ([`scored_frames`]). Recall is the share of frames above
//!    0.5; decay is the mean over the first quarter of the frames minus the mean over the last one.
//!
//! The benchmark knows foreground and background only. A segmentation into labels is scored as it stands, all labels
//! other than 0 being foreground; or with the help of the truth, to tell wrong labels from a wrong choice among them
//! ([`LabelTally`]).
//!
//! Source: Perazzi et al., "A Benchmark Dataset and Evaluation Methodology for Video Object Segmentation", CVPR 2016,
//! and the behaviour of its published program.

use serde::Serialize;
use std::ops::Range;
use tracecut::Error;
use tracecut::image::Plane;

/// Share of the image's diagonal within which boundaries match.
const TOLERANCE: f64 = 0.008;
/// A frame counts for the recall when its score is above this.
const RECALLED_ABOVE: f64 = 0.5;

/// The frames of a clip that count: all but the first and the last.
pub fn scored_frames(num_frames: usize) -> Range<usize> {
    1..num_frames.saturating_sub(1).max(1)
}

/// Intersection over union; 1 when both masks are empty.
///
/// # Errors
/// [`Error::Data`] when the sizes differ.
pub fn region_similarity(mask: &Plane<bool>, truth: &Plane<bool>) -> Result<f64, Error> {
    check_sizes((mask.width(), mask.height()), truth)?;
    let (mut both, mut either) = (0_u64, 0_u64);
    for (&m, &t) in mask.data().iter().zip(truth.data()) {
        both += u64::from(m & t);
        either += u64::from(m | t);
    }
    Ok(if either == 0 { 1.0 } else { both as f64 / either as f64 })
}

/// Harmonic mean of boundary precision and recall.
///
/// A mask without a boundary has precision 1, as none of it is wrong, and recall 0 if there is a true boundary; so F is
/// 1 when both boundaries are empty and 0 when one is.
///
/// # Errors
/// [`Error::Data`] when the sizes differ.
pub fn boundary_measure(mask: &Plane<bool>, truth: &Plane<bool>) -> Result<f64, Error> {
    boundary_measure_within(tolerance_px(mask.width(), mask.height()), mask, truth)
}

/// [`boundary_measure`] where boundaries match that are at most `radius` pixels apart.
///
/// # Errors
/// [`Error::Data`] when the sizes differ.
pub fn boundary_measure_within(radius: usize, mask: &Plane<bool>, truth: &Plane<bool>) -> Result<f64, Error> {
    check_sizes((mask.width(), mask.height()), truth)?;
    let (boundary_found, boundary_true) = (boundary(mask), boundary(truth));
    let precision = matched_share(&boundary_found, &boundary_true, radius);
    let recall = matched_share(&boundary_true, &boundary_found, radius);
    Ok(if precision + recall == 0.0 { 0.0 } else { 2.0 * precision * recall / (precision + recall) })
}

/// Largest distance between matching boundaries, in pixels.
pub fn tolerance_px(width: usize, height: usize) -> usize {
    let diagonal = ((width * width + height * height) as f64).sqrt();
    (TOLERANCE * diagonal).ceil() as usize
}

/// The pixels that differ from their right, lower or lower right neighbour inside the image.
pub fn boundary(mask: &Plane<bool>) -> Plane<bool> {
    let (width, height) = (mask.width(), mask.height());
    Plane::from_fn(width, height, |x, y| {
        let (right, below) = (x + 1 < width, y + 1 < height);
        let value = mask[(x, y)];
        (right && mask[(x + 1, y)] != value)
            || (below && mask[(x, y + 1)] != value)
            || (right && below && mask[(x + 1, y + 1)] != value)
    })
}

/// Share of the true pixels of `of` with one of `near` no farther than `radius`; 1 if `of` has none.
fn matched_share(of: &Plane<bool>, near: &Plane<bool>, radius: usize) -> f64 {
    let is_near = dilated(near, radius);
    let (mut total, mut matched) = (0_u64, 0_u64);
    for (&pixel, &is_near) in of.data().iter().zip(is_near.data()) {
        total += u64::from(pixel);
        matched += u64::from(pixel & is_near);
    }
    if total == 0 { 1.0 } else { matched as f64 / total as f64 }
}

/// All pixels within `radius` of a true one: for each of these the rows of a disc are filled in.
fn dilated(plane: &Plane<bool>, radius: usize) -> Plane<bool> {
    let (width, height) = (plane.width(), plane.height());
    let reach: Vec<usize> = (0..=radius).map(|dy| (radius * radius - dy * dy).isqrt()).collect();
    let mut wide = Plane::filled(width, height, false);
    for y in 0..height {
        for x in (0..width).filter(|&x| plane[(x, y)]) {
            for row in y.saturating_sub(radius)..(y + radius + 1).min(height) {
                let reach = reach[row.abs_diff(y)];
                wide.data_mut()[row * width..][x.saturating_sub(reach)..(x + reach + 1).min(width)].fill(true);
            }
        }
    }
    wide
}

pub(super) fn check_sizes<T: Copy>((w, h): (usize, usize), truth: &Plane<T>) -> Result<(), Error> {
    let (tw, th) = (truth.width(), truth.height());
    if (w, h) == (tw, th) {
        return Ok(());
    }
    Err(Error::Data { reason: format!("mask is {w}x{h} and the true mask {tw}x{th} (expected one size)") })
}

/// One measure over the frames of a clip.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Summary {
    /// Mean over the frames.
    pub mean: f64,
    /// Share of the frames above 0.5.
    pub recall: f64,
    /// Mean over the first quarter of the frames minus the mean over the last: what is lost on the way.
    pub decay: f64,
}

impl Summary {
    /// Summary of one value a frame; all zero without values.
    ///
    /// Quarters, as the benchmark's program takes them: of `n` values the five marks `i (n - 1) / 4`, `i = 0..=4`, are
    /// rounded to whole numbers, halves up; a quarter runs from one mark to the next, both included, so that
    /// neighbouring quarters share a value.
    pub fn new(values: &[f64]) -> Self {
        if values.is_empty() {
            return Self::default();
        }
        let mark = |i: usize| (i * (values.len() - 1) + 2) / 4;
        let quarter = |i: usize| average(&values[mark(i)..=mark(i + 1)]);
        let recalled = values.iter().filter(|&&v| v > RECALLED_ABOVE).count();
        Self { mean: average(values), recall: recalled as f64 / values.len() as f64, decay: quarter(0) - quarter(3) }
    }

    /// Mean of each number over clips; all zero without clips.
    pub fn mean_of(clips: &[Self]) -> Self {
        let over = |value: fn(&Self) -> f64| average(&clips.iter().map(value).collect::<Vec<f64>>());
        Self { mean: over(|s| s.mean), recall: over(|s| s.recall), decay: over(|s| s.decay) }
    }
}

fn average(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Pixels of each label on the true foreground and on the background, over the frames of a clip.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LabelTally {
    /// Label by label: pixels on the background, on the foreground.
    counts: Vec<[u64; 2]>,
}

impl LabelTally {
    /// Nothing counted yet; labels are `0..num_labels`.
    pub fn new(num_labels: usize) -> Self {
        Self { counts: vec![[0; 2]; num_labels] }
    }

    /// Counts one frame.
    ///
    /// # Errors
    /// [`Error::Data`] when the sizes differ or a label is too large; the frame may then be counted in part.
    pub fn add(&mut self, labels: &Plane<u32>, truth: &Plane<bool>) -> Result<(), Error> {
        check_sizes((labels.width(), labels.height()), truth)?;
        let num_labels = self.counts.len();
        for (&label, &truth) in labels.data().iter().zip(truth.data()) {
            let Some(counts) = self.counts.get_mut(label as usize) else {
                return Err(Error::Data { reason: format!("label {label} (expected 0..{num_labels})") });
            };
            counts[usize::from(truth)] += 1;
        }
        Ok(())
    }

    /// Marks the labels with more than half of their pixels on the true foreground. This choice minimises wrong pixels, and
    /// need not maximise region similarity.
    pub fn oracle_foreground(&self) -> Vec<bool> {
        self.counts.iter().map(|[background, foreground]| foreground > background).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracecut::rng::Rng;

    /// True where the rows have a `#`.
    fn mask(rows: &[&str]) -> Plane<bool> {
        let data = rows.iter().flat_map(|r| r.bytes()).map(|b| b == b'#').collect();
        Plane::from_vec(rows[0].len(), rows.len(), data).unwrap()
    }

    fn rectangle((width, height): (usize, usize), x: Range<usize>, y: Range<usize>) -> Plane<bool> {
        Plane::from_fn(width, height, |px, py| x.contains(&px) && y.contains(&py))
    }

    fn j(a: &Plane<bool>, b: &Plane<bool>) -> f64 {
        region_similarity(a, b).unwrap()
    }

    fn f(a: &Plane<bool>, b: &Plane<bool>) -> f64 {
        boundary_measure(a, b).unwrap()
    }

    #[test]
    fn region_similarity_of_rectangles_is_their_intersection_over_their_union() {
        let a = rectangle((40, 30), 5..25, 5..15);
        let b = rectangle((40, 30), 15..35, 10..20);
        assert_eq!(j(&a, &b), 50.0 / 350.0);
        assert_eq!((j(&a, &a), f(&a, &a)), (1.0, 1.0));
    }

    #[test]
    fn empty_masks_follow_the_conventions_of_the_benchmark() {
        let empty = Plane::filled(40, 30, false);
        let full = empty.map(|_| true);
        let some = rectangle((40, 30), 5..25, 5..15);
        assert_eq!((j(&empty, &empty), f(&empty, &empty)), (1.0, 1.0));
        assert_eq!((j(&empty, &some), f(&empty, &some)), (0.0, 0.0));
        assert_eq!((j(&some, &empty), f(&some, &empty)), (0.0, 0.0));
        // The image's own border is no boundary.
        assert_eq!((j(&full, &empty), f(&full, &empty)), (0.0, 1.0));
    }

    #[test]
    fn boundary_pixels_differ_from_a_neighbour_to_the_right_or_below() {
        let drawn = boundary(&mask(&[".....", "..##.", "..##.", "....."]));
        assert_eq!(drawn, mask(&[".###.", ".#.#.", ".###.", "....."]));
        // In the last row only the right neighbour counts, in the last column only the lower one.
        assert_eq!(boundary(&mask(&["...", "..#", "..#"])), mask(&[".##", ".#.", ".#."]));
        assert_eq!(boundary(&mask(&["#"])), mask(&["."]));
    }

    #[test]
    fn boundaries_match_up_to_the_tolerance_and_not_beyond() {
        assert_eq!((tolerance_px(854, 480), tolerance_px(100, 75), tolerance_px(1, 1)), (8, 1, 1));
        let strip = |x: usize| rectangle((854, 480), x..854, 0..480);
        assert_eq!(f(&strip(100), &strip(108)), 1.0);
        assert_eq!(f(&strip(100), &strip(109)), 0.0);
        // Half of the boundary found is right, all of the true one is found: 2 / (1 + 2).
        let two = Plane::from_fn(854, 480, |x, _| (100..400).contains(&x));
        assert_eq!(f(&two, &strip(100)), 2.0 / 3.0);
    }

    /// F by its definition, pixel pair by pixel pair.
    fn naive_f(a: &Plane<bool>, b: &Plane<bool>, radius: f64) -> f64 {
        let points = |p: &Plane<bool>| {
            let p = boundary(p);
            let all = (0..p.data().len()).filter(|&i| p.data()[i]);
            all.map(|i| ((i % p.width()) as f64, (i / p.width()) as f64)).collect::<Vec<_>>()
        };
        let share = |of: &[(f64, f64)], near: &[(f64, f64)]| {
            let hit = of.iter().filter(|p| near.iter().any(|q| (p.0 - q.0).hypot(p.1 - q.1) <= radius)).count();
            if of.is_empty() { 1.0 } else { hit as f64 / of.len() as f64 }
        };
        let (a, b) = (points(a), points(b));
        let (p, r) = (share(&a, &b), share(&b, &a));
        if p + r > 0.0 { 2.0 * p * r / (p + r) } else { 0.0 }
    }

    #[test]
    fn measures_of_random_masks_equal_their_definitions() {
        let mut rng = Rng::for_stage(17, "davis");
        let mut seen = 0;
        for trial in 0..60_usize {
            // Wide images, so that the tolerance grows to several pixels at few pixels.
            let (width, height) = (1 + rng.below(700), 1 + rng.below(6));
            let step = 1 + rng.below(200);
            let mut random = || {
                let flips: Vec<bool> = (0..width.div_ceil(step) * height).map(|_| rng.below(2) == 0).collect();
                Plane::from_fn(width, height, |x, y| flips[x / step * height + y / (1 + trial % 3)])
            };
            let (a, b) = (random(), random());
            let radius = (TOLERANCE * (width as f64).hypot(height as f64)).ceil();
            let naive = naive_f(&a, &b, radius);
            assert!((f(&a, &b) - naive).abs() < 1e-12, "{width}x{height}: {} (expected {naive})", f(&a, &b));
            assert_eq!((j(&a, &b), f(&a, &b)), (j(&b, &a), f(&b, &a)));
            let pairs = || a.data().iter().zip(b.data());
            let (both, either) = (pairs().filter(|p| *p.0 && *p.1).count(), pairs().filter(|p| *p.0 || *p.1).count());
            assert_eq!(j(&a, &b), if either == 0 { 1.0 } else { both as f64 / either as f64 });
            seen += usize::from(naive > 0.0 && naive < 1.0);
        }
        assert!(seen > 20, "only {seen} trials with an F between 0 and 1");
    }

    #[test]
    fn the_first_and_the_last_frame_do_not_count() {
        assert_eq!(scored_frames(5), 1..4);
        assert!([0, 1, 2].iter().all(|&n| scored_frames(n).is_empty()));
    }

    #[test]
    fn summaries_follow_the_quarters_of_the_benchmark() {
        // Marks of 7 values: 0, 1.5, 3, 4.5, 6, so the quarters are 0..=2 and 5..=6.
        let summary = Summary::new(&[0.9, 0.6, 0.6, 0.5, 0.4, 0.3, 0.2]);
        assert!((summary.mean - 0.5).abs() < 1e-12 && (summary.decay - (0.7 - 0.25)).abs() < 1e-12, "{summary:?}");
        // 0.5 itself is not above 0.5.
        assert_eq!(summary.recall, 3.0 / 7.0);
        assert_eq!(Summary::new(&[0.8]), Summary { mean: 0.8, recall: 1.0, decay: 0.0 });
        assert_eq!(Summary::new(&[]), Summary::default());
        let two = [Summary::new(&[0.8]), Summary::new(&[0.2])];
        assert_eq!(Summary::mean_of(&two), Summary { mean: 0.5, recall: 0.5, decay: 0.0 });
    }

    #[test]
    fn the_oracle_takes_labels_that_lie_mostly_on_the_truth() {
        let labels = Plane::from_vec(5, 1, vec![0, 7, 7, 7, 9]).unwrap();
        let mut tally = LabelTally::new(10);
        tally.add(&labels, &mask(&[".##.#"])).unwrap();
        let chosen = |tally: &LabelTally| {
            let oracle = tally.oracle_foreground();
            (0..oracle.len()).filter(|&l| oracle[l]).collect::<Vec<_>>()
        };
        assert_eq!(chosen(&tally), [7, 9]);
        // Another frame takes label 7 to three of six pixels, which is not more than half, and label 0 to two of two.
        tally.add(&labels, &mask(&["##..#"])).unwrap();
        assert_eq!(chosen(&tally), [9]);
        tally.add(&labels.map(|_| 0), &mask(&["###.."])).unwrap();
        assert_eq!(chosen(&tally), [0, 9]);
        assert!(tally.add(&labels, &mask(&["..."])).is_err());
        let message = LabelTally::new(9).add(&labels, &mask(&["....."])).unwrap_err().to_string();
        assert_eq!(message, "label 9 (expected 0..9)");
    }

    #[test]
    fn masks_of_different_sizes_are_refused() {
        let (a, b) = (Plane::filled(4, 3, true), Plane::filled(3, 4, true));
        let message = region_similarity(&a, &b).unwrap_err().to_string();
        assert!(message.contains("4x3") && message.contains("3x4"), "{message}");
        assert!(boundary_measure(&a, &b).is_err());
    }
}
