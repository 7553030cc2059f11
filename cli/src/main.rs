//! `tracecut`: the command line.

mod boundaries;
mod clock;
mod dump;
mod eval;
mod explain;
mod failure;
mod images;
mod input;
mod jobs;
mod masks;
mod overlay;
mod pictures;
mod run;
mod segment;
mod settings;
mod superpixels;
mod svg;
mod y4m;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Finds the moving objects in a video.
#[derive(Parser, Debug)]
#[command(name = "tracecut", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Segment a clip: masks, tracks.dat, overlay pictures and result.json
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
    /// List all parameters with range, default and meaning
    Params,
}

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Segment(args) => segment::segment(&args),
        Command::Explain(args) => explain::explain(&args),
        Command::Eval(command) => eval::eval(&command),
        Command::Boundaries(args) => boundaries::boundaries(&args),
        Command::Superpixels(args) => superpixels::superpixels(&args),
        Command::Params => settings::list(),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure::Failure(reason)) => {
            eprintln!("error: {reason}");
            ExitCode::FAILURE
        }
    }
}
