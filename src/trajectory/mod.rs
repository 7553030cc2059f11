//! Point trajectories: where the points of the scene go, frame after frame (section 2.1).
//!
//! In: frames and their flow, forward and backward. Out: [`Trajectories`]. The tracker is by Sundaram, Brox and
//! Keutzer (ECCV 2010); the paper uses it:
//!
//! 1. Seed points on a grid where the structure tensor's smaller eigenvalue shows structure in two directions.
//! 2. Move each point by the forward flow, sampled bilinearly.
//! 3. End it where the backward flow does not lead back (occlusion) or where the flow changes too fast (motion
//!    boundary).
//! 4. Seed again wherever no live point is near; drop tracks that are too short.
//!
//! Deviation from the published tracker: structure is measured on brightness instead of colour, and points are sampled
//! bilinearly instead of at the nearest pixel, which keeps velocities smooth.
//! Cost: O(pixels + points) per frame.

mod structure;
mod tracker;

pub use structure::structure;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use tracker::Found;
pub use tracker::Tracker;

use crate::Error;
use std::ops::Range;

crate::params! {
    /// Point trajectories.
    pub struct TrajectoryParams {
        /// Spacing of the seed grid, in pixels of the processed frames. Lower is slower and finds smaller objects.
        /// Default: the published tracker's 8.
        pub grid_step: f32 = 8.0, in 3.0..=64.0;
        /// Shortest trajectory kept, in frames (section 5: 7). Clips of fewer than 13 frames use half their length, but
        /// at least 2.
        pub min_length: u32 = 7, in 2..=1000;
        /// Spacing of the denser trajectories that the masks are made from, in pixels of the processed frames.
        pub mask_step: f32 = 4.0, in 2.0..=64.0;
        /// Shortest trajectory that the masks are made from, in frames.
        pub mask_min_length: u32 = 2, in 2..=1000, expert;
        /// A seed needs a structure of more than this fraction of the frame's mean, and ten times as much more on the
        /// border (published tracker: 0.1). Lower tracks weaker texture, which the checks below then have to judge.
        pub structure_mean: f32 = 0.03, in 0.0..=10.0, expert;
        /// A seed needs more than this structure, in grey levels squared (published tracker: 1). 0 seeds all but
        /// constant areas.
        pub structure_floor: f32 = 0.02, in 0.0..=1000.0, expert;
    }
}

impl TrajectoryParams {
    /// The same with the spacing and least length of the trajectories that the masks are made from.
    pub fn for_masks(&self) -> Self {
        Self { grid_step: self.mask_step, min_length: self.mask_min_length, ..self.clone() }
    }

    /// The shortest length kept in a clip of `num_frames` frames: half of a short clip, never below 2.
    pub(crate) fn min_length_for(&self, num_frames: usize) -> usize {
        (self.min_length as usize).min(num_frames.div_ceil(2).max(2))
    }
}

/// Point trajectories as a struct of arrays.
///
/// Law: the points of trajectory `i` are `offset[i]..offset[i + 1]`, one for each of the consecutive frames from
/// `start_frame[i]` on; `offset.len() == len() + 1`; every trajectory has at least one point and ends before
/// `num_frames`. Coordinates are finite, in pixels, pixel centres at integers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trajectories {
    /// Number of frames of the clip.
    pub num_frames: usize,
    /// Width and height of the image that the coordinates refer to, in pixels.
    pub size: (usize, usize),
    /// First frame of each trajectory.
    pub start_frame: Vec<u32>,
    /// Where the points of each trajectory begin; `len() + 1` numbers.
    pub offset: Vec<u32>,
    /// Horizontal coordinate of each point.
    pub x: Vec<f32>,
    /// Vertical coordinate of each point.
    pub y: Vec<f32>,
    /// Local flow variation at each point, in pixels per frame: how much the flow varies around it; 0 where unknown.
    pub variation: Vec<f32>,
}

