//! Small clips of any content, under any legal parameters, in any order of calls: nothing panics, and whatever comes out
//! keeps its laws. `TRACECUT_SEEDS=FIRST..LAST` runs other seeds than the usual ones and prints what takes long.

use std::time::Instant;
use tracecut::correction::{Correction, Stroke};
use tracecut::image::{Frame, Plane};
use tracecut::params::{ParamGroup, ParamValue};
use tracecut::rng::Rng;
use tracecut::trajectory::Trajectories;
use tracecut::{Params, Session, Step};

/// Seeds of every run, and of the long one.
const USUAL: std::ops::Range<u64> = 0..150;
const LONG: std::ops::Range<u64> = 1000..21_000;

/// What a run may answer to any of these calls.
const CODES: [&str; 7] = ["too-few-frames", "frame-size", "frame-size-changed", "too-large", "param", "data", "state"];

fn pick<T: Copy>(rng: &mut Rng, of: &[T]) -> T {
    of[rng.below(of.len())]
}

/// Ends of the range, values near them, and others; small ones as likely as large ones.
fn legal(rng: &mut Rng, (low, high): (f64, f64)) -> f64 {
    match rng.below(6) {
        0 => low,
        1 => high,
        2 => rng.range(low, high),
        3 => (low + 10_f64.powf(rng.range(-7.0, 0.0))).min(high),
        4 => (high - 10_f64.powf(rng.range(-7.0, 0.0))).max(low),
        _ => (low + (high - low) * 10_f64.powf(rng.range(-6.0, 0.0))).clamp(low, high),
    }
}

/// Legal parameters, a few of them anything, or many.
fn params(rng: &mut Rng) -> Params {
    let mut params = match rng.below(4) {
        0 => Params::paper(),
        1 => Params::fast(),
        _ => Params::default(),
    };
    let mut count = 0;
    params.visit("", &mut |_| count += 1);
    let changed = if rng.below(5) == 0 { rng.below(count) } else { rng.below(7) };
    let chosen: Vec<usize> = (0..changed).map(|_| rng.below(count)).collect();
    let mut at = 0;
    params.visit("", &mut |mut field| {
        at += 1;
        if !chosen.contains(&(at - 1)) {
            return;
        }
        let value = match field.kind() {
            "boolean" => ParamValue::Bool(rng.below(2) == 1),
            "choice" => ParamValue::Text(pick(rng, field.choices()).to_owned()),
            "integer" => ParamValue::Number(legal(rng, field.range).round()),
            _ => ParamValue::Number(legal(rng, field.range)),
        };
        // A number that 32 bits round to more than the range allows is refused, and the old one stays.
        let _ = field.set(&value);
    });
    params
}

/// A clip of some content.
fn frames(rng: &mut Rng) -> Vec<Frame> {
    let most = pick(rng, &[3, 12, 40, 80]);
    let (width, height) = (1 + rng.below(most), 1 + rng.below(most));
    let count = rng.below(6) + usize::from(rng.below(9) > 0);
    let content = rng.below(7);
    let (dx, dy, size) = (rng.range(-4.0, 4.0), rng.range(-4.0, 4.0), rng.range(1.0, 30.0));
    let colour = rng.next_u64().to_le_bytes();
    let cut = rng.below(6);
    (0..count)
        .map(|t| {
            let mut noise = Rng::for_stage(rng.next_u64(), "noise");
            let plane = Plane::from_fn(width, height, |x, y| {
                let (u, v) = (x as f64 - dx * t as f64, y as f64 - dy * t as f64);
                let inside = (u - width as f64 / 2.0).hypot(v - height as f64 / 2.0) < size / 2.0;
                let texture = ((u * 0.7).sin() * (v * 0.9).cos() * 100.0 + 128.0) as u8;
                match content {
                    0 => [colour[0], colour[1], colour[2]],
                    1 => noise.next_u64().to_le_bytes()[..3].try_into().unwrap(),
                    2 => [if (x + y + t) % 2 == 0 { 255 } else { 0 }; 3],
                    3 => [texture, texture.wrapping_add(colour[0]), 255 - texture],
                    4 if inside => [texture, colour[1], 0],
                    4 => [((x * 31 + y * 17) % 256) as u8; 3],
                    5 if t >= cut => [255 - texture; 3],
                    5 => [texture; 3],
                    _ if inside => [255, 255, 255],
                    _ => [0, 0, ((x * 255) / width) as u8],
                }
            });
            Frame::from_rgb(plane.data().iter().flatten().copied().collect(), width, height).unwrap()
        })
        .collect()
}

/// Trajectories of any tracker, some of which break the law.
fn tracks(rng: &mut Rng, num_frames: usize, size: (usize, usize)) -> Trajectories {
    let mut tracks = Trajectories::empty(num_frames, size);
    let wild = rng.below(8) == 0;
    for _ in 0..rng.below(60) {
        let start = rng.below(num_frames.max(1));
        let length = 1 + rng.below(num_frames - start.min(num_frames.saturating_sub(1)));
        let at = (rng.below(size.0) as f32, rng.below(size.1) as f32);
        let by = pick(rng, &[0.0, 0.5, -1.0]);
        let points = (0..length).map(|k| {
            let x = (at.0 + by * k as f32).clamp(0.0, (size.0 - 1) as f32);
            if wild && rng.below(20) == 0 { (f32::NAN, at.1, 0.0) } else { (x, at.1, 0.0) }
        });
        tracks.push(start, points.collect::<Vec<_>>());
    }
    tracks
}

