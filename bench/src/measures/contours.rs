//! How well a boundary map agrees with the outlines that people drew (Berkeley benchmark).
//!
//! In: a map of strengths, 0 off its thin lines, and the outlines of several people. Out: precision and recall at every
//! threshold.
//!
//! A pixel of the map and a pixel of an outline may be *matched* when they are no further apart than a tolerance, by
//! custom 0.0075 of the image's diagonal ([`tolerance`]). Two ways of counting:
//!
//! - **One-to-one**, the benchmark's own: for each person and threshold a largest matching in which every pixel has at
//!   most one partner. Precision is the share of the map's pixels that are matched with the outline of at least one
//!   person; recall is the share of the outline pixels of all people, counted together, that are matched.
//! - **Nearest**: a pixel counts as matched when there is any pixel of the other kind within the tolerance. It forgives
//!   double lines.
//!
//! A largest matching that grows by one pixel of the map after the other, strongest first, is a largest matching of
//! every threshold's pixels on its way: a pixel once matched stays matched (its partner may change), and one that could
//! not be matched when its turn came never can be later. So one pass per person gives all thresholds (Kuhn's augmenting
//! paths; what a failed search has seen is closed for good and never searched again).
//!
//! **Deviations from the benchmark's program.** It weighs distances too, with a random approximation; here the size of
//! the matching alone counts, near pixels being tried first. It thins the map again at each threshold; here the map
//! must come thin. It takes 99 even thresholds and interpolates; here they are [`THRESHOLDS`] quantiles of the
//! strengths in all images together, so that a monotone change of the strengths changes no score.
//!
//! Source: Martin, Fowlkes and Malik, "Learning to Detect Natural Image Boundaries Using Local Brightness, Color, and
//! Texture Cues", PAMI 2004; Arbelaez et al., "Contour Detection and Hierarchical Image Segmentation", PAMI 2011.

use tracecut::Error;
use tracecut::image::Plane;

/// Thresholds at which maps are scored.
pub const THRESHOLDS: usize = 99;

/// The benchmark's tolerance for an image: 0.0075 of its diagonal, in pixels.
pub fn tolerance(width: usize, height: usize) -> f64 {
    0.0075 * ((width * width + height * height) as f64).sqrt()
}

/// The matching of pixels of map and outline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Matching {
    /// Each pixel has at most one partner.
    OneToOne,
    /// Any number of partners.
    Nearest,
}

/// The contribution of one image: strengths, from which the counts at every threshold follow.
///
/// Law: each list falls; `correct.len() <= found.len()`, `recalled.len() <= truth`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ImageScore {
    /// Strengths of the map's pixels.
    pub found: Vec<f32>,
    /// Strengths of those that match an outline.
    pub correct: Vec<f32>,
    /// Strength down to which the threshold must fall for an outline pixel to be matched, for each that ever is.
    pub recalled: Vec<f32>,
    /// Outline pixels of all people.
    pub truth: usize,
}

/// Precision and recall of a set of images at one threshold.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Quality {
    /// Smallest strength that counts as boundary; for a mixture of thresholds 0.
    pub threshold: f32,
    /// Share of the map's pixels that lie on an outline; 0 when there are none.
    pub precision: f64,
    /// Share of the outline pixels that the map has; 0 when there are none.
    pub recall: f64,
}

impl Quality {
    /// Harmonic mean of precision and recall.
    pub fn f(&self) -> f64 {
        let sum = self.precision + self.recall;
        if sum > 0.0 { 2.0 * self.precision * self.recall / sum } else { 0.0 }
    }
}

/// The two numbers of the benchmark.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Summary {
    /// At the one threshold that is best for all images together (ODS).
    pub ods: Quality,
    /// With the best threshold for each image (OIS).
    pub ois: Quality,
}

