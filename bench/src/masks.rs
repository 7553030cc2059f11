//! `bench masks`: clips of many kinds through the pipeline, their masks against the true ones.

use super::batch::{in_order, require_dense, write_json};
use super::clips::{Clip, Suite, write_overlays};
use super::compare::Earlier;
use super::report::{Column, Outcome, RUNS_HELP, Report, Run, Scores, heading};
use super::runs::{Excerpt, RunId, RunOptions};
use crate::measures::agreement::{
    AgreementQuality, DoubtQuality, FAILURE_DROP, FAILURE_J, FALSE_SHARE, FrameAgreement,
};
use crate::measures::davis::scored_frames;
use crate::measures::expected_j::{JudgedRun, kinds, left_out, weights};
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
all frames, and the share of the frames with a J far below their run's median whose agreement tells. Then the correlation of the expected J,
and how many failures, frames with such a J or one below .5, are in a doubt: of the masks, and of each kind by weights of the expected J that
were fitted on the other kinds. All without --window.";

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
    /// Its agreement and the terms of the expected J; `None` in windows.
    #[serde(skip)]
    judged: Option<JudgedRun>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Scored {
    frame: usize,
    #[serde(flatten)]
    scores: MaskScores,
    /// Agreement with nearby frames; `null` in windows.
    agreement: Option<f32>,
    /// Expected J; `null` in windows, and if the frame is not judged.
    expected_j: Option<f32>,
}

