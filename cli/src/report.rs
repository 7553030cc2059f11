//! `result.json`: composed at the end from a part for each window, which is on disk until then.

use crate::failure::{Damage, Failure, Result, create_folder, read, write};
use crate::masks::MaskReport;
use crate::output::OutputFolder;
use crate::provenance::{Options, Origin};
use crate::run::{Seconds, Timing, peak_memory_bytes};
use crate::timeline::FrameTimes;
use crate::window::{ClipSummary, WindowResult};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;
use tracecut::Params;
use tracecut::discretize::Clusters;
use tracecut::mask::Agreement;
use tracecut::trajectory::Trajectories;

/// The part of the report from one window.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct WindowPart {
    window: WindowReport,
    size: (usize, usize),
    working: (usize, usize),
    /// The times of the settled frames.
    times: Option<FrameTimes>,
    labels: Vec<LabelSize>,
    masks: Option<MaskReport>,
    /// Rows of `objects.csv`.
    table: String,
    /// Agreement of the masks of each settled frame with those of nearby frames.
    agreement: Vec<Option<f32>>,
    /// Settled frames whose masks should be looked at, numbered in the clip.
    doubts: Vec<Range<usize>>,
    eigenvalues: Vec<f64>,
    eigen: Value,
    seconds: BTreeMap<String, Seconds>,
}

/// A window in the report, with frame numbers of the clip.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
struct WindowReport {
    index: usize,
    shot: usize,
    first_frame: usize,
    frames: usize,
    settled: FrameRange,
    trajectories: usize,
    points: usize,
    clusters: usize,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    objects: Vec<ObjectClusters>,
    /// Log-odds above which clusters were merged; left out if those of the parameters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    merge_log_odds: Option<f64>,
}

/// The frames `from <= t < to`.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct FrameRange {
    from: usize,
    to: usize,
}

/// The clusters of an object in a window.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct ObjectClusters {
    label: u8,
    clusters: Vec<usize>,
}

#[derive(Debug, Default, Clone, Serialize, Deserialize)]
struct LabelSize {
    label: usize,
    trajectories: usize,
    points: usize,
}

impl WindowReport {
    /// Returns a copy without the objects that have no pixel in the clip.
    fn with_objects_of(&self, masks: Option<&MaskReport>) -> Self {
        let has_pixels = |object: &&ObjectClusters| masks.is_some_and(|masks| masks.has_object(object.label));
        Self { objects: self.objects.iter().filter(has_pixels).cloned().collect(), ..self.clone() }
    }
}

impl WindowPart {
    pub(crate) fn new(
        window_result: &WindowResult<'_>,
        masks: Option<(MaskReport, String)>,
        timing: &Timing,
    ) -> Result<Self> {
        let session = window_result.session;
        let results = window_result.results()?;
        let (masks, table) = masks.map_or_else(Default::default, |(masks, table)| (Some(masks), table));
        let eigen = serde_json::to_value(&results.embedding.info).map_err(|e| Failure::new(e.to_string()))?;
        let object = |(label, clusters)| ObjectClusters { label, clusters };
        let agreement = session.agreement();
        let (first, settled) = (window_result.first, window_result.settled.clone());
        let clusters = masks.as_ref().map_or_else(Vec::new, MaskReport::clusters_of_objects);
        let window = WindowReport {
            index: window_result.index,
            shot: window_result.shot,
            first_frame: first,
            frames: session.num_frames(),
            settled: FrameRange { from: first + settled.start, to: first + settled.end },
            trajectories: results.tracks.len(),
            points: results.tracks.x.len(),
            clusters: results.clusters.count,
            objects: clusters.into_iter().map(object).collect(),
            merge_log_odds: agreement.and_then(|agreement| agreement.merge_log_odds),
        };
        Ok(Self {
            window,
            size: session.input_size().unwrap_or_default(),
            working: session.working_size().unwrap_or_default(),
            agreement: agreement.and_then(|a| a.frames.get(settled.clone())).unwrap_or_default().to_vec(),
            doubts: agreement.map_or_else(Vec::new, |a| settled_doubts(a, first, &settled)),
            times: FrameTimes::collect(settled.map(|t| window_result.timing(t))),
            labels: label_sizes(results.tracks, results.clusters),
            masks,
            table,
            eigenvalues: results.embedding.eigenvalues.clone(),
            eigen,
            seconds: timing.by_name(),
        })
    }

    fn path(place: &OutputFolder, index: usize) -> PathBuf {
        place.work().join(format!("parts/{index:05}.json"))
    }

