//! Laws of the iterator of windows.

use crate::correction::Correction;
use crate::image::Frame;
use crate::synth::Scene;
use crate::{Error, Params};
use crate::{Session, Window, Windows};

const SIZE: (usize, usize) = (72, 48);
/// Large enough for objects.
const WITH_OBJECTS: (usize, usize) = (96, 64);

fn scene(frames: usize, seed: u64) -> impl Iterator<Item = Result<Frame, Error>> {
    scene_of(SIZE, frames, seed)
}

fn scene_of((width, height): (usize, usize), frames: usize, seed: u64) -> impl Iterator<Item = Result<Frame, Error>> {
    let scene = Scene::sample((width, height), frames, seed);
    (0..frames).map(move |t| Ok(scene.frame(t)))
}

fn all<I: Iterator<Item = Result<Frame, Error>>>(mut windows: Windows<I>) -> Vec<Window> {
    let mut found = Vec::new();
    while let Some(window) = windows.next_window(|_| ()) {
        let window = window.unwrap();
        assert!(window.settled.end <= windows.session().num_frames());
        assert!(window.settled.clone().all(|t| windows.session().labels(t).is_ok()));
        found.push(window);
    }
    assert!(windows.next_window(|_| ()).is_none());
    found
}

/// The clip's numbers of the settled frames, in the order in which they were settled.
fn settled(windows: &[Window]) -> Vec<usize> {
    windows.iter().flat_map(|w| w.settled.clone().map(|t| w.first_frame + t)).collect()
}

fn windows<I: Iterator<Item = Result<Frame, Error>>>(frames: I, window: usize, overlap: usize) -> Windows<I> {
    Windows::new(Params::default(), frames).unwrap().with_window(window, overlap).unwrap()
}

#[test]
fn each_frame_is_settled_once_and_in_order() {
    for (count, window, overlap) in [(1, 12, 4), (2, 12, 4), (12, 12, 4), (13, 12, 4), (30, 12, 5), (20, 2, 1)] {
        let found = all(windows(scene(count, 1), window, overlap));
        assert_eq!(settled(&found), (0..count).collect::<Vec<_>>(), "{count} frames by {window}");
        assert!(found.iter().enumerate().all(|(k, w)| w.index == k && w.shot == 0));
    }
}

#[test]
fn a_window_of_all_frames_is_a_session() {
    let mut session = crate::Session::new(Params::default()).unwrap();
    scene(10, 3).for_each(|frame| session.push_frame(frame.unwrap()).unwrap());
    session.run().unwrap();
    let mut windows = windows(scene(10, 3), 10, 4).with_threads(2);
    assert_eq!(windows.next_window(|_| ()).unwrap().unwrap().settled, 0..10);
    for t in 0..10 {
        assert_eq!(windows.session().labels(t).unwrap(), session.labels(t).unwrap());
    }
}

#[test]
fn the_last_window_is_a_full_one() {
    let found = all(windows(scene(15, 1), 12, 4));
    assert_eq!(found.iter().map(|w| w.first_frame).collect::<Vec<_>>(), [0, 3]);
}

#[test]
fn a_cut_ends_a_window_wherever_it_falls() {
    // In the middle of a window, right after a full one, in the first frame after it, and shots of a single frame.
    for cut in [1, 6, 12, 13, 19] {
        let found = all(windows(scene(cut, 1).chain(scene(20 - cut, 7)), 12, 4));
        assert_eq!(settled(&found), (0..20).collect::<Vec<_>>(), "a cut before frame {cut}");
        let begin = found.iter().find(|w| w.shot == 1).map(|w| w.first_frame);
        assert_eq!(begin, Some(cut));
        assert_eq!(found.last().map(|w| w.shot), Some(1));
    }
}

