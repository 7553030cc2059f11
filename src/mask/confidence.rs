//! The probability that a pixel is correctly labelled as object or background.
//!
//! It is a logistic function of features of the pixel, with weights fitted on clips with true masks (docs/confidence.md). In
//! the background the main feature is the margin of the cut: the extra cost of the cheapest other label of the superpixel. In
//! objects the margin is not informative, since wrong objects are wrong as a whole; there the features are the background
//! evidence for the object and the share of the frame labelled as objects. Confidence falls near borders.

use crate::image::Plane;

// Ranges of the features, chosen by eye from the clips of the fit.
/// Depths count up to this many pixels.
const MAX_DEPTH_PX: f32 = 12.0;
/// Margins count up to this, in units of cost.
const MAX_MARGIN: f32 = 20.0;
/// Background evidence counts from this on, in units of cost.
const MIN_CUE: f32 = -1.0;
/// Background evidence counts up to this, in units of cost.
const MAX_CUE: f32 = 3.0;
/// Least confidence: no features are evidence for less.
const MIN_CONFIDENCE: f32 = 0.3;

/// Weights of the logistic function for background pixels.
struct BackgroundWeights {
    bias: f32,
    log_margin: f32,
    depth: f32,
}

/// Weights of the logistic function for object pixels.
struct ObjectWeights {
    bias: f32,
    cue: f32,
    depth: f32,
    /// Weight of the square root of the share of the frame labelled as objects.
    share: f32,
}

// Fitted on clips with true masks: docs/confidence.md.
const BACKGROUND_WEIGHTS: BackgroundWeights = BackgroundWeights { bias: -0.27, log_margin: 1.11, depth: 1.15 };
const OBJECT_WEIGHTS: ObjectWeights = ObjectWeights { bias: 0.48, cue: 0.72, depth: 0.82, share: -2.96 };

/// The mask of a frame with the terms of its confidence.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ConfidenceInput<'a> {
    pub(crate) mask: &'a Plane<u8>,
    /// The margin of the cut at each pixel, in units of cost; 0 where the label is not the cut's.
    pub(crate) margin: &'a Plane<f32>,
    /// Mean background evidence for each label, in units of cost.
    pub(crate) cues: &'a [f32; 256],
}

/// Computes the probability of each pixel's label.
pub(crate) fn confidence(input: ConfidenceInput) -> Plane<f32> {
    let mask = input.mask;
    let depth = border_distance(mask);
    let num_labelled = mask.data().iter().filter(|&&label| label > 0).count() as f32;
    let share = (num_labelled / mask.data().len().max(1) as f32).sqrt();
    Plane::from_fn(mask.width(), mask.height(), |x, y| {
        let (label, depth) = (mask[(x, y)], (f32::from(depth[(x, y)]) / MAX_DEPTH_PX).sqrt());
        let log_odds = if label == 0 {
            let weights = BACKGROUND_WEIGHTS;
            let log_margin = libm::logf(1.0 + input.margin[(x, y)].clamp(0.0, MAX_MARGIN));
            weights.bias + weights.log_margin * log_margin + weights.depth * depth
        } else {
            let weights = OBJECT_WEIGHTS;
            let cue = input.cues[usize::from(label)].clamp(MIN_CUE, MAX_CUE);
            weights.bias + weights.cue * cue + weights.depth * depth + weights.share * share
        };
        (1.0 / (1.0 + libm::expf(-log_odds))).max(MIN_CONFIDENCE)
    })
}

/// Computes the city-block distance of each pixel to the nearest border pixel of its label, up to [`MAX_DEPTH_PX`].
pub(super) fn border_distance(mask: &Plane<u8>) -> Plane<u8> {
    let (w, h) = (mask.width(), mask.height());
    let differs = |x: usize, y: usize| {
        let neighbours = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
        neighbours.into_iter().any(|(a, b)| a < w && b < h && mask[(a, b)] != mask[(x, y)])
    };
    let mut depth = Plane::from_fn(w, h, |x, y| if differs(x, y) { 0 } else { MAX_DEPTH_PX as u8 });
    let mut lower = |at: (usize, usize), from: (usize, usize)| depth[at] = depth[at].min(depth[from] + 1);
    for y in 0..h {
        (1..w).for_each(|x| lower((x, y), (x - 1, y)));
        (1..w).rev().for_each(|x| lower((x - 1, y), (x, y)));
    }
    for x in 0..w {
        (1..h).for_each(|y| lower((x, y), (x, y - 1)));
        (1..h).rev().for_each(|y| lower((x, y - 1), (x, y)));
    }
    depth
}

#[cfg(test)]
mod tests {
    use super::*;

    fn confidence_of(mask: &Plane<u8>, margin: f32, cue: f32) -> Plane<f32> {
        let margin = mask.map(|_| margin);
        confidence(ConfidenceInput { mask, margin: &margin, cues: &[cue; 256] })
    }

    #[test]
    fn border_distances_are_those_of_an_exhaustive_search() {
        let mut rng = crate::rng::Rng::for_stage(1, "confidence");
        for _ in 0..10 {
            let seeds: Vec<(usize, usize)> = (0..3).map(|_| (rng.below(30), rng.below(20))).collect();
            let mask = Plane::from_fn(30, 20, |x, y| {
                u8::from(seeds.iter().any(|s| s.0.abs_diff(x) < 4 && s.1.abs_diff(y) < 3))
            });
            let distance = border_distance(&mask);
            let all = || (0..600).map(|p| (p % 30, p / 30));
            for (x, y) in all() {
                let away = |&(a, b): &(usize, usize)| a.abs_diff(x) + b.abs_diff(y);
                let other = all().filter(|&at| mask[at] != mask[(x, y)]).map(|at| away(&at)).min();
                assert_eq!(usize::from(distance[(x, y)]), other.map_or(12, |steps| (steps - 1).min(12)));
            }
        }
    }

    #[test]
    fn deep_pixels_large_margins_and_cues_are_surer_and_much_labelled_is_less_sure() {
        let half = |edge: usize| Plane::from_fn(80, 40, move |x, _| u8::from(x < edge));
        let (near, far) = ((60, 20), (79, 20));
        let weak = confidence_of(&half(60), 0.2, 1.0);
        let strong = confidence_of(&half(60), 5.0, 2.5);
        assert!(strong[far] > weak[far] && weak[far] > weak[near], "background");
        assert!(strong[(20, 20)] > weak[(20, 20)] && weak[(20, 20)] > weak[(59, 20)], "object");
        assert!(confidence_of(&half(20), 0.2, 1.0)[(2, 20)] > weak[(2, 20)], "a smaller share");
        assert!(weak.data().iter().chain(strong.data()).all(|p| (0.3..1.0).contains(p)));
    }
}
