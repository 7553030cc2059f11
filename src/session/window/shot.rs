//! Detection of cuts between shots.
//!
//! Two frames of one shot show the same things, displaced; two frames on either side of a cut do not. Both frames are reduced,
//! the flow between them is computed in both directions, and a pixel is matched if the flow passes the forward-backward check
//! and leads to a similar colour. A cut is where most of the picture is unmatched.
//!
//! In: two frames of one size. Out: the unmatched share of the first frame, `0.0..=1.0`.
//! **Limits.** A cut between two views of the same scene from one place is not detected; a flash of light counts as two cuts.

use crate::flow::{FlowField, FlowParams, FlowPyramid, FlowScratch, flow_between_with};
use crate::image::{Frame, Plane, sample_bilinear};

crate::params! {
    /// Cuts between shots.
    pub struct ShotParams {
        /// A clip that is processed window by window begins a new shot where more than this share of the picture is
        /// unmatched in the next frame. 1 never begins one. Neighbouring frames of 20 of our 21 sequences stay below
        /// 0.2, frames of a fast swinging camera reach 0.69; of 1384 pairs of frames from different sequences all
        /// but 14 are above 0.97.
        pub max_unmatched: f32 = 0.72, in 0.0..=1.0;
    }
}

// Chosen by eye together; the threshold on their result, `shot.maxUnmatched`, is measured.
/// Long side of the reduced frames, in pixels.
const THUMBNAIL_SIDE_PX: usize = 128;
/// Largest squared error of the forward-backward check, in pixels of the reduced frame.
const MAX_FORWARD_BACKWARD_ERROR_SQ_PX: f32 = 1.0;
/// Largest difference of a colour channel between matched pixels without contrast, in grey levels.
const MAX_COLOUR_DIFFERENCE: f32 = 8.0;
/// Growth of this bound with the contrast of the pixel.
const COLOUR_DIFFERENCE_PER_CONTRAST: f32 = 0.5;
/// Weight of a pixel without contrast. Plain areas (skies, walls, roads) look alike in any two shots, so that pixels are
/// weighted by their contrast.
const PLAIN_WEIGHT: f32 = 0.1;
/// Contrast above this counts as this much, in grey levels.
const MAX_CONTRAST: f32 = 16.0;

/// A reduced frame, as [`unmatched_share`] compares it.
#[derive(Debug, Clone)]
pub(crate) struct Thumbnail {
    pyramid: FlowPyramid,
    channels: [Plane<f32>; 3],
    /// The largest difference of each pixel to its neighbours, in grey levels, up to a bound.
    contrast: Plane<f32>,
}

impl Thumbnail {
    /// Reduces a frame of any size.
    pub(crate) fn new(frame: &Frame) -> Self {
        let long = frame.width().max(frame.height());
        let reduced =
            |side: usize| if long > THUMBNAIL_SIDE_PX { (side * THUMBNAIL_SIDE_PX).div_ceil(long) } else { side };
        let small = frame.resized(reduced(frame.width()), reduced(frame.height()));
        let channels = [0, 1, 2].map(|c| small.channel(c));
        let luma = small.luma();
        Self { pyramid: FlowPyramid::from_luma(&luma), channels, contrast: contrast(&luma) }
    }
}

/// Returns the largest difference of each pixel to its four neighbours.
fn contrast(luma: &Plane<f32>) -> Plane<f32> {
    let (w, h) = (luma.width(), luma.height());
    Plane::from_fn(w, h, |x, y| {
        let value = luma[(x, y)];
        let sides =
            [(x.saturating_sub(1), y), ((x + 1).min(w - 1), y), (x, y.saturating_sub(1)), (x, (y + 1).min(h - 1))];
        sides.into_iter().map(|side| (luma[side] - value).abs()).fold(0.0, f32::max).min(MAX_CONTRAST)
    })
}

/// Returns the share of `previous` that is unmatched in `next`, among the pixels that flow keeps inside the frame; 1 if there
/// are none. Both are of frames of one size.
pub(crate) fn unmatched_share(previous: &Thumbnail, next: &Thumbnail) -> f32 {
    let (params, mut scratch) = (FlowParams::default(), FlowScratch::default());
    let forward = flow_between_with(&previous.pyramid, &next.pyramid, &params, &mut scratch);
    let backward = flow_between_with(&next.pyramid, &previous.pyramid, &params, &mut scratch);
    let (mut matched, mut inside) = (0.0, 0.0);
    for y in 0..forward.u.height() {
        for x in 0..forward.u.width() {
            if let Some(is_match) = is_matched([previous, next], [&forward, &backward], x, y) {
                let weight = f64::from(PLAIN_WEIGHT + previous.contrast[(x, y)]);
                inside += weight;
                matched += if is_match { weight } else { 0.0 };
            }
        }
    }
    if inside == 0.0 { 1.0 } else { (1.0 - matched / inside) as f32 }
}

/// Returns whether a pixel is matched in the next frame; `None` if the flow leads out of the frame.
fn is_matched(
    [previous, next]: [&Thumbnail; 2],
    [forward, backward]: [&FlowField; 2],
    x: usize,
    y: usize,
) -> Option<bool> {
    let (u, v) = (forward.u[(x, y)], forward.v[(x, y)]);
    let (nx, ny) = (x as f32 + u, y as f32 + v);
    let (right, bottom) = ((forward.u.width() - 1) as f32, (forward.u.height() - 1) as f32);
    if !(0.0..=right).contains(&nx) || !(0.0..=bottom).contains(&ny) {
        return None;
    }
    let (bu, bv) = (sample_bilinear(&backward.u, nx, ny), sample_bilinear(&backward.v, nx, ny));
    let returns = (u + bu).powi(2) + (v + bv).powi(2) <= MAX_FORWARD_BACKWARD_ERROR_SQ_PX;
    let bound = MAX_COLOUR_DIFFERENCE + COLOUR_DIFFERENCE_PER_CONTRAST * previous.contrast[(x, y)];
    let is_similar = |(a, b): (&Plane<f32>, &Plane<f32>)| (sample_bilinear(b, nx, ny) - a[(x, y)]).abs() <= bound;
    Some(returns && previous.channels.iter().zip(&next.channels).all(is_similar))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::Scene;

    fn share(a: &Frame, b: &Frame) -> f32 {
        unmatched_share(&Thumbnail::new(a), &Thumbnail::new(b))
    }

    fn grey(width: usize, height: usize, value: u8) -> Frame {
        Frame::from_rgb(vec![value; 3 * width * height], width, height).unwrap()
    }

    #[test]
    fn neighbouring_frames_find_each_other_and_other_scenes_do_not() {
        let (scene, other) = (Scene::sample((240, 135), 12, 0), Scene::sample((240, 135), 12, 7));
        let bound = ShotParams::default().max_unmatched;
        for t in 1..12 {
            let within = share(&scene.frame(t - 1), &scene.frame(t));
            assert!(within < 0.3, "frame {t}: {within}");
        }
        let across = share(&scene.frame(5), &other.frame(0));
        assert!(across > bound, "{across}");
    }

    #[test]
    fn plain_frames_differ_by_their_colour_alone() {
        for (w, h) in [(1, 1), (300, 2), (64, 48)] {
            assert_eq!(share(&grey(w, h, 90), &grey(w, h, 95)), 0.0, "{w}x{h}");
            assert_eq!(share(&grey(w, h, 90), &grey(w, h, 200)), 1.0, "{w}x{h}");
        }
    }
}
