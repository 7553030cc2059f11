//! How likely the label of a pixel is right, in that the pixel is on an object or is not.
//!
//! A logistic function of what is known of the pixel, fitted on clips with true masks (docs/confidence.md). For the
//! background it is led by the margin of the cut: how much dearer another label of the pixel's superpixel would have
//! been. For objects the margin tells nothing, for what is wrong there is wrong as a whole: what the background says
//! for the object counts, and how much of the frame is held to be objects. Near borders all is less sure.

use crate::image::Plane;

/// Deeper in its label than this many pixels, a pixel is no surer.
const DEEP: f32 = 12.0;
/// Margins count up to this.
const MOST_MARGIN: f32 = 20.0;
/// What the background says for an object counts within this range.
const CUES: (f32, f32) = (-1.0, 3.0);
/// No label is held to be less likely than this: what is known of a pixel never says so much against it.
const LEAST: f32 = 0.3;

/// Of a pixel of the background: base, ln(1 + margin), depth.
const OF_BACKGROUND: [f32; 3] = [-0.27, 1.11, 1.15];
/// Of a pixel of an object: base, what the background says for it, depth, root of the share of the frame.
const OF_OBJECTS: [f32; 4] = [0.48, 0.72, 0.82, -2.96];

/// What a frame's masks were made from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Said<'a> {
    /// The frame's mask.
    pub mask: &'a Plane<u8>,
    /// The margin of the cut at each pixel, in units of cost; 0 where the label comes from elsewhere.
    pub margin: &'a Plane<f32>,
    /// What the background says for each label on average, in units of cost.
    pub cue: &'a [f32; 256],
}

/// The probability of each pixel's label.
pub(crate) fn confidence(said: Said) -> Plane<f32> {
    let mask = said.mask;
    let depth = depth(mask);
    let labelled = mask.data().iter().filter(|&&label| label > 0).count() as f32;
    let share = (labelled / mask.data().len().max(1) as f32).sqrt();
    Plane::from_fn(mask.width(), mask.height(), |x, y| {
        let (label, deep) = (mask[(x, y)], (f32::from(depth[(x, y)]) / DEEP).sqrt());
        let odds = if label == 0 {
            let [base, of_margin, of_depth] = OF_BACKGROUND;
            base + of_margin * libm::logf(1.0 + said.margin[(x, y)].clamp(0.0, MOST_MARGIN)) + of_depth * deep
        } else {
            let [base, of_cue, of_depth, of_share] = OF_OBJECTS;
            let cue = said.cue[usize::from(label)].clamp(CUES.0, CUES.1);
            base + of_cue * cue + of_depth * deep + of_share * share
        };
        (1.0 / (1.0 + libm::expf(-odds))).max(LEAST)
    })
}

/// Steps from each pixel to the nearest that has a neighbour of another label, along rows and columns, up to [`DEEP`].
pub(super) fn depth(mask: &Plane<u8>) -> Plane<u8> {
    let (w, h) = (mask.width(), mask.height());
    let differs = |x: usize, y: usize| {
        let near = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
        near.into_iter().any(|(a, b)| a < w && b < h && mask[(a, b)] != mask[(x, y)])
    };
    let mut depth = Plane::from_fn(w, h, |x, y| if differs(x, y) { 0 } else { DEEP as u8 });
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

    fn said(mask: &Plane<u8>, margin: f32, cue: f32) -> Plane<f32> {
        let margin = mask.map(|_| margin);
        confidence(Said { mask, margin: &margin, cue: &[cue; 256] })
    }

    #[test]
    fn depth_counts_steps_to_the_rim_as_a_naive_search_does() {
        let mut rng = crate::rng::Rng::for_stage(1, "confidence");
        for _ in 0..10 {
            let seeds: Vec<(usize, usize)> = (0..3).map(|_| (rng.below(30), rng.below(20))).collect();
            let mask = Plane::from_fn(30, 20, |x, y| {
                u8::from(seeds.iter().any(|s| s.0.abs_diff(x) < 4 && s.1.abs_diff(y) < 3))
            });
            let found = depth(&mask);
            let all = || (0..600).map(|p| (p % 30, p / 30));
            for (x, y) in all() {
                let away = |&(a, b): &(usize, usize)| a.abs_diff(x) + b.abs_diff(y);
                let other = all().filter(|&at| mask[at] != mask[(x, y)]).map(|at| away(&at)).min();
                assert_eq!(usize::from(found[(x, y)]), other.map_or(12, |steps| (steps - 1).min(12)));
            }
        }
    }

    #[test]
    fn deep_pixels_large_margins_and_cues_are_surer_and_much_labelled_is_less_sure() {
        let half = |edge: usize| Plane::from_fn(80, 40, move |x, _| u8::from(x < edge));
        let (near, far) = ((60, 20), (79, 20));
        let weak = said(&half(60), 0.2, 1.0);
        let strong = said(&half(60), 5.0, 2.5);
        assert!(strong[far] > weak[far] && weak[far] > weak[near], "background");
        assert!(strong[(20, 20)] > weak[(20, 20)] && weak[(20, 20)] > weak[(59, 20)], "object");
        assert!(said(&half(20), 0.2, 1.0)[(2, 20)] > weak[(2, 20)], "a smaller share");
        assert!(weak.data().iter().chain(strong.data()).all(|p| (0.3..1.0).contains(p)));
    }
}
