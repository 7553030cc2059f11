//! The table of rules and constants that are not the paper's, `docs/choices.json`, and the ledger of what each is worth.

use crate::measures::estimate::Estimate;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use tracecut::Params;
use tracecut::params::{ParamValue, flatten};
use tracecut_cli::failure::{Failure, Result, read};

/// One rule or constant.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Choice {
    pub(super) name: String,
    /// The choice of the paper, or of its source.
    pub(super) paper: String,
    /// Reason for ours, in a line.
    pub(super) why: String,
    /// The settings that take it away; none where no setting does.
    #[serde(default)]
    pub(super) without: BTreeMap<String, ParamValue>,
}

/// Reads the table, and makes sure that every choice can be taken away.
pub(super) fn read_choices(path: &Path) -> Result<Vec<Choice>> {
    let choices: Vec<Choice> = serde_json::from_slice(&read(path)?)
        .map_err(|e| Failure::about(path.display(), format_args!("is no table of choices: {e}")))?;
    for choice in &choices {
        choice.params(&Params::default()).map_err(|failure| failure.with_subject(path.display()))?;
    }
    Ok(choices)
}

impl Choice {
    /// `params` without this choice.
    pub(super) fn params(&self, params: &Params) -> Result<Params> {
        let mut without = params.clone();
        without.apply(&self.without).map_err(|e| Failure::about(&self.name, e))?;
        if !self.without.is_empty() && without == Params::default() {
            return Err(Failure::about(&self.name, "its settings are the defaults: they take nothing away"));
        }
        Ok(without)
    }

    /// Our values of what these settings change.
    pub(super) fn ours(&self) -> String {
        let values = flatten(&self.without).into_iter().map(|(name, _)| format!("`{name}` {}", default_of(&name)));
        let values: Vec<String> = values.collect();
        if values.is_empty() { "in force always".to_owned() } else { values.join(", ") }
    }

    /// These settings as arguments of the command line.
    pub(super) fn arguments(&self) -> String {
        let plain = |value: &ParamValue| match value {
            ParamValue::Text(text) => text.clone(),
            other => other.to_string(),
        };
        let settings = flatten(&self.without).into_iter().map(|(name, value)| format!("--set {name}={}", plain(value)));
        settings.collect::<Vec<_>>().join(" ")
    }
}

/// A parameter's default as it is written on the command line.
fn default_of(name: &str) -> String {
    let mut text = String::new();
    Params::default().for_each(&mut |field| {
        if field.name == name {
            text = match field.kind() {
                "choice" => field.choices()[field.get() as usize].to_owned(),
                "boolean" => (field.get() != 0.0).to_string(),
                _ => field.get().to_string(),
            };
        }
    });
    text
}

/// Figures with the defaults, or their change without a choice.
#[derive(Debug, Clone)]
pub(super) struct Effect {
    /// J as a mean over the kinds, the error of points, J of each kind; `None` where some run is missing.
    pub(super) columns: Vec<Option<Estimate>>,
}

/// Largest change that is printed as 0.
const ROUNDED: f64 = 0.0005;

/// The ledger as Markdown. `effects` has an entry for each choice; `command` made it.
pub(super) fn markdown(
    choices: &[Choice],
    kinds: &[&str],
    base: &Effect,
    effects: &[Option<Effect>],
    command: &str,
) -> String {
    let mut text = INTRODUCTION.to_owned();
    text += "\n## What they are\n\n| choice | the paper | ours | why | without it |\n|---|---|---|---|---|\n";
    for choice in choices {
        let arguments = choice.arguments();
        let without = if arguments.is_empty() { "not to be taken away".to_owned() } else { format!("`{arguments}`") };
        line(&mut text, &[&choice.name, &choice.paper, &choice.ours(), &choice.why, &without]);
    }
    text += "\n## What they are worth\n\n";
    if base.columns.iter().all(Option::is_none) {
        text += "Not measured on this build.\n";
        return text;
    }
    let _ = write!(text, "{EFFECTS}\n\n```text\n{command}\n```\n\n| choice | mean of kinds | points, % |");
    kinds.iter().for_each(|kind| text += &format!(" {kind} |"));
    text += &format!(" left out |\n|---{}|\n", "|---:".repeat(kinds.len() + 3));
    effect_row(&mut text, "*with all of them*", base, false);
    for (choice, effect) in choices.iter().zip(effects) {
        if let Some(effect) = effect {
            effect_row(&mut text, &choice.name, effect, true);
        }
    }
    text
}

const INTRODUCTION: &str = "\
# Choices

Rules and constants that are not the paper's, or that the paper leaves open. Written from [choices.json](choices.json) by
`cargo run --release -p tracecut-bench -- ablate`; do not edit it by hand.
";

const EFFECTS: &str = "\
How J moves when a choice is taken away (below 0: the choice helps), as a mean over the runs of each clip, then over the clips,
± its standard error over the clips; and likewise the error of labelled points over all clips (above 0: the choice helps). The
first row has the figures themselves, ± their standard errors over the runs. A dash: not measured on this build.