/// Scores the thin lines of `map` (pixels above 0) against the outlines of several people.
///
/// # Errors
/// [`Error::Data`] when the sizes differ or a strength is not a number.
pub fn score(
    map: &Plane<f32>,
    people: &[Plane<bool>],
    tolerance: f64,
    matching: Matching,
) -> Result<ImageScore, Error> {
    let size = (map.width(), map.height());
    for outline in people {
        let actual = (outline.width(), outline.height());
        if actual != size {
            let reason = format!("outlines are {}x{} (expected {}x{})", actual.0, actual.1, size.0, size.1);
            return Err(Error::Data { reason });
        }
    }
    if map.data().iter().any(|v| v.is_nan()) {
        return Err(Error::Data { reason: "a boundary strength is not a number".into() });
    }
    let mut pixels: Vec<usize> = (0..map.data().len()).filter(|&i| map.data()[i] > 0.0).collect();
    pixels.sort_by(|&a, &b| map.data()[b].total_cmp(&map.data()[a]).then(a.cmp(&b)));
    let offsets = disc(tolerance);
    let mut correct = vec![false; map.data().len()];
    let mut result = ImageScore::default();
    for outline in people {
        result.truth += outline.data().iter().filter(|&&on| on).count();
        let recalled = match matching {
            Matching::OneToOne => match_one_to_one(map, &pixels, outline, &offsets, &mut correct),
            Matching::Nearest => match_nearest(map, &pixels, outline, &offsets, &mut correct),
        };
        result.recalled.extend(recalled);
    }
    result.recalled.sort_by(|a, b| b.total_cmp(a));
    result.correct = pixels.iter().filter(|&&i| correct[i]).map(|&i| map.data()[i]).collect();
    result.found = pixels.iter().map(|&i| map.data()[i]).collect();
    Ok(result)
}

/// ODS and OIS over images.
pub fn summarize(images: &[ImageScore]) -> Summary {
    let mut strengths: Vec<f32> = images.iter().flat_map(|s| s.found.iter().copied()).collect();
    strengths.sort_by(f32::total_cmp);
    let count = strengths.len();
    let mut ods = Quality::default();
    let mut best: Vec<(f64, Counts)> = vec![(-1.0, Counts::default()); images.len()];
    for k in 0..THRESHOLDS.min(count) {
        let threshold = strengths[k * count / THRESHOLDS.min(count)];
        let mut total = Counts::default();
        for (image, best) in images.iter().zip(&mut best) {
            let counts = Counts::at(image, threshold);
            total.add(counts);
            let f = counts.quality(threshold).f();
            if f > best.0 {
                *best = (f, counts);
            }
        }
        let quality = total.quality(threshold);
        if quality.f() > ods.f() {
            ods = quality;
        }
    }
    let mut sum = Counts::default();
    best.iter().for_each(|&(_, counts)| sum.add(counts));
    Summary { ods, ois: sum.quality(0.0) }
}

#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    found: usize,
    correct: usize,
    recalled: usize,
    truth: usize,
}

impl Counts {
    fn at(image: &ImageScore, threshold: f32) -> Self {
        let reaching = |falling: &[f32]| falling.partition_point(|&v| v >= threshold);
        Self {
            found: reaching(&image.found),
            correct: reaching(&image.correct),
            recalled: reaching(&image.recalled),
            truth: image.truth,
        }
    }

    fn add(&mut self, other: Self) {
        self.found += other.found;
        self.correct += other.correct;
        self.recalled += other.recalled;
        self.truth += other.truth;
    }

    fn quality(self, threshold: f32) -> Quality {
        let share = |part: usize, total: usize| part as f64 / total.max(1) as f64;
        Quality { threshold, precision: share(self.correct, self.found), recall: share(self.recalled, self.truth) }
    }
}

/// Steps to all pixels within `radius`, nearest first.
fn disc(radius: f64) -> Vec<(i32, i32)> {
    let reach = radius.max(0.0).floor() as i32;
    let square = |(dx, dy): (i32, i32)| dx * dx + dy * dy;
    let mut steps: Vec<(i32, i32)> = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy))).collect();
    steps.retain(|&s| f64::from(square(s)) <= radius * radius);
    steps.sort_by_key(|&s| (square(s), s));
    steps
}

/// The pixels at `steps` from pixel `i` that lie in the image.
fn neighbours<'a>(i: usize, plane: &Plane<bool>, steps: &'a [(i32, i32)]) -> impl Iterator<Item = usize> + 'a {
    let (width, height) = (plane.width() as i32, plane.height() as i32);
    let (x, y) = (i as i32 % width, i as i32 / width);
    steps.iter().filter_map(move |&(dx, dy)| {
        let (x, y) = (x + dx, y + dy);
        ((0..width).contains(&x) && (0..height).contains(&y)).then_some((y * width + x) as usize)
    })
}

