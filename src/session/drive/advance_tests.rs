//! Laws of clips that are taken window by window.

use crate::Session;
use crate::image::Frame;
use crate::rng::Rng;
use crate::synth::Scene;
use crate::{Error, Params};

const SIZE: (usize, usize) = (240, 136);

fn scene(frames: usize, seed: u64) -> Scene {
    Scene::sample((SIZE.0, SIZE.1), frames, seed)
}

fn session() -> Session {
    Session::new(Params::default()).unwrap()
}

fn plain(value: u8) -> Frame {
    Frame::from_rgb(vec![value; 3 * 32 * 24], 32, 24).unwrap()
}

/// The label that most pixels of each true object bear in frame `t` of the window.
fn labels_of_objects(session: &Session, scene: &Scene, t: usize, frame: usize) -> Vec<u8> {
    let (found, truth) = (session.labels(t).unwrap(), scene.mask(frame));
    let mut votes = vec![[0_u32; 256]; scene.num_objects() + 1];
    for (&object, &label) in truth.data().iter().zip(found.data()) {
        votes[usize::from(object)][usize::from(label)] += 1;
    }
    votes[1..].iter().map(|v| (0..=255).max_by_key(|&label| v[usize::from(label)]).unwrap()).collect()
}

#[test]
fn objects_keep_their_labels_and_trajectories_their_numbers_from_window_to_window() {
    let scene = scene(44, 1);
    let mut s = session();
    for t in 0..20 {
        assert!(!s.push_in_shot(scene.frame(t)).unwrap());
    }
    s.run().unwrap();
    let first = labels_of_objects(&s, &scene, 14, 14);
    assert!(first.iter().all(|&label| label > 0), "{first:?}");
    for begin in [12, 24] {
        let (tracks, numbers) = (s.trajectories().unwrap().clone(), s.trajectory_numbers().to_vec());
        let flow = s.flow(15).unwrap();
        s.advance(8).unwrap();
        assert_eq!(s.num_frames(), 8);
        (begin + 8..begin + 20).for_each(|t| assert!(!s.push_in_shot(scene.frame(t)).unwrap()));
        s.run().unwrap();
        assert_eq!(labels_of_objects(&s, &scene, 10, begin + 10), first);
        assert_eq!(s.flow(3).unwrap(), flow);
        let mut common = 0;
        for (i, number) in s.trajectory_numbers().iter().enumerate() {
            let Some(old) = numbers.iter().position(|n| n == number) else { continue };
            common += 1;
            for t in 0..8 {
                if let (Some(now), Some(before)) = (s.trajectories().unwrap().at(i, t), tracks.at(old, t + 12)) {
                    assert_eq!(now, before);
                }
            }
        }
        assert!(common > 50, "{common} common trajectories");
    }
}

#[test]
fn a_cut_holds_the_frame_back_and_begins_a_shot_with_new_labels() {
    let (one, other) = (scene(12, 0), scene(12, 7));
    let mut s = session();
    (0..12).for_each(|t| assert!(!s.push_in_shot(one.frame(t)).unwrap()));
    assert!(s.push_in_shot(other.frame(0)).unwrap() && s.holds_next_shot());
    assert_eq!(s.push_in_shot(other.frame(1)).unwrap_err().code(), "state");
    assert_eq!(s.num_frames(), 12);
    s.run().unwrap();
    let (before, last_number) = (s.objects().unwrap().labels(), *s.trajectory_numbers().iter().max().unwrap());
    s.advance(5).unwrap();
    assert_eq!((s.num_frames(), s.holds_next_shot()), (1, false));
    (1..12).for_each(|t| assert!(!s.push_in_shot(other.frame(t)).unwrap()));
    s.run().unwrap();
    let after = s.objects().unwrap().labels();
    assert!(!before.is_empty() && !after.is_empty());
    assert!(after.iter().all(|label| !before.contains(label)), "{before:?} {after:?}");
    assert!(s.trajectory_numbers().iter().all(|&n| n > last_number));
}

