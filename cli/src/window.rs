//! Runs of a clip window by window: frames in, files of each window out, and a checkpoint after each.

use crate::ending::uninterrupted;
use crate::failure::{Damage, Failure, MIN_FRAMES, Result};
use crate::input::{ClipFrame, FrameTiming, Input};
use crate::log::{ClipProgress, Log};
use crate::output::OutputFolder;
use crate::provenance::{Origin, Provenance, Recipe, SavedRun};
use crate::run::{Clock, Seconds, Timing};
use serde_json::json;
use std::cell::{OnceCell, RefCell};
use std::collections::VecDeque;
use std::iter::once;
use std::ops::Range;
use std::path::Path;
use std::rc::Rc;
use tracecut::discretize::Clusters;
use tracecut::embedding::Embedding;
use tracecut::image::Frame;
use tracecut::trajectory::Trajectories;
use tracecut::{Error, Session, Window, Windows};

/// A finished window with the frames that its files are made from.
#[derive(Debug)]
pub(crate) struct WindowResult<'a> {
    pub(crate) session: &'a Session,
    pub(crate) index: usize,
    pub(crate) shot: usize,
    /// The clip's number of its first frame.
    pub(crate) first: usize,
    /// The frames, counted from its first, whose files are written now.
    pub(crate) settled: Range<usize>,
    buffer: &'a FrameBuffer,
}

/// The results of a finished session.
#[derive(Debug)]
pub(crate) struct Results<'a> {
    pub(crate) tracks: &'a Trajectories,
    pub(crate) clusters: &'a Clusters,
    pub(crate) embedding: &'a Embedding,
}

impl<'a> WindowResult<'a> {
    /// Returns frame `t` of the window at input size.
    pub(crate) fn frame(&self, t: usize) -> Result<&'a Frame> {
        let frame = self.buffered(t).and_then(|buffered| buffered.frame.as_ref());
        frame.ok_or_else(|| Failure::new(format!("frame {} was lost: please report this", self.first + t)))
    }

    /// Returns the timing of frame `t` of the window; `None` if the input has no times.
    pub(crate) fn timing(&self, t: usize) -> Option<FrameTiming> {
        self.buffered(t)?.timing
    }

    fn buffered(&self, t: usize) -> Option<&'a BufferedFrame> {
        self.buffer.frames.get((self.first + t).checked_sub(self.buffer.first)?)
    }

    pub(crate) fn results(&self) -> Result<Results<'a>> {
        Ok(Results {
            tracks: self.session.trajectories().ok_or_else(Failure::missing_result)?,
            clusters: self.session.clusters().ok_or_else(Failure::missing_result)?,
            embedding: self.session.embedding().ok_or_else(Failure::missing_result)?,
        })
    }
}

/// Frames whose files are not written yet.
#[derive(Debug, Default)]
struct FrameBuffer {
    /// The clip's number of the first frame in the buffer.
    first: usize,
    frames: VecDeque<BufferedFrame>,
}

#[derive(Debug)]
struct BufferedFrame {
    /// The frame at input size; `None` if no file is made from its pixels.
    frame: Option<Frame>,
    timing: Option<FrameTiming>,
}

impl FrameBuffer {
    /// Drops the frames before frame `end` of the clip.
    fn drop_before(&mut self, end: usize) {
        let count = end.saturating_sub(self.first).min(self.frames.len());
        self.frames.drain(..count);
        self.first += count;
    }
}

/// A clip to be run.
#[derive(Debug)]
pub(crate) struct ClipRun<'a> {
    pub(crate) path: &'a Path,
    pub(crate) recipe: &'a Recipe<'a>,
    /// Frames of a window.
    pub(crate) window: usize,
    pub(crate) threads: usize,
    /// Trajectories of another tracker, with which all frames are one window.
    pub(crate) tracks: Option<Trajectories>,
    /// True if files are made from the frames themselves.
    pub(crate) needs_frames: bool,
}

/// The summary of a finished run.
#[derive(Debug)]
pub(crate) struct ClipSummary<'a> {
    /// Number of windows.
    pub(crate) windows: usize,
    pub(crate) provenance: Provenance<'a>,
    /// Set if the input is damaged after the frames that were run.
    pub(crate) damage: Option<Damage>,
}