Left out: \"5 of 7\" says that without any one of 7 kinds the choice would have been made (taking it away lowers the mean over
the other kinds), and that 5 of these kinds do not lose by it.";

fn effect_row(text: &mut String, title: &str, effect: &Effect, signed: bool) {
    let cells = effect.columns.iter().map(|&estimate| cell(estimate, signed));
    let last = if signed { left_out(effect.columns.get(2..).unwrap_or_default()) } else { "–".to_owned() };
    let cells: Vec<String> = std::iter::once(title.to_owned()).chain(cells).chain([last]).collect();
    line(text, &cells.iter().map(String::as_str).collect::<Vec<_>>());
}

/// Leave one kind out: on how many of the kinds a choice holds that was made by the others.
fn left_out(kinds: &[Option<Estimate>]) -> String {
    let Some(effects) = kinds.iter().map(|k| Some((*k)?.mean)).collect::<Option<Vec<f64>>>() else {
        return "–".to_owned();
    };
    let total: f64 = effects.iter().sum();
    let favourable: Vec<f64> = effects.iter().copied().filter(|effect| total - effect < 0.0).collect();
    let holds = favourable.iter().filter(|effect| **effect <= ROUNDED).count();
    if favourable.is_empty() { "never made".to_owned() } else { format!("{holds} of {}", favourable.len()) }
}

fn cell(estimate: Option<Estimate>, signed: bool) -> String {
    let Some(Estimate { mean, standard_error }) = estimate else { return "–".to_owned() };
    let mean = if signed { format!("{mean:+.3}") } else { format!("{mean:.3}") };
    standard_error.map_or(mean.clone(), |error| format!("{mean} ± {error:.3}"))
}

fn line(text: &mut String, cells: &[&str]) {
    *text += &format!("| {} |\n", cells.join(" | "));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effects_stand_beside_their_errors_and_what_is_not_measured_is_a_dash() {
        let choice = |name: &str| -> Choice {
            let text =
                format!(r#"{{"name": "{name}", "paper": "0", "why": "w", "without": {{"refine": {{"band": 0}}}}}}"#);
            serde_json::from_str(&text).unwrap()
        };
        let estimate = |mean, error| Some(Estimate { mean, standard_error: Some(error) });
        let single = Some(Estimate { mean: -0.2, standard_error: None });
        let base = Effect { columns: vec![estimate(0.25, 0.0), None, estimate(0.55, 0.0501), None] };
        let effect = Effect { columns: vec![estimate(0.125, 0.0), estimate(1.5, 0.5), single, None] };
        let text = markdown(&[choice("one"), choice("two")], &["a", "b"], &base, &[Some(effect), None], "run it");
        for row in [
            "| one | 0 | `refine.band` 8 | w | `--set refine.band=0` |",
            "| choice | mean of kinds | points, % | a | b | left out |",
            "| *with all of them* | 0.250 ± 0.000 | – | 0.550 ± 0.050 | – | – |",
            "| one | +0.125 ± 0.000 | +1.500 ± 0.500 | -0.200 | – | – |",
        ] {
            assert!(text.lines().any(|l| l == row), "{row} is missing:\n{text}");
        }
        assert_eq!(text.matches("| two |").count(), 1, "{text}");
        let of = |effects: &[f64]| left_out(&effects.iter().map(|&e| Estimate::of(&[e])).collect::<Vec<_>>());
        // Without the first it would have been made, and helps there too; without the second likewise; the third loses.
        assert_eq!(of(&[-0.1, -0.2, 0.05]), "2 of 3");
        // Only the first is for it: left out, the others would not have made it.
        assert_eq!(of(&[-0.3, 0.0, 0.1]), "1 of 2");
        assert_eq!(of(&[0.1, 0.2]), "never made");
        let none = Effect { columns: vec![None, None, None, None] };
        assert!(markdown(&[], &["a", "b"], &none, &[], "").contains("Not measured"));
    }

    #[test]
    fn every_choice_of_the_table_is_in_force_and_can_be_taken_away() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/choices.json");
        let choices = read_choices(&path).unwrap();
        assert!(choices.len() > 20, "{} choices", choices.len());
        for choice in &choices {
            for (name, value) in flatten(&choice.without) {
                let mut params = Params::default();
                params.set(&name, value).unwrap();
                assert_ne!(params, Params::default(), "{}: {name} has this value by default", choice.name);
            }
            let texts = [&choice.name, &choice.paper, &choice.why];
            assert!(texts.iter().all(|t| !t.is_empty() && !t.contains(['|', '\n'])), "{choice:?}");
        }
    }

    #[test]
    fn our_value_is_the_default_and_the_setting_is_the_other() {
        let text = r#"{"name": "a", "paper": "b", "why": "c", "without": {"cut": {"outlierWeight": 0, "weightByLength": false}}}"#;
        let choice: Choice = serde_json::from_str(text).unwrap();
        assert_eq!(choice.ours(), "`cut.outlierWeight` 1, `cut.weightByLength` true");
        assert_eq!(choice.arguments(), "--set cut.outlierWeight=0 --set cut.weightByLength=false");
        assert_eq!(choice.params(&Params::default()).unwrap().cut.outlier_weight, 0.0);
    }
}
