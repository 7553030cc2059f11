//! The agreement of masks with the masks of nearby frames along the flow: a measure of quality that needs no true masks.
//!
//! In: the mask of each frame, and the forward flow of each pair of consecutive frames. Out: [`Agreement`], 1 where a mask
//! equals its neighbours, moved along the flow, and 0 where they share no pixel.
//!
//! 1. From every frame `s`, the pixels of a grid, every fourth of 480, are followed along the chained flow to `s + 1`, `s + 2`
//!    and `s + 4`, until they leave the frame. The label of each in `s` is compared with that where it lands.
//! 2. A pixel of another label is occluded, and does not count, if one of the same label lands beside it. Pixels that become
//!    visible are not followed at all.
//! 3. The agreement of two frames is intersection over union of these pixels, for all objects as one and for each object.
//! 4. The agreement of a frame is the mean over the up to six frames that it is compared with.
//!
//! [`Agreement::doubts`] are the frames that agree much less than others of the clip, or whose objects are suddenly larger or
//! smaller: masks that are wrong in the same way for some frames agree, but they begin and end with a jump.
//!
//! A wrong mask disagrees with all six, a correct one beside it only with that. Masks that are wrong in the same way in all
//! frames agree. The cost is linear in pixels. Not in the paper.

use crate::flow::{CompactFlow, Field, STEPS_PER_PIXEL_LOG2};
use crate::image::Plane;
use crate::order::nth_smallest;
use std::ops::Range;

/// Frames are compared with those this many frames before and after; chosen by eye.
const GAPS: [usize; 3] = [1, 2, 4];
/// Pixels are followed at least this many along the longer side of the frame, and less than twice as many, or all; chosen by eye.
const MIN_GRID_SIDE: usize = 120;
/// The same where only the mean of the clip is asked for; chosen by eye.
const MIN_COARSE_GRID_SIDE: usize = 60;
/// A frame is doubtful below this part of the median agreement of the clip; chosen by eye.
const DOUBTFUL_PART: f32 = 0.7;
/// And if the area of its objects differs by this factor from the median of the frames around it; chosen by eye.
const DOUBTFUL_AREA_FACTOR: f32 = 1.8;
/// These are the frames at most this many before and after it; chosen by eye.
const AREA_REACH: usize = 6;
/// Least number of them that have objects; chosen by eye.
const MIN_AREA_FRAMES: usize = 5;
/// Doubtful frames are in one range with those at most this many frames before and after; chosen by eye.
const DOUBT_REACH: usize = 2;

/// The agreement of masks with the masks of nearby frames along the flow, `0.0..=1.0`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Agreement {
    /// The mean over the frames; `None` if no two frames can be compared.
    pub clip: Option<f32>,
    /// Agreement of each frame, all objects as one: `None` without a frame to compare with, and where neither has an object.
    pub frames: Vec<Option<f32>>,
    /// The same of each label from 1 on.
    pub objects: Vec<Vec<Option<f32>>>,
    /// Log-odds above which clusters were merged, if not those of `discretize.mergeLogOdds`, whose masks agreed less.
    pub merge_log_odds: Option<f64>,
    /// Number of pixels of objects in each frame.
    pub(crate) areas: Vec<u32>,
}

impl Agreement {
    /// Returns the ranges of frames whose masks should be looked at, in their order: those that agree much less than the
    /// median frame or whose objects have almost twice, or half, the area that they have in the frames around, and up to
    /// two frames before and after them. Empty if all frames agree about as well.
    #[must_use]
    pub fn doubts(&self) -> Vec<Range<usize>> {
        let known: Vec<f32> = self.frames.iter().copied().flatten().collect();
        let threshold = DOUBTFUL_PART * nth_smallest(&known, known.len() / 2);
        let agrees_little = |t: &usize| self.frames[*t].is_some_and(|value| value < threshold);
        let mut doubts: Vec<Range<usize>> = Vec::new();
        for t in (0..self.frames.len()).filter(|t| agrees_little(t) || self.has_sudden_area(*t)) {
            let (from, to) = (t.saturating_sub(DOUBT_REACH), (t + DOUBT_REACH + 1).min(self.frames.len()));
            match doubts.last_mut().filter(|last| from <= last.end) {
                Some(last) => last.end = to,
                None => doubts.push(from..to),
            }
        }
        doubts
    }

