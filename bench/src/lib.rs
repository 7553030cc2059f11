//! The program `bench`: scores against ground truth.
//!
//! Not published: neither the crate, nor the wheel, nor the user's command line carries any of it. README.md beside
//! `src` has a line for each command. [`measures`] has the computations; a module for each command reads, runs and prints.

mod batch;
mod clips;
mod compare;
mod davis;
mod fit;
mod flow;
mod masks;
pub mod measures;
mod moseg;
mod points;
mod report;
mod runs;
mod stability;

use clap::{Parser, Subcommand};
use std::process::ExitCode;
use tracecut_cli::ending;
use tracecut_cli::failure::Result;

/// Scores TraceCut against ground truth.
#[derive(Parser, Debug)]
#[command(name = "bench")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Run every sequence of a folder in the layout of the Moseg benchmark and score the labels
    Moseg(moseg::MosegArgs),
    /// Run every sequence of a folder in the layout of DAVIS 2016 and score the masks: region similarity J, boundary
    /// measure F
    Davis(davis::DavisArgs),
    /// Run clips of many kinds, with masks of some or all frames, and score the masks: J, F, recall, false share, objects
    /// found; per clip, per kind and in all
    Masks(masks::MasksArgs),
    /// Run clips of all kinds and score the labels of their trajectories: error, error by region, fragments, objects; per
    /// clip, per kind and in all
    Points(points::PointsArgs),
    /// Fit the weights of what is known of two clusters, on clips of all kinds, and say what each term is worth
    Fit(fit::FitArgs),
    /// Measure the changes of J under irrelevant changes of a clip: seed, crop, mirror, light, JPEG, start
    Stability(stability::StabilityArgs),
    /// End-point error of the flow on frame pairs in the Middlebury layout: NAME/frame10.png, frame11.png, flow10.flo
    Flow(flow::FlowArgs),
}

/// The whole program.
#[must_use]
pub fn main() -> ExitCode {
    let command = Cli::parse().command;
    ending::conclude(false, || run(&command)).into()
}

fn run(command: &Command) -> Result<()> {
    match command {
        Command::Moseg(args) => moseg::eval(args),
        Command::Davis(args) => davis::eval(args),
        Command::Masks(args) => masks::eval(args),
        Command::Points(args) => points::eval(args),
        Command::Fit(args) => fit::eval(args),
        Command::Stability(args) => stability::eval(args),
        Command::Flow(args) => flow::eval(args),
    }
}