impl Trajectories {
    /// None yet, for a clip of `num_frames` frames of `size` pixels.
    pub fn empty(num_frames: usize, size: (usize, usize)) -> Self {
        Self { num_frames, size, offset: vec![0], ..Self::default() }
    }

    /// Number of trajectories.
    pub fn len(&self) -> usize {
        self.start_frame.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.start_frame.is_empty()
    }

    /// Where the points of trajectory `i` lie in `x`, `y` and `variation`.
    pub fn points(&self, i: usize) -> Range<usize> {
        self.offset[i] as usize..self.offset[i + 1] as usize
    }

    /// The frames in which trajectory `i` is alive.
    pub fn frames(&self, i: usize) -> Range<usize> {
        let start = self.start_frame[i] as usize;
        // Where 32 bits are all there are, a start from outside may be too near their end.
        start..start.saturating_add(self.points(i).len())
    }

    #[doc(hidden)]
    /// Where the point of trajectory `i` in `frame` lies in `x`, `y` and `variation`; it must be alive there.
    pub fn point(&self, i: usize, frame: usize) -> usize {
        self.offset[i] as usize + frame - self.start_frame[i] as usize
    }

    /// The position of trajectory `i` in `frame`, if it is alive there.
    pub fn at(&self, i: usize, frame: usize) -> Option<(f32, f32)> {
        self.frames(i).contains(&frame).then(|| {
            let p = self.point(i, frame);
            (self.x[p], self.y[p])
        })
    }

    /// Adds a trajectory that starts in `start_frame` with `points` of `(x, y, variation)`.
    pub fn push(&mut self, start_frame: usize, points: impl IntoIterator<Item = (f32, f32, f32)>) {
        self.start_frame.push(start_frame as u32);
        for (x, y, variation) in points {
            self.x.push(x);
            self.y.push(y);
            self.variation.push(variation);
        }
        self.offset.push(self.x.len() as u32);
    }

    /// Index and position of every trajectory alive in `frame`, by index.
    pub fn alive(&self, frame: usize) -> impl Iterator<Item = (usize, f32, f32)> + '_ {
        (0..self.len()).filter_map(move |i| self.at(i, frame).map(|(x, y)| (i, x, y)))
    }

    /// Checks the law of the type.
    ///
    /// # Errors
    /// [`Error::Data`] naming the first breach, with the value and what is legal.
    pub fn check(&self) -> Result<(), Error> {
        let breach = |reason: String| Err(Error::Data { reason });
        let (n, points) = (self.len(), self.x.len());
        if self.offset.len() != n + 1
            || self.offset.first() != Some(&0)
            || self.offset.last().map(|&o| o as usize) != Some(points)
        {
            return breach(format!(
                "trajectory offsets: {} numbers ending in {} (expected {} from 0 to {points})",
                self.offset.len(),
                self.offset.last().copied().unwrap_or(0),
                n + 1
            ));
        }
        if self.y.len() != points || self.variation.len() != points {
            return breach(format!(
                "{points} x, {} y and {} variation values (expected as many of each)",
                self.y.len(),
                self.variation.len()
            ));
        }
        for i in 0..n {
            if self.offset[i] >= self.offset[i + 1] {
                return breach(format!("trajectory {i} has no points (expected at least 1)"));
            }
            if self.frames(i).end > self.num_frames {
                return breach(format!(
                    "trajectory {i} ends in frame {} (expected a frame in 0..{})",
                    self.frames(i).end - 1,
                    self.num_frames
                ));
            }
        }
        for (name, values) in [("x", &self.x), ("y", &self.y), ("variation", &self.variation)] {
            if let Some(p) = values.iter().position(|v| !v.is_finite()) {
                let value = if values[p].is_nan() { "NaN" } else { ["inf", "-inf"][usize::from(values[p] < 0.0)] };
                return breach(format!("{name}[{p}] = {value} (expected a finite number of pixels)"));
            }
        }
        Ok(())
    }
}
