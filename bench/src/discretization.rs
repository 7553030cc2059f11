//! `bench discretization`: Figure 10, five discretizations of one embedding over a sweep of thresholds.

use super::batch::{Batch, run_clip, write_json};
use super::moseg::{Sequence, find_sequences};
use super::shot::Shot;
use crate::measures::discretization::{Comparison, Errors, FRAGMENT_SHARE, compare, errors, mean};
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;
use tracecut::connectedness::ConnectednessMode;
use tracecut::discretize::DiscretizeMethod::{self, KMeans, Rotation, RotationMerge};
use tracecut::discretize::{CountRule, DiscretizeParams, cluster_count};
use tracecut::embedding::Embedding;
use tracecut::{Params, Session};
use tracecut_cli::clock::Seconds;
use tracecut_cli::failure::{Failure, Result, print};

#[derive(Args, Debug)]
#[command(after_help = "\
Each sequence is tracked and embedded once, by its motion alone; the five discretizations then share embedding and discontinuities:
  K-means, rot          K-means and eigenvector rotation into K clusters, K being the number of eigenvalues that reach a threshold
  rot-disc              the same rotation, then merging across weak borders (discretize.mergeThreshold)
  K-means-gap, rot-gap  K-means and rotation, K being the place of the first gap between consecutive eigenvalues that reaches a threshold
Two errors are counted on the trajectory points in the labelled frames and averaged over the sequences. Missed: objects, the background
among them, that no cluster matches with an intersection over union above 70 %. Over-segmentation: clusters with at least the share
--fragment-share of the points of the object in which most of their points lie, beyond the first of each object.
K never exceeds --eigenvectors. Curves are compared by their lower envelopes: at a rate of misses the least over-segmentation that any
threshold reaches without missing more. rot-disc is below another where it has less of it, or none at all.")]
pub(crate) struct DiscretizationArgs {
    /// Folder with one sub-folder for each sequence, in the layout of the Moseg benchmark
    folder: PathBuf,
    /// Use the first N frames of each sequence, or all where it is shorter
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Eigenvectors to compute
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u32).range(2..=64))]
    eigenvectors: u32,
    /// Count clusters as fragments from this share of an object's points on, in percent; 0 counts all
    #[arg(long, value_name = "PERCENT", default_value_t = 100.0 * FRAGMENT_SHARE, value_parser = parse_percent)]
    fragment_share: f64,
    #[command(flatten)]
    batch: Batch,
}

const EIGENVALUES: [f64; 16] =
    [0.995, 0.99, 0.98, 0.97, 0.96, 0.94, 0.92, 0.9, 0.87, 0.84, 0.8, 0.75, 0.7, 0.65, 0.6, 0.5];
const GAPS: [f64; 15] = [0.3, 0.2, 0.15, 0.1, 0.08, 0.06, 0.05, 0.04, 0.03, 0.02, 0.015, 0.01, 0.007, 0.005, 0.003];

fn parse_percent(text: &str) -> std::result::Result<f64, String> {
    let value = text.parse().ok().filter(|v| (0.0..=100.0).contains(v));
    value.ok_or_else(|| "expected a number, 0..=100".to_owned())
}

/// The curves in their order: name, method, rule for K.
const CURVES: [(&str, DiscretizeMethod, CountRule); 5] = [
    ("rot-disc", RotationMerge, CountRule::Eigenvalues),
    ("K-means", KMeans, CountRule::Eigenvalues),
    ("rot", Rotation, CountRule::Eigenvalues),
    ("K-means-gap", KMeans, CountRule::Gap),
    ("rot-gap", Rotation, CountRule::Gap),
];

/// One sequence: its eigenvalues, and each method's errors for K = 1, 2, ...
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Outcome {
    name: String,
    trajectories: usize,
    eigenvalues: Vec<f64>,
    rotation_merge: Vec<Errors>,
    k_means: Vec<Errors>,
    rotation: Vec<Errors>,
    #[serde(flatten)]
    time: Seconds,
}

