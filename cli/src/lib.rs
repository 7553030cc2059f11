//! The command line `tracecut`. A library only so that tests and `fuzz/` reach the readers of files; nobody else should
//! use it.

mod boundaries;
mod checkpoint;
mod clock;
mod dump;
mod ending;
mod eval;
mod explain;
mod failure;
mod ffmpeg;
mod formats;
mod images;
mod input;
mod jobs;
mod log;
mod masks;
mod output;
mod overlay;
mod pictures;
#[doc(hidden)]
pub mod readers;
mod report;
mod run;
mod segment;
mod selftest;
mod settings;
mod shell;
mod superpixels;
mod svg;
mod window;
mod y4m;

use clap::{Parser, Subcommand};
use failure::{Failure, tell};
use std::process::ExitCode;

/// Finds the moving objects in a video.
#[derive(Parser, Debug)]
#[command(name = "tracecut", version, after_help = ending::CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Segment clips: masks, trajectories, pictures and a report
    Segment(segment::SegmentArgs),
    /// Say why pixels have their labels: the terms of the cut, and what is behind them
    Explain(explain::ExplainArgs),
    /// Score against ground truth
    #[command(subcommand)]
    Eval(eval::EvalCommand),
    /// Boundary probability of an image, as grey pictures
    Boundaries(boundaries::BoundariesArgs),
    /// Superpixels of an image: a label map, and a picture of the edges between them
    Superpixels(superpixels::SuperpixelArgs),
    /// Check that this machine computes what every other does
    Selftest(selftest::SelftestArgs),
    /// List all parameters with range, default and meaning
    Params,
    /// Print completions for a shell
    Completions(shell::CompletionsArgs),
    /// Print a man page
    Man(shell::ManArgs),
}

/// The whole program.
#[doc(hidden)]
#[must_use]
pub fn main() -> ExitCode {
    let command = Cli::parse().command;
    let tells_events = matches!(&command, Command::Segment(args) if segment::tells_events(args));
    let Err(failure) = ending::listen().map_err(|e| Failure::new(format!("signals: {e}"))).and_then(|()| run(&command))
    else {
        return ExitCode::SUCCESS;
    };
    let code = failure.kind as u8;
    if tells_events {
        tell(serde_json::json!({ "event": "error", "code": code, "message": failure.reason }));
    } else {
        tell(format_args!("error: {}", failure.reason));
    }
    ExitCode::from(code)
}

fn run(command: &Command) -> failure::Result<()> {
    match command {
        Command::Segment(args) => segment::segment(args),
        Command::Explain(args) => explain::explain(args),
        Command::Eval(command) => eval::eval(command),
        Command::Boundaries(args) => boundaries::boundaries(args),
        Command::Superpixels(args) => superpixels::superpixels(args),
        Command::Selftest(args) => selftest::selftest(args),
        Command::Params => settings::list(),
        Command::Completions(args) => shell::completions(args),
        Command::Man(args) => shell::man(args),
    }
}