fn correction(rng: &mut Rng, num_frames: usize, (width, height): (usize, usize)) -> Correction {
    let place = |rng: &mut Rng| {
        (
            rng.below(num_frames + 1),
            rng.range(-1.0, width as f64 + 1.0) as f32,
            rng.range(-1.0, height as f64 + 1.0) as f32,
        )
    };
    let stroke = |rng: &mut Rng| {
        let (t, x, y) = place(rng);
        let (_, to_x, to_y) = place(rng);
        Stroke { t, points: vec![(x, y), (to_x, to_y)], radius: rng.range(0.0, 5.0) as f32 }
    };
    match rng.below(4) {
        0 => Correction::Merge { into: rng.below(4) as u8, from: rng.below(4) as u8 },
        1 => {
            let at = (rng.below(2) == 0).then(|| place(rng));
            Correction::Split { label: rng.below(3) as u8, at }
        }
        2 => Correction::Together((0..1 + rng.below(2)).map(|_| stroke(rng)).collect()),
        _ => Correction::Apart((0..2 + rng.below(2)).map(|_| stroke(rng)).collect()),
    }
}

/// An error has to be one of those that are documented.
fn allowed<T>(outcome: Result<T, tracecut::Error>) -> Option<T> {
    match outcome {
        Ok(value) => Some(value),
        Err(error) => {
            assert!(CODES.contains(&error.code()), "{error}");
            None
        }
    }
}

/// All that a session knows keeps its laws.
fn check(session: &Session) {
    let Some((width, height)) = session.input_size() else { return };
    if let Some(tracks) = session.trajectories() {
        tracks.check().unwrap();
    }
    if let Some(embedding) = session.embedding() {
        assert!(embedding.vectors.iter().chain(&embedding.eigenvalues).all(|v| v.is_finite()));
    }
    if let Some(d) = session.discontinuities() {
        assert!(d.d.iter().all(|v| v.is_finite()));
    }
    let known: Vec<u8> = session.objects().map_or(Vec::new(), tracecut::mask::Objects::labels);
    for t in 0..session.num_frames() {
        if let Some(field) = allowed(session.flow(t)) {
            assert!(field.u.data().iter().chain(field.v.data()).all(|v| v.is_finite()));
        }
        if let Some(map) = allowed(session.saliency_map(t)) {
            assert!(map.data().iter().all(|v| v.is_finite() && *v >= 0.0));
        }
        if let Some(map) = allowed(session.boundaries(t)) {
            assert!(map.pb.data().iter().all(|v| (0.0..=1.0).contains(v)));
        }
        if let Some(superpixels) = allowed(session.superpixels(t)) {
            assert!(superpixels.label.data().iter().all(|&l| (l as usize) < superpixels.count));
        }
        if let Some(sure) = allowed(session.confidence(t)) {
            assert!(sure.data().iter().all(|v| (0.0..=1.0).contains(v)));
        }
        allowed(session.background(t));
        if let Some(mask) = allowed(session.labels(t)) {
            assert_eq!((mask.width(), mask.height()), (width, height));
            assert!(mask.data().iter().all(|l| *l == 0 || known.contains(l)), "{known:?}");
            allowed(session.explain(t, width / 2, height / 2));
        }
    }
}

/// One session, from its seed.
fn session(seed: u64) {
    let mut rng = Rng::for_stage(seed, "random");
    let mut session = Session::new(params(&mut rng)).unwrap();
    let clip = frames(&mut rng);
    let size = clip.first().map_or((5, 5), |frame| (frame.width(), frame.height()));
    if rng.below(5) == 0 {
        allowed(session.set_trajectories(tracks(&mut rng, clip.len(), size)));
    }
    let windows = rng.below(4) == 0;
    for frame in &clip {
        if windows {
            if allowed(session.push_in_shot(frame.clone())) == Some(true) {
                allowed(session.run());
                check(&session);
                allowed(session.advance(1 + rng.below(3)));
            }
        } else {
            allowed(session.push_frame(frame.clone()));
        }
    }
    if rng.below(5) == 0 {
        for _ in 0..rng.below(40) {
            allowed(session.step());
        }
        check(&session);
        if rng.below(3) == 0 {
            session.clear();
            for frame in &clip {
                allowed(session.push_frame(frame.clone()));
            }
        }
    }
    // Errors end a run as they would end a caller's.
    while allowed(session.step()).is_some_and(|step| step != Step::Done) {}
    check(&session);
    for _ in 0..rng.below(3) {
        if allowed(session.correct(&correction(&mut rng, clip.len(), size))).is_some() {
            allowed(session.run());
            check(&session);
        }
        if rng.below(4) == 0 && session.num_corrections() > 0 {
            allowed(session.undo_correction());
            allowed(session.run());
        }
    }
}

fn run(seeds: std::ops::Range<u64>, tell: bool) {
    for seed in seeds {
        let begin = Instant::now();
        let outcome = std::panic::catch_unwind(|| session(seed));
        assert!(outcome.is_ok(), "seed {seed}");
        let seconds = begin.elapsed().as_secs_f64();
        if tell && seconds > 1.0 {
            println!("seed {seed}: {seconds:.1} s");
        }
    }
}

fn asked_for() -> Option<std::ops::Range<u64>> {
    let text = std::env::var("TRACECUT_SEEDS").ok()?;
    let (first, last) = text.split_once("..").expect("TRACECUT_SEEDS=FIRST..LAST");
    Some(first.parse().unwrap()..last.parse().unwrap())
}

#[test]
fn any_small_clip_under_any_legal_parameters_keeps_the_laws() {
    run(asked_for().unwrap_or(USUAL), asked_for().is_some());
}

#[test]
#[ignore = "some minutes; part of npm run test:long"]
fn many_more_small_clips() {
    run(LONG, true);
}