/// Reads, checks, counts and buffers frames. It ends where the input is damaged.
struct FrameReader<'a> {
    frames: Box<dyn Iterator<Item = Result<ClipFrame>>>,
    size: (usize, usize),
    number: usize,
    keeps_pixels: bool,
    buffer: Rc<RefCell<FrameBuffer>>,
    seconds: Rc<RefCell<Seconds>>,
    damage: Rc<OnceCell<Failure>>,
    log: &'a Log,
}

impl Iterator for FrameReader<'_> {
    type Item = Result<Frame>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.damage.get().is_some() {
            return None;
        }
        let clock = Clock::start();
        let Some(frame) = self.frames.next() else {
            self.log.end_input();
            return None;
        };
        let frame = frame.and_then(|frame| self.check_size(frame));
        self.seconds.borrow_mut().add(clock.seconds());
        match frame {
            Ok(ClipFrame { frame, timing, .. }) => {
                self.number += 1;
                let buffered = BufferedFrame { frame: self.keeps_pixels.then(|| frame.clone()), timing };
                self.buffer.borrow_mut().frames.push_back(buffered);
                self.log.read_frame();
                Some(Ok(frame))
            }
            Err(failure) if failure.is_after_clip() => {
                self.damage.get_or_init(|| failure);
                self.log.end_input();
                None
            }
            Err(failure) => Some(Err(failure)),
        }
    }
}

impl FrameReader<'_> {
    fn check_size(&self, clip_frame: ClipFrame) -> Result<ClipFrame> {
        let ClipFrame { name, frame, .. } = &clip_frame;
        let (expected, actual) = (self.size, (frame.width(), frame.height()));
        if actual == expected {
            return Ok(clip_frame);
        }
        Err(Failure::from(Error::FrameSizeChanged { index: self.number, expected, actual }).with_subject(name))
    }
}

/// An opened clip.
struct OpenClip<'a> {
    reader: FrameReader<'a>,
    buffer: Rc<RefCell<FrameBuffer>>,
    seconds: Rc<RefCell<Seconds>>,
    damage: Rc<OnceCell<Failure>>,
    provenance: Provenance<'a>,
}

impl<'a> ClipRun<'a> {
    /// Runs the clip, from the checkpoint of `saved_run` if there is one. Calls `write` for each window and saves a checkpoint after it.
    pub(crate) fn run(
        mut self,
        input: &Input,
        place: &OutputFolder,
        saved_run: Option<SavedRun>,
        log: &'a Log,
        mut write: impl FnMut(&WindowResult<'_>, Timing) -> Result<()>,
    ) -> Result<ClipSummary<'a>> {
        let OpenClip { reader, buffer, seconds, damage, provenance } =
            self.open(input, saved_run.as_ref(), place, log)?;
        let summary = |windows| ClipSummary {
            windows,
            provenance: provenance.clone(),
            damage: damage.get().and_then(|failure| failure.damage.clone()),
        };
        if let Some(tracks) = self.tracks.take() {
            self.run_with_tracks(tracks, reader, &buffer, log, write)?;
            return Ok(summary(1));
        }
        let overlap = Window::overlap(self.window);
        let windows = Windows::new(self.recipe.params.clone(), reader)?.with_window(self.window, overlap)?;
        let windows = windows.with_threads(self.threads);
        let mut windows = match saved_run {
            Some(run) => windows.resume(run.checkpoint)?,
            None => windows,
        };
        loop {
            let (mut timing, mut clock) = (Timing::default(), Clock::start());
            let next = windows.next_window(|progress| {
                let read = seconds.take();
                timing.count_reading(read);
                timing.count(progress.stage, clock.lap().without(read));
                log.step(progress);
            });
            let Some(window) = next.transpose()? else { return Err(too_few(self.path, 0)) };
            let num_settled = window.first_frame + window.settled.end;
            // Other windows leave their last frames to the next one.
            let ends_shot = window.settled.end == windows.session().num_frames();
            {
                let buffer = &buffer.borrow();
                let (session, first) = (windows.session(), window.first_frame);
                let Window { index, shot, settled, .. } = window.clone();
                uninterrupted(|| write(&WindowResult { session, index, shot, first, settled, buffer }, timing))?;
            }
            log.settle(num_settled, ends_shot);
            let checkpoint = windows.checkpoint()?;
            let is_last = checkpoint.is_none();
            if let Some(checkpoint) = checkpoint {
                buffer.borrow_mut().drop_before(num_settled);
                let saved_run = SavedRun { provenance: provenance.to_json()?, checkpoint };
                uninterrupted(|| saved_run.write(place))?;
            }
            log.event("window", json!({ "index": window.index, "shot": window.shot, "settled": num_settled }));
            if is_last {
                return if num_settled < MIN_FRAMES {
                    Err(too_few(self.path, num_settled))
                } else {
                    Ok(summary(window.index + 1))
                };
            }
        }
    }

