//! Long clips as an iterator of windows, each a run of one session over some of the frames.
//!
//! ```text
//! frames   0 ......................... 49 50 ...                         89
//! window 0 [============================]          settles 0..45
//! window 1                         [40 ============================ 89]     settles 45..
//! ```
//!
//! A window is full when it has all its frames and one more comes. It is run; then all but its last frames are dropped,
//! and the new frame is the next. Neighbours share the masks of the frames that they have in common by halves: each is
//! settled by the window that sees more of what goes on around it. A frame that begins a new shot ends the window, which
//! then settles all it has. Where the clip's length is known, the last window is full too: it reaches further back.

use super::checkpoint::Checkpoint;
use crate::Error;
use crate::correction::Correction;
use crate::image::Frame;
use crate::session::base::{Params, Progress};
use crate::session::run::Session;
use crate::session::window::{Plan, Window};
use std::collections::VecDeque;

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
pub struct Windows<I, E = Error> {
    session: Session,
    frames: I,
    plan: Plan,
    threads: usize,
    /// Frames that are still to come, where that is known.
    left: Option<usize>,
    /// Whether frames are read ahead, enough to show in time where the clip ends.
    looks_ahead: bool,
    /// Read already, and not looked at yet.
    queue: VecDeque<Result<Frame, E>>,
    /// Read already, but in no window.
    ahead: Option<Frame>,
    /// The clip's number of the first frame that the session holds.
    first: usize,
    next: Next,
}

/// What comes before the next window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Next {
    /// More frames.
    Frames,
    /// The session goes on with this number of frames of the window that was run.
    Advance(usize),
    /// It has gone on with them; the frame that was read ahead is to be taken.
    Ahead(usize),
    /// Nothing: the clip has ended, or an error ended it.
    Nothing,
}

