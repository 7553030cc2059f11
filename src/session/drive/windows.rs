//! Long clips as an iterator of windows: runs of one session over some of the frames each.
//!
//! ```text
//! frames   0 ......................... 49 50 ...                         89
//! window 0 [============================]          settles 0..45
//! window 1                         [40 ============================ 89]     settles 45..
//! ```
//!
//! A window runs when it has all its frames and one more has been read. Then all but its last frames are dropped, and the new
//! frame is added. Of the frames shared by two windows, each window settles the half with more frames around it. A frame that
//! begins a new shot ends the window, which then settles all of its frames. The last window begins earlier, so that it is
//! full too: up to a window of frames is read ahead to find the end of the clip, unless the iterator knows its length.

use super::checkpoint::Checkpoint;
use crate::Error;
use crate::correction::Correction;
use crate::image::Frame;
use crate::session::base::{Params, Progress};
use crate::session::run::Session;
use crate::session::window::{Window, WindowPlan};
use std::collections::VecDeque;

/// A clip of any length, processed window by window in the memory of one window.
///
/// ```
/// use tracecut::{Error, Params, Windows, synth::Scene};
///
/// let scene = Scene::sample((160, 90), 20, 0);
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
    plan: WindowPlan,
    threads: usize,
    /// Number of frames not yet read, if known.
    remaining: Option<usize>,
    /// True if a window of frames is read ahead, to find the end of the clip in time.
    reads_ahead: bool,
    /// Frames read ahead.
    queue: VecDeque<Result<Frame, E>>,
    /// The frame after the present window.
    lookahead: Option<Frame>,
    /// The clip's number of the session's first frame.
    first: usize,
    next: NextAction,
}

/// The first action of the next window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum NextAction {
    /// Read frames.
    Read,
    /// Advance the session to a window that shares this number of frames.
    Advance(usize),
    /// Push the lookahead frame to a session that has been advanced.
    PushLookahead(usize),
    /// None: the clip has ended, or an error ended it.
    End,
}

