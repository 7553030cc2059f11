//! Parameters from the command line: a JSON file, then single settings.

use crate::failure::{Failure, Result, print, read_text};
use clap::Args;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use tracecut::Params;
use tracecut::params::ParamValue;

#[derive(Args, Debug)]
pub struct Settings {
    /// JSON file of parameters, e.g. {"clip": {"maxSide": 960}}; `tracecut params` lists them
    #[arg(long, value_name = "FILE")]
    params: Option<PathBuf>,
    /// Set one parameter, after the file; may be repeated. preset=paper chooses the parameters of the paper
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = parse_setting)]
    settings: Vec<(String, ParamValue)>,
}

impl Settings {
    /// Returns the defaults changed by the file, then by each `--set` in order.
    pub fn params(&self) -> Result<Params> {
        let mut params = Params::default();
        if let Some(path) = &self.params {
            apply(&mut params, path, &read_text(path)?)?;
        }
        for (name, value) in &self.settings {
            params.set(name, value)?;
        }
        Ok(params)
    }

    /// Returns the parameters of a command that only uses those with these names, or sections that end with a dot. A file may
    /// also hold others, for other commands.
    pub(crate) fn params_of(&self, used: &[&str]) -> Result<Params> {
        let is_used =
            |name: &str| used.iter().any(|&part| name == part || (part.ends_with('.') && name.starts_with(part)));
        if let Some((name, value)) = self.settings.iter().find(|(name, _)| name != "preset" && !is_used(name)) {
            let form = |part: &&str| if part.ends_with('.') { format!("{part}*") } else { (*part).to_owned() };
            let used: Vec<String> = used.iter().map(form).collect();
            return Err(Failure::usage(format!(
                "{name} = {value} (expected a parameter of this command: {})",
                used.join(", ")
            )));
        }
        self.params()
    }
}

/// Applies the JSON of file `path` to `params`.
pub(crate) fn apply(params: &mut Params, path: &Path, json: &str) -> Result<()> {
    let tree: BTreeMap<String, ParamValue> = serde_json::from_str(json)
        .map_err(|e| Failure::usage(format!("is not a JSON object of parameters: {e}")).with_subject(path.display()))?;
    params.apply(&tree).map_err(|e| Failure::from(e).with_subject(path.display()))
}

/// Parses `key=value`: true and false, numbers, or text (the name of a preset or a choice).
pub(crate) fn parse_setting(text: &str) -> std::result::Result<(String, ParamValue), String> {
    let (name, value) =
        text.split_once('=').ok_or_else(|| "expected KEY=VALUE, such as flow.patchStride=5".to_owned())?;
    let value = match value.trim() {
        "true" => ParamValue::Bool(true),
        "false" => ParamValue::Bool(false),
        text => text.parse().map_or_else(|_| ParamValue::Text(text.to_owned()), ParamValue::Number),
    };
    Ok((name.trim().to_owned(), value))
}

#[derive(Args, Debug)]
pub(crate) struct ParamsArgs {
    /// List the parameters for research instead; all parameters can be set
    #[arg(long)]
    expert: bool,
}

/// Prints the parameters with range, default and meaning.
pub(crate) fn list(args: &ParamsArgs) -> Result<()> {
    let (mut lines, mut num_hidden) = (Vec::new(), 0);
    Params::default().for_each(&mut |field| {
        if field.expert != args.expert {
            num_hidden += 1;
            return;
        }
        let (low, high) = (field.min, field.max);
        let form = match field.kind() {
            "choice" => {
                let names = field.choices();
                format!("{}, default {}", names.join(" or "), names[field.get() as usize])
            }
            "boolean" => format!("true or false, default {}", field.get() != 0.0),
            "integer" => format!("whole number, {low}..={high}, default {}", field.get()),
            _ => format!("number, {low}..={high}, default {}", field.get()),
        };
        lines.push(format!("{}  ({form})", field.name));
        lines.extend(field.doc.lines().map(|l| format!("    {}", l.trim())));
    });
    if !args.expert {
        lines.push(format!("\n{num_hidden} more parameters, for research: tracecut params --expert"));
    }
    print(lines.join("\n"))
}
