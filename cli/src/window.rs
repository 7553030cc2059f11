//! A clip window by window: frames in, files of each window out, and where a run can go on.

use crate::checkpoint::{Origin, Saved};
use crate::clock::{Clock, Seconds};
use crate::ending::whole;
use crate::failure::{Failure, Result};
use crate::input::{ClipFrame, Input};
use crate::log::Log;
use crate::output::Place;
use crate::run::Timing;
use serde_json::json;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::iter::once;
use std::ops::Range;
use std::rc::Rc;
use tracecut::discretize::Clusters;
use tracecut::embedding::Embedding;
use tracecut::image::Frame;
use tracecut::trajectory::Trajectories;
use tracecut::{Error, Params, Session, Window, Windows};

/// A window that was run, with what of its frames files are made from.
#[derive(Debug)]
pub(crate) struct Found<'a> {
    pub(crate) session: &'a Session,
    pub(crate) index: usize,
    pub(crate) shot: usize,
    /// The clip's number of its first frame.
    pub(crate) first: usize,
    /// The frames, counted from its first, whose files it makes.
    pub(crate) settled: Range<usize>,
    kept: &'a Kept,
}

/// What a finished session holds.
#[derive(Debug)]
pub(crate) struct Results<'a> {
    pub(crate) tracks: &'a Trajectories,
    pub(crate) clusters: &'a Clusters,
    pub(crate) embedding: &'a Embedding,
}

impl<'a> Found<'a> {
    /// Frame `t` of the window, as it came.
    pub(crate) fn frame(&self, t: usize) -> Result<&'a Frame> {
        let frame = (self.first + t).checked_sub(self.kept.first).and_then(|at| self.kept.frames.get(at));
        frame.ok_or_else(|| Failure::new(format!("frame {} was not kept: please report this", self.first + t)))
    }

    pub(crate) fn results(&self) -> Result<Results<'a>> {
        Ok(Results {
            tracks: self.session.trajectories().ok_or_else(Failure::lost)?,
            clusters: self.session.clusters().ok_or_else(Failure::lost)?,
            embedding: self.session.embedding().ok_or_else(Failure::lost)?,
        })
    }
}

/// Frames as they came that pictures and masks are still to be made from.
#[derive(Debug, Default)]
struct Kept {
    /// The clip's number of the first of them.
    first: usize,
    frames: VecDeque<Frame>,
}

impl Kept {
    /// Drops those before frame `settled` of the clip.
    fn drop_before(&mut self, settled: usize) {
        let count = settled.saturating_sub(self.first).min(self.frames.len());
        self.frames.drain(..count);
        self.first += count;
    }
}

/// How a clip is run.
#[derive(Debug)]
pub(crate) struct Run<'a> {
    pub(crate) params: &'a Params,
    /// Frames of a window.
    pub(crate) window: usize,
    pub(crate) threads: usize,
    /// Trajectories to use, for which all frames make one window.
    pub(crate) tracks: Option<Trajectories>,
    /// The options that results depend on.
    pub(crate) options: &'a str,
    /// Whether files are made from the frames themselves.
    pub(crate) needs_frames: bool,
}

/// Frames that are checked, counted and perhaps kept as they are read.
struct Source {
    frames: Box<dyn Iterator<Item = Result<ClipFrame>>>,
    size: (usize, usize),
    number: usize,
    keeps: bool,
    kept: Rc<RefCell<Kept>>,
    reading: Rc<RefCell<Seconds>>,
}

impl Iterator for Source {
    type Item = Result<Frame>;

    fn next(&mut self) -> Option<Self::Item> {
        let clock = Clock::start();
        let frame = self.frames.next()?.and_then(|ClipFrame { name, frame, .. }| self.checked(&name, frame));
        self.reading.borrow_mut().add(clock.seconds());
        self.number += 1;
        if let (true, Ok(frame)) = (self.keeps, &frame) {
            self.kept.borrow_mut().frames.push_back(frame.clone());
        }
        Some(frame)
    }
}

impl Source {
    fn checked(&self, name: &str, frame: Frame) -> Result<Frame> {
        let (expected, actual) = (self.size, (frame.width(), frame.height()));
        if actual == expected {
            return Ok(frame);
        }
        Err(Failure::from(Error::FrameSizeChanged { index: self.number, expected, actual }).of(name))
    }
}

/// A clip that is read, and what is known of its reading.
struct Reading {
    source: Source,
    kept: Rc<RefCell<Kept>>,
    seconds: Rc<RefCell<Seconds>>,
    origin: Origin,
}

