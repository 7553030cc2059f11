//! Masks of any clip against true masks that may leave pixels, and whole frames, open.
//!
//! **In:** the labels of a frame, 0 for the background, and a [`Truth`] for each pixel. **Out:** [`MaskScores`] of the
//! frame, which average over frames, clips and kinds of clips; and [`Census`], which objects were found.
//!
//! Pixels that the truth ignores count nowhere. In a frame with an object
//!
//! - J and F are computed as in [`davis`](super::davis), for all labels other than 0 together;
//! - best is the J of the one label that has the most of it: below J an object is in parts, or many objects are apart;
//! - recall is the labelled share of the true objects' pixels, the false share the labelled share of the background's.
//!
//! In a frame without any object J is 1 less the labelled share, so that a speck costs little; the false share is that
//! share, and the others are left open.
//!
//! The truth says object or not, and not which. So true objects are its connected pieces (eight neighbours), followed
//! from each frame that has a truth to the next one where they overlap; two that touch once are one. Pieces that never
//! fill 1/2000 of the frame are not counted. A label is false when most of its pixels in the clip lie on the
//! background; a true object is found when labels that are not false have at least half of its pixels.

use super::davis::{boundary_measure, check_sizes};
use serde::Serialize;
use std::collections::BTreeMap;
use tracecut::Error;
use tracecut::image::Plane;
use tracecut::sets::DisjointSets;

/// The truth of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Truth {
    /// On no object.
    Background,
    /// On some object.
    Object,
    /// Open: not scored.
    Ignored,
}

/// Scores of masks, of a frame or on average; `None` if undefined.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct MaskScores {
    /// Region similarity, `0.0..=1.0`, 1 best.
    pub j: Option<f64>,
    /// Boundary measure, `0.0..=1.0`, 1 best.
    pub f: Option<f64>,
    /// Region similarity of the best label.
    pub best: Option<f64>,
    /// Share of the true objects' pixels that have a label.
    pub recall: Option<f64>,
    /// Share of the background that has a label, 0 best.
    pub false_share: Option<f64>,
}

impl MaskScores {
    /// Mean of each number over those that have it.
    pub fn mean_of(all: &[Self]) -> Self {
        let over = |value: fn(&Self) -> Option<f64>| {
            let values: Vec<f64> = all.iter().filter_map(value).collect();
            (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
        };
        Self {
            j: over(|s| s.j),
            f: over(|s| s.f),
            best: over(|s| s.best),
            recall: over(|s| s.recall),
            false_share: over(|s| s.false_share),
        }
    }
}

/// Counts of objects and labels of a clip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Census {
    /// Labels other than 0 in the scored pixels.
    pub labels: usize,
    /// Of these, those with most of their pixels on the background.
    pub false_objects: usize,
    /// True objects.
    pub true_objects: usize,
    /// True objects with at least half of their pixels in labels that are not false.
    pub found_objects: usize,
}

/// Pixels of each label, by what they truly are: background, object.
pub(super) type Counts = Vec<[u64; 2]>;

fn counts_of(labels: &Plane<u8>, truth: &Plane<Truth>) -> Counts {
    let mut counts = vec![[0; 2]; 256];
    for (&label, &truth) in labels.data().iter().zip(truth.data()) {
        match truth {
            Truth::Background => counts[usize::from(label)][0] += 1,
            Truth::Object => counts[usize::from(label)][1] += 1,
            Truth::Ignored => {}
        }
    }
    counts
}

/// Scores of one frame.
///
/// # Errors
/// [`Error::Data`] when the sizes differ.
pub fn score_frame(labels: &Plane<u8>, truth: &Plane<Truth>) -> Result<MaskScores, Error> {
    check_sizes((labels.width(), labels.height()), truth)?;
    scores_of(&counts_of(labels, truth), labels, truth)
}

fn scores_of(counts: &Counts, labels: &Plane<u8>, truth: &Plane<Truth>) -> Result<MaskScores, Error> {
    let labelled = |kind: usize| counts[1..].iter().map(|c| c[kind]).sum::<u64>();
    let (wrong, right) = (labelled(0), labelled(1));
    let (background, object) = (wrong + counts[0][0], right + counts[0][1]);
    let share = |part: u64, total: u64| part as f64 / total.max(1) as f64;
    let false_share = Some(share(wrong, background));
    if object == 0 {
        return Ok(MaskScores { j: Some(1.0 - share(wrong, background)), false_share, ..MaskScores::default() });
    }
    let similarity = |c: &[u64; 2]| share(c[1], c[0] + object);
    let (mask, objects) = (scored_mask(labels, truth), truth.map(|t| t == Truth::Object));
    Ok(MaskScores {
        j: Some(similarity(&[wrong, right])),
        f: Some(boundary_measure(&mask, &objects)?),
        best: Some(counts[1..].iter().map(similarity).fold(0.0, f64::max)),
        recall: Some(share(right, object)),
        false_share,
    })
}

