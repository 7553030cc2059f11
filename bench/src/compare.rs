//! `--compare`: differences of figures to those of an earlier file, run by run.

use super::report::{Column, ERROR_WIDTH, Outcome, Run, Scores};
use super::runs::{Excerpt, RunId};
use crate::measures::estimate::Estimate;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use tracecut_cli::failure::{Failure, Result, read};

/// Figures that an earlier `--json` of the same command wrote.
#[derive(Debug)]
pub(crate) struct Earlier {
    path: PathBuf,
    content: Content,
}

#[derive(Debug, Deserialize)]
struct Content {
    frames: Option<u32>,
    clips: Vec<EarlierClip>,
}

#[derive(Debug, Deserialize)]
struct EarlierClip {
    name: String,
    kind: String,
    runs: Vec<EarlierRun>,
}

#[derive(Debug, Deserialize)]
struct EarlierRun {
    #[serde(flatten)]
    id: RunId,
    #[serde(flatten)]
    figures: BTreeMap<String, serde_json::Value>,
}

impl Earlier {
    /// Reads the file, if there is one, and makes sure that its runs are of as many frames.
    pub(crate) fn read(path: Option<&Path>, frames: Option<u32>) -> Result<Option<Self>> {
        let Some(path) = path else { return Ok(None) };
        let content: Content = serde_json::from_slice(&read(path)?)
            .map_err(|e| Failure::about(path.display(), format_args!("is no file of figures of this command: {e}")))?;
        if content.frames != frames {
            let of = |frames: Option<u32>| frames.map_or_else(|| "all frames".to_owned(), |n| format!("--frames {n}"));
            let reason = format!("has figures of {} (expected {})", of(content.frames), of(frames));
            return Err(Failure::about(path.display(), reason));
        }
        Ok(Some(Self { path: path.to_owned(), content }))
    }

    /// Makes sure that the file has a clip's runs of these excerpts under these seeds; an error says which it has not.
    pub(crate) fn require(&self, kind: &str, name: &str, excerpts: &[Excerpt], seeds: &[u32]) -> Result<()> {
        let mut ids = excerpts.iter().flat_map(|excerpt| seeds.iter().map(|&seed| excerpt.run_id(seed)));
        ids.try_for_each(|id| self.run(kind, name, id).map(|_| ()))
    }

    /// Returns the run of a clip with this id.
    fn run(&self, kind: &str, name: &str, id: RunId) -> Result<&EarlierRun> {
        let missing = |reason: String| Failure::about(self.path.display(), reason);
        let clip = self.content.clips.iter().find(|clip| clip.name == name && clip.kind == kind);
        let clip = clip.ok_or_else(|| missing(format!("has no clip {name} of kind {kind}")))?;
        clip.runs.iter().find(|run| run.id == id).ok_or_else(|| missing(format!("has no run of {name} {id}")))
    }

    /// Returns the rows of the differences of kinds and of all, then those of the clips that changed most.
    pub(crate) fn lines<S: Scores>(&self, clips: &[Outcome<S>]) -> Result<Vec<String>> {
        let columns = || S::COLUMNS.iter().enumerate().filter(|(_, column)| column.has_error);
        let titles = columns().map(|(_, c)| format!("{:>width$}{:>ERROR_WIDTH$} ", c.heading, "SE", width = c.width));
        let head = format!("{:width$}{}", "difference", titles.collect::<String>(), width = S::HEAD_WIDTH);
        let mut lines = vec![String::new(), format!("compared with {}", self.path.display()), head];
        let changes = clips.iter().map(|clip| self.changes(clip)).collect::<Result<Vec<Vec<Option<Change>>>>>()?;
        let mut kinds: Vec<&str> = clips.iter().map(|clip| clip.kind.as_str()).collect();
        kinds.sort_unstable();
        kinds.dedup();
        let differences = |k: usize, is_selected: &dyn Fn(&str) -> bool| -> Vec<f64> {
            let selected = clips.iter().zip(&changes).filter(|(clip, _)| is_selected(&clip.kind));
            selected.filter_map(|(_, changes)| Some(changes[k]?.difference())).collect()
        };
        let row = |title: String, estimate: &dyn Fn(usize) -> Option<Estimate>| {
            let cells: String = columns().map(|(k, column)| cell(column, estimate(k))).collect();
            format!("{title:width$}{}", cells.trim_end(), width = S::HEAD_WIDTH)
        };
        for &kind in &kinds {
            let count = clips.iter().filter(|clip| clip.kind == kind).count();
            let of_kind = |k: usize| Estimate::of(&differences(k, &|of| of == kind));
            lines.push(row(format!("{kind} ({count})"), &of_kind));
        }
        let over_kinds = |k: usize| {
            let groups = kinds.iter().map(|kind| differences(k, &|of| of == *kind));
            Estimate::of_groups(&groups.filter(|group| !group.is_empty()).collect::<Vec<_>>())
        };
        lines.push(row(format!("mean of kinds ({})", kinds.len()), &over_kinds));
        lines.push(row(format!("mean of clips ({})", clips.len()), &|k| Estimate::of(&differences(k, &|_| true))));
        lines.extend(largest_changes(clips, &changes));
        Ok(lines)
    }

