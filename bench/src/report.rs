//! The table and the JSON file of clips that are run several times: figures of clips, of kinds and overall, each a mean
//! with its standard error.

use super::runs::RunId;
use crate::measures::estimate::Estimate;
use serde::Serialize;
use std::collections::BTreeMap;
use tracecut::Params;
use tracecut_cli::run::Seconds;

/// Describes the figures, for `--help`.
pub(super) const RUNS_HELP: &str = "\
With --starts, --mirror and --seeds all combinations are run; seeds share flow and superpixels (but not in windows).
A later start is left out if fewer than 10 frames (or --frames) follow it, or if none of them could be scored. Figures of a clip are means
over its runs. SE is the standard error of the figure on its left: that of a clip is the standard deviation over its runs by the root of
their number; that of a kind or of all follows from the clips' (root of the sum of squares, by their number). So it says how much of a figure
is chance of the runs, not of the choice of clips; it is unknown (-) if a clip has a single run.

With --compare the rows below have the figures less those of the file, run by run, as means over the runs of each clip and then over clips.
Their SE is the standard deviation over the clips by the root of their number (of a weighted mean for the mean of kinds); a star marks
differences of more than two SE. The file has to have all these clips and runs, of as many frames. Clips that changed much follow.

The kind of a clip is what stands before -- in its name, or else the name of DIR.";

/// A figure of runs: its name in JSON, and its column.
pub(super) struct Column {
    pub(super) name: &'static str,
    pub(super) heading: &'static str,
    pub(super) width: usize,
    pub(super) decimals: usize,
    /// True if its standard error has a column.
    pub(super) has_error: bool,
}

/// Width of a column of standard errors.
pub(super) const ERROR_WIDTH: usize = 7;

/// The scores of a run.
pub(super) trait Scores: Serialize {
    const COLUMNS: &'static [Column];
    /// Width of what stands before the columns.
    const HEAD_WIDTH: usize;
    /// A change of the first figure of a clip that `--compare` shows.
    const LARGE_CHANGE: f64;

    /// Returns the figures in the order of the columns; `None` if undefined.
    fn values(&self) -> Vec<Option<f64>>;
}

/// A run of a clip and its scores.
#[derive(Debug, Serialize)]
pub(super) struct Run<S> {
    #[serde(flatten)]
    pub(super) id: RunId,
    pub(super) frames: usize,
    #[serde(flatten)]
    pub(super) scores: S,
    #[serde(flatten)]
    pub(super) time: Seconds,
}

/// Figures by name; those that are undefined are missing.
type Summary = BTreeMap<&'static str, Estimate>;

/// The runs of a clip.
#[derive(Debug, Serialize)]
pub(super) struct Outcome<S> {
    pub(super) name: String,
    pub(super) kind: String,
    pub(super) runs: Vec<Run<S>>,
    pub(super) mean: Summary,
}

/// Means over some clips or kinds.
#[derive(Debug, Serialize)]
struct Group {
    clips: usize,
    #[serde(flatten)]
    mean: Summary,
}

/// The content of the file of `--json`.
#[derive(Serialize)]
#[serde(rename_all = "camelCase", bound = "S: Scores")]
pub(super) struct Report<'a, S: Scores> {
    frames: Option<u32>,
    pub(super) clips: &'a [Outcome<S>],
    kinds: BTreeMap<&'a str, Group>,
    mean_of_kinds: Group,
    mean_of_clips: Group,
    params: &'a Params,
}

impl<S: Scores> Outcome<S> {
    pub(super) fn new(name: &str, kind: &str, runs: Vec<Run<S>>) -> Self {
        let rows: Vec<Vec<Option<f64>>> = runs.iter().map(|run| run.scores.values()).collect();
        let over_runs = |k: usize| Estimate::of(&rows.iter().filter_map(|row| row[k]).collect::<Vec<_>>());
        let mean = summary::<S>(|k, _| over_runs(k));
        Self { name: name.to_owned(), kind: kind.to_owned(), runs, mean }
    }

    /// Returns the processor seconds of all runs.
    pub(super) fn seconds(&self) -> f64 {
        self.runs.iter().map(|run| run.time.best()).sum()
    }

