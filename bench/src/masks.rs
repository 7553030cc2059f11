//! `bench masks`: clips of many kinds through the pipeline, their masks against the true ones.

use super::batch::{in_order, require_dense, write_json};
use super::clips::{Clip, Suite, write_overlays};
use super::compare::Earlier;
use super::report::{Column, Outcome, RUNS_HELP, Report, Run, Scores, heading};
use super::runs::{Excerpt, RunId, RunOptions};
use crate::measures::agreement::{
    AgreementQuality, DoubtQuality, FAILURE_DROP, FALSE_SHARE, FrameAgreement, RunDoubts,
};
use crate::measures::davis::scored_frames;
use crate::measures::masks::{Census, ClipScorer, MaskScores, Truth};
use clap::Args;
use serde::Serialize;
use std::ops::Range;
use std::path::PathBuf;
use tracecut::image::Plane;
use tracecut::mask::Agreement;
use tracecut::{Params, Window, Windows};
use tracecut_cli::failure::{Failure, Result, print};
use tracecut_cli::input::ClipFrame;
use tracecut_cli::run::{Clock, Seconds};

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

Below: Spearman's rank correlation of the agreement of masks in time with J, as a mean over the runs and over
all frames, the share of the frames with a J far below their run's median whose agreement tells, and how many of them are in a doubt. All
without --window.";

#[derive(Args, Debug)]
#[command(after_help = format!("{HELP}\n\n{RUNS_HELP}"))]
pub(crate) struct MasksArgs {
    #[command(flatten)]
    suite: Suite,
    /// Use N frames from each start, or all where there are fewer
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(3..))]
    frames: Option<u32>,
    /// Take each clip in windows of N frames, as the package and the page take long ones
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..))]
    window: Option<u32>,
    #[command(flatten)]
    runs: RunOptions,
    /// Write every tenth frame into this folder as NAME/%05d.png, masks in colour, true objects outlined in white
    #[arg(long, value_name = "DIR")]
    overlay: Option<PathBuf>,
    /// Write all figures and the parameters to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Compare with the figures that an earlier --json of this command wrote
    #[arg(long, value_name = "FILE")]
    compare: Option<PathBuf>,
}

/// The scores of a run.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct MaskRun {
    #[serde(flatten)]
    scores: MaskScores,
    #[serde(flatten)]
    census: Census,
    /// Frame by frame: its index and its scores.
    of_frames: Vec<Scored>,
    /// Frames whose masks should be looked at; empty in windows.
    doubts: Vec<Range<usize>>,
}

#[derive(Debug, Serialize)]
struct Scored {
    frame: usize,
    #[serde(flatten)]
    scores: MaskScores,
    /// Agreement with nearby frames; `null` in windows.
    agreement: Option<f32>,
}

/// The content of the file of `--json`.
#[derive(Serialize)]
struct MaskReport<'a> {
    #[serde(flatten)]
    report: &'a Report<'a, MaskRun>,
    /// How well the agreement of masks predicts J; `null` in windows.
    agreement: Option<AgreementQuality>,
    /// How well doubts find frames with a low J; `null` in windows.
    doubts: Option<DoubtQuality>,
}

const fn column(name: &'static str, heading: &'static str) -> Column {
    Column { name, heading, width: 7, decimals: 3, has_error: false }
}

impl Scores for MaskRun {
    const COLUMNS: &'static [Column] = &[
        Column { has_error: true, ..column("j", "J") },
        column("f", "F"),
        column("best", "best"),
        column("recall", "recall"),
        column("falseShare", "false"),
    ];
    const HEAD_WIDTH: usize = 43;
    /// Chosen by eye.
    const LARGE_CHANGE: f64 = 0.05;

    fn values(&self) -> Vec<Option<f64>> {
        let MaskScores { j, f, best, recall, false_share } = self.scores;
        vec![j, f, best, recall, false_share]
    }
}

