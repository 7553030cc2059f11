//! Long clips as an iterator of windows, each a run of one session over some of the frames.
//!
//! ```text
//! frames   0 ......................... 49 50 ...                         89
//! window 0 [============================]          settles 0..45
//! window 1                         [40 ============================ 89]     settles 45..
//! ```
//!
//! A window is full when it has so many frames and one more comes. It is run; then all but its last frames are dropped,
//! and the new frame is the next. Neighbours share the masks of the frames that they have in common by halves: each is
//! settled by the window that sees more of what goes on around it. A frame that begins a new shot ends the window, which
//! then settles all it has. Where the clip's length is known, the last window is full too: it reaches further back.

use super::params::Params;
use super::session::Session;
use super::stage::Progress;
use crate::Error;
use crate::image::Frame;
use std::ops::Range;

/// Most frames of a window: memory grows with them.
const MAX_WINDOW: usize = 400;

/// Frames that neighbours have in common, where a window has more than these.
const OVERLAP: usize = 10;

/// Frames of a window.
const WINDOW: usize = 50;

/// A window of a long clip that was run; its results are those of [`Windows::session`], until the next is asked for.
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

/// A clip of any length, window by window, in the memory of one.
///
/// ```
/// use tracecut::{Error, Params, Windows, synth::Scene};
///
/// let scene = Scene::sample(160, 90, 20, 0);
/// let frames = (0..20).map(|t| Ok::<_, Error>(scene.frame(t)));
/// let mut windows = Windows::new(Params::default(), frames)?.with_window(12, 4)?;
/// let mut masks = Vec::new();
/// while let Some(window) = windows.next_window(|_progress| ()) {
///     for t in window?.settled {
///         masks.push(windows.session().labels(t)?);
///     }
/// }
/// assert_eq!(masks.len(), 20);
/// # Ok::<(), Error>(())
/// ```
#[derive(Debug)]
pub struct Windows<I> {
    session: Session,
    frames: I,
    window: usize,
    overlap: usize,
    threads: usize,
    /// Frames that are still to come, where that is known.
    left: Option<usize>,
    /// Read already, but in no window.
    ahead: Option<Frame>,
    index: usize,
    shot: usize,
    first: usize,
    /// Frames at the begin of the window that an earlier one settled.
    settled: usize,
    next: Next,
}

/// What comes before the next window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Next {
    /// More frames.
    Frames,
    /// The session goes on with so many frames of the window that was run.
    Advance(usize),
    /// Nothing: the clip, or an error, has ended it.
    Nothing,
}