    /// Returns the change of each figure of a clip; `None` if no run has the figure in both files.
    fn changes<S: Scores>(&self, clip: &Outcome<S>) -> Result<Vec<Option<Change>>> {
        let pair = |run: &Run<S>| Ok((self.run(&clip.kind, &clip.name, run.id)?, run.scores.values()));
        let pairs = clip.runs.iter().map(pair).collect::<Result<Vec<_>>>()?;
        let change = |(k, column): (usize, &Column)| {
            let values = pairs.iter().filter_map(|(earlier, now)| {
                Some(Change { before: earlier.figures.get(column.name)?.as_f64()?, now: now[k]? })
            });
            Change::mean_of(&values.collect::<Vec<_>>())
        };
        Ok(S::COLUMNS.iter().enumerate().map(change).collect())
    }
}

/// A figure in the file and now.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Change {
    before: f64,
    now: f64,
}

impl Change {
    /// Computes the mean change of runs; `None` without one.
    fn mean_of(runs: &[Self]) -> Option<Self> {
        let over = |value: fn(&Self) -> f64| runs.iter().map(value).sum::<f64>() / runs.len() as f64;
        (!runs.is_empty()).then(|| Self { before: over(|c| c.before), now: over(|c| c.now) })
    }

    fn difference(self) -> f64 {
        self.now - self.before
    }
}

/// Formats a difference, its standard error and a star if it is significant.
fn cell(column: &Column, difference: Option<Estimate>) -> String {
    let (width, decimals) = (column.width, column.decimals);
    let Some(difference) = difference else { return format!("{:>width$}{:>ERROR_WIDTH$} ", "-", "-") };
    let error = difference.standard_error.map_or_else(|| "-".to_owned(), |error| format!("{error:.decimals$}"));
    let mark = if difference.is_significant() { '*' } else { ' ' };
    format!("{:+width$.decimals$}{error:>ERROR_WIDTH$}{mark}", difference.mean)
}

