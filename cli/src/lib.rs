//! The command line `tracecut`. It is a library only for its tests, for `fuzz/` (the readers of files) and for `bench/` (reading,
//! running and drawing clips); nobody else should use it.

mod animation;
mod clip_frame;
#[doc(hidden)]
pub mod clock;
mod dump;
#[doc(hidden)]
pub mod ending;
mod explain;
#[doc(hidden)]
pub mod failure;
mod ffmpeg;
mod formats;
#[doc(hidden)]
pub mod images;
#[doc(hidden)]
pub mod input;
#[doc(hidden)]
pub mod log;
#[doc(hidden)]
pub mod masks;
mod output;
mod overlay;
#[doc(hidden)]
pub mod pictures;
mod progress;
#[doc(hidden)]
pub mod provenance;
#[doc(hidden)]
pub mod readers;
mod report;
#[doc(hidden)]
pub mod run;
mod segment;
mod selftest;
#[doc(hidden)]
pub mod settings;
mod shell;
mod still;
mod timeline;
mod times;
mod window;
mod y4m;

use clap::{CommandFactory, Parser, Subcommand};
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
    /// Explain the labels of pixels: the terms of the cut and their origin
    Explain(explain::ExplainArgs),
    /// Boundary probability of an image, as grey pictures
    Boundaries(still::BoundariesArgs),
    /// Superpixels of an image: a label map, and a picture of the edges between them
    Superpixels(still::SuperpixelArgs),
    /// Check that this machine computes the same results as every other
    Selftest(selftest::SelftestArgs),
    /// List the parameters with range, default and meaning
    Params(settings::ParamsArgs),
    /// Print completions for a shell
    Completions(shell::CompletionsArgs),
    /// Print a man page
    Man(shell::ManArgs),
}

/// Runs the program.
#[doc(hidden)]
#[must_use]
pub fn main() -> ExitCode {
    let command = Cli::parse().command;
    let logs_events = matches!(&command, Command::Segment(args) if segment::logs_events(args));
    ending::conclude(logs_events, || run(&command))
}

fn run(command: &Command) -> failure::Result<()> {
    match command {
        Command::Segment(args) => segment::segment(args),
        Command::Explain(args) => explain::explain(args),
        Command::Boundaries(args) => still::boundaries(args),
        Command::Superpixels(args) => still::superpixels(args),
        Command::Selftest(args) => selftest::selftest(args),
        Command::Params(args) => settings::list(args),
        Command::Completions(args) => shell::completions(args, Cli::command()),
        Command::Man(args) => shell::man(args, Cli::command()),
    }
}
