//! `bench figment`: sequences of entangled people with masks of every few frames, run and scored.

use super::batch::{Batch, run_clip, sequences, write_json};
use crate::measures::figment::{Scores, mean, score};
use clap::Args;
use png::{BitDepth, ColorType, Decoder};
use serde::Serialize;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use tracecut::connectedness::ConnectednessMode;
use tracecut::discretize::Clusters;
use tracecut::image::Plane;
use tracecut::{Params, Session};
use tracecut_cli::clock::Seconds;
use tracecut_cli::failure::{Failure, Result, print, read};
use tracecut_cli::images;

#[derive(Args, Debug)]
#[command(after_help = "\
Layout of a sequence NAME:
  FOLDER/NAME/frames/        images, one a frame, in the order of their names; or FOLDER/NAME/frames.y4m
  FOLDER/NAME/masks/N.png    what frame number N shows, counted from 0 (00000.png, 00007.png, ... for every seventh frame): a grey or
                             palette image of the frames' size, 0 the background, 1 and up the people, the same number in all frames
Columns, after the paper's Table 1, of the trajectory points in the frames with masks; each cluster is assigned to the person, or the
background, that has most of its points:
  density     pixels that carry a point
  error       points in a cluster not assigned to their person
  per region  the same of each person, 100 without points; mean over the people, without the background
  over-seg.   clusters assigned to a person beyond the first; mean
  recall      pixels of a person within half a grid step of a point of a cluster assigned to that person; mean
  leakage     people whose main cluster has more than half of its points elsewhere
  tracking    frames in which more than half of a person's points are in one and the same cluster assigned to that person; mean
The row \"without connectedness\" scores what the clusters would be with connectedness.mode=off, from the same trajectories.")]
pub(crate) struct FigmentArgs {
    /// Folder with one sub-folder for each sequence
    folder: PathBuf,
    /// Use the first N frames of each sequence, or all where it is shorter
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..))]
    frames: Option<u32>,
    #[command(flatten)]
    batch: Batch,
}

