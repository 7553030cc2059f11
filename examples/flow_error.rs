//! Prints the end-point error of the flow for every pair of a Middlebury folder, and the time of a field:
//! `cargo run --release --example flow_error -- FOLDER [flow.name=value ...]`.
//!
//! Each subfolder holds two `.png` frames in order and, to count, a `.flo` file of the true flow.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;
use tracecut::eval::flow::{FlowTruth, end_point_error};
use tracecut::flow::{FlowPyramid, FlowScratch, flow_between_with};
use tracecut::image::Frame;
use tracecut::params::ParamValue;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().ok_or("a folder is needed")?);
    let mut params = tracecut::Params::default();
    for setting in arguments {
        let (name, value) = setting.split_once('=').ok_or("settings look like flow.name=value")?;
        params.set(name, &ParamValue::Number(value.parse()?))?;
    }
    let mut folders: Vec<PathBuf> =
        std::fs::read_dir(&folder)?.map(|e| e.map(|e| e.path())).collect::<Result<_, _>>()?;
    folders.sort();
    let mut scratch = FlowScratch::default();
    let (mut sum, mut count, mut seconds) = (0.0, 0.0, 0.0);
    for pair in &folders {
        let (Some(truth), frames) = (with_ending(pair, "flo")?.first().cloned(), with_ending(pair, "png")?) else {
            continue;
        };
        let truth = FlowTruth::from_flo(&std::fs::read(truth)?)?;
        let [from, to] = frames.as_slice() else { continue };
        let (from, to) = (Frame::decode(&std::fs::read(from)?)?.luma(), Frame::decode(&std::fs::read(to)?)?.luma());
        let (mut best, mut error) = (f64::INFINITY, 0.0);
        for _ in 0..2 {
            let begin = Instant::now();
            let pyramids = [&from, &to].map(|luma| FlowPyramid::new(luma, &params.flow));
            let flow = flow_between_with(&pyramids[0], &pyramids[1], &params.flow, &mut scratch);
            best = begin.elapsed().as_secs_f64().min(best);
            error = end_point_error(&flow, &truth)?;
        }
        print!("{} {error:.3}  ", pair.file_name().unwrap_or_default().to_string_lossy());
        (sum, count, seconds) = (sum + error, count + 1.0, seconds + best);
    }
    println!("\nmean {:.4} px, {:.1} ms a field", sum / count, 1000.0 * seconds / count);
    Ok(())
}

/// The files of `folder` whose names end in `ending`, sorted.
fn with_ending(folder: &Path, ending: &str) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut files = Vec::new();
    if folder.is_dir() {
        for entry in std::fs::read_dir(folder)? {
            let path = entry?.path();
            if path.extension().is_some_and(|e| e == ending) {
                files.push(path);
            }
        }
    }
    files.sort();
    Ok(files)
}