pub(super) fn eval(args: &MasksArgs) -> Result<()> {
    let params = args.suite.settings.params()?;
    require_dense(&params)?;
    let clips = args.suite.clips()?;
    let seeds = args.runs.seeds(&[params.clip.seed]);
    let work = |clip: &Clip| run_clip(clip, &params, &seeds, args).map_err(|f| f.with_subject(&clip.name));
    let earlier = Earlier::read(args.compare.as_deref(), args.frames)?;
    if let Some(earlier) = &earlier {
        for clip in &clips {
            earlier.require(&clip.kind, &clip.name, &args.runs.clip_excerpts(clip, args.frames)?, &seeds)?;
        }
    }
    let with_errors = args.runs.are_several(&seeds);
    let head = format!("{:28} frames labels  ", "clip");
    print(format_args!("{head}{}   found  false objects  seconds", heading::<MaskRun>(with_errors)))?;
    let outcomes = in_order(&clips, args.suite.jobs(), work, |o| print(row(o, with_errors)))?;
    let report = Report::new(&outcomes, args.frames, &params);
    print("")?;
    report.lines(with_errors).into_iter().try_for_each(print)?;
    let runs = || outcomes.iter().flat_map(|outcome| &outcome.runs);
    let sum = |count: fn(&Census) -> usize| runs().map(|run| count(&run.scores.census)).sum::<usize>();
    print(format_args!(
        "in all {} of {} objects found, {} false objects of {} labels, {:.1} s",
        sum(|c| c.found_objects),
        sum(|c| c.true_objects),
        sum(|c| c.false_objects),
        sum(|c| c.labels),
        outcomes.iter().map(Outcome::seconds).sum::<f64>()
    ))?;
    let agreement = agreement_quality(runs().map(|run| run.scores.of_frames.as_slice()));
    agreement.iter().flat_map(agreement_lines).try_for_each(print)?;
    let doubts = agreement.map(|_| doubt_quality(runs().map(|run| &run.scores)));
    doubts.iter().map(doubt_line).try_for_each(print)?;
    earlier.map_or(Ok(Vec::new()), |earlier| earlier.lines(&outcomes))?.into_iter().try_for_each(print)?;
    write_json(args.json.as_deref(), &MaskReport { report: &report, agreement, doubts })
}

/// Runs all excerpts of a clip under all seeds.
fn run_clip(clip: &Clip, params: &Params, seeds: &[u32], args: &MasksArgs) -> Result<Outcome<MaskRun>> {
    let mut runs = Vec::new();
    for excerpt in args.runs.clip_excerpts(clip, args.frames)? {
        let truth = excerpt.truth(clip)?;
        // The first run of the clip is drawn.
        let overlay = args.overlay.as_deref().filter(|_| excerpt.start == 0 && !excerpt.mirrored);
        let drawn = |id: RunId| overlay.filter(|_| seeds.first() == Some(&id.seed)).map(|o| o.join(&clip.name));
        if let Some(window) = args.window {
            for &seed in seeds {
                let (masks, time) = run_windows(&excerpt, params, seed, window as usize)?;
                let id = excerpt.run_id(seed);
                write_pictures(drawn(id), &excerpt, &masks, &truth)?;
                runs.push(score(id, &masks, &truth, Unsupervised::default(), time)?);
            }
            continue;
        }
        runs.extend(excerpt.run_seeds(params, seeds, |session, id, time| {
            let masks = (0..truth.len()).map(|t| Ok(session.labels(t)?)).collect::<Result<Vec<_>>>()?;
            let found = session.agreement();
            let agreement = found.map_or_else(Vec::new, |agreement| agreement.frames.clone());
            let doubts = found.map_or_else(Vec::new, Agreement::doubts);
            write_pictures(drawn(id), &excerpt, &masks, &truth)?;
            score(id, &masks, &truth, Unsupervised { agreement, doubts }, time)
        })?);
    }
    Ok(Outcome::new(&clip.name, &clip.kind, runs))
}

/// Writes every tenth frame into `folder`, if there is one.
fn write_pictures(
    folder: Option<PathBuf>,
    excerpt: &Excerpt,
    masks: &[Plane<u8>],
    truth: &[Option<Plane<Truth>>],
) -> Result<()> {
    let Some(folder) = folder else { return Ok(()) };
    let objects = |t: usize| truth[t].as_ref().map(|mask| mask.map(|kind| kind == Truth::Object));
    write_overlays(folder, truth.len(), OVERLAY_STEP, excerpt.frames(), |t| Ok((masks[t].clone(), objects(t))))
}

/// What a session said of its masks; empty in windows.
#[derive(Debug, Default)]
struct Unsupervised {
    /// Agreement with nearby frames, frame by frame.
    agreement: Vec<Option<f32>>,
    doubts: Vec<Range<usize>>,
}