impl<I, E> Windows<I>
where
    I: Iterator<Item = Result<Frame, E>>,
    E: From<Error>,
{
    /// Windows of 50 frames, neighbours with 10 in common, over `frames`, all of one size.
    ///
    /// # Errors
    /// [`Error::Param`] when a parameter is out of range.
    pub fn new(params: Params, frames: I) -> Result<Self, Error> {
        Ok(Self {
            session: Session::new(params)?,
            frames,
            window: WINDOW,
            overlap: OVERLAP,
            threads: 1,
            left: None,
            ahead: None,
            index: 0,
            shot: 0,
            first: 0,
            settled: 0,
            next: Next::Frames,
        })
    }

    /// Windows of `window` frames, neighbours with `overlap` in common.
    ///
    /// # Errors
    /// [`Error::Param`] unless `window` is 2 to 400 and `overlap` is 1 to `window − 1`.
    pub fn with_window(self, window: usize, overlap: usize) -> Result<Self, Error> {
        let frames = |most: usize, least: usize| format!("a whole number of frames, {least}..={most}");
        let illegal = |name: &str, value: usize, expected| {
            Err(Error::Param { name: name.to_owned(), value: value.to_string(), expected })
        };
        if !(2..=MAX_WINDOW).contains(&window) {
            return illegal("window", window, frames(MAX_WINDOW, 2));
        }
        if !(1..window).contains(&overlap) {
            return illegal("overlap", overlap, frames(window - 1, 1));
        }
        Ok(Self { window, overlap, ..self })
    }

    /// Says how many frames there are: the last window then is a full one.
    #[must_use]
    pub fn with_length(self, frames: usize) -> Self {
        Self { left: Some(frames), ..self }
    }

    /// Runs on so many threads, with the same results; see [`Session::run_on`].
    #[must_use]
    pub fn with_threads(self, threads: usize) -> Self {
        Self { threads: threads.max(1), ..self }
    }

    /// The session, which holds the results of the window that came last.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Runs the next window, and tells `report` of each step; `None` after the last, and after an error.
    ///
    /// # Errors
    /// Those of the frames; [`Error::FrameSizeChanged`] with the clip's number of the frame; and as [`Session::step`].
    pub fn next_window(&mut self, mut report: impl FnMut(Progress)) -> Option<Result<Window, E>> {
        let always = |progress| {
            report(progress);
            Ok(())
        };
        self.try_next_window(always)
    }

    /// The same, and an error of `report` ends the run and the clip.
    ///
    /// # Errors
    /// Those of `report`, and as [`Windows::next_window`].
    #[doc(hidden)] // For the Python package, whose callbacks may raise.
    pub fn try_next_window(&mut self, report: impl FnMut(Progress) -> Result<(), E>) -> Option<Result<Window, E>> {
        let window = self.run_next(report).transpose();
        if !matches!(window, Some(Ok(_))) {
            self.next = Next::Nothing;
        }
        window
    }

    fn run_next(&mut self, mut report: impl FnMut(Progress) -> Result<(), E>) -> Result<Option<Window>, E> {
        match self.next {
            Next::Frames => {}
            Next::Advance(kept) => self.advance(kept)?,
            Next::Nothing => return Ok(None),
        }
        self.fill()?;
        if self.session.num_frames() == self.settled && !self.session.holds_frame() {
            return Ok(None);
        }
        let mut stopped = Ok(());
        let goes_on = |progress| {
            stopped = report(progress);
            stopped.is_ok()
        };
        self.session.run_while(self.threads, goes_on)?;
        stopped?;
        let window = self.window();
        self.index += 1;
        Ok(Some(window))
    }

    /// Drops what the window at hand alone needs, and takes the frame that was read ahead.
    fn advance(&mut self, kept: usize) -> Result<(), E> {
        self.drop_all_but(kept)?;
        if let Some(frame) = self.ahead.take() {
            self.push(frame)?;
            if self.session.holds_frame() {
                self.drop_all_but(kept)?;
            }
        }
        Ok(())
    }

    fn drop_all_but(&mut self, kept: usize) -> Result<(), E> {
        let (frames, begins_shot) = (self.session.num_frames(), self.session.holds_frame());
        self.session.advance(kept)?;
        self.shot += usize::from(begins_shot);
        self.first += if begins_shot { frames } else { frames - kept };
        if begins_shot {
            self.settled = 0;
        }
        Ok(())
    }

    /// Takes frames until the window is full and one more is there, a new shot begins, or there are no more.
    fn fill(&mut self) -> Result<(), E> {
        while !self.session.holds_frame() {
            let Some(frame) = self.frames.next() else { break };
            self.left = self.left.map(|left| left.saturating_sub(1));
            if self.session.num_frames() == self.window {
                self.ahead = Some(frame?);
                break;
            }
            self.push(frame?)?;
        }
        Ok(())
    }

    fn push(&mut self, frame: Frame) -> Result<(), E> {
        match self.session.push_in_shot(frame) {
            Ok(_) => Ok(()),
            Err(Error::FrameSizeChanged { index, expected, actual }) => {
                Err(Error::FrameSizeChanged { index: self.first + index, expected, actual }.into())
            }
            Err(error) => Err(error.into()),
        }
    }

    /// The window that was run, and what comes after it.
    fn window(&mut self) -> Window {
        let frames = self.session.num_frames();
        let (mut settled, mut after) = (self.settled..frames, frames);
        self.next = Next::Frames;
        if let Some(ahead) = &self.ahead {
            let kept = self.shared();
            self.next = Next::Advance(kept);
            if !self.session.begins_shot(ahead) {
                after = kept / 2;
                settled.end -= kept - after;
            }
        } else if self.session.holds_frame() {
            self.next = Next::Advance(1);
        }
        self.settled = after;
        Window { index: self.index, shot: self.shot, first_frame: self.first, settled }
    }

    /// How many frames the next window shares with this one: more when few are left, since a window of few frames sees
    /// little motion.
    fn shared(&self) -> usize {
        let least = self.left.map_or(0, |left| self.window.saturating_sub(1 + left));
        self.overlap.max(least).min(self.window - 1)
    }
}