impl Outcome {
    /// K by `rule` at `threshold`, at least 1.
    fn count(&self, rule: CountRule, threshold: f64) -> usize {
        let count = match rule {
            CountRule::Gap => {
                let dimensions = self.eigenvalues.len();
                let embedding = Embedding { dimensions, eigenvalues: self.eigenvalues.clone(), ..Embedding::default() };
                let mut params = DiscretizeParams::default();
                params.count = rule;
                params.min_gap = threshold;
                cluster_count(&embedding, &params)
            }
            _ => self.eigenvalues.iter().filter(|&&l| l >= threshold).count(),
        };
        count.clamp(1, self.rotation.len().max(1))
    }

    fn errors(&self, method: DiscretizeMethod, count: usize) -> Errors {
        let of_count = match method {
            KMeans => &self.k_means,
            Rotation => &self.rotation,
            _ => &self.rotation_merge,
        };
        of_count.get(count - 1).copied().unwrap_or_default()
    }
}

/// A curve's averages at one threshold.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(rename_all = "camelCase")]
struct Point {
    threshold: f64,
    mean_count: f64,
    #[serde(flatten)]
    errors: Errors,
}

#[derive(Debug, Serialize)]
struct Curve {
    name: &'static str,
    points: Vec<Point>,
    /// Comparison of rot-disc with this curve.
    #[serde(skip_serializing_if = "Option::is_none")]
    comparison: Option<Comparison>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Report<'a> {
    frames: u32,
    fragment_share: f64,
    curves: &'a [Curve],
    sequences: &'a [Outcome],
    params: &'a Params,
}

pub(super) fn eval(args: &DiscretizationArgs) -> Result<()> {
    let mut params = args.batch.settings.params()?;
    params.clip.dense = false;
    params.connectedness.mode = ConnectednessMode::Off;
    // Every K up to the last is tried, whatever the eigenvalues.
    params.embedding.max_dimensions = args.eigenvectors;
    params.embedding.min_dimensions = args.eigenvectors;
    let sequences = find_sequences(&args.folder, &args.batch.only)?;
    print("sequence      tracks  2nd  6th  12th  last eigenvalue   least over-segmentation of rot-disc   seconds")?;
    let outcomes = args.batch.run(&sequences, |s| &s.name, |s| run_sequence(s, &params, args), print_sequence)?;
    let curves = curves(&outcomes);
    print_table("eigenvalues", "K is the number of eigenvalues of at least", &curves[..3])?;
    print_table("gap", "K is the place of the first gap of at least", &curves[3..])?;
    print_verdict(&curves)?;
    let (frames, fragment_share) = (args.frames, args.fragment_share);
    let report = Report { frames, fragment_share, curves: &curves, sequences: &outcomes, params: &params };
    write_json(args.batch.json.as_deref(), &report)
}

fn run_sequence(sequence: &Sequence, params: &Params, args: &DiscretizationArgs) -> Result<Outcome> {
    let (session, time) = run_clip(&sequence.list, Some(args.frames), params.clone())?;
    let shot = Shot::read(&sequence.definition, 0..session.num_frames())?;
    let embedding = session.embedding().ok_or_else(Failure::missing_result)?;
    let share = args.fragment_share / 100.0;
    let sweep = |method| sweep(&session, &shot, method, share).ok_or_else(Failure::missing_result);
    Ok(Outcome {
        name: sequence.name.clone(),
        trajectories: embedding.num_rows,
        eigenvalues: embedding.eigenvalues.clone(),
        rotation_merge: sweep(RotationMerge)?,
        k_means: sweep(KMeans)?,
        rotation: sweep(Rotation)?,
        time,
    })
}

/// The errors of `method` for each K from 1 to the number of eigenvectors.
fn sweep(session: &Session, shot: &Shot, method: DiscretizeMethod, fragment_share: f64) -> Option<Vec<Errors>> {
    let (tracks, most) = (session.trajectories()?, session.embedding()?.dimensions);
    let frames = shot.definition.labelled_within(session.num_frames()).map(|f| f.index);
    let labelled: Vec<_> = frames.zip(&shot.maps).collect();
    let of_count = |count| {
        let clusters = session.clusters_by(method, count)?;
        Some(errors(&labelled, shot.definition.num_regions(), tracks, &clusters, fragment_share))
    };
    (1..=most.max(1)).map(of_count).collect()
}

