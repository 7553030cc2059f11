//! The command line `tracecut`. A library only so that tests and `fuzz/` reach the readers of files, and `bench/` how
//! clips are read, run and drawn; nobody else should use it.

mod animation;
mod boundaries;
mod checkpoint;
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
mod provenance;
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
mod superpixels;
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
    /// Say why pixels have their labels: the terms of the cut, and what is behind them
    Explain(explain::ExplainArgs),
    /// Boundary probability of an image, as grey pictures
    Boundaries(boundaries::BoundariesArgs),
    /// Superpixels of an image: a label map, and a picture of the edges between them
    Superpixels(superpixels::SuperpixelArgs),
    /// Check that this machine computes what every other does
    Selftest(selftest::SelftestArgs),
    /// List the parameters with range, default and meaning
    Params(settings::ParamsArgs),
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
    ending::conclude(tells_events, || run(&command))
}

fn run(command: &Command) -> failure::Result<()> {
    match command {
        Command::Segment(args) => segment::segment(args),
        Command::Explain(args) => explain::explain(args),
        Command::Boundaries(args) => boundaries::boundaries(args),
        Command::Superpixels(args) => superpixels::superpixels(args),
        Command::Selftest(args) => selftest::selftest(args),
        Command::Params(args) => settings::list(args),
        Command::Completions(args) => shell::completions(args, Cli::command()),
        Command::Man(args) => shell::man(args, Cli::command()),
    }
}