/// A sequence's files: frames, and the number and path of each mask.
#[derive(Debug)]
struct Sequence {
    name: String,
    frames: PathBuf,
    masks: Vec<(usize, PathBuf)>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Outcome {
    name: String,
    frames: usize,
    labelled: usize,
    trajectories: usize,
    clusters: usize,
    #[serde(flatten)]
    scores: Scores,
    /// The same trajectories by motion alone; `null` where nothing else counts.
    without_connectedness: Option<Scores>,
    #[serde(flatten)]
    time: Seconds,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Report<'a> {
    sequences: &'a [Outcome],
    mean: Scores,
    without_connectedness: Option<Scores>,
    params: &'a Params,
}

pub(super) fn eval(args: &FigmentArgs) -> Result<()> {
    let mut params = args.batch.settings.params()?;
    params.clip.dense = false;
    let sequences = find_sequences(&args.folder, &args.batch.only)?;
    print(HEADING)?;
    let outcomes = args.batch.run(&sequences, |s| &s.name, |s| run_sequence(s, &params, args.frames), print_rows)?;
    let scores: Vec<Scores> = outcomes.iter().map(|o| o.scores).collect();
    let without: Option<Vec<Scores>> = outcomes.iter().map(|o| o.without_connectedness).collect();
    let (mean_with, mean_without) = (mean(&scores), without.map(|w| mean(&w)));
    let how = if mean_without.is_some() { ", with connectedness" } else { "" };
    let seconds: f64 = outcomes.iter().map(|o| o.time.best()).sum();
    print(format_args!("{:36}{} {seconds:8.1}", format!("mean{how}"), columns(&mean_with)))?;
    if let Some(without) = &mean_without {
        print(format_args!("{:36}{}", "mean, without", columns(without)))?;
    }
    let report = Report { sequences: &outcomes, mean: mean_with, without_connectedness: mean_without, params: &params };
    write_json(args.batch.json.as_deref(), &report)
}

/// All sub-folders with masks, by name.
fn find_sequences(folder: &Path, only: &[String]) -> Result<Vec<Sequence>> {
    sequences(folder, only, "sub-folders NAME with NAME/frames and NAME/masks", |path, name| {
        let masks = path.join("masks");
        if !masks.is_dir() {
            return Ok(None);
        }
        let video = path.join("frames.y4m");
        let frames = if video.is_file() { video } else { path.join("frames") };
        let masks = images::in_folder(&masks)?.into_iter().map(numbered).collect::<Result<_>>()?;
        Ok(Some(Sequence { name: name.to_owned(), frames, masks }))
    })
}

/// A mask's path with the number of its frame.
fn numbered(path: PathBuf) -> Result<(usize, PathBuf)> {
    match path.file_stem().and_then(|stem| stem.to_str()?.parse().ok()) {
        Some(number) => Ok((number, path)),
        None => {
            Err(Failure::about(path.display(), "has another name than its frame's number (expected 00000.png, ...)"))
        }
    }
}

fn run_sequence(sequence: &Sequence, params: &Params, frames: Option<u32>) -> Result<Outcome> {
    let (session, time) = run_clip(&sequence.frames, frames, params.clone())?;
    let (Some(tracks), Some(clusters)) = (session.trajectories(), session.clusters()) else {
        return Err(Failure::missing_result());
    };
    let masks = read_masks(sequence, &session, frames.is_some())?;
    let labelled: Vec<_> = masks.iter().map(|(frame, mask)| (*frame, mask)).collect();
    let radius = 0.5 * f64::from(params.trajectory.grid_step) * input_scale(&session);
    let scored = |clusters: &Clusters| score(&labelled, tracks, clusters, radius);
    let motion = if params.connectedness.mode == ConnectednessMode::Off { None } else { session.motion_clusters()? };
    Ok(Outcome {
        name: sequence.name.clone(),
        frames: session.num_frames(),
        labelled: labelled.len(),
        trajectories: tracks.len(),
        clusters: clusters.count,
        scores: scored(clusters)?,
        without_connectedness: motion.map(|m| scored(&m)).transpose()?,
        time,
    })
}

/// Input pixels a working pixel.
fn input_scale(session: &Session) -> f64 {
    match (session.input_size(), session.working_size()) {
        (Some(input), Some(working)) => input.0 as f64 / working.0.max(1) as f64,
        _ => 1.0,
    }
}

/// The masks of the clip's frames; later ones may be left over where only the first frames were taken.
fn read_masks(sequence: &Sequence, session: &Session, is_part: bool) -> Result<Vec<(usize, Plane<u8>)>> {
    let masks = sequence.masks.iter().filter(|(frame, _)| !is_part || *frame < session.num_frames());
    masks.map(|(frame, path)| Ok((*frame, read_mask(path)?))).collect()
}

/// The values of a grey image or the indices of a palette image.
fn read_mask(path: &Path) -> Result<Plane<u8>> {
    let broken = |e: &dyn std::fmt::Display| Failure::about(path.display(), format_args!("is not a mask: {e}"));
    let mut reader = Decoder::new(Cursor::new(read(path)?)).read_info().map_err(|e| broken(&e))?;
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    let depth = match (reader.info().color_type, reader.info().bit_depth) {
        (ColorType::Grayscale | ColorType::Indexed, BitDepth::Sixteen) => None,
        (ColorType::Grayscale | ColorType::Indexed, depth) => Some(depth as usize),
        _ => None,
    };
    let depth = depth.ok_or_else(|| broken(&"its colours say nothing (expected grey or palette, at most 8 bit)"))?;
    let mut bytes = vec![0; reader.output_buffer_size().ok_or_else(|| broken(&"it is too large"))?];
    let line = reader.next_frame(&mut bytes).map_err(|e| broken(&e))?.line_size;
    // Several pixels may share a byte, the first in its highest bits; lines start with a byte of their own.
    let value = |x: usize, y: usize| {
        let bit = x * depth;
        let shift = 8 - depth - bit % 8;
        (bytes[y * line + bit / 8] >> shift) & (0xff >> (8 - depth)) as u8
    };
    Ok(Plane::from_fn(width, height, value))
}

const HEADING: &str = "sequence     frames  tracks clusters  density %   error %  per region %  over-seg.  recall %  \
                       leakage %  tracking %  seconds";

fn print_rows(o: &Outcome) -> Result<()> {
    let head = format!("{:12} {:6} {:7} {:8}", o.name, o.frames, o.trajectories, o.clusters);
    print(format_args!("{head:36}{} {:8.1}", columns(&o.scores), o.time.best()))?;
    match &o.without_connectedness {
        Some(without) => print(format_args!("{:36}{}", "    without connectedness", columns(without))),
        None => Ok(()),
    }
}

fn columns(s: &Scores) -> String {
    format!(
        "{:11.2} {:9.2} {:13.2} {:10.2} {:9.2} {:10.2} {:11.2}",
        s.density, s.clustering_error, s.per_region_error, s.oversegmentation, s.recall, s.leakage, s.tracking_time
    )
}