/// Marks the pixels of `found` that lie near `outline`; gives the strength at which each outline pixel is first
/// reached.
fn match_nearest(
    map: &Plane<f32>,
    found: &[usize],
    outline: &Plane<bool>,
    steps: &[(i32, i32)],
    correct: &mut [bool],
) -> Vec<f32> {
    let mut is_matched = vec![false; map.data().len()];
    let mut recalled = Vec::new();
    for &i in found {
        for j in neighbours(i, outline, steps).filter(|&j| outline.data()[j]) {
            correct[i] = true;
            if !is_matched[j] {
                is_matched[j] = true;
                recalled.push(map.data()[i]);
            }
        }
    }
    recalled
}

const FREE: usize = usize::MAX;

/// Marks the pixels of `found` that a largest matching gives a partner in `outline`; gives the strengths of these
/// pixels.
fn match_one_to_one(
    map: &Plane<f32>,
    found: &[usize],
    outline: &Plane<bool>,
    steps: &[(i32, i32)],
    correct: &mut [bool],
) -> Vec<f32> {
    let mut search = Search {
        outline,
        steps,
        partner: vec![FREE; map.data().len()],
        seen: vec![0; map.data().len()],
        from: vec![FREE; map.data().len()],
        queue: Vec::new(),
    };
    let mut recalled = Vec::new();
    for (turn, &i) in found.iter().enumerate() {
        if search.augment(i, turn as u32 + 1) {
            correct[i] = true;
            recalled.push(map.data()[i]);
        }
    }
    recalled
}

/// Breadth-first search for augmenting paths; all planes are indexed by pixel.
struct Search<'a> {
    outline: &'a Plane<bool>,
    steps: &'a [(i32, i32)],
    /// The map's pixel that an outline pixel is matched with, or [`FREE`].
    partner: Vec<usize>,
    /// The last turn in which an outline pixel was seen, [`CLOSED`] if no path through it can ever end.
    seen: Vec<u32>,
    /// The map's pixel from which an outline pixel was reached in this turn.
    from: Vec<usize>,
    queue: Vec<usize>,
}

const CLOSED: u32 = u32::MAX;