/// The content of the file of `--json`.
#[derive(Serialize)]
struct MaskReport<'a> {
    #[serde(flatten)]
    report: &'a Report<'a, MaskRun>,
    /// How well the agreement of masks predicts J; `null` in windows.
    agreement: Option<AgreementQuality>,
    /// How well the expected J predicts J; `null` in windows.
    #[serde(rename = "expectedJ")]
    expected_j: Option<AgreementQuality>,
    /// How well doubts find failures; `null` in windows.
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
    let judged: Vec<JudgedRun> = runs().filter_map(|run| run.scores.judged.clone()).collect();
    let (expected_j, doubts) =
        (agreement.map(|_| expectation_quality(&judged)), agreement.map(|_| doubt_quality(&judged)));
    if agreement.is_some() {
        expected_j_lines(&judged).into_iter().try_for_each(print)?;
    }
    earlier.map_or(Ok(Vec::new()), |earlier| earlier.lines(&outcomes))?.into_iter().try_for_each(print)?;
    write_json(args.json.as_deref(), &MaskReport { report: &report, agreement, expected_j, doubts })
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
                runs.push(score(id, &masks, &truth, None, time)?);
            }
            continue;
        }
        runs.extend(excerpt.run_seeds(params, seeds, |session, id, time| {
            let masks = (0..truth.len()).map(|t| Ok(session.labels(t)?)).collect::<Result<Vec<_>>>()?;
            let judged = session.agreement().cloned().zip(session.expected_j_terms());
            let kind = clip.kind.clone();
            let judged = judged.map(|(agreement, terms)| JudgedRun { kind, agreement, terms, j: Vec::new() });
            write_pictures(drawn(id), &excerpt, &masks, &truth)?;
            score(id, &masks, &truth, judged, time)
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

/// Scores the masks of a run; `judged` is `None` in windows.
fn score(
    id: RunId,
    masks: &[Plane<u8>],
    truth: &[Option<Plane<Truth>>],
    mut judged: Option<JudgedRun>,
    time: Seconds,
) -> Result<Run<MaskRun>> {
    let (mut scorer, mut places) = (ClipScorer::default(), Vec::new());
    for t in scored_frames(truth.len()) {
        if let Some(truth) = &truth[t] {
            scorer.add(&masks[t], truth)?;
            places.push(t);
        }
    }
    let agreement = judged.as_ref().map(|run| &run.agreement);
    let value = |values: Option<&Vec<Option<f32>>>, frame: usize| values?.get(frame).copied().flatten();
    let scored = |(&frame, &scores): (&usize, &MaskScores)| Scored {
        frame,
        scores,
        agreement: value(agreement.map(|a| &a.frames), frame),
        expected_j: value(agreement.map(|a| &a.expected_j), frame),
    };
    let of_frames: Vec<Scored> = places.iter().zip(scorer.frames()).map(scored).collect();
    if of_frames.is_empty() {
        return Err(Failure::input("has no mask of a frame but the first and the last, which do not count"));
    }
    let doubts = agreement.map_or_else(Vec::new, Agreement::doubts);
    if let Some(run) = &mut judged {
        run.j = of_frames.iter().filter_map(|scored| Some((scored.frame, scored.scores.j?))).collect();
    }
    let scores = MaskScores::mean_of(scorer.frames());
    let scores = MaskRun { scores, census: scorer.census(), of_frames, doubts, judged };
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

/// Compares the expected J with J.
fn expectation_quality(runs: &[JudgedRun]) -> AgreementQuality {
    AgreementQuality::of_runs(&runs.iter().map(JudgedRun::expectations).collect::<Vec<_>>())
}

/// Compares the doubts with J.
fn doubt_quality<'a>(runs: impl IntoIterator<Item = &'a JudgedRun>) -> DoubtQuality {
    DoubtQuality::of_runs(&runs.into_iter().map(JudgedRun::doubts).collect::<Vec<_>>())
}

/// Formats how well doubts find failures.
fn doubt_line(quality: &DoubtQuality) -> String {
    let DoubtQuality { failures, found, unjudged, false_doubts, false_frames, frames } = *quality;
    let rate = |count: usize| 100.0 * count as f64 / frames.max(1) as f64;
    format!(
        "doubts have {found} of {failures} failures, {unjudged} are not judged; without any: {false_doubts} doubts, {:.2} in 100 \
         frames; {:.1} % of the frames are in a doubt and no failure",
        rate(false_doubts),
        rate(false_frames)
    )
}

/// Formats how well J is expected, also on kinds of clips that were left out, and the weights fitted on all.
fn expected_j_lines(runs: &[JudgedRun]) -> Vec<String> {
    let summary =
        |runs: &[JudgedRun]| vec![correlation_line(&expectation_quality(runs)), doubt_line(&doubt_quality(runs))];
    let mut lines = vec![String::new(), format!("expected J; a failure has such a J, or one below {FAILURE_J}")];
    lines.extend(summary(runs));
    let left_out = left_out(runs);
    if !left_out.is_empty() {
        lines.push("each kind by weights fitted on the others".to_owned());
        lines.extend(summary(&left_out));
        let of_kind = |kind: &String| doubt_quality(left_out.iter().filter(|run| run.kind == *kind));
        lines.extend(kinds(runs).iter().map(|kind| format!("{kind:12} {}", doubt_line(&of_kind(kind)))));
        let weights: Vec<String> = weights(runs, None).iter().map(|weight| format!("{weight:.4}")).collect();
        lines.push(format!("weights fitted on all: [{}]", weights.join(", ")));
    }
    lines
}

/// Formats rank correlations with J.
fn correlation_line(quality: &AgreementQuality) -> String {
    let AgreementQuality { correlation_in_runs, correlation, frames, .. } = *quality;
    let [in_runs, all] = [correlation_in_runs, correlation].map(three);
    format!("rank correlation with J: in runs {in_runs}, over all {frames} frames {all}")
}

fn three(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.3}"))
}

/// Formats how well the agreement of masks predicts J.
fn agreement_lines(quality: &AgreementQuality) -> Vec<String> {
    let AgreementQuality { failures, found, .. } = *quality;
    vec![
        String::new(),
        "agreement in time".to_owned(),
        correlation_line(quality),
        format!(
            "frames with a J {FAILURE_DROP} below the median: {failures}; found at a false alarm rate of {FALSE_SHARE}: {}",
            three(found)
        ),
    ]
}
