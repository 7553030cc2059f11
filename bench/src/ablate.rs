//! `bench ablate`: what each choice that is not the paper's is worth, written into a ledger.

mod cache;
mod ledger;

use super::batch::{in_order, require_dense};
use super::clips::Suite;
use super::points::{Item, PointScores, items};
use super::runs::{Excerpt, RunOptions, SEEDS};
use super::shot::Shot;
use crate::measures::davis::scored_frames;
use crate::measures::masks::{ClipScorer, MaskScores, Truth};
use cache::{Cache, Key, Score};
use clap::Args;
use ledger::{Choice, Effect, markdown, read_choices};
use std::path::PathBuf;
use tracecut::image::Plane;
use tracecut::session::Forks;
use tracecut::{Params, Session};
use tracecut_cli::failure::{Failure, Result, print, write};

const HELP: &str = "\
Runs every clip with all choices in force, and with each one of the table taken away, under every seed; writes how J moves on each kind
of clip, and how the error of the labelled points does. What a choice does not touch is run once a clip. Scores are kept in the folder
of --cache under the program, the clip's place and all parameters: a run that was broken off goes on where it was, and one with more
rules or clips runs only what is new. After clips were changed in their place, empty it.";

#[derive(Args, Debug)]
#[command(after_help = HELP)]
pub(crate) struct AblateArgs {
    #[command(flatten)]
    suite: Suite,
    /// Folder that keeps the scores
    #[arg(long, value_name = "DIR")]
    cache: PathBuf,
    /// The table of choices
    #[arg(long, value_name = "FILE", default_value = "docs/choices.json")]
    choices: PathBuf,
    /// The ledger
    #[arg(long, value_name = "FILE", default_value = "docs/choices.md")]
    out: PathBuf,
    /// Run nothing: write the ledger from what the cache holds
    #[arg(long)]
    cached: bool,
    /// Run only the choices whose names contain one of these
    #[arg(long, value_name = "TEXT,...", value_delimiter = ',')]
    rules: Vec<String>,
    /// Use the first N frames of each clip, or all where it is shorter
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(3..))]
    frames: u32,
    #[command(flatten)]
    runs: RunOptions,
}

/// The scores of each run of each clip, `None` where it was not run.
type Table = Vec<Vec<Option<Score>>>;

pub(super) fn eval(args: &AblateArgs) -> Result<()> {
    let params = args.suite.settings.params()?;
    require_dense(&params)?;
    let choices = read_choices(&args.choices)?;
    let items = items(&args.suite)?;
    let variants = variants(&choices, &params, args)?;
    let tables = measure(&variants, &items, args)?;
    let mut kinds: Vec<&str> = items.iter().filter(|item| item.has_masks()).map(|item| item.kind.as_str()).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let base = columns(tables[0].as_ref(), &items, &kinds);
    let effect = |table: &Table| difference(&columns(Some(table), &items, &kinds), &base);
    let effects: Vec<Option<Effect>> = tables[1..].iter().map(|table| table.as_ref().map(effect)).collect();
    let options = format!("--cache CACHE {} --frames {}", args.runs.arguments(&args.runs.seeds(&SEEDS)), args.frames);
    write(&args.out, markdown(&choices, &kinds, &base, &effects, &args.suite.command("ablate", &options)))?;
    print(format_args!("see {}", args.out.display()))
}

/// The parameters with all choices in force, then those without each one; `None` where it is not asked for.
fn variants(choices: &[Choice], params: &Params, args: &AblateArgs) -> Result<Vec<Option<(String, Params)>>> {
    let is_selected = |c: &Choice| args.rules.is_empty() || args.rules.iter().any(|text| c.name.contains(text));
    let mut variants = vec![Some(("all in force".to_owned(), params.clone()))];
    for choice in choices {
        let takes_away = !choice.without.0.is_empty() && is_selected(choice);
        let without = || Ok::<_, Failure>((format!("without {}", choice.name), choice.params(params)?));
        variants.push(takes_away.then(without).transpose()?);
    }
    Ok(variants)
}

/// Runs every variant on every clip; prints a line for each once the clip is done.
fn measure(variants: &[Option<(String, Params)>], items: &[Item], args: &AblateArgs) -> Result<Vec<Option<Table>>> {
    let cache = Cache::open(&args.cache)?;
    let work = |item: &Item| {
        let scores = scores_of(item, variants, &cache, args).map_err(|failure| failure.with_subject(&item.name))?;
        Ok((item.name.clone(), scores))
    };
    let report = |(clip, scores): &(String, Vec<Vec<Option<Score>>>)| {
        variants.iter().flatten().zip(scores).try_for_each(|((name, _), row)| {
            let figures: Vec<String> = row.iter().map(|s| s.as_ref().map_or("-".to_owned(), Score::line)).collect();
            print(format_args!("{clip}\t{name}\t{}", figures.join("\t")))
        })
    };
    let by_clip = in_order(items, args.suite.jobs(), work, report)?;
    let mut run = 0..;
    let table = |run: usize| by_clip.iter().map(|(_, scores)| scores[run].clone()).collect();
    Ok(variants.iter().map(|v| v.as_ref().and_then(|_| run.next()).map(table)).collect())
}

