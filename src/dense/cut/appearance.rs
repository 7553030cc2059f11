//! What objects and the ground near them look like, learned from a cut to make it anew.
//!
//! Colours of the superpixels of objects over the whole clip, against those of the ground near objects; what is far from
//! them says nothing of their borders, and nothing is said of it. Models and cuts in turn are those of Rother, Kolmogorov
//! and Blake, "GrabCut", 2004. Not in the paper.

use super::colour::{Colour, Histogram, UNSEEN};
use crate::image::Frame;
use crate::superpixel::Superpixels;

/// Ground is near an object within this part of the frame's longer side, in columns and rows.
const NEAR: f32 = 0.1;
/// Log-odds count up to this.
const MOST: f32 = 2.0;

/// Adds to the evidence for objects, which may be empty, what objects and the ground near them look like by the labels of
/// a cut: `weight` times the log-odds of each superpixel, frame by frame. `is_object` says which labels are objects.
#[must_use]
pub fn add_appearance(
    evidence: &[f32],
    superpixels: &[Superpixels],
    frames: &[Frame],
    labels: &[Vec<u32>],
    is_object: &[bool],
    weight: f32,
) -> Vec<f32> {
    let by_colour = appearance(superpixels, frames, labels, is_object);
    let mut sums = evidence.to_vec();
    sums.resize(by_colour.len(), 0.0);
    sums.iter_mut().zip(by_colour).for_each(|(sum, odds)| *sum += weight * odds);
    sums
}

/// Log-odds of object against ground by the colour of each superpixel, frame by frame; 0 of those not near an object.
/// `labels` are those of a cut before, and `is_object` says what they are.
fn appearance(superpixels: &[Superpixels], frames: &[Frame], labels: &[Vec<u32>], is_object: &[bool]) -> Vec<f32> {
    let count = superpixels.iter().map(|s| s.count).sum();
    let Some(mut colours) = ClipColours::new(superpixels, frames, 2) else { return vec![0.0; count] };
    let mut is_near: Vec<bool> = Vec::with_capacity(count);
    for (s, labels) in superpixels.iter().zip(labels) {
        let object: Vec<bool> = labels.iter().map(|&label| is_object.get(label as usize) == Some(&true)).collect();
        let first = is_near.len();
        is_near.extend(near_objects(s, &object));
        for (k, &object) in object.iter().enumerate().filter(|&(k, _)| is_near[first + k]) {
            colours.add(first + k, usize::from(object), 1.0);
        }
    }
    let odds = |node: usize| {
        let [ground, object] = [0, 1].map(|label| colours.share(node, label) + UNSEEN);
        libm::logf(object / ground).clamp(-MOST, MOST)
    };
    is_near.iter().enumerate().map(|(node, &near)| if near { odds(node) } else { 0.0 }).collect()
}

/// Whether any pixel of each superpixel is near a pixel of an object.
fn near_objects(superpixels: &Superpixels, is_object: &[bool]) -> Vec<bool> {
    let label = superpixels.label();
    let (w, h) = (label.width(), label.height());
    let reach = (NEAR * w.max(h) as f32) as usize;
    // A bit a pixel.
    let words = w.div_ceil(64);
    let mut near = Vec::with_capacity(words * h);
    for y in 0..h {
        let bits =
            |labels: &[u32]| labels.iter().rev().fold(0, |bits, &s| bits << 1 | u64::from(is_object[s as usize]));
        near.extend(label.row(y).chunks(64).map(bits));
    }
    near.chunks_exact_mut(words).for_each(|row| doubling(reach, |by| shift(row, by)));
    // Rows are words further on in one row of all.
    doubling(reach, |by| shift(&mut near, 64 * words * by));
    let mut found = vec![false; superpixels.count];
    for y in 0..h {
        for (labels, &bits) in label.row(y).chunks(64).zip(&near[y * words..]) {
            let mut bits = bits;
            while bits != 0 {
                // Bits after the end of a row are of no pixel.
                labels.get(bits.trailing_zeros() as usize).into_iter().for_each(|&s| found[s as usize] = true);
                bits &= bits - 1;
            }
        }
    }
    found
}

/// Calls `add` with steps that add up to `reach`, each at most one more than all before it.
fn doubling(reach: usize, mut add: impl FnMut(usize)) {
    let mut done = 0;
    while done < reach {
        let by = (done + 1).min(reach - done);
        add(by);
        done += by;
    }
}

/// Sets what is `by` bits before or after a set bit.
fn shift(row: &mut [u64], by: usize) {
    let (words, bits) = (by / 64, by % 64);
    for k in (words..row.len()).rev() {
        let carried = if bits > 0 && k > words { row[k - words - 1] >> (64 - bits) } else { 0 };
        row[k] |= row[k - words] << bits | carried;
    }
    for k in 0..row.len().saturating_sub(words) {
        let carried = if bits > 0 && k + words + 1 < row.len() { row[k + words + 1] << (64 - bits) } else { 0 };
        row[k] |= row[k + words] >> bits | carried;
    }
}

/// The colours of each label over the whole clip.
struct ClipColours {
    /// Mean colour of each superpixel, frame by frame.
    mean: Vec<Colour>,
    /// Number of pixels of each superpixel.
    area: Vec<f32>,
    labels: Vec<Histogram>,
}

