//! Run lengths of masks in the format of COCO: pixels in column order; runs outside and inside alternate, beginning with one
//! outside, which may be empty.

use crate::Error;
use crate::image::Plane;

/// The run lengths of one label in a mask.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CocoRuns {
    /// The label of the runs.
    pub label: u8,
    /// Lengths of the runs, outside and inside alternating; they sum to the pixels of the mask.
    pub counts: Vec<u32>,
    /// Number of the label's pixels.
    pub area: usize,
    /// First column and first row of its bounding box.
    pub corner: (usize, usize),
    /// Width and height of its bounding box.
    pub size: (usize, usize),
}

/// Returns the run lengths of every label in `mask`, including 0, ascending. Takes one pass over the mask.
pub fn coco_runs(mask: &Plane<u8>) -> Vec<CocoRuns> {
    let (width, height) = (mask.width(), mask.height());
    let columns = (0..width).flat_map(|x| (0..height).map(move |y| mask[(x, y)]));
    let mut runs_by_label: Vec<(CocoRuns, usize)> =
        (0..=u8::MAX).map(|label| (CocoRuns { label, ..CocoRuns::default() }, 0)).collect();
    let mut run: Option<(u8, usize)> = None;
    for (k, label) in columns.chain([0]).enumerate() {
        match run {
            Some((current, _)) if current == label && k < width * height => continue,
            Some((last, start)) => {
                let (runs, end) = &mut runs_by_label[usize::from(last)];
                runs.add(start, k, *end, height);
                *end = k;
            }
            None => {}
        }
        run = Some((label, k));
    }
    let complete = |(mut runs, end): (CocoRuns, usize)| {
        runs.counts.extend((end < width * height).then_some((width * height - end) as u32));
        runs
    };
    runs_by_label.into_iter().filter(|(runs, _)| runs.area > 0).map(complete).collect()
}

impl CocoRuns {
    /// Adds the run `start..end`; the previous one ended at `previous_end`.
    fn add(&mut self, start: usize, end: usize, previous_end: usize, height: usize) {
        let (left, right) = (start / height, (end - 1) / height + 1);
        // A run that goes on in the next column touches both edges.
        let (top, bottom) = if left + 1 == right { (start % height, (end - 1) % height + 1) } else { (0, height) };
        let ((l, t), (w, h)) = if self.area == 0 { ((left, top), (0, 0)) } else { (self.corner, self.size) };
        self.corner = (l.min(left), t.min(top));
        self.size = ((l + w).max(right) - self.corner.0, (t + h).max(bottom) - self.corner.1);
        self.counts.extend([(start - previous_end) as u32, (end - start) as u32]);
        self.area += end - start;
    }
}

/// Encodes run lengths as a string that pycocotools reads. Each length is a signed number in groups of group bits; from the fourth
/// on, its difference from the last but one is encoded.
pub fn coco_text(counts: &[u32]) -> String {
    let mut text = String::new();
    for (i, &count) in counts.iter().enumerate() {
        let mut bits = i64::from(count) - if i > 2 { i64::from(counts[i - 2]) } else { 0 };
        loop {
            let group = (bits & 31) as u8;
            bits >>= 5;
            // The fifth bit is the sign: the number ends when the remaining bits all equal it.
            let is_more = bits != if group & 16 > 0 { -1 } else { 0 };
            text.push(char::from(48 + group + if is_more { 32 } else { 0 }));
            if !is_more {
                break;
            }
        }
    }
    text
}

/// Decodes the run lengths of a string, the inverse of [`coco_text`].
///
/// # Errors
/// [`Error::Data`] if the string is not valid.
pub fn coco_counts(text: &str) -> Result<Vec<u32>, Error> {
    let mut counts: Vec<u32> = Vec::new();
    let (mut value, mut shift) = (0_i64, 0);
    for byte in text.bytes() {
        let group = byte.wrapping_sub(48);
        if group > 63 || shift > 30 {
            return Err(invalid_counts(text));
        }
        value |= i64::from(group & 31) << shift;
        shift += 5;
        if group & 32 > 0 {
            continue;
        }
        if group & 16 > 0 {
            value -= 1 << shift;
        }
        let i = counts.len();
        let count = value + if i > 2 { i64::from(counts[i - 2]) } else { 0 };
        let illegal =
            |_| Error::Data { reason: format!("counts[{i}] = {count} (expected a whole number, 0..={})", u32::MAX) };
        counts.push(u32::try_from(count).map_err(illegal)?);
        (value, shift) = (0, 0);
    }
    if shift > 0 { Err(invalid_counts(text)) } else { Ok(counts) }
}