/// Formats the clips whose first figure changed most.
fn largest_changes<S: Scores>(clips: &[Outcome<S>], changes: &[Vec<Option<Change>>]) -> Vec<String> {
    let Some(column) = S::COLUMNS.first() else { return Vec::new() };
    let (width, decimals) = (column.width, column.decimals);
    let pairs = clips.iter().zip(changes).filter_map(|(clip, changes)| Some((clip, (*changes.first()?)?)));
    let large = pairs.filter(|(_, change)| change.difference().abs() > S::LARGE_CHANGE);
    let row = |(clip, Change { before, now }): (&Outcome<S>, Change)| {
        format!("{:head$}{before:width$.decimals$}{now:width$.decimals$}", clip.name, head = S::HEAD_WIDTH)
    };
    let mut rows: Vec<String> = large.map(row).collect();
    let title = format!("{} changed by more than {}", column.heading, S::LARGE_CHANGE);
    if rows.is_empty() {
        return vec![String::new(), format!("of no clip {title}")];
    }
    let head = format!("{title:head$}{:>width$}{:>width$}", "before", "now", head = S::HEAD_WIDTH);
    rows.splice(0..0, [String::new(), head]);
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Serialize;
    use tracecut_cli::run::Seconds;

    #[derive(Serialize)]
    struct Toy {
        j: Option<f64>,
    }

    impl Scores for Toy {
        const COLUMNS: &'static [Column] =
            &[Column { name: "j", heading: "J", width: 7, decimals: 3, has_error: true }];
        const HEAD_WIDTH: usize = 18;
        const LARGE_CHANGE: f64 = 0.05;

        fn values(&self) -> Vec<Option<f64>> {
            vec![self.j]
        }
    }

    fn clip(name: &str, kind: &str, values: &[Option<f64>]) -> Outcome<Toy> {
        let run = |(k, &j): (usize, &Option<f64>)| {
            let id = RunId { start: 10 * (k / 2), mirrored: k % 2 == 1, seed: 0 };
            Run { id, frames: 20, scores: Toy { j }, time: Seconds::default() }
        };
        Outcome::new(name, kind, values.iter().enumerate().map(run).collect())
    }

    /// The file that a run with these clips writes.
    fn earlier(clips: &[Outcome<Toy>]) -> Earlier {
        let text = serde_json::json!({ "frames": 20, "clips": clips, "meanOfClips": {} }).to_string();
        Earlier { path: PathBuf::from("old.json"), content: serde_json::from_str(&text).unwrap() }
    }

    #[test]
    fn differences_are_paired_run_by_run_and_their_errors_go_over_clips() {
        let old = earlier(&[
            clip("c", "two", &[Some(0.5)]),
            clip("a", "one", &[Some(0.25), Some(0.75)]),
            clip("unused", "one", &[]),
            clip("b", "one", &[Some(0.5), None]),
        ]);
        // Clip a gains 0.1 and 0.3, clip b 0.1 in the one run that has both, clip c loses 0.02.
        let now = [
            clip("a", "one", &[Some(0.35), Some(1.05)]),
            clip("b", "one", &[Some(0.6), Some(0.9)]),
            clip("c", "two", &[Some(0.48)]),
        ];
        let lines = old.lines(&now).unwrap();
        assert_eq!(lines[..3], ["", "compared with old.json", "difference              J     SE "]);
        // 0.15 with differences of 0.2 and 0.1: sd 0.0707, by the root of 2.
        assert_eq!(lines[3], "one (2)            +0.150  0.050*");
        assert_eq!(lines[4], "two (1)            -0.020      -");
        // Weights of 1/4, 1/4 and 1/2: mean 0.065, squares of weight times deviation 0.003022, times 3/2.
        assert_eq!(lines[5], "mean of kinds (2)  +0.065  0.067");
        // Mean 0.0933, sd 0.1102, by the root of 3.
        assert_eq!(lines[6], "mean of clips (3)  +0.093  0.064");
        assert_eq!(lines[8], "J changed by more than 0.05 before    now");
        assert_eq!(lines[9..], ["a                   0.500  0.700", "b                   0.500  0.600"]);
        let same = earlier(&now).lines(&now).unwrap();
        assert_eq!(same.last().unwrap(), "of no clip J changed by more than 0.05");
        assert_eq!(same[3], "one (2)            +0.000  0.000");
    }

    #[test]
    fn clips_and_runs_that_the_file_has_not_are_named() {
        let old = earlier(&[clip("a", "one", &[Some(0.25)])]);
        let failure = old.lines(&[clip("a", "one", &[Some(0.25), Some(0.5)])]).unwrap_err();
        assert_eq!(failure.reason, "old.json: has no run of a from frame 0, mirrored, seed 0");
        let failure = old.lines(&[clip("a", "two", &[Some(0.25)])]).unwrap_err();
        assert_eq!(failure.reason, "old.json: has no clip a of kind two");
        let excerpt = Excerpt { start: 0, images: Vec::new(), mirrored: false };
        old.require("one", "a", std::slice::from_ref(&excerpt), &[0]).unwrap();
        let failure = old.require("one", "a", &[excerpt], &[0, 3]).unwrap_err();
        assert_eq!(failure.reason, "old.json: has no run of a from frame 0, seed 3");
    }
}
