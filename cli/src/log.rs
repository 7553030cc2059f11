//! Progress of a run: a bar, lines of JSON, or nothing.

use crate::failure::{Failure, Result, print, print_error};
use crate::progress::ClipProgress;
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::cell::RefCell;
use std::time::Instant;
use tracecut::{Progress, Stage};

#[derive(Args, Debug)]
pub(crate) struct LogArgs {
    /// Print the report of each input (the contents of result.json) on standard output, on one line
    #[arg(long)]
    json: bool,
    /// Print nothing but errors
    #[arg(long, conflicts_with = "log")]
    quiet: bool,
    /// Format of progress on standard error: a bar if it is a terminal, or a line of JSON per event
    #[arg(long, value_name = "FORM", default_value = "text")]
    log: LogFormat,
}

#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq)]
enum LogFormat {
    Text,
    Json,
}

/// The output of progress and reports.
#[derive(Debug)]
pub struct Log {
    bar: ProgressBar,
    clip: RefCell<Option<ShownClip>>,
    prints_reports: bool,
    quiet: bool,
    events: bool,
}

/// The clip whose progress is shown.
#[derive(Debug)]
struct ShownClip {
    progress: ClipProgress,
    begin: Instant,
    /// The window, stage and percent that were shown last.
    shown: Option<(usize, Option<Stage>, Option<u32>)>,
}

/// Length of the bar.
const BAR_STEPS: u64 = 1000;

impl LogArgs {
    pub(crate) fn open(&self) -> Log {
        let events = self.log == LogFormat::Json;
        let bar = if self.quiet || events { ProgressBar::hidden() } else { visible_bar() };
        Log { bar, clip: RefCell::default(), prints_reports: self.json, quiet: self.quiet, events }
    }
}

/// Returns a bar on standard error, which is hidden unless that is a terminal.
fn visible_bar() -> ProgressBar {
    ProgressBar::new(BAR_STEPS)
}

/// Returns the style of a bar; without one if the length of the clip is unknown.
fn bar_style(is_known: bool) -> ProgressStyle {
    let template = if is_known { "{msg:15} {wide_bar} {percent:>3}% {prefix}" } else { "{msg} {elapsed}" };
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

impl Log {
    /// Returns a log with a bar and texts.
    pub(crate) fn plain() -> Self {
        Self { bar: visible_bar(), quiet: false, ..Self::quiet() }
    }

    /// Returns a log that prints nothing.
    pub fn quiet() -> Self {
        Self { bar: ProgressBar::hidden(), clip: RefCell::default(), prints_reports: false, quiet: true, events: false }
    }

    /// Prints an event on standard error, if events are on.
    pub(crate) fn event(&self, name: &str, mut fields: Value) {
        if self.events {
            fields["event"] = json!(name);
            print_error(fields);
        }
    }

    /// Reports a failure that does not end the program.
    pub(crate) fn failure(&self, input: &str, failure: &Failure) {
        if self.events {
            self.event("error", json!({ "input": input, "code": failure.kind as i32, "message": failure.reason }));
        } else {
            print_error(format_args!("error: {}", failure.reason));
        }
    }

    /// Returns whether failures are logged as events.
    pub(crate) fn logs_events(&self) -> bool {
        self.events
    }

    /// Begins a clip.
    pub(crate) fn begin_clip(&self, progress: ClipProgress) {
        *self.clip.borrow_mut() = Some(ShownClip { progress, begin: Instant::now(), shown: None });
    }

    /// Reports a frame that was read.
    pub(crate) fn read_frame(&self) {
        self.update(None, ClipProgress::count_frame);
    }

    /// Reports the end of the input.
    pub(crate) fn end_input(&self) {
        self.clip.borrow_mut().iter_mut().for_each(|clip| clip.progress.end_input());
    }

    /// Reports a step of the run.
    pub(crate) fn step(&self, progress: Progress) {
        // Flow and trajectories alternate: flow is named, which takes far longer.
        let stage = if progress.stage == Stage::Trajectories { Stage::Flow } else { progress.stage };
        self.update(Some(stage), |clip| clip.count(Some(progress.stage), progress.done, progress.total));
    }

    /// Reports a finished window, after which `num_settled` frames of the clip are finished.
    pub(crate) fn settle(&self, num_settled: usize) {
        self.clip.borrow_mut().iter_mut().for_each(|clip| clip.progress.settle(num_settled));
    }

    /// Changes the progress of the clip, and shows each stage of each window, and each percent.
    fn update(&self, stage: Option<Stage>, change: impl FnOnce(&mut ClipProgress)) {
        let mut clip = self.clip.borrow_mut();
        let Some(ShownClip { progress, begin, shown }) = clip.as_mut() else { return };
        change(progress);
        let (window, share) = (progress.window_index(), progress.share());
        let percent = share.map(|share| (100.0 * share) as u32);
        if shown.replace((window, stage, percent)) == Some((window, stage, percent)) {
            return;
        }
        let stage = stage.map_or("decode", Stage::name);
        let seconds_left = progress.seconds_left(begin.elapsed().as_secs_f64());
        self.event(
            "progress",
            json!({ "stage": stage, "share": share.unwrap_or_default(), "secondsLeft": seconds_left }),
        );
        self.bar.set_style(bar_style(share.is_some()));
        self.bar.set_position((BAR_STEPS as f64 * share.unwrap_or_default()) as u64);
        self.bar.set_message(stage);
        self.bar.set_prefix(seconds_left.map_or_else(String::new, |seconds| format!("{seconds:.0} s left")));
    }

    /// Ends the clip.
    pub(crate) fn end(&self) {
        self.bar.finish_and_clear();
        *self.clip.borrow_mut() = None;
    }

    /// Prints the report of a finished input, or its summary.
    pub(crate) fn finish_input(&self, report: &str, summary: &str) -> Result<()> {
        self.end();
        if self.prints_reports {
            print(report)
        } else if self.quiet {
            Ok(())
        } else {
            print(summary)
        }
    }
}
