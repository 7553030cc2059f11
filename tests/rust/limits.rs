//! What is larger than a parameter allows is refused with its figure, and the session goes on.

use crate::generators::seeds::chunk;
use std::collections::BTreeMap;
use tracecut::image::Frame;
use tracecut::params::ParamValue;
use tracecut::trajectory::Trajectories;
use tracecut::{Error, Params, Session, Step};

fn with(settings: &[(&str, f64)]) -> Session {
    let mut params = Params::default();
    for &(name, value) in settings {
        params.set(name, &ParamValue::Number(value)).unwrap();
    }
    Session::new(params).unwrap()
}

fn frame(width: usize, height: usize, t: usize) -> Frame {
    let pixel = |p: usize| ((p % width + 2 * t) * 37 + (p / width) * 101) as u8;
    Frame::from_rgb((0..3 * width * height).map(|b| pixel(b / 3)).collect(), width, height).unwrap()
}

fn refused<T: std::fmt::Debug>(outcome: Result<T, Error>, name: &str, words: &str) {
    let error = outcome.unwrap_err();
    assert_eq!(error.code(), "too-large", "{error}");
    let expected = format!("{words}; the parameter {name} sets this limit)");
    assert_eq!(error.to_string(), expected);
}

fn moving(count: usize, frames: usize) -> Trajectories {
    let mut tracks = Trajectories::empty(frames, (40, 30));
    (0..count).for_each(|k| tracks.push(0, (0..frames).map(|t| (k as f32 + 0.5 * t as f32, 10.0, 0.0))));
    tracks
}

#[test]
fn a_frame_of_too_many_pixels_is_refused_and_the_session_goes_on() {
    let mut session = with(&[("clip.maxPixels", 1200.0), ("clip.maxFrames", 3.0)]);
    refused(session.push_frame(frame(41, 30, 0)), "clip.max_pixels", "1230 pixels in a frame (expected at most 1200");
    assert_eq!(session.num_frames(), 0);
    (0..3).for_each(|t| session.push_frame(frame(40, 30, t)).unwrap());
    refused(session.push_frame(frame(40, 30, 3)), "clip.max_frames", "4 frames in a session (expected at most 3");
    session.run().unwrap();
    assert_eq!(session.labels(2).unwrap().data().len(), 1200);
}

#[test]
fn a_window_has_so_many_frames_and_the_clip_any_number() {
    let mut session = with(&[("clip.maxFrames", 3.0), ("shot.maxUnmatched", 1.0)]);
    (0..3).for_each(|t| assert!(!session.push_in_shot(frame(40, 30, t)).unwrap()));
    refused(session.push_in_shot(frame(40, 30, 3)), "clip.max_frames", "4 frames in a session (expected at most 3");
    session.run().unwrap();
    session.advance(1).unwrap();
    (3..5).for_each(|t| assert!(!session.push_in_shot(frame(40, 30, t)).unwrap()));
    session.run().unwrap();
}

#[test]
fn trajectories_from_outside_are_counted_before_they_are_looked_at() {
    let limits = [("clip.maxFrames", 9.0), ("clip.maxTrajectories", 5.0), ("clip.maxPoints", 40.0)];
    let mut session = with(&limits);
    let given = |session: &mut Session, tracks| session.set_trajectories(tracks);
    let words = "10 frames in a session (expected at most 9";
    refused(given(&mut session, moving(1, 10)), "clip.max_frames", words);
    refused(given(&mut session, moving(6, 4)), "clip.max_trajectories", "6 trajectories (expected at most 5");
    refused(given(&mut session, moving(5, 9)), "clip.max_points", "45 points of trajectories (expected at most 40");
    let huge = Trajectories { num_frames: usize::MAX, ..moving(2, 4) };
    assert_eq!(given(&mut session, huge).unwrap_err().code(), "too-large");
    given(&mut session, moving(5, 8)).unwrap();
    session.run().unwrap();
}

#[test]
fn trajectories_that_are_found_are_counted_before_they_are_compared() {
    let mut session = with(&[("clip.maxTrajectories", 3.0), ("trajectory.gridStep", 3.0)]);
    (0..9).for_each(|t| session.push_frame(frame(60, 50, t)).unwrap());
    let error = session.run().unwrap_err();
    assert_eq!(error.code(), "too-large", "{error}");
    assert!(
        error
            .to_string()
            .ends_with("trajectories (expected at most 3; the parameter clip.max_trajectories sets this limit)")
    );
    assert_eq!(session.step().unwrap_err(), error);
    session.clear();
    (0..2).for_each(|t| session.push_frame(frame(4, 4, t)).unwrap());
    assert!(matches!(session.step(), Ok(Step::Working(_))));
}

/// A PNG file whose header claims a size; it has no pixels.
fn claiming(width: u32, height: u32) -> Vec<u8> {
    let head = [&width.to_be_bytes()[..], &height.to_be_bytes(), &[8, 2, 0, 0, 0]].concat();
    [b"\x89PNG\r\n\x1a\n".to_vec(), chunk(b"IHDR", &head), chunk(b"IDAT", &[])].concat()
}

#[test]
fn a_file_is_refused_by_its_header() {
    let words = "67125248 pixels in an image file (expected at most 67108864";
    refused(Frame::decode(&claiming(16_384, 4097)), "clip.max_pixels", words);
    let words = "101 pixels in an image file (expected at most 100";
    refused(Frame::decode_within(&claiming(101, 1), 100), "clip.max_pixels", words);
    assert_eq!(Frame::decode_within(&claiming(100, 1), 100).unwrap_err().code(), "decode");
    assert_eq!(Frame::decode(&claiming(16_385, 1)).unwrap_err().code(), "frame-size");
    refused(with(&[("clip.maxPixels", 100.0)]).push_encoded(&claiming(101, 1)), "clip.max_pixels", words);
}

#[test]
fn limits_are_parameters_with_ranges() {
    let tree: BTreeMap<String, ParamValue> = serde_json::from_str(r#"{"clip": {"maxPixels": 0}}"#).unwrap();
    let error = Params::default().apply(&tree).unwrap_err();
    assert_eq!(error.to_string(), "clip.max_pixels = 0 (expected a whole number, 1..=268435456)");
    // 8K is ordinary.
    assert!(Params::default().clip.max_pixels > 7680 * 4320);
}