/// The five curves, averaged over the sequences.
fn curves(outcomes: &[Outcome]) -> Vec<Curve> {
    let averages = |method, rule, thresholds: &[f64]| -> Vec<Point> {
        let at = |&threshold: &f64| {
            let counts: Vec<usize> = outcomes.iter().map(|o| o.count(rule, threshold)).collect();
            let errors: Vec<Errors> = outcomes.iter().zip(&counts).map(|(o, &k)| o.errors(method, k)).collect();
            let mean_count = counts.iter().sum::<usize>() as f64 / counts.len().max(1) as f64;
            Point { threshold, mean_count, errors: mean(&errors) }
        };
        thresholds.iter().map(at).collect()
    };
    let mut curves: Vec<Curve> = CURVES
        .iter()
        .map(|&(name, method, rule)| {
            let thresholds: &[f64] = if rule == CountRule::Gap { &GAPS } else { &EIGENVALUES };
            Curve { name, points: averages(method, rule, thresholds), comparison: None }
        })
        .collect();
    let ours = errors_along(&curves[0]);
    for curve in &mut curves[1..] {
        curve.comparison = compare(&ours, &errors_along(curve));
    }
    curves
}

fn errors_along(curve: &Curve) -> Vec<Errors> {
    curve.points.iter().map(|p| p.errors).collect()
}

fn print_sequence(o: &Outcome) -> Result<()> {
    let value = |k: usize| o.eigenvalues.get(k).or(o.eigenvalues.last()).copied().unwrap_or(f64::NAN);
    let best = |missed: f64| {
        let candidates = o.rotation_merge.iter().filter(|e| e.missed <= missed).map(|e| e.oversegmentation);
        candidates.reduce(f64::min)
    };
    let fewest = o.rotation_merge.iter().map(|e| e.missed).fold(f64::INFINITY, f64::min);
    print(format_args!(
        "{:12} {:7} {:.2} {:.2}  {:.2}  {:.2}              {:3.0} with {:.0} missed {:20.1}",
        o.name,
        o.trajectories,
        value(1),
        value(5),
        value(11),
        value(usize::MAX),
        best(fewest).unwrap_or(0.0),
        fewest,
        o.time.best()
    ))
}

fn print_table(rule: &str, meaning: &str, curves: &[Curve]) -> Result<()> {
    let names: Vec<String> = curves.iter().map(|c| format!("{:>20}", c.name)).collect();
    print(format_args!("\n{:>11} {:>6}{}", rule, "mean K", names.concat()))?;
    print(format_args!(
        "{:>18}{}",
        "",
        "   missed over-seg.".repeat(curves.len()).replace("   missed", "     missed")
    ))?;
    for (row, point) in curves[0].points.iter().enumerate() {
        let cells: Vec<String> = curves
            .iter()
            .map(|c| format!("{:11.2}{:9.2}", c.points[row].errors.missed, c.points[row].errors.oversegmentation))
            .collect();
        print(format_args!("{:11} {:6.2}{}", point.threshold, point.mean_count, cells.concat()))?;
    }
    print(format_args!("({meaning} the number in the first column)"))
}

fn print_verdict(curves: &[Curve]) -> Result<()> {
    print("")?;
    let mut holds = true;
    for curve in &curves[1..] {
        let Some(c) = curve.comparison else { continue };
        holds &= c.holds();
        let rates = c.below + c.equal + c.above;
        print(format_args!(
            "rot-disc against {:12} below at {} of {rates} rates of misses from {:.2} on, equal at {}, above at {}; least margin {:.2}",
            format!("{}:", curve.name),
            c.below,
            c.from,
            c.equal,
            c.above,
            c.margin
        ))?;
    }
    let verdict = if holds { "yes" } else { "no" };
    print(format_args!("rot-disc lies below the others at every rate of misses that both reach: {verdict}"))
}