/// The scores of a clip, variant by variant, of each run: from the cache, or else by running it.
fn scores_of(
    item: &Item,
    variants: &[Option<(String, Params)>],
    cache: &Cache,
    args: &AblateArgs,
) -> Result<Vec<Vec<Option<Score>>>> {
    let place = item.path().canonicalize().unwrap_or_else(|_| item.path().to_owned());
    let seeds = args.runs.seeds(&SEEDS);
    let variants: Vec<&Params> = variants.iter().flatten().map(|(_, params)| params).collect();
    let mut rows = vec![Vec::new(); variants.len()];
    for excerpt in item.excerpts(&args.runs, args.frames)? {
        let mut forks = None;
        for (row, params) in rows.iter_mut().zip(&variants) {
            for &seed in &seeds {
                let mut params = Params::clone(params);
                params.clip.seed = seed;
                let (start, mirrored) = (excerpt.start, excerpt.mirrored);
                let key = Key { clip: &place, start, mirrored, frames: args.frames, params: &params };
                let known = cache.get(&key)?;
                if known.is_some() || args.cached {
                    row.push(known);
                    continue;
                }
                let (forks, truth) = match &mut forks {
                    Some(begun) => begun,
                    none => {
                        let session = excerpt.session(args.suite.settings.params()?)?;
                        none.insert((Forks::new(session)?, GroundTruth::read(item, &excerpt)?))
                    }
                };
                let score = truth.score(forks.labelled(&params)?)?;
                cache.put(&key, score.clone())?;
                row.push(Some(score));
            }
        }
    }
    Ok(rows)
}

/// The true masks of an excerpt, of all frames, and the regions of its points.
struct GroundTruth {
    masks: Vec<Option<Plane<Truth>>>,
    shot: Shot,
}

impl GroundTruth {
    fn read(item: &Item, excerpt: &Excerpt) -> Result<Self> {
        Ok(Self { masks: item.masks(excerpt)?, shot: item.shot(excerpt)? })
    }

    /// Scores points, and makes masks and scores them where there are true ones.
    fn score(&self, mut session: Session) -> Result<Score> {
        let points = PointScores::of(&session, &self.shot)?;
        let mut scorer = ClipScorer::default();
        if self.masks.iter().any(Option::is_some) {
            session.run()?;
            for t in scored_frames(self.masks.len()) {
                if let Some(truth) = &self.masks[t] {
                    scorer.add(&session.labels(t)?, truth)?;
                }
            }
        }
        Ok(Score { masks: MaskScores::mean_of(scorer.frames()), points })
    }
}

/// Computes, for each seed, the mean J of each kind and over the kinds, and the mean error of points over all clips.
fn columns(table: Option<&Table>, items: &[Item], kinds: &[&str]) -> Effect {
    let rows = |is_selected: &dyn Fn(&Item) -> bool, value: &dyn Fn(&Score) -> f64| {
        let selected = items.iter().zip(table.into_iter().flatten()).filter(|(item, _)| is_selected(item));
        let rows = selected.map(|(_, row)| row.iter().map(|score| score.as_ref().map(value)).collect());
        mean_rows(&rows.collect::<Vec<_>>())
    };
    let j = |score: &Score| score.masks.j.unwrap_or_default();
    let mut columns: Vec<_> =
        kinds.iter().map(|kind| rows(&|item| item.has_masks() && item.kind == *kind, &j)).collect();
    let mean = mean_rows(&columns);
    columns.splice(0..0, [mean, rows(&|_| true, &|score| score.points.error.unwrap_or_default())]);
    Effect { columns }
}

/// The mean of rows, column by column; `None` where a row is missing, or all are.
fn mean_rows(rows: &[Option<Vec<f64>>]) -> Option<Vec<f64>> {
    let rows: Vec<&Vec<f64>> = rows.iter().map(Option::as_ref).collect::<Option<_>>()?;
    let length = rows.first()?.len();
    Some((0..length).map(|i| rows.iter().map(|row| row[i]).sum::<f64>() / rows.len() as f64).collect())
}

fn difference(effect: &Effect, base: &Effect) -> Effect {
    let less = |(ours, base): (&Option<Vec<f64>>, &Option<Vec<f64>>)| {
        Some(ours.as_ref()?.iter().zip(base.as_ref()?).map(|(a, b)| a - b).collect())
    };
    Effect { columns: effect.columns.iter().zip(&base.columns).map(less).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_of_rows_go_column_by_column_and_need_all_rows() {
        let rows = [Some(vec![0.5, 1.0]), Some(vec![0.25, 0.5])];
        assert_eq!(mean_rows(&rows), Some(vec![0.375, 0.75]));
        assert_eq!(mean_rows(&[rows[0].clone(), None]), None);
        assert_eq!(mean_rows(&[]), None);
        let effect = |rows: &[Option<Vec<f64>>]| Effect { columns: rows.to_vec() };
        let found = difference(&effect(&[rows[1].clone(), None]), &effect(&rows));
        assert_eq!(found.columns, [Some(vec![-0.25, -0.5]), None]);
    }
}