    /// Opens the clip at the checkpoint of `saved_run`, which must be of the same input.
    fn open(
        &self,
        input: &Input,
        saved_run: Option<&SavedRun>,
        place: &OutputFolder,
        log: &'a Log,
    ) -> Result<OpenClip<'a>> {
        let clock = Clock::start();
        let mut frames = input.frames()?;
        let first = frames.next().ok_or_else(|| too_few(self.path, 0))??;
        let seconds = Rc::new(RefCell::new(clock.seconds()));
        let size = (first.frame.width(), first.frame.height());
        let source = Origin::new(self.path, input.num_frames(), &first.frame);
        let provenance = Provenance { recipe: self.recipe, source };
        saved_run.map_or(Ok(()), |run| run.check(&provenance, place))?;
        let begin = saved_run.map_or(0, |run| run.checkpoint.first_frame());
        let frames: Box<dyn Iterator<Item = Result<ClipFrame>>> =
            if begin == 0 { Box::new(once(Ok(first)).chain(frames)) } else { Box::new(frames.skip(begin - 1)) };
        let buffer = Rc::new(RefCell::new(FrameBuffer { first: begin, ..FrameBuffer::default() }));
        let damage = Rc::<OnceCell<Failure>>::default();
        let reader = FrameReader {
            frames,
            size,
            number: begin,
            keeps_pixels: self.needs_frames || size.0.max(size.1) > self.recipe.params.clip.max_side as usize,
            buffer: Rc::clone(&buffer),
            seconds: Rc::clone(&seconds),
            damage: Rc::clone(&damage),
            log,
        };
        let window = if self.tracks.is_some() { usize::MAX } else { self.window };
        log.begin_clip(ClipProgress::new(input.num_frames(), window, self.recipe.params.clip.dense, begin));
        Ok(OpenClip { reader, buffer, seconds, damage, provenance })
    }

    /// Runs the whole clip as one window, with trajectories of another tracker.
    fn run_with_tracks(
        self,
        mut tracks: Trajectories,
        reader: FrameReader<'_>,
        buffer: &RefCell<FrameBuffer>,
        log: &Log,
        mut write: impl FnMut(&WindowResult<'_>, Timing) -> Result<()>,
    ) -> Result<()> {
        let (mut timing, mut clock) = (Timing::default(), Clock::start());
        let mut session = Session::new(self.recipe.params.clone())?;
        tracks.size = reader.size;
        for frame in reader {
            session.push_frame(frame?)?;
        }
        session.set_trajectories(tracks)?;
        timing.count_reading(clock.lap());
        session.run_on(self.threads, |progress| {
            timing.count(progress.stage, clock.lap());
            log.step(progress);
        })?;
        let all_frames = 0..session.num_frames();
        let window = WindowResult {
            session: &session,
            index: 0,
            shot: 0,
            first: 0,
            settled: all_frames,
            buffer: &buffer.borrow(),
        };
        uninterrupted(|| write(&window, timing))
    }
}

pub(crate) fn too_few(path: &Path, got: usize) -> Failure {
    Failure::from(Error::TooFewFrames { got, needed: MIN_FRAMES }).with_subject(path.display())
}
