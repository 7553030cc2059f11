//! Random frames, parameters, trajectories and corrections of small clips.

use super::choices::Choices;
use tracecut::Params;
use tracecut::correction::{Correction, Stroke};
use tracecut::image::{Frame, Plane};
use tracecut::params::ParamValue;
use tracecut::rng::Rng;
use tracecut::trajectory::Trajectories;

/// Returns an end of the range, a value near it or another one; small ones are as likely as large ones.
fn legal(choices: &mut Choices<'_>, low: f64, high: f64) -> f64 {
    match choices.below(6) {
        0 => low,
        1 => high,
        2 => choices.range(low, high),
        3 => (low + 10_f64.powf(choices.range(-7.0, 0.0))).min(high),
        4 => (high - 10_f64.powf(choices.range(-7.0, 0.0))).max(low),
        _ => (low + (high - low) * 10_f64.powf(choices.range(-6.0, 0.0))).clamp(low, high),
    }
}

/// Returns legal parameters, of which a few or many have random values.
pub fn params(choices: &mut Choices<'_>) -> Params {
    let mut params = match choices.below(4) {
        0 => Params::paper(),
        1 => Params::fast(),
        _ => Params::default(),
    };
    let mut count = 0;
    params.for_each(&mut |_| count += 1);
    let changed = if choices.once_in(5) { choices.below(count) } else { choices.below(7) };
    let chosen: Vec<usize> = (0..changed).map(|_| choices.below(count)).collect();
    let (mut at, mut given) = (0, Vec::new());
    params.for_each(&mut |field| {
        at += 1;
        if !chosen.contains(&(at - 1)) {
            return;
        }
        let value = match field.kind() {
            "boolean" => ParamValue::Bool(choices.once_in(2)),
            "choice" => ParamValue::Text(choices.pick(field.choices()).to_owned()),
            "integer" => ParamValue::Number(legal(choices, field.min, field.max).round()),
            _ => ParamValue::Number(legal(choices, field.min, field.max)),
        };
        given.push((field.name, value));
    });
    for (name, value) in given {
        // A number that 32 bits round to more than the range allows is refused, and the old one stays.
        let _ = params.set(&name, &value);
    }
    params
}

/// Returns a clip of some content, of up to six frames.
pub fn frames(choices: &mut Choices<'_>) -> Vec<Frame> {
    let most = choices.pick(&[3, 12, 40, 80]);
    let (width, height) = (1 + choices.below(most), 1 + choices.below(most));
    let count = choices.below(6) + usize::from(!choices.once_in(9));
    clip(choices, (width, height), count)
}

/// Returns an image of some content.
pub fn image(choices: &mut Choices<'_>) -> Frame {
    let most = choices.pick(&[3, 12, 40, 64]);
    let size = (1 + choices.below(most), 1 + choices.below(most));
    clip(choices, size, 1).remove(0)
}

fn clip(choices: &mut Choices<'_>, (width, height): (usize, usize), count: usize) -> Vec<Frame> {
    let content = choices.below(7);
    let (dx, dy, size) = (choices.range(-4.0, 4.0), choices.range(-4.0, 4.0), choices.range(1.0, 30.0));
    let colour = choices.next_u64().to_le_bytes();
    let cut = choices.below(6);
    (0..count)
        .map(|t| {
            let mut noise = Rng::for_stage(choices.next_u64(), "noise");
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

/// Returns trajectories as of any tracker, some of which are invalid.
pub fn tracks(choices: &mut Choices<'_>, num_frames: usize, size: (usize, usize)) -> Trajectories {
    let mut tracks = Trajectories::empty(num_frames, size);
    let kind = choices.below(8);
    for _ in 0..choices.below(60) {
        let start = choices.below(num_frames.max(1));
        let length = 1 + choices.below(num_frames - start.min(num_frames.saturating_sub(1)));
        let at = begin(choices, kind, size);
        let by = choices.pick(&[0.0, 0.5, -1.0]);
        let points: Vec<_> = (0..length)
            .map(|k| {
                let x = (at.0 + by * k as f32).clamp(0.0, (size.0 - 1) as f32);
                match kind {
                    0 if choices.once_in(20) => (choices.pick(&[f32::NAN, f32::INFINITY, f32::MAX]), at.1, 0.0),
                    1 => (at.0 + by * k as f32, at.1, choices.pick(&[0.0, -1.0, 1e30])),
                    _ => (x, at.1, 0.0),
                }
            })
            .collect();
        tracks.push(start, points);
    }
    if kind == 5 && !tracks.is_empty() {
        break_numbers(choices, &mut tracks);
    }
    tracks
}

/// Makes one of the arrays invalid.
fn break_numbers(choices: &mut Choices<'_>, tracks: &mut Trajectories) {
    let number = choices.pick(&[0, 1, 2, 1 << 16, u32::MAX - 1, u32::MAX]);
    let i = choices.below(tracks.len());
    match choices.below(6) {
        0 => tracks.start_frame[i] = number,
        1 => tracks.offset[i + 1] = number,
        2 => drop(tracks.offset.pop()),
        3 => tracks.variation.push(0.0),
        4 => tracks.num_frames = choices.pick(&[0, 1, 2, 300]),
        _ => tracks.size = choices.pick(&[(0, 3), (1, 1), (16_384, 1), (16_385, 1)]),
    }
}

/// Returns where a trajectory begins: anywhere, far outside, all at one place, or all on one line.
fn begin(choices: &mut Choices<'_>, kind: usize, (width, height): (usize, usize)) -> (f32, f32) {
    let (x, y) = (choices.below(width) as f32, choices.below(height) as f32);
    match kind {
        1 => (x * choices.pick(&[1.0, -1.0, 1e3, 1e9, 1e30, 1e38]), y * choices.pick(&[1.0, 1e-30, -1e20])),
        2 => (0.0, 0.0),
        3 => (x, 0.0),
        4 => (x, x.min((height - 1) as f32)),
        _ => (x, y),
    }
}

/// Returns a correction.
pub fn correction(choices: &mut Choices<'_>, num_frames: usize, (width, height): (usize, usize)) -> Correction {
    let place = |choices: &mut Choices<'_>| {
        (
            choices.below(num_frames + 1),
            choices.range(-1.0, width as f64 + 1.0) as f32,
            choices.range(-1.0, height as f64 + 1.0) as f32,
        )
    };
    let stroke = |choices: &mut Choices<'_>| {
        let (t, x, y) = place(choices);
        let (_, to_x, to_y) = place(choices);
        Stroke { t, points: vec![(x, y), (to_x, to_y)], radius: choices.range(0.0, 5.0) as f32 }
    };
    match choices.below(4) {
        0 => Correction::Merge { into: choices.below(4) as u8, from: choices.below(4) as u8 },
        1 => {
            let at = choices.once_in(2).then(|| place(choices));
            Correction::Split { label: choices.below(3) as u8, at }
        }
        2 => Correction::JoinStrokes((0..1 + choices.below(2)).map(|_| stroke(choices)).collect()),
        _ => Correction::SplitStrokes((0..2 + choices.below(2)).map(|_| stroke(choices)).collect()),
    }
}
