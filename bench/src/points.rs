//! `bench points`: labelled trajectories against the true masks of clips of all kinds.

use super::batch::{in_order, write_json};
use super::clips::{Clip, Suite, find_clips};
use super::compare::Earlier;
use super::moseg::{Sequence, Shot, find_sequences, read_definition};
use super::report::{Column, Outcome, RUNS_HELP, Report, Run, Scores, by_kind, group_row, heading, summary};
use super::runs::{Excerpt, RunOptions};
use crate::measures::definition::{Definition, LabelledFrame};
use crate::measures::estimate::Estimate;
use crate::measures::moseg::{self, best_clusters, trimmed};
use clap::Args;
use serde::Serialize;
use std::ops::Range;
use std::path::{Path, PathBuf};
use tracecut::image::Plane;
use tracecut::trajectory::Trajectories;
use tracecut::{Params, Session};
use tracecut_cli::failure::{Failure, Result, print};
use tracecut_cli::images;

const HELP: &str = "\
Folders of the Moseg benchmark are scored on its labelled frames; others on all frames that have a mask, each colour of which is a region.

Per clip, as `moseg` has them:
  error %        wrong points of all
  region %       the same in each region, as a mean over the regions
  fragments      clusters that no region took
  objects, of    regions with an error below 10 %, without the background, and the number of regions but one
  best           intersection over union of each object's points with those of its best cluster, as a mean over the objects: an object in
                 parts is low here

Trimmed means leave out the lowest and the highest tenth of the clips.";

#[derive(Args, Debug)]
#[command(after_help = format!("{HELP}\n\n{RUNS_HELP}"))]
pub(crate) struct PointsArgs {
    #[command(flatten)]
    suite: Suite,
    /// Use N frames from each start, or all where there are fewer
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(3..))]
    frames: u32,
    #[command(flatten)]
    runs: RunOptions,
    /// Score the labels after the masks are made, where the background has had its say
    #[arg(long)]
    dense: bool,
    /// Write all figures to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Compare with the figures that an earlier --json of this command wrote
    #[arg(long, value_name = "FILE")]
    compare: Option<PathBuf>,
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

/// Scores of labelled points.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct PointScores {
    /// Wrong points, in percent; `None` without points.
    pub(super) error: Option<f64>,
    /// Mean of the regions' errors, in percent.
    pub(super) region: f64,
    /// Clusters that no region took; `None` without points.
    pub(super) fragments: Option<f64>,
    /// Regions with an error below 10 %, the background not counted.
    pub(super) objects: f64,
    /// Visible regions, the background not counted.
    pub(super) true_objects: f64,
    /// Intersection over union of each object's points with its best cluster; `None` without an object.
    pub(super) best: Option<f64>,
}

/// The scores of a run.
#[derive(Debug, Serialize)]
struct PointRun {
    trajectories: usize,
    clusters: usize,
    #[serde(flatten)]
    scores: PointScores,
}

impl Scores for PointRun {
    const COLUMNS: &'static [Column] = &[
        Column { name: "error", heading: "error %", width: 10, decimals: 2, has_error: true },
        Column { name: "region", heading: "region %", width: 10, decimals: 2, has_error: true },
        Column { name: "fragments", heading: "fragments", width: 11, decimals: 2, has_error: true },
        Column { name: "objects", heading: "objects", width: 9, decimals: 1, has_error: true },
        Column { name: "trueObjects", heading: "of", width: 5, decimals: 1, has_error: false },
        Column { name: "best", heading: "best", width: 8, decimals: 3, has_error: true },
    ];
    const HEAD_WIDTH: usize = 46;
    /// Chosen by eye.
    const LARGE_CHANGE: f64 = 5.0;

    fn values(&self) -> Vec<Option<f64>> {
        let PointScores { error, region, fragments, objects, true_objects, best } = self.scores;
        vec![error, Some(region), fragments, Some(objects), Some(true_objects), best]
    }
}

pub(super) fn eval(args: &PointsArgs) -> Result<()> {
    let mut params = args.suite.settings.params()?;
    params.clip.dense = args.dense;
    let seeds = args.runs.seeds(&[params.clip.seed]);
    let items = items(&args.suite)?;
    let earlier = Earlier::read(args.compare.as_deref(), Some(args.frames))?;
    if let Some(earlier) = &earlier {
        for item in &items {
            earlier.require(&item.kind, &item.name, &item.excerpts(&args.runs, args.frames)?, &seeds)?;
        }
    }
    let with_errors = args.runs.are_several(&seeds);
    print(format_args!("{:30} tracks clusters{}  seconds", "clip", heading::<PointRun>(with_errors)))?;
    let work = |item: &Item| run_item(item, &params, &seeds, args).map_err(|f| f.with_subject(&item.name));
    let outcomes = in_order(&items, args.suite.jobs(), work, |o| print(row(o, with_errors)))?;
    let report = Report::new(&outcomes, Some(args.frames), &params);
    print("")?;
    report.lines(with_errors).into_iter().try_for_each(print)?;
    trimmed_lines(&outcomes).into_iter().try_for_each(print)?;
    earlier.map_or(Ok(Vec::new()), |earlier| earlier.lines(&outcomes))?.into_iter().try_for_each(print)?;
    write_json(args.json.as_deref(), &report)
}

