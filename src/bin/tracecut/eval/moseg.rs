//! `tracecut eval moseg`: every sequence of the benchmark through the pipeline and the evaluator.

use super::score_shot;
use crate::failure::{Failure, Result, print, write};
use crate::input::Input;
use crate::jobs::in_order;
use crate::run::run;
use crate::settings::Settings;
use clap::Args;
use indicatif::ProgressBar;
use serde::Serialize;
use std::path::{Path, PathBuf};
use tracecut::Params;
use tracecut::eval::moseg::{Scores, mean, trimmed_mean};
use tracecut::eval::tracks;

#[derive(Args, Debug)]
pub(crate) struct MosegArgs {
    /// Folder with one sub-folder for each sequence, holding NAME.bmf, NAMEDef.dat, images and masks
    folder: PathBuf,
    /// Use the first N frames of each sequence, or all where it is shorter
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Write all figures and the parameters to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the labelled trajectories of each sequence into this folder as NAME.dat
    #[arg(long, value_name = "DIR")]
    tracks: Option<PathBuf>,
    /// Only the sequences whose names these are
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    only: Vec<String>,
    /// Number of sequences to work on at once
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=256))]
    jobs: u32,
    #[command(flatten)]
    settings: Settings,
}

/// A sequence's files.
#[derive(Debug)]
struct Sequence {
    name: String,
    list: PathBuf,
    definition: PathBuf,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Outcome {
    name: String,
    frames: usize,
    trajectories: usize,
    clusters: usize,
    #[serde(flatten)]
    scores: Scores,
    seconds: f64,
    cpu_seconds: Option<f64>,
}

impl Outcome {
    /// Processor seconds where known: sequences run side by side.
    fn shown_seconds(&self) -> f64 {
        self.cpu_seconds.unwrap_or(self.seconds)
    }
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Report<'a> {
    frames: u32,
    sequences: &'a [Outcome],
    mean: &'a Scores,
    trimmed_mean: &'a Scores,
    params: &'a Params,
}

pub(super) fn eval(args: &MosegArgs) -> Result<()> {
    let params = args.settings.params()?;
    let sequences = find_sequences(&args.folder, &args.only)?;
    if let Some(folder) = &args.tracks {
        crate::failure::create_folder(folder)?;
    }
    print(HEADING)?;
    let outcomes = in_order(&sequences, args.jobs as usize, |s| run_sequence(s, &params, args), |o| print(row(o)))?;
    let scores: Vec<Scores> = outcomes.iter().map(|o| o.scores.clone()).collect();
    let (mean, trimmed) = (mean(&scores), trimmed_mean(&scores));
    let seconds: f64 = outcomes.iter().map(Outcome::shown_seconds).sum();
    print(format_args!("{:35}{} {seconds:8.1}", "mean", score_columns(&mean)))?;
    print(format_args!("{:35}{}", "trimmed mean", score_columns(&trimmed)))?;
    if let Some(path) = &args.json {
        let report =
            Report { frames: args.frames, sequences: &outcomes, mean: &mean, trimmed_mean: &trimmed, params: &params };
        let text = serde_json::to_string_pretty(&report).map_err(|e| Failure::about(path.display(), e))?;
        write(path, text + "\n")?;
    }
    Ok(())
}

/// All sub-folders with a `.bmf` list, by name.
fn find_sequences(folder: &Path, only: &[String]) -> Result<Vec<Sequence>> {
    let cannot = |e| Failure::about(folder.display(), format_args!("cannot be read: {e}"));
    let mut sequences = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(cannot)? {
        let path = entry.map_err(cannot)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let list = path.join(&name).with_extension("bmf");
        if list.is_file() && (only.is_empty() || only.contains(&name)) {
            let definition = path.join(format!("{name}Def.dat"));
            sequences.push(Sequence { name, list, definition });
        }
    }
    if sequences.is_empty() {
        let reason = "holds no sequence (expected sub-folders NAME with NAME.bmf and NAMEDef.dat)";
        return Err(Failure::about(folder.display(), reason));
    }
    if let Some(missing) = only.iter().find(|name| sequences.iter().all(|s| s.name != **name)) {
        return Err(Failure::about(folder.display(), format_args!("holds no sequence named {missing}")));
    }
    sequences.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(sequences)
}

fn run_sequence(sequence: &Sequence, params: &Params, args: &MosegArgs) -> Result<Outcome> {
    let run_it = || {
        let input = Input::open(&sequence.list, Some(args.frames), Path::new(""))?;
        let (session, timing) = run(&input, params.clone(), &ProgressBar::hidden())?;
        let (Some(tracks), Some(clusters)) = (session.trajectories(), session.clusters()) else {
            return Err(Failure("the session ended without a result: please report this".to_owned()));
        };
        // Scored as written, so that a score of the file gives the same figures.
        let text = tracks::write(tracks, clusters)?;
        if let Some(folder) = &args.tracks {
            write(&folder.join(format!("{}.dat", sequence.name)), &text)?;
        }
        let (tracks, clusters) = tracks::parse(&text)?;
        Ok(Outcome {
            name: sequence.name.clone(),
            frames: session.num_frames(),
            trajectories: tracks.len(),
            clusters: clusters.count,
            scores: score_shot(&sequence.definition, &tracks, &clusters)?,
            seconds: timing.total.wall,
            cpu_seconds: timing.total.cpu,
        })
    };
    run_it().map_err(|Failure(reason)| Failure::about(&sequence.name, reason))
}

const HEADING: &str =
    "sequence     frames  tracks clusters  density %  overall %   region %  over-seg.  objects  seconds";

fn row(o: &Outcome) -> String {
    let head = format!("{:12} {:6} {:7} {:8}", o.name, o.frames, o.trajectories, o.clusters);
    format!("{head:35}{} {:8.1}", score_columns(&o.scores), o.shown_seconds())
}

fn score_columns(s: &Scores) -> String {
    format!("{:11.2} {:10.2} {:10.2} {:10.2} {:8}", s.density, s.overall, s.average, s.oversegmentation, s.extracted)
}
