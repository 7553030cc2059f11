//! What the camera does over the whole clip.
//!
//! In: the dominant motion of each frame pair, the frames, and trajectories. Out: a [`Camera`], which stands
//! still, moves or goes forward, with the homographies along the clip. What a scene does besides them, since it is not flat, is a
//! `Warp`.
//!
//! 1. The motions of the pairs are chained to homographies between frames some way apart.
//! 2. Trajectories tell whether it goes forward, as in a car ([`Travel`]); then it does not stand still.
//! 3. Edges vote. An edge pixel agrees with a motion if the slope of brightness at the place where that motion puts it
//!    is nearly the same. The camera stands still if edges agree with no motion at all about as often as with the
//!    chain: a chain drifts, and before plain ground it follows whatever moves.
//!
//! Not in the paper. All in `f64` with `+ - * /`, square roots and comparisons: the same bits on every target.

mod dominant;
mod homography;
mod travel;
mod warp;

pub use dominant::DominantMotion;
pub(crate) use dominant::{Residuals, Search, dominant_motion};
pub(crate) use homography::Homography;
pub use travel::Travel;
pub(crate) use travel::{Forward, Going, Pair, Units, Ways};
pub(crate) use warp::Warp;

use crate::image::{Frame, Plane, gaussian_blur, sample_bilinear};
use crate::order;

/// Longest side of the pictures that edges are compared in, in pixels.
const SIDE: usize = 320;
/// Pairs of frames compared at most, and how far they are apart.
const PAIRS: usize = 8;
const APART: usize = 6;
/// An edge has at least this slope, in grey levels a pixel, and is among the steepest fifth.
const LEAST_SLOPE: f32 = 4.0;
const STEEPEST: f64 = 0.2;
/// Slopes agree if they differ by less than this part of the first.
const ALIKE: f32 = 0.5;
/// The camera stands still if no motion agrees this well as compared with the chain, and with this share at all.
const AS_GOOD: f64 = 0.95;
const LEAST_AGREEMENT: f64 = 0.15;

/// The camera of a clip.
#[derive(Debug, Clone, PartialEq)]
pub enum Camera {
    /// It stands still.
    Still,
    /// It moves.
    Moving(CameraPath),
    /// It surely goes forward, as in a car.
    Forward(CameraPath, Travel),
}

/// The homographies along a clip.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraPath {
    /// From each frame to the first.
    to_first: Vec<Homography>,
}

impl Camera {
    /// The camera that these dominant motions, one a frame pair, and these frames speak for. It moves where there is
    /// nothing to tell by, and where it surely goes forward.
    pub fn new(motions: &[DominantMotion], frames: &[Frame], travel: Option<Travel>) -> Self {
        let last = frames.len().min(motions.len() + 1).saturating_sub(1);
        let apart = APART.min(last);
        if apart == 0 {
            return Self::along(Vec::new(), travel);
        }
        let pairs = PAIRS.min(last / apart).max(1);
        let starts = (0..pairs).map(|k| if pairs > 1 { k * (last - apart) / (pairs - 1) } else { 0 });
        let (mut chain, mut none) = (Vec::new(), Vec::new());
        for t in starts {
            let pair = Edges::new(&frames[t], &frames[t + apart]);
            let scale = frames[t].width() as f64 / pair.first.x.width() as f64;
            let chained = motions[t..t + apart].iter().fold(Homography::IDENTITY, |way, m| m.homography().after(&way));
            chain.push(pair.share_alike(&chained.rescaled(scale)));
            none.push(pair.share_alike(&Homography::IDENTITY));
        }
        let (chain, none) = (median(chain), median(none));
        if travel.is_none() && none >= LEAST_AGREEMENT && none >= AS_GOOD * chain {
            return Self::Still;
        }
        let mut to_first = vec![Homography::IDENTITY];
        for motion in motions {
            to_first.push(to_first[to_first.len() - 1].after(&motion.homography().inverse()));
        }
        Self::along(to_first, travel)
    }

    fn along(to_first: Vec<Homography>, travel: Option<Travel>) -> Self {
        let path = CameraPath { to_first };
        match travel {
            Some(travel) => Self::Forward(path, travel),
            None => Self::Moving(path),
        }
    }

