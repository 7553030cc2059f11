//! `bench points`: labelled trajectories against the true masks of clips of all kinds.

use super::batch::{in_order, run_clip, write_json};
use super::clips::{Clip, Suite, find_clips};
use super::moseg::{Sequence, find_sequences};
use super::shot::Shot;
use crate::measures::definition::{Definition, LabelledFrame};
use crate::measures::masks::Truth;
use crate::measures::moseg::{Scores, best_clusters, mean, score, trimmed_mean};
use clap::Args;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use tracecut::image::Plane;
use tracecut::{Params, Session};
use tracecut_cli::clock::Seconds;
use tracecut_cli::failure::{Failure, Result, print};

const HELP: &str = "\
Folders of the Moseg benchmark are scored on its labelled frames; others on all frames that have a mask, each colour of which is a region.

Per clip, means over the seeds, as `moseg` has them:
  error %        wrong points of all
  region %       the same in each region, as a mean over the regions
  fragments      clusters that no region took
  objects        regions with an error below 10 %, without the background, of how many
  best           intersection over union of each object's points with those of its best cluster, as a mean over the objects: an object in
                 parts is low here

The kind of a clip is what stands before -- in its name, or else the name of DIR. Trimmed means leave out the lowest and the highest tenth.";

#[derive(Args, Debug)]
#[command(after_help = HELP)]
pub(crate) struct PointsArgs {
    #[command(flatten)]
    suite: Suite,
    /// Use the first N frames of each clip, or all where it is shorter
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(3..))]
    frames: u32,
    /// Run each clip under each of these seeds
    #[arg(long, value_name = "SEED,...", value_delimiter = ',')]
    seeds: Vec<u32>,
    /// Score the labels after the masks are made, where the background has had its say
    #[arg(long)]
    dense: bool,
    /// Write all figures to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// A clip with true masks, in either layout.
#[derive(Debug)]
enum Source {
    Shot(Sequence),
    Masks(Clip),
}