fn invalid_counts(text: &str) -> Error {
    let start: String = text.chars().take(40).collect();
    Error::Data { reason: format!("counts = \"{start}\" (expected run lengths in the format of COCO)") }
}

/// Decodes run lengths to a mask, 1 inside and 0 outside.
///
/// # Errors
/// [`Error::Data`] unless they sum to the number of pixels.
pub fn coco_mask(counts: &[u32], (width, height): (usize, usize)) -> Result<Plane<u8>, Error> {
    let covered: u64 = counts.iter().map(|&count| u64::from(count)).sum();
    let pixels = (width as u64).saturating_mul(height as u64);
    if covered != pixels {
        return Err(Error::Data { reason: format!("counts cover {covered} pixels (expected {pixels})") });
    }
    let mut mask = Plane::from_fn(width, height, |_, _| 0);
    let mut start = 0;
    for (i, &count) in counts.iter().enumerate() {
        let end = start + count as usize;
        if i % 2 == 1 {
            (start..end).for_each(|k| mask[(k / height, k % height)] = 1);
        }
        start = end;
    }
    Ok(mask)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(rows: &[&[u8]]) -> Plane<u8> {
        Plane::from_fn(rows[0].len(), rows.len(), |x, y| rows[y][x])
    }

    #[test]
    fn runs_go_down_the_columns_and_have_a_box() {
        let runs = coco_runs(&mask(&[&[0, 1], &[1, 1], &[1, 0]]));
        assert_eq!((runs[0].label, &runs[0].counts[..]), (0, &[0, 1, 4, 1][..]));
        let box_of = |runs: &CocoRuns| (runs.corner, runs.size);
        assert_eq!((runs[1].label, &runs[1].counts[..], runs[1].area), (1, &[1, 4, 1][..], 4));
        assert_eq!(box_of(&runs[1]), ((0, 0), (2, 3)));
        assert_eq!(box_of(&coco_runs(&mask(&[&[0, 0, 0], &[7, 0, 0]]))[1]), ((0, 1), (1, 1)));
    }

    /// Against counts taken label by label, pixel by pixel.
    #[test]
    fn runs_are_those_of_each_label_alone_and_give_its_mask_back() {
        for (w, h) in [(1, 1), (7, 3), (3, 7), (40, 30)] {
            for stride in [1, 2, 5, 1000] {
                let mask = Plane::from_fn(w, h, |x, y| ((x * 3 + y * y) / stride % 4 * 85) as u8);
                let all = coco_runs(&mask);
                assert_eq!(all.iter().map(|runs| runs.area).sum::<usize>(), w * h);
                for runs in all {
                    let own = Plane::from_fn(w, h, |x, y| u8::from(mask[(x, y)] == runs.label));
                    let mut counts = vec![0];
                    for (x, y) in (0..w).flat_map(|x| (0..h).map(move |y| (x, y))) {
                        if usize::from(own[(x, y)]) == counts.len() % 2 {
                            counts.push(0);
                        }
                        *counts.last_mut().unwrap() += 1;
                    }
                    assert_eq!(runs.counts, counts);
                    assert_eq!(coco_mask(&coco_counts(&coco_text(&counts)).unwrap(), (w, h)).unwrap(), own);
                    let xs: Vec<_> = (0..w).filter(|&x| (0..h).any(|y| own[(x, y)] == 1)).collect();
                    let ys: Vec<_> = (0..h).filter(|&y| (0..w).any(|x| own[(x, y)] == 1)).collect();
                    let size = (xs[xs.len() - 1] + 1 - xs[0], ys[ys.len() - 1] + 1 - ys[0]);
                    assert_eq!((runs.corner, runs.size), ((xs[0], ys[0]), size));
                }
            }
        }
    }

    /// EvidenceInput strings of pycocotools.
    #[test]
    fn lengths_are_compressed_as_pycocotools_does() {
        for (counts, text) in
            [(&[6, 1, 40, 4, 5, 4, 5, 4, 21][..], "61X13mN000`0"), (&[0, 64], "0P2"), (&[15, 16], "?`0")]
        {
            assert_eq!(coco_text(counts), text, "{counts:?}");
            assert_eq!(coco_counts(text).unwrap(), counts);
        }
    }

    #[test]
    fn invalid_counts_are_errors() {
        let message = |text| coco_counts(text).unwrap_err().to_string();
        assert!(message("P").contains("counts = \"P\""));
        assert!(message("~").contains("counts = \"~\""));
        assert!(message("oooooooooo").contains("in the format of COCO"));
        assert!(message("22O").contains("counts[2] = -1"));
        assert!(coco_mask(&[1], (2, 2)).unwrap_err().to_string().contains("cover 1 pixels (expected 4)"));
    }
}
