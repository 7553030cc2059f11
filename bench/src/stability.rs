//! `bench stability`: how far J of the masks moves when nothing that matters changes.

use super::batch::{in_order, require_dense, write_json};
use super::clips::{Clip, Suite};
use super::runs::{Excerpt, map_frame};
use crate::measures::masks::{MaskScores, score_frame};
use clap::Args;
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use serde::Serialize;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use tracecut::image::{Frame, Plane};
use tracecut::{Params, Session};
use tracecut_cli::failure::{Failure, Result, print};
use tracecut_cli::input::ClipFrame;

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

/// J of a clip under each change.
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

/// The content of the file of `--json`.
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
            .map_err(|failure| failure.with_subject(format_args!("{} {change}", clip.name)))
    };
    let report = |&j: &f64| {
        scores.borrow_mut().push(j);
        if scores.borrow().len() < changes.len() {
            return Ok(());
        }
        let clip = &clips[outcomes.borrow().len()];
        let outcome = Outcome::new(clip, changes, &scores.take());
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
    let (start, mirrored) = (usize::from(change == Change::Later), change == Change::Mirror);
    let images = clip.frames(None)?.into_iter().skip(start).take(frames as usize).collect();
    let excerpt = Excerpt { start, images, mirrored };
    let mut session = Session::new(params)?;
    for frame in excerpt.frames() {
        let ClipFrame { name, frame, .. } = frame?;
        session.push_frame(change.of_frame(frame)?).map_err(|e| Failure::about(name, e))?;
    }
    session.run()?;
    let mut scores = Vec::new();
    for (t, truth) in excerpt.truth(clip)?.into_iter().enumerate() {
        if let Some(truth) = truth {
            scores.push(score_frame(&session.labels(t)?, &change.of_plane(truth)?)?);
        }
    }
    MaskScores::mean_of(&scores).j.ok_or_else(|| Failure::new("has no true mask of the frames used".to_owned()))
}

impl Outcome {
    fn new(clip: &Clip, changes: &[Change], scores: &[f64]) -> Self {
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
    let values: Vec<f64> = outcomes.iter().flat_map(|o| o.j.values().copied()).collect();
    let largest_spread = outcomes.iter().map(|o| o.spread).fold(0.0, f64::max);
    Means { j: mean(&values), sd: over(|o| o.sd), spread: over(|o| o.spread), largest_spread }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Quality of the JPEG files, chosen by eye.
const JPEG_QUALITY: u8 = 80;
/// Share of brightness that remains in a darker clip. Chosen by eye.
const DARKENING: f32 = 0.95;

/// A change of a clip before it is run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Change {
    /// Nothing.
    Base,
    /// Another seed.
    Seed(u32),
    /// Without this many first columns and rows.
    Crop(usize),
    /// Left and right swapped.
    Mirror,
    /// A twentieth darker.
    Dark,
    /// Through a JPEG file.
    Jpeg,
    /// From the second frame on.
    Later,
}

const ALL: &str = "base,seed1,seed2,crop1,crop4,mirror,dark,jpeg,later";

impl FromStr for Change {
    type Err = String;

    fn from_str(name: &str) -> std::result::Result<Self, String> {
        let unknown = || format!("expected some of {ALL}; seed and crop with any number");
        match name {
            "base" => Ok(Self::Base),
            "mirror" => Ok(Self::Mirror),
            "dark" => Ok(Self::Dark),
            "jpeg" => Ok(Self::Jpeg),
            "later" => Ok(Self::Later),
            other => {
                let number = |prefix| other.strip_prefix(prefix).and_then(|n: &str| n.parse::<u32>().ok());
                let crop = || number("crop").map(|n| Self::Crop(n as usize));
                number("seed").map(Self::Seed).or_else(crop).ok_or_else(unknown)
            }
        }
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Base => f.write_str("base"),
            Self::Seed(seed) => write!(f, "seed{seed}"),
            Self::Crop(pixels) => write!(f, "crop{pixels}"),
            Self::Mirror => f.write_str("mirror"),
            Self::Dark => f.write_str("dark"),
            Self::Jpeg => f.write_str("jpeg"),
            Self::Later => f.write_str("later"),
        }
    }
}

impl Change {
    /// Applies the change of pixels to a frame. The excerpt has the other changes.
    fn of_frame(self, frame: Frame) -> Result<Frame> {
        match self {
            Self::Base | Self::Seed(_) | Self::Mirror | Self::Later => Ok(frame),
            Self::Dark => {
                let darker = |&value: &u8| (f32::from(value) * DARKENING + 0.5) as u8;
                Ok(Frame::from_rgb(frame.rgb().iter().map(darker).collect(), frame.width(), frame.height())?)
            }
            Self::Jpeg => through_jpeg(&frame),
            Self::Crop(_) => map_frame(&frame, |plane| self.of_plane(plane)),
        }
    }

    /// Applies the crop to a plane, such as the true mask.
    fn of_plane<T: Copy>(self, plane: Plane<T>) -> Result<Plane<T>> {
        let (width, height) = (plane.width(), plane.height());
        match self {
            Self::Crop(n) if n >= width.min(height) => {
                Err(Failure::new(format!("crop{n} leaves nothing of frames of {width}x{height}")))
            }
            Self::Crop(n) => Ok(Plane::from_fn(width - n, height - n, |x, y| plane[(x + n, y + n)])),
            _ => Ok(plane),
        }
    }
}

fn through_jpeg(frame: &Frame) -> Result<Frame> {
    let (width, height) = (frame.width() as u32, frame.height() as u32);
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY)
        .write_image(frame.rgb(), width, height, ExtendedColorType::Rgb8)
        .map_err(|e| Failure::about("cannot be made a JPEG file", e))?;
    Ok(Frame::decode(&bytes)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(values: &[u8], width: usize) -> Frame {
        let rgb = values.iter().flat_map(|&v| [v, v, v]).collect();
        Frame::from_rgb(rgb, width, values.len() / width).unwrap()
    }

    fn values(frame: &Frame) -> Vec<u8> {
        frame.rgb().iter().step_by(3).copied().collect()
    }

    #[test]
    fn names_are_read_as_they_are_written() {
        for name in ALL.split(',').chain(["seed17", "crop32"]) {
            assert_eq!(name.parse::<Change>().unwrap().to_string(), name);
        }
        for wrong in ["", "crop", "seed-1", "bright"] {
            assert!(wrong.parse::<Change>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn frames_and_masks_are_changed_alike() {
        let picture = [10, 20, 30, 40, 50, 60];
        let changed = |change: Change| values(&change.of_frame(grey(&picture, 3)).unwrap());
        let plane = Plane::from_vec(3, 2, picture.to_vec()).unwrap();
        assert_eq!(changed(Change::Crop(1)), [50, 60]);
        assert_eq!(Change::Crop(1).of_plane(plane.clone()).unwrap().data(), [50, 60]);
        assert_eq!(changed(Change::Dark), [10, 19, 29, 38, 48, 57]);
        assert_eq!(Change::Dark.of_plane(plane.clone()).unwrap(), plane);
        assert!(Change::Crop(2).of_plane(plane).is_err());
    }

    #[test]
    fn a_jpeg_is_near_its_original_and_not_it() {
        let original: Vec<u8> = (0..64 * 64_u32).map(|i| (i * 37 % 251) as u8 / 2 + (i % 64) as u8).collect();
        let changed = values(&Change::Jpeg.of_frame(grey(&original, 64)).unwrap());
        let worst = original.iter().zip(&changed).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(changed != original && worst < Some(100), "{worst:?}");
    }
}