    pub(crate) fn write(&self, place: &OutputFolder) -> Result<()> {
        create_folder(&place.work().join("parts"))?;
        let text = serde_json::to_string(self).map_err(|e| Failure::new(e.to_string()))?;
        write(&Self::path(place, self.window.index), text)
    }

    /// Reads the parts of the first `count` windows.
    pub(crate) fn read_all(place: &OutputFolder, count: usize) -> Result<Vec<Self>> {
        let part = |index| {
            let path = Self::path(place, index);
            serde_json::from_slice(&read(&path)?).map_err(|e| Failure::about(path.display(), e))
        };
        (0..count).map(part).collect()
    }
}

fn label_sizes(tracks: &Trajectories, clusters: &Clusters) -> Vec<LabelSize> {
    let mut sizes: Vec<LabelSize> =
        (0..clusters.count).map(|label| LabelSize { label, ..LabelSize::default() }).collect();
    for (i, &label) in clusters.label.iter().enumerate() {
        let size = &mut sizes[label as usize];
        size.trajectories += 1;
        size.points += tracks.points(i).len();
    }
    sizes
}

/// The contents of `result.json`.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Report<'a> {
    version: &'static str,
    input: String,
    width: usize,
    height: usize,
    working_width: usize,
    working_height: usize,
    pub(crate) frames: usize,
    /// Set if the input is damaged after these frames.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) truncated: Option<Truncated>,
    shots: usize,
    /// Results of a single window, left out if there are several.
    #[serde(flatten)]
    only: Option<OnlyWindow<'a>>,
    /// Background, objects and superpixels; left out without masks.
    #[serde(flatten)]
    masks: Option<MaskReport>,
    /// Mean agreement of the masks with those of nearby frames, `0.0..=1.0`; left out if none can be compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    agreement: Option<f64>,
    /// Frames whose masks should be looked at; left out if there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    doubts: Vec<FrameRange>,
    windows: Vec<WindowReport>,
    /// File names of the frames; left out if one file has all of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) frame_names: Option<Vec<String>>,
    /// Average number of frames a second; left out like the times if frames have none.
    #[serde(skip_serializing_if = "Option::is_none")]
    frame_rate: Option<f64>,
    #[serde(flatten)]
    pub(crate) times: Option<FrameTimes>,
    source: &'a Origin,
    options: &'a Options,
    params: &'a Params,
    /// Wall seconds of each stage, and of the whole run including writing.
    seconds: BTreeMap<&'a str, f64>,
    /// The processor time of the first thread, which does not depend on other programs; `null` if the system does not report
    /// it.
    cpu_seconds: BTreeMap<&'a str, Option<f64>>,
    peak_memory_bytes: Option<u64>,
}

/// Damage in a clip.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Truncated {
    /// Number of whole frames before the damage, which the results hold.
    pub(crate) frames: usize,
    pub(crate) reason: String,
}

impl Truncated {
    /// Returns the failure that ends a run of `input` after its results are written.
    pub(crate) fn failure(&self, input: &str) -> Failure {
        let Self { frames, reason } = self;
        let last = frames.saturating_sub(1);
        Failure::about(input, format_args!("{reason} (results end after frame {last}, the last whole one)"))
    }
}

#[derive(Debug, Serialize)]
struct OnlyWindow<'a> {
    trajectories: usize,
    points: usize,
    clusters: usize,
    labels: &'a [LabelSize],
    eigenvalues: &'a [f64],
    eigen: &'a Value,
}

/// Returns the rows of `objects.csv`; `None` without masks.
pub(crate) fn rows(parts: &[WindowPart]) -> Option<String> {
    parts.first()?.masks.as_ref()?;
    Some(parts.iter().map(|part| part.table.as_str()).collect())
}

/// Returns the doubts of a window among its settled frames, numbered in the clip.
fn settled_doubts(agreement: &Agreement, first: usize, settled: &Range<usize>) -> Vec<Range<usize>> {
    let within = |doubt: Range<usize>| first + doubt.start.max(settled.start)..first + doubt.end.min(settled.end);
    agreement.doubts().into_iter().map(within).filter(|doubt| !doubt.is_empty()).collect()
}

/// Joins the doubts of windows that continue those of the window before.
fn joined_doubts(parts: &[WindowPart]) -> Vec<FrameRange> {
    let mut joined: Vec<FrameRange> = Vec::new();
    for doubt in parts.iter().flat_map(|part| &part.doubts) {
        match joined.last_mut().filter(|last| last.to == doubt.start) {
            Some(last) => last.to = doubt.end,
            None => joined.push(FrameRange { from: doubt.start, to: doubt.end }),
        }
    }
    joined
}

