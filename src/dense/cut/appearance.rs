//! Appearance of objects and of the background near them, learned from one cut for the next.
//!
//! Colour histograms of the objects' superpixels over the whole clip, and of the background near objects, give log-odds of
//! each superpixel there; farther background says nothing about borders. Alternating models and cuts is GrabCut (Rother,
//! Kolmogorov and Blake, 2004). Not in the paper. Cost: O(pixels). It fails where objects have the colours of their
//! surroundings.

use super::colour::{Colour, Histogram, UNSEEN_SHARE};
use crate::image::Frame;
use crate::superpixel::Superpixels;

/// Reach of the background near an object, in columns and rows, as a part of the frame's longer side. Chosen by eye.
const NEAR_SIDE_SHARE: f32 = 0.1;
/// Bound of the log-odds. Chosen by eye.
const MAX_LOG_ODDS: f32 = 2.0;

/// Adds to the evidence for objects, which may be empty, `weight` times the log-odds of each superpixel by appearance, frame
/// by frame, learned from the labels of a cut. `is_object` marks the labels that are objects.
#[must_use]
pub fn add_appearance(
    evidence: &[f32],
    superpixels: &[Superpixels],
    frames: &[Frame],
    labels: &[Vec<u32>],
    is_object: &[bool],
    weight: f32,
) -> Vec<f32> {
    let log_odds = appearance_log_odds(superpixels, frames, labels, is_object);
    let mut sums = evidence.to_vec();
    sums.resize(log_odds.len(), 0.0);
    sums.iter_mut().zip(log_odds).for_each(|(sum, odds)| *sum += weight * odds);
    sums
}

/// Log-odds of object against background by the colour of each superpixel, frame by frame; 0 far from objects.
fn appearance_log_odds(
    superpixels: &[Superpixels],
    frames: &[Frame],
    labels: &[Vec<u32>],
    is_object: &[bool],
) -> Vec<f32> {
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
    let log_odds = |node: usize| {
        let [background, object] = [0, 1].map(|label| colours.share(node, label) + UNSEEN_SHARE);
        libm::logf(object / background).clamp(-MAX_LOG_ODDS, MAX_LOG_ODDS)
    };
    is_near.iter().enumerate().map(|(node, &is_near)| if is_near { log_odds(node) } else { 0.0 }).collect()
}

/// Marks superpixels that have a pixel near an object, by a dilation of the objects' pixels with one bit a pixel.
fn near_objects(superpixels: &Superpixels, is_object: &[bool]) -> Vec<bool> {
    let label = superpixels.label();
    let (w, h) = (label.width(), label.height());
    let radius = (NEAR_SIDE_SHARE * w.max(h) as f32) as usize;
    let row_words = w.div_ceil(64);
    let mut dilated = Vec::with_capacity(row_words * h);
    for y in 0..h {
        let bits =
            |labels: &[u32]| labels.iter().rev().fold(0, |bits, &s| bits << 1 | u64::from(is_object[s as usize]));
        dilated.extend(label.row(y).chunks(64).map(bits));
    }
    dilated.chunks_exact_mut(row_words).for_each(|row| dilate(row, radius, 1));
    dilate(&mut dilated, radius, 64 * row_words);
    let mut is_near = vec![false; superpixels.count];
    for y in 0..h {
        for (labels, &bits) in label.row(y).chunks(64).zip(&dilated[y * row_words..]) {
            let mut bits = bits;
            while bits != 0 {
                // Bits after the end of a row have no pixel.
                labels.get(bits.trailing_zeros() as usize).into_iter().for_each(|&s| is_near[s as usize] = true);
                bits &= bits - 1;
            }
        }
    }
    is_near
}

/// Sets all bits within `radius` times `stride` of a set bit, by shifts that double.
fn dilate(bits: &mut [u64], radius: usize, stride: usize) {
    let mut reached = 0;
    while reached < radius {
        let step = (reached + 1).min(radius - reached);
        spread(bits, step * stride);
        reached += step;
    }
}

/// Sets the bits `distance` before and after each set bit.
fn spread(bits: &mut [u64], distance: usize) {
    let (skip, shift) = (distance / 64, distance % 64);
    for k in (skip..bits.len()).rev() {
        let carry = if shift > 0 && k > skip { bits[k - skip - 1] >> (64 - shift) } else { 0 };
        bits[k] |= bits[k - skip] << shift | carry;
    }
    for k in 0..bits.len().saturating_sub(skip) {
        let carry = if shift > 0 && k + skip + 1 < bits.len() { bits[k + skip + 1] << (64 - shift) } else { 0 };
        bits[k] |= bits[k + skip] >> shift | carry;
    }
}

