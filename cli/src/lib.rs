//! The command line `tracecut`. It is a library only for the Python package, whose program `tracecut` is this one (`run_program`),
//! for its tests, for `fuzz/` (the readers of files) and for `bench/` (reading, running and drawing clips); nobody else should
//! use it.

mod animation;
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
#[doc(hidden)]
pub mod pictures;
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
mod still;
mod timeline;
mod window;
mod y4m;

use clap::{Args, CommandFactory, Parser, Subcommand};
use clap_complete::Shell;
use failure::{Failure, print};
use std::ffi::OsString;
use std::io::{self, Write};

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
    Completions(CompletionsArgs),
    /// Print a man page
    Man(ManArgs),
}

#[derive(Args, Debug)]
struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

#[derive(Args, Debug)]
struct ManArgs {
    /// A command, such as segment; the program itself if left out
    command: Option<String>,
}

/// Runs the program with these arguments, the first of which is its name, and returns its exit code. Installs handlers of
/// SIGINT and SIGTERM, which end the process.
#[doc(hidden)]
#[must_use]
pub fn run_program(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let code = match Cli::try_parse_from(arguments) {
        Ok(Cli { command }) => {
            let logs_events = matches!(&command, Command::Segment(args) if segment::logs_events(args));
            ending::conclude(logs_events, || run_command(&command))
        }
        Err(usage) => {
            let _ = usage.print();
            usage.exit_code() as u8
        }
    };
    let _ = io::stdout().flush();
    code
}

fn run_command(command: &Command) -> failure::Result<()> {
    match command {
        Command::Segment(args) => segment::segment(args),
        Command::Explain(args) => explain::explain(args),
        Command::Boundaries(args) => still::boundaries(args),
        Command::Superpixels(args) => still::superpixels(args),
        Command::Selftest(args) => selftest::selftest(args),
        Command::Params(args) => settings::list(args),
        Command::Completions(args) => print_completions(args, Cli::command()),
        Command::Man(args) => print_man_page(args, Cli::command()),
    }
}

/// Prints completions of the program for a shell.
fn print_completions(args: &CompletionsArgs, mut program: clap::Command) -> failure::Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut program, "tracecut", &mut script);
    print(String::from_utf8_lossy(&script).trim_end())
}

/// Prints a man page of the program or of one of its commands.
fn print_man_page(args: &ManArgs, mut program: clap::Command) -> failure::Result<()> {
    program.build();
    let command = match &args.command {
        None => program,
        Some(name) => {
            let subcommand = program.find_subcommand(name).cloned();
            subcommand
                .ok_or_else(|| Failure::usage(format!("there is no command \"{name}\" (tracecut --help lists them)")))?
        }
    };
    let mut page = Vec::new();
    clap_mangen::Man::new(command).render(&mut page).map_err(|e| Failure::new(format!("man page: {e}")))?;
    print(String::from_utf8_lossy(&page).trim_end())
}
