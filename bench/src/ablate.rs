//! `bench ablate`: what each choice that is not the paper's is worth, written into a ledger.

mod cache;
mod ledger;

use super::batch::{in_order, require_dense};
use super::clips::Suite;
use super::points::{Item, PointScores, items};
use super::runs::{Excerpt, RunOptions, SEEDS};
use super::shot::Shot;
use crate::measures::davis::scored_frames;
use crate::measures::estimate::Estimate;
use crate::measures::masks::{ClipScorer, MaskScores, Truth};
use cache::{Cache, Key, Score};
use clap::Args;
use ledger::{Choice, Effect, markdown, read_choices};
use std::path::PathBuf;
use tracecut::Forks;
use tracecut::image::Plane;
use tracecut::{Params, Session};
use tracecut_cli::failure::{Failure, Result, print, write};

const HELP: &str = "\
Runs every clip with all choices in force, and with each one of the table taken away, from every start, mirrored and under every seed (0, 1
and 2 if --seeds is not given); writes how J moves on each kind of clip, and how the error of the labelled points does, with the standard
error over the clips. What a choice does not touch is run once for each start. Scores are kept in the folder of --cache under the program,
the clip's place and all parameters: a run that was broken off goes on where it was, and one with more rules or clips runs only what is new.
After clips were changed in their place, empty it.";

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
    /// Use N frames from each start, or all where there are fewer
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
    let with_all = tables[0].as_ref();
    let base = effect(with_all, None, &items, &kinds);
    let change = |table: &Table| effect(Some(table), with_all, &items, &kinds);
    let effects: Vec<Option<Effect>> = tables[1..].iter().map(|table| table.as_ref().map(change)).collect();
    let options = format!("--cache CACHE {} --frames {}", args.runs.arguments(&args.runs.seeds(&SEEDS)), args.frames);
    write(&args.out, markdown(&choices, &kinds, &base, &effects, &args.suite.command("ablate", &options)))?;
    print(format_args!("see {}", args.out.display()))
}

/// The parameters with all choices in force, then those without each one; `None` where it is not asked for.
fn variants(choices: &[Choice], params: &Params, args: &AblateArgs) -> Result<Vec<Option<(String, Params)>>> {
    let is_selected = |c: &Choice| args.rules.is_empty() || args.rules.iter().any(|text| c.name.contains(text));
    let mut variants = vec![Some(("all in force".to_owned(), params.clone()))];
    for choice in choices {
        let takes_away = !choice.without.is_empty() && is_selected(choice);
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

/// Computes figures of a table: the mean J over the kinds, the error of points over all clips, and J of each kind. With
/// `base` they are differences to it, paired run by run.
fn effect(table: Option<&Table>, base: Option<&Table>, items: &[Item], kinds: &[&str]) -> Effect {
    let selected = |is_selected: &dyn Fn(&Item) -> bool, value: fn(&Score) -> f64| {
        let rows = (0..items.len()).filter(|&i| is_selected(&items[i]));
        let clip = |i: usize| of_clip(&table?[i], base.map(|base| &base[i][..]), value);
        rows.map(clip).collect::<Option<Vec<Estimate>>>()
    };
    // What a single table has is uncertain by its runs, what a choice changes by the clips.
    let mean = |groups: &[Vec<Estimate>]| match base {
        None => Estimate::mean_of(&groups.iter().map(|group| Estimate::mean_of(group)).collect::<Option<Vec<_>>>()?),
        Some(_) => {
            let means = |group: &Vec<Estimate>| group.iter().map(|clip| clip.mean).collect();
            Estimate::of_groups(&groups.iter().map(means).collect::<Vec<Vec<f64>>>())
        }
    };
    let j = |score: &Score| score.masks.j.unwrap_or_default();
    let clips_of = |kind: &&str| selected(&|item| item.has_masks() && item.kind == **kind, j);
    let by_kind: Vec<Option<Vec<Estimate>>> = kinds.iter().map(clips_of).collect();
    let error = selected(&|_| true, |score| score.points.error.unwrap_or_default());
    let mut columns = vec![by_kind.iter().cloned().collect::<Option<Vec<_>>>().and_then(|groups| mean(&groups))];
    columns.extend([error].into_iter().chain(by_kind).map(|group| mean(&[group?])));
    Effect { columns }
}

/// Computes the mean over the runs of a clip, or over their differences to `base`; `None` if a run is missing.
fn of_clip(runs: &[Option<Score>], base: Option<&[Option<Score>]>, value: fn(&Score) -> f64) -> Option<Estimate> {
    let values = runs.iter().enumerate().map(|(k, run)| {
        let base = base.map_or(Some(0.0), |base| base[k].as_ref().map(value))?;
        Some(value(run.as_ref()?) - base)
    });
    Estimate::of(&values.collect::<Option<Vec<f64>>>()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(error: f64) -> Option<Score> {
        let points = PointScores {
            error: Some(error),
            region: 0.0,
            fragments: None,
            objects: 0.0,
            true_objects: 0.0,
            best: None,
        };
        Some(Score { masks: MaskScores::default(), points })
    }

    #[test]
    fn a_clip_is_the_mean_of_its_runs_and_needs_all_of_them() {
        let error = |score: &Score| score.points.error.unwrap();
        let (with, without) = ([run(0.5), run(1.0)], [run(0.25), run(0.5)]);
        assert_eq!(of_clip(&with, None, error), Estimate::of(&[0.5, 1.0]));
        assert_eq!(of_clip(&without, Some(&with), error), Estimate::of(&[-0.25, -0.5]));
        assert_eq!(of_clip(&[run(0.5), None], None, error), None);
        assert_eq!(of_clip(&with, Some(&[None, run(1.0)]), error), None);
        assert_eq!(of_clip(&[], None, error), None);
    }
}
