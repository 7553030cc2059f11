//! Progress of a run: a bar, lines of JSON, or nothing.

use crate::failure::{Failure, Result, print, print_error};
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::cell::Cell;
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
    shown: Cell<Option<Stage>>,
    prints_reports: bool,
    quiet: bool,
    events: bool,
}

impl LogArgs {
    pub(crate) fn open(&self) -> Log {
        let events = self.log == LogFormat::Json;
        let bar = if self.quiet || events { ProgressBar::hidden() } else { visible_bar() };
        Log { bar, shown: Cell::default(), prints_reports: self.json, quiet: self.quiet, events }
    }
}

/// Returns a bar on standard error, which is hidden unless that is a terminal.
fn visible_bar() -> ProgressBar {
    let style = ProgressStyle::with_template("{msg:15} {wide_bar} {pos}/{len} {elapsed}");
    ProgressBar::new(0).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

impl Log {
    /// Returns a log with a bar and texts.
    pub(crate) fn plain() -> Self {
        Self { bar: visible_bar(), quiet: false, ..Self::quiet() }
    }

    /// Returns a log that prints nothing.
    pub fn quiet() -> Self {
        Self { bar: ProgressBar::hidden(), shown: Cell::default(), prints_reports: false, quiet: true, events: false }
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

    /// Reports a step of the run.
    pub(crate) fn step(&self, progress: Progress) {
        // Flow and trajectories alternate: the bar follows the flow, which takes far longer.
        if progress.stage == Stage::Trajectories {
            return;
        }
        if self.shown.replace(Some(progress.stage)) != Some(progress.stage) {
            self.begin(progress.stage.name(), progress.total as usize);
        }
        self.bar.set_position(u64::from(progress.done));
    }

    /// Begins a stage.
    pub(crate) fn begin(&self, name: &'static str, steps: usize) {
        self.bar.set_position(0);
        self.bar.set_length(steps as u64);
        self.bar.set_message(name);
    }

    /// Advances the stage by one step.
    pub(crate) fn advance(&self) {
        self.bar.inc(1);
    }

    /// Ends the last stage.
    pub(crate) fn end(&self) {
        self.bar.finish_and_clear();
        self.shown.set(None);
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
