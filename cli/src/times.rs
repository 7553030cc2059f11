//! The times of the frames of a clip.

use crate::clip_frame::FrameTiming;
use serde::{Deserialize, Serialize};

/// Times and durations of consecutive frames, in seconds as the file says.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct FrameTimes {
    pub(crate) times: Vec<f64>,
    pub(crate) durations: Vec<f64>,
}

impl FrameTimes {
    /// Collects the timings of frames; `None` if a frame has none.
    pub(crate) fn collect(timings: impl IntoIterator<Item = Option<FrameTiming>>) -> Option<Self> {
        timings.into_iter().try_fold(Self::default(), |mut collected, timing| {
            collected.times.push(timing?.time);
            collected.durations.push(timing?.duration);
            Some(collected)
        })
    }

    /// Joins the times of consecutive windows; `None` if a window has none.
    pub(crate) fn join<'a>(windows: impl IntoIterator<Item = Option<&'a Self>>) -> Option<Self> {
        windows.into_iter().try_fold(Self::default(), |mut collected, window| {
            collected.times.extend(&window?.times);
            collected.durations.extend(&window?.durations);
            Some(collected)
        })
    }

    /// Returns the average number of frames a second, from the first frame's time to the last one's end, rounded to a millionth so
    /// that 25 stays 25 with rounded times.
    pub(crate) fn frame_rate(&self) -> Option<f64> {
        let seconds = self.times.last()? + self.durations.last()? - self.times.first()?;
        (seconds > 0.0).then(|| (1e6 * self.times.len() as f64 / seconds).round() / 1e6)
    }
}
