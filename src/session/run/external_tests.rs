//! Laws of trajectories from outside, beside frames.

use super::session::Phase;
use crate::Session;
use crate::image::{Frame, Plane};
use crate::synth::Scene;
use crate::trajectory::Trajectories;
use crate::{Error, Params};

const SIZE: (usize, usize) = (320, 180);
const FRAMES: usize = 10;

fn frames() -> Vec<Frame> {
    let scene = Scene::sample((SIZE.0, SIZE.1), FRAMES, 2);
    (0..FRAMES).map(|t| scene.frame(t)).collect()
}

fn with(frames: &[Frame]) -> Session {
    let mut session = Session::new(Params::default()).unwrap();
    frames.iter().for_each(|frame| session.push_frame(frame.clone()).unwrap());
    session
}

fn masks(session: &Session) -> Vec<Plane<u8>> {
    (0..FRAMES).map(|t| session.labels(t).unwrap()).collect()
}

/// What the tracker found, as another one would give it.
fn outside(session: &Session) -> Trajectories {
    let mut tracks = session.trajectories().unwrap().clone();
    tracks.variation.fill(0.0);
    tracks
}

#[test]
fn our_own_trajectories_from_outside_give_our_own_masks() {
    let frames = frames();
    let mut ours = with(&frames);
    ours.run().unwrap();
    let mut theirs = with(&frames);
    theirs.set_trajectories(outside(&ours)).unwrap();
    // How far apart they are is guessed from how many there are; here it is known.
    let Phase::Frames(clip) = &mut theirs.phase else { panic!("the run has begun") };
    clip.params = ours.params().scaled_to(SIZE);
    theirs.run().unwrap();
    assert_eq!(theirs.running().unwrap().outputs.track_set.tracks, ours.running().unwrap().outputs.track_set.tracks);
    assert_eq!(theirs.clusters(), ours.clusters());
    assert!(ours.objects().unwrap().highest_label > 1);
    assert_eq!(masks(&theirs), masks(&ours));
}

#[test]
fn with_a_guessed_spacing_masks_are_nearly_the_same_and_the_order_of_calls_does_not_matter() {
    let frames = frames();
    let mut ours = with(&frames);
    ours.run().unwrap();
    let mut after = with(&frames);
    after.set_trajectories(outside(&ours)).unwrap();
    let mut before = with(&[]);
    before.set_trajectories(outside(&ours)).unwrap();
    frames.iter().for_each(|frame| before.push_frame(frame.clone()).unwrap());
    after.run().unwrap();
    before.run_on(2, |_| {}).unwrap();
    assert_eq!(masks(&before), masks(&after));
    assert_eq!(before.trajectories(), Some(&outside(&ours)));
    let same = |(a, b): (&Plane<u8>, &Plane<u8>)| a.data().iter().zip(b.data()).filter(|(a, b)| a == b).count();
    let agreed: usize = masks(&ours).iter().zip(&masks(&after)).map(same).sum();
    let share = agreed as f64 / (SIZE.0 * SIZE.1 * FRAMES) as f64;
    assert!(share > 0.98, "{share} of the pixels are the same");
}

#[test]
fn what_does_not_fit_the_frames_is_refused_and_can_be_set_again() {
    let frames: Vec<Frame> = frames().into_iter().take(3).collect();
    let corners = [(-0.5, -0.5, 0.0), (319.5, 179.5, 0.0), (0.0, 179.5, 0.0)];
    let made = |count, size, point: (f32, f32, f32)| {
        let mut tracks = Trajectories::empty(count, size);
        tracks.push(0, corners);
        tracks.push(1, [point]);
        tracks
    };
    let mut session = with(&frames);
    let size = session.set_trajectories(made(3, (320, 200), corners[0])).unwrap_err();
    assert_eq!(size.to_string(), "trajectories of 320x200 pixels (expected 320x180, as the frames)");
    let refused = |session: &mut Session, tracks| {
        session.set_trajectories(tracks).unwrap();
        session.run().unwrap_err().to_string()
    };
    let longer = refused(&mut session, made(4, SIZE, corners[0]));
    assert_eq!(longer, "trajectories of 4 frames (expected 3, as many as were pushed)");
    let outside = refused(&mut session, made(3, SIZE, (20.0, 179.6, 0.0)));
    assert_eq!(outside, "y[3] = 179.60000610351563 (expected a position in the frame, -0.5..=179.5)");
    session.set_trajectories(made(3, SIZE, corners[1])).unwrap();
    session.run().unwrap();
    assert_eq!(session.labels(2).unwrap().data().len(), 320 * 180);
    session.clear();
    session.set_trajectories(made(3, (320, 200), corners[0])).unwrap();
    let error = session.push_frame(frames[0].clone()).unwrap_err();
    assert_eq!(error, Error::FrameSizeChanged { index: 0, expected: (320, 200), actual: SIZE });
}

#[test]
fn clips_in_windows_take_none() {
    let frames = frames();
    let tracks = Trajectories::empty(2, SIZE);
    let mut session = with(&[]);
    session.push_in_shot(frames[0].clone()).unwrap();
    assert_eq!(session.set_trajectories(tracks.clone()).unwrap_err().code(), "state");
    session.clear();
    session.set_trajectories(tracks).unwrap();
    assert_eq!(session.push_in_shot(frames[0].clone()).unwrap_err().code(), "state");
    session.push_frame(frames[0].clone()).unwrap();
    session.push_frame(frames[1].clone()).unwrap();
    session.run().unwrap();
}
