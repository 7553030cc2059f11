//! The table and the JSON file of `bench masks`: clips, kinds, all.

use crate::measures::masks::{Census, MaskScores};
use crate::measures::reliability::{Bin, Reliability};
use serde::Serialize;
use std::collections::BTreeMap;
use tracecut::Params;
use tracecut_cli::clock::Seconds;

/// Bins of the reliability with less of all pixels say little.
const FAIR_SHARE: f64 = 0.01;

/// The scores of a clip under one seed.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Run {
    pub(super) seed: u32,
    pub(super) frames: usize,
    #[serde(flatten)]
    pub(crate) scores: MaskScores,
    #[serde(flatten)]
    pub(super) census: Census,
    /// Frame by frame: its index and its scores.
    pub(super) of_frames: Vec<Scored>,
    #[serde(flatten)]
    pub(super) time: Seconds,
    /// Reliability of confidences; empty in windows.
    #[serde(skip)]
    pub(super) reliability: Reliability,
}

#[derive(Debug, Serialize)]
pub(super) struct Scored {
    pub(super) frame: usize,
    #[serde(flatten)]
    pub(super) scores: MaskScores,
}

/// The scores of a clip, seed by seed.
#[derive(Debug, Serialize)]
pub(super) struct Outcome {
    pub(super) name: String,
    pub(super) kind: String,
    pub(super) runs: Vec<Run>,
}

/// Means of some clips.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Group {
    clips: usize,
    #[serde(flatten)]
    scores: MaskScores,
    /// J under each seed.
    j_of_seeds: Vec<f64>,
}

/// The content of the file of `--json`.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Report<'a> {
    frames: Option<u32>,
    clips: &'a [Outcome],
    kinds: BTreeMap<&'a str, Group>,
    mean_of_kinds: Group,
    mean_of_clips: Group,
    /// Reliability of confidences, in tenths; `null` for an empty bin.
    reliability: Vec<Option<Bin>>,
    params: &'a Params,
}

impl<'a> Report<'a> {
    pub(super) fn new(clips: &'a [Outcome], frames: Option<u32>, params: &'a Params) -> Self {
        let mut by_kind: BTreeMap<&str, Vec<&Outcome>> = BTreeMap::new();
        clips.iter().for_each(|clip| by_kind.entry(&clip.kind).or_default().push(clip));
        let of_kinds: Vec<Vec<MaskScores>> = by_kind.values().map(|clips| seed_means(clips)).collect();
        let counts = by_kind.values().map(Vec::len);
        let kinds = by_kind.keys().zip(&of_kinds).zip(counts).map(|((&k, s), n)| (k, Group::new(n, s))).collect();
        let outcomes: Vec<&Outcome> = clips.iter().collect();
        let over_kinds = average_by_seed(&of_kinds);
        Self {
            frames,
            clips,
            kinds,
            mean_of_kinds: Group::new(clips.len(), &over_kinds),
            mean_of_clips: Group::new(clips.len(), &seed_means(&outcomes)),
            reliability: Reliability::of_clips(outcomes.iter().flat_map(|o| &o.runs).map(|r| &r.reliability)).curve(),
            params,
        }
    }

    /// Returns the rows below the rows of the clips.
    pub(super) fn lines(&self) -> Vec<String> {
        let title = |kind: &str, clips: usize| format!("{kind} ({clips})");
        let mut lines = vec![String::new()];
        lines.extend(self.kinds.iter().map(|(kind, group)| group.row(&title(kind, group.clips))));
        lines.push(self.mean_of_kinds.row(&title("mean of kinds", self.kinds.len())));
        lines.push(self.mean_of_clips.row(&title("mean of clips", self.clips.len())));
        let runs = || self.clips.iter().flat_map(|clip| &clip.runs);
        let sum = |count: fn(&Run) -> usize| runs().map(count).sum::<usize>();
        lines.push(format!(
            "in all {} of {} objects found, {} false objects of {} labels, {:.1} s",
            sum(|r| r.census.found_objects),
            sum(|r| r.census.true_objects),
            sum(|r| r.census.false_objects),
            sum(|r| r.census.labels),
            runs().map(|r| r.time.best()).sum::<f64>()
        ));
        lines.extend(reliability_lines(&Reliability::of_clips(runs().map(|r| &r.reliability))));
        lines
    }
}

