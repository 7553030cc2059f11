//! A clip window by window: frames in, files of each window out, and where a run can go on.

use crate::clock::{Clock, Seconds};
use crate::ending::whole;
use crate::failure::{Damage, Failure, MIN_FRAMES, Result};
use crate::input::{ClipFrame, FrameTiming, Input};
use crate::log::Log;
use crate::output::Place;
use crate::provenance::{Origin, Provenance, Recipe, Saved};
use crate::run::Timing;
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
        let frame = self.kept(t).and_then(|kept| kept.frame.as_ref());
        frame.ok_or_else(|| Failure::new(format!("frame {} was not kept: please report this", self.first + t)))
    }

    /// Returns the timing of frame `t` of the window; `None` if the input has no times.
    pub(crate) fn timing(&self, t: usize) -> Option<FrameTiming> {
        self.kept(t)?.timing
    }

    fn kept(&self, t: usize) -> Option<&'a KeptFrame> {
        self.kept.frames.get((self.first + t).checked_sub(self.kept.first)?)
    }

    pub(crate) fn results(&self) -> Result<Results<'a>> {
        Ok(Results {
            tracks: self.session.trajectories().ok_or_else(Failure::lost)?,
            clusters: self.session.clusters().ok_or_else(Failure::lost)?,
            embedding: self.session.embedding().ok_or_else(Failure::lost)?,
        })
    }
}

/// Frames whose files are still to be made.
#[derive(Debug, Default)]
struct Kept {
    /// The clip's number of the first of them.
    first: usize,
    frames: VecDeque<KeptFrame>,
}

#[derive(Debug)]
struct KeptFrame {
    /// The frame as it came; `None` if no file is made from its pixels.
    frame: Option<Frame>,
    timing: Option<FrameTiming>,
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
    pub(crate) path: &'a Path,
    pub(crate) recipe: &'a Recipe<'a>,
    /// Frames of a window.
    pub(crate) window: usize,
    pub(crate) threads: usize,
    /// Trajectories to use, for which all frames make one window.
    pub(crate) tracks: Option<Trajectories>,
    /// Whether files are made from the frames themselves.
    pub(crate) needs_frames: bool,
}

/// A clip that was run.
#[derive(Debug)]
pub(crate) struct Outcome<'a> {
    /// Number of windows.
    pub(crate) windows: usize,
    pub(crate) provenance: Provenance<'a>,
    /// Set if the input is damaged after the frames that were run.
    pub(crate) damage: Option<Damage>,
}

/// Frames that are checked, counted and kept as they are read. They end where the input is damaged.
struct Source {
    frames: Box<dyn Iterator<Item = Result<ClipFrame>>>,
    size: (usize, usize),
    number: usize,
    keeps: bool,
    kept: Rc<RefCell<Kept>>,
    reading: Rc<RefCell<Seconds>>,
    damage: Rc<OnceCell<Failure>>,
}

impl Iterator for Source {
    type Item = Result<Frame>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.damage.get().is_some() {
            return None;
        }
        let clock = Clock::start();
        let frame = self.frames.next()?.and_then(|frame| self.check_size(frame));
        self.reading.borrow_mut().add(clock.seconds());
        match frame {
            Ok(ClipFrame { frame, timing, .. }) => {
                self.number += 1;
                let kept = KeptFrame { frame: self.keeps.then(|| frame.clone()), timing };
                self.kept.borrow_mut().frames.push_back(kept);
                Some(Ok(frame))
            }
            Err(failure) if failure.is_after_clip() => {
                self.damage.get_or_init(|| failure);
                None
            }
            Err(failure) => Some(Err(failure)),
        }
    }
}

impl Source {
    fn check_size(&self, clip_frame: ClipFrame) -> Result<ClipFrame> {
        let ClipFrame { name, frame, .. } = &clip_frame;
        let (expected, actual) = (self.size, (frame.width(), frame.height()));
        if actual == expected {
            return Ok(clip_frame);
        }
        Err(Failure::from(Error::FrameSizeChanged { index: self.number, expected, actual }).of(name))
    }
}

/// A clip that is read, and what is known of its reading.
struct Reading<'a> {
    source: Source,
    kept: Rc<RefCell<Kept>>,
    seconds: Rc<RefCell<Seconds>>,
    damage: Rc<OnceCell<Failure>>,
    provenance: Provenance<'a>,
}

