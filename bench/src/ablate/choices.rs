//! The table of rules and constants that are not the paper's: `docs/choices.json`.

use serde::Deserialize;
use std::path::Path;
use tracecut::Params;
use tracecut::params::{ParamTree, ParamValue};
use tracecut_cli::failure::{Failure, Result, read};

/// One rule or constant.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Choice {
    pub(super) name: String,
    /// What the paper, or the work that it takes this from, has.
    pub(super) paper: String,
    /// Why ours is another, in a line.
    pub(super) why: String,
    /// The settings that take it away; none where no setting does.
    #[serde(default)]
    pub(super) without: ParamTree,
}

/// Reads the table, and makes sure that every choice can be taken away.
pub(super) fn read_choices(path: &Path) -> Result<Vec<Choice>> {
    let choices: Vec<Choice> = serde_json::from_slice(&read(path)?)
        .map_err(|e| Failure::about(path.display(), format_args!("is no table of choices: {e}")))?;
    for choice in &choices {
        choice.params(&Params::default()).map_err(|failure| failure.of(path.display()))?;
    }
    Ok(choices)
}

impl Choice {
    /// `params` without this choice.
    pub(super) fn params(&self, params: &Params) -> Result<Params> {
        let mut without = params.clone();
        without.apply(&self.without).map_err(|e| Failure::about(&self.name, e))?;
        if !self.without.0.is_empty() && without == Params::default() {
            return Err(Failure::about(&self.name, "its settings are the defaults: they take nothing away"));
        }
        Ok(without)
    }

    /// Our values of what these settings change.
    pub(super) fn ours(&self) -> String {
        let values = self.without.flatten().into_iter().map(|(name, _)| format!("`{name}` {}", default_of(&name)));
        let values: Vec<String> = values.collect();
        if values.is_empty() { "in force always".to_owned() } else { values.join(", ") }
    }

    /// These settings as arguments of the command line.
    pub(super) fn arguments(&self) -> String {
        let plain = |value: &ParamValue| match value {
            ParamValue::Text(text) => text.clone(),
            other => other.to_string(),
        };
        let settings = self.without.flatten().into_iter().map(|(name, value)| format!("--set {name}={}", plain(value)));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_choice_of_the_table_is_in_force_and_can_be_taken_away() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/choices.json");
        let choices = read_choices(&path).unwrap();
        assert!(choices.len() > 20, "{} choices", choices.len());
        for choice in &choices {
            for (name, value) in choice.without.flatten() {
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
        let text =
            r#"{"name": "a", "paper": "b", "why": "c", "without": {"cut": {"byLength": false, "strangerWeight": 0}}}"#;
        let choice: Choice = serde_json::from_str(text).unwrap();
        assert_eq!(choice.ours(), "`cut.byLength` true, `cut.strangerWeight` 1");
        assert_eq!(choice.arguments(), "--set cut.byLength=false --set cut.strangerWeight=0");
        assert_eq!(choice.params(&Params::default()).unwrap().cut.stranger_weight, 0.0);
    }
}
