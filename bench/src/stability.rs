//! `bench stability`: how far J of the masks moves when nothing that matters changes.

mod change;

use super::batch::require_dense;
use super::batch::write_json;
use super::clips::{Clip, Suite};
use crate::jobs::in_order;
use crate::measures::masks::{MaskScores, score_frame};
use change::{ALL, Change};
use clap::Args;
use serde::Serialize;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::PathBuf;
use tracecut::Params;
use tracecut_cli::failure::{Failure, Result, print};
use tracecut_cli::input::{ClipFrame, decode};
use tracecut_cli::log::Log;
use tracecut_cli::run::run_frames;

const HELP: &str = "\
Each clip is run as it is (base), under other seeds (seed1, seed2), without its first column and row of pixels, or its first four (crop1,
crop4), mirrored, 5 % darker, through JPEG of quality 80, and from its second frame on (later). Masks should move with the pixels, and
not otherwise.

J is the mean over all frames that have a true mask, the first and the last too; in a frame without any object it is 1 less the share
that is labelled. Spread is the largest J of a clip less its smallest, sd their standard deviation.";

#[derive(Args, Debug)]
#[command(after_help = HELP)]
pub(crate) struct StabilityArgs {
    #[command(flatten)]
    suite: Suite,
    /// Use the first N frames of each clip, or all where it is shorter
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u32).range(2..))]
    frames: u32,
    /// Longest side at which frames are processed, in pixels; short for --set clip.maxSide=PX
    #[arg(long, value_name = "PX", default_value_t = 480)]
    max_side: u32,
    /// The changes to try
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', default_value = ALL)]
    changes: Vec<Change>,
    /// Write all figures and the parameters to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// What came of a clip: J under each change.
#[derive(Debug, Serialize)]
struct Outcome {
    name: String,
    kind: String,
    j: BTreeMap<String, f64>,
    spread: f64,
    sd: f64,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Means {
    j: f64,
    sd: f64,
    spread: f64,
    largest_spread: f64,
}

/// What goes into the file of `--json`.
#[derive(Debug, Serialize)]
struct Report<'a> {
    frames: u32,
    clips: &'a [Outcome],
    mean: &'a Means,
    params: &'a Params,
}

pub(super) fn eval(args: &StabilityArgs) -> Result<()> {
    let mut params = args.suite.settings.params()?;
    params.set("clip.maxSide", &tracecut::params::ParamValue::Number(f64::from(args.max_side)))?;
    require_dense(&params)?;
    let clips = args.suite.clips()?;
    let outcomes = outcomes(&clips, &params, args)?;
    let mean = means(&outcomes);
    print(format_args!(
        "mean J {:.3}, mean sd {:.3}, mean spread {:.3}, largest spread {:.3}",
        mean.j, mean.sd, mean.spread, mean.largest_spread
    ))?;
    let report = Report { frames: args.frames, clips: &outcomes, mean: &mean, params: &params };
    write_json(args.json.as_deref(), &report)
}

/// Runs every clip under every change; prints a clip's row when its last run is done.
fn outcomes(clips: &[Clip], params: &Params, args: &StabilityArgs) -> Result<Vec<Outcome>> {
    let changes = &args.changes;
    let pairs: Vec<(&Clip, Change)> = clips.iter().flat_map(|clip| changes.iter().map(move |&c| (clip, c))).collect();
    print(heading(changes))?;
    let (scores, outcomes) = (RefCell::new(Vec::new()), RefCell::new(Vec::new()));
    let work = |&(clip, change): &(&Clip, Change)| {
        j_under(clip, change, params.clone(), args.frames)
            .map_err(|failure| failure.of(format_args!("{} {change}", clip.name)))
    };
    let report = |&j: &f64| {
        scores.borrow_mut().push(j);
        if scores.borrow().len() < changes.len() {
            return Ok(());
        }
        let clip = &clips[outcomes.borrow().len()];
        let outcome = Outcome::of(clip, changes, &scores.take());
        print(outcome.row(changes))?;
        outcomes.borrow_mut().push(outcome);
        Ok(())
    };
    in_order(&pairs, args.suite.jobs(), work, report)?;
    Ok(outcomes.into_inner())
}

/// J of the clip so changed.
fn j_under(clip: &Clip, change: Change, mut params: Params, frames: u32) -> Result<f64> {
    if let Change::Seed(seed) = change {
        params.clip.seed = seed;
    }
    // One more is there for those who leave the first out.
    let mut images = clip.frames(Some(frames.saturating_add(1)))?.split_off(change.skipped());
    images.truncate(frames as usize);
    let changed = images.iter().map(|path| {
        let frame = change.of_frame(decode(path)?)?;
        Ok(ClipFrame { name: path.display().to_string(), frame, timing: None })
    });
    let (session, _) = run_frames(changed, Some(images.len()), params, 1, &Log::quiet())?;
    let mut scores = Vec::new();
    for (t, image) in images.iter().enumerate() {
        if let Some(truth) = clip.truth(image)? {
            scores.push(score_frame(&session.labels(t)?, &change.of_plane(&truth)?)?);
        }
    }
    MaskScores::mean_of(&scores).j.ok_or_else(|| Failure::new("has no true mask of the frames used".to_owned()))
}

impl Outcome {
    fn of(clip: &Clip, changes: &[Change], scores: &[f64]) -> Self {
        let mean = mean(scores);
        let variance = scores.iter().map(|j| (j - mean).powi(2)).sum::<f64>() / scores.len().max(1) as f64;
        let (low, high) = scores.iter().fold((f64::MAX, f64::MIN), |(low, high), &j| (low.min(j), high.max(j)));
        let j = changes.iter().map(Change::to_string).zip(scores.iter().copied()).collect();
        Self { name: clip.name.clone(), kind: clip.kind.clone(), j, spread: high - low, sd: variance.sqrt() }
    }

    fn row(&self, changes: &[Change]) -> String {
        let columns: String = changes.iter().map(|c| format!("{:8.3}", self.j[&c.to_string()])).collect();
        format!("{:28}{columns}{:8.3}{:8.3}", self.name, self.spread, self.sd)
    }
}

fn heading(changes: &[Change]) -> String {
    let columns: String = changes.iter().map(|c| format!("{:>8}", c.to_string())).collect();
    format!("{:28}{columns}{:>8}{:>8}", "clip", "spread", "sd")
}

fn means(outcomes: &[Outcome]) -> Means {
    let over = |value: fn(&Outcome) -> f64| mean(&outcomes.iter().map(value).collect::<Vec<_>>());
    let all: Vec<f64> = outcomes.iter().flat_map(|o| o.j.values().copied()).collect();
    let largest_spread = outcomes.iter().map(|o| o.spread).fold(0.0, f64::max);
    Means { j: mean(&all), sd: over(|o| o.sd), spread: over(|o| o.spread), largest_spread }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}
