//! `bench moseg`: every sequence of the benchmark through the pipeline and the evaluator.

use super::batch::{Batch, run_clip, sequences, write_json};
use crate::measures::definition::{Definition, parse_pgm};
use crate::measures::moseg::{Scores, mean, score, score_dense, trimmed_mean};
use clap::Args;
use serde::Serialize;
use std::ops::Range;
use std::path::{Path, PathBuf};
use tracecut::connectedness::ConnectednessMode;
use tracecut::discretize::Clusters;
use tracecut::image::Plane;
use tracecut::tracks;
use tracecut::{Params, Session};
use tracecut_cli::failure::{Failure, Result, print, read, read_text, write};
use tracecut_cli::images::is_endless;
use tracecut_cli::run::Seconds;

#[derive(Args, Debug)]
#[command(after_help = "\
Each sequence has a row that scores its trajectories by their clusters. \"without connectedness\" scores what the clusters would be with
connectedness.mode=off, from the same trajectories; sequences in which it changes no score have no such row, the means have both. With
that setting itself there is only one way.
With --dense each sequence has two rows more. \"pixels by cluster\" scores all pixels of the labelled frames by their cluster, before
objects are told from background: it compares with the first row, and with the pixel row of the paper's Table 2. \"pixels by mask label\"
scores them by the labels of the masks, where all clusters of the background are one. The background is a region and a label as any
other. Density is the share of pixels with a label: every pixel has one, so that it is 100 % in the dense rows.")]
pub(crate) struct MosegArgs {
    /// Folder with one sub-folder for each sequence, holding NAME.bmf, NAMEDef.dat, images and masks
    folder: PathBuf,
    /// Use the first N frames of each sequence, or all where it is shorter
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Make masks as well, and score all pixels of the labelled frames
    #[arg(long)]
    dense: bool,
    /// Write the labelled trajectories of each sequence into this folder as NAME.dat
    #[arg(long, value_name = "DIR")]
    tracks: Option<PathBuf>,
    #[command(flatten)]
    batch: Batch,
}

/// A sequence's files.
#[derive(Debug)]
pub(super) struct Sequence {
    pub(super) name: String,
    pub(super) list: PathBuf,
    pub(super) definition: PathBuf,
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
    /// The same trajectories by motion alone; `null` where nothing else counts.
    without_connectedness: Option<Scores>,
    #[serde(flatten)]
    dense: Option<Dense<Scores>>,
    /// Shown is processor time where known: sequences run side by side.
    #[serde(flatten)]
    time: Seconds,
}

/// Figures of the two ways to score pixels.
#[derive(Debug, Serialize)]
struct Dense<T> {
    /// By cluster.
    pixels: T,
    /// By label of the masks.
    masks: T,
}

/// Means over the sequences.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Means {
    mean: Scores,
    trimmed_mean: Scores,
}

impl Means {
    fn over(outcomes: &[Outcome], scores: impl Fn(&Outcome) -> Option<&Scores>) -> Self {
        let scores: Vec<Scores> = outcomes.iter().filter_map(scores).cloned().collect();
        Self { mean: mean(&scores), trimmed_mean: trimmed_mean(&scores) }
    }
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Report<'a> {
    frames: u32,
    sequences: &'a [Outcome],
    #[serde(flatten)]
    sparse: Means,
    without_connectedness: Option<Means>,
    #[serde(flatten)]
    dense: Option<Dense<Means>>,
    params: &'a Params,
}

pub(super) fn eval(args: &MosegArgs) -> Result<()> {
    let mut params = args.batch.settings.params()?;
    // Without masks to score the run ends with the trajectories' labels.
    params.clip.dense = args.dense;
    let sequences = find_sequences(&args.folder, &args.batch.only)?;
    if let Some(folder) = &args.tracks {
        tracecut_cli::failure::create_folder(folder)?;
    }
    print(HEADING)?;
    let outcomes = args.batch.run(&sequences, |s| &s.name, |s| run_sequence(s, &params, args), print_rows)?;
    let sparse = Means::over(&outcomes, |o| Some(&o.scores));
    let dense = args.dense.then(|| Dense {
        pixels: Means::over(&outcomes, |o| o.dense.as_ref().map(|d| &d.pixels)),
        masks: Means::over(&outcomes, |o| o.dense.as_ref().map(|d| &d.masks)),
    });
    let connected = params.connectedness.mode != ConnectednessMode::Off;
    let without = connected.then(|| Means::over(&outcomes, |o| o.without_connectedness.as_ref()));
    let seconds: f64 = outcomes.iter().map(|o| o.time.best()).sum();
    print_means(&sparse, without.as_ref(), dense.as_ref(), seconds)?;
    let frames = args.frames;
    let report =
        Report { frames, sequences: &outcomes, sparse, without_connectedness: without, dense, params: &params };
    write_json(args.batch.json.as_deref(), &report)
}

/// All sub-folders with a `.bmf` list, by name.
pub(super) fn find_sequences(folder: &Path, only: &[String]) -> Result<Vec<Sequence>> {
    sequences(folder, only, "sub-folders NAME with NAME.bmf and NAMEDef.dat", |path, name| {
        let list = path.join(name).with_extension("bmf");
        let definition = path.join(format!("{name}Def.dat"));
        Ok(list.is_file().then(|| Sequence { name: name.to_owned(), list, definition }))
    })
}