/// The pixels with a label, but for those that the truth ignores.
fn scored_mask(labels: &Plane<u8>, truth: &Plane<Truth>) -> Plane<bool> {
    let pairs = labels.data().iter().zip(truth.data());
    let data = pairs.map(|(&label, &truth)| label != 0 && truth != Truth::Ignored).collect();
    Plane::from_vec(labels.width(), labels.height(), data).unwrap_or_default()
}

/// Scores a clip frame by frame.
#[derive(Debug)]
pub struct ClipScorer {
    frames: Vec<MaskScores>,
    counts: Counts,
    pieces: Pieces,
}

impl Default for ClipScorer {
    fn default() -> Self {
        Self { frames: Vec::new(), counts: vec![[0; 2]; 256], pieces: Pieces::default() }
    }
}

impl ClipScorer {
    /// Counts the next frame that has a truth. All frames have one size.
    ///
    /// # Errors
    /// [`Error::Data`] when the sizes differ.
    pub fn add(&mut self, labels: &Plane<u8>, truth: &Plane<Truth>) -> Result<(), Error> {
        check_sizes((labels.width(), labels.height()), truth)?;
        let counts = counts_of(labels, truth);
        self.frames.push(scores_of(&counts, labels, truth)?);
        for (sum, new) in self.counts.iter_mut().zip(&counts) {
            *sum = [sum[0] + new[0], sum[1] + new[1]];
        }
        self.pieces.add(labels, &truth.map(|t| t == Truth::Object));
        Ok(())
    }

    /// The scores of the frames so far.
    pub fn frames(&self) -> &[MaskScores] {
        &self.frames
    }

    /// Counts of the frames so far.
    pub fn census(&self) -> Census {
        let is_false: Vec<bool> = self.counts.iter().map(|[background, object]| background > object).collect();
        let is_seen = |label: &usize| self.counts[*label] != [0, 0];
        let (true_objects, found_objects) =
            self.pieces.count_objects(|label| label != 0 && !is_false[usize::from(label)]);
        Census {
            labels: (1..256).filter(is_seen).count(),
            false_objects: (1..256).filter(|&l| is_false[l]).count(),
            true_objects,
            found_objects,
        }
    }
}

/// A piece counts when it fills this share of the frame at some time; smaller ones are specks of the annotation.
const LEAST_SHARE: f64 = 1.0 / 2000.0;

/// One piece in one frame.
#[derive(Debug, Default)]
struct Piece {
    /// Pixels by label.
    labels: BTreeMap<u8, u64>,
    pixels: u64,
}

/// Connected pieces of all frames so far; pieces of neighbouring frames that overlap are one object.
#[derive(Debug, Default)]
struct Pieces {
    all: Vec<Piece>,
    /// Pieces that overlap, as indices.
    links: Vec<(usize, usize)>,
    /// The last frame: which piece each pixel is on.
    last: Vec<Option<usize>>,
}

impl Pieces {
    /// Counts a frame: its labels, and the pixels on objects. All frames have one size.
    fn add(&mut self, labels: &Plane<u8>, objects: &Plane<bool>) {
        let mut sets = connected(objects);
        let mut piece_of_root: BTreeMap<usize, usize> = BTreeMap::new();
        let mut pieces = vec![None; objects.data().len()];
        for i in (0..pieces.len()).filter(|&i| objects.data()[i]) {
            let piece = *piece_of_root.entry(sets.root(i)).or_insert_with(|| {
                self.all.push(Piece::default());
                self.all.len() - 1
            });
            self.all[piece].pixels += 1;
            *self.all[piece].labels.entry(labels.data()[i]).or_default() += 1;
            pieces[i] = Some(piece);
        }
        let overlaps = self.last.iter().zip(&pieces).filter_map(|(before, now)| Some(((*before)?, (*now)?)));
        self.links.extend(overlaps);
        self.links.sort_unstable();
        self.links.dedup();
        self.last = pieces;
    }