#[test]
fn a_cut_right_after_a_window_begins_a_shot_without_another_run() {
    let (one, other) = (scene(12, 0), scene(12, 7));
    let mut s = session();
    (0..12).for_each(|t| assert!(!s.push_in_shot(one.frame(t)).unwrap()));
    s.run().unwrap();
    let before = s.objects().unwrap().labels();
    s.advance(5).unwrap();
    assert_eq!(s.advance(5).unwrap_err().code(), "state");
    assert!(s.push_in_shot(other.frame(0)).unwrap());
    s.advance(5).unwrap();
    assert_eq!((s.num_frames(), s.holds_next_shot()), (1, false));
    (1..12).for_each(|t| assert!(!s.push_in_shot(other.frame(t)).unwrap()));
    s.run().unwrap();
    let after = s.objects().unwrap().labels();
    assert!(!before.is_empty() && !after.is_empty());
    assert!(after.iter().all(|label| !before.contains(label)), "{before:?} {after:?}");
}

#[test]
fn a_shot_of_one_frame_is_all_background() {
    let mut s = session();
    assert!(!s.push_in_shot(plain(10)).unwrap());
    assert!(s.push_in_shot(plain(200)).unwrap());
    for _ in 0..2 {
        s.run().unwrap();
        assert_eq!(s.labels(0).unwrap().data(), vec![0; 32 * 24]);
        assert!(s.trajectories().unwrap().is_empty() && s.saliency().is_none());
        if s.holds_next_shot() {
            s.advance(1).unwrap();
        }
    }
    assert_eq!(s.advance(1).unwrap_err().code(), "param");
    assert_eq!(s.labels(0).unwrap().data(), vec![0; 32 * 24]);
}

#[test]
fn advance_wants_a_finished_window_a_legal_overlap_and_then_new_frames() {
    let mut s = session();
    assert_eq!(s.advance(1).unwrap_err().code(), "state");
    (0..6).for_each(|k| assert!(!s.push_in_shot(plain(50 + k)).unwrap()));
    assert_eq!(s.advance(1).unwrap_err().code(), "state");
    s.run().unwrap();
    assert_eq!(s.advance(6).unwrap_err().to_string(), "overlap = 6 (expected a whole number of frames, 1..=5)");
    assert_eq!(s.advance(0).unwrap_err().code(), "param");
    assert_eq!(s.labels(5).unwrap().width(), 32);
    s.advance(3).unwrap();
    assert_eq!(s.run(), Err(Error::TooFewFrames { got: 3, needed: 4 }));
    s.push_in_shot(plain(56)).unwrap();
    s.run().unwrap();
    assert_eq!(s.num_frames(), 4);
    let mut plain_session = session();
    (0..3).for_each(|_| plain_session.push_frame(plain(9)).unwrap());
    plain_session.run().unwrap();
    assert_eq!(plain_session.advance(1).unwrap_err().code(), "state");
}

/// A scene of random grey blocks, and before it a red square of blocks of its own that leaves the frame to the right and
/// comes back.
fn leaving_and_back(t: usize) -> Frame {
    let (w, h) = (160, 96);
    let noise = |u: usize, v: usize| Rng::for_stage((u / 4 * 1000 + v / 4) as u64, "leaving").below(200) as u8;
    let left = if t < 40 { 40 + 4 * t } else { 400 - 4 * t };
    let pixel = |i: usize| {
        let (x, y) = (i % w, i / w);
        let grey = noise(x, y);
        if (left..left + 40).contains(&x) && (30..70).contains(&y) {
            let own = noise(x + 900 - left, y);
            return [55 + own, own / 4, own / 4];
        }
        [grey; 3]
    };
    Frame::from_rgb((0..w * h).flat_map(pixel).collect(), w, h).unwrap()
}

#[test]
fn what_leaves_the_frame_and_comes_back_has_its_label_again() {
    let mut s = session();
    let mut labels = Vec::new();
    for begin in [0, 15, 30, 45, 60] {
        if begin > 0 {
            s.advance(5).unwrap();
        }
        let first = begin + s.num_frames();
        (first..begin + 20).for_each(|t| assert!(!s.push_in_shot(leaving_and_back(t)).unwrap()));
        s.run().unwrap();
        labels.push(s.objects().unwrap().labels());
    }
    assert_eq!(labels.first(), Some(&vec![1]), "{labels:?}");
    assert!(labels[2].is_empty(), "{labels:?}");
    assert_eq!(labels.last(), Some(&vec![1]), "{labels:?}");
}
