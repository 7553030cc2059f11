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
//! [`Agreement::doubts`] are the frames of which a low J is expected (`expected_j`), or whose objects are suddenly larger or
//! smaller: masks that are wrong in the same way for some frames agree, but they begin and end with a jump.
//!
//! A wrong mask disagrees with all six, a correct one beside it only with that. Masks that are wrong in the same way in all
//! frames agree. The cost is linear in pixels. Not in the paper.

use crate::flow::{CompactFlow, Field, STEPS_PER_PIXEL_LOG2};
use crate::image::Plane;
use std::ops::Range;

/// Frames are compared with those this many frames before and after; chosen by eye.
const GAPS: [usize; 3] = [1, 2, 4];
/// Pixels are followed at least this many along the longer side of the frame, and less than twice as many, or all; chosen by eye.
const MIN_GRID_SIDE: usize = 120;
/// The same where only the mean of the clip is asked for; chosen by eye.
const MIN_COARSE_GRID_SIDE: usize = 60;
/// A frame is doubtful if a lower J is expected; chosen on left-out kinds of clips (`bench masks`).
const DOUBTFUL_J: f32 = 0.68;
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
    /// Expected J of each frame, `0.0..=1.0`: the intersection over union with the true mask. `None` where it is not judged:
    /// in frames without objects, and without an agreement.
    pub expected_j: Vec<Option<f32>>,
    /// Log-odds above which clusters were merged, if not those of `discretize.mergeLogOdds`, whose masks agreed less.
    pub merge_log_odds: Option<f64>,
    /// Number of pixels of objects in each frame.
    pub(crate) areas: Vec<u32>,
}

