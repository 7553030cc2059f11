//! What a run says while it is at it: a bar, lines of JSON, or nothing.

use crate::failure::{Failure, Result, print, tell};
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::cell::Cell;
use tracecut::{Progress, Stage};

#[derive(Args, Debug)]
pub(crate) struct LogArgs {
    /// Print each report (what result.json holds) on standard output, on one line
    #[arg(long)]
    json: bool,
    /// Say nothing but errors
    #[arg(long, conflicts_with = "log")]
    quiet: bool,
    /// How progress is told on standard error: a bar where that is a terminal, or a line of JSON for each event
    #[arg(long, value_name = "FORM", default_value = "text")]
    log: Form,
}

#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    Text,
    Json,
}

/// Where words go.
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
        let events = self.log == Form::Json;
        let bar = if self.quiet || events { ProgressBar::hidden() } else { visible_bar() };
        Log { bar, shown: Cell::default(), prints_reports: self.json, quiet: self.quiet, events }
    }
}

/// A bar on standard error if that is a terminal, otherwise none.
fn visible_bar() -> ProgressBar {
    let style = ProgressStyle::with_template("{msg:15} {wide_bar} {pos}/{len} {elapsed}");
    ProgressBar::new(0).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

impl Log {
    /// A bar where there is a terminal, and words.
    pub(crate) fn plain() -> Self {
        Self { bar: visible_bar(), quiet: false, ..Self::quiet() }
    }

    /// Nothing at all.
    pub fn quiet() -> Self {
        Self { bar: ProgressBar::hidden(), shown: Cell::default(), prints_reports: false, quiet: true, events: false }
    }

    /// One line on standard error, where events are asked for.
    pub(crate) fn event(&self, name: &str, mut what: Value) {
        if self.events {
            what["event"] = json!(name);
            tell(what);
        }
    }

    /// A failure that does not end the program.
    pub(crate) fn failure(&self, input: &str, failure: &Failure) {
        if self.events {
            self.event("error", json!({ "input": input, "code": failure.kind as i32, "message": failure.reason }));
        } else {
            tell(format_args!("error: {}", failure.reason));
        }
    }

    /// Whether failures are told as events.
    pub(crate) fn tells_events(&self) -> bool {
        self.events
    }

    /// A step of the run.
    pub(crate) fn step(&self, progress: Progress) {
        // Flow and trajectories take turns: the bar follows the flow, which takes far longer.
        if progress.stage == Stage::Trajectories {
            return;
        }
        if self.shown.replace(Some(progress.stage)) != Some(progress.stage) {
            self.begin(progress.stage.name(), progress.total as usize);
        }
        self.bar.set_position(u64::from(progress.done));
    }

    /// A stage begins.
    pub(crate) fn begin(&self, name: &'static str, steps: usize) {
        self.bar.set_position(0);
        self.bar.set_length(steps as u64);
        self.bar.set_message(name);
    }

    /// The stage at hand goes on by one.
    pub(crate) fn advance(&self) {
        self.bar.inc(1);
    }

    /// The last stage is over.
    pub(crate) fn end(&self) {
        self.bar.finish_and_clear();
        self.shown.set(None);
    }

    /// An input is done: its report, or a sentence about it.
    pub(crate) fn done(&self, report: &str, summary: &str) -> Result<()> {
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
