//! Runs a session over an input, with a log, and counts time and memory as the operating system does.

use crate::failure::{Failure, Result};
use crate::input::{ClipFrame, Input};
use crate::log::{ClipProgress, Log};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::time::Instant;
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

/// Wall time and, on Linux, the processor time of this thread (which does not depend on other programs).
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub struct Seconds {
    #[serde(rename = "seconds")]
    pub wall: f64,
    #[serde(rename = "cpuSeconds")]
    pub cpu: Option<f64>,
}

impl Seconds {
    pub fn add(&mut self, other: Self) {
        self.wall += other.wall;
        self.cpu = match (self.cpu, other.cpu) {
            (Some(a), Some(b)) => Some(a + b),
            (a, b) => a.or(b),
        };
    }

    /// Subtracts the time of a part.
    pub(crate) fn without(self, part: Self) -> Self {
        let cpu = self.cpu.map(|cpu| (cpu - part.cpu.unwrap_or(0.0)).max(0.0));
        Self { wall: (self.wall - part.wall).max(0.0), cpu }
    }

    /// Returns processor seconds if known, otherwise wall seconds.
    pub fn best(self) -> f64 {
        self.cpu.unwrap_or(self.wall)
    }
}

/// A stopwatch.
#[derive(Debug)]
pub struct Clock {
    wall: Instant,
    cpu: Option<f64>,
}

impl Clock {
    pub fn start() -> Self {
        Self { wall: Instant::now(), cpu: thread_seconds() }
    }

    pub fn seconds(&self) -> Seconds {
        // A new thread has no count yet.
        let cpu = thread_seconds().map(|now| now - self.cpu.unwrap_or(0.0));
        Seconds { wall: self.wall.elapsed().as_secs_f64(), cpu }
    }

    /// Returns the seconds since the start or the last lap, and starts another lap.
    pub fn lap(&mut self) -> Seconds {
        let seconds = self.seconds();
        *self = Self::start();
        seconds
    }
}

fn thread_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split_whitespace().next()?.parse().ok()?;
    // Some sandboxes offer the file and fill it with zeros.
    (nanoseconds > 0.0).then_some(nanoseconds * 1e-9)
}

/// Returns the peak memory of this process in bytes; `None` if the system does not report it (Linux does).
pub(crate) fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|k| k * 1024)
}