impl Group {
    /// Summarises the means under each seed.
    fn new(clips: usize, seeds: &[MaskScores]) -> Self {
        Self { clips, scores: MaskScores::mean_of(seeds), j_of_seeds: seeds.iter().filter_map(|s| s.j).collect() }
    }

    fn row(&self, title: &str) -> String {
        format!("{title:43}{}{}", columns(&self.scores), spread_column(&self.j_of_seeds))
    }
}

/// Formats the curve of confidences against the share of right pixels.
fn reliability_lines(found: &Reliability) -> Vec<String> {
    let bins = found.curve().into_iter().enumerate().filter_map(|(k, bin)| Some((k, bin?)));
    let row = |(k, bin): (usize, Bin)| {
        let (low, high) = (k as f64 / 10.0, (k + 1) as f64 / 10.0);
        let off = bin.right - bin.said;
        format!("{low:.1} to {high:.1} {:10.3} {:7.3} {off:+7.3} {:7.3}", bin.said, bin.right, bin.share)
    };
    let mut lines: Vec<String> = bins.map(row).collect();
    if !lines.is_empty() {
        lines.splice(0..0, [String::new(), "confidence       said   right     off   share".to_owned()]);
        let furthest = found.furthest(FAIR_SHARE);
        lines.push(format!("furthest from the diagonal, with at least {FAIR_SHARE} of the pixels: {furthest:.3}"));
    }
    lines
}

/// Means over clips, seed by seed.
fn seed_means(clips: &[&Outcome]) -> Vec<MaskScores> {
    let scores: Vec<Vec<MaskScores>> = clips.iter().map(|c| c.runs.iter().map(|r| r.scores).collect()).collect();
    average_by_seed(&scores)
}

/// Averages lists by seed: the mean of all first elements, of all second ones, and so on.
fn average_by_seed(lists: &[Vec<MaskScores>]) -> Vec<MaskScores> {
    let length = lists.first().map_or(0, Vec::len);
    (0..length).map(|s| MaskScores::mean_of(&lists.iter().map(|l| l[s]).collect::<Vec<_>>())).collect()
}

pub(super) fn heading(several: bool) -> String {
    let head = "clip                         frames labels      J      F   best recall  false";
    let spread = if several { " spread" } else { "" };
    format!("{head}{spread}   found  false objects  seconds")
}

/// Formats the row of a clip, with the counts of the first seed.
pub(super) fn row(outcome: &Outcome) -> String {
    let scores: Vec<MaskScores> = outcome.runs.iter().map(|r| r.scores).collect();
    let j: Vec<f64> = scores.iter().filter_map(|s| s.j).collect();
    let seconds: f64 = outcome.runs.iter().map(|r| r.time.best()).sum();
    let (frames, census) = outcome.runs.first().map(|r| (r.frames, r.census)).unwrap_or_default();
    let objects = format!("{}/{}", census.found_objects, census.true_objects);
    let wrong = format!("{}/{}", census.false_objects, census.labels);
    let head = format!("{:29} {frames:5} {:6} ", outcome.name, census.labels);
    let figures = format!("{}{}", columns(&MaskScores::mean_of(&scores)), spread_column(&j));
    format!("{head:43}{figures} {objects:>7} {wrong:>14} {seconds:8.1}")
}

fn columns(s: &MaskScores) -> String {
    let three = |value: Option<f64>| value.map_or_else(|| format!("{:>7}", "-"), |v| format!("{v:7.3}"));
    [s.j, s.f, s.best, s.recall, s.false_share].map(three).concat()
}

/// Largest less smallest; nothing for one value.
fn spread_column(values: &[f64]) -> String {
    if values.len() < 2 {
        return String::new();
    }
    let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(low, high), &v| (low.min(v), high.max(v)));
    format!("{:7.3}", high - low)
}