    /// Counts the objects, and the objects with at least half of their pixels in labels that `counts`.
    fn count_objects(&self, counts: impl Fn(u8) -> bool) -> (usize, usize) {
        let mut sets = DisjointSets::new(self.all.len());
        self.links.iter().for_each(|&(a, b)| sets.join(a, b));
        let least = (LEAST_SHARE * self.last.len() as f64).ceil() as u64;
        // Object by object: largest piece, pixels, those with a label that counts.
        let mut objects: BTreeMap<usize, (u64, u64, u64)> = BTreeMap::new();
        for (i, piece) in self.all.iter().enumerate() {
            let covered: u64 = piece.labels.iter().filter(|(label, _)| counts(**label)).map(|(_, n)| n).sum();
            let object = objects.entry(sets.root(i)).or_default();
            *object = (object.0.max(piece.pixels), object.1 + piece.pixels, object.2 + covered);
        }
        objects.retain(|_, (largest, ..)| *largest >= least);
        (objects.len(), objects.values().filter(|(_, pixels, covered)| 2 * covered >= *pixels).count())
    }
}

/// Joins each true pixel with its true neighbours among eight.
fn connected(plane: &Plane<bool>) -> DisjointSets {
    let (width, height) = (plane.width(), plane.height());
    let mut sets = DisjointSets::new(width * height);
    for y in 0..height {
        for x in (0..width).filter(|&x| plane[(x, y)]) {
            let pixel = y * width + x;
            if x > 0 && plane[(x - 1, y)] {
                sets.join(pixel - 1, pixel);
            }
            for above in (x.saturating_sub(1)..(x + 2).min(width)).filter(|&a| y > 0 && plane[(a, y - 1)]) {
                sets.join((y - 1) * width + above, pixel);
            }
        }
    }
    sets
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Labels from digits, `.` for 0.
    fn labels(rows: &[&str]) -> Plane<u8> {
        let data = rows.iter().flat_map(|r| r.bytes()).map(|b| if b == b'.' { 0 } else { b - b'0' }).collect();
        Plane::from_vec(rows[0].len(), rows.len(), data).unwrap()
    }

    /// `#` object, `?` ignored, `.` background.
    fn truth(rows: &[&str]) -> Plane<Truth> {
        let kind = |b| match b {
            b'#' => Truth::Object,
            b'?' => Truth::Ignored,
            _ => Truth::Background,
        };
        Plane::from_vec(rows[0].len(), rows.len(), rows.iter().flat_map(|r| r.bytes()).map(kind).collect()).unwrap()
    }

    #[test]
    fn a_frame_with_ignored_pixels_has_the_scores_of_the_others() {
        let scores = score_frame(&labels(&["112.3...", "11......"]), &truth(&["##??....", "###....."])).unwrap();
        // Right 4 of 5; wrong one of 9; labels 2 on ignored pixels count for nothing.
        assert_eq!(scores.j, Some(4.0 / 6.0));
        assert_eq!((scores.best, scores.recall), (Some(4.0 / 5.0), Some(4.0 / 5.0)));
        assert_eq!(scores.false_share, Some(1.0 / 9.0));
        let seen = |p: &Plane<u8>, t: &Plane<Truth>| {
            boundary_measure(&scored_mask(p, t), &t.map(|t| t == Truth::Object)).unwrap()
        };
        let (l, t) = (labels(&["112.3...", "11......"]), truth(&["##??....", "###....."]));
        assert_eq!(scores.f, Some(seen(&l, &t)));
        assert_eq!(score_frame(&l, &t.map(|_| Truth::Ignored)).unwrap().j, Some(1.0));
    }

    #[test]
    fn without_an_object_the_labelled_share_is_taken_off() {
        let scores = score_frame(&labels(&["11..", "...2"]), &truth(&["....", "..??"])).unwrap();
        assert_eq!(scores.j, Some(1.0 - 2.0 / 6.0));
        assert_eq!((scores.f, scores.best, scores.recall), (None, None, None));
        assert_eq!(scores.false_share, Some(2.0 / 6.0));
    }

    #[test]
    fn an_object_that_nothing_covers_scores_zero() {
        let scores = score_frame(&labels(&["...", "..."]), &truth(&["##.", "..."])).unwrap();
        assert_eq!((scores.j, scores.f, scores.best), (Some(0.0), Some(0.0), Some(0.0)));
        assert_eq!((scores.recall, scores.false_share), (Some(0.0), Some(0.0)));
        let message = score_frame(&labels(&["..."]), &truth(&["##"])).unwrap_err().to_string();
        assert!(message.contains("3x1") && message.contains("2x1"), "{message}");
    }

    #[test]
    fn means_leave_out_what_is_not_known() {
        let some = MaskScores { j: Some(0.5), f: Some(0.25), ..MaskScores::default() };
        let other = MaskScores { j: Some(1.0), false_share: Some(0.125), ..MaskScores::default() };
        let mean = MaskScores::mean_of(&[some, other]);
        assert_eq!((mean.j, mean.f, mean.best, mean.false_share), (Some(0.75), Some(0.25), None, Some(0.125)));
        assert_eq!(MaskScores::mean_of(&[]), MaskScores::default());
    }

    #[test]
    fn found_and_false_objects_are_counted_over_the_clip() {
        let mut scorer = ClipScorer::default();
        // Two objects; the left one goes right and stays one. Label 1 has it, label 2 little of the right one, 3 none.
        scorer.add(&labels(&["11....2", "......."]), &truth(&["##...##", ".....##"])).unwrap();
        scorer.add(&labels(&[".11...2", "...33.."]), &truth(&[".##..##", "...?.##"])).unwrap();
        let expected = Census { labels: 3, false_objects: 1, true_objects: 2, found_objects: 1 };
        assert_eq!(scorer.census(), expected);
        // In a third frame label 2 takes the whole right object, 3 + 2 + 2 pixels of 12, and label 3 the rest of it.
        scorer.add(&labels(&["1122222", "..22222"]), &truth(&["##...##", ".....##"])).unwrap();
        let census = scorer.census();
        // Six of label 2 are right and six wrong, which is not most.
        assert_eq!((census.labels, census.false_objects, census.found_objects), (3, 1, 2));
        assert_eq!(scorer.frames().len(), 3);
    }

    #[test]
    fn a_false_label_finds_nothing() {
        let mut scorer = ClipScorer::default();
        scorer.add(&labels(&["111111"]), &truth(&["##...."])).unwrap();
        let expected = Census { labels: 1, false_objects: 1, true_objects: 1, found_objects: 0 };
        assert_eq!(scorer.census(), expected);
    }

    fn plane(rows: &[&str]) -> Plane<bool> {
        let data = rows.iter().flat_map(|r| r.bytes()).map(|b| b == b'#').collect();
        Plane::from_vec(rows[0].len(), rows.len(), data).unwrap()
    }

    /// How many objects the frames hold.
    fn count(frames: &[&[&str]]) -> usize {
        let mut pieces = Pieces::default();
        for rows in frames {
            let objects = plane(rows);
            pieces.add(&objects.map(|_| 0), &objects);
        }
        pieces.count_objects(|_| true).0
    }

    #[test]
    fn pieces_touch_at_corners_and_go_on_where_they_overlap() {
        assert_eq!(count(&[&["#...", ".#.#"]]), 2);
        assert_eq!(count(&[&[".#..", "#..."]]), 1);
        assert_eq!(count(&[&["##..", "...."], &[".##.", "...."], &["..##", "...."]]), 1);
        // Gone for a frame, or too fast to overlap: another object.
        assert_eq!(count(&[&["##.."], &["...."], &["##.."]]), 2);
        assert_eq!(count(&[&["#..."], &["..#."]]), 2);
        // Two that meet once are one.
        assert_eq!(count(&[&["#..#"], &["####"], &["#..#"]]), 1);
        assert_eq!(count(&[&["...."]]), 0);
    }

    #[test]
    fn specks_are_no_objects_and_half_of_one_is_enough() {
        let mut pieces = Pieces::default();
        // 80 x 100 pixels: an object has 4 at least.
        let objects = Plane::from_fn(80, 100, |x, y| y == 0 && (x < 3 || (10..14).contains(&x)));
        pieces.add(&Plane::from_fn(80, 100, |x, _| u8::from(x >= 12) + u8::from(x < 3)), &objects);
        assert_eq!(pieces.count_objects(|label| label == 1), (1, 1));
        assert_eq!(pieces.count_objects(|label| label == 2), (1, 0));
        let fewer = Plane::from_fn(80, 100, |x, y| u8::from(y == 0 && x == 13));
        let mut pieces = Pieces::default();
        pieces.add(&fewer, &objects);
        assert_eq!(pieces.count_objects(|label| label == 1), (1, 0));
    }
}
