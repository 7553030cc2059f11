//! `bench davis`: every sequence of a folder through the pipeline, its masks against the true ones.

pub(super) mod folder;
mod published;
mod source;

use super::batch::{Batch, require_dense, write_json};
use super::shot::num_clusters;
use crate::measures::davis::{LabelTally, Summary, boundary, boundary_measure, region_similarity, scored_frames};
use clap::Args;
use folder::{Sequence, find_sequences};
use published::Published;
use serde::Serialize;
use source::AtSource;
use std::path::PathBuf;
use tracecut::image::Plane;
use tracecut::{Params, Session};
use tracecut_cli::clock::Seconds;
use tracecut_cli::failure::{Result, print};
use tracecut_cli::input::Input;
use tracecut_cli::log::Log;
use tracecut_cli::masks::tinted;
use tracecut_cli::pictures::{Pixels, Series};
use tracecut_cli::run::run;

/// The truth's outline in overlays.
const OUTLINE: [u8; 3] = [255, 255, 255];

const HELP: &str = "\
J is region similarity (intersection over union), F boundary measure, both 0 to 1, over all frames but the first and the last.
Recall is the share of frames above 0.5, decay the mean over the first quarter of the frames minus the mean over the last.

Foreground are all labels other than 0: nothing of the truth is used. Only the column \"oracle J\" uses it, to tell wrong clusters from
a wrong choice of objects among them: there a cluster is foreground if more than half of its pixels in the clip truly are.

With --at-source follow J, F, and F where boundaries have to be within one pixel, each of the masks as above and of those that were
enlarged with the pictures; they differ only for frames that are processed at a smaller size (--set clip.maxSide=480).

Beside these stand the figures of DIR/published.json where there is one, {\"method\": {\"sequence\": [J, F]}}: those of trc, the
paper's own program, and of the method without learning that has the best J on the sequence.";

#[derive(Args, Debug)]
#[command(after_help = HELP)]
pub(crate) struct DavisArgs {
    /// Folder with NAME/JPEGImages and NAME/Annotations, or with JPEGImages/480p/NAME and Annotations/480p/NAME
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Use the first N frames of each sequence, or all where it is shorter
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(3..))]
    frames: Option<u32>,
    /// Write frames into this folder as NAME/%05d.png, masks in colour, the true mask outlined in white
    #[arg(long, value_name = "DIR")]
    overlay: Option<PathBuf>,
    /// Of the overlays write every N-th
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..))]
    overlay_step: u32,
    /// Also score masks brought to the size of the frames with their pictures
    #[arg(long)]
    at_source: bool,
    #[command(flatten)]
    batch: Batch,
}

/// What came of one sequence.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Outcome {
    name: String,
    frames: usize,
    objects: usize,
    j: Summary,
    f: Summary,
    oracle_j: Summary,
    /// With `--at-source`.
    #[serde(skip_serializing_if = "Option::is_none")]
    at_source: Option<AtSource>,
    /// Frame by frame, from the second to the last but one.
    j_of_frames: Vec<f64>,
    f_of_frames: Vec<f64>,
    /// Shown is processor time where known: sequences run side by side.
    #[serde(flatten)]
    time: Seconds,
}

/// What goes into the file of `--json`.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Report<'a> {
    frames: Option<u32>,
    sequences: &'a [Outcome],
    mean: Means,
    params: &'a Params,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Means {
    j: Summary,
    f: Summary,
    oracle_j: Summary,
    #[serde(skip_serializing_if = "Option::is_none")]
    at_source: Option<AtSource>,
}

pub(super) fn eval(args: &DavisArgs) -> Result<()> {
    let params = args.batch.settings.params()?;
    require_dense(&params)?;
    let sequences = find_sequences(&args.folder, &args.batch.only)?;
    let published = Published::beside(&args.folder)?;
    let more = if args.at_source { source::HEADING } else { "" };
    print(format_args!("{HEADING}{more}{}", published.heading()))?;
    let report = |o: &Outcome| print(format_args!("{}{}", row(o), published.columns(&o.name)));
    let outcomes = args.batch.run(&sequences, |s| &s.name, |s| run_sequence(s, &params, args), report)?;
    let mean = means(&outcomes);
    let names: Vec<&str> = outcomes.iter().map(|o| o.name.as_str()).collect();
    let seconds: f64 = outcomes.iter().map(|o| o.time.best()).sum();
    let title = format!("mean of {}", outcomes.len());
    let columns = score_columns(&mean.j, &mean.f, &mean.oracle_j);
    let more = mean.at_source.as_ref().map(AtSource::columns).unwrap_or_default();
    print(format_args!("{title:31}{columns} {seconds:8.1}{more}{}", published.mean_columns(&names)))?;
    published.table(&names).iter().try_for_each(print)?;
    let report = Report { frames: args.frames, sequences: &outcomes, mean, params: &params };
    write_json(args.batch.json.as_deref(), &report)
}

