//! `tracecut eval ablate`: what each choice that is not the paper's is worth, written into a ledger.

mod cache;
mod choices;
mod ledger;

use super::clips::{Clip, Suite};
use super::masks::{require_dense, run_clip};
use crate::failure::{Failure, Result, print, write};
use crate::jobs::in_order;
use cache::{Cache, Key};
use choices::{Choice, read_choices};
use clap::Args;
use ledger::{Effect, markdown};
use std::path::PathBuf;
use tracecut::Params;
use tracecut::eval::masks::MaskScores;

const HELP: &str = "\
Runs `eval masks` on every clip with all choices in force, and with each one of the table taken away, under every seed; writes how J moves on
each kind of clip. Scores are kept in the folder of --cache under the program, the clip's place and all parameters: a run that was broken
off goes on where it was, and one with more rules or clips runs only what is new. After clips were changed in their place, empty it.";

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
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(3..))]
    frames: Option<u32>,
    /// Run each clip under each of these seeds
    #[arg(long, value_name = "SEED,...", value_delimiter = ',', default_value = "0,1,2")]
    seeds: Vec<u32>,
}

/// J of each clip under each seed, `None` where it was not run.
type Table = Vec<Vec<Option<f64>>>;

pub(super) fn eval(args: &AblateArgs) -> Result<()> {
    let params = args.suite.settings.params()?;
    require_dense(&params)?;
    let choices = read_choices(&args.choices)?;
    let clips = args.suite.clips()?;
    let variants = variants(&choices, &params, args)?;
    let tables = measure(&variants, &clips, args)?;
    let mut kinds: Vec<&str> = clips.iter().map(|clip| clip.kind.as_str()).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let base = columns(&tables[0], &clips, &kinds);
    let effects: Vec<Option<Effect>> = tables[1..]
        .iter()
        .map(|table| table.as_ref().map(|t| difference(&columns(&Some(t.clone()), &clips, &kinds), &base)))
        .collect();
    write(&args.out, markdown(&choices, &kinds, &base, &effects, &command(args)))?;
    print(format_args!("see {}", args.out.display()))
}

/// The parameters with all choices in force, then those without each one; `None` where it is not asked for.
fn variants(choices: &[Choice], params: &Params, args: &AblateArgs) -> Result<Vec<Option<(String, Params)>>> {
    let wanted = |c: &Choice| args.rules.is_empty() || args.rules.iter().any(|text| c.name.contains(text));
    let mut variants = vec![Some(("all in force".to_owned(), params.clone()))];
    for choice in choices {
        let takes_away = !choice.without.0.is_empty() && wanted(choice);
        let without = || Ok::<_, Failure>((format!("without {}", choice.name), choice.params(params)?));
        variants.push(takes_away.then(without).transpose()?);
    }
    Ok(variants)
}

/// Runs every variant on every clip; prints a line for each as soon as it is known.
fn measure(variants: &[Option<(String, Params)>], clips: &[Clip], args: &AblateArgs) -> Result<Vec<Option<Table>>> {
    let cache = Cache::open(&args.cache)?;
    let pairs: Vec<(&(String, Params), &Clip)> =
        variants.iter().flatten().flat_map(|v| clips.iter().map(move |clip| (v, clip))).collect();
    let work = |&((name, params), clip): &(&(String, Params), &Clip)| {
        let scores = scores_of(clip, params, &cache, args)
            .map_err(|failure| failure.of(format_args!("{}, {name}", clip.name)))?;
        Ok((format!("{name}: {}", clip.name), scores))
    };
    let report = |(title, scores): &(String, Vec<Option<f64>>)| {
        let figures: Vec<String> = scores.iter().map(|j| j.map_or("-".to_owned(), |j| format!("{j:.3}"))).collect();
        print(format_args!("{title:60} {}", figures.join(" ")))
    };
    let mut all = in_order(&pairs, args.suite.jobs(), work, report)?.into_iter().map(|(_, scores)| scores);
    Ok(variants.iter().map(|v| v.as_ref().map(|_| all.by_ref().take(clips.len()).collect())).collect())
}

/// J of a clip under each seed: from the cache, or else by running it.
fn scores_of(clip: &Clip, params: &Params, cache: &Cache, args: &AblateArgs) -> Result<Vec<Option<f64>>> {
    let place = clip.images.canonicalize().unwrap_or_else(|_| clip.images.clone());
    let under = |seed: &u32| {
        let mut params = params.clone();
        params.clip.seed = *seed;
        let key = Key { clip: &place, frames: args.frames, params: &params };
        if let Some(known) = cache.get(&key)? {
            return Ok(known.j);
        }
        if args.cached {
            return Ok(None);
        }
        let scores: MaskScores = run_clip(clip, args.frames, None, params.clone(), None)?.scores;
        cache.put(&key, scores)?;
        Ok(scores.j)
    };
    args.seeds.iter().map(under).collect()
}

/// Means over each kind's clips, and over the kinds, seed by seed.
fn columns(table: &Option<Table>, clips: &[Clip], kinds: &[&str]) -> Effect {
    let mut columns: Vec<Option<Vec<f64>>> = kinds
        .iter()
        .map(|kind| {
            let of_kind = clips.iter().zip(table.iter().flatten()).filter(|(clip, _)| clip.kind == *kind);
            mean_rows(&of_kind.map(|(_, row)| row.iter().copied().collect()).collect::<Vec<_>>())
        })
        .collect();
    columns.push(mean_rows(&columns));
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

/// What makes the figures again, places left out.
fn command(args: &AblateArgs) -> String {
    let seeds: Vec<String> = args.seeds.iter().map(u32::to_string).collect();
    let frames = args.frames.map_or(String::new(), |n| format!(" --frames {n}"));
    let only =
        if args.suite.only.is_empty() { String::new() } else { format!(" --only {}", args.suite.only.join(",")) };
    let names = args.suite.folders.iter().map(|f| f.file_name().unwrap_or_default().to_string_lossy().into_owned());
    let names: Vec<String> = names.collect();
    format!("tracecut eval ablate {} --cache CACHE --seeds {}{frames}{only}", names.join(" "), seeds.join(","))
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