impl<I, E> Windows<I, E>
where
    I: Iterator<Item = Result<Frame, E>>,
    E: From<Error>,
{
    /// Processes `frames`, all of one size, in windows of 50 frames that share 10 with their neighbours.
    ///
    /// The last window is as long as the others. To find the end of the clip, up to a window of frames is read ahead, unless
    /// the iterator's [`size_hint`](Iterator::size_hint) is exact.
    ///
    /// # Errors
    /// [`Error::Param`] if a parameter is out of range.
    pub fn new(params: Params, frames: I) -> Result<Self, Error> {
        let (least, most) = frames.size_hint();
        let remaining = most.filter(|&most| most == least);
        Ok(Self {
            session: Session::new(params)?,
            frames,
            plan: WindowPlan::default(),
            threads: 1,
            remaining,
            reads_ahead: remaining.is_none(),
            queue: VecDeque::new(),
            lookahead: None,
            first: 0,
            next: NextAction::Read,
        })
    }

    /// Sets the number of frames of a window, and how many it shares with its neighbours.
    ///
    /// # Errors
    /// [`Error::Param`] unless `window` is 2 to 400 and `overlap` is 1 to `window − 1`.
    pub fn with_window(self, window: usize, overlap: usize) -> Result<Self, Error> {
        Ok(Self { plan: WindowPlan::new(window, overlap)?, ..self })
    }

    /// Sets the number of threads, which does not change results; see [`Session::run_on`].
    #[must_use]
    pub fn with_threads(self, threads: usize) -> Self {
        Self { threads: threads.max(1), ..self }
    }

    /// Returns the session, which holds the results of the last window.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Corrects the masks of the last window, as [`Session::correct`]. [`Windows::rerun`] computes the masks that change;
    /// otherwise the next window does so first.
    ///
    /// A correction applies to this window. Later windows select their objects again and give them the labels that most of
    /// their trajectories have here after all corrections; earlier windows do not change.
    ///
    /// # Errors
    /// As [`Session::correct`]; nothing changes then.
    #[doc(hidden)] // For the Python package.
    pub fn correct(&mut self, correction: &Correction) -> Result<(), Error> {
        self.session.correct(correction)
    }

    /// Undoes the last correction of the last window.
    ///
    /// # Errors
    /// [`Error::State`] if there is none.
    #[doc(hidden)] // For the Python package.
    pub fn undo_correction(&mut self) -> Result<(), Error> {
        self.session.undo_correction()
    }

    /// Computes the masks after corrections, and calls `report` after each step.
    ///
    /// # Errors
    /// As [`Session::step`].
    #[doc(hidden)] // For the Python package.
    pub fn rerun(&mut self, mut report: impl FnMut(Progress)) -> Result<(), Error> {
        let always = |progress| {
            report(progress);
            true
        };
        self.rerun_while(self.threads, always).map(|_is_done| ())
    }

    /// Computes the masks on a number of threads as long as `report` returns true. Returns whether all are done.
    ///
    /// # Errors
    /// As [`Windows::rerun`].
    #[doc(hidden)] // For the Python package, whose callbacks may raise.
    pub fn rerun_while(&mut self, threads: usize, report: impl FnMut(Progress) -> bool) -> Result<bool, Error> {
        // Without a correction the run is done, or frames of the window are missing.
        if self.session.num_corrections() == 0 { Ok(true) } else { self.session.run_while(threads, report) }
    }

    /// Returns the state after the last window; `None` before the first window and after the end of the clip. This drops the
    /// session's results of that window; the next window is not affected.
    ///
    /// # Errors
    /// [`Error::State`] if the session has not finished a window.
    pub fn checkpoint(&mut self) -> Result<Option<Checkpoint>, Error> {
        if let NextAction::Advance(overlap) = self.next {
            self.advance(overlap)?;
            self.next = NextAction::PushLookahead(overlap);
        }
        let NextAction::PushLookahead(_) = self.next else { return Ok(None) };
        let checkpoint = |handover| Checkpoint {
            plan: self.plan.clone(),
            first: self.first,
            overlap: self.session.num_frames(),
            has_lookahead: self.lookahead.is_some(),
            handover,
        };
        Ok(self.session.handover().map(checkpoint))
    }

    /// Resumes a clip from a checkpoint, with the same results as without an interruption. The parameters and the size of the
    /// windows must be the same, and the iterator of frames must begin with frame [`Checkpoint::first_frame`] of the clip.
    ///
    /// # Errors
    /// Those of the frames; [`Error::TooFewFrames`] if they end too early.
    pub fn resume(mut self, checkpoint: Checkpoint) -> Result<Self, E> {
        let needed = checkpoint.overlap + usize::from(checkpoint.has_lookahead);
        let mut frames = Vec::new();
        while frames.len() < needed {
            let too_few = Error::TooFewFrames { got: frames.len(), needed };
            frames.push(self.next_frame().ok_or(too_few)??);
        }
        self.lookahead = if checkpoint.has_lookahead { frames.pop() } else { None };
        self.next = NextAction::PushLookahead(checkpoint.overlap);
        self.plan = WindowPlan { size: self.plan.size, overlap: self.plan.overlap, ..checkpoint.plan };
        self.first = checkpoint.first;
        self.session.resume(frames, checkpoint.handover)?;
        Ok(self)
    }

    /// Runs the next window and calls `report` after each step; `None` after the last window, and after an error.
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

    /// Runs the next window as [`Windows::next_window`]; an error of `report` ends the clip.
    ///
    /// # Errors
    /// Those of `report`, and as [`Windows::next_window`].
    #[doc(hidden)] // For the Python package, whose callbacks may raise.
    pub fn try_next_window(&mut self, report: impl FnMut(Progress) -> Result<(), E>) -> Option<Result<Window, E>> {
        let window = self.run_next(report).transpose();
        if !matches!(window, Some(Ok(_))) {
            self.next = NextAction::End;
        }
        window
    }

    fn run_next(&mut self, mut report: impl FnMut(Progress) -> Result<(), E>) -> Result<Option<Window>, E> {
        let mut stopped = Ok(());
        let mut try_report = |progress| {
            stopped = report(progress);
            stopped.is_ok()
        };
        if !self.rerun_while(self.threads, &mut try_report)? {
            return stopped.map(|()| None);
        }
        match self.next {
            NextAction::Read => {}
            NextAction::Advance(overlap) => {
                self.advance(overlap)?;
                self.push_lookahead(overlap)?;
            }
            NextAction::PushLookahead(overlap) => self.push_lookahead(overlap)?,
            NextAction::End => return Ok(None),
        }
        self.fill()?;
        if self.session.num_frames() == 0 {
            return Ok(None);
        }
        self.session.run_while(self.threads, try_report)?;
        stopped?;
        Ok(Some(self.finish_window()))
    }

    /// Pushes the lookahead frame. If it begins a new shot, the previous window has settled all frames before it.
    fn push_lookahead(&mut self, overlap: usize) -> Result<(), E> {
        if let Some(frame) = self.lookahead.take() {
            self.push(frame)?;
            if self.session.holds_next_shot() {
                self.advance(overlap)?;
            }
        }
        Ok(())
    }

    /// Advances the session.
    fn advance(&mut self, overlap: usize) -> Result<(), Error> {
        let (frames, begins_shot) = (self.session.num_frames(), self.session.holds_next_shot());
        self.session.advance(overlap)?;
        self.first += if begins_shot { frames } else { frames - overlap };
        Ok(())
    }

    /// Reads frames until the window is full and has a lookahead frame, a new shot begins, or there are no more.
    fn fill(&mut self) -> Result<(), E> {
        while !self.session.holds_next_shot() {
            let Some(frame) = self.next_frame() else { break };
            if self.session.num_frames() == self.plan.size {
                self.lookahead = Some(frame?);
                break;
            }
            self.push(frame?)?;
        }
        Ok(())
    }

    fn next_frame(&mut self) -> Option<Result<Frame, E>> {
        while self.reads_ahead && self.queue.len() <= self.plan.size {
            let Some(frame) = self.frames.next() else {
                (self.reads_ahead, self.remaining) = (false, Some(self.queue.len()));
                break;
            };
            self.queue.push_back(frame);
        }
        let frame = self.queue.pop_front().or_else(|| self.frames.next())?;
        self.remaining = self.remaining.map(|remaining| remaining.saturating_sub(1));
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

    /// Returns the window that was run, and sets the next action.
    fn finish_window(&mut self) -> Window {
        let overlap = if let Some(lookahead) = &self.lookahead {
            let overlap = self.plan.next_overlap(self.remaining);
            self.next = NextAction::Advance(overlap);
            (!self.session.begins_shot(lookahead)).then_some(overlap)
        } else {
            self.next = if self.session.holds_next_shot() { NextAction::Advance(1) } else { NextAction::End };
            None
        };
        self.plan.finish_window(self.session.num_frames(), overlap)
    }
}

#[cfg(test)]
mod tests {
    use crate::correction::Correction;
    use crate::image::Frame;
    use crate::synth::Scene;
    use crate::{Error, Params};
    use crate::{Session, Window, Windows};

    const SIZE: (usize, usize) = (72, 48);
    /// Large enough for objects.
    const WITH_OBJECTS: (usize, usize) = (96, 64);

    fn scene(frames: usize, seed: u64) -> impl Iterator<Item = Result<Frame, Error>> {
        scene_of(SIZE, frames, seed)
    }

    fn scene_of(
        (width, height): (usize, usize),
        frames: usize,
        seed: u64,
    ) -> impl Iterator<Item = Result<Frame, Error>> {
        let scene = Scene::sample((width, height), frames, seed);
        (0..frames).map(move |t| Ok(scene.frame(t)))
    }

    fn all<I: Iterator<Item = Result<Frame, Error>>>(mut windows: Windows<I>) -> Vec<Window> {
        let mut found = Vec::new();
        while let Some(window) = windows.next_window(|_| ()) {
            let window = window.unwrap();
            assert!(window.settled.end <= windows.session().num_frames());
            assert!(window.settled.clone().all(|t| windows.session().labels(t).is_ok()));
            found.push(window);
        }
        assert!(windows.next_window(|_| ()).is_none());
        found
    }

    /// The clip's numbers of the settled frames, in the order in which they were settled.
    fn settled(windows: &[Window]) -> Vec<usize> {
        windows.iter().flat_map(|w| w.settled.clone().map(|t| w.first_frame + t)).collect()
    }

    fn windows<I: Iterator<Item = Result<Frame, Error>>>(frames: I, window: usize, overlap: usize) -> Windows<I> {
        Windows::new(Params::default(), frames).unwrap().with_window(window, overlap).unwrap()
    }

    #[test]
    fn each_frame_is_settled_once_and_in_order() {
        for (count, window, overlap) in [(1, 12, 4), (2, 12, 4), (12, 12, 4), (13, 12, 4), (30, 12, 5), (20, 2, 1)] {
            let found = all(windows(scene(count, 1), window, overlap));
            assert_eq!(settled(&found), (0..count).collect::<Vec<_>>(), "{count} frames by {window}");
            assert!(found.iter().enumerate().all(|(k, w)| w.index == k && w.shot == 0));
        }
    }

    #[test]
    fn a_window_of_all_frames_is_a_session() {
        let mut session = crate::Session::new(Params::default()).unwrap();
        scene(10, 3).for_each(|frame| session.push_frame(frame.unwrap()).unwrap());
        session.run().unwrap();
        let mut windows = windows(scene(10, 3), 10, 4).with_threads(2);
        assert_eq!(windows.next_window(|_| ()).unwrap().unwrap().settled, 0..10);
        for t in 0..10 {
            assert_eq!(windows.session().labels(t).unwrap(), session.labels(t).unwrap());
        }
    }

    #[test]
    fn the_last_window_is_a_full_one() {
        let found = all(windows(scene(15, 1), 12, 4));
        assert_eq!(found.iter().map(|w| w.first_frame).collect::<Vec<_>>(), [0, 3]);
    }

    #[test]
    fn a_cut_ends_a_window_wherever_it_falls() {
        // In the middle of a window, right after a full one, in the first frame after it, and shots of a single frame.
        for cut in [1, 6, 12, 13, 19] {
            let found = all(windows(scene(cut, 1).chain(scene(20 - cut, 7)), 12, 4));
            assert_eq!(settled(&found), (0..20).collect::<Vec<_>>(), "a cut before frame {cut}");
            let begin = found.iter().find(|w| w.shot == 1).map(|w| w.first_frame);
            assert_eq!(begin, Some(cut));
            assert_eq!(found.last().map(|w| w.shot), Some(1));
        }
    }

    #[test]
    fn an_error_ends_it_and_names_the_frame_of_the_clip() {
        let small = Frame::from_rgb(vec![0; 3 * 16 * 16], 16, 16).unwrap();
        let mut windows = windows(scene(15, 1).chain([Ok(small)]), 12, 4);
        assert!(windows.next_window(|_| ()).unwrap().is_ok());
        let error = windows.next_window(|_| ()).unwrap().unwrap_err();
        assert_eq!(error, Error::FrameSizeChanged { index: 15, expected: SIZE, actual: (16, 16) });
        assert!(windows.next_window(|_| ()).is_none());
    }

    #[test]
    fn windows_and_overlaps_have_ranges() {
        let new = || Windows::new(Params::default(), scene(2, 0)).unwrap();
        for (window, overlap, message) in [
            (1, 1, "window = 1 (expected a whole number of frames, 2..=400)"),
            (401, 1, "window = 401 (expected a whole number of frames, 2..=400)"),
            (10, 10, "overlap = 10 (expected a whole number of frames, 1..=9)"),
            (10, 0, "overlap = 0 (expected a whole number of frames, 1..=9)"),
        ] {
            assert_eq!(new().with_window(window, overlap).err().unwrap().to_string(), message);
        }
    }

    #[test]
    fn an_error_of_the_report_ends_the_clip() {
        let mut windows = windows(scene(20, 1), 12, 4).with_threads(2);
        let mut steps = 0;
        let stops = |_| {
            steps += 1;
            if steps == 5 { Err(Error::State { reason: "stopped".to_owned() }) } else { Ok(()) }
        };
        assert!(matches!(windows.try_next_window(stops), Some(Err(Error::State { reason })) if reason == "stopped"));
        assert_eq!(steps, 5);
        assert!(windows.next_window(|_| ()).is_none());
    }

    type Masks = Vec<crate::image::Plane<u8>>;

    /// The masks that a window settles.
    fn masks_of<I: Iterator<Item = Result<Frame, Error>>>(windows: &Windows<I>, window: &Window) -> Masks {
        window.settled.clone().map(|t| windows.session().labels(t).unwrap()).collect()
    }

    /// Shots of 12, 17 and 1 frames: cuts after a full window, in one, and next to the end.
    fn shots(skipped: usize) -> impl Iterator<Item = Result<Frame, Error>> {
        let scene = |frames, seed| scene_of(WITH_OBJECTS, frames, seed);
        scene(12, 1).chain(scene(17, 7)).chain(scene(1, 3)).skip(skipped)
    }

    #[test]
    fn a_clip_goes_on_from_every_checkpoint_as_if_it_had_not_stopped() {
        let mut whole = windows(shots(0), 10, 4);
        let (mut expected, mut checkpoints): (Vec<(Window, Masks)>, Vec<_>) = Default::default();
        while let Some(window) = whole.next_window(|_| ()) {
            let window = window.unwrap();
            expected.push((window.clone(), masks_of(&whole, &window)));
            checkpoints.extend(whole.checkpoint().unwrap());
        }
        assert!(expected.iter().any(|(_, masks)| masks.iter().any(|mask| mask.data().iter().any(|&label| label > 0))));
        assert_eq!((checkpoints.len(), expected.last().map(|(window, _)| window.shot)), (expected.len() - 1, Some(2)));
        for checkpoint in checkpoints {
            let (from, first) = (checkpoint.window(), checkpoint.first_frame());
            assert_eq!(checkpoint.settled(), expected[from].0.first_frame + expected[from].0.settled.start);
            let mut rest = windows(shots(first), 10, 4).resume(checkpoint).unwrap();
            for (window, masks) in &expected[from..] {
                assert_eq!(&rest.next_window(|_| ()).unwrap().unwrap(), window);
                assert!(&masks_of(&rest, window) == masks, "window {} after a stop before {from}", window.index);
            }
            assert!(rest.next_window(|_| ()).is_none());
        }
    }

    #[test]
    fn windows_without_stops_are_those_with_checkpoints_and_looking_ahead_is_knowing_the_length() {
        type Frames = Box<dyn Iterator<Item = Result<Frame, Error>>>;
        let run = |frames: Frames, stops: bool| {
            let mut windows = windows(frames, 10, 4);
            let mut found: Vec<(Window, Masks)> = Vec::new();
            while let Some(window) = windows.next_window(|_| ()) {
                let window = window.unwrap();
                found.push((window.clone(), masks_of(&windows, &window)));
                assert!(!stops || windows.checkpoint().is_ok());
            }
            found
        };
        for skipped in [0, 9] {
            let known = run(Box::new(shots(skipped)), false);
            // Nobody knows how many frames a filter lets through.
            assert!(run(Box::new(shots(skipped).filter(|_| true)), true) == known, "{skipped} skipped");
        }
    }

    #[test]
    fn a_checkpoint_needs_the_frames_that_follow_it() {
        let mut whole = windows(scene(15, 1), 10, 4);
        assert!(whole.checkpoint().unwrap().is_none());
        whole.next_window(|_| ()).unwrap().unwrap();
        let checkpoint = whole.checkpoint().unwrap().unwrap();
        let first = checkpoint.first_frame();
        let error = windows(scene(10, 1).skip(first), 10, 4).resume(checkpoint).err().unwrap();
        assert_eq!(error, Error::TooFewFrames { got: 5, needed: 6 });
    }

    /// Windows of a clip, and what a session of the same frames has that is corrected and goes on in the same way.
    #[test]
    fn a_corrected_window_goes_on_as_a_corrected_session_does() {
        let (mut clip, mut session) =
            (windows(scene_of(WITH_OBJECTS, 20, 1), 12, 4), Session::new(Params::default()).unwrap());
        assert!(matches!(clip.correct(&Correction::Split { label: 1, at: None }), Err(Error::State { .. })));
        let first = clip.next_window(|_| ()).unwrap().unwrap();
        let before = masks_of(&clip, &first);
        for frame in scene_of(WITH_OBJECTS, 20, 1).take(12) {
            session.push_in_shot(frame.unwrap()).unwrap();
        }
        session.run().unwrap();
        let split = Correction::Split { label: 1, at: None };
        clip.correct(&split).unwrap();
        clip.undo_correction().unwrap();
        assert!(masks_of(&clip, &first) == before && clip.undo_correction().is_err());
        clip.correct(&split).unwrap();
        session.correct(&split).unwrap();
        session.run().unwrap();
        let mut steps = 0;
        clip.rerun(|_| steps += 1).unwrap();
        assert!(steps > 0 && masks_of(&clip, &first) != before);
        clip.correct(&Correction::Merge { into: 0, from: 2 }).unwrap();
        session.correct(&Correction::Merge { into: 0, from: 2 }).unwrap();
        assert!(first.settled.clone().all(|t| clip.session().labels(t).unwrap() == session.labels(t).unwrap()));
        session.advance(4).unwrap();
        for frame in scene_of(WITH_OBJECTS, 20, 1).skip(12) {
            session.push_in_shot(frame.unwrap()).unwrap();
        }
        session.run().unwrap();
        let second = clip.next_window(|_| ()).unwrap().unwrap();
        assert!(second.settled.clone().all(|t| clip.session().labels(t).unwrap() == session.labels(t).unwrap()));
    }

    #[test]
    fn the_next_window_first_makes_the_masks_of_a_correction() {
        let second = |reruns: bool| {
            let mut clip = windows(scene_of(WITH_OBJECTS, 20, 1), 12, 4).with_threads(2);
            clip.next_window(|_| ()).unwrap().unwrap();
            clip.correct(&Correction::Split { label: 1, at: None }).unwrap();
            assert!(!reruns || clip.rerun(|_| ()).is_ok());
            let window = clip.next_window(|_| ()).unwrap().unwrap();
            masks_of(&clip, &window)
        };
        assert!(second(false) == second(true));
    }
}
