//! `bench davis`: every sequence of a folder through the pipeline, its masks against the true ones, also at the size of the
//! frames and beside figures that others published.

use super::batch::{Batch, require_dense, write_json};
use super::clips::{Clip, davis_clips, write_overlays};
use super::moseg::num_clusters;
use crate::measures::davis::{
    LabelTally, Summary, boundary_measure, boundary_measure_within, region_similarity, scored_frames,
};
use crate::measures::masks::Truth;
use clap::Args;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use tracecut::image::Plane;
use tracecut::mask::enlarge;
use tracecut::{Params, Session};
use tracecut_cli::failure::{Failure, Result, print, read_text};
use tracecut_cli::input::{ClipFrame, Input, decode};
use tracecut_cli::log::Log;
use tracecut_cli::run::{Clock, Seconds, run};

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
    /// Write every N-th frame of the overlays
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..))]
    overlay_step: u32,
    /// Also score masks brought to the size of the frames with their pictures
    #[arg(long)]
    at_source: bool,
    #[command(flatten)]
    batch: Batch,
}

/// The scores of one sequence.
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

/// The content of the file of `--json`.
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
    let sequences = davis_clips(&args.folder, &args.batch.only)?;
    let published = Published::beside(&args.folder)?;
    let more = if args.at_source { SOURCE_HEADING } else { "" };
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
        at_source: at_source.map(|rows| AtSource::mean_of(&rows)),
    }
}

fn run_sequence(clip: &Clip, params: &Params, args: &DavisArgs) -> Result<Outcome> {
    let truth = truth_of(clip, args.frames)?;
    let input = Input::open(&clip.images, args.frames)?;
    let (session, timing) = run(&input, params.clone(), 1, &Log::quiet())?;
    if let Some(folder) = &args.overlay {
        let masks_of = |t: usize| Ok((session.labels(t)?, Some(truth[t].clone())));
        write_overlays(folder.join(&clip.name), truth.len(), args.overlay_step as usize, input.frames()?, masks_of)?;
    }
    let mut outcome = score(&session, &truth)?;
    if args.at_source {
        outcome.at_source = Some(AtSource::score(&session, &input, &truth)?);
    }
    outcome.name.clone_from(&clip.name);
    outcome.time = timing.total;
    Ok(outcome)
}

/// The true masks of the first `frames` frames of a clip, or of all; every frame has one, of its size.
fn truth_of(clip: &Clip, frames: Option<u32>) -> Result<Vec<Plane<bool>>> {
    let images = clip.frames(frames)?;
    if scored_frames(images.len()).is_empty() {
        let reason = format!("holds {} images (expected at least 3, as the first and last do not count)", images.len());
        return Err(Failure::about(clip.images.display(), reason));
    }
    let first = decode(&images[0])?;
    let mask_of = |image: &Path| {
        let wrong = |reason: String| Failure::about(clip.mask_path(image).display(), reason);
        let missing = || wrong(format!("is missing (expected the true mask of {})", image.display()));
        let mask = clip.truth(image)?.ok_or_else(missing)?;
        let (size, expected) = ((mask.width(), mask.height()), (first.width(), first.height()));
        if size != expected {
            let ((width, height), (w, h)) = (size, expected);
            return Err(wrong(format!("is {width}x{height} (expected {w}x{h}, as the frames are)")));
        }
        Ok(mask.map(|kind| kind == Truth::Object))
    };
    images.iter().map(|image| mask_of(image)).collect()
}

