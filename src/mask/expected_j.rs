//! The expected J of masks: an estimate of their intersection over union with the true masks, which are not needed.
//!
//! In: a cut and its input, the masks made from it, their agreement along the flow, the frames and the flow. Out: the
//! expected J of each frame. It is a logistic regression on three terms.
//!
//! 1. Each superpixel has a probability `p` of being an object's, by its own log-odds: background, appearance and
//!    trajectories. The expected intersection of a mask and the truth is `Σ p` over the mask, their expected union is the
//!    mask's area and `Σ p` outside of it. The first term is the mean of their quotient over the clip.
//! 2. A border of an object where neither colours nor the flow differ on both sides is likely a wrong one. The second term is
//!    the mean share of such borders over the clip.
//! 3. The third term is the agreement of the frame.
//!
//! Means over the clip predict J better than the values of a frame: masks are seldom wrong in one frame alone. A frame
//! without objects, or without an agreement, is not judged. Not in the paper. Cost: O(pixels + points). It fails on masks
//! that are wrong for good reasons: what moves and is no object, and parts of an object that never move.

use crate::cut::{CutInput, CutParams, pixel_index};
use crate::flow::{CompactFlow, Field};
use crate::image::{Frame, Plane};

/// Weights of a frame's J: bias, then the terms. Fitted by `cargo run --release -p tracecut-bench -- masks davis wild --frames 40
/// --seeds 0`, which prints them; do not edit them by hand.
const WEIGHTS: [f64; 1 + NUM_TERMS] = [-4.1323, 5.0637, -4.7331, 1.6554];

/// Number of terms of a frame.
pub(crate) const NUM_TERMS: usize = 3;

// The constants below are chosen by eye.

/// Factor on the log-odds of a superpixel.
const LOG_ODDS_FACTOR: f64 = 2.0;
/// Colours and flow of the two sides of a border are compared at this distance from it.
const BORDER_REACH_PX: usize = 3;
/// Least difference of the flow, squared, in pixels, and of the colours, squared, in grey levels, across a supported border.
const MIN_FLOW_STEP_SQ: f32 = 0.25;
const MIN_COLOUR_STEP_SQ: u32 = 400;

/// The masks of a clip, and what they were made from, at one size.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CutMasks<'a> {
    pub input: CutInput<'a>,
    pub params: &'a CutParams,
    /// The mask label of each label of the cut, 0 for the background.
    pub objects: &'a [u8],
    pub masks: &'a [Plane<u8>],
    pub frames: &'a [Frame],
    /// The flow of each pair of frames.
    pub flows: &'a [CompactFlow],
}

/// Computes the expected J of each frame, 0 to 1; `None` for frames that are not judged. `agreement` is that of the masks
/// along the flow.
pub(crate) fn expected_j(masks: &CutMasks, agreement: &[Option<f32>]) -> Vec<Option<f32>> {
    let expected = |terms: [f64; NUM_TERMS]| {
        sigmoid(WEIGHTS[0] + WEIGHTS[1..].iter().zip(terms).map(|(weight, term)| weight * term).sum::<f64>()) as f32
    };
    expected_j_terms(masks, agreement).into_iter().map(|terms| terms.map(expected)).collect()
}

/// Computes the terms of each frame: the expected intersection over union and the share of unsupported borders, as means over
/// the clip, and the agreement of the frame.
pub(crate) fn expected_j_terms(masks: &CutMasks, agreement: &[Option<f32>]) -> Vec<Option<[f64; NUM_TERMS]>> {
    let (mut has_objects, mut first) = (Vec::new(), 0);
    let (mut iou_sum, mut unsupported_sum, mut count) = (0.0, 0.0, 0.0);
    for (t, superpixels) in masks.input.superpixels.iter().enumerate() {
        let iou = masks.expected_iou(t, first);
        has_objects.push(iou.is_some());
        if let Some(iou) = iou {
            (iou_sum, unsupported_sum) = (iou_sum + iou, unsupported_sum + masks.unsupported_share(t));
            count += 1.0;
        }
        first += superpixels.count;
    }
    let terms = |(&agreement, has_objects): (&Option<f32>, bool)| {
        Some([iou_sum / count, unsupported_sum / count, f64::from(agreement.filter(|_| has_objects)?)])
    };
    agreement.iter().zip(has_objects).map(terms).collect()
}

