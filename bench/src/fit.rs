//! `bench fit`: the weights of what is known of two clusters, from clips with true masks.

use super::batch::in_order;
use super::clips::Suite;
use super::moseg::Shot;
use super::points::{Item, items};
use super::runs::{RunOptions, SEEDS};
use crate::measures::logistic::{Example, fit, loss};
use crate::measures::moseg::overlap_of;
use clap::Args;
use std::path::PathBuf;
use tracecut::discretize::Clusters;
use tracecut::evidence::ClusterPair;
use tracecut::{Params, Session};
use tracecut_cli::failure::{Failure, Result, print, write};

const HELP: &str = "\
Each clip is run to the labels of its trajectories. For every two neighbouring pieces of the over-segmentation, before any are merged, the
terms of src/figure/evidence.rs are written down, and how likely two of their points, one of each, are of one region; for every cluster
the terms of src/figure/evidence.rs, before a moving or a still camera, and its share of points on objects. Logistic regressions give the weights: every
clip counts alike, in it a pair by the logarithm of the points of its smaller piece, a cluster by the root of its points.

For each kind of clips the loss is printed of weights that were fitted on the others, and of those fitted on all (nats a pair); then the
loss without each term, always on kinds that were left out.";

/// The price of a squared weight, in units of the mean loss.
const RIDGE: f64 = 0.003;
/// Pieces with fewer points in scored frames tell nothing.
const FEWEST: f64 = 5.0;
/// The terms of pairs, in their order.
const PAIR: [&str; 4] = ["discontinuity", "gain", "contrast", "residual"];
/// Those of objects before a moving camera, and before a still one.
const OBJECT: [&str; 2] = ["border", "contrast"];
const OBJECT_BEFORE_PLATE: [&str; 1] = ["plate distance"];

#[derive(Args, Debug)]
#[command(after_help = HELP)]
pub(crate) struct FitArgs {
    #[command(flatten)]
    suite: Suite,
    /// Use N frames from each start, or all where there are fewer
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(3..))]
    frames: u32,
    #[command(flatten)]
    runs: RunOptions,
    /// Write the weights to this file, as constants of src/figure/evidence.rs
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// The examples of a clip, and its kind.
#[derive(Debug, Default)]
struct Lesson {
    kind: String,
    examples: Vec<Example>,
}

/// Examples of a clip: of pairs, of objects, and of objects before a still camera.
type Lessons = [Lesson; 3];

pub(super) fn eval(args: &FitArgs) -> Result<()> {
    let mut params = args.suite.settings.params()?;
    params.clip.dense = false;
    let items = items(&args.suite)?;
    let seeds = args.runs.seeds(&SEEDS);
    let work =
        |item: &Item| lessons_of(item, &params, &seeds, args).map_err(|failure| failure.with_subject(&item.name));
    let report = |lessons: &Lessons| {
        let [pairs, objects, still] = lessons.each_ref().map(|lesson| lesson.examples.len());
        print(format_args!("{:20} {pairs:6} pairs {:4} clusters", lessons[0].kind, objects + still))
    };
    let lessons_of_clips = in_order(&items, args.suite.jobs(), work, report)?;
    let mut tables = Vec::new();
    for (k, names) in [&PAIR[..], &OBJECT, &OBJECT_BEFORE_PLATE].into_iter().enumerate() {
        let lessons: Vec<&Lesson> = lessons_of_clips.iter().map(|lessons| &lessons[k]).collect();
        let weights = fit(&examples(&lessons, |_| true), RIDGE);
        if weights.is_empty() {
            return Err(Failure::new("no clip has clusters to learn from: nothing can be fitted".to_owned()));
        }
        report_losses(&lessons, &weights, names)?;
        tables.push(weights);
    }
    let options = format!("--frames {} {}", args.frames, args.runs.arguments(&seeds));
    let text = table(&tables, &args.suite.command("fit", &options));
    print(&text)?;
    args.out.as_ref().map_or(Ok(()), |path| write(path, text))
}

fn examples(lessons: &[&Lesson], wanted: impl Fn(&str) -> bool) -> Vec<Example> {
    lessons.iter().filter(|lesson| wanted(&lesson.kind)).flat_map(|lesson| lesson.examples.clone()).collect()
}

/// The pairs and clusters of all runs of a clip; the weights of each sum up to one.
fn lessons_of(item: &Item, params: &Params, seeds: &[u32], args: &FitArgs) -> Result<Lessons> {
    let mut examples = <[Vec<Example>; 3]>::default();
    for excerpt in item.excerpts(&args.runs, args.frames)? {
        let shot = item.shot(&excerpt)?;
        excerpt.run_seeds(params, seeds, |session, _, _| add_examples(&session, &shot, item, &mut examples))?;
    }
    let normalized = |mut examples: Vec<Example>| {
        let total: f64 = examples.iter().map(|e| e.weight).sum();
        examples.iter_mut().for_each(|e| e.weight /= total);
        Lesson { kind: item.kind.clone(), examples }
    };
    Ok(examples.map(normalized))
}

/// Adds the pairs and clusters of a run.
fn add_examples(session: &Session, shot: &Shot, item: &Item, examples: &mut [Vec<Example>; 3]) -> Result<()> {
    let overlap = |clusters: &Clusters| -> Result<Vec<Vec<u64>>> {
        let Some(tracks) = session.trajectories() else { return Ok(Vec::new()) };
        overlap_of(&shot.definition, &shot.maps, tracks, clusters).map_err(|e| Failure::new(e.to_string()))
    };
    if let Some((label, pairs)) = session.pieces() {
        let count = 1 + label.iter().max().map_or(0, |&l| l as usize);
        pairs_in(&overlap(&Clusters { count, label })?, pairs, &mut examples[0]);
    }
    // Regions of shots can be parts of the scene; masks show objects.
    let terms = session.cluster_terms().filter(|_| item.has_masks());
    if let (Some((still, terms)), Some(clusters)) = (terms, session.clusters()) {
        objects_in(&overlap(clusters)?, terms, &mut examples[1 + usize::from(still)]);
    }
    Ok(())
}

