//! The windows of a long clip: where they begin and end, and the frames whose masks each of them settles. It computes with
//! frame numbers only, so that callers that read the frames themselves can use it too.

use crate::Error;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Frames shared by neighbouring windows that have more frames than this; chosen by eye.
const OVERLAP_FRAMES: usize = 10;

/// A window of a long clip. [`Windows::session`] has its results until the next window runs.
///
/// [`Windows::session`]: crate::Windows::session
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Window {
    /// Number of the window, from 0.
    pub index: usize,
    /// Number of its shot, from 0: a label means the same object in all windows of a shot.
    pub shot: usize,
    /// The clip's number of its first frame.
    pub first_frame: usize,
    /// The frames whose masks are final after this window, counted from its first. Over all windows these are the frames of
    /// the clip in order, each once.
    pub settled: Range<usize>,
}

impl Window {
    /// Default number of frames of a window.
    #[doc(hidden)] // For the command line and the Python package.
    pub const FRAMES: usize = 50;

    /// Largest number of frames of a window: memory grows with it.
    #[doc(hidden)] // For the command line and the Python package.
    pub const MAX_FRAMES: usize = 400;

    /// Returns the default number of frames shared by neighbouring windows of `frames` frames.
    #[doc(hidden)] // For the command line and the Python package.
    pub fn overlap(frames: usize) -> usize {
        OVERLAP_FRAMES.min(frames.saturating_sub(1))
    }
}

/// The present window of a clip, counted in frames.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct WindowPlan {
    /// Frames of a window.
    pub(crate) size: usize,
    pub(crate) overlap: usize,
    /// Number of the present window.
    pub(crate) index: usize,
    pub(crate) shot: usize,
    /// The clip's number of its first frame.
    pub(crate) first: usize,
    /// Its first frames that the previous window settled.
    pub(crate) settled: usize,
}

impl Default for WindowPlan {
    fn default() -> Self {
        let (size, overlap) = (Window::FRAMES, Window::overlap(Window::FRAMES));
        Self { size, overlap, index: 0, shot: 0, first: 0, settled: 0 }
    }
}

impl WindowPlan {
    /// Plans windows of `window` frames, neighbours with `overlap` in common.
    pub(crate) fn new(window: usize, overlap: usize) -> Result<Self, Error> {
        let check = |name: &str, value: usize, min: usize, max: usize| {
            if (min..=max).contains(&value) {
                return Ok(());
            }
            let expected = format!("a whole number of frames, {min}..={max}");
            Err(Error::Param { name: name.to_owned(), value: value.to_string(), expected })
        };
        check("window", window, 2, Window::MAX_FRAMES)?;
        check("overlap", overlap, 1, window - 1)?;
        Ok(Self { size: window, overlap, ..Self::default() })
    }

    /// Returns how many frames the next window shares with this one, when one more frame has been read and `remaining` follow
    /// it. It shares more if few remain, since a short window shows little motion.
    pub(crate) fn next_overlap(&self, remaining: Option<usize>) -> usize {
        let missing = remaining.map_or(0, |remaining| self.size.saturating_sub(remaining.saturating_add(1)));
        self.overlap.max(missing).min(self.size - 1)
    }

    /// Finishes the present window of `frames` frames. The next one shares `overlap` of them, or begins a new shot.
    pub(crate) fn finish_window(&mut self, frames: usize, overlap: Option<usize>) -> Window {
        // Each of two windows settles the half of the shared frames with more frames around it.
        let settled_next = overlap.map(|overlap| overlap / 2);
        let unsettled = overlap.unwrap_or(0) - settled_next.unwrap_or(0);
        let settled = self.settled..frames.saturating_sub(unsettled);
        let window = Window { index: self.index, shot: self.shot, first_frame: self.first, settled };
        self.index += 1;
        self.shot += usize::from(overlap.is_none());
        self.first += frames.saturating_sub(overlap.unwrap_or(0));
        self.settled = settled_next.unwrap_or(0);
        window
    }

    /// Continues with the first window of another clip.
    #[cfg(feature = "wasm")]
    pub(crate) fn begin_clip(&mut self) {
        (self.shot, self.first, self.settled) = (0, 0, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The windows of a clip whose shots begin at `cuts`.
    fn windows(frames: usize, (window, overlap): (usize, usize), cuts: &[usize], known: bool) -> Vec<(Window, usize)> {
        let mut plan = WindowPlan::new(window, overlap).unwrap();
        let (mut found, mut begin, mut end) = (Vec::new(), 0, 1);
        loop {
            while end < frames && end - begin < window && !cuts.contains(&end) {
                end += 1;
            }
            let kept = plan.next_overlap(known.then(|| frames.saturating_sub(end + 1)));
            let goes_on = end < frames && !cuts.contains(&end);
            found.push((plan.finish_window(end - begin, goes_on.then_some(kept)), end - begin));
            if end == frames {
                return found;
            }
            begin = if goes_on { end - kept } else { end };
            end += 1;
        }
    }

    #[test]
    fn each_frame_is_settled_once_in_order_and_in_its_shot() {
        for window in [2, 3, 5, 8] {
            for (overlap, frames) in (1..window).flat_map(|overlap| (1..=20).map(move |frames| (overlap, frames))) {
                for cuts in [&[][..], &[1], &[window], &[window + 1], &[3, 4], &[window, window + 1, window + 2]] {
                    let mut next = 0;
                    for (k, (part, size)) in
                        windows(frames, (window, overlap), cuts, frames % 2 == 0).into_iter().enumerate()
                    {
                        assert!(part.index == k && size <= window && part.settled.end <= size);
                        for t in part.settled {
                            assert_eq!(part.first_frame + t, next);
                            assert_eq!(part.shot, cuts.iter().filter(|&&cut| cut <= next).count());
                            next += 1;
                        }
                    }
                    assert_eq!(next, frames, "{window} {overlap} {cuts:?}");
                }
            }
        }
    }

    #[test]
    fn the_last_window_is_full_where_the_length_is_known() {
        let places = |frames, known| {
            let of = |(part, size): (Window, usize)| (part.first_frame, size, part.settled);
            windows(frames, (50, 10), &[], known).into_iter().map(of).collect::<Vec<_>>()
        };
        assert_eq!(places(50, false), [(0, 50, 0..50)]);
        assert_eq!(places(51, false), [(0, 50, 0..45), (40, 11, 5..11)]);
        assert_eq!(places(90, false), [(0, 50, 0..45), (40, 50, 5..50)]);
        assert_eq!(places(51, true), [(0, 50, 0..25), (1, 50, 24..50)]);
        assert_eq!(places(90, true), [(0, 50, 0..45), (40, 50, 5..50)]);
        assert_eq!(places(97, true), [(0, 50, 0..45), (40, 50, 5..28), (47, 50, 21..50)]);
    }

    #[test]
    fn a_small_window_has_a_small_overlap() {
        assert_eq!([0, 2, 11, 400].map(Window::overlap), [0, 1, 10, 10]);
        assert!(WindowPlan::new(1, 1).is_err() && WindowPlan::new(401, 10).is_err() && WindowPlan::new(5, 5).is_err());
    }
}