    /// Returns whether the area of the objects in frame `t` is far from the median of the frames around.
    fn has_sudden_area(&self, t: usize) -> bool {
        let around = t.saturating_sub(AREA_REACH)..(t + AREA_REACH + 1).min(self.areas.len());
        let around: Vec<u32> = self.areas[around].iter().copied().filter(|&area| area > 0).collect();
        let num_smaller = |area: u32| around.iter().filter(|&&other| other < area).count();
        // The larger of the middle two of an even number.
        let median = around.iter().copied().filter(|&area| num_smaller(area) <= around.len() / 2).max();
        let (median, area) = (median.unwrap_or_default() as f32, self.areas[t] as f32);
        around.len() >= MIN_AREA_FRAMES
            && (area > DOUBTFUL_AREA_FACTOR * median || DOUBTFUL_AREA_FACTOR * area < median)
    }
}

fn mean(values: &[Option<f32>]) -> Option<f32> {
    let mut sum = Mean::default();
    values.iter().flatten().for_each(|&value| sum.add(f64::from(value)));
    sum.value()
}

/// Computes the agreement of `masks` (labels, 0 for the background) along `flows`: `flows[t]` leads from frame `t` to
/// `t + 1`, in pixels of the masks.
///
/// Frames are compared as far as there is flow between them, and masks only if they have its size: an empty mask stands
/// for a frame that has none.
pub(crate) fn agreement(masks: &[Plane<u8>], flows: &[CompactFlow]) -> Agreement {
    agreement_of_grid(masks, flows, MIN_GRID_SIDE)
}

/// Computes the mean agreement of a clip from a quarter of the pixels, and so faster; `None` if no two frames can be compared.
pub(crate) fn clip_agreement(masks: &[Plane<u8>], flows: &[CompactFlow]) -> Option<f32> {
    agreement_of_grid(masks, flows, MIN_COARSE_GRID_SIDE).clip
}

fn agreement_of_grid(masks: &[Plane<u8>], flows: &[CompactFlow], min_side: usize) -> Agreement {
    let num_labels = masks.iter().flat_map(Plane::data).max().map_or(0, |&label| usize::from(label));
    // First for all objects as one, then for each label.
    let mut means = vec![vec![Mean::default(); masks.len()]; 1 + num_labels];
    for s in 0..masks.len() {
        let Some(size) = flows.get(s).map(Field::size) else { break };
        let step_log2 = grid_step_log2(size.0.max(size.1), min_side);
        let mut followed = grid(size, 1 << step_log2);
        for (gap, flow) in (1..=GAPS[GAPS.len() - 1]).zip(&flows[s..]) {
            let Some(mask) = masks.get(s + gap).filter(|_| flow.size() == size) else { break };
            followed.retain_mut(|pixel| pixel.follow(flow));
            let has_size = |mask: &Plane<u8>| (mask.width(), mask.height()) == size;
            if !GAPS.contains(&gap) || !has_size(&masks[s]) || !has_size(mask) {
                continue;
            }
            let overlaps = overlaps([&masks[s], mask], &followed, num_labels, step_log2);
            for (means, overlap) in means.iter_mut().zip(overlaps) {
                for t in [s, s + gap] {
                    overlap.into_iter().for_each(|overlap| means[t].add(overlap));
                }
            }
        }
    }
    let mut values = means.iter().map(|means| means.iter().map(Mean::value).collect());
    let frames: Vec<Option<f32>> = values.next().unwrap_or_default();
    let area = |mask: &Plane<u8>| mask.data().iter().filter(|&&label| label > 0).count() as u32;
    let areas = masks.iter().map(area).collect();
    Agreement { clip: mean(&frames), frames, objects: values.collect(), merge_log_odds: None, areas }
}

