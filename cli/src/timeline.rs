//! Presentation times: repairs times that are missing or do not increase, and computes the duration of each picture.

use crate::clip_frame::{ClipFrame, FrameTiming};
use crate::failure::{Failure, Result};
use tracecut::image::Frame;

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