/// Colour histogram of each label over the whole clip.
struct ClipColours {
    /// Mean colour of each superpixel, frame by frame.
    mean: Vec<Colour>,
    /// Number of pixels of each superpixel.
    area: Vec<f32>,
    labels: Vec<Histogram>,
}

impl ClipColours {
    /// Computes mean colours, with empty histograms; `None` unless every frame has the size of its superpixels.
    fn new(superpixels: &[Superpixels], frames: &[Frame], num_labels: usize) -> Option<Self> {
        let (mut mean, mut area) = (Vec::new(), Vec::new());
        for (t, s) in superpixels.iter().enumerate() {
            let frame = frames.get(t).filter(|f| (f.width(), f.height()) == s.runs().size())?;
            // Red and green, and blue and the count, each in the halves of a number.
            let mut sums = vec![[0_u64; 2]; s.count];
            for (&p, rgb) in s.label().data().iter().zip(frame.rgb().as_chunks::<3>().0) {
                let (sum, [r, g, b]) = (&mut sums[p as usize], rgb.map(u64::from));
                *sum = [sum[0] + (r | g << 32), sum[1] + (b | 1 << 32)];
            }
            for [red_green, blue_count] in sums {
                let [r, g, b, count] = [red_green, red_green >> 32, blue_count, blue_count >> 32].map(|v| v as u32);
                mean.push(Colour::from_rgb(&[r, g, b].map(|v| (v / count.max(1)) as u8)));
                area.push(count as f32);
            }
        }
        Some(Self { mean, area, labels: vec![Histogram::new(); num_labels] })
    }

    /// Adds a share of the superpixel `node` to the histogram of `label`.
    fn add(&mut self, node: usize, label: usize, share: f32) {
        self.labels[label].add(&self.mean[node].corners(), share * self.area[node]);
    }

    /// Returns the share of `label` that has the colour of superpixel `node`.
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
    fn superpixels_near_an_object_with_its_colour_have_positive_log_odds() {
        let (superpixels, frame) = columns([200, 200, 200, 40, 40, 40, 40, 40, 200, 200]);
        // In the first frame the object was cut too small.
        let labels = [vec![1, 1, 0, 0, 0, 0, 0, 0, 0, 0], vec![1, 1, 1, 0, 0, 0, 0, 0, 0, 0]];
        let log_odds =
            appearance_log_odds(&[superpixels.clone(), superpixels], &[frame.clone(), frame], &labels, &[false, true]);
        assert!(log_odds[2] > 0.5 && log_odds[13] < -1.0, "{log_odds:?}");
        assert_eq!(log_odds[3..10], [0.0; 7]);
    }

    #[test]
    fn background_unlike_the_object_has_negative_log_odds() {
        let (superpixels, frame) = columns([200, 200, 40, 40, 40, 40, 40, 40, 40, 40]);
        let labels = [vec![1, 1, 1, 0, 0, 0, 0, 0, 0, 0], vec![1, 1, 1, 0, 0, 0, 0, 0, 0, 0]];
        let log_odds =
            appearance_log_odds(&[superpixels.clone(), superpixels], &[frame.clone(), frame], &labels, &[false, true]);
        assert_eq!(log_odds.len(), 20);
        assert!(log_odds[0] > 1.0 && log_odds[3] < 0.0 && log_odds[2] < 0.0, "{log_odds:?}");
    }

    #[test]
    fn without_objects_or_frames_the_log_odds_are_zero() {
        let (superpixels, frame) = columns([9; 10]);
        let labels = [vec![0; 10]];
        let pictures = std::slice::from_ref(&superpixels);
        assert_eq!(appearance_log_odds(pictures, &[frame], &labels, &[false, true]), [0.0; 10]);
        assert_eq!(appearance_log_odds(pictures, &[], &labels, &[false, true]), [0.0; 10]);
    }

    #[test]
    fn near_objects_equals_a_naive_search() {
        let mut rng = crate::rng::Rng::for_stage(3, "near");
        for _ in 0..20 {
            let label = Plane::from_fn(40, 30, |x, y| (x / 4 + y / 3 * 10) as u32);
            let superpixels = Superpixels::from(&label);
            let object: Vec<bool> = (0..100).map(|_| rng.below(30) == 0).collect();
            let is_marked = near_objects(&superpixels, &object);
            let places = || (0..40 * 30).map(|i| (i % 40, i / 40));
            for s in 0..100_u32 {
                let is_inside = |&(x, y): &(usize, usize)| label[(x, y)] == s;
                let of_object = |&(x, y): &(usize, usize)| object[label[(x, y)] as usize];
                let is_near = places()
                    .filter(is_inside)
                    .any(|(x, y)| places().filter(of_object).any(|(a, b)| x.abs_diff(a) <= 4 && y.abs_diff(b) <= 4));
                assert_eq!(is_marked[s as usize], is_near);
            }
        }
    }
}
