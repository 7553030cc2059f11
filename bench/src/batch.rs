//! What all evaluations of a folder of sequences share: some arguments, and finding the sequences.

use clap::Args;
use std::path::{Path, PathBuf};
use tracecut_cli::failure::{Failure, Result};
use tracecut_cli::settings::Settings;

#[derive(Args, Debug)]
pub(super) struct Batch {
    /// Write all figures and the parameters to this file
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
    /// Only the sequences whose names these are
    #[arg(long, alias = "sequences", value_name = "NAME,...", value_delimiter = ',')]
    pub(super) only: Vec<String>,
    /// Number of sequences to work on at once
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=256))]
    pub(super) jobs: u32,
    #[command(flatten)]
    pub(super) settings: Settings,
}

/// What `open` makes of the sub-folders of `folder`, by name; `None` where one is no sequence. With `only` not empty,
/// those with these names. None at all, or one of `only` missing, is an error; `expected` says what a sequence is.
pub(super) fn sequences<T>(
    folder: &Path,
    only: &[String],
    expected: &str,
    open: impl Fn(&Path, &str) -> Result<Option<T>>,
) -> Result<Vec<T>> {
    let cannot = |e| Failure::about(folder.display(), format_args!("cannot be read: {e}"));
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(cannot)? {
        let path = entry.map_err(cannot)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if only.is_empty() || only.contains(&name) {
            found.extend(open(&path, &name)?.map(|sequence| (name, sequence)));
        }
    }
    if found.is_empty() {
        return Err(Failure::about(folder.display(), format_args!("holds no sequence (expected {expected})")));
    }
    if let Some(missing) = only.iter().find(|name| found.iter().all(|(n, _)| n != *name)) {
        return Err(Failure::about(folder.display(), format_args!("holds no sequence named {missing}")));
    }
    found.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(found.into_iter().map(|(_, sequence)| sequence).collect())
}
