//! Sessions with random calls, runs that must give the same result, single images, and sessions recorded for other builds.

use super::choices::Choices;
use super::clips::{correction, frames, image, params, tracks};
use super::invariants::{allowed, check_boundaries, check_session, check_superpixels};
use serde_json::{Value, json};
use std::path::Path;
use tracecut::contour::{Segments, boundary_map, contour_segments};
use tracecut::image::{Frame, Plane};
use tracecut::mask::enlarge;
use tracecut::still::image_discontinuities;
use tracecut::superpixel::{superpixels_in, superpixels_of};
use tracecut::{Checkpoint, Error, Params, Session, Step, Windows};

/// Checks a session with any legal parameters after random calls.
pub fn check_random_calls(choices: &mut Choices<'_>) {
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

/// Pushes frames, with or without runs at the end of each shot.
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

/// Makes fewer than `most` corrections, and undoes some of them.
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

/// Checks a session with given trajectories, valid or not, with or without frames.
pub fn check_given_tracks(choices: &mut Choices<'_>) {
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
    assert!(!taken || legal, "invalid trajectories were accepted");
    allowed(session.run());
    check_session(&session);
    correct(choices, &mut session, 2);
}

/// Checks that a result is restored when all of its corrections are undone.
pub fn check_undo(choices: &mut Choices<'_>) {
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
    assert!(results(&session) == before, "undone corrections changed the result");
}

/// The results that must be the same however a clip is run.
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

/// Returns the results of a finished session.
pub fn results(session: &Session) -> Results {
    let tracks = session.trajectories().map_or(Vec::new(), |t| t.x.iter().chain(&t.y).map(|v| v.to_bits()).collect());
    let labels = session.clusters().map_or(Vec::new(), |clusters| clusters.label.clone());
    let frames = 0..session.num_frames();
    let superpixels =
        frames.clone().filter_map(|t| Some(session.superpixels(t).ok()?.label().data().to_vec())).collect();
    let masks = frames.filter_map(|t| session.labels(t).ok()).collect();
    Results { tracks, labels, superpixels, masks }
}

/// Checks that a run that is paused, continued on several threads or in a used session gives the same result.
pub fn check_interrupted_run(choices: &mut Choices<'_>) {
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

/// Checks that windows which stop, are written, read and resumed give the same masks.
pub fn check_resumed_windows(choices: &mut Choices<'_>) {
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

/// Returns the masks that the next windows settle; at most `most` windows.
fn settled<I: Iterator<Item = Result<Frame, Error>>>(windows: &mut Windows<I>, most: usize) -> Vec<Plane<u8>> {
    let mut masks = Vec::new();
    for _ in 0..most {
        let Some(Some(window)) = windows.next_window(|_| ()).map(allowed) else { break };
        check_session(windows.session());
        masks.extend(window.settled.filter_map(|t| windows.session().labels(t).ok()));
    }
    masks
}

/// Checks boundaries, superpixels and discontinuities of a single image under any legal parameters.
pub fn check_image(choices: &mut Choices<'_>) {
    let (params, frame) = (params(choices), image(choices));
    let map = boundary_map(&frame);
    check_boundaries(&map);
    check_segments(&frame, &contour_segments(&map, &params.contour));
    let wanted = choices.once_in(2).then(|| 1 + choices.below(300));
    let found = superpixels_in(&map, wanted, &params.contour, &params.superpixel);
    check_superpixels(&found);
    assert_eq!(found, superpixels_of(&frame, wanted, &params.contour, &params.superpixel));
    let mask = found.label().map(|label| (label % 4) as u8);
    if choices.once_in(4) {
        let picture = image(choices);
        // Refused unless the picture is a larger one of the same shape.
        let _ = enlarge(&mask, &picture, |label| label != 2);
    }
    if choices.once_in(2) {
        check_discontinuities(&frame, &params);
    }
}

fn check_segments(frame: &Frame, segments: &Segments) {
    let inside = |v: f32, side: usize| (-0.5..=side as f32 - 0.5).contains(&v);
    let count = segments.points.len();
    assert!(segments.points.iter().all(|&(x, y)| inside(x, frame.width()) && inside(y, frame.height())));
    assert!(segments.lines.iter().all(|&(a, b)| a != b && (a.max(b) as usize) < count));
}

fn check_discontinuities(frame: &Frame, params: &Params) {
    let found = image_discontinuities(frame, &params.still, params.clip.seed);
    check_boundaries(&found.pb);
    check_boundaries(&found.combined);
    assert!(found.eigenvalues.iter().all(|v| v.is_finite()));
    assert!(found.eigenvectors.iter().flat_map(|plane| plane.data()).all(|v| v.is_finite()));
    for map in [&found.d, &found.spectral] {
        assert!(map.strength.data().iter().chain(map.thin.data()).all(|v| v.is_finite() && *v >= 0.0));
    }
}

/// Writes a session with its outcome, for other builds to repeat (`tests/native/differ.test.mjs`): parameters and outcome in
/// `SEED.json`, the frames in `SEED.rgba`.
pub fn write_session(folder: &Path, seed: u64) {
    let mut choices = Choices::from_seed(seed, "differ");
    let params = params(&mut choices);
    let clip = frames(&mut choices);
    let (width, height) = clip.first().map_or((0, 0), |frame| (frame.width(), frame.height()));
    let rgba: Vec<u8> =
        clip.iter().flat_map(|f| f.rgb().chunks_exact(3)).flat_map(|p| [p[0], p[1], p[2], 255]).collect();
    let run = |threads: usize| -> Result<Results, Error> {
        let mut session = Session::new(params.clone())?;
        for frame in rgba.chunks_exact((4 * width * height).max(1)) {
            session.push_rgba(frame, width, height)?;
        }
        session.run_on(threads, |_| ())?;
        Ok(results(&session))
    };
    let outcome = run(1);
    assert!(run(3) == outcome, "seed {seed}: three threads differ from one");
    let record = json!({
        "params": params_json(&params), "width": width, "height": height, "frames": clip.len(), "outcome": outcome_json(&outcome),
    });
    std::fs::write(folder.join(format!("{seed}.rgba")), rgba).unwrap();
    std::fs::write(folder.join(format!("{seed}.json")), serde_json::to_string(&record).unwrap()).unwrap();
}

/// Goes through text, in which 0.1 in single precision is 0.1.
fn params_json(params: &Params) -> Value {
    serde_json::from_str(&serde_json::to_string(params).unwrap()).unwrap()
}

/// As `outcomeOf` in `tests/native/differ.test.mjs`.
fn outcome_json(outcome: &Result<Results, Error>) -> Value {
    match outcome {
        Ok(found) => json!({
            "tracks": hash_words(&found.tracks),
            "labels": hash_words(&found.labels),
            "superpixels": found.superpixels.iter().map(|map| hash_words(map)).collect::<Vec<_>>(),
            "masks": found.masks.iter().map(|mask| fnv1a(mask.data().iter().copied())).collect::<Vec<_>>(),
        }),
        Err(error) => json!({ "error": error.code() }),
    }
}

fn hash_words(words: &[u32]) -> String {
    fnv1a(words.iter().flat_map(|v| v.to_le_bytes()))
}

/// Returns the hash of bytes, as `fnv1a` in `tests/fingerprint.mjs` does.
pub fn fnv1a(bytes: impl Iterator<Item = u8>) -> String {
    format!("{:08x}", bytes.fold(0x811c_9dc5_u32, |hash, b| (hash ^ u32::from(b)).wrapping_mul(0x0100_0193)))
}
