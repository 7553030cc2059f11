//! Whole sessions, in any order of calls, and the same clip by different ways.

use super::choices::Choices;
use super::clips::{correction, frames, params, tracks};
use super::laws::{allowed, check_session};
use tracecut::image::{Frame, Plane};
use tracecut::{Checkpoint, Error, Session, Step, Windows};

/// A session of any legal parameters in any order of calls: nothing panics, and what comes out keeps its laws.
pub fn any_calls(choices: &mut Choices<'_>) {
    let mut session = Session::new(params(choices)).unwrap();
    let clip = frames(choices);
    let size = size_of(&clip);
    if choices.once_in(5) {
        allowed(session.set_trajectories(tracks(choices, clip.len(), size)));
    }
    push_all(choices, &mut session, &clip);
    if choices.once_in(5) {
        for _ in 0..choices.below(40) {
            allowed(session.step());
        }
        check_session(&session);
        if choices.once_in(3) {
            session.clear();
            push(&mut session, &clip);
        }
    }
    // Errors end a run as they would end a caller's.
    while allowed(session.step()).is_some_and(|step| step != Step::Done) {}
    check_session(&session);
    correct(choices, &mut session, 3);
}

fn size_of(clip: &[Frame]) -> (usize, usize) {
    clip.first().map_or((5, 5), |frame| (frame.width(), frame.height()))
}

fn push(session: &mut Session, clip: &[Frame]) {
    for frame in clip {
        allowed(session.push_frame(frame.clone()));
    }
}

/// Frame by frame, or shot by shot with runs in between.
fn push_all(choices: &mut Choices<'_>, session: &mut Session, clip: &[Frame]) {
    let in_shots = choices.once_in(4);
    for frame in clip {
        if !in_shots {
            allowed(session.push_frame(frame.clone()));
        } else if allowed(session.push_in_shot(frame.clone())) == Some(true) {
            allowed(session.run());
            check_session(session);
            allowed(session.advance(1 + choices.below(3)));
        }
    }
}

/// Fewer than `most` corrections, some of them taken back.
fn correct(choices: &mut Choices<'_>, session: &mut Session, most: usize) {
    let (num_frames, size) = (session.num_frames(), session.input_size().unwrap_or((5, 5)));
    for _ in 0..choices.below(most) {
        if allowed(session.correct(&correction(choices, num_frames, size))).is_some() {
            allowed(session.run());
            check_session(session);
        }
        if choices.once_in(4) && session.num_corrections() > 0 {
            allowed(session.undo_correction());
            allowed(session.run());
        }
    }
}

/// Trajectories from outside, lawful or not, alone or with frames.
pub fn outside_tracks(choices: &mut Choices<'_>) {
    let mut session = Session::new(params(choices)).unwrap();
    let mut clip = frames(choices);
    let size = size_of(&clip);
    if choices.once_in(2) {
        clip.clear();
    }
    push(&mut session, &clip);
    let num_frames = if clip.is_empty() { choices.below(12) } else { clip.len() };
    let given = tracks(choices, num_frames, size);
    let legal = given.check().is_ok();
    let taken = allowed(session.set_trajectories(given)).is_some();
    assert!(!taken || legal, "unlawful trajectories were taken");
    allowed(session.run());
    check_session(&session);
    correct(choices, &mut session, 2);
}

/// Many corrections of one result; all of them taken back, it is what it was.
pub fn corrections(choices: &mut Choices<'_>) {
    let mut session = Session::new(params(choices)).unwrap();
    push(&mut session, &frames(choices));
    if allowed(session.run()).is_none() {
        return;
    }
    let before = results(&session);
    correct(choices, &mut session, 6);
    while session.num_corrections() > 0 {
        allowed(session.undo_correction());
        allowed(session.run());
    }
    assert!(results(&session) == before, "corrections that were taken back left something");
}

/// What of a run must be the same by any way.
#[derive(Debug, PartialEq)]
pub struct Results {
    /// Coordinates of all trajectory points, as bits.
    pub tracks: Vec<u32>,
    /// The label of each trajectory.
    pub labels: Vec<u32>,
    /// The superpixel of each pixel, of all frames.
    pub superpixels: Vec<Vec<u32>>,
    /// The masks of all frames.
    pub masks: Vec<Plane<u8>>,
}

