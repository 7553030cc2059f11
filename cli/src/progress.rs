//! The progress of a clip in windows: the finished share, which never falls, and the seconds left.

use std::collections::BTreeMap;
use std::iter;
use tracecut::{Stage, Window};

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

    /// Ends a window, after which `num_settled` frames of the clip are finished.
    pub(crate) fn settle(&mut self, num_settled: usize) {
        self.stages.clear();
        self.num_settled = num_settled;
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
        let shared = if self.num_settled == 0 { overlap / 2 } else { overlap };
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

    /// Runs windows that settle up to these frames, and returns the share after each step.
    fn shares(progress: &mut ClipProgress, ends: &[usize]) -> Vec<f64> {
        let mut shares = Vec::new();
        for &end in ends {
            for stage in STAGES {
                // The cut adds steps.
                let totals = if stage == Stage::Cut { [4, 9, 9] } else { [4, 4, 4] };
                for (total, done) in totals.into_iter().zip([1, 4, totals[2]]) {
                    progress.count(Some(stage), done, total);
                    shares.extend(progress.share());
                }
            }
            progress.settle(end);
            shares.extend(progress.share());
        }
        shares
    }

    #[test]
    fn the_share_of_a_clip_in_windows_never_falls_and_ends_at_one() {
        // The second window ends early, at a new shot.
        let mut progress = ClipProgress::new(Some(130), 50, true, 0);
        let shares = shares(&mut progress, &[45, 60, 105, 130]);
        assert!(shares.is_sorted(), "{shares:?}");
        assert_eq!(shares.last(), Some(&1.0));
        assert!(shares[0] > 0.0 && shares[0] < 0.15, "{}", shares[0]);
        assert_eq!(progress.seconds_left(10.0), Some(0.0));
    }

    #[test]
    fn the_share_of_a_resumed_clip_begins_where_the_first_run_ended() {
        let mut progress = ClipProgress::new(Some(100), 50, true, 45);
        progress.count(Some(Stage::Flow), 19, 98);
        assert!((0.45..0.5).contains(&progress.share().unwrap()), "{progress:?}");
        assert_eq!(progress.seconds_left(0.5), None);
        progress.settle(85);
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