fn means(outcomes: &[Outcome]) -> Means {
    let over = |value: fn(&Outcome) -> Summary| Summary::mean_of(&outcomes.iter().map(value).collect::<Vec<_>>());
    let at_source = outcomes.iter().map(|o| o.at_source.as_ref()).collect::<Option<Vec<_>>>();
    Means {
        j: over(|o| o.j),
        f: over(|o| o.f),
        oracle_j: over(|o| o.oracle_j),
        at_source: at_source.map(|all| AtSource::mean_of(&all)),
    }
}

fn run_sequence(sequence: &Sequence, params: &Params, args: &DavisArgs) -> Result<Outcome> {
    let truth = sequence.truth(args.frames)?;
    let input = Input::open(&sequence.images, args.frames)?;
    let (session, timing) = run(&input, params.clone(), 1, &Log::quiet())?;
    if let Some(folder) = &args.overlay {
        write_overlays(folder.join(&sequence.name), args.overlay_step as usize, &input, &session, &truth)?;
    }
    let mut outcome = score(&session, &truth)?;
    if args.at_source {
        outcome.at_source = Some(AtSource::of(&session, &input, &truth)?);
    }
    outcome.name.clone_from(&sequence.name);
    outcome.time = timing.total;
    Ok(outcome)
}

fn score(session: &Session, truth: &[Plane<bool>]) -> Result<Outcome> {
    let mut tally = LabelTally::new(num_clusters(session));
    for (t, truth) in truth.iter().enumerate() {
        tally.add(&session.cluster_labels(t)?, truth)?;
    }
    let chosen = tally.oracle_foreground();
    let (mut j, mut f, mut oracle) = (Vec::new(), Vec::new(), Vec::new());
    for t in scored_frames(truth.len()) {
        let mask = session.labels(t)?.map(|label| label != 0);
        let oracle_mask = session.cluster_labels(t)?.map(|cluster| chosen[cluster as usize]);
        j.push(region_similarity(&mask, &truth[t])?);
        f.push(boundary_measure(&mask, &truth[t])?);
        oracle.push(region_similarity(&oracle_mask, &truth[t])?);
    }
    Ok(Outcome {
        name: String::new(),
        frames: truth.len(),
        objects: session.objects().map_or(0, |o| o.highest_label),
        j: Summary::of(&j),
        f: Summary::of(&f),
        oracle_j: Summary::of(&oracle),
        at_source: None,
        j_of_frames: j,
        f_of_frames: f,
        time: Seconds::default(),
    })
}

fn write_overlays(folder: PathBuf, step: usize, input: &Input, session: &Session, truth: &[Plane<bool>]) -> Result<()> {
    let series = Series::create(folder, truth.len())?;
    for (t, frame) in input.frames()?.enumerate().step_by(step) {
        let frame = frame?.frame;
        let mut rgb = tinted(&frame, &session.labels(t)?);
        paint_lines(&mut rgb, &boundary(&truth[t]), OUTLINE);
        series.write(t, (frame.width(), frame.height()), Pixels::Rgb(&rgb))?;
    }
    Ok(())
}

const HEADING: &str =
    "sequence         frames objects  J mean  recall   decay   F mean  recall   decay  oracle J  seconds";

fn row(o: &Outcome) -> String {
    let head = format!("{:16} {:6} {:7}", o.name, o.frames, o.objects);
    let more = o.at_source.as_ref().map(AtSource::columns).unwrap_or_default();
    format!("{head:31}{} {:8.1}{more}", score_columns(&o.j, &o.f, &o.oracle_j), o.time.best())
}

fn score_columns(j: &Summary, f: &Summary, oracle_j: &Summary) -> String {
    let three = |s: &Summary| format!("{:8.3} {:7.3} {:7.3}", s.mean, s.recall, s.decay);
    format!("{} {} {:9.3}", three(j), three(f), oracle_j.mean)
}

/// Paints the true pixels of `lines` over `rgb`.
pub(super) fn paint_lines(rgb: &mut [u8], lines: &Plane<bool>, colour: [u8; 3]) {
    let on_line = rgb.chunks_exact_mut(3).zip(lines.data()).filter(|(_, line)| **line);
    on_line.for_each(|(pixel, _)| pixel.copy_from_slice(&colour));
}