impl Agreement {
    /// Returns the ranges of frames whose masks should be looked at, in their order: those of which a low J is expected or
    /// whose objects have almost twice, or half, the area that they have in the frames around, and up to two frames before
    /// and after them.
    #[must_use]
    pub fn doubts(&self) -> Vec<Range<usize>> {
        let is_low = |t: &usize| self.expected_j.get(*t).copied().flatten().is_some_and(|j| j < DOUBTFUL_J);
        let mut doubts: Vec<Range<usize>> = Vec::new();
        for t in (0..self.frames.len()).filter(|t| is_low(t) || self.has_sudden_area(*t)) {
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
    Agreement { clip: mean(&frames), frames, objects: values.collect(), areas, ..Agreement::default() }
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
mod tests {
    use super::*;
    use crate::flow::FlowField;
    use crate::rng::Rng;

    const SIZE: (usize, usize) = (80, 60);
    /// Every fourth pixel.
    const NAIVE_GRID_SIDE: usize = 20;

    fn flow_of(size: (usize, usize), motion: impl Fn(usize, usize) -> (f32, f32)) -> CompactFlow {
        let plane = |component: fn((f32, f32)) -> f32| Plane::from_fn(size.0, size.1, |x, y| component(motion(x, y)));
        CompactFlow::new(&FlowField { u: plane(|d| d.0), v: plane(|d| d.1) })
    }

    /// Object 1, 24 pixels wide and 20 high, with its left border at `left`.
    fn object(left: usize) -> Plane<u8> {
        Plane::from_fn(SIZE.0, SIZE.1, |x, y| u8::from((left..left + 24).contains(&x) && (16..36).contains(&y)))
    }

    fn still(frames: usize) -> Vec<CompactFlow> {
        vec![flow_of(SIZE, |_, _| (0.0, 0.0)); frames - 1]
    }

    #[test]
    fn still_masks_agree_and_empty_ones_say_nothing() {
        let result = agreement(&vec![object(20); 7], &still(7));
        let (frames, objects) = (vec![Some(1.0); 7], vec![vec![Some(1.0); 7]]);
        let clip = Some(1.0);
        assert_eq!(result, Agreement { clip, frames, objects, areas: vec![480; 7], ..Agreement::default() });

        let result = agreement(&vec![Plane::filled(SIZE.0, SIZE.1, 0); 7], &still(7));
        assert_eq!((result.clip, result.frames, result.objects.len()), (None, vec![None; 7], 0));
    }

    #[test]
    fn masks_that_move_with_the_flow_agree_and_those_that_stay_do_not() {
        // The object moves four pixels a frame before a still scene.
        let corner = |t: usize| 8 + 4 * t;
        let moving: Vec<_> = (0..8).map(|t| object(corner(t))).collect();
        let flows: Vec<_> =
            moving[..7].iter().map(|mask| flow_of(SIZE, |x, y| (4.0 * f32::from(mask[(x, y)]), 0.0))).collect();
        let clip = agreement(&moving, &flows).clip.unwrap();
        assert!(clip > 0.95, "{clip}");
        let clip = agreement(&vec![object(20); 8], &flows).clip.unwrap();
        assert!(clip < 0.9, "{clip}");
    }

    #[test]
    fn a_flooded_mask_agrees_least_and_those_beside_it_less_than_others() {
        let mut masks = vec![object(20); 15];
        masks[7] = Plane::filled(SIZE.0, SIZE.1, 1);
        let frames: Vec<f32> = agreement(&masks, &still(15)).frames.into_iter().flatten().collect();
        assert!(frames[7] < 0.2, "{frames:?}");
        for near in [3, 5, 6, 8, 9, 11] {
            assert!(frames[near] > 0.8 && frames[near] < 0.9, "{frames:?}");
        }
        assert!([0, 1, 2, 4, 10, 12, 13, 14].into_iter().all(|far| frames[far] == 1.0), "{frames:?}");
    }

    #[test]
    fn objects_are_compared_where_one_of_two_frames_has_them() {
        let mut masks = vec![object(20); 12];
        // Object 2 has the right half of object 1 in frame 6 and touches no other frame.
        (16..36).for_each(|y| (32..44).for_each(|x| masks[6][(x, y)] = 2));
        let result = agreement(&masks, &still(12));
        assert_eq!(result.clip, Some(1.0), "all objects as one");
        assert_eq!((result.objects[0][6], result.objects[1][6]), (Some(0.5), Some(0.0)));
        assert_eq!((result.objects[1][7], result.objects[1][9]), (Some(0.0), None));
    }

    #[test]
    fn missing_frames_flows_and_other_sizes_are_left_out() {
        let mut masks = vec![object(20); 6];
        masks[2] = Plane::default();
        let expected = [Some(1.0), Some(1.0), None, Some(1.0), Some(1.0), Some(1.0)];
        assert_eq!(agreement(&masks, &still(6)).frames, expected);
        masks[2] = Plane::filled(90, 60, 1);
        assert_eq!(agreement(&masks, &still(6)).frames, expected);

        let masks = vec![object(20); 4];
        let mut flows = still(4);
        flows[1] = flow_of((20, 20), |_, _| (0.0, 0.0));
        assert_eq!(agreement(&masks, &flows).frames, [Some(1.0); 4], "0 and 1, 2 and 3");
        assert_eq!(agreement(&masks, &flows[..1]).frames, [Some(1.0), Some(1.0), None, None]);
        for (masks, flows) in [(0, 3), (1, 0), (1, 3), (3, 0)] {
            let result = agreement(&vec![object(20); masks], &still(1 + flows));
            assert_eq!((result.clip, result.frames), (None, vec![None; masks]));
        }
        assert_eq!(agreement(&[object(1), object(1)], &still(9)).clip, Some(1.0));
    }

    /// Follows one pixel at a time and compares one label at a time.
    fn naive(masks: &[Plane<u8>], flows: &[CompactFlow], t: usize, is_object: impl Fn(u8) -> bool) -> Option<f32> {
        let ((w, h), step) = (SIZE, 1 << grid_step_log2(SIZE.0, NAIVE_GRID_SIDE));
        let land = |s: usize, gap: usize, x: usize, y: usize| {
            let (mut px, mut py) = (x as f32, y as f32);
            for flow in &flows[s..s + gap] {
                let (u, v) = flow.at((px + 0.5) as usize, (py + 0.5) as usize);
                (px, py) = (px + u, py + v);
                if px < -0.5 || py < -0.5 || px >= w as f32 - 0.5 || py >= h as f32 - 0.5 {
                    return None;
                }
            }
            Some((px, py))
        };
        let mut overlaps = Vec::new();
        for gap in [1, 2, 4] {
            for s in [t.checked_sub(gap), Some(t)].into_iter().flatten().filter(|s| s + gap < masks.len()) {
                let starts = || (0..w * h).map(|p| (p % w, p / w)).filter(|(x, y)| x % step == 0 && y % step == 0);
                let cell = |(x, y): (f32, f32)| ((x + 0.5) as usize / step, (y + 0.5) as usize / step);
                let label = |mask: &Plane<u8>, (x, y): (f32, f32)| mask[((x + 0.5) as usize, (y + 0.5) as usize)];
                let (mut both, mut either) = (0, 0);
                for (x, y) in starts() {
                    let Some(to) = land(s, gap, x, y) else { continue };
                    let (first, second) = (masks[s][(x, y)], label(&masks[s + gap], to));
                    let is_shown = |(a, b): (usize, usize)| {
                        let other = land(s, gap, a, b).filter(|&other| cell(other) == cell(to));
                        other.is_some_and(|other| masks[s][(a, b)] == label(&masks[s + gap], other))
                    };
                    let counts = first == second || !starts().any(is_shown);
                    both += u32::from(counts && is_object(first) && is_object(second));
                    either += u32::from(counts && (is_object(first) || is_object(second)));
                }
                overlaps.extend((either > 0).then(|| f64::from(both) / f64::from(either)));
            }
        }
        (!overlaps.is_empty()).then(|| (overlaps.iter().sum::<f64>() / overlaps.len() as f64) as f32)
    }

    #[test]
    fn the_agreement_is_that_of_a_naive_version() {
        let mut rng = Rng::for_stage(1, "agreement");
        let (w, h) = SIZE;
        let mut mask = || {
            let corners: Vec<(usize, usize)> = (0..3).map(|_| (rng.below(w), rng.below(h))).collect();
            let label = |x: usize, y: usize| corners.iter().position(|c| c.0.abs_diff(x) < 18 && c.1.abs_diff(y) < 14);
            Plane::from_fn(w, h, |x, y| label(x, y).map_or(0, |k| k as u8 + 1))
        };
        let masks: Vec<_> = (0..6).map(|_| mask()).collect();
        let motion = |t: usize| {
            flow_of(SIZE, move |x, y| {
                let (x, y) = (x as f64 / 7.0 + t as f64, y as f64 / 5.0);
                (2.5 * (x + y).sin() as f32, 1.5 * (x - 2.0 * y).cos() as f32)
            })
        };
        let flows: Vec<_> = (0..5).map(motion).collect();
        let result = agreement_of_grid(&masks, &flows, NAIVE_GRID_SIDE);
        let is_near = |a: Option<f32>, b: Option<f32>| match (a, b) {
            (Some(a), Some(b)) => (a - b).abs() < 1e-6,
            (a, b) => a == b,
        };
        for t in 0..6 {
            let all = naive(&masks, &flows, t, |label| label > 0);
            assert!(is_near(result.frames[t], all), "frame {t}: {:?} {all:?}", result.frames[t]);
            for label in 1..=3 {
                let (object, one) =
                    (result.objects[label - 1][t], naive(&masks, &flows, t, |l| usize::from(l) == label));
                assert!(is_near(object, one), "frame {t}, label {label}: {object:?} {one:?}");
            }
        }
    }

    #[test]
    fn doubts_are_ranges_around_the_frames_of_a_low_expected_j() {
        let doubts = |expected_j: &[Option<f32>]| {
            let (frames, areas) = (vec![Some(0.9); expected_j.len()], vec![100; expected_j.len()]);
            Agreement { frames, areas, expected_j: expected_j.to_vec(), ..Agreement::default() }.doubts()
        };
        assert!(doubts(&[]).is_empty() && doubts(&[None; 9]).is_empty() && doubts(&[Some(0.8); 30]).is_empty());
        assert_eq!(doubts(&[Some(0.1); 9]), [Range { start: 0, end: 9 }], "wrong from the first frame to the last");
        let mut expected = [Some(0.8); 30];
        (expected[9], expected[13], expected[19], expected[0]) = (Some(0.3), Some(0.1), Some(0.2), Some(0.4));
        assert_eq!(doubts(&expected), [0..3, 7..16, 17..22]);
        (expected[29], expected[20]) = (Some(0.0), None);
        assert_eq!(doubts(&expected), [0..3, 7..16, 17..22, 27..30]);
    }

    #[test]
    fn a_flooded_frame_is_a_doubt_by_its_area_alone() {
        let mut masks = vec![object(20); 15];
        masks[7] = Plane::filled(SIZE.0, SIZE.1, 1);
        assert_eq!(agreement(&masks, &still(15)).doubts(), [Range { start: 5, end: 10 }]);
    }

    #[test]
    fn areas_that_jump_are_doubts_and_those_that_grow_are_not() {
        let doubts = |areas: &[u32]| {
            Agreement { frames: vec![Some(0.9); areas.len()], areas: areas.to_vec(), ..Agreement::default() }.doubts()
        };
        let growing: Vec<u32> = (0..40).map(|t| 100 + 20 * t).collect();
        assert!(doubts(&growing).is_empty() && doubts(&[0; 20]).is_empty());
        let mut areas = [100; 30];
        (areas[9], areas[10], areas[20]) = (179, 56, 0);
        assert_eq!(doubts(&areas), [Range { start: 18, end: 23 }]);
        (areas[9], areas[10]) = (181, 55);
        assert_eq!(doubts(&areas), [7..13, 18..23]);
        // An object that enters: too few frames around have one.
        let entering: Vec<u32> = (0..30).map(|t| if t < 26 { 0 } else { 50 }).collect();
        assert!(doubts(&entering).is_empty());
    }
}
