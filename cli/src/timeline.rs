//! Frames of a clip with their presentation times: repairs times that are missing or do not increase, and computes the duration
//! of each picture.

use crate::failure::{Failure, Result};
use serde::{Deserialize, Serialize};
use tracecut::Error;
use tracecut::image::{Frame, MAX_SIDE};

/// A frame of a clip.
#[derive(Debug, Clone)]
pub struct ClipFrame {
    /// Its name in errors: the file name, with the number of the frame if the file has several.
    pub name: String,
    /// Its pixels.
    pub frame: Frame,
    /// `None` in lists of image files.
    pub timing: Option<FrameTiming>,
}

/// The presentation time of a frame in its file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameTiming {
    /// Presentation time in seconds.
    pub time: f64,
    /// Seconds until the next frame, or the end.
    pub duration: f64,
}

pub(crate) type Frames = Box<dyn Iterator<Item = Result<ClipFrame>>>;

/// Checks a size before memory is allocated for it.
pub(crate) fn check(width: usize, height: usize, max_pixels: usize) -> std::result::Result<(), Error> {
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(Error::FrameSize { width, height });
    }
    if width * height > max_pixels {
        return Err(Error::TooLarge {
            what: "pixels in a frame",
            actual: width * height,
            limit: max_pixels,
            name: "clip.max_pixels".to_owned(),
        });
    }
    Ok(())
}

/// Duration of a picture without one in its file.
const DEFAULT_DURATION_S: f64 = 1.0 / 25.0;

/// A decoded picture with its time in the file, in seconds.
#[derive(Debug)]
pub(crate) struct Picture {
    pub(crate) frame: Frame,
    pub(crate) time: Option<f64>,
    pub(crate) duration: Option<f64>,
}

/// Ends a source of pictures before the end of its file.
#[derive(Debug)]
pub(crate) enum StreamEnd {
    /// The file is damaged or cut off, with the cause.
    Damage(String),
    Failure(Failure),
}

/// The pictures of a file with their times, as defined in `docs/frames.md`. Reads one picture ahead.
pub(crate) struct Timeline<S> {
    name: String,
    source: Option<S>,
    /// The picture after the last one returned.
    next: Option<Picture>,
    stop: Option<StreamEnd>,
    num_given: usize,
    last: Option<FrameTiming>,
}

impl<S: Iterator<Item = std::result::Result<Picture, StreamEnd>>> Timeline<S> {
    /// Reads the pictures of `source`, which is called `name` in errors.
    pub(crate) fn new(name: impl Into<String>, source: S) -> Self {
        Self { name: name.into(), source: Some(source), next: None, stop: None, num_given: 0, last: None }
    }

    /// Reads a picture. The source is dropped at its end.
    fn read_picture(&mut self) -> Option<Picture> {
        match self.source.as_mut()?.next() {
            Some(Ok(picture)) => return Some(picture),
            Some(Err(stop)) => self.stop = Some(stop),
            None => {}
        }
        self.source = None;
        None
    }

    fn take_failure(&mut self) -> Option<Failure> {
        Some(match self.stop.take()? {
            StreamEnd::Damage(reason) => Failure::damaged(&self.name, self.num_given, reason),
            StreamEnd::Failure(failure) => failure,
        })
    }

    /// Returns whether a picture ends at or before zero, where players begin.
    fn is_before_start(&self, picture: &Picture) -> bool {
        let Some(time) = picture.time else { return false };
        let end = self.next.as_ref().map_or(Some(time + picture.duration.unwrap_or(0.0)), |next| next.time);
        time < 0.0 && end.is_some_and(|end| end <= 0.0)
    }

    fn time_of(&self, picture: &Picture) -> FrameTiming {
        let time = match (picture.time, self.last) {
            (Some(time), None) => time,
            (Some(time), Some(last)) if time > last.time => time,
            (_, Some(last)) => last.time + last.duration,
            (None, None) => 0.0,
        };
        let duration = picture.duration.filter(|&duration| duration > 0.0).or(self.last.map(|last| last.duration));
        let next = self.next.as_ref().and_then(|next| next.time).filter(|&next| next > time);
        FrameTiming { time, duration: next.map_or(duration.unwrap_or(DEFAULT_DURATION_S), |next| next - time) }
    }
}

