//! Where the windows of a long clip begin and end, and which frames each of them settles: numbers alone, so that whoever
//! reads the frames can ask.

use crate::Error;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Frames that neighbours have in common, where a window has more than these.
const OVERLAP: usize = 10;

/// A window of a long clip that was run; its results are those of [`Windows::session`], until the next is asked for.
///
/// [`Windows::session`]: crate::Windows::session
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Window {
    /// Its number, from 0.
    pub index: usize,
    /// The number of its shot, from 0: labels mean the same object in all windows of a shot.
    pub shot: usize,
    /// The clip's number of its first frame.
    pub first_frame: usize,
    /// The frames, counted from its first, whose masks it settles: over all windows each frame of the clip once, in order.
    pub settled: Range<usize>,
}

impl Window {
    /// Frames of a window, where nobody says.
    #[doc(hidden)] // For the command line and the Python package.
    pub const FRAMES: usize = 50;

    /// Most frames of a window: memory grows with them.
    #[doc(hidden)] // For the command line and the Python package.
    pub const MOST_FRAMES: usize = 400;

    /// Frames that neighbours of `frames` frames have in common, where nobody says.
    #[doc(hidden)] // For the command line and the Python package.
    pub fn overlap(frames: usize) -> usize {
        OVERLAP.min(frames.saturating_sub(1))
    }
}

/// The windows of a clip, one after the other.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Plan {
    /// Frames of a window.
    pub(crate) size: usize,
    pub(crate) overlap: usize,
    /// The number of the window at hand.
    pub(crate) index: usize,
    pub(crate) shot: usize,
    /// The clip's number of its first frame.
    pub(crate) first: usize,
    /// Frames at its begin that an earlier one settled.
    pub(crate) settled: usize,
}

impl Default for Plan {
    fn default() -> Self {
        let (size, overlap) = (Window::FRAMES, Window::overlap(Window::FRAMES));
        Self { size, overlap, index: 0, shot: 0, first: 0, settled: 0 }
    }
}

impl Plan {
    /// Windows of `window` frames, neighbours with `overlap` in common.
    pub(crate) fn new(window: usize, overlap: usize) -> Result<Self, Error> {
        let frames = |most: usize, least: usize| format!("a whole number of frames, {least}..={most}");
        let illegal = |name: &str, value: usize, expected| {
            Err(Error::Param { name: name.to_owned(), value: value.to_string(), expected })
        };
        if !(2..=Window::MOST_FRAMES).contains(&window) {
            return illegal("window", window, frames(Window::MOST_FRAMES, 2));
        }
        if !(1..window).contains(&overlap) {
            return illegal("overlap", overlap, frames(window - 1, 1));
        }
        Ok(Self { size: window, overlap, ..Self::default() })
    }

    /// How many frames the next window shares with the one at hand, a frame more being there and `left` still to come: more
    /// when few are, since a window of few frames sees little motion.
    pub(crate) fn shared(&self, left: Option<usize>) -> usize {
        let least = left.map_or(0, |left| self.size.saturating_sub(left.saturating_add(1)));
        self.overlap.max(least).min(self.size - 1)
    }

    /// The window at hand, which was run and has `frames` frames. The next one shares `kept` of them, or begins a new shot.
    pub(crate) fn close(&mut self, frames: usize, kept: Option<usize>) -> Window {
        // Of what two windows share each settles the half in which it sees more of what goes on around.
        let after = kept.map(|kept| kept / 2);
        let left_over = kept.unwrap_or(0) - after.unwrap_or(0);
        let settled = self.settled..frames.saturating_sub(left_over);
        let window = Window { index: self.index, shot: self.shot, first_frame: self.first, settled };
        self.index += 1;
        self.shot += usize::from(kept.is_none());
        self.first += frames.saturating_sub(kept.unwrap_or(0));
        self.settled = after.unwrap_or(0);
        window
    }

    /// Goes on with the first window of another clip.
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
        let mut plan = Plan::new(window, overlap).unwrap();
        let (mut found, mut begin, mut end) = (Vec::new(), 0, 1);
        loop {
            while end < frames && end - begin < window && !cuts.contains(&end) {
                end += 1;
            }
            let kept = plan.shared(known.then(|| frames.saturating_sub(end + 1)));
            let goes_on = end < frames && !cuts.contains(&end);
            found.push((plan.close(end - begin, goes_on.then_some(kept)), end - begin));
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
        assert!(Plan::new(1, 1).is_err() && Plan::new(401, 10).is_err() && Plan::new(5, 5).is_err());
    }
}