impl ClipColours {
    /// No label has any colour yet; `None` unless every frame has the size of its superpixels.
    fn new(superpixels: &[Superpixels], frames: &[Frame], num_labels: usize) -> Option<Self> {
        let (mut mean, mut area) = (Vec::new(), Vec::new());
        for (t, s) in superpixels.iter().enumerate() {
            let frame = frames.get(t).filter(|f| (f.width(), f.height()) == s.runs().size())?;
            // Two sums in each number.
            let mut sums = vec![[0_u64; 2]; s.count];
            for (&p, rgb) in s.label().data().iter().zip(frame.rgb().as_chunks::<3>().0) {
                let (sum, [r, g, b]) = (&mut sums[p as usize], rgb.map(u64::from));
                *sum = [sum[0] + (r | g << 32), sum[1] + (b | 1 << 32)];
            }
            for [red_green, blue_count] in sums {
                let [r, g, b, count] = [red_green, red_green >> 32, blue_count, blue_count >> 32].map(|v| v as u32);
                mean.push(Colour::of(&[r, g, b].map(|v| (v / count.max(1)) as u8)));
                area.push(count as f32);
            }
        }
        Some(Self { mean, area, labels: vec![Histogram::new(); num_labels] })
    }

    /// The superpixel `node` has `label`, to this share.
    fn add(&mut self, node: usize, label: usize, share: f32) {
        self.labels[label].add(&self.mean[node].corners(), share * self.area[node]);
    }

    /// The share of `label` that has the colour of superpixel `node`.
    fn share(&self, node: usize, label: usize) -> f32 {
        self.labels[label].share(&self.mean[node].corners())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Plane;

    /// Columns of ten pixels as superpixels of a frame of 100x20, with these greys.
    fn columns(greys: [u8; 10]) -> (Superpixels, Frame) {
        let label = Plane::from_fn(100, 20, |x, _| x as u32 / 10);
        let rgb = (0..100 * 20).flat_map(|i| [greys[i % 100 / 10]; 3]).collect();
        (Superpixels::from(&label), Frame::from_rgb(rgb, 100, 20).unwrap())
    }

    #[test]
    fn what_looks_like_the_object_beside_it_is_drawn_to_it_and_what_is_far_is_not() {
        let (superpixels, frame) = columns([200, 200, 200, 40, 40, 40, 40, 40, 200, 200]);
        // In the first frame the object was cut too small.
        let labels = [vec![1, 1, 0, 0, 0, 0, 0, 0, 0, 0], vec![1, 1, 1, 0, 0, 0, 0, 0, 0, 0]];
        let found = appearance(&[superpixels.clone(), superpixels], &[frame.clone(), frame], &labels, &[false, true]);
        assert!(found[2] > 0.5 && found[13] < -1.0, "{found:?}");
        assert_eq!(found[3..10], [0.0; 7]);
    }

    #[test]
    fn ground_that_looks_like_none_of_the_object_is_held_back() {
        let (superpixels, frame) = columns([200, 200, 40, 40, 40, 40, 40, 40, 40, 40]);
        let labels = [vec![1, 1, 1, 0, 0, 0, 0, 0, 0, 0], vec![1, 1, 1, 0, 0, 0, 0, 0, 0, 0]];
        let found = appearance(&[superpixels.clone(), superpixels], &[frame.clone(), frame], &labels, &[false, true]);
        assert_eq!(found.len(), 20);
        assert!(found[0] > 1.0 && found[3] < 0.0 && found[2] < 0.0, "{found:?}");
    }

    #[test]
    fn without_objects_or_frames_nothing_is_said() {
        let (superpixels, frame) = columns([9; 10]);
        let labels = [vec![0; 10]];
        let pictures = std::slice::from_ref(&superpixels);
        assert_eq!(appearance(pictures, &[frame], &labels, &[false, true]), [0.0; 10]);
        assert_eq!(appearance(pictures, &[], &labels, &[false, true]), [0.0; 10]);
    }

    #[test]
    fn near_is_within_a_tenth_of_the_longer_side_as_a_naive_search_finds() {
        let mut rng = crate::rng::Rng::for_stage(3, "near");
        for _ in 0..20 {
            let label = Plane::from_fn(40, 30, |x, y| (x / 4 + y / 3 * 10) as u32);
            let superpixels = Superpixels::from(&label);
            let object: Vec<bool> = (0..100).map(|_| rng.below(30) == 0).collect();
            let found = near_objects(&superpixels, &object);
            let places = || (0..40 * 30).map(|i| (i % 40, i / 40));
            for s in 0..100_u32 {
                let own = |&(x, y): &(usize, usize)| label[(x, y)] == s;
                let of_object = |&(x, y): &(usize, usize)| object[label[(x, y)] as usize];
                let is_near = places()
                    .filter(own)
                    .any(|(x, y)| places().filter(of_object).any(|(a, b)| x.abs_diff(a) <= 4 && y.abs_diff(b) <= 4));
                assert_eq!(found[s as usize], is_near);
            }
        }
    }
}