fn score(session: &Session, truth: &[Plane<bool>]) -> Result<Outcome> {
    let mut tally = LabelTally::new(num_clusters(session));
    for (t, truth) in truth.iter().enumerate() {
        tally.add(&session.cluster_labels(t)?, truth)?;
    }
    let foreground = tally.oracle_foreground();
    let (mut j, mut f, mut oracle) = (Vec::new(), Vec::new(), Vec::new());
    for t in scored_frames(truth.len()) {
        let mask = session.labels(t)?.map(|label| label != 0);
        let oracle_mask = session.cluster_labels(t)?.map(|cluster| foreground[cluster as usize]);
        j.push(region_similarity(&mask, &truth[t])?);
        f.push(boundary_measure(&mask, &truth[t])?);
        oracle.push(region_similarity(&oracle_mask, &truth[t])?);
    }
    Ok(Outcome {
        name: String::new(),
        frames: truth.len(),
        objects: session.objects().map_or(0, |o| o.highest_label),
        j: Summary::new(&j),
        f: Summary::new(&f),
        oracle_j: Summary::new(&oracle),
        at_source: None,
        j_of_frames: j,
        f_of_frames: f,
        time: Seconds::default(),
    })
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

/// Boundaries of the fine measure match within this many pixels: the benchmark's own tolerance is wider than the pixels of
/// a mask at half the size.
const FINE_PX: usize = 1;

const SOURCE_HEADING: &str = "  J near   large  F near   large  F1 near  large  ms a frame";

/// Means over the scored frames, of the nearest pixel's label and of enlarged masks.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct AtSource {
    j: Enlarging,
    f: Enlarging,
    /// F within one pixel.
    fine_f: Enlarging,
    /// Milliseconds that enlarging took, a frame.
    milliseconds: f64,
}

#[derive(Debug, Default, Clone, Copy, Serialize)]
struct Enlarging {
    nearest: f64,
    enlarged: f64,
}

fn fine_measure(mask: &Plane<bool>, truth: &Plane<bool>) -> std::result::Result<f64, tracecut::Error> {
    boundary_measure_within(FINE_PX, mask, truth)
}

impl AtSource {
    fn score(session: &Session, input: &Input, truth: &[Plane<bool>]) -> Result<Self> {
        let scored = scored_frames(truth.len());
        let mut sums = [Enlarging::default(); 3];
        let mut seconds = 0.0;
        for (t, frame) in input.frames()?.enumerate().take(scored.end).skip(scored.start) {
            let ClipFrame { name, frame, .. } = frame?;
            let nearest = session.labels(t)?.map(|label| label != 0);
            let clock = Clock::start();
            let enlarged = enlarge(session.working_labels(t)?, &frame, |label| label != 0);
            seconds += clock.seconds().best();
            let enlarged = enlarged.map_err(|e| Failure::about(name, e))?.labels.map(|label| label != 0);
            let measures = [region_similarity, boundary_measure, fine_measure];
            for (sum, measure) in sums.iter_mut().zip(measures) {
                sum.nearest += measure(&nearest, &truth[t])?;
                sum.enlarged += measure(&enlarged, &truth[t])?;
            }
        }
        let count = scored.len() as f64;
        let [j, f, fine_f] = sums.map(|s| Enlarging { nearest: s.nearest / count, enlarged: s.enlarged / count });
        Ok(Self { j, f, fine_f, milliseconds: 1000.0 * seconds / count })
    }

    fn mean_of(rows: &[&Self]) -> Self {
        let mean = |value: &dyn Fn(&Self) -> f64| rows.iter().map(|row| value(row)).sum::<f64>() / rows.len() as f64;
        let pair = |value: fn(&Self) -> Enlarging| Enlarging {
            nearest: mean(&|row| value(row).nearest),
            enlarged: mean(&|row| value(row).enlarged),
        };
        Self {
            j: pair(|row| row.j),
            f: pair(|row| row.f),
            fine_f: pair(|row| row.fine_f),
            milliseconds: mean(&|row| row.milliseconds),
        }
    }

    fn columns(&self) -> String {
        let pair = |p: Enlarging| format!("{:8.4}{:8.4}", p.nearest, p.enlarged);
        format!("{}{}{} {:11.1}", pair(self.j), pair(self.f), pair(self.fine_f), self.milliseconds)
    }
}

/// The paper's own program.
const PAPER: &str = "trc";
/// Methods on the benchmark's site that use no trained part: trc and msg trace trajectories (this paper; Ochs and
/// Brox), fst is by Papazoglou and Ferrari, nlc by Faktor and Irani, cvos by Taylor et al., key by Lee et al., sal by
/// Wang et al., tis by Griffin and Corso.
const UNLEARNED: [&str; 8] = ["trc", "msg", "fst", "nlc", "cvos", "key", "sal", "tis"];