impl CutMasks<'_> {
    /// Computes the expected intersection over union of the mask of frame `t` with the truth; `None` without objects. `first`
    /// is the number of the frame's first superpixel among all.
    fn expected_iou(&self, t: usize, first: usize) -> Option<f64> {
        let Self { input, params, .. } = self;
        let (superpixels, mask) = (&input.superpixels[t], &self.masks[t]);
        let mut inside = vec![0_u32; superpixels.count];
        for (y, columns, p) in superpixels.runs().rows() {
            inside[p as usize] += mask.row(y)[columns].iter().filter(|&&label| label > 0).count() as u32;
        }
        let at = |values: &[f32], p: usize| values.get(first + p).copied().unwrap_or_default();
        let (mut intersection, mut union) = (0.0, 0.0);
        for (p, (vote, area)) in self.votes(t).into_iter().zip(superpixels.areas()).enumerate() {
            let log_odds = at(input.evidence, p) + params.appearance_weight * at(input.appearance, p) + vote;
            let probability = sigmoid(LOG_ODDS_FACTOR * f64::from(log_odds));
            intersection += f64::from(inside[p]) * probability;
            union += f64::from(inside[p]) + f64::from(area - inside[p]) * probability;
        }
        inside.iter().any(|&inside| inside > 0).then(|| intersection / union)
    }

    /// Returns the share of objects less that of the background among the trajectories in each superpixel of frame `t`; 0
    /// without any.
    fn votes(&self, t: usize) -> Vec<f32> {
        let superpixels = &self.input.superpixels[t];
        let (size, superpixel) = (superpixels.runs().size(), superpixels.label());
        let mut votes = vec![(0.0, 0.0_f32); superpixels.count];
        for (i, x, y) in self.input.tracks.alive(t) {
            let label = self.input.label.get(i).and_then(|&label| self.objects.get(label as usize));
            let Some(&label) = label else { continue };
            let (sum, count) = &mut votes[superpixel.data()[pixel_index(size, x, y)] as usize];
            (*sum, *count) = (*sum + if label > 0 { 1.0 } else { -1.0 }, *count + 1.0);
        }
        votes.into_iter().map(|(sum, count)| sum / count.max(1.0)).collect()
    }

    /// Computes the share of the borders of objects in frame `t` across which neither the flow nor the colours differ.
    fn unsupported_share(&self, t: usize) -> f64 {
        let (mask, frame) = (&self.masks[t], &self.frames[t]);
        let Some(flow) = self.flows.get(t).or(self.flows.last()) else { return 0.0 };
        let (width, height) = (mask.width(), mask.height());
        let is_unsupported = |a: (usize, usize), b: (usize, usize)| {
            let ([(u0, v0), (u1, v1)], colour) =
                ([a, b].map(|(x, y)| flow.at(x, y)), |(x, y): (usize, usize)| &frame.rgb()[3 * (y * width + x)..][..3]);
            let steps = colour(a).iter().zip(colour(b)).map(|(a, b)| u32::from(a.abs_diff(*b)).pow(2));
            (u0 - u1).powi(2) + (v0 - v1).powi(2) < MIN_FLOW_STEP_SQ && steps.sum::<u32>() < MIN_COLOUR_STEP_SQ
        };
        let (mut unsupported, mut length) = (0, 0);
        for (dx, dy) in [(1, 0), (0, 1)] {
            let (before, after) = (1 + BORDER_REACH_PX, BORDER_REACH_PX);
            for y in before * dy..height.saturating_sub(after * dy) {
                for x in before * dx..width.saturating_sub(after * dx) {
                    if (mask[(x, y)] > 0) != (mask[(x - dx, y - dy)] > 0) {
                        let outer = [(x - before * dx, y - before * dy), (x + after * dx, y + after * dy)];
                        unsupported += u32::from(is_unsupported(outer[0], outer[1]));
                        length += 1;
                    }
                }
            }
        }
        f64::from(unsupported) / f64::from(length.max(1))
    }
}