impl<S: Iterator<Item = std::result::Result<Picture, StreamEnd>>> Iterator for Timeline<S> {
    type Item = Result<ClipFrame>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let Some(picture) = self.next.take().or_else(|| self.read_picture()) else {
                return self.take_failure().map(Err);
            };
            self.next = self.read_picture();
            if self.is_before_start(&picture) {
                continue;
            }
            let timing = self.time_of(&picture);
            let name = format!("{}, frame {}", self.name, self.num_given);
            self.num_given += 1;
            self.last = Some(timing);
            return Some(Ok(ClipFrame { name, frame: picture.frame, timing: Some(timing) }));
        }
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    /// Times and durations that a timeline gives to pictures with these.
    fn timings(pictures: &[(Option<f64>, Option<f64>)]) -> Vec<(f64, f64)> {
        let frame = Frame::from_rgb(vec![0; 3], 1, 1).unwrap();
        let picture =
            |&(time, duration): &(Option<f64>, Option<f64>)| Ok(Picture { frame: frame.clone(), time, duration });
        let timing = |frame: Result<ClipFrame>| frame.unwrap().timing.unwrap();
        Timeline::new("clip", pictures.iter().map(picture)).map(timing).map(|t| (t.time, t.duration)).collect()
    }

    #[test]
    fn durations_last_until_the_next_picture_and_the_last_is_what_the_file_says() {
        let uneven = [(Some(1.0), Some(9.0)), (Some(1.5), None), (Some(3.0), Some(0.25))];
        assert_eq!(timings(&uneven), [(1.0, 0.5), (1.5, 1.5), (3.0, 0.25)]);
        assert_eq!(timings(&[(Some(1.0), None), (Some(1.5), Some(0.0))]), [(1.0, 0.5), (1.5, 0.5)]);
        assert_eq!(timings(&[(Some(2.0), None)]), [(2.0, 0.04)]);
    }

    #[test]
    fn missing_and_equal_times_follow_the_picture_before() {
        let said = Some(0.25);
        let equal = [(Some(0.0), said), (Some(0.0), said), (Some(0.0), None), (Some(1.0), None)];
        assert_eq!(timings(&equal), [(0.0, 0.25), (0.25, 0.25), (0.5, 0.5), (1.0, 0.5)]);
        let missing = [(None, None), (None, None), (Some(1.0), None)];
        assert_eq!(timings(&missing), [(0.0, 0.04), (0.04, 0.96), (1.0, 0.96)]);
    }

    #[test]
    fn pictures_that_end_at_or_before_zero_are_left_out() {
        let early = [(Some(-0.5), None), (Some(-0.25), None), (Some(0.0), None), (Some(0.25), None)];
        assert_eq!(timings(&early), [(0.0, 0.25), (0.25, 0.25)]);
        let across = [(Some(-0.5), None), (Some(-0.25), None), (Some(0.5), None)];
        assert_eq!(timings(&across), [(-0.25, 0.75), (0.5, 0.75)]);
    }

    #[test]
    fn damage_comes_after_the_pictures_before_it_and_ends_the_clip() {
        let frame = Frame::from_rgb(vec![0; 3], 1, 1).unwrap();
        let source = (0..4).map(|k| {
            let picture = Picture { frame: frame.clone(), time: Some(f64::from(k)), duration: None };
            if k == 2 { Err(StreamEnd::Damage("is cut off".to_owned())) } else { Ok(picture) }
        });
        let frames: Vec<_> = Timeline::new("clip", source).collect();
        assert_eq!(frames.len(), 3);
        let failure = frames.into_iter().next_back().unwrap().unwrap_err();
        assert_eq!(failure.reason, "clip: is cut off");
        assert_eq!(failure.damage.unwrap().frames, 2);
    }
}
