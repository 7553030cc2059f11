//! Trajectories as plain data.

use crate::Error;
use std::ops::Range;

/// Point trajectories as a struct of arrays.
///
/// Invariants: the points of trajectory `i` are `offset[i]..offset[i + 1]`, one for each of the consecutive frames from
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
    /// Start of each trajectory's points; `len() + 1` numbers.
    pub offset: Vec<u32>,
    /// Horizontal coordinate of each point.
    pub x: Vec<f32>,
    /// Vertical coordinate of each point.
    pub y: Vec<f32>,
    /// Local flow variation σ at each point, in pixels per frame; 0 if unknown.
    pub variation: Vec<f32>,
}

impl Trajectories {
    /// Creates an empty list for a clip of `num_frames` frames of `size` pixels.
    pub fn empty(num_frames: usize, size: (usize, usize)) -> Self {
        Self { num_frames, size, offset: vec![0], ..Self::default() }
    }

    /// Returns the number of trajectories.
    pub fn len(&self) -> usize {
        self.start_frame.len()
    }

    /// Returns true if there are no trajectories.
    pub fn is_empty(&self) -> bool {
        self.start_frame.is_empty()
    }

    /// Returns the indices of trajectory `i`'s points in `x`, `y` and `variation`.
    pub fn points(&self, i: usize) -> Range<usize> {
        self.offset[i] as usize..self.offset[i + 1] as usize
    }

    /// Returns the frames in which trajectory `i` is alive.
    #[inline]
    pub fn frames(&self, i: usize) -> Range<usize> {
        let start = self.start_frame[i] as usize;
        // On 32-bit targets an invalid start may be close to the largest number.
        start..start.saturating_add(self.points(i).len())
    }

    #[doc(hidden)]
    /// Returns the index of trajectory `i`'s point in `frame`, in which it must be alive.
    #[inline]
    pub fn point(&self, i: usize, frame: usize) -> usize {
        self.offset[i] as usize + frame - self.start_frame[i] as usize
    }

    /// Returns the position of trajectory `i` in `frame`, if it is alive there.
    pub fn at(&self, i: usize, frame: usize) -> Option<(f32, f32)> {
        let p = point_in(frame, self.start_frame[i], &self.offset[i..i + 2])?;
        Some((self.x[p], self.y[p]))
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

    /// Returns index and position of every trajectory alive in `frame`, in the order of the indices.
    pub fn alive(&self, frame: usize) -> impl Iterator<Item = (usize, f32, f32)> + '_ {
        let mut next = 0;
        std::iter::from_fn(move || {
            let (i, p) = self.next_alive(next, frame)?;
            next = i + 1;
            Some((i, self.x[p], self.y[p]))
        })
    }

    /// Returns the first trajectory from `first` on that is alive in `frame`, and the index of its point there.
    // Not inlined: it is called from many places, and most trajectories are passed over here.
    #[inline(never)]
    fn next_alive(&self, first: usize, frame: usize) -> Option<(usize, usize)> {
        let tracks = self.start_frame[first..].iter().zip(self.offset[first..].windows(2));
        (first..).zip(tracks).find_map(|(i, (&start, offsets))| Some((i, point_in(frame, start, offsets)?)))
    }

    /// Checks the invariants of the type.
    ///
    /// # Errors
    /// [`Error::Data`] naming the first breach, with the value and what is legal.
    #[doc(hidden)] // For the Python package and tests.
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

/// Returns the index of the point in `frame` of a trajectory that starts in frame `start` and has the points between two offsets;
/// `None` if it is not alive there.
#[inline]
fn point_in(frame: usize, start: u32, offsets: &[u32]) -> Option<usize> {
    // Before the start the difference wraps to a large number, so that one comparison decides.
    let index = u32::try_from(frame).ok()?.wrapping_sub(start);
    (index < offsets[1].wrapping_sub(offsets[0])).then(|| (offsets[0] + index) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn the_alive_tracks_are_those_whose_frames_contain_the_frame() {
        let mut rng = Rng::for_stage(1, "alive");
        let mut tracks = Trajectories::empty(12, (64, 48));
        for i in 0..40 {
            let (start, length) = (rng.below(10), 1 + rng.below(3));
            tracks.push(start, (0..length.min(12 - start)).map(|k| (i as f32, k as f32, 0.0)));
        }
        tracks.check().unwrap();
        for frame in 0..14 {
            let naive = (0..40).filter(|&i| tracks.frames(i).contains(&frame));
            let naive = naive.map(|i| (i, tracks.x[tracks.point(i, frame)], tracks.y[tracks.point(i, frame)]));
            assert_eq!(tracks.alive(frame).collect::<Vec<_>>(), naive.clone().collect::<Vec<_>>());
            assert!(naive.clone().all(|(i, x, y)| tracks.at(i, frame) == Some((x, y))));
        }
        // A frame that 32 bits do not hold is no other one.
        assert!([usize::MAX, u32::MAX as usize].into_iter().all(|frame| tracks.alive(frame).next().is_none()));
        #[cfg(target_pointer_width = "64")]
        assert_eq!(tracks.at(0, tracks.start_frame[0] as usize + (1 << 32)), None);
    }
}