/// J and F of one method on one sequence.
type Figures = [f64; 2];

/// The figures of each method, sequence by sequence; empty where there is no file.
#[derive(Debug, Default)]
struct Published(BTreeMap<String, BTreeMap<String, Figures>>);

impl Published {
    /// Reads `published.json` in `folder`, if there.
    fn beside(folder: &Path) -> Result<Self> {
        let path = folder.join("published.json");
        if !path.is_file() {
            return Ok(Self::default());
        }
        let methods = serde_json::from_str(&read_text(&path)?).map_err(|e| {
            Failure::about(path.display(), format_args!("is not {{\"method\": {{\"sequence\": [J, F]}}}}: {e}"))
        })?;
        Ok(Self(methods))
    }

    fn heading(&self) -> &'static str {
        if self.0.is_empty() { "" } else { "  | trc J  trc F  best J  best F" }
    }

    /// The paper's figures on a sequence, and the figures of the unlearned method with the best J.
    fn columns(&self, sequence: &str) -> String {
        if self.0.is_empty() {
            return String::new();
        }
        let (best, name) = match self.best(sequence) {
            Some((name, pair)) => (Some(pair), name),
            None => (None, ""),
        };
        figure_columns(self.figures(PAPER, sequence), best, name)
    }

    /// The means of these columns over the `sequences` that have them.
    fn mean_columns(&self, sequences: &[&str]) -> String {
        if self.0.is_empty() {
            return String::new();
        }
        let paper: Vec<Figures> = sequences.iter().filter_map(|s| self.figures(PAPER, s)).collect();
        let best: Vec<Figures> = sequences.iter().filter_map(|s| self.best(s)).map(|(_, pair)| pair).collect();
        figure_columns(mean_figures(&paper), mean_figures(&best), "")
    }

    /// A line for each method that has figures on all of `sequences`: its means, best J first.
    fn table(&self, sequences: &[&str]) -> Vec<String> {
        let mut rows: Vec<(&str, Figures)> = Vec::new();
        for (name, figures) in &self.0 {
            let figures: Option<Vec<Figures>> = sequences.iter().map(|&s| figures.get(s).copied()).collect();
            rows.extend(figures.and_then(|figures| mean_figures(&figures)).map(|mean| (name.as_str(), mean)));
        }
        rows.sort_by(|a, b| b.1[0].total_cmp(&a.1[0]));
        let line = |(name, [j, f]): &(&str, Figures)| {
            let note = if UNLEARNED.contains(name) { "" } else { "  with learned parts, or not known" };
            format!("  {name:8} J {j:.3}  F {f:.3}{note}")
        };
        let heading = format!("\npublished means over the same {} sequence(s), whole clips:", sequences.len());
        if rows.is_empty() { Vec::new() } else { std::iter::once(heading).chain(rows.iter().map(line)).collect() }
    }

    fn figures(&self, method: &str, sequence: &str) -> Option<Figures> {
        self.0.get(method)?.get(sequence).copied()
    }

    fn best(&self, sequence: &str) -> Option<(&'static str, Figures)> {
        let candidates = UNLEARNED.iter().filter_map(|&name| Some((name, self.figures(name, sequence)?)));
        candidates.max_by(|a, b| a.1[0].total_cmp(&b.1[0]))
    }
}

fn mean_figures(pairs: &[Figures]) -> Option<Figures> {
    let over = |c: usize| pairs.iter().map(|p| p[c]).sum::<f64>() / pairs.len() as f64;
    (!pairs.is_empty()).then(|| [over(0), over(1)])
}

fn figure_columns(paper: Option<Figures>, best: Option<Figures>, name: &str) -> String {
    let number = |pair: Option<Figures>, c: usize| pair.map_or_else(|| "-".to_owned(), |p| format!("{:.3}", p[c]));
    let line = format!(
        "  | {:>5}  {:>5}  {:>6}  {:>6}  {name}",
        number(paper, 0),
        number(paper, 1),
        number(best, 0),
        number(best, 1)
    );
    line.trim_end().to_owned()
}