fn mean_agreement(parts: &[WindowPart]) -> Option<f64> {
    let frames: Vec<f64> = parts.iter().flat_map(|part| &part.agreement).flatten().map(|&a| f64::from(a)).collect();
    (!frames.is_empty()).then(|| frames.iter().sum::<f64>() / frames.len() as f64)
}

impl<'a> Report<'a> {
    /// Composes the report of a clip; `None` without windows.
    pub(crate) fn new(
        input: String,
        names: Option<Vec<String>>,
        summary: &'a ClipSummary<'a>,
        parts: &'a [WindowPart],
    ) -> Option<Self> {
        let (first, last) = (parts.first()?, parts.last()?);
        let recipe = summary.provenance.recipe;
        let only = (parts.len() == 1).then(|| OnlyWindow {
            trajectories: first.window.trajectories,
            points: first.window.points,
            clusters: first.window.clusters,
            labels: &first.labels,
            eigenvalues: &first.eigenvalues,
            eigen: &first.eigen,
        });
        let frames = last.window.settled.to;
        let masks = MaskReport::merged(parts.iter().map(|part| part.masks.as_ref()).collect::<Option<_>>());
        let times = FrameTimes::join(parts.iter().map(|part| part.times.as_ref()));
        let truncated = |damage: &Damage| Truncated { frames, reason: damage.reason.clone() };
        Some(Self {
            version: recipe.version,
            input,
            width: first.size.0,
            height: first.size.1,
            working_width: first.working.0,
            working_height: first.working.1,
            frames,
            truncated: summary.damage.as_ref().map(truncated),
            shots: last.window.shot + 1,
            only,
            windows: parts.iter().map(|part| part.window.with_objects_of(masks.as_ref())).collect(),
            masks,
            agreement: mean_agreement(parts),
            doubts: joined_doubts(parts),
            frame_names: names.map(|names| names.into_iter().take(frames).collect()),
            frame_rate: times.as_ref().and_then(FrameTimes::frame_rate),
            times,
            source: &summary.provenance.source,
            options: &recipe.options,
            params: recipe.params,
            seconds: BTreeMap::new(),
            cpu_seconds: BTreeMap::new(),
            peak_memory_bytes: None,
        })
    }

    /// Sets the time and memory of the run: the time of the windows plus `finishing`, the time since the last one.
    pub(crate) fn set_costs(&mut self, parts: &'a [WindowPart], finishing: Seconds) {
        let mut seconds: BTreeMap<&str, Seconds> = BTreeMap::new();
        let finishing = [("write", finishing), ("total", finishing)];
        let windows = parts.iter().flat_map(|part| &part.seconds).map(|(name, &spent)| (name.as_str(), spent));
        windows.chain(finishing).for_each(|(name, spent)| seconds.entry(name).or_default().add(spent));
        self.seconds = seconds.iter().map(|(&name, s)| (name, s.wall)).collect();
        self.cpu_seconds = seconds.iter().map(|(&name, s)| (name, s.cpu)).collect();
        self.peak_memory_bytes = peak_memory_bytes();
    }

    /// Width and height of the masks.
    pub(crate) fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Returns a summary in one line.
    pub(crate) fn summary(&self, place: &OutputFolder) -> String {
        let (width, height, frames) = (self.width, self.height, self.frames);
        let contents = match &self.only {
            Some(only) => format!("{} trajectories in {} clusters", only.trajectories, only.clusters),
            None => format!("{} windows, {} shot(s)", self.windows.len(), self.shots),
        };
        let objects = self.masks.as_ref().map_or_else(String::new, |m| format!("{} object(s), ", m.num_objects()));
        let note = if self.windows.iter().any(|w| w.merge_log_odds.is_some()) { " by other clusters" } else { "" };
        let agreement = self.agreement.map_or_else(String::new, |a| format!("agreement {a:.2}{note}, "));
        let seconds = self.seconds.get("total").copied().unwrap_or_default();
        let doubts = self.doubts.iter().map(|doubt| format!("{} to {}", doubt.from, doubt.to - 1));
        let doubts = match doubts.collect::<Vec<_>>() {
            doubts if doubts.is_empty() => String::new(),
            doubts => format!("\nto check: frames {}", doubts.join(", ")),
        };
        format!(
            "{frames} frames of {width}x{height}: {contents}, {objects}{agreement}{seconds:.2} s; see {}{doubts}",
            place.target().display()
        )
    }
}