impl Search<'_> {
    /// Finds a partner for the map's pixel `start`, moving others to new partners if need be.
    fn augment(&mut self, start: usize, turn: u32) -> bool {
        self.queue.clear();
        // Outline pixels in the order of their discovery; `start` itself is searched first.
        let mut next = 0;
        let mut pixel = start;
        loop {
            for j in neighbours(pixel, self.outline, self.steps) {
                if !self.outline.data()[j] || self.seen[j] == turn || self.seen[j] == CLOSED {
                    continue;
                }
                self.seen[j] = turn;
                self.from[j] = pixel;
                if self.partner[j] == FREE {
                    self.turn_over(j, start);
                    return true;
                }
                self.queue.push(j);
            }
            let Some(&j) = self.queue.get(next) else { break };
            next += 1;
            pixel = self.partner[j];
        }
        for &j in &self.queue {
            self.seen[j] = CLOSED;
        }
        false
    }

    /// Changes the matching along the path from `start` to the free outline pixel `end`.
    fn turn_over(&mut self, end: usize, start: usize) {
        let mut j = end;
        loop {
            let pixel = self.from[j];
            // The outline pixel that `pixel` leaves is the one through which it was reached.
            let partner = if pixel == start { None } else { self.old_partner(pixel) };
            self.partner[j] = pixel;
            let Some(partner) = partner else { return };
            j = partner;
        }
    }

    fn old_partner(&self, pixel: usize) -> Option<usize> {
        neighbours(pixel, self.outline, self.steps).find(|&j| self.outline.data()[j] && self.partner[j] == pixel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracecut::rng::Rng;

    fn random_case(rng: &mut Rng, side: usize) -> (Plane<f32>, Plane<bool>) {
        let map = Plane::from_fn(side, side, |_, _| {
            let v = rng.uniform() as f32;
            // Few levels, so that ties occur.
            if v < 0.3 { (v * 20.0).ceil() / 6.0 } else { 0.0 }
        });
        let outline = Plane::from_fn(side, side, |_, _| rng.uniform() < 0.2);
        (map, outline)
    }

    /// Size of a largest matching, by trying every choice.
    fn largest(lines: &[usize], outline: &Plane<bool>, steps: &[(i32, i32)], used: &mut Vec<usize>) -> usize {
        let Some((&first, rest)) = lines.split_first() else { return 0 };
        let mut best = largest(rest, outline, steps, used);
        for j in neighbours(first, outline, steps).filter(|&j| outline.data()[j]) {
            if !used.contains(&j) {
                used.push(j);
                best = best.max(1 + largest(rest, outline, steps, used));
                used.pop();
            }
        }
        best
    }

    #[test]
    fn every_threshold_has_a_largest_matching() {
        let mut rng = Rng::for_stage(5, "contours");
        for case in 0..60 {
            let (map, outline) = random_case(&mut rng, 5);
            let steps = disc(1.5);
            let score = score(&map, std::slice::from_ref(&outline), 1.5, Matching::OneToOne).unwrap();
            for threshold in [0.1, 0.4, 0.6, 0.9] {
                let lines: Vec<usize> = (0..25).filter(|&i| map.data()[i] >= threshold).collect();
                let expected = largest(&lines, &outline, &steps, &mut Vec::new());
                let counts = Counts::at(&score, threshold);
                assert_eq!(
                    (counts.correct, counts.recalled),
                    (expected, expected),
                    "case {case}, threshold {threshold}"
                );
                assert_eq!(counts.found, lines.len());
            }
        }
    }

    #[test]
    fn nearest_counts_equal_those_of_all_pairs() {
        let mut rng = Rng::for_stage(6, "contours");
        let (map, one) = random_case(&mut rng, 12);
        let (_, two) = random_case(&mut rng, 12);
        let people = [one, two];
        let score = score(&map, &people, 2.0, Matching::Nearest).unwrap();
        let near = |i: usize, j: usize| {
            let (dx, dy) = ((i % 12).abs_diff(j % 12), (i / 12).abs_diff(j / 12));
            dx * dx + dy * dy <= 4
        };
        let threshold = 0.5;
        let lines: Vec<usize> = (0..144).filter(|&i| map.data()[i] >= threshold).collect();
        let on = |p: &Plane<bool>| (0..144).filter(|&j| p.data()[j]).collect::<Vec<_>>();
        let correct = lines.iter().filter(|&&i| people.iter().any(|p| on(p).iter().any(|&j| near(i, j)))).count();
        let recalled: usize =
            people.iter().map(|p| on(p).iter().filter(|&&j| lines.iter().any(|&i| near(i, j))).count()).sum();
        let counts = Counts::at(&score, threshold);
        assert_eq!((counts.found, counts.correct, counts.recalled), (lines.len(), correct, recalled));
        assert_eq!(counts.truth, people.iter().map(|p| on(p).len()).sum::<usize>());
    }

    #[test]
    fn a_double_line_is_half_wrong_one_to_one_and_right_to_the_nearest() {
        let map = Plane::from_fn(8, 8, |x, _| if x == 3 || x == 5 { 1.0 } else { 0.0 });
        let outline = Plane::from_fn(8, 8, |x, _| x == 4);
        for (matching, precision) in [(Matching::OneToOne, 0.5), (Matching::Nearest, 1.0)] {
            let summary = summarize(&[score(&map, std::slice::from_ref(&outline), 1.0, matching).unwrap()]);
            assert_eq!((summary.ods.precision, summary.ods.recall), (precision, 1.0), "{matching:?}");
        }
    }

    #[test]
    fn the_best_threshold_is_one_for_all_images_or_one_for_each() {
        // A false pixel beside a true one; which is the stronger of the two differs.
        let image = |right: f32, wrong: f32| ImageScore {
            found: if right > wrong { vec![right, wrong] } else { vec![wrong, right] },
            correct: vec![right],
            recalled: vec![right],
            truth: 1,
        };
        let summary = summarize(&[image(0.9, 0.5), image(0.4, 0.2)]);
        assert_eq!((summary.ods.threshold, summary.ods.precision, summary.ods.recall), (0.4, 2.0 / 3.0, 1.0));
        assert_eq!(summary.ois.f(), 1.0);
        assert_eq!(summarize(&[]), Summary::default());
        assert_eq!(summarize(&[ImageScore { truth: 3, ..ImageScore::default() }]).ods.f(), 0.0);
    }

    #[test]
    fn wrong_sizes_and_numbers_are_errors() {
        let map = Plane::filled(3, 2, 0.5);
        assert!(score(&map, &[Plane::filled(2, 3, true)], 1.0, Matching::Nearest).is_err());
        assert!(score(&Plane::filled(3, 2, f32::NAN), &[Plane::filled(3, 2, true)], 1.0, Matching::Nearest).is_err());
        assert_eq!(tolerance(481, 321), 0.0075 * (481.0_f64 * 481.0 + 321.0 * 321.0).sqrt());
    }
}
