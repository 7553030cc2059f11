//! docs/cli.md against the program's own help.

use super::{text, tracecut};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

fn document() -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/cli.md")).unwrap().replace('\r', "")
}

fn help(command: &str) -> String {
    text(&tracecut([command, "--help"]).stdout)
}

/// Returns the names of the commands, as the program lists them.
fn commands() -> Vec<String> {
    let help = text(&tracecut(["--help"]).stdout);
    let list = help.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap().to_owned();
    let names: Vec<String> = list.lines().map(|line| line.split_whitespace().next().unwrap().to_owned()).collect();
    names.into_iter().filter(|name| name != "help").collect()
}

/// Returns the words of a text that begin with `--`.
fn options(text: &str) -> BTreeSet<String> {
    let parts = text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-'));
    parts.filter(|word| word.starts_with("--") && word.len() > 3).map(str::to_owned).collect()
}

/// Returns the part of a text from `begin` on, up to `end`.
fn between<'a>(text: &'a str, begin: &str, end: &str) -> &'a str {
    let (_, rest) = text.split_once(begin).unwrap_or_else(|| panic!("\"{begin}\" is missing: {text}"));
    rest.split(end).next().unwrap()
}

#[test]
fn every_command_and_option_is_described() {
    let document = document();
    let described = options(&document);
    let commands = commands();
    assert!(commands.len() >= 8, "{commands:?}");
    for command in commands {
        assert!(document.contains(&format!("tracecut {command}")), "{command}");
        let mut own = options(&help(&command));
        own.retain(|option| option != "--help" && !described.contains(option));
        assert!(own.is_empty(), "{command}: {own:?}");
    }
}

#[test]
fn every_format_and_file_of_results_is_described() {
    let (document, help) = (document(), help("segment"));
    let table = between(&document, "| format | file | content |", "\n\n");
    let values =
        between(&help, "Possible values:\n", "[default").lines().filter_map(|line| line.trim().strip_prefix("- "));
    let values: Vec<&str> = values.filter_map(|line| line.split(':').next()).collect();
    let is_missing = |name: &&str| !table.contains(&format!("\n| `{name}` | "));
    let missing: Vec<&str> = values.iter().copied().filter(is_missing).collect();
    assert!(values.len() >= 6 && missing.is_empty(), "{values:?}, {missing:?}");
    let files = between(&help, "Results in the folder:\n", "\n\n");
    let names = files.lines().filter_map(|line| line.strip_prefix("  ")).filter(|line| !line.starts_with(' '));
    for name in names.map(|line| line.split_whitespace().next().unwrap()) {
        assert!(table.contains(&format!("`{name}`")), "{name}");
    }
}

#[test]
fn segment_and_explain_list_the_same_kinds_of_input_as_the_document() {
    let kinds = |command: &str| {
        between(&help(command), "Arguments:\n", "\n\n")
            .split_once('>')
            .unwrap()
            .1
            .trim_matches(['.', ' ', '\n'])
            .to_owned()
    };
    let (segment, explain) = (kinds("segment"), kinds("explain"));
    assert_eq!(segment, explain);
    let document = document();
    let input = between(&document, "## Input\n", "\n\n`tracecut");
    for kind in ["PNG, JPEG or PPM", ".bmf", "animated GIF, PNG or WebP", "Y4M", "ffmpeg", "standard input"] {
        assert!(segment.contains(kind) && input.contains(kind), "{kind}: {segment}");
    }
}

#[test]
fn exit_codes_are_those_of_the_help() {
    let help = text(&tracecut(["--help"]).stdout);
    let told = between(&help, "Exit codes", "\u{0}").lines().skip(1);
    let told: BTreeSet<&str> = told.filter_map(|line| line.split_whitespace().next()).collect();
    let document = document();
    let table = between(&document, "| exit code | meaning |\n|---|---|\n", "\n\n");
    let rows: Vec<&str> = table.lines().map(|line| between(line, "| ", " |")).collect();
    assert_eq!(rows, ["0", "1", "2", "3", "4", "130, 143"]);
    assert!(rows.iter().all(|row| told.contains(row.split(',').next().unwrap())), "{told:?}");
}

#[test]
fn events_have_the_described_names_and_fields() {
    let document = document();
    let table = between(&document, "| `event` | fields |", "\n\n");
    for name in ["begin", "progress", "window", "done", "complete", "truncated", "error"] {
        assert!(table.contains(&format!("`{name}`")), "{name}");
    }
    for field in ["stage", "share", "secondsLeft"] {
        assert!(table.contains(&format!("`{field}`")), "{field}");
    }
}