fn run_sequence(sequence: &Sequence, params: &Params, args: &MosegArgs) -> Result<Outcome> {
    let (session, time) = run_clip(&sequence.list, Some(args.frames), params.clone())?;
    let (Some(tracks), Some(clusters)) = (session.trajectories(), session.clusters()) else {
        return Err(Failure::missing_result());
    };
    let shot = Shot::read(&sequence.definition, 0..tracks.num_frames)?;
    // Scored as written, so that a score of the file gives the same figures.
    let scored = |clusters: &Clusters| -> Result<(String, Scores)> {
        let text = tracks::write(tracks, clusters)?;
        let (tracks, clusters) = tracks::parse(&text)?;
        let scores = score(&shot.definition, &shot.maps, &tracks, &clusters);
        Ok((text, scores.map_err(|e| Failure::about(sequence.definition.display(), e))?))
    };
    let (text, scores) = scored(clusters)?;
    if let Some(folder) = &args.tracks {
        write(&folder.join(format!("{}.dat", sequence.name)), &text)?;
    }
    let motion = if params.connectedness.mode == ConnectednessMode::Off { None } else { session.motion_clusters()? };
    Ok(Outcome {
        name: sequence.name.clone(),
        frames: session.num_frames(),
        trajectories: tracks.len(),
        clusters: clusters.count,
        scores,
        without_connectedness: motion.map(|m| Ok::<_, Failure>(scored(&m)?.1)).transpose()?,
        dense: if args.dense { Some(score_pixels(&shot, &session)?) } else { None },
        time,
    })
}

/// Both ways to score the pixels of the labelled frames.
fn score_pixels(shot: &Shot, session: &Session) -> Result<Dense<Scores>> {
    let num_frames = session.num_frames();
    let frames = || shot.definition.labelled_within(num_frames).map(|frame| frame.index);
    let clusters = frames().map(|t| session.cluster_labels(t)).collect::<std::result::Result<Vec<_>, _>>()?;
    let masks = frames().map(|t| Ok(session.labels(t)?.map(u32::from))).collect::<Result<Vec<_>>>()?;
    let num_labels = session.objects().map_or(0, |o| o.highest_label + 1);
    let score = |labels: &[_], count| score_dense(&shot.definition, &shot.maps, labels, count, num_frames);
    Ok(Dense { pixels: score(&clusters, num_clusters(session))?, masks: score(&masks, num_labels)? })
}

const HEADING: &str =
    "sequence     frames  tracks clusters  density %  overall %   region %  over-seg.  objects  seconds";

fn print_rows(o: &Outcome) -> Result<()> {
    let head = format!("{:12} {:6} {:7} {:8}", o.name, o.frames, o.trajectories, o.clusters);
    print(format_args!("{head:35}{} {:8.1}", score_columns(&o.scores), o.time.best()))?;
    if let Some(without) = o.without_connectedness.as_ref().filter(|w| **w != o.scores) {
        print(format_args!("{:35}{}", "    without connectedness", score_columns(without)))?;
    }
    let Some(dense) = &o.dense else { return Ok(()) };
    print(format_args!("{:35}{}", "    pixels by cluster", score_columns(&dense.pixels)))?;
    print(format_args!("{:35}{}", "    pixels by mask label", score_columns(&dense.masks)))
}

fn print_means(sparse: &Means, without: Option<&Means>, dense: Option<&Dense<Means>>, seconds: f64) -> Result<()> {
    let how = if without.is_some() { ", with connectedness" } else { "" };
    print(format_args!("{:35}{} {seconds:8.1}", format!("mean{how}"), score_columns(&sparse.mean)))?;
    let mut rows = vec![(format!("trimmed mean{how}"), &sparse.trimmed_mean)];
    rows.extend(
        without
            .iter()
            .flat_map(|w| [("mean, without".into(), &w.mean), ("trimmed mean, without".into(), &w.trimmed_mean)]),
    );
    let ways = dense.iter().flat_map(|d| [("pixels by cluster", &d.pixels), ("pixels by mask label", &d.masks)]);
    rows.extend(ways.flat_map(|(name, means)| {
        [(format!("{name}, mean"), &means.mean), (format!("{name}, trimmed mean"), &means.trimmed_mean)]
    }));
    rows.iter().try_for_each(|(name, scores)| print(format_args!("{name:35}{}", score_columns(scores))))
}

fn score_columns(s: &Scores) -> String {
    format!("{:11.2} {:10.2} {:10.2} {:10.2} {:8}", s.density, s.overall, s.average, s.oversegmentation, s.extracted)
}

/// A shot's ground truth: its definition and the region maps of the labelled frames used.
pub(super) struct Shot {
    pub(super) definition: Definition,
    pub(super) maps: Vec<Plane<u8>>,
}

impl Shot {
    /// Reads a definition file and the masks beside it of a range of frames; the range's first is frame 0 of the result.
    pub(super) fn read(path: &Path, frames: Range<usize>) -> Result<Self> {
        let mut definition = read_definition(path)?;
        definition.num_frames = definition.num_frames.saturating_sub(frames.start);
        definition.labelled.retain(|frame| frames.contains(&frame.index));
        let mut maps = Vec::new();
        for frame in &mut definition.labelled {
            frame.index -= frames.start;
        }
        for frame in &definition.labelled {
            let mask_path = path.with_file_name(&frame.mask);
            if is_endless(&mask_path) {
                return Err(Failure::about(
                    path.display(),
                    format_args!("names {}, which is no file", mask_path.display()),
                ));
            }
            let mask = parse_pgm(&read(&mask_path)?).map_err(|e| Failure::about(mask_path.display(), e))?;
            maps.push(definition.regions(&mask));
        }
        Ok(Self { definition, maps })
    }
}

/// Reads a definition file.
pub(super) fn read_definition(path: &Path) -> Result<Definition> {
    Definition::parse(&read_text(path)?).map_err(|e| Failure::about(path.display(), e))
}

/// Returns the number of labels of [`Session::cluster_labels`]: a clip without clusters has one.
pub(super) fn num_clusters(session: &Session) -> usize {
    session.clusters().map_or(0, |c| c.count).max(1)
}