fn sigmoid(x: f64) -> f64 {
    1.0 / (1.0 + libm::exp(-x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::FlowField;
    use crate::superpixel::Superpixels;
    use crate::trajectory::Trajectories;

    const FRAMES: usize = 3;
    /// Two superpixels of 12 x 6 pixels side by side in each frame; the left one is an object.
    const SIZE: (usize, usize) = (24, 6);

    fn plane<T: Copy>(left: T, right: T) -> Plane<T> {
        Plane::from_fn(SIZE.0, SIZE.1, |x, _| if x < SIZE.0 / 2 { left } else { right })
    }

    /// What is known of the left and the right superpixel.
    #[derive(Clone, Copy, Default)]
    struct Sides {
        evidence: [f32; 2],
        grey: [u8; 2],
        motion: [f32; 2],
        /// Trajectories of the object, on the left.
        num_tracks: usize,
    }

    /// The terms of the frames; those of `empty` have no object, and the last one has no agreement.
    fn terms_of(sides: Sides, empty: &[usize]) -> Vec<Option<[f64; NUM_TERMS]>> {
        let Sides { evidence, grey, motion, num_tracks } = sides;
        let superpixels = vec![Superpixels::from(&plane(0, 1)); FRAMES];
        let mut tracks = Trajectories::empty(FRAMES, SIZE);
        (0..num_tracks).for_each(|k| tracks.push(0, (0..FRAMES).map(|_| (k as f32, 1.0, 0.0))));
        let masks: Vec<_> = (0..FRAMES).map(|t| plane(u8::from(!empty.contains(&t)), 0)).collect();
        let rgb = plane(grey[0], grey[1]).data().iter().flat_map(|&grey| [grey; 3]).collect();
        let flow = FlowField { u: plane(motion[0], motion[1]), v: plane(0.0, 0.0) };
        let input = CutInput {
            superpixels: &superpixels,
            tracks: &tracks,
            label: &vec![1; num_tracks],
            num_labels: 2,
            objects: &[false, true],
            evidence: &evidence.repeat(FRAMES),
            appearance: &[],
        };
        let masks = CutMasks {
            input,
            params: &CutParams::default(),
            objects: &[0, 1],
            masks: &masks,
            frames: &vec![Frame::from_rgb(rgb, SIZE.0, SIZE.1).unwrap(); FRAMES],
            flows: &vec![CompactFlow::new(&flow); FRAMES - 1],
        };
        let agreement = [Some(0.9), Some(0.8), None];
        let (expected, terms) = (expected_j(&masks, &agreement), expected_j_terms(&masks, &agreement));
        assert!(expected.iter().zip(&terms).all(|(j, terms)| j.is_some() == terms.is_some()));
        terms
    }

    #[test]
    fn the_expected_overlap_is_a_quotient_of_expected_areas() {
        let overlap =
            |evidence, num_tracks| terms_of(Sides { evidence, num_tracks, ..Sides::default() }, &[])[0].unwrap()[0];
        // Half of the object's 72 pixels, over these and half of the others.
        assert!((overlap([0.0, 0.0], 0) - 36.0 / 108.0).abs() < 1e-6);
        let p = sigmoid(2.0);
        assert!((overlap([0.0, 0.0], 3) - 72.0 * p / 108.0).abs() < 1e-6, "all trajectories are the object's");
        assert!((overlap([1.0, -1.0], 0) - p / (2.0 - p)).abs() < 1e-6);
        assert!(overlap([3.0, -3.0], 3) > 0.99 && overlap([-3.0, 3.0], 0) < 0.01);
    }

    #[test]
    fn borders_are_supported_by_a_step_of_the_flow_or_of_the_colours() {
        let unsupported = |grey, motion| terms_of(Sides { grey, motion, ..Sides::default() }, &[])[0].unwrap()[1];
        assert_eq!(unsupported([90, 100], [0.0, 0.4]), 1.0);
        assert_eq!(unsupported([90, 102], [0.0, 0.4]), 0.0);
        assert_eq!(unsupported([90, 100], [0.0, 0.6]), 0.0);
    }

    #[test]
    fn terms_are_means_over_the_clip_but_for_the_agreement() {
        let terms = terms_of(Sides { evidence: [1.0, -1.0], ..Sides::default() }, &[]);
        let [first, second] = [terms[0].unwrap(), terms[1].unwrap()];
        assert_eq!(first[..2], second[..2]);
        assert_eq!([first[2], second[2]], [0.9, 0.8].map(|agreement: f32| f64::from(agreement)));
    }

    #[test]
    fn frames_without_objects_or_agreement_are_not_judged() {
        let is_judged =
            |empty: &[usize]| terms_of(Sides::default(), empty).iter().map(Option::is_some).collect::<Vec<_>>();
        assert_eq!(is_judged(&[]), [true, true, false]);
        assert_eq!(is_judged(&[1]), [true, false, false]);
        assert_eq!(is_judged(&[0, 1, 2]), [false; 3]);
    }
}