#[derive(Debug)]
pub(super) struct Item {
    pub(super) name: String,
    pub(super) kind: String,
    source: Source,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Outcome {
    name: String,
    kind: String,
    runs: Vec<Run>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Run {
    seed: u32,
    trajectories: usize,
    clusters: usize,
    #[serde(flatten)]
    scores: Scores,
    best: Option<f64>,
    #[serde(flatten)]
    time: Seconds,
}

pub(super) fn eval(args: &PointsArgs) -> Result<()> {
    let mut params = args.suite.settings.params()?;
    params.clip.dense = args.dense;
    let seeds = if args.seeds.is_empty() { vec![params.clip.seed] } else { args.seeds.clone() };
    let items = items(&args.suite)?;
    print("clip                           tracks clusters   error %  region %  fragments  objects    best  seconds")?;
    let outcomes =
        in_order(&items, args.suite.jobs(), |item| run_seeds(item, &params, &seeds, args), |o| print(row(o)))?;
    print("")?;
    means(&outcomes).into_iter().try_for_each(print)?;
    write_json(args.json.as_deref(), &outcomes)
}

impl Item {
    /// Returns true if its truth is masks of objects, not regions of a shot.
    pub(super) fn has_masks(&self) -> bool {
        matches!(self.source, Source::Masks(_))
    }

    /// Returns the folder of its frames.
    pub(super) fn images(&self) -> &Path {
        match &self.source {
            Source::Shot(sequence) => &sequence.list,
            Source::Masks(clip) => &clip.images,
        }
    }

    /// The true masks of its first frames; none where it has regions.
    pub(super) fn masks(&self, frames: u32) -> Result<Vec<Option<Plane<Truth>>>> {
        match &self.source {
            Source::Shot(_) => Ok(Vec::new()),
            Source::Masks(clip) => clip.frames(Some(frames))?.iter().map(|image| clip.truth(image)).collect(),
        }
    }

    /// The true regions of its first frames.
    pub(super) fn shot(&self, frames: u32) -> Result<Shot> {
        match &self.source {
            Source::Shot(sequence) => Shot::read(&sequence.definition, frames as usize),
            Source::Masks(clip) => shot_of(clip, frames),
        }
    }
}

/// The clips of all folders.
pub(super) fn items(suite: &Suite) -> Result<Vec<Item>> {
    let mut items = Vec::new();
    for folder in &suite.folders {
        if !holds_shots(folder) {
            let of_clip =
                |clip: Clip| Item { name: clip.name.clone(), kind: clip.kind.clone(), source: Source::Masks(clip) };
            items.extend(find_clips(folder, &suite.only)?.into_iter().map(of_clip));
            continue;
        }
        let kind = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let is_selected = |s: &Sequence| suite.only.is_empty() || suite.only.iter().any(|text| s.name.contains(text));
        let of_shot = |s: Sequence| Item { name: s.name.clone(), kind: kind.clone(), source: Source::Shot(s) };
        items.extend(find_sequences(folder, &[])?.into_iter().filter(is_selected).map(of_shot));
    }
    Ok(items)
}

/// Returns true for a folder of the Moseg benchmark.
fn holds_shots(folder: &Path) -> bool {
    let is_shot = |path: PathBuf| path.file_name().is_some_and(|name| path.join(name).with_extension("bmf").is_file());
    std::fs::read_dir(folder).is_ok_and(|entries| entries.flatten().any(|entry| is_shot(entry.path())))
}

fn run_seeds(item: &Item, params: &Params, seeds: &[u32], args: &PointsArgs) -> Result<Outcome> {
    let runs = seeds.iter().map(|&seed| {
        let mut params = params.clone();
        params.clip.seed = seed;
        run_one(item, params, args)
    });
    let runs = runs.collect::<Result<Vec<_>>>().map_err(|failure| failure.with_subject(&item.name))?;
    Ok(Outcome { name: item.name.clone(), kind: item.kind.clone(), runs })
}

fn run_one(item: &Item, params: Params, args: &PointsArgs) -> Result<Run> {
    let seed = params.clip.seed;
    let (session, time, Shot { definition, maps }) = run_item(item, params, args.frames)?;
    let (Some(tracks), Some(clusters)) = (session.trajectories(), session.clusters()) else {
        return Err(Failure::missing_result());
    };
    let broken = |e| Failure::about(&item.name, e);
    Ok(Run {
        seed,
        trajectories: tracks.len(),
        clusters: clusters.count,
        scores: score(&definition, &maps, tracks, clusters).map_err(broken)?,
        best: best_clusters(&definition, &maps, tracks, clusters).map_err(broken)?,
        time,
    })
}

/// A clip's first frames through the pipeline; how long that took, and their truth.
pub(super) fn run_item(item: &Item, params: Params, frames: u32) -> Result<(Session, Seconds, Shot)> {
    let (session, time) = run_clip(item.images(), Some(frames), params)?;
    Ok((session, time, item.shot(frames)?))
}

/// The truth of a clip with masks: region 0 is the background; all mistakes count alike.
fn shot_of(clip: &Clip, frames: u32) -> Result<Shot> {
    let images = clip.frames(Some(frames))?;
    let (mut labelled, mut maps, mut colours): (_, Vec<Plane<u8>>, _) = (Vec::new(), Vec::new(), Vec::new());
    for (index, image) in images.iter().enumerate() {
        if let Some(map) = clip.regions(image, &mut colours)? {
            labelled.push(LabelledFrame { index, mask: String::new(), image: String::new() });
            maps.push(map);
        }
    }
    let count = 1 + colours.len();
    let penalty = (0..count).map(|a| (0..count).map(|b| f64::from(u8::from(a != b))).collect()).collect();
    let definition = Definition { grey: (0..count as u8).collect(), penalty, num_frames: images.len(), labelled };
    Ok(Shot { definition, maps })
}

fn row(outcome: &Outcome) -> String {
    let over = |value: fn(&Run) -> usize| outcome.runs.iter().map(value).sum::<usize>() / outcome.runs.len().max(1);
    let head = format!("{:29} {:7} {:8}", outcome.name, over(|r| r.trajectories), over(|r| r.clusters));
    let seconds: f64 = outcome.runs.iter().map(|r| r.time.best()).sum();
    format!("{head} {} {seconds:8.1}", columns(&of_seeds(outcome), best_of(&[outcome])))
}

/// The scores of a clip as means over the seeds; `visible` is the number of objects.
fn of_seeds(outcome: &Outcome) -> Scores {
    let runs: Vec<Scores> = outcome.runs.iter().map(|run| run.scores.clone()).collect();
    let count = runs.len().max(1) as f64;
    let mean = mean(&runs);
    // One of the visible regions is the background.
    let objects = (mean.visible / count - 1.0).max(0.0);
    Scores { extracted: mean.extracted / count, visible: objects, labeled: mean.labeled / count, ..mean }
}

fn best_of(outcomes: &[&Outcome]) -> Option<f64> {
    let values: Vec<f64> = outcomes.iter().flat_map(|o| &o.runs).filter_map(|run| run.best).collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The rows of each kind, and of all clips.
fn means(outcomes: &[Outcome]) -> Vec<String> {
    let mut kinds: BTreeMap<&str, Vec<&Outcome>> = BTreeMap::new();
    outcomes.iter().for_each(|outcome| kinds.entry(&outcome.kind).or_default().push(outcome));
    let mut lines = Vec::new();
    let mut of_kinds = Vec::new();
    for (kind, clips) in &kinds {
        let scores: Vec<Scores> = clips.iter().map(|o| of_seeds(o)).collect();
        let title = |suffix: &str| format!("{kind} ({}){suffix}", clips.len());
        lines.push(format!("{:46} {}", title(""), columns(&mean(&scores), best_of(clips))));
        if clips.len() > 4 {
            lines.push(format!("{:46} {}", title(", trimmed"), columns(&trimmed_mean(&scores), best_of(clips))));
        }
        of_kinds.push(mean(&scores));
    }
    let scores: Vec<Scores> = outcomes.iter().map(of_seeds).collect();
    let outcomes: Vec<&Outcome> = outcomes.iter().collect();
    lines.push(format!("{:46} {}", format!("mean of kinds ({})", kinds.len()), columns(&mean(&of_kinds), None)));
    lines.push(format!(
        "{:46} {}",
        format!("mean of clips ({})", outcomes.len()),
        columns(&mean(&scores), best_of(&outcomes))
    ));
    lines
}

fn columns(s: &Scores, best: Option<f64>) -> String {
    let objects = format!("{:.1}/{:.0}", s.extracted, s.visible);
    let best = best.map_or_else(|| "-".to_owned(), |best| format!("{best:.3}"));
    format!("{:9.2} {:9.2} {:10.2} {objects:>8} {best:>7}", s.overall, s.average, s.oversegmentation)
}