    /// One that moves the scene by so much a frame, in pixels.
    #[cfg(test)]
    pub(crate) fn panning(speed: f64, num_frames: usize) -> Self {
        let to_first = |t: usize| Homography([1.0, 0.0, -speed * t as f64, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        Self::along((0..num_frames).map(to_first).collect(), None)
    }

    /// Where the scene of frame `from` is in frame `to`.
    pub(crate) fn between(&self, from: usize, to: usize) -> Homography {
        match self {
            Self::Still => Homography::IDENTITY,
            Self::Moving(path) | Self::Forward(path, _) => path.between(from, to),
        }
    }
}

impl CameraPath {
    /// Where the scene of frame `from` is in frame `to`.
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

/// How brightness rises to the right and down, in a frame that may be reduced.
struct Slopes {
    x: Plane<f32>,
    y: Plane<f32>,
}

impl Slopes {
    fn of(frame: &Frame) -> Self {
        let step = frame.width().max(frame.height()).div_ceil(SIDE).max(1);
        let small = frame.resized((frame.width() / step).max(1), (frame.height() / step).max(1));
        // Without the noise of single pixels.
        let luma = gaussian_blur(&small.luma(), 0.7);
        let (w, h) = (luma.width(), luma.height());
        let x = |x: usize, y: usize| 0.5 * (luma[((x + 1).min(w - 1), y)] - luma[(x.saturating_sub(1), y)]);
        let y = |x: usize, y: usize| 0.5 * (luma[(x, (y + 1).min(h - 1))] - luma[(x, y.saturating_sub(1))]);
        Self { x: Plane::from_fn(w, h, x), y: Plane::from_fn(w, h, y) }
    }

    fn steepness_sq(&self, x: usize, y: usize) -> f32 {
        self.x[(x, y)] * self.x[(x, y)] + self.y[(x, y)] * self.y[(x, y)]
    }
}

/// The edges of a frame, and the slopes of another.
struct Edges {
    first: Slopes,
    second: Slopes,
    /// Where the edges are, and how steep.
    steep: Vec<(usize, usize, f32)>,
}

impl Edges {
    fn new(first: &Frame, second: &Frame) -> Self {
        let [first, second] = [first, second].map(Slopes::of);
        let (w, h) = (first.x.width(), first.x.height());
        let steep = Plane::from_fn(w, h, |x, y| first.steepness_sq(x, y));
        let bound = order::nth_smallest(steep.data(), ((1.0 - STEEPEST) * (w * h - 1) as f64) as usize);
        let bound = bound.max(LEAST_SLOPE * LEAST_SLOPE);
        let places = (0..h).flat_map(|y| (0..w).map(move |x| (x, y)));
        let steep = places.map(|(x, y)| (x, y, steep[(x, y)])).filter(|&(.., steep)| steep >= bound).collect();
        Self { first, second, steep }
    }

    /// Share of the edges that `motion` puts on the same slope in the second frame; those that it takes out of the frame
    /// do not count. 0 without edges.
    fn share_alike(&self, motion: &Homography) -> f64 {
        let Self { first, second, steep } = self;
        let (right, bottom) = ((first.x.width() - 1) as f64, (first.x.height() - 1) as f64);
        let (mut alike, mut all) = (0_u32, 0_u32);
        for &(x, y, steep) in steep {
            let (px, py) = motion.apply(x as f64, y as f64);
            if !(px >= 0.0 && py >= 0.0 && px <= right && py <= bottom) {
                continue;
            }
            let dx = sample_bilinear(&second.x, px as f32, py as f32) - first.x[(x, y)];
            let dy = sample_bilinear(&second.y, px as f32, py as f32) - first.y[(x, y)];
            all += 1;
            alike += u32::from(dx * dx + dy * dy < ALIKE * ALIKE * steep);
        }
        if all == 0 { 0.0 } else { f64::from(alike) / f64::from(all) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::FlowField;
    use crate::rng::Rng;

    /// Frame `t` of a scene of random blocks, `speed` pixels further to the right than the one before, and before it a
    /// thing of a fifth of the frame that moves on its own.
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
        dominant_motion(&flow, &Search { perspective: true, tolerance: 0.5 }, None)
    }

    #[test]
    fn a_camera_that_stands_still_is_told_from_one_that_pans() {
        for (speed, still) in [(0, true), (1, false), (3, false)] {
            let frames: Vec<Frame> = (0..14).map(|t| frame(t, speed)).collect();
            let motions = vec![motion(-(speed as f32)); 13];
            assert_eq!(Camera::new(&motions, &frames, None) == Camera::Still, still, "{speed} pixels a frame");
        }
    }

    #[test]
    fn dominant_motions_that_follow_a_mover_do_not_make_a_still_camera_move() {
        let frames: Vec<Frame> = (0..14).map(|t| frame(t, 0)).collect();
        assert_eq!(Camera::new(&vec![motion(-2.0); 13], &frames, None), Camera::Still);
    }

    #[test]
    fn where_there_is_nothing_to_tell_by_the_camera_moves() {
        let flat = Frame::from_rgb(vec![90; 3 * 20 * 10], 20, 10).unwrap();
        assert_ne!(Camera::new(&[motion(0.0)], &[flat.clone(), flat.clone()], None), Camera::Still);
        assert_ne!(Camera::new(&[], &[flat], None), Camera::Still);
        assert_ne!(Camera::new(&[], &[], None), Camera::Still);
    }
}
