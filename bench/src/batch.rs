//! What all evaluations of a folder of sequences share: some arguments, finding and running the sequences, and the file of
//! figures.

use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use tracecut::{Params, Session};
use tracecut_cli::failure::{Failure, Result, cannot_read, write};
use tracecut_cli::input::Input;
use tracecut_cli::log::Log;
use tracecut_cli::run::{Seconds, run};
use tracecut_cli::settings::Settings;

/// The command that starts this program, for the files that it writes.
pub(super) const PROGRAM: &str = "cargo run --release -p tracecut-bench --";

/// Refuses parameters under which there are no masks.
pub(super) fn require_dense(params: &Params) -> Result<()> {
    if params.clip.dense {
        return Ok(());
    }
    Err(Failure::usage("clip.dense is false, so that there would be no masks to score: leave it on".to_owned()))
}

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

impl Batch {
    /// Calls `work` on every sequence and `report` on every outcome, in order; a failure has the sequence's name.
    pub(super) fn run<S: Sync, O: Send>(
        &self,
        sequences: &[S],
        name: fn(&S) -> &str,
        work: impl Fn(&S) -> Result<O> + Sync,
        report: impl Fn(&O) -> Result<()>,
    ) -> Result<Vec<O>> {
        let named = |sequence: &S| work(sequence).map_err(|failure| failure.with_subject(name(sequence)));
        in_order(sequences, self.jobs as usize, named, report)
    }
}

/// The first frames of a clip, or all, through the pipeline on one thread, as clips run side by side; and how long that
/// took.
pub(super) fn run_clip(images: &Path, frames: Option<u32>, params: Params) -> Result<(Session, Seconds)> {
    let (session, timing) = run(&Input::open(images, frames)?, params, 1, &Log::quiet())?;
    Ok((session, timing.total))
}

/// Writes all figures as JSON, where a file is named for them.
pub(super) fn write_json(path: Option<&Path>, report: &impl Serialize) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    let text = serde_json::to_string_pretty(report).map_err(|e| Failure::about(path.display(), e))?;
    write(path, text + "\n")
}

/// Opens the sequences among the sub-folders of `folder`, by name, or those named in `only`; `open` returns `None` for other
/// folders. It is an error if there are none, or one of `only` is missing; `expected` describes a sequence.
pub(super) fn sequences<T>(
    folder: &Path,
    only: &[String],
    expected: &str,
    open: impl Fn(&Path, &str) -> Result<Option<T>>,
) -> Result<Vec<T>> {
    let cannot = |e| cannot_read(folder, &e);
    let mut matches = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(cannot)? {
        let path = entry.map_err(cannot)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if only.is_empty() || only.contains(&name) {
            matches.extend(open(&path, &name)?.map(|sequence| (name, sequence)));
        }
    }
    if let Some(missing) = only.iter().find(|name| matches.iter().all(|(n, _)| n != *name)) {
        return Err(Failure::about(folder.display(), format_args!("holds no sequence named {missing}")));
    }
    if matches.is_empty() {
        return Err(Failure::about(folder.display(), format_args!("holds no sequence (expected {expected})")));
    }
    matches.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(matches.into_iter().map(|(_, sequence)| sequence).collect())
}

/// Calls `work` on every item, up to `jobs` at a time, and `report` on every result in the items' order as soon as it
/// and all before it are there. Ends at the first failure in that order.
pub(crate) fn in_order<I: Sync, O: Send>(
    items: &[I],
    jobs: usize,
    work: impl Fn(&I) -> Result<O> + Sync,
    report: impl Fn(&O) -> Result<()>,
) -> Result<Vec<O>> {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..jobs.min(items.len()) {
            let (sender, next, work) = (sender.clone(), &next, &work);
            scope.spawn(move || {
                while let Some((index, item)) = items.iter().enumerate().nth(next.fetch_add(1, Ordering::Relaxed)) {
                    if sender.send((index, work(item))).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        let mut waiting: Vec<Option<Result<O>>> = items.iter().map(|_| None).collect();
        let mut results = Vec::new();
        for (index, result) in receiver {
            waiting[index] = Some(result);
            while let Some(result) = waiting.get_mut(results.len()).and_then(Option::take) {
                // On a failure the receiver is dropped, and the threads end after the sequence at hand.
                let result = result?;
                report(&result)?;
                results.push(result);
            }
        }
        Ok(results)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Condvar, Mutex};

    #[test]
    fn results_come_in_the_order_of_the_items_whatever_finishes_first() {
        let items: Vec<u64> = vec![4, 0, 2, 1, 3];
        let (seen, finished, changed) = (Mutex::new(Vec::new()), Mutex::new(0), Condvar::new());
        // The first item is finished last.
        let work = |&item: &u64| {
            let count = finished.lock().unwrap();
            let mut count = changed.wait_while(count, |count| item == 4 && *count < 4).unwrap();
            *count += 1;
            changed.notify_all();
            Ok(item)
        };
        let report = |&item: &u64| {
            seen.lock().unwrap().push(item);
            Ok(())
        };
        let all = in_order(&items, 3, work, report).unwrap();
        assert_eq!((&all, &*seen.lock().unwrap()), (&items, &items));
    }

    #[test]
    fn the_first_failure_in_order_ends_the_run() {
        let work = |&n: &u32| if n >= 2 { Err(Failure::new(format!("item {n}"))) } else { Ok(n) };
        let failure = in_order(&[0, 1, 2, 3], 2, work, |_| Ok(())).unwrap_err();
        assert_eq!(failure.reason, "item 2");
        assert!(in_order(&[] as &[u32], 2, work, |_| Ok(())).unwrap().is_empty());
    }
}