/// Compares two masks along the pixels that were followed from the first to the second: intersection over union of all
/// objects as one, then of each label; `None` if neither mask has it.
fn overlaps(
    [from, to]: [&Plane<u8>; 2],
    followed: &[FollowedPixel],
    num_labels: usize,
    step_log2: u32,
) -> Vec<Option<f64>> {
    let width = to.width();
    let labels_of =
        |pixel: &FollowedPixel| [from.data()[pixel.start as usize], to.data()[pixel.index(width)]].map(usize::from);
    // A pixel is in a cell of the grid.
    let columns = (width >> step_log2) + 1;
    let cell_of = |pixel: &FollowedPixel| {
        let (x, y) = pixel.pixel();
        (y >> step_log2) * columns + (x >> step_log2)
    };
    let mut agrees = vec![false; columns * ((to.height() >> step_log2) + 1)];
    let mut counts = vec![ObjectCount::default(); 1 + num_labels];
    let mut all = ObjectCount::default();
    let mut mismatches = Vec::new();
    for pixel in followed {
        let ([first, second], cell) = (labels_of(pixel), cell_of(pixel));
        if first == second {
            agrees[cell] = true;
            counts[first].add(true);
        } else {
            mismatches.push((first, second, cell));
        }
    }
    counts[1..].iter().for_each(|count| all.add_all(count));
    for (first, second, _) in mismatches.into_iter().filter(|&(.., cell)| !agrees[cell]) {
        counts[first].add(false);
        counts[second].add(false);
        all.add(first > 0 && second > 0);
    }
    // The background's place.
    counts[0] = all;
    counts.iter().map(ObjectCount::overlap).collect()
}

/// A mean of some numbers.
#[derive(Debug, Clone, Copy, Default)]
struct Mean {
    sum: f64,
    count: u32,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    fn value(&self) -> Option<f32> {
        (self.count > 0).then(|| (self.sum / f64::from(self.count)) as f32)
    }
}

/// A pixel that is followed along the flow.
#[derive(Debug, Clone, Copy)]
struct FollowedPixel {
    /// The index of the pixel in the first frame.
    start: u32,
    /// Its position now plus half a pixel, in the steps of the flow, so that sums are exact.
    x: i32,
    y: i32,
}

impl FollowedPixel {
    /// Moves to the next frame; false outside of it.
    fn follow(&mut self, flow: &CompactFlow) -> bool {
        let (width, height) = flow.size();
        let (u, v) = flow.steps(self.index(width));
        (self.x, self.y) = (self.x + u, self.y + v);
        // A negative position is a large number.
        let is_inside =
            |position: i32, length: usize| (position.cast_unsigned() as usize) < length << STEPS_PER_PIXEL_LOG2;
        is_inside(self.x, width) && is_inside(self.y, height)
    }

    /// Returns the nearest pixel.
    fn pixel(&self) -> (usize, usize) {
        let pixel = |position: i32| (position.cast_unsigned() >> STEPS_PER_PIXEL_LOG2) as usize;
        (pixel(self.x), pixel(self.y))
    }

    /// Returns the index of the nearest pixel in a plane of this width.
    fn index(&self, width: usize) -> usize {
        let (x, y) = self.pixel();
        y * width + x
    }
}

/// Returns the distance of followed pixels in a frame of this longer side, as a power of two.
fn grid_step_log2(side: usize, min_side: usize) -> u32 {
    (side / min_side).max(1).ilog2()
}

/// Returns the pixels to follow.
fn grid((width, height): (usize, usize), step: usize) -> Vec<FollowedPixel> {
    let centre = |k: usize| (k << STEPS_PER_PIXEL_LOG2) as i32 + (1 << STEPS_PER_PIXEL_LOG2) / 2;
    let pixel = |x: usize, y: usize| FollowedPixel { start: (y * width + x) as u32, x: centre(x), y: centre(y) };
    (0..height).step_by(step).flat_map(|y| (0..width).step_by(step).map(move |x| pixel(x, y))).collect()
}

/// The numbers of pixels that are on an object in one of two frames, and in both.
#[derive(Debug, Clone, Copy, Default)]
struct ObjectCount {
    in_either: u32,
    in_both: u32,
}

impl ObjectCount {
    fn add(&mut self, is_in_both: bool) {
        self.in_either += 1;
        self.in_both += u32::from(is_in_both);
    }

    fn add_all(&mut self, other: &Self) {
        self.in_either += other.in_either;
        self.in_both += other.in_both;
    }

    /// Returns the intersection over union; `None` if neither frame has the object.
    fn overlap(&self) -> Option<f64> {
        (self.in_either > 0).then(|| f64::from(self.in_both) / f64::from(self.in_either))
    }
}

#[cfg(test)]
mod tests;
