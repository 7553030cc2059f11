//! Helpers of the tests of programs, also of `bench`: folders, texts, a clip in which an object moves, and seed files.

#[path = "../../tests/rust/generators/choices.rs"]
mod choices;
#[path = "../../tests/rust/generators/seeds.rs"]
pub(crate) mod seeds;

use image::{ExtendedColorType, ImageEncoder};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

/// Creates an empty folder for a test.
pub(crate) fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    if path.exists() {
        fs::remove_dir_all(&path).unwrap();
    }
    fs::create_dir_all(&path).unwrap();
    path
}

/// Returns a folder of data that are not ours to publish: in `shared/data` beside the repository, or in the `shared` folder that
/// `TRACECUT_SHARED` names. `None`, with a printed line, if it is missing.
pub(crate) fn shared(name: &str) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    let data = std::env::var_os("TRACECUT_SHARED").map_or_else(beside, PathBuf::from).join("data").join(name);
    if !data.is_dir() {
        println!("skipped: no data in {}", data.display());
        return None;
    }
    Some(data)
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Fails the test unless the program ended with `code` and named each of `words` after `error: `.
pub(crate) fn assert_refused(output: &Output, code: i32, words: &[&str]) {
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{message}");
    assert!(message.starts_with("error: ") && !message.contains("panicked"), "{message}");
    for word in words {
        assert!(message.contains(word), "\"{word}\" is missing: {message}");
    }
}

/// What is in a folder, by name.
pub(crate) fn names_in(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

pub(crate) fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// The bytes of a PNG file as they stand in it: labels, or grey levels.
pub(crate) fn png_bytes(path: &Path) -> Vec<u8> {
    let mut reader = png::Decoder::new(std::io::BufReader::new(fs::File::open(path).unwrap())).read_info().unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut data).unwrap();
    data
}

pub(crate) fn assert_done(output: &Output) {
    assert!(output.status.success(), "{}", text(&output.stderr));
}

/// A grey value for each pixel of a frame.
pub(crate) type Picture<'a> = &'a dyn Fn(i32, i32) -> u8;

pub(crate) fn rgb(width: u32, height: u32, picture: Picture) -> Vec<u8> {
    let pixel = |i: u32| picture((i % width) as i32, (i / width) as i32);
    (0..width * height).flat_map(|i| [pixel(i); 3]).collect()
}

pub(crate) fn png(path: &Path, width: u32, height: u32, picture: Picture) {
    let encoder = image::codecs::png::PngEncoder::new(fs::File::create(path).unwrap());
    encoder.write_image(&rgb(width, height, picture), width, height, ExtendedColorType::Rgb8).unwrap();
}

pub(crate) fn clip(folder: &Path, frames: i32, (width, height): (u32, u32), picture: &dyn Fn(i32, i32, i32) -> u8) {
    for t in 0..frames {
        png(&folder.join(format!("f{t}.png")), width, height, &|x, y| picture(x, y, t));
    }
}

/// Smooth noise: bilinear between random values on a grid of 4 pixels.
pub(crate) fn texture(x: i32, y: i32, seed: u64) -> u8 {
    let value = |x: i32, y: i32| f64::from(tracecut::rng::mix(seed ^ ((x as u64) << 32) ^ u64::from(y as u32)) as u8);
    let (i, j) = (x.div_euclid(4), y.div_euclid(4));
    let (a, b) = (f64::from(x.rem_euclid(4)) / 4.0, f64::from(y.rem_euclid(4)) / 4.0);
    let row = |j: i32| (1.0 - a) * value(i, j) + a * value(i + 1, j);
    ((1.0 - b) * row(j) + b * row(j + 1)) as u8
}

pub(crate) const SIZE: (u32, u32) = (128, 96);
pub(crate) const FRAMES: i32 = 10;

/// Whether pixel `(x, y)` of frame `t` belongs to the object: 48 x 40 pixels that go right by two a frame.
pub(crate) fn on_object(x: i32, y: i32, t: i32) -> bool {
    (20 + 2 * t..68 + 2 * t).contains(&x) && (28..68).contains(&y)
}

/// A textured object in front of a background that goes left by one pixel a frame.
pub(crate) fn moving(x: i32, y: i32, t: i32) -> u8 {
    if on_object(x, y, t) { texture(x - 2 * t, y, 1) } else { texture(x + t, y, 2) }
}
