//! `bench foreground`: which trajectories are foreground, against the labelled frames of the Moseg benchmark.

use super::batch::{Batch, run_clip, write_json};
use super::moseg::{Sequence, find_sequences};
use super::shot::Shot;
use crate::measures::foreground::{ForegroundScores, mean, score};
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;
use tracecut::Params;
use tracecut_cli::clock::Seconds;
use tracecut_cli::failure::{Failure, Result, print};

#[derive(Args, Debug)]
#[command(after_help = "\
All regions but the first of each definition file are foreground. Counted are the trajectory points of the labelled frames. IoU: those that are
foreground in truth and result by those that are in either. Recall: the share of the true foreground that was found. False alarms: the
share of the true background that was taken for foreground. Alone: IoU before the mean over each trajectory's neighbourhood in the
embedding.")]
pub(crate) struct ForegroundArgs {
    /// Folder with one sub-folder for each sequence, holding NAME.bmf, NAMEDef.dat, images and masks
    folder: PathBuf,
    /// Use the first N frames of each sequence, or all where it is shorter
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    #[command(flatten)]
    batch: Batch,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Outcome {
    name: String,
    frames: usize,
    trajectories: usize,
    #[serde(flatten)]
    scores: ForegroundScores,
    /// The same before the average over the embedding.
    alone: ForegroundScores,
    #[serde(flatten)]
    time: Seconds,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Report<'a> {
    frames: u32,
    sequences: &'a [Outcome],
    mean: ForegroundScores,
    mean_alone: ForegroundScores,
    params: &'a Params,
}

pub(super) fn eval(args: &ForegroundArgs) -> Result<()> {
    let mut params = args.batch.settings.params()?;
    params.clip.dense = false;
    let sequences = find_sequences(&args.folder, &args.batch.only)?;
    print("sequence     frames  tracks     IoU  recall  false alarms   alone  seconds")?;
    let outcomes = args.batch.run(&sequences, |s| &s.name, |s| run_sequence(s, &params, args.frames), print_row)?;
    let means = |scores: fn(&Outcome) -> ForegroundScores| mean(&outcomes.iter().map(scores).collect::<Vec<_>>());
    let (in_context, without_context) = (means(|o| o.scores), means(|o| o.alone));
    let seconds: f64 = outcomes.iter().map(|o| o.time.best()).sum();
    print(format_args!("{:27}{} {seconds:8.1}", "mean", columns(&in_context, &without_context)))?;
    let report = Report {
        frames: args.frames,
        sequences: &outcomes,
        mean: in_context,
        mean_alone: without_context,
        params: &params,
    };
    write_json(args.batch.json.as_deref(), &report)
}

fn run_sequence(sequence: &Sequence, params: &Params, frames: u32) -> Result<Outcome> {
    let (session, time) = run_clip(&sequence.list, Some(frames), params.clone())?;
    let (Some(tracks), Some(saliency)) = (session.trajectories(), session.saliency()) else {
        return Err(Failure::missing_result());
    };
    let shot = Shot::read(&sequence.definition, 0..tracks.num_frames)?;
    let scored = |foreground: &[bool]| {
        score(&shot.definition, &shot.maps, tracks, foreground)
            .map_err(|e| Failure::about(sequence.definition.display(), e))
    };
    let salient: Vec<bool> = saliency.of_points.iter().map(|&s| f64::from(s) > params.saliency.threshold).collect();
    Ok(Outcome {
        name: sequence.name.clone(),
        frames: session.num_frames(),
        trajectories: tracks.len(),
        scores: scored(&saliency.foreground)?,
        alone: scored(&salient)?,
        time,
    })
}

fn print_row(o: &Outcome) -> Result<()> {
    let head = format!("{:12} {:6} {:7}", o.name, o.frames, o.trajectories);
    print(format_args!("{head:27}{} {:8.1}", columns(&o.scores, &o.alone), o.time.best()))
}

fn columns(s: &ForegroundScores, alone: &ForegroundScores) -> String {
    format!("{:8.3}{:8.3}{:14.3}{:8.3}", s.iou, s.recall, s.false_alarms, alone.iou)
}
