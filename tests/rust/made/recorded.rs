//! Sessions written down with their outcome, for other builds to do again: `tests/differ.mjs`.

use super::choices::Choices;
use super::clips::{frames, params};
use super::sessions::{Results, results};
use serde_json::{Value, json};
use std::path::Path;
use tracecut::{Params, Session};

/// Writes `SEED.json`, what goes in but for the frames and what came out, and `SEED.rgba`, the frames.
pub fn write(folder: &Path, seed: u64) {
    let mut choices = Choices::of_seed(seed, "differ");
    let params = params(&mut choices);
    let clip = frames(&mut choices);
    let (width, height) = clip.first().map_or((0, 0), |frame| (frame.width(), frame.height()));
    let rgba: Vec<u8> =
        clip.iter().flat_map(|f| f.rgb().chunks_exact(3)).flat_map(|p| [p[0], p[1], p[2], 255]).collect();
    let run = |threads: usize| -> Result<Results, tracecut::Error> {
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
        "params": tree(&params), "width": width, "height": height, "frames": clip.len(), "outcome": told(&outcome),
    });
    std::fs::write(folder.join(format!("{seed}.rgba")), rgba).unwrap();
    std::fs::write(folder.join(format!("{seed}.json")), serde_json::to_string(&record).unwrap()).unwrap();
}

/// Through text, in which 0.1 in single precision is 0.1.
fn tree(params: &Params) -> Value {
    serde_json::from_str(&serde_json::to_string(params).unwrap()).unwrap()
}

/// As `outcomeOf` in `tests/differ.mjs`.
fn told(outcome: &Result<Results, tracecut::Error>) -> Value {
    match outcome {
        Ok(found) => json!({
            "tracks": of_words(&found.tracks),
            "labels": of_words(&found.labels),
            "superpixels": found.superpixels.iter().map(|map| of_words(map)).collect::<Vec<_>>(),
            "masks": found.masks.iter().map(|mask| fnv1a(mask.data().iter().copied())).collect::<Vec<_>>(),
        }),
        Err(error) => json!({ "error": error.code() }),
    }
}

fn of_words(words: &[u32]) -> String {
    fnv1a(words.iter().flat_map(|v| v.to_le_bytes()))
}

/// As `fnv1a` in `tests/fingerprint.mjs`.
fn fnv1a(bytes: impl Iterator<Item = u8>) -> String {
    format!("{:08x}", bytes.fold(0x811c_9dc5_u32, |hash, b| (hash ^ u32::from(b)).wrapping_mul(0x0100_0193)))
}
