//! Runs a session over an input, with a clock and a progress bar.

use crate::clock::{Clock, Seconds};
use crate::failure::{Failure, Result};
use crate::input::{Input, NamedFrame};
use indicatif::{ProgressBar, ProgressStyle};
use std::collections::BTreeMap;
use tracecut::{Params, Session, Stage};

/// How long reading the frames and each stage took.
#[derive(Debug, Default)]
pub struct Timing {
    /// Reading and decoding the frames.
    read: Seconds,
    stages: BTreeMap<Stage, Seconds>,
    /// All of these.
    pub total: Seconds,
}

impl Timing {
    /// Seconds of reading, of each stage and of all, by name.
    pub(crate) fn by_name(&self) -> BTreeMap<String, Seconds> {
        let stages = self.stages.iter().map(|(stage, &seconds)| (stage.name(), seconds));
        let all = [("read", self.read), ("total", self.total)].into_iter().chain(stages);
        all.map(|(name, seconds)| (name.to_owned(), seconds)).collect()
    }

    /// Counts reading.
    pub(crate) fn count_reading(&mut self, seconds: Seconds) {
        self.read.add(seconds);
        self.total.add(seconds);
    }

    /// Counts a step of a stage.
    pub(crate) fn count(&mut self, stage: Stage, seconds: Seconds) {
        self.stages.entry(stage).or_default().add(seconds);
        self.total.add(seconds);
    }
}

/// Reads all frames of `input` and steps a session to its end on `threads` threads.
pub fn run(input: &Input, params: Params, threads: usize, bar: &ProgressBar) -> Result<(Session, Timing)> {
    run_frames(input.frames()?, input.num_frames(), params, threads, bar)
}

/// Steps a session to its end over `frames`, whose number is `count` where known.
pub fn run_frames(
    frames: impl Iterator<Item = Result<NamedFrame>>,
    count: Option<usize>,
    params: Params,
    threads: usize,
    bar: &ProgressBar,
) -> Result<(Session, Timing)> {
    let mut timing = Timing::default();
    let clock = Clock::start();
    let mut session = Session::new(params)?;
    set_stage(bar, "reading", count.unwrap_or(0));
    for frame in frames {
        let (name, frame) = frame?;
        session.push_frame(frame).map_err(|e| Failure::about(name, e))?;
        bar.inc(1);
    }
    timing.count_reading(clock.seconds());
    let mut shown = None;
    let mut clock = Clock::start();
    session.run_on(threads, |progress| {
        let seconds = clock.seconds();
        clock = Clock::start();
        timing.count(progress.stage, seconds);
        // Flow and trajectories take turns: the bar follows the flow, which takes far longer.
        if progress.stage == Stage::Trajectories {
            return;
        }
        if shown != Some(progress.stage) {
            set_stage(bar, progress.stage.name(), progress.total as usize);
            shown = Some(progress.stage);
        }
        bar.set_position(u64::from(progress.done));
    })?;
    bar.finish_and_clear();
    Ok((session, timing))
}

/// Frames that neighbouring windows have in common, where they have more.
pub const SHARED: usize = 10;

/// A bar on standard error if that is a terminal, otherwise none.
pub(crate) fn progress_bar() -> ProgressBar {
    let bar = ProgressBar::new(0);
    let style = ProgressStyle::with_template("{msg:15} {wide_bar} {pos}/{len} {elapsed}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}

pub(crate) fn set_stage(bar: &ProgressBar, name: &'static str, steps: usize) {
    bar.set_position(0);
    bar.set_length(steps as u64);
    bar.set_message(name);
}
