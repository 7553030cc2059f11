//! `bench masks`: clips of many kinds through the pipeline, their masks against the true ones.

mod report;

use super::batch::{in_order, require_dense, write_json};
use super::clips::{Clip, Suite, write_overlays};
use crate::measures::davis::scored_frames;
use crate::measures::masks::{ClipScorer, MaskScores, Truth};
use crate::measures::reliability::Reliability;
use clap::Args;
use report::{Outcome, Report, Run, Scored};
use std::path::{Path, PathBuf};
use tracecut::image::Plane;
use tracecut::{Params, Session, Window, Windows};
use tracecut_cli::clock::{Clock, Seconds};
use tracecut_cli::failure::{Failure, Result, print};
use tracecut_cli::input::{ClipFrame, Input};
use tracecut_cli::log::Log;
use tracecut_cli::run::run;

/// One overlay in this many is written.
const OVERLAY_STEP: usize = 10;

const HELP: &str = "\
In NAME/masks 255 is an object, 128 is not scored, and all else is background; in NAME/Annotations all that is not black is an object.
Masks have the names of their frames. A frame may lack one; the first and the last frame are not scored.

Per clip, means over its scored frames; all labels other than 0 are foreground:
  J              region similarity (intersection over union); in a frame without any object, 1 less the share that is labelled
  F              boundary measure of DAVIS 2016, over frames with an object, as the next two
  best           J of the one label that has the most of it
  recall         share of the object pixels that have a label
  false          share of the background pixels that have a label
  found          true objects found, of how many: connected pieces of the true masks, followed to the next frame with a mask where they
                 overlap (two that touch once are one; those that never fill 1/2000 of the frame are left out). One is found when labels
                 that are not false have at least half of its pixels
  false objects  labels with most of their pixels in the clip on the background, of how many labels

Below: what was said of pixels to be right (in that they are on an object or are not), and the share that was, in tenths of what was said;
every clip counts alike. Without --window.

The kind of a clip is what stands before -- in its name, or else the name of DIR. With --seeds figures are means over the seeds, and
spread is the largest J less the smallest: of the clip, of the mean over the kind, or of the mean over all.";

#[derive(Args, Debug)]
#[command(after_help = HELP)]
pub(crate) struct MasksArgs {
    #[command(flatten)]
    suite: Suite,
    /// Use the first N frames of each clip, or all where it is shorter
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(3..))]
    frames: Option<u32>,
    /// Take each clip in windows of N frames, as the package and the page take long ones
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..))]
    window: Option<u32>,
    /// Run each clip under each of these seeds
    #[arg(long, value_name = "SEED,...", value_delimiter = ',')]
    seeds: Vec<u32>,
    /// Write every tenth frame into this folder as NAME/%05d.png, masks in colour, true objects outlined in white
    #[arg(long, value_name = "DIR")]
    overlay: Option<PathBuf>,
    /// Write all figures and the parameters to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

pub(super) fn eval(args: &MasksArgs) -> Result<()> {
    let params = args.suite.settings.params()?;
    require_dense(&params)?;
    let clips = args.suite.clips()?;
    let seeds = if args.seeds.is_empty() { vec![params.clip.seed] } else { args.seeds.clone() };
    let several = seeds.len() > 1;
    print(report::heading(several))?;
    let work = |clip: &Clip| run_seeds(clip, &params, &seeds, args);
    let outcomes = in_order(&clips, args.suite.jobs(), work, |o| print(report::row(o)))?;
    let report = Report::new(&outcomes, args.frames, &params);
    report.lines().into_iter().try_for_each(print)?;
    write_json(args.json.as_deref(), &report)
}