impl<'a> Run<'a> {
    /// Runs the clip from where `saved` was made, calls `write` for each window, and saves where it is.
    pub(crate) fn all(
        mut self,
        input: &Input,
        place: &Place,
        saved: Option<Saved>,
        log: &Log,
        mut write: impl FnMut(&Found<'_>, Timing) -> Result<()>,
    ) -> Result<Outcome<'a>> {
        let Reading { source, kept, seconds, damage, provenance } = self.open(input, saved.as_ref(), place)?;
        let outcome = |windows| Outcome {
            windows,
            provenance: provenance.clone(),
            damage: damage.get().and_then(|failure| failure.damage.clone()),
        };
        if let Some(tracks) = self.tracks.take() {
            self.at_once(tracks, source, &kept, log, write)?;
            return Ok(outcome(1));
        }
        let overlap = Window::overlap(self.window);
        let windows = Windows::new(self.recipe.params.clone(), source)?.with_window(self.window, overlap)?;
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
                timing.count(progress.stage, clock.lap().without(read));
                log.step(progress);
            });
            let Some(window) = next.transpose()? else { return Err(too_few(self.path, 0)) };
            let settled = window.first_frame + window.settled.end;
            {
                let kept = &kept.borrow();
                let (session, first) = (windows.session(), window.first_frame);
                let Window { index, shot, settled, .. } = window.clone();
                whole(|| write(&Found { session, index, shot, first, settled, kept }, timing))?;
            }
            log.event("window", json!({ "index": window.index, "shot": window.shot, "settled": settled }));
            let Some(checkpoint) = windows.checkpoint()? else {
                return if settled < MIN_FRAMES {
                    Err(too_few(self.path, settled))
                } else {
                    Ok(outcome(window.index + 1))
                };
            };
            kept.borrow_mut().drop_before(settled);
            let saved = Saved { provenance: provenance.to_json()?, checkpoint };
            whole(|| saved.write(place))?;
        }
    }

    /// Begins to read where `saved` was made, of the input that it was made of.
    fn open(&self, input: &Input, saved: Option<&Saved>, place: &Place) -> Result<Reading<'a>> {
        let clock = Clock::start();
        let mut frames = input.frames()?;
        let first = frames.next().ok_or_else(|| too_few(self.path, 0))??;
        let seconds = Rc::new(RefCell::new(clock.seconds()));
        let size = (first.frame.width(), first.frame.height());
        let source = Origin::new(self.path, input.num_frames(), &first.frame);
        let provenance = Provenance { recipe: self.recipe, source };
        saved.map_or(Ok(()), |saved| saved.check(&provenance, place))?;
        let begin = saved.map_or(0, |saved| saved.checkpoint.first_frame());
        let frames: Box<dyn Iterator<Item = Result<ClipFrame>>> =
            if begin == 0 { Box::new(once(Ok(first)).chain(frames)) } else { Box::new(frames.skip(begin - 1)) };
        let kept = Rc::new(RefCell::new(Kept { first: begin, ..Kept::default() }));
        let damage = Rc::<OnceCell<Failure>>::default();
        let source = Source {
            frames,
            size,
            number: begin,
            keeps: self.needs_frames || size.0.max(size.1) > self.recipe.params.clip.max_side as usize,
            kept: Rc::clone(&kept),
            reading: Rc::clone(&seconds),
            damage: Rc::clone(&damage),
        };
        Ok(Reading { source, kept, seconds, damage, provenance })
    }

    /// Runs the whole clip as one window, with trajectories from outside.
    fn at_once(
        self,
        mut tracks: Trajectories,
        source: Source,
        kept: &RefCell<Kept>,
        log: &Log,
        mut write: impl FnMut(&Found<'_>, Timing) -> Result<()>,
    ) -> Result<()> {
        let (mut timing, mut clock) = (Timing::default(), Clock::start());
        let mut session = Session::new(self.recipe.params.clone())?;
        tracks.size = source.size;
        for frame in source {
            session.push_frame(frame?)?;
        }
        session.set_trajectories(tracks)?;
        timing.count_reading(clock.lap());
        session.run_on(self.threads, |progress| {
            timing.count(progress.stage, clock.lap());
            log.step(progress);
        })?;
        let settled = 0..session.num_frames();
        let found = Found { session: &session, index: 0, shot: 0, first: 0, settled, kept: &kept.borrow() };
        whole(|| write(&found, timing))
    }
}

pub(crate) fn too_few(path: &Path, got: usize) -> Failure {
    Failure::from(Error::TooFewFrames { got, needed: MIN_FRAMES }).of(path.display())
}