#[test]
fn an_error_ends_it_and_names_the_frame_of_the_clip() {
    let small = Frame::from_rgb(vec![0; 3 * 16 * 16], 16, 16).unwrap();
    let mut windows = windows(scene(15, 1).chain([Ok(small)]), 12, 4);
    assert!(windows.next_window(|_| ()).unwrap().is_ok());
    let error = windows.next_window(|_| ()).unwrap().unwrap_err();
    assert_eq!(error, Error::FrameSizeChanged { index: 15, expected: SIZE, actual: (16, 16) });
    assert!(windows.next_window(|_| ()).is_none());
}

#[test]
fn windows_and_overlaps_have_ranges() {
    let new = || Windows::new(Params::default(), scene(2, 0)).unwrap();
    for (window, overlap, message) in [
        (1, 1, "window = 1 (expected a whole number of frames, 2..=400)"),
        (401, 1, "window = 401 (expected a whole number of frames, 2..=400)"),
        (10, 10, "overlap = 10 (expected a whole number of frames, 1..=9)"),
        (10, 0, "overlap = 0 (expected a whole number of frames, 1..=9)"),
    ] {
        assert_eq!(new().with_window(window, overlap).err().unwrap().to_string(), message);
    }
}

#[test]
fn an_error_of_the_report_ends_the_clip() {
    let mut windows = windows(scene(20, 1), 12, 4).with_threads(2);
    let mut steps = 0;
    let stops = |_| {
        steps += 1;
        if steps == 5 { Err(Error::State { reason: "stopped".to_owned() }) } else { Ok(()) }
    };
    assert!(matches!(windows.try_next_window(stops), Some(Err(Error::State { reason })) if reason == "stopped"));
    assert_eq!(steps, 5);
    assert!(windows.next_window(|_| ()).is_none());
}

type Masks = Vec<crate::image::Plane<u8>>;

/// The masks that a window settles.
fn masks_of<I: Iterator<Item = Result<Frame, Error>>>(windows: &Windows<I>, window: &Window) -> Masks {
    window.settled.clone().map(|t| windows.session().labels(t).unwrap()).collect()
}

/// Shots of 12, 17 and 1 frames: cuts after a full window, in one, and next to the end.
fn shots(skipped: usize) -> impl Iterator<Item = Result<Frame, Error>> {
    let scene = |frames, seed| scene_of(WITH_OBJECTS, frames, seed);
    scene(12, 1).chain(scene(17, 7)).chain(scene(1, 3)).skip(skipped)
}

#[test]
fn a_clip_goes_on_from_every_checkpoint_as_if_it_had_not_stopped() {
    let mut whole = windows(shots(0), 10, 4);
    let (mut expected, mut checkpoints): (Vec<(Window, Masks)>, Vec<_>) = Default::default();
    while let Some(window) = whole.next_window(|_| ()) {
        let window = window.unwrap();
        expected.push((window.clone(), masks_of(&whole, &window)));
        checkpoints.extend(whole.checkpoint().unwrap());
    }
    assert!(expected.iter().any(|(_, masks)| masks.iter().any(|mask| mask.data().iter().any(|&label| label > 0))));
    assert_eq!((checkpoints.len(), expected.last().map(|(window, _)| window.shot)), (expected.len() - 1, Some(2)));
    for checkpoint in checkpoints {
        let (from, first) = (checkpoint.window(), checkpoint.first_frame());
        assert_eq!(checkpoint.settled(), expected[from].0.first_frame + expected[from].0.settled.start);
        let mut rest = windows(shots(first), 10, 4).resume(checkpoint).unwrap();
        for (window, masks) in &expected[from..] {
            assert_eq!(&rest.next_window(|_| ()).unwrap().unwrap(), window);
            assert!(&masks_of(&rest, window) == masks, "window {} after a stop before {from}", window.index);
        }
        assert!(rest.next_window(|_| ()).is_none());
    }
}