impl Run<'_> {
    /// Runs the clip from where `saved` was made, calls `write` for each window, and saves where it is; returns how many
    /// windows there are.
    pub(crate) fn all(
        mut self,
        input: &Input,
        place: &Place,
        saved: Option<Saved>,
        log: &Log,
        mut write: impl FnMut(&Found<'_>, &Timing) -> Result<()>,
    ) -> Result<usize> {
        let Reading { source, kept, seconds, origin } = self.open(input, saved.as_ref(), place)?;
        if let Some(tracks) = self.tracks.take() {
            return self.at_once(tracks, source, &kept, log, write);
        }
        let overlap = Window::overlap(self.window);
        let windows = Windows::new(self.params.clone(), source)?.with_window(self.window, overlap)?;
        let windows = windows.with_threads(self.threads).with_look_ahead();
        let mut windows = match saved {
            Some(saved) => windows.resume(saved.checkpoint)?,
            None => windows,
        };
        loop {
            let (mut timing, mut clock) = (Timing::default(), Clock::start());
            let next = windows.next_window(|progress| {
                let read = seconds.take();
                timing.count_reading(read);
                timing.count(progress.stage, clock.seconds().without(read));
                clock = Clock::start();
                log.step(progress);
            });
            let Some(window) = next.transpose()? else { return Err(too_few(0)) };
            let settled = window.first_frame + window.settled.end;
            {
                let kept = &kept.borrow();
                let (session, first) = (windows.session(), window.first_frame);
                let Window { index, shot, settled, .. } = window.clone();
                whole(|| write(&Found { session, index, shot, first, settled, kept }, &timing))?;
            }
            log.event("window", json!({ "index": window.index, "shot": window.shot, "settled": settled }));
            let Some(checkpoint) = windows.checkpoint()? else {
                return if settled < 2 { Err(too_few(settled)) } else { Ok(window.index + 1) };
            };
            kept.borrow_mut().drop_before(settled);
            let saved = Saved { options: self.options.to_owned(), origin: origin.clone(), checkpoint };
            whole(|| saved.write(place))?;
        }
    }

    /// Begins to read where `saved` was made, of the input that it was made of.
    fn open(&self, input: &Input, saved: Option<&Saved>, place: &Place) -> Result<Reading> {
        let mut frames = input.frames()?;
        let first = frames.next().ok_or_else(|| too_few(0))??;
        let size = (first.frame.width(), first.frame.height());
        let origin = Origin::of(&first.frame, input.num_frames());
        saved.map_or(Ok(()), |saved| saved.check(&origin, place))?;
        let begin = saved.map_or(0, |saved| saved.checkpoint.first_frame());
        let frames: Box<dyn Iterator<Item = Result<ClipFrame>>> =
            if begin == 0 { Box::new(once(Ok(first)).chain(frames)) } else { Box::new(frames.skip(begin - 1)) };
        let kept = Rc::new(RefCell::new(Kept { first: begin, ..Kept::default() }));
        let seconds = Rc::<RefCell<Seconds>>::default();
        let keeps = self.needs_frames || size.0.max(size.1) > self.params.clip.max_side as usize;
        let (own, reading) = (Rc::clone(&kept), Rc::clone(&seconds));
        Ok(Reading { source: Source { frames, size, number: begin, keeps, kept: own, reading }, kept, seconds, origin })
    }

    /// Runs the whole clip as one window, with trajectories from outside.
    fn at_once(
        self,
        mut tracks: Trajectories,
        source: Source,
        kept: &RefCell<Kept>,
        log: &Log,
        mut write: impl FnMut(&Found<'_>, &Timing) -> Result<()>,
    ) -> Result<usize> {
        let (mut timing, clock) = (Timing::default(), Clock::start());
        let mut session = Session::new(self.params.clone())?;
        tracks.size = source.size;
        for frame in source {
            session.push_frame(frame?)?;
        }
        session.set_trajectories(tracks)?;
        timing.count_reading(clock.seconds());
        let mut clock = Clock::start();
        session.run_on(self.threads, |progress| {
            timing.count(progress.stage, clock.seconds());
            clock = Clock::start();
            log.step(progress);
        })?;
        let settled = 0..session.num_frames();
        let found = Found { session: &session, index: 0, shot: 0, first: 0, settled, kept: &kept.borrow() };
        whole(|| write(&found, &timing))?;
        Ok(1)
    }
}

fn too_few(got: usize) -> Failure {
    Error::TooFewFrames { got, needed: 2 }.into()
}
