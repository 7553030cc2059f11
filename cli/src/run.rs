//! Runs a session over an input, with a clock and a log.

use crate::clock::{Clock, Seconds};
use crate::failure::{Failure, Result};
use crate::input::{ClipFrame, Input};
use crate::log::{ClipProgress, Log};
use std::collections::BTreeMap;
use tracecut::{Params, Session, Stage};

/// Seconds that reading, each stage and writing took.
#[derive(Debug, Default)]
pub struct Timing {
    /// Reading and decoding the frames.
    read: Seconds,
    stages: BTreeMap<Stage, Seconds>,
    /// Writing the files of results.
    write: Seconds,
    /// The whole run.
    pub total: Seconds,
}

impl Timing {
    /// Returns the seconds of reading, each stage, writing and the whole run, by name.
    pub(crate) fn by_name(&self) -> BTreeMap<String, Seconds> {
        let stages = self.stages.iter().map(|(stage, &seconds)| (stage.name(), seconds));
        let entries = [("read", self.read), ("write", self.write), ("total", self.total)].into_iter().chain(stages);
        entries.map(|(name, seconds)| (name.to_owned(), seconds)).collect()
    }

    /// Counts reading.
    pub(crate) fn count_reading(&mut self, seconds: Seconds) {
        self.read.add(seconds);
        self.total.add(seconds);
    }

    /// Sets the seconds of writing and of the whole run.
    pub(crate) fn close(&mut self, write: Seconds, total: Seconds) {
        (self.write, self.total) = (write, total);
    }

    /// Counts a step of a stage.
    pub(crate) fn count(&mut self, stage: Stage, seconds: Seconds) {
        self.stages.entry(stage).or_default().add(seconds);
        self.total.add(seconds);
    }
}

/// Reads all frames of `input` and steps a session to its end on `threads` threads.
pub fn run(input: &Input, params: Params, threads: usize, log: &Log) -> Result<(Session, Timing)> {
    run_frames(input.frames()?, input.num_frames(), params, threads, log)
}

/// Steps a session to its end over `frames`; `count` is their number if known.
pub fn run_frames(
    frames: impl Iterator<Item = Result<ClipFrame>>,
    count: Option<usize>,
    params: Params,
    threads: usize,
    log: &Log,
) -> Result<(Session, Timing)> {
    let mut timing = Timing::default();
    let mut clock = Clock::start();
    let mut session = Session::new(params)?;
    let (all_frames, has_masks) = (usize::MAX, session.params().clip.dense);
    log.begin_clip(ClipProgress::new(count, all_frames, has_masks, 0));
    for frame in frames {
        let ClipFrame { name, frame, .. } = frame?;
        session.push_frame(frame).map_err(|e| Failure::about(name, e))?;
        log.read_frame();
    }
    log.end_input();
    timing.count_reading(clock.lap());
    session.run_on(threads, |progress| {
        timing.count(progress.stage, clock.lap());
        log.step(progress);
    })?;
    log.end();
    Ok((session, timing))
}
