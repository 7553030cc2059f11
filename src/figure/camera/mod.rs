//! Motion of the camera over the whole clip.
//!
//! In: the dominant motion of each frame pair, the frames, and trajectories. Out: a [`Camera`]: how surely it stands still,
//! whether it goes forward, and the homographies along the clip. Parallax is added by a `Warp`.
//!
//! 1. The motions of the pairs are chained to homographies between frames a few apart.
//! 2. A camera whose trajectories show forward motion, as from a car ([`ForwardMotion`]), does not stand still.
//! 3. Edge pixels vote: one agrees with a motion if the image gradient at its new position is nearly the same. The camera
//!    surely stands still if the edges agree with no motion about as often as with the chain, since a chain drifts, and on
//!    plain ground it follows whatever moves. It surely moves if they agree less than nine tenths as often; what follows
//!    weighs both, so that no edge decides.
//!
//! Not in the paper. Cost: O(pixels) for each of at most eight pairs. It fails where a slow pan moves edges by less than
//! their width. All in `f64` with `+ - * /`, square roots and comparisons: the same bits on every target.

mod dominant;
mod forward;
mod warp;

pub use dominant::DominantMotion;
pub(crate) use dominant::{MotionFit, RowMotion, dominant_motion};
pub use forward::ForwardMotion;
pub(crate) use forward::{Egomotion, FramePair, FrameScale, PointMatches, RadialMotion};
pub(crate) use warp::Homography;
pub(crate) use warp::Warp;

use crate::image::{Frame, Plane, gaussian_blur, sample_bilinear};
use crate::order;

// All constants of this file are chosen by eye.

/// Longest side of the reduced frames that edges are compared in.
const MAX_SIDE_PX: usize = 320;
/// Most pairs of frames that are compared, and the distance between the frames of a pair.
const MAX_PAIRS: usize = 8;
const PAIR_SPAN_FRAMES: usize = 6;
/// Standard deviation of the blur before gradients, against the noise of single pixels.
const BLUR_SIGMA_PX: f32 = 0.7;
/// Least gradient of an edge, in grey levels a pixel.
const MIN_EDGE_GRADIENT: f32 = 4.0;
/// Largest share of the pixels that are edges: the steepest gradients.
const MAX_EDGE_SHARE: f64 = 0.2;
/// Largest difference of gradients that agree, as a part of the first.
const MAX_GRADIENT_CHANGE: f32 = 0.5;
/// Between these shares of the chain's agreement, and these agreements, of no motion a moving camera becomes a still one.
const STILL_TO_CHAIN: [f64; 2] = [0.9, 0.95];
const STILL_AGREEMENT: [f64; 2] = [0.05, 0.15];

/// Motion of the camera of a clip.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// How surely it stands still, 0 to 1.
    pub(crate) stillness: f32,
    pub(crate) path: CameraPath,
    /// Its motion if it surely goes forward, as from a car.
    pub(crate) forward: Option<ForwardMotion>,
}

/// How surely a camera stands still, 0 to 1, by the agreement of the edges with the chain of motions and with no motion.
fn stillness(chain: f64, still: f64) -> f32 {
    let ramp = |value: f64, [from, to]: [f64; 2]| ((value - from) / (to - from)).clamp(0.0, 1.0);
    ramp(still / chain.max(f64::MIN_POSITIVE), STILL_TO_CHAIN).min(ramp(still, STILL_AGREEMENT)) as f32
}

/// The homographies along a clip.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct CameraPath {
    /// From each frame to the first.
    to_first: Vec<Homography>,
}

impl Camera {
    /// Classifies the camera by the dominant motion of each frame pair, the frames, and its forward motion if it has any.
    /// Without frames, motions or edges it counts as moving.
    pub fn new(motions: &[DominantMotion], frames: &[Frame], forward: Option<ForwardMotion>) -> Self {
        let last = frames.len().min(motions.len() + 1).saturating_sub(1);
        let span = PAIR_SPAN_FRAMES.min(last);
        if span == 0 {
            return Self { stillness: 0.0, path: CameraPath::default(), forward };
        }
        let pairs = MAX_PAIRS.min(last / span).max(1);
        let starts = (0..pairs).map(|k| if pairs > 1 { k * (last - span) / (pairs - 1) } else { 0 });
        let (mut chain_agreement, mut still_agreement) = (Vec::new(), Vec::new());
        for t in starts {
            let edges = Edges::new(&frames[t], &frames[t + span]);
            let scale = frames[t].width() as f64 / edges.first.x.width() as f64;
            let chain = motions[t..t + span].iter().fold(Homography::IDENTITY, |map, m| m.homography().after(&map));
            chain_agreement.push(edges.agreement(&chain.rescaled(scale)));
            still_agreement.push(edges.agreement(&Homography::IDENTITY));
        }
        let (chain, still) = (median(chain_agreement), median(still_agreement));
        let stillness = if forward.is_some() { 0.0 } else { stillness(chain, still) };
        let mut to_first = vec![Homography::IDENTITY];
        for motion in motions {
            to_first.push(to_first[to_first.len() - 1].after(&motion.homography().inverse()));
        }
        Self { stillness, path: CameraPath { to_first }, forward }
    }

