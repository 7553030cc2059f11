//! Laws of the session.

use crate::trajectory::Trajectories;
use crate::{Error, Params};
use crate::{Session, Stage, Step};

fn session() -> Session {
    Session::new(Params::default()).unwrap()
}

fn shades(width: usize, height: usize, value: u8) -> Vec<u8> {
    vec![value; 4 * width * height]
}

#[test]
fn too_few_frames_are_an_error_and_more_can_be_pushed() {
    let mut s = session();
    assert_eq!(s.step(), Err(Error::TooFewFrames { got: 0, needed: 2 }));
    s.push_rgba(&shades(32, 24, 9), 32, 24).unwrap();
    assert_eq!(s.step(), Err(Error::TooFewFrames { got: 1, needed: 2 }));
    s.push_rgba(&shades(32, 24, 9), 32, 24).unwrap();
    s.run().unwrap();
    assert_eq!(s.clusters().unwrap().count, 0);
}

#[test]
fn a_frame_of_another_size_is_refused_and_the_session_goes_on() {
    let mut s = session();
    s.push_rgba(&shades(32, 24, 9), 32, 24).unwrap();
    let error = s.push_rgba(&shades(24, 32, 9), 24, 32).unwrap_err();
    assert_eq!(error, Error::FrameSizeChanged { index: 1, expected: (32, 24), actual: (24, 32) });
    s.push_rgba(&shades(32, 24, 9), 32, 24).unwrap();
    s.run().unwrap();
}

#[test]
fn tiny_and_black_clips_run_to_their_end() {
    for (w, h, frames) in [(1, 1, 2), (17, 3, 3), (64, 48, 8)] {
        let mut s = session();
        for _ in 0..frames {
            s.push_rgba(&shades(w, h, 0), w, h).unwrap();
        }
        s.run().unwrap();
        assert!(s.trajectories().unwrap().is_empty());
        assert_eq!(s.flow(0).unwrap().u.width(), w);
        assert_eq!(s.flow(frames - 1).unwrap_err().code(), "state");
    }
}

#[test]
fn outside_trajectories_are_checked() {
    let mut tracks = Trajectories::empty(3, (64, 48));
    tracks.push(0, [(1.0, 1.0, 0.0), (f32::NAN, 1.0, 0.0), (1.0, 1.0, 0.0)]);
    let message = session().set_trajectories(tracks).unwrap_err().to_string();
    assert_eq!(message, "x[1] = NaN (expected a finite number of pixels)");
    assert!(session().set_trajectories(Trajectories::empty(1, (64, 48))).is_err());
    assert!(session().set_trajectories(Trajectories::empty(3, (0, 48))).is_err());
    let mut s = session();
    s.set_trajectories(Trajectories::empty(3, (64, 48))).unwrap();
    s.run().unwrap();
    assert_eq!(s.push_rgba(&shades(64, 48, 0), 64, 48).unwrap_err().code(), "state");
    assert_eq!(s.set_trajectories(Trajectories::empty(3, (64, 48))).unwrap_err().code(), "state");
    s.clear();
    s.set_trajectories(Trajectories::empty(3, (64, 48))).unwrap();
}

#[test]
fn progress_counts_up_to_its_total_in_every_stage() {
    let mut s = session();
    for _ in 0..4 {
        s.push_rgba(&shades(40, 30, 50), 40, 30).unwrap();
    }
    let mut last = std::collections::BTreeMap::new();
    while let Step::Working(p) = s.step().unwrap() {
        let before = last.insert(p.stage, p);
        assert!(p.done <= p.total && before.is_none_or(|b| b.done < p.done));
    }
    assert_eq!(last.len(), Stage::ALL.len());
    assert!(last.values().all(|p| p.done == p.total));
}

#[test]
fn a_run_without_masks_ends_without_objects() {
    for is_dense in [true, false] {
        let mut params = Params::default();
        params.clip.dense = is_dense;
        let mut s = Session::new(params).unwrap();
        for _ in 0..3 {
            s.push_rgba(&shades(32, 24, 9), 32, 24).unwrap();
        }
        s.run().unwrap();
        assert_eq!(s.objects().is_some(), is_dense);
        assert_eq!(s.labels(0).is_ok(), is_dense);
    }
}