/// Those of a session that is done.
pub fn results(session: &Session) -> Results {
    let tracks = session.trajectories().map_or(Vec::new(), |t| t.x.iter().chain(&t.y).map(|v| v.to_bits()).collect());
    let labels = session.clusters().map_or(Vec::new(), |clusters| clusters.label.clone());
    let frames = 0..session.num_frames();
    let superpixels =
        frames.clone().filter_map(|t| Some(session.superpixels(t).ok()?.label().data().to_vec())).collect();
    let masks = frames.filter_map(|t| session.labels(t).ok()).collect();
    Results { tracks, labels, superpixels, masks }
}

/// A clip at one go is the same as stopped and gone on with, on two threads, and by a session that did another before.
pub fn two_ways(choices: &mut Choices<'_>) {
    let params = params(choices);
    let clip = frames(choices);
    let pushed = || {
        let mut session = Session::new(params.clone()).unwrap();
        push(&mut session, &clip);
        session
    };
    let mut whole = pushed();
    if allowed(whole.run()).is_none() {
        return;
    }
    let expected = results(&whole);
    let mut other = pushed();
    for _ in 0..choices.below(60) {
        allowed(other.step());
        // Looking at a half-finished run changes nothing.
        if choices.once_in(16) {
            check_session(&other);
        }
    }
    if choices.once_in(3) {
        other.clear();
        push(&mut other, &clip);
    }
    let threads = 1 + choices.below(3);
    other.run_on(threads, |_| ()).unwrap();
    assert!(results(&other) == expected, "on {threads} threads, in two halves");
}

/// A clip in windows is the same as stopped after any window, written down, read and gone on with.
pub fn windows(choices: &mut Choices<'_>) {
    let params = params(choices);
    let mut clip = frames(choices);
    clip.extend(frames(choices).into_iter().filter(|frame| choices.below(8) > 0 || frame.width() > 5));
    let size = size_of(&clip);
    // A clip is of one size, most times.
    clip.retain(|frame| (frame.width(), frame.height()) == size || choices.once_in(40));
    let again = clip.clone();
    clip.extend(again.into_iter().rev());
    let window = 2 + choices.below(6);
    let (overlap, hides_length) = (1 + choices.below(window - 1), choices.once_in(2));
    let stop = choices.below(4);
    let open = |first: usize| {
        let frames: Vec<Result<Frame, Error>> = clip.iter().skip(first).cloned().map(Ok).collect();
        let frames: Box<dyn Iterator<Item = _>> = match hides_length {
            // Nobody knows how many frames a filter lets through.
            true => Box::new(frames.into_iter().filter(|_| true)),
            false => Box::new(frames.into_iter()),
        };
        Windows::new(params.clone(), frames).unwrap().with_window(window, overlap).unwrap()
    };
    let expected = settled(&mut open(0), usize::MAX);
    let mut halted = open(0);
    let mut masks = settled(&mut halted, stop);
    let checkpoint: Option<Checkpoint> = allowed(halted.checkpoint()).flatten();
    let Some(checkpoint) = checkpoint else { return };
    let bytes = postcard::to_stdvec(&checkpoint).unwrap();
    let checkpoint: Checkpoint = postcard::from_bytes(&bytes).unwrap();
    let first = checkpoint.first_frame();
    match open(first).resume(checkpoint) {
        Ok(mut resumed) => masks.extend(settled(&mut resumed, usize::MAX)),
        Err(error) => drop(allowed(Err::<(), _>(error))),
    }
    assert!(masks == expected, "stopped after window {stop}");
}

/// The masks that the next windows settle, at most `most` of them.
fn settled<I: Iterator<Item = Result<Frame, Error>>>(windows: &mut Windows<I>, most: usize) -> Vec<Plane<u8>> {
    let mut masks = Vec::new();
    for _ in 0..most {
        let Some(Some(window)) = windows.next_window(|_| ()).map(allowed) else { break };
        check_session(windows.session());
        masks.extend(window.settled.filter_map(|t| windows.session().labels(t).ok()));
    }
    masks
}