    /// The same camera, if it stood still this surely.
    #[cfg(test)]
    pub(crate) fn with_stillness(self, stillness: f32) -> Self {
        Self { stillness, ..self }
    }

    /// A camera that stands still.
    #[cfg(test)]
    pub(crate) fn still() -> Self {
        Self { stillness: 1.0, path: CameraPath::default(), forward: None }
    }

    /// A camera that moves the scene by `speed` pixels a frame to the right.
    #[cfg(test)]
    pub(crate) fn panning(speed: f64, num_frames: usize) -> Self {
        let to_first = |t: usize| Homography([1.0, 0.0, -speed * t as f64, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        Self { stillness: 0.0, path: CameraPath { to_first: (0..num_frames).map(to_first).collect() }, forward: None }
    }

    /// Returns whether it rather stands still than moves.
    pub(crate) fn is_still(&self) -> bool {
        self.stillness > 0.5
    }

    /// Returns the map of the scene from frame `from` to frame `to`.
    pub(crate) fn between(&self, from: usize, to: usize) -> Homography {
        if self.is_still() { Homography::IDENTITY } else { self.path.between(from, to) }
    }
}

impl CameraPath {
    /// Returns the map of the scene from frame `from` to frame `to`.
    pub(crate) fn between(&self, from: usize, to: usize) -> Homography {
        match (self.to_first.get(from), self.to_first.get(to)) {
            (Some(a), Some(b)) => b.inverse().after(a),
            _ => Homography::IDENTITY,
        }
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    order::sort_by_key(&mut values, |&v| order::f64_key(v));
    values[values.len() / 2]
}

/// Image gradients of a reduced frame, in grey levels a pixel.
struct Gradients {
    x: Plane<f32>,
    y: Plane<f32>,
}

impl Gradients {
    fn new(frame: &Frame) -> Self {
        let step = frame.width().max(frame.height()).div_ceil(MAX_SIDE_PX).max(1);
        let small = frame.resized((frame.width() / step).max(1), (frame.height() / step).max(1));
        let luma = gaussian_blur(&small.luma(), BLUR_SIGMA_PX);
        let (w, h) = (luma.width(), luma.height());
        let x = |x: usize, y: usize| 0.5 * (luma[((x + 1).min(w - 1), y)] - luma[(x.saturating_sub(1), y)]);
        let y = |x: usize, y: usize| 0.5 * (luma[(x, (y + 1).min(h - 1))] - luma[(x, y.saturating_sub(1))]);
        Self { x: Plane::from_fn(w, h, x), y: Plane::from_fn(w, h, y) }
    }

    fn magnitude_sq(&self, x: usize, y: usize) -> f32 {
        self.x[(x, y)] * self.x[(x, y)] + self.y[(x, y)] * self.y[(x, y)]
    }
}

/// Edges of a frame, and the gradients of another to compare them with.
struct Edges {
    first: Gradients,
    second: Gradients,
    /// Column, row and squared gradient of each edge pixel.
    pixels: Vec<(usize, usize, f32)>,
}

impl Edges {
    fn new(first: &Frame, second: &Frame) -> Self {
        let [first, second] = [first, second].map(Gradients::new);
        let (w, h) = (first.x.width(), first.x.height());
        let gradient_sq = Plane::from_fn(w, h, |x, y| first.magnitude_sq(x, y));
        let quantile = order::nth_smallest(gradient_sq.data(), ((1.0 - MAX_EDGE_SHARE) * (w * h - 1) as f64) as usize);
        let threshold = quantile.max(MIN_EDGE_GRADIENT * MIN_EDGE_GRADIENT);
        let pixels = (0..h).flat_map(|y| (0..w).map(move |x| (x, y)));
        let pixels = pixels.map(|(x, y)| (x, y, gradient_sq[(x, y)])).filter(|&(.., sq)| sq >= threshold).collect();
        Self { first, second, pixels }
    }

    /// Returns the share of the edges whose gradient is the same where `motion` maps them in the second frame. Edges that
    /// leave the frame do not count; 0 without edges.
    fn agreement(&self, motion: &Homography) -> f64 {
        let Self { first, second, pixels } = self;
        let (right, bottom) = ((first.x.width() - 1) as f64, (first.x.height() - 1) as f64);
        let (mut agreeing, mut total) = (0_u32, 0_u32);
        for &(x, y, gradient_sq) in pixels {
            let (px, py) = motion.apply(x as f64, y as f64);
            if !(px >= 0.0 && py >= 0.0 && px <= right && py <= bottom) {
                continue;
            }
            let dx = sample_bilinear(&second.x, px as f32, py as f32) - first.x[(x, y)];
            let dy = sample_bilinear(&second.y, px as f32, py as f32) - first.y[(x, y)];
            total += 1;
            agreeing += u32::from(dx * dx + dy * dy < MAX_GRADIENT_CHANGE * MAX_GRADIENT_CHANGE * gradient_sq);
        }
        if total == 0 { 0.0 } else { f64::from(agreeing) / f64::from(total) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::FlowField;
    use crate::rng::Rng;

    /// Frame `t` of a scene of random blocks, `speed` pixels further to the right than the one before, and before it a
    /// patch of a fifth of the frame that moves independently.
    fn frame(t: usize, speed: usize) -> Frame {
        let (w, h) = (96_usize, 64_usize);
        let mut rgb = Vec::new();
        for y in 0..h {
            for x in 0..w {
                let inside = (x + 2 * t).abs_diff(60) < 12 && y.abs_diff(30) < 20;
                let (u, v) = if inside { (x + 2 * t + 500, y) } else { (x + speed * t, y) };
                let grey = Rng::for_stage((u / 5 * 1000 + v / 5) as u64, "camera").below(256) as u8;
                rgb.extend([grey; 3]);
            }
        }
        Frame::from_rgb(rgb, w, h).unwrap()
    }

    fn motion(u: f32) -> DominantMotion {
        let flow = FlowField { u: Plane::filled(96, 64, u), v: Plane::filled(96, 64, 0.0) };
        dominant_motion(&flow, &MotionFit { perspective: true, tolerance: 0.5 }, None)
    }

    #[test]
    fn a_still_camera_is_told_from_a_panning_one() {
        for (speed, still) in [(0, 1.0), (1, 0.0), (3, 0.0)] {
            let frames: Vec<Frame> = (0..14).map(|t| frame(t, speed)).collect();
            let motions = vec![motion(-(speed as f32)); 13];
            assert_eq!(Camera::new(&motions, &frames, None).stillness, still, "{speed} pixels a frame");
        }
    }

    #[test]
    fn stillness_has_no_jump_at_any_agreement() {
        let by_share: Vec<f32> = (0..=100).map(|step| stillness(0.8, 0.008 * f64::from(step))).collect();
        let by_agreement: Vec<f32> =
            (0..=100).map(|step| stillness(0.003 * f64::from(step), 0.003 * f64::from(step))).collect();
        for values in [by_share, by_agreement] {
            assert!(values[0] == 0.0 && values[100] == 1.0, "{values:?}");
            assert!(values.windows(2).all(|pair| (0.0..0.25).contains(&(pair[1] - pair[0]))), "{values:?}");
        }
    }

    #[test]
    fn dominant_motions_that_follow_a_mover_do_not_make_a_still_camera_move() {
        let frames: Vec<Frame> = (0..14).map(|t| frame(t, 0)).collect();
        assert_eq!(Camera::new(&vec![motion(-2.0); 13], &frames, None).stillness, 1.0);
    }

    #[test]
    fn without_edges_or_frames_the_camera_counts_as_moving() {
        let flat = Frame::from_rgb(vec![90; 3 * 20 * 10], 20, 10).unwrap();
        assert_eq!(Camera::new(&[motion(0.0)], &[flat.clone(), flat.clone()], None).stillness, 0.0);
        assert_eq!(Camera::new(&[], &[flat], None).stillness, 0.0);
        assert_eq!(Camera::new(&[], &[], None).stillness, 0.0);
    }
}
