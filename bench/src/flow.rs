//! `bench flow`: end-point error on frame pairs with known flow.

use crate::measures::flow::{FlowTruth, end_point_error};
use clap::Args;
use std::path::{Path, PathBuf};
use tracecut::Params;
use tracecut::flow::{FlowField, FlowPyramid, flow_between};
use tracecut_cli::failure::{Failure, Result, print, read};
use tracecut_cli::input::decode;
use tracecut_cli::run::Clock;
use tracecut_cli::settings::Settings;

#[derive(Args, Debug)]
pub(crate) struct FlowArgs {
    /// Folder with one sub-folder for each pair; those without flow10.flo are left out
    folder: PathBuf,
    /// Runs of each pair; the fastest counts
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    repeat: u32,
    #[command(flatten)]
    settings: Settings,
}

pub(super) fn eval(args: &FlowArgs) -> Result<()> {
    let params = args.settings.params()?;
    let pairs = find_pairs(&args.folder)?;
    print("pair              error px   ms a field")?;
    let mut rows = Vec::new();
    for pair in &pairs {
        let (error, ms) = run_pair(pair, &params, args.repeat)?;
        let name = pair.file_name().unwrap_or_default().to_string_lossy();
        print(row(&name, error, ms))?;
        rows.push((error, ms));
    }
    let mean = |value: fn(&(f64, f64)) -> f64| rows.iter().map(value).sum::<f64>() / rows.len() as f64;
    print(row(&format!("mean of {}", rows.len()), mean(|r| r.0), mean(|r| r.1)))
}

fn row(name: &str, error: f64, ms: f64) -> String {
    format!("{name:16} {error:9.4} {ms:12.1}")
}

fn find_pairs(folder: &Path) -> Result<Vec<PathBuf>> {
    let cannot = |e| Failure::about(folder.display(), format_args!("cannot be read: {e}"));
    let mut pairs = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(cannot)? {
        let path = entry.map_err(cannot)?.path();
        if path.join("flow10.flo").is_file() {
            pairs.push(path);
        }
    }
    if pairs.is_empty() {
        let reason = "holds no pair (expected sub-folders with frame10.png, frame11.png and flow10.flo)";
        return Err(Failure::about(folder.display(), reason));
    }
    pairs.sort();
    Ok(pairs)
}

/// Mean end-point error in pixels and milliseconds for one field, both pyramids included.
fn run_pair(folder: &Path, params: &Params, repeat: u32) -> Result<(f64, f64)> {
    let truth_path = folder.join("flow10.flo");
    let truth = FlowTruth::from_flo(&read(&truth_path)?).map_err(|e| Failure::about(truth_path.display(), e))?;
    let from = decode(&folder.join("frame10.png"))?;
    let to = decode(&folder.join("frame11.png"))?;
    if (from.width(), from.height()) != (to.width(), to.height()) {
        return Err(Failure::about(folder.display(), "frame10.png and frame11.png differ in size"));
    }
    let (from, to) = (from.luma(), to.luma());
    let mut fastest = f64::INFINITY;
    let mut field = FlowField::default();
    for _ in 0..repeat {
        let clock = Clock::start();
        field = flow_between(&FlowPyramid::from_luma(&from), &FlowPyramid::from_luma(&to), &params.flow);
        fastest = fastest.min(1000.0 * clock.seconds().best());
    }
    let error = end_point_error(&field, &truth).map_err(|e| Failure::about(folder.display(), e))?;
    Ok((error, fastest))
}