fn run_seeds(clip: &Clip, params: &Params, seeds: &[u32], args: &MasksArgs) -> Result<Outcome> {
    let run_one = |(index, &seed): (usize, &u32)| {
        let mut params = params.clone();
        params.clip.seed = seed;
        let overlay = args.overlay.as_deref().filter(|_| index == 0);
        run_clip(clip, args.frames, args.window, params, overlay)
    };
    let runs = seeds.iter().enumerate().map(run_one).collect::<Result<Vec<_>>>();
    let runs = runs.map_err(|failure| failure.with_subject(&clip.name))?;
    Ok(Outcome { name: clip.name.clone(), kind: clip.kind.clone(), runs })
}

/// Runs one clip, whole or in windows of `window` frames, and scores it; with `overlay` also writes pictures into that
/// folder.
pub(super) fn run_clip(
    clip: &Clip,
    frames: Option<u32>,
    window: Option<u32>,
    params: Params,
    overlay: Option<&Path>,
) -> Result<Run> {
    let seed = params.clip.seed;
    let images = clip.frames(frames)?;
    let truth = images.iter().map(|image| clip.truth(image)).collect::<Result<Vec<_>>>()?;
    let input = Input::open(&clip.images, frames)?;
    let mut reliability = Reliability::default();
    let (masks, time) = match window {
        Some(window) => run_windows(&input, params, window as usize)?,
        None => {
            let (session, timing) = run(&input, params, 1, &Log::quiet())?;
            let masks = (0..truth.len()).map(|t| Ok(session.labels(t)?)).collect::<Result<Vec<_>>>()?;
            for t in scored_frames(truth.len()) {
                if let Some(truth) = &truth[t] {
                    reliability.add(&masks[t], &confidence_at_input(&session, t)?, truth)?;
                }
            }
            (masks, timing.total)
        }
    };
    if let Some(folder) = overlay {
        let objects = |t: usize| truth[t].as_ref().map(|mask| mask.map(|kind| kind == Truth::Object));
        let masks_of = |t: usize| Ok((masks[t].clone(), objects(t)));
        write_overlays(folder.join(&clip.name), truth.len(), OVERLAY_STEP, &input, masks_of)?;
    }
    let (mut scorer, mut places) = (ClipScorer::default(), Vec::new());
    for t in scored_frames(truth.len()) {
        if let Some(truth) = &truth[t] {
            scorer.add(&masks[t], truth)?;
            places.push(t);
        }
    }
    let of_frames: Vec<Scored> =
        places.iter().zip(scorer.frames()).map(|(&frame, &scores)| Scored { frame, scores }).collect();
    if of_frames.is_empty() {
        let reason = "has no mask of a frame but the first and the last, which do not count";
        return Err(Failure::about(clip.images.display(), reason));
    }
    let scores = MaskScores::mean_of(scorer.frames());
    Ok(Run { seed, frames: truth.len(), scores, census: scorer.census(), of_frames, time, reliability })
}

/// The masks of all frames of a clip taken in windows of `window` frames, as the package and the page take long ones.
fn run_windows(input: &Input, params: Params, window: usize) -> Result<(Vec<Plane<u8>>, Seconds)> {
    let frames = input.frames()?.collect::<Result<Vec<ClipFrame>>>()?;
    let (clock, count) = (Clock::start(), frames.len());
    let frames = frames.into_iter().map(|frame| Ok::<_, Failure>(frame.frame));
    let overlap = Window::overlap(window);
    let mut windows = Windows::new(params, frames)?.with_window(window, overlap)?.with_length(count);
    let mut masks = Vec::new();
    while let Some(found) = windows.next_window(|_| ()) {
        for t in found?.settled {
            masks.push(windows.session().labels(t)?);
        }
    }
    Ok((masks, clock.seconds()))
}

/// The confidence of each pixel of frame `t` at input size.
fn confidence_at_input(session: &Session, t: usize) -> Result<Plane<f32>> {
    let (sure, (width, height)) = (session.confidence(t)?, session.input_size().unwrap_or_default());
    Ok(Plane::from_fn(width, height, |x, y| sure[(x * sure.width() / width, y * sure.height() / height)]))
}
