//! `tracecut eval fit`: the weights of what is known of two clusters, from clips with true masks.

use super::clips::Suite;
use super::points::{Item, items, run_item};
use crate::failure::{Failure, Result, print, write};
use crate::jobs::in_order;
use clap::Args;
use std::path::PathBuf;
use tracecut::Params;
use tracecut::discretize::Clusters;
use tracecut::eval::logistic::{Example, fit, loss};
use tracecut::eval::moseg::overlap_of;

const HELP: &str = "\
Each clip is run to the labels of its trajectories. For every two neighbouring pieces of the over-segmentation, before any are merged, the
terms of src/evidence/pair.rs are written down, and how likely two of their points, one of each, are of one region. A logistic regression
gives the weights: every clip counts alike, in it a pair by the logarithm of the points of its smaller piece.

For each kind of clips the loss is printed of weights that were fitted on the others, and of those fitted on all (nats a pair); then the
loss without each term, always on kinds that were left out.";

/// The price of a squared weight, in units of the mean loss.
const RIDGE: f64 = 0.003;
/// Pieces with fewer points in scored frames tell nothing.
const FEWEST: u64 = 5;
/// The terms, in their order.
const NAMES: [&str; 4] = ["discontinuity", "gain", "strangeness", "rest"];

#[derive(Args, Debug)]
#[command(after_help = HELP)]
pub(crate) struct FitArgs {
    #[command(flatten)]
    suite: Suite,
    /// Use the first N frames of each clip, or all where it is shorter
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(3..))]
    frames: u32,
    /// Run each clip under each of these seeds
    #[arg(long, value_name = "SEED,...", value_delimiter = ',', default_value = "0,1,2")]
    seeds: Vec<u32>,
    /// Write the table of weights to this file: src/evidence/weights.rs
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// The examples of a clip, and its kind.
#[derive(Debug)]
struct Lesson {
    kind: String,
    examples: Vec<Example>,
}

pub(super) fn eval(args: &FitArgs) -> Result<()> {
    let mut params = args.suite.settings.params()?;
    params.clip.dense = false;
    let items = items(&args.suite)?;
    let work = |item: &Item| lesson(item, &params, args).map_err(|failure| failure.of(&item.name));
    let report = |lesson: &Lesson| print(format_args!("{:20} {:6} pairs", lesson.kind, lesson.examples.len()));
    let lessons = in_order(&items, args.suite.jobs(), work, report)?;
    let weights = fit(&examples(&lessons, |_| true), RIDGE);
    if weights.is_empty() {
        return Err(Failure::new("no clip has two neighbouring pieces: nothing can be fitted".to_owned()));
    }
    report_losses(&lessons, &weights)?;
    let text = table(&weights);
    print(&text)?;
    args.out.as_ref().map_or(Ok(()), |path| write(path, text))
}

fn examples(lessons: &[Lesson], wanted: impl Fn(&str) -> bool) -> Vec<Example> {
    lessons.iter().filter(|lesson| wanted(&lesson.kind)).flat_map(|lesson| lesson.examples.clone()).collect()
}

/// The pairs of a clip under all seeds; their weights sum up to one.
fn lesson(item: &Item, params: &Params, args: &FitArgs) -> Result<Lesson> {
    let mut found = Vec::new();
    for &seed in &args.seeds {
        let mut params = params.clone();
        params.clip.seed = seed;
        let (session, _, shot) = run_item(item, params, args.frames)?;
        let (Some((label, pairs)), Some(tracks)) = (session.pieces(), session.trajectories()) else { continue };
        let count = 1 + label.iter().max().map_or(0, |&l| l as usize);
        let overlap = overlap_of(&shot.definition, &shot.maps, tracks, &Clusters { count, label })
            .map_err(|e| Failure::new(e.to_string()))?;
        let points = |cluster: u32| overlap.iter().map(|row| row[cluster as usize]).sum::<u64>();
        for pair in pairs {
            let (p, q) = pair.clusters;
            let (a, b) = (points(p), points(q));
            if a.min(b) >= FEWEST {
                let both = |row: &Vec<u64>| row[p as usize] as f64 * row[q as usize] as f64;
                let truth = overlap.iter().map(both).sum::<f64>() / (a as f64 * b as f64);
                found.push(Example { terms: pair.terms.to_vec(), truth, weight: (1.0 + a.min(b) as f64).ln() });
            }
        }
    }
    let all: f64 = found.iter().map(|e| e.weight).sum();
    found.iter_mut().for_each(|e| e.weight /= all);
    Ok(Lesson { kind: item.kind.clone(), examples: found })
}

