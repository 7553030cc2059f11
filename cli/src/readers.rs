//! The readers of files from bytes, for fuzzing and its tests.

use crate::animation::AnimationKind;
use crate::failure::{Failure, Result};
use crate::{animation, images, input, settings};
use std::io::Cursor;
use std::path::Path;
use tracecut::Params;
use tracecut::image::{Frame, MAX_PIXELS};

/// The name of the bytes in errors.
const NAME: &str = "bytes";

fn with_reason<T>(outcome: Result<T>) -> std::result::Result<T, String> {
    outcome.map_err(|failure: Failure| failure.reason)
}

/// At most `most` frames of an animated GIF, PNG or WebP.
///
/// # Errors
/// The message of the command line.
pub fn animation(bytes: &[u8], most: usize) -> std::result::Result<Vec<Frame>, String> {
    let kind = match bytes {
        [b'R', ..] => AnimationKind::WebP,
        [0x89, ..] => AnimationKind::Png,
        _ => AnimationKind::Gif,
    };
    let frames = with_reason(animation::frames(kind, NAME, Cursor::new(bytes.to_vec()), MAX_PIXELS))?;
    frames.take(most).map(|frame| with_reason(frame).map(|frame| frame.frame)).collect()
}

/// At most `most` frames of a Y4M stream.
///
/// # Errors
/// The message of the command line.
pub fn y4m(bytes: &[u8], most: usize) -> std::result::Result<Vec<Frame>, String> {
    let frames = with_reason(input::y4m_frames(Path::new(NAME), Cursor::new(bytes.to_vec()), MAX_PIXELS))?;
    frames.take(most).map(|frame| with_reason(frame).map(|frame| frame.frame)).collect()
}

/// The names in a `.bmf` list.
///
/// # Errors
/// The message of the command line.
pub fn list(text: &str) -> std::result::Result<Vec<String>, String> {
    with_reason(images::names_in(Path::new(NAME), text))
        .map(|names| names.iter().map(|&name| name.to_owned()).collect())
}

/// Parameters from JSON.
///
/// # Errors
/// The message of the command line.
pub fn parameters(text: &str) -> std::result::Result<Params, String> {
    let mut params = Params::default();
    with_reason(settings::apply(&mut params, Path::new(NAME), text)).map(|()| params)
}

/// A setting of the command line, `key=value`.
///
/// # Errors
/// The message of the command line.
pub fn setting(text: &str) -> std::result::Result<Params, String> {
    let (name, value) = settings::parse_setting(text)?;
    let mut params = Params::default();
    params.set(&name, &value).map(|()| params).map_err(|e| e.to_string())
}
