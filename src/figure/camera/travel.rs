//! A camera that goes forward over the whole clip: pairs of frames some way apart, and how it goes in each.

use super::forward::{Forward, Going, Step, Units};
use crate::trajectory::Trajectories;

/// Frames that points are compared across, and from one such pair of frames to the next.
const SPAN: usize = 6;
const STRIDE: usize = 3;
/// Share of the pairs in which the camera must surely go forward.
const LEAST_SURE: f64 = 0.6;

/// How the camera goes from a frame to another.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Pair {
    /// The first of the two frames.
    pub(crate) start: usize,
    /// Each trajectory that is in both, and its step.
    pub(crate) steps: Vec<(usize, Step)>,
    pub(crate) forward: Forward,
}

/// How the camera goes forward: in pairs of frames over the whole clip.
#[derive(Debug, Clone, PartialEq)]
pub struct Travel {
    pub(crate) units: Units,
    pub(crate) pairs: Vec<Pair>,
}

impl Travel {
    /// Frames from the first to the second of a pair.
    pub(crate) const SPAN: usize = SPAN;

    /// What the trajectories tell. `None` unless the camera surely goes forward in most pairs.
    pub fn of(tracks: &Trajectories) -> Option<Self> {
        Self::by(tracks, &mut |_, ways| ways.forward())
    }

    /// The same, where it is told elsewhere how the camera goes in each pair: the motion, and whether it is sure.
    pub(crate) fn by(
        tracks: &Trajectories,
        forward: &mut dyn FnMut(usize, Ways) -> Option<(Forward, bool)>,
    ) -> Option<Self> {
        let units = Units::new(tracks.size);
        let (mut pairs, mut sure) = (Vec::new(), 0);
        let is_enough = |sure: usize, pairs: usize| sure as f64 >= LEAST_SURE * pairs as f64;
        let num_pairs = Self::num_pairs(tracks);
        for k in 0..num_pairs {
            // Not even if it were sure in all that are left.
            if !is_enough(sure + num_pairs - k, pairs.len() + num_pairs - k) {
                return None;
            }
            let start = k * STRIDE;
            let Some((forward, is_sure)) = forward(k, Ways::new(tracks, k)) else { continue };
            sure += usize::from(is_sure);
            let steps = common(tracks, start).map(|(i, from, to)| (i, units.step(from, to))).collect();
            pairs.push(Pair { start, steps, forward });
        }
        (sure > 0 && is_enough(sure, pairs.len())).then_some(Self { units, pairs })
    }

    /// How many pairs of frames are compared.
    pub(crate) fn num_pairs(tracks: &Trajectories) -> usize {
        tracks.num_frames.saturating_sub(SPAN).div_ceil(STRIDE)
    }
}

/// The trajectories that are in the first frame of a pair and in the second, and where.
fn common(tracks: &Trajectories, start: usize) -> impl Iterator<Item = (usize, (f32, f32), (f32, f32))> + '_ {
    tracks.alive(start).filter_map(move |(i, x, y)| Some((i, (x, y), tracks.at(i, start + SPAN)?)))
}

/// The ways of all points in a pair of frames, which tell how the camera goes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Ways {
    /// Of the frames, in pixels.
    pub(crate) size: (usize, usize),
    /// From and to.
    pub(crate) points: Vec<[f32; 4]>,
}

impl Ways {
    /// In the `k`th pair.
    pub(crate) fn new(tracks: &Trajectories, k: usize) -> Self {
        let points = common(tracks, k * STRIDE).map(|(_, from, to)| [from.0, from.1, to.0, to.1]).collect();
        Self { size: tracks.size, points }
    }

    /// How the camera goes, and whether it surely goes forward.
    pub(crate) fn forward(&self) -> Option<(Forward, bool)> {
        let units = Units::new(self.size);
        let steps: Vec<Step> = self.points.iter().map(|&[x, y, u, v]| units.step((x, y), (u, v))).collect();
        let forward = Forward::fit(&steps, units)?;
        Some((forward, forward.is_sure(&steps, units)))
    }
}

impl Pair {
    /// How each of them goes.
    pub(crate) fn goings(&self) -> Vec<Going> {
        self.steps.iter().map(|(_, step)| self.forward.going(step)).collect()
    }

    /// How far below the focus of expansion the `k`th step begins.
    pub(crate) fn below(&self, k: usize) -> f64 {
        self.steps[k].1.y - self.forward.focus.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    /// Points of random depth before a camera that goes forward by `speed`, and to the right by `aside`, each frame.
    fn tracks(speed: f64, aside: f64) -> Trajectories {
        let mut rng = Rng::for_stage(7, "travel");
        let mut tracks = Trajectories::empty(20, (480, 270));
        for _ in 0..400 {
            let (depth, x, y) = (rng.range(6.0, 40.0), rng.range(-0.8, 0.8), rng.range(-0.45, 0.45));
            let at = |t: f64| {
                let z = depth - speed * t;
                (240.0 + 300.0 * (x * depth - aside * t) / z, 135.0 + 300.0 * y * depth / z)
            };
            let points =
                (0..20).map(|t| at(f64::from(t))).take_while(|&(x, y)| x > 0.0 && x < 480.0 && y > 0.0 && y < 270.0);
            tracks.push(0, points.map(|(x, y)| (x as f32, y as f32, 0.0)));
        }
        tracks
    }

    #[test]
    fn only_a_camera_that_goes_forward_travels() {
        let found = Travel::of(&tracks(0.2, 0.0)).unwrap();
        assert!(found.pairs.iter().all(|pair| (pair.forward.focus.0 - 240.0).abs() < 5.0), "{found:?}");
        assert_eq!(Travel::of(&tracks(0.0, 0.2)), None);
        assert_eq!(Travel::of(&tracks(0.0, 0.0)), None);
        assert_eq!(Travel::of(&Trajectories::empty(20, (480, 270))), None);
    }
}
