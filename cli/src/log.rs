//! Progress of a run, as a bar, lines of JSON, or nothing: the finished share of the clip, which never falls, and the seconds left.

use crate::failure::{Failure, Result, print, print_error};
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::iter;
use std::time::Instant;
use tracecut::{Progress, Stage, Window};

#[derive(Args, Debug)]
pub(crate) struct LogArgs {
    /// Print the report of each input (the contents of result.json) on standard output, on one line
    #[arg(long)]
    json: bool,
    /// Print nothing but errors
    #[arg(long, conflicts_with = "log")]
    quiet: bool,
    /// Format of progress on standard error: a bar if it is a terminal, or a line of JSON per event
    #[arg(long, value_name = "FORM", default_value = "text")]
    log: LogFormat,
}

#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq)]
enum LogFormat {
    Text,
    Json,
}

/// The output of progress and reports.
#[derive(Debug)]
pub struct Log {
    bar: ProgressBar,
    clip: RefCell<Option<ShownClip>>,
    prints_reports: bool,
    quiet: bool,
    events: bool,
}

/// The clip whose progress is shown.
#[derive(Debug)]
struct ShownClip {
    progress: ClipProgress,
    begin: Instant,
    /// The window, stage and percent that were shown last.
    shown: Option<(usize, Option<Stage>, Option<u32>)>,
}

/// Length of the bar.
const BAR_STEPS: u64 = 1000;

impl LogArgs {
    pub(crate) fn open(&self) -> Log {
        let events = self.log == LogFormat::Json;
        let bar = if self.quiet || events { ProgressBar::hidden() } else { visible_bar() };
        Log { bar, clip: RefCell::default(), prints_reports: self.json, quiet: self.quiet, events }
    }
}

/// Returns a bar on standard error, which is hidden unless that is a terminal.
fn visible_bar() -> ProgressBar {
    ProgressBar::new(BAR_STEPS)
}