/// Scores the masks of a run.
fn score(
    id: RunId,
    masks: &[Plane<u8>],
    truth: &[Option<Plane<Truth>>],
    said: Unsupervised,
    time: Seconds,
) -> Result<Run<MaskRun>> {
    let (mut scorer, mut places) = (ClipScorer::default(), Vec::new());
    for t in scored_frames(truth.len()) {
        if let Some(truth) = &truth[t] {
            scorer.add(&masks[t], truth)?;
            places.push(t);
        }
    }
    let agreement = |frame: usize| said.agreement.get(frame).copied().flatten();
    let scored = |(&frame, &scores): (&usize, &MaskScores)| Scored { frame, scores, agreement: agreement(frame) };
    let of_frames: Vec<Scored> = places.iter().zip(scorer.frames()).map(scored).collect();
    if of_frames.is_empty() {
        return Err(Failure::input("has no mask of a frame but the first and the last, which do not count"));
    }
    let scores = MaskScores::mean_of(scorer.frames());
    let scores = MaskRun { scores, census: scorer.census(), of_frames, doubts: said.doubts };
    Ok(Run { id, frames: truth.len(), scores, time })
}

/// The masks of all frames of a clip taken in windows of `window` frames, as the package and the page take long ones.
fn run_windows(excerpt: &Excerpt, params: &Params, seed: u32, window: usize) -> Result<(Vec<Plane<u8>>, Seconds)> {
    let mut params = params.clone();
    params.clip.seed = seed;
    let frames = excerpt.frames().collect::<Result<Vec<ClipFrame>>>()?;
    let clock = Clock::start();
    let frames = frames.into_iter().map(|frame| Ok::<_, Failure>(frame.frame));
    let overlap = Window::overlap(window);
    let mut windows = Windows::new(params, frames)?.with_window(window, overlap)?;
    let mut masks = Vec::new();
    while let Some(found) = windows.next_window(|_| ()) {
        for t in found?.settled {
            masks.push(windows.session().labels(t)?);
        }
    }
    Ok((masks, clock.seconds()))
}

/// Formats the row of a clip, with the counts of its first run.
fn row(outcome: &Outcome<MaskRun>, with_errors: bool) -> String {
    let (frames, census) = outcome.runs.first().map(|r| (r.frames, r.scores.census)).unwrap_or_default();
    let objects = format!("{}/{}", census.found_objects, census.true_objects);
    let wrong = format!("{}/{}", census.false_objects, census.labels);
    let head = format!("{:29} {frames:5} {:6} ", outcome.name, census.labels);
    outcome.row(&head, &format!(" {objects:>7} {wrong:>14} {:8.1}", outcome.seconds()), with_errors)
}

/// Compares the agreement of masks with J; `None` in windows.
fn agreement_quality<'a>(runs: impl Iterator<Item = &'a [Scored]>) -> Option<AgreementQuality> {
    let frame = |scored: &Scored| Some(FrameAgreement { agreement: f64::from(scored.agreement?), j: scored.scores.j? });
    let runs: Vec<Vec<FrameAgreement>> = runs.map(|frames| frames.iter().filter_map(frame).collect()).collect();
    Some(AgreementQuality::of_runs(&runs)).filter(|quality| quality.frames > 0)
}

/// Compares the doubts with J.
fn doubt_quality<'a>(runs: impl Iterator<Item = &'a MaskRun>) -> DoubtQuality {
    let j = |scored: &Scored| Some((scored.frame, scored.scores.j?));
    let run = |run: &MaskRun| RunDoubts { doubts: run.doubts.clone(), j: run.of_frames.iter().filter_map(j).collect() };
    DoubtQuality::of_runs(&runs.map(run).collect::<Vec<_>>())
}

/// Formats how well doubts find frames with a low J.
fn doubt_line(quality: &DoubtQuality) -> String {
    let DoubtQuality { failures, found, false_doubts, frames } = *quality;
    let rate = 100.0 * false_doubts as f64 / frames.max(1) as f64;
    format!("doubts have {found} of these {failures}; without any: {false_doubts}, {rate:.2} in 100 frames")
}

/// Formats how well the agreement of masks predicts J.
fn agreement_lines(quality: &AgreementQuality) -> Vec<String> {
    let three = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.3}"));
    let AgreementQuality { correlation_in_runs, correlation, frames, failures, found } = *quality;
    vec![
        String::new(),
        "agreement in time".to_owned(),
        format!(
            "rank correlation with J: in runs {}, over all {frames} frames {}",
            three(correlation_in_runs),
            three(correlation)
        ),
        format!(
            "frames with a J {FAILURE_DROP} below the median: {failures}; found at a false alarm rate of {FALSE_SHARE}: {}",
            three(found)
        ),
    ]
}