/// Counts the points of each cluster in scored frames.
fn points(overlap: &[Vec<u64>], cluster: usize) -> f64 {
    overlap.iter().map(|row| row[cluster]).sum::<u64>() as f64
}

fn pairs_in(overlap: &[Vec<u64>], pairs: Vec<ClusterPair>, found: &mut Vec<Example>) {
    for pair in pairs {
        let [p, q] = [pair.clusters.0 as usize, pair.clusters.1 as usize];
        let (a, b) = (points(overlap, p), points(overlap, q));
        if a.min(b) >= FEWEST {
            let truth = overlap.iter().map(|row| row[p] as f64 * row[q] as f64).sum::<f64>() / (a * b);
            found.push(Example { terms: pair.terms.to_vec(), truth, weight: (1.0 + a.min(b)).ln() });
        }
    }
}

fn objects_in(overlap: &[Vec<u64>], terms: Vec<Vec<f64>>, found: &mut Vec<Example>) {
    for (cluster, terms) in terms.into_iter().enumerate() {
        let num_points = points(overlap, cluster);
        if num_points >= FEWEST {
            let truth = points(&overlap[1..], cluster) / num_points;
            found.push(Example { terms, truth, weight: num_points.sqrt() });
        }
    }
}

fn report_losses(lessons: &[&Lesson], weights: &[f64], names: &[&str]) -> Result<()> {
    let mut kinds: Vec<&str> = lessons.iter().map(|lesson| lesson.kind.as_str()).collect();
    kinds.sort_unstable();
    kinds.dedup();
    print(format_args!("\n{:24} {:>10} {:>10}", "loss", "left out", "fitted on"))?;
    for &kind in &kinds {
        let (tests, training) = (examples(lessons, |k| k == kind), examples(lessons, |k| k != kind));
        if !tests.is_empty() && !training.is_empty() {
            let left_out = loss(&fit(&training, RIDGE), &tests);
            print(format_args!("{kind:24} {left_out:10.3} {:10.3}", loss(weights, &tests)))?;
        }
    }
    print(format_args!("\n{:24} {:>10}", "left out, mean of kinds", ""))?;
    print(format_args!("{:24} {:10.4}", "all terms", left_out(lessons, &kinds, None)))?;
    for (k, name) in names.iter().enumerate() {
        print(format_args!("without {name:16} {:10.4}", left_out(lessons, &kinds, Some(k))))?;
    }
    print("")
}

/// The mean over the kinds of the loss on each by weights that were fitted on the others, without a term.
fn left_out(lessons: &[&Lesson], kinds: &[&str], without: Option<usize>) -> f64 {
    let select = |is_wanted: &dyn Fn(&str) -> bool| {
        let mut selection = examples(lessons, is_wanted);
        if let Some(k) = without {
            selection.iter_mut().for_each(|e| e.terms[k] = 0.0);
        }
        selection
    };
    let losses = kinds.iter().filter_map(|&kind| {
        let (tests, training) = (select(&|k| k == kind), select(&|k| k != kind));
        (!tests.is_empty() && !training.is_empty()).then(|| loss(&fit(&training, RIDGE), &tests))
    });
    let losses: Vec<f64> = losses.collect();
    losses.iter().sum::<f64>() / losses.len().max(1) as f64
}

/// The source of the tables.
fn table(weights: &[Vec<f64>], command: &str) -> String {
    let mut text = format!("// Fitted by `{command}`; do not edit them by hand.\n");
    let tables = [
        ("PAIR_WEIGHTS", "a pair of clusters to be one object: bias, then the terms of `ClusterPair`"),
        (
            "OBJECT_WEIGHTS",
            "a cluster to be an object, with a moving camera: bias, then the terms of `ClusterCues::Moving`",
        ),
        (
            "STILL_OBJECT_WEIGHTS",
            "a cluster to be an object, with a still camera: bias, then the term of `ClusterCues::Still`",
        ),
    ];
    for ((name, what), weights) in tables.into_iter().zip(weights) {
        let numbers: Vec<String> = weights.iter().map(|w| format!("{w:.4}")).collect();
        let (count, numbers) = (weights.len(), numbers.join(", "));
        text += &format!("\n/// Weights of {what}.\nconst {name}: [f64; {count}] = [{numbers}];\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_rust_and_a_kind_is_judged_by_the_others() {
        let table = table(&[vec![1.0, -0.25], vec![0.5], vec![0.25]], "bench fit");
        assert!(table.contains("\nconst PAIR_WEIGHTS: [f64; 2] = [1.0000, -0.2500];\n"), "{table}");
        assert!(table.ends_with("\nconst STILL_OBJECT_WEIGHTS: [f64; 1] = [0.2500];\n"), "{table}");
        // One kind obeys the term, the other its opposite: what is learned on one is wrong on the other.
        let lesson = |kind: &str, sign: f64| Lesson {
            kind: kind.to_owned(),
            examples: [-1.0, 1.0]
                .map(|x| Example { terms: vec![x], truth: 0.5 + 0.4 * sign * x, weight: 0.5 })
                .to_vec(),
        };
        let (a, b) = (lesson("a", 1.0), lesson("b", -1.0));
        let lessons = [&a, &b];
        assert!(left_out(&lessons, &["a", "b"], None) > left_out(&lessons, &["a", "b"], Some(0)));
    }
}