#[test]
fn windows_without_stops_are_those_with_checkpoints_and_looking_ahead_is_knowing_the_length() {
    type Frames = Box<dyn Iterator<Item = Result<Frame, Error>>>;
    let run = |frames: Frames, stops: bool| {
        let mut windows = windows(frames, 10, 4);
        let mut found: Vec<(Window, Masks)> = Vec::new();
        while let Some(window) = windows.next_window(|_| ()) {
            let window = window.unwrap();
            found.push((window.clone(), masks_of(&windows, &window)));
            assert!(!stops || windows.checkpoint().is_ok());
        }
        found
    };
    for skipped in [0, 9] {
        let known = run(Box::new(shots(skipped)), false);
        // Nobody knows how many frames a filter lets through.
        assert!(run(Box::new(shots(skipped).filter(|_| true)), true) == known, "{skipped} skipped");
    }
}

#[test]
fn a_checkpoint_needs_the_frames_that_follow_it() {
    let mut whole = windows(scene(15, 1), 10, 4);
    assert!(whole.checkpoint().unwrap().is_none());
    whole.next_window(|_| ()).unwrap().unwrap();
    let checkpoint = whole.checkpoint().unwrap().unwrap();
    let first = checkpoint.first_frame();
    let error = windows(scene(10, 1).skip(first), 10, 4).resume(checkpoint).err().unwrap();
    assert_eq!(error, Error::TooFewFrames { got: 5, needed: 6 });
}

/// Windows of a clip, and what a session of the same frames has that is corrected and goes on in the same way.
#[test]
fn a_corrected_window_goes_on_as_a_corrected_session_does() {
    let (mut clip, mut session) =
        (windows(scene_of(WITH_OBJECTS, 20, 1), 12, 4), Session::new(Params::default()).unwrap());
    assert!(matches!(clip.correct(&Correction::Split { label: 1, at: None }), Err(Error::State { .. })));
    let first = clip.next_window(|_| ()).unwrap().unwrap();
    let before = masks_of(&clip, &first);
    for frame in scene_of(WITH_OBJECTS, 20, 1).take(12) {
        session.push_in_shot(frame.unwrap()).unwrap();
    }
    session.run().unwrap();
    let split = Correction::Split { label: 1, at: None };
    clip.correct(&split).unwrap();
    clip.undo_correction().unwrap();
    assert!(masks_of(&clip, &first) == before && clip.undo_correction().is_err());
    clip.correct(&split).unwrap();
    session.correct(&split).unwrap();
    session.run().unwrap();
    let mut steps = 0;
    clip.rerun(|_| steps += 1).unwrap();
    assert!(steps > 0 && masks_of(&clip, &first) != before);
    clip.correct(&Correction::Merge { into: 0, from: 2 }).unwrap();
    session.correct(&Correction::Merge { into: 0, from: 2 }).unwrap();
    assert!(first.settled.clone().all(|t| clip.session().labels(t).unwrap() == session.labels(t).unwrap()));
    session.advance(4).unwrap();
    for frame in scene_of(WITH_OBJECTS, 20, 1).skip(12) {
        session.push_in_shot(frame.unwrap()).unwrap();
    }
    session.run().unwrap();
    let second = clip.next_window(|_| ()).unwrap().unwrap();
    assert!(second.settled.clone().all(|t| clip.session().labels(t).unwrap() == session.labels(t).unwrap()));
}

#[test]
fn the_next_window_first_makes_the_masks_of_a_correction() {
    let second = |reruns: bool| {
        let mut clip = windows(scene_of(WITH_OBJECTS, 20, 1), 12, 4).with_threads(2);
        clip.next_window(|_| ()).unwrap().unwrap();
        clip.correct(&Correction::Split { label: 1, at: None }).unwrap();
        assert!(!reruns || clip.rerun(|_| ()).is_ok());
        let window = clip.next_window(|_| ()).unwrap().unwrap();
        masks_of(&clip, &window)
    };
    assert!(second(false) == second(true));
}