impl Item {
    /// Returns true if its truth is masks of objects, not regions of a shot.
    pub(super) fn has_masks(&self) -> bool {
        matches!(self.source, Source::Masks(_))
    }

    /// Returns the excerpts to run, each of at most `frames` frames: those of later starts that have a labelled frame.
    pub(super) fn excerpts(&self, options: &RunOptions, frames: u32) -> Result<Vec<Excerpt>> {
        match &self.source {
            Source::Shot(sequence) => {
                let labelled = read_definition(&sequence.definition)?.labelled;
                let is_scored = |range: Range<usize>| labelled.iter().any(|frame| range.contains(&frame.index));
                Ok(options.excerpts(&images::in_list(&sequence.list)?, Some(frames), is_scored))
            }
            Source::Masks(clip) => options.clip_excerpts(clip, Some(frames)),
        }
    }

    /// The true regions of an excerpt.
    pub(super) fn shot(&self, excerpt: &Excerpt) -> Result<Shot> {
        let mut shot = match &self.source {
            Source::Shot(sequence) => Shot::read(&sequence.definition, excerpt.range())?,
            Source::Masks(clip) => shot_of(clip, &excerpt.images)?,
        };
        shot.maps = shot.maps.into_iter().map(|map| excerpt.orient(map)).collect();
        Ok(shot)
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

/// Runs all excerpts of a clip under all seeds.
fn run_item(item: &Item, params: &Params, seeds: &[u32], args: &PointsArgs) -> Result<Outcome<PointRun>> {
    let mut runs = Vec::new();
    for excerpt in item.excerpts(&args.runs, args.frames)? {
        let shot = item.shot(&excerpt)?;
        runs.extend(excerpt.run_seeds(params, seeds, |session, id, time| {
            let scores = PointRun {
                trajectories: session.trajectories().map_or(0, Trajectories::len),
                clusters: session.clusters().map_or(0, |clusters| clusters.count),
                scores: PointScores::of(&session, &shot)?,
            };
            Ok(Run { id, frames: session.num_frames(), scores, time })
        })?);
    }
    Ok(Outcome::new(&item.name, &item.kind, runs))
}

impl PointScores {
    /// Scores the labelled trajectories of a session.
    pub(super) fn of(session: &Session, shot: &Shot) -> Result<Self> {
        let (Some(tracks), Some(clusters)) = (session.trajectories(), session.clusters()) else {
            return Err(Failure::missing_result());
        };
        let Shot { definition, maps } = shot;
        let scores = moseg::score(definition, maps, tracks, clusters)?;
        let has_points = scores.density > 0.0;
        Ok(Self {
            error: has_points.then_some(scores.overall),
            region: scores.average,
            fragments: has_points.then_some(scores.oversegmentation),
            objects: scores.extracted,
            // One of the visible regions is the background.
            true_objects: (scores.visible - 1.0).max(0.0),
            best: best_clusters(definition, maps, tracks, clusters)?,
        })
    }
}

/// The truth of a clip with masks: region 0 is the background; all mistakes count alike.
fn shot_of(clip: &Clip, images: &[PathBuf]) -> Result<Shot> {
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

fn row(outcome: &Outcome<PointRun>, with_errors: bool) -> String {
    let count = outcome.runs.len().max(1);
    let mean = |value: fn(&PointRun) -> usize| outcome.runs.iter().map(|run| value(&run.scores)).sum::<usize>() / count;
    let head = format!("{:29} {:7} {:8}", outcome.name, mean(|r| r.trajectories), mean(|r| r.clusters));
    outcome.row(&head, &format!(" {:8.1}", outcome.seconds()), with_errors)
}

/// Formats the trimmed means of kinds with enough clips.
fn trimmed_lines(outcomes: &[Outcome<PointRun>]) -> Vec<String> {
    let kinds = by_kind(outcomes).into_iter().filter(|(_, clips)| clips.len() > 4);
    let line = |(kind, clips): (&str, Vec<&Outcome<PointRun>>)| {
        let values = |column: &Column| clips.iter().filter_map(|clip| Some(clip.mean.get(column.name)?.mean)).collect();
        let estimate = |mean: f64| Estimate { mean, standard_error: None };
        let mean = summary::<PointRun>(|_, column| Some(estimate(trimmed(values(column))?)));
        group_row::<PointRun>(&format!("{kind}, trimmed"), clips.len(), &mean, false)
    };
    kinds.map(line).collect()
}