/// Returns the style of a bar; without one if the length of the clip is unknown.
fn bar_style(is_known: bool) -> ProgressStyle {
    let template = if is_known { "{msg:15} {wide_bar} {percent:>3}% {prefix}" } else { "{msg} {elapsed}" };
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

impl Log {
    /// Returns a log with a bar and texts.
    pub(crate) fn plain() -> Self {
        Self { bar: visible_bar(), quiet: false, ..Self::quiet() }
    }

    /// Returns a log that prints nothing.
    pub fn quiet() -> Self {
        Self { bar: ProgressBar::hidden(), clip: RefCell::default(), prints_reports: false, quiet: true, events: false }
    }

    /// Prints an event on standard error, if events are on.
    pub(crate) fn event(&self, name: &str, mut fields: Value) {
        if self.events {
            fields["event"] = json!(name);
            print_error(fields);
        }
    }

    /// Reports a failure that does not end the program.
    pub(crate) fn failure(&self, input: &str, failure: &Failure) {
        if self.events {
            self.event("error", json!({ "input": input, "code": failure.kind as i32, "message": failure.reason }));
        } else {
            print_error(format_args!("error: {}", failure.reason));
        }
    }

    /// Returns whether failures are logged as events.
    pub(crate) fn logs_events(&self) -> bool {
        self.events
    }

    /// Begins a clip.
    pub(crate) fn begin_clip(&self, progress: ClipProgress) {
        *self.clip.borrow_mut() = Some(ShownClip { progress, begin: Instant::now(), shown: None });
    }

    /// Reports a frame that was read.
    pub(crate) fn read_frame(&self) {
        self.update(None, ClipProgress::count_frame);
    }

    /// Reports the end of the input.
    pub(crate) fn end_input(&self) {
        self.clip.borrow_mut().iter_mut().for_each(|clip| clip.progress.end_input());
    }

    /// Reports a step of the run.
    pub(crate) fn step(&self, progress: Progress) {
        // Flow and trajectories alternate: flow is named, which takes far longer.
        let stage = if progress.stage == Stage::Trajectories { Stage::Flow } else { progress.stage };
        self.update(Some(stage), |clip| clip.count(Some(progress.stage), progress.done, progress.total));
    }

    /// Reports a finished window, after which `num_settled` frames of the clip are finished, and whether its shot ends there.
    pub(crate) fn settle(&self, num_settled: usize, ends_shot: bool) {
        self.clip.borrow_mut().iter_mut().for_each(|clip| clip.progress.settle(num_settled, ends_shot));
    }

    /// Changes the progress of the clip, and shows each stage of each window, and each percent.
    fn update(&self, stage: Option<Stage>, change: impl FnOnce(&mut ClipProgress)) {
        let mut clip = self.clip.borrow_mut();
        let Some(ShownClip { progress, begin, shown }) = clip.as_mut() else { return };
        change(progress);
        let (window, share) = (progress.window_index(), progress.share());
        let percent = share.map(|share| (100.0 * share) as u32);
        if shown.replace((window, stage, percent)) == Some((window, stage, percent)) {
            return;
        }
        let stage = stage.map_or("decode", Stage::name);
        let seconds_left = progress.seconds_left(begin.elapsed().as_secs_f64());
        self.event(
            "progress",
            json!({ "stage": stage, "share": share.unwrap_or_default(), "secondsLeft": seconds_left }),
        );
        self.bar.set_style(bar_style(share.is_some()));
        self.bar.set_position((BAR_STEPS as f64 * share.unwrap_or_default()) as u64);
        self.bar.set_message(stage);
        self.bar.set_prefix(seconds_left.map_or_else(String::new, |seconds| format!("{seconds:.0} s left")));
    }

    /// Ends the clip.
    pub(crate) fn end(&self) {
        self.bar.finish_and_clear();
        *self.clip.borrow_mut() = None;
    }

    /// Prints the report of a finished input, or its summary.
    pub(crate) fn finish_input(&self, report: &str, summary: &str) -> Result<()> {
        self.end();
        if self.prints_reports {
            print(report)
        } else if self.quiet {
            Ok(())
        } else {
            print(summary)
        }
    }
}

/// A stage of a window; `None` is decoding, before the session's own stages.
type Step = Option<Stage>;

/// Usual time of decoding a frame, in the unit of [`Stage::cost`]: fits videos of 640 x 360.
const DECODING_COST: f64 = 0.1;

/// Smallest share of a run, and its shortest time, with an estimate of the time left; chosen by eye.
const MIN_SHARE: f64 = 0.02;
const MIN_SECONDS: f64 = 1.0;

/// Steps of a stage of the present window.
#[derive(Debug, Clone, Copy)]
struct Steps {
    /// Steps that were done before, with another window.
    before: u32,
    done: u32,
    total: u32,
}

impl Steps {
    fn fraction(self) -> f64 {
        let (done, total) = (self.done.saturating_sub(self.before), self.total.saturating_sub(self.before));
        if total == 0 { 1.0 } else { (f64::from(done) / f64::from(total)).min(1.0) }
    }
}

/// The progress of a clip.
#[derive(Debug)]
pub(crate) struct ClipProgress {
    /// Number of frames of the clip, if known.
    num_frames: Option<usize>,
    /// Frames of a window.
    window_frames: usize,
    /// True if the stages after the clusters run.
    has_masks: bool,
    /// Frames whose masks an earlier run has finished.
    first: usize,
    num_read: usize,
    /// Frames that the finished windows have settled.
    num_settled: usize,
    /// True if the present window shares no frames with the one before.
    begins_shot: bool,
    /// Index of the present window in this run.
    window_index: usize,
    stages: BTreeMap<Step, Steps>,
    share: f64,
}

impl ClipProgress {
    /// Begins at frame `first` of a clip.
    pub(crate) fn new(num_frames: Option<usize>, window_frames: usize, has_masks: bool, first: usize) -> Self {
        let stages = BTreeMap::new();
        Self {
            num_frames,
            window_frames,
            has_masks,
            first,
            num_read: first,
            num_settled: first,
            begins_shot: first == 0,
            window_index: 0,
            stages,
            share: 0.0,
        }
    }

    /// Index of the present window in this run.
    pub(crate) fn window_index(&self) -> usize {
        self.window_index
    }

    /// Counts a frame that was read.
    pub(crate) fn count_frame(&mut self) {
        self.num_read += 1;
        let done = self.num_read as u32;
        // A window of frames is read ahead.
        let end = self
            .num_frames
            .map_or(self.num_read, |frames| frames.min(self.window_end(frames).saturating_add(self.window_frames)));
        self.count(None, done, end as u32);
    }

    /// Sets the number of frames at the end of the input.
    pub(crate) fn end_input(&mut self) {
        self.num_frames = Some(self.num_read);
        self.update();
    }

    /// Counts steps: `done` of `total` of a stage.
    pub(crate) fn count(&mut self, stage: Step, done: u32, total: u32) {
        let before = done.saturating_sub(1);
        let steps = self.stages.entry(stage).or_insert(Steps { before, done, total });
        (steps.done, steps.total) = (done, total);
        self.update();
    }

    /// Ends a window, after which `num_settled` frames of the clip are finished, and maybe its shot.
    pub(crate) fn settle(&mut self, num_settled: usize, ends_shot: bool) {
        self.stages.clear();
        self.num_settled = num_settled;
        self.begins_shot = ends_shot;
        self.window_index += 1;
        self.update();
    }

    /// Returns the finished share, 0 to 1; `None` while the number of frames is unknown.
    pub(crate) fn share(&self) -> Option<f64> {
        self.num_frames.map(|_| self.share)
    }

    /// Returns the estimated seconds left after `elapsed` seconds; `None` if it is too early.
    pub(crate) fn seconds_left(&self, elapsed: f64) -> Option<f64> {
        let share = self.share()?;
        let gained = share - self.first as f64 / self.num_frames? as f64;
        let is_known = share >= 1.0 || (gained >= MIN_SHARE && elapsed >= MIN_SECONDS);
        is_known.then(|| elapsed * (1.0 - share) / gained)
    }

    fn update(&mut self) {
        let Some(frames) = self.num_frames.filter(|&frames| frames > 0) else { return };
        let settled = self.num_settled as f64;
        let expected = self.window_end(frames).saturating_sub(self.num_settled) as f64;
        let share = (settled + self.window_fraction() * expected) / frames as f64;
        // A new shot ends a window early, and a cut may take more steps than it said.
        self.share = share.clamp(self.share, 1.0);
    }

    /// Returns the number of frames that are expected to be settled after the present window.
    fn window_end(&self, frames: usize) -> usize {
        let overlap = Window::overlap(self.window_frames);
        let shared = if self.begins_shot { overlap / 2 } else { overlap };
        let end = self.num_settled.saturating_add(self.window_frames - shared);
        // The last window settles all that is left.
        if frames <= end.saturating_add(overlap / 2) { frames } else { end }
    }

    /// Returns the finished part of the present window.
    fn window_fraction(&self) -> f64 {
        let latest = self.stages.keys().next_back().copied();
        let is_over = |stage: Step| {
            // These alternate.
            let is_flow = stage == Some(Stage::Flow) && latest == Some(Some(Stage::Trajectories));
            latest.is_some_and(|latest| stage < latest) && !is_flow
        };
        let runs = |stage: Step| self.has_masks || stage < Some(Stage::Superpixels);
        let (mut done, mut total) = (0.0, 0.0);
        for stage in iter::once(None).chain(Stage::ALL.map(Some)).filter(|&stage| runs(stage)) {
            let cost = stage.map_or(DECODING_COST, Stage::cost);
            let fraction = self.stages.get(&stage).map_or(0.0, |steps| steps.fraction());
            done += cost * if is_over(stage) { 1.0 } else { fraction };
            total += cost;
        }
        done / total
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STAGES: [Stage; 4] = [Stage::Flow, Stage::Affinities, Stage::Cut, Stage::Masks];

    /// Runs windows that settle up to these frames, where a shot may end, and returns the share after each step.
    fn shares(progress: &mut ClipProgress, ends: &[(usize, bool)]) -> Vec<f64> {
        let mut shares = Vec::new();
        for &(end, ends_shot) in ends {
            for stage in STAGES {
                // The cut adds steps.
                let totals = if stage == Stage::Cut { [4, 9, 9] } else { [4, 4, 4] };
                for (total, done) in totals.into_iter().zip([1, 4, totals[2]]) {
                    progress.count(Some(stage), done, total);
                    shares.extend(progress.share());
                }
            }
            progress.settle(end, ends_shot);
            shares.extend(progress.share());
        }
        shares
    }

    #[test]
    fn the_share_of_a_clip_in_windows_never_falls_and_ends_at_one() {
        // The second window ends early, at a new shot; the last one fills the clip.
        let mut progress = ClipProgress::new(Some(110), 50, true, 0);
        let shares = shares(&mut progress, &[(45, false), (60, true), (110, true)]);
        assert!(shares.is_sorted(), "{shares:?}");
        assert_eq!(shares[shares.len() - 2..], [1.0, 1.0], "also before the last window is settled: {shares:?}");
        assert!(shares[0] > 0.0 && shares[0] < 0.15, "{}", shares[0]);
        assert_eq!(progress.seconds_left(10.0), Some(0.0));
    }

    #[test]
    fn the_share_of_a_resumed_clip_begins_where_the_first_run_ended() {
        let mut progress = ClipProgress::new(Some(100), 50, true, 45);
        progress.count(Some(Stage::Flow), 19, 98);
        assert!((0.45..0.5).contains(&progress.share().unwrap()), "{progress:?}");
        assert_eq!(progress.seconds_left(0.5), None);
        progress.settle(85, false);
        assert_eq!(progress.seconds_left(40.0).map(f64::round), Some(15.0));
    }

    #[test]
    fn a_clip_of_unknown_length_has_a_share_once_its_end_was_read() {
        let mut progress = ClipProgress::new(None, 50, true, 0);
        progress.count_frame();
        progress.count_frame();
        assert_eq!((progress.share(), progress.seconds_left(9.0)), (None, None));
        progress.end_input();
        progress.count(Some(Stage::Masks), 1, 2);
        assert!(progress.share().unwrap() > 0.9, "{progress:?}");
    }

    #[test]
    fn without_masks_the_clusters_end_a_window() {
        let mut progress = ClipProgress::new(Some(10), 50, false, 0);
        progress.count(Some(Stage::Clusters), 1, 1);
        assert_eq!(progress.share(), Some(1.0));
    }
}