    /// Formats its row: `head`, the figures, `tail`. With `with_errors` they have their standard errors.
    pub(super) fn row(&self, head: &str, tail: &str, with_errors: bool) -> String {
        format!("{head:width$}{}{tail}", columns::<S>(&self.mean, with_errors), width = S::HEAD_WIDTH)
    }
}

impl<'a, S: Scores> Report<'a, S> {
    pub(super) fn new(clips: &'a [Outcome<S>], frames: Option<u32>, params: &'a Params) -> Self {
        let of_kinds = by_kind(clips);
        let kinds: BTreeMap<_, _> = of_kinds.iter().map(|(&kind, clips)| (kind, Group::of_clips(clips))).collect();
        let mean_of_kinds =
            Group { clips: clips.len(), mean: mean_of::<S>(&kinds.values().map(|g| &g.mean).collect::<Vec<_>>()) };
        let mean_of_clips = Group::of_clips(&clips.iter().collect::<Vec<_>>());
        Self { frames, clips, kinds, mean_of_kinds, mean_of_clips, params }
    }

    /// Returns the rows of the kinds and of all.
    pub(super) fn lines(&self, with_errors: bool) -> Vec<String> {
        let kinds = self.kinds.iter().map(|(&kind, group)| (kind, group.clips, group));
        let all = [
            ("mean of kinds", self.kinds.len(), &self.mean_of_kinds),
            ("mean of clips", self.clips.len(), &self.mean_of_clips),
        ];
        let row = |(title, count, group): (&str, usize, &Group)| group_row::<S>(title, count, &group.mean, with_errors);
        kinds.chain(all).map(row).collect()
    }
}

impl Group {
    fn of_clips<S: Scores>(clips: &[&Outcome<S>]) -> Self {
        Self { clips: clips.len(), mean: mean_of::<S>(&clips.iter().map(|clip| &clip.mean).collect::<Vec<_>>()) }
    }
}

/// Returns the clips of each kind.
pub(super) fn by_kind<S>(clips: &[Outcome<S>]) -> BTreeMap<&str, Vec<&Outcome<S>>> {
    let mut kinds: BTreeMap<&str, Vec<&Outcome<S>>> = BTreeMap::new();
    clips.iter().for_each(|clip| kinds.entry(&clip.kind).or_default().push(clip));
    kinds
}

/// Formats the row of a group of clips.
pub(super) fn group_row<S: Scores>(title: &str, count: usize, mean: &Summary, with_errors: bool) -> String {
    format!("{:width$}{}", format!("{title} ({count})"), columns::<S>(mean, with_errors), width = S::HEAD_WIDTH)
}

/// Computes each figure from its number and its column.
pub(super) fn summary<S: Scores>(figure: impl Fn(usize, &'static Column) -> Option<Estimate>) -> Summary {
    S::COLUMNS.iter().enumerate().filter_map(|(k, column)| Some((column.name, figure(k, column)?))).collect()
}

/// Computes the mean of each figure over those that have it.
fn mean_of<S: Scores>(means: &[&Summary]) -> Summary {
    let over = |name: &str| means.iter().filter_map(|mean| mean.get(name).copied()).collect::<Vec<_>>();
    summary::<S>(|_, column| Estimate::mean_of(&over(column.name)))
}

/// Formats the headings of the figures.
pub(super) fn heading<S: Scores>(with_errors: bool) -> String {
    let cell = |column: &Column| {
        let error = if with_errors && column.has_error { format!("{:>ERROR_WIDTH$}", "SE") } else { String::new() };
        format!("{:>width$}{error}", column.heading, width = column.width)
    };
    S::COLUMNS.iter().map(cell).collect()
}

fn columns<S: Scores>(mean: &Summary, with_errors: bool) -> String {
    let number = |value: Option<f64>, width: usize, decimals: usize| match value {
        Some(value) => format!("{value:width$.decimals$}"),
        None => format!("{:>width$}", "-"),
    };
    let cell = |column: &Column| {
        let estimate = mean.get(column.name);
        let mut text = number(estimate.map(|e| e.mean), column.width, column.decimals);
        if with_errors && column.has_error {
            text += &number(estimate.and_then(|e| e.standard_error), ERROR_WIDTH, column.decimals);
        }
        text
    };
    S::COLUMNS.iter().map(cell).collect()
}