fn report_losses(lessons: &[Lesson], weights: &[f64]) -> Result<()> {
    let mut kinds: Vec<&str> = lessons.iter().map(|lesson| lesson.kind.as_str()).collect();
    kinds.sort_unstable();
    kinds.dedup();
    print(format_args!("\n{:24} {:>10} {:>10}", "loss", "left out", "fitted on"))?;
    for &kind in &kinds {
        let (own, others) = (examples(lessons, |k| k == kind), examples(lessons, |k| k != kind));
        if !own.is_empty() && !others.is_empty() {
            let left_out = loss(&fit(&others, RIDGE), &own);
            print(format_args!("{kind:24} {left_out:10.3} {:10.3}", loss(weights, &own)))?;
        }
    }
    print(format_args!("\n{:24} {:>10}", "left out, mean of kinds", ""))?;
    print(format_args!("{:24} {:10.4}", "all terms", left_out(lessons, &kinds, None)))?;
    for (k, name) in NAMES.iter().enumerate() {
        print(format_args!("without {name:16} {:10.4}", left_out(lessons, &kinds, Some(k))))?;
    }
    print("")
}

/// The mean over the kinds of the loss on each by weights that were fitted on the others, without a term.
fn left_out(lessons: &[Lesson], kinds: &[&str], without: Option<usize>) -> f64 {
    let of = |wanted: &dyn Fn(&str) -> bool| {
        let mut found = examples(lessons, wanted);
        if let Some(k) = without {
            found.iter_mut().for_each(|e| e.terms[k] = 0.0);
        }
        found
    };
    let losses = kinds.iter().filter_map(|&kind| {
        let (own, others) = (of(&|k| k == kind), of(&|k| k != kind));
        (!own.is_empty() && !others.is_empty()).then(|| loss(&fit(&others, RIDGE), &own))
    });
    let losses: Vec<f64> = losses.collect();
    losses.iter().sum::<f64>() / losses.len().max(1) as f64
}

/// The source of the table.
fn table(weights: &[f64]) -> String {
    let numbers: Vec<String> = weights.iter().map(|w| format!("{w:.4}")).collect();
    format!(
        "//! The fitted weights, by the command below; do not edit them by hand.\n\
         //!\n\
         //! `tracecut eval fit bms26 davis wild --out src/evidence/weights.rs`\n\n\
         /// Of a pair of clusters, for that they are one: base, then the terms of `pair`.\n\
         pub(super) const PAIR: [f64; {}] = [{}];\n",
        weights.len(),
        numbers.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_rust_and_a_kind_is_judged_by_the_others() {
        let table = table(&[1.0, -0.25]);
        assert!(table.ends_with("pub(super) const PAIR: [f64; 2] = [1.0000, -0.2500];\n"), "{table}");
        // One kind obeys the term, the other its opposite: what is learned on one is wrong on the other.
        let lesson = |kind: &str, sign: f64| Lesson {
            kind: kind.to_owned(),
            examples: [-1.0, 1.0]
                .map(|x| Example { terms: vec![x], truth: 0.5 + 0.4 * sign * x, weight: 0.5 })
                .to_vec(),
        };
        let lessons = [lesson("a", 1.0), lesson("b", -1.0)];
        assert!(left_out(&lessons, &["a", "b"], None) > left_out(&lessons, &["a", "b"], Some(0)));
    }
}