impl<I, E> Windows<I, E>
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
            plan: Plan::default(),
            threads: 1,
            left: None,
            looks_ahead: false,
            queue: VecDeque::new(),
            ahead: None,
            first: 0,
            next: Next::Frames,
        })
    }

    /// Windows of `window` frames, neighbours with `overlap` in common.
    ///
    /// # Errors
    /// [`Error::Param`] unless `window` is 2 to 400 and `overlap` is 1 to `window − 1`.
    pub fn with_window(self, window: usize, overlap: usize) -> Result<Self, Error> {
        Ok(Self { plan: Plan::new(window, overlap)?, ..self })
    }

    /// Says how many frames there are: the last window then is a full one.
    #[must_use]
    pub fn with_length(self, frames: usize) -> Self {
        Self { left: Some(frames), ..self }
    }

    /// Reads up to a window of frames ahead, and so finds where the clip ends without being told: for frames that come
    /// from a stream. Results are those of [`Windows::with_length`].
    #[must_use]
    pub fn with_look_ahead(self) -> Self {
        Self { looks_ahead: true, ..self }
    }

    /// Runs on this number of threads, with the same results; see [`Session::run_on`].
    #[must_use]
    pub fn with_threads(self, threads: usize) -> Self {
        Self { threads: threads.max(1), ..self }
    }

    /// The session, which holds the results of the window that came last.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Corrects the masks of the window that was run last, as [`Session::correct`]; [`Windows::rerun`] makes those that
    /// have to be made anew, and so does the next window before it begins.
    ///
    /// What is merged or split is so in this window. Those that follow find their objects anew, and give them the labels
    /// that most of their trajectories bear here after all corrections; what earlier windows settled stays.
    ///
    /// # Errors
    /// As [`Session::correct`]; nothing changes then.
    #[doc(hidden)] // For the Python package.
    pub fn correct(&mut self, correction: &Correction) -> Result<(), Error> {
        self.session.correct(correction)
    }

    /// Takes the last correction of that window back.
    ///
    /// # Errors
    /// [`Error::State`] without a correction of that window in force.
    #[doc(hidden)] // For the Python package.
    pub fn undo_correction(&mut self) -> Result<(), Error> {
        self.session.undo_correction()
    }

    /// Makes the masks after corrections, and tells `report` of each step.
    ///
    /// # Errors
    /// As [`Session::step`].
    #[doc(hidden)] // For the Python package.
    pub fn rerun(&mut self, mut report: impl FnMut(Progress)) -> Result<(), Error> {
        let always = |progress| {
            report(progress);
            true
        };
        self.rerun_while(self.threads, always).map(|_done| ())
    }

    /// The same on this number of threads, as long as `report` gives true; gives whether all is done.
    ///
    /// # Errors
    /// As [`Windows::rerun`].
    #[doc(hidden)] // For the Python package, whose callbacks may raise.
    pub fn rerun_while(&mut self, threads: usize, report: impl FnMut(Progress) -> bool) -> Result<bool, Error> {
        // Without a correction all is done, or the frames of a window are still to come.
        if self.session.num_corrections() == 0 { Ok(true) } else { self.session.run_while(threads, report) }
    }

    /// Where the clip goes on after the window that was run last; `None` before the first, and when none is to follow.
    /// The session's results of that window are gone then, and the next window comes as it would have.
    ///
    /// # Errors
    /// None after a window that was run; [`Error::State`] says that a session is not in order.
    pub fn checkpoint(&mut self) -> Result<Option<Checkpoint>, Error> {
        if let Next::Advance(kept) = self.next {
            self.drop_all_but(kept)?;
            self.next = Next::Ahead(kept);
        }
        let Next::Ahead(_) = self.next else { return Ok(None) };
        let checkpoint = |carried| Checkpoint {
            plan: self.plan.clone(),
            first: self.first,
            kept: self.session.num_frames(),
            is_ahead: self.ahead.is_some(),
            carried,
        };
        Ok(self.session.carried().map(checkpoint))
    }

    /// Goes on where `checkpoint` was made, with the same results as if there had been no interruption. The parameters
    /// and the size of the windows must be the same, and the iterator of frames must begin with frame
    /// [`Checkpoint::first_frame`] of the clip; a length that was set is still that of the whole clip.
    ///
    /// # Errors
    /// Those of the frames; [`Error::TooFewFrames`] when they end too early.
    pub fn resume(mut self, checkpoint: Checkpoint) -> Result<Self, E> {
        let needed = checkpoint.kept + usize::from(checkpoint.is_ahead);
        self.left = self.left.map(|left| left.saturating_sub(checkpoint.first));
        let mut frames = Vec::new();
        while frames.len() < needed {
            let too_few = Error::TooFewFrames { got: frames.len(), needed };
            frames.push(self.next_frame().ok_or(too_few)??);
        }
        self.ahead = if checkpoint.is_ahead { frames.pop() } else { None };
        self.next = Next::Ahead(checkpoint.kept);
        self.plan = Plan { size: self.plan.size, overlap: self.plan.overlap, ..checkpoint.plan };
        self.first = checkpoint.first;
        self.session.go_on(frames, checkpoint.carried)?;
        Ok(self)
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
        let mut stopped = Ok(());
        let mut goes_on = |progress| {
            stopped = report(progress);
            stopped.is_ok()
        };
        if !self.rerun_while(self.threads, &mut goes_on)? {
            return stopped.map(|()| None);
        }
        match self.next {
            Next::Frames => {}
            Next::Advance(kept) => {
                self.drop_all_but(kept)?;
                self.take_ahead(kept)?;
            }
            Next::Ahead(kept) => self.take_ahead(kept)?,
            Next::Nothing => return Ok(None),
        }
        self.fill()?;
        if self.session.num_frames() == 0 {
            return Ok(None);
        }
        self.session.run_while(self.threads, goes_on)?;
        stopped?;
        Ok(Some(self.window()))
    }

    /// Takes the frame that was read ahead; where it begins a new shot, the window before has seen all that is here.
    fn take_ahead(&mut self, kept: usize) -> Result<(), E> {
        if let Some(frame) = self.ahead.take() {
            self.push(frame)?;
            if self.session.holds_frame() {
                self.drop_all_but(kept)?;
            }
        }
        Ok(())
    }

    /// Drops what the window at hand alone needs.
    fn drop_all_but(&mut self, kept: usize) -> Result<(), Error> {
        let (frames, begins_shot) = (self.session.num_frames(), self.session.holds_frame());
        self.session.advance(kept)?;
        self.first += if begins_shot { frames } else { frames - kept };
        Ok(())
    }

    /// Takes frames until the window is full and one more is there, a new shot begins, or there are no more.
    fn fill(&mut self) -> Result<(), E> {
        while !self.session.holds_frame() {
            let Some(frame) = self.next_frame() else { break };
            if self.session.num_frames() == self.plan.size {
                self.ahead = Some(frame?);
                break;
            }
            self.push(frame?)?;
        }
        Ok(())
    }

    fn next_frame(&mut self) -> Option<Result<Frame, E>> {
        while self.looks_ahead && self.queue.len() <= self.plan.size {
            let Some(frame) = self.frames.next() else {
                (self.looks_ahead, self.left) = (false, Some(self.queue.len()));
                break;
            };
            self.queue.push_back(frame);
        }
        let frame = self.queue.pop_front().or_else(|| self.frames.next())?;
        self.left = self.left.map(|left| left.saturating_sub(1));
        Some(frame)
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
        let goes_on = if let Some(ahead) = &self.ahead {
            let kept = self.plan.shared(self.left);
            self.next = Next::Advance(kept);
            (!self.session.begins_shot(ahead)).then_some(kept)
        } else {
            self.next = if self.session.holds_frame() { Next::Advance(1) } else { Next::Nothing };
            None
        };
        self.plan.close(self.session.num_frames(), goes_on)
    }
}
