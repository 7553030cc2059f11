//! What a run says while it is at it: a bar, lines of JSON, or nothing.

use crate::failure::{Failure, Result, print, tell};
use crate::run::{progress_bar, set_stage};
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressDrawTarget};
use serde_json::{Value, json};
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
pub(crate) struct Log {
    bar: ProgressBar,
    shown: std::cell::Cell<Option<Stage>>,
    prints_reports: bool,
    quiet: bool,
    events: bool,
}

impl LogArgs {
    pub(crate) fn open(&self) -> Log {
        let bar = progress_bar();
        let events = self.log == Form::Json;
        if self.quiet || events {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        Log { bar, shown: Default::default(), prints_reports: self.json, quiet: self.quiet, events }
    }
}

impl Log {
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
            set_stage(&self.bar, progress.stage.name(), progress.total as usize);
        }
        self.bar.set_position(u64::from(progress.done));
    }

    pub(crate) fn bar(&self) -> &ProgressBar {
        &self.bar
    }

    /// An input is done: its report, or a sentence about it.
    pub(crate) fn done(&self, report: &str, summary: &str) -> Result<()> {
        self.bar.finish_and_clear();
        self.shown.set(None);
        if self.prints_reports {
            print(report)
        } else if self.quiet {
            Ok(())
        } else {
            print(summary)
        }
    }
}
