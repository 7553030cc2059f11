//! The readers of files, each by the bytes alone: what fuzzing and its tests call.

use crate::failure::{Failure, Result};
use crate::{animation, images, input, settings};
use std::io::Cursor;
use std::path::Path;
use tracecut::Params;
use tracecut::image::{Frame, MAX_PIXELS};

/// What such bytes are called in an error.
const NAME: &str = "bytes";

fn told<T>(outcome: Result<T>) -> std::result::Result<T, String> {
    outcome.map_err(|failure: Failure| failure.reason)
}

/// At most `most` frames of an animated GIF, PNG or WebP.
///
/// # Errors
/// As the command line says it.
pub fn animation(bytes: &[u8], most: usize) -> std::result::Result<Vec<Frame>, String> {
    let kind = match bytes {
        [b'R', ..] => animation::Kind::WebP,
        [0x89, ..] => animation::Kind::Png,
        _ => animation::Kind::Gif,
    };
    let frames = told(animation::frames(kind, NAME, Cursor::new(bytes.to_vec()), MAX_PIXELS))?;
    frames.take(most).map(|frame| told(frame).map(|frame| frame.frame)).collect()
}

/// At most `most` frames of a Y4M stream.
///
/// # Errors
/// As the command line says it.
pub fn y4m(bytes: &[u8], most: usize) -> std::result::Result<Vec<Frame>, String> {
    let frames = told(input::y4m_frames(Path::new(NAME), Cursor::new(bytes.to_vec()), MAX_PIXELS))?;
    frames.take(most).map(|frame| told(frame).map(|frame| frame.frame)).collect()
}

/// The names in a `.bmf` list.
///
/// # Errors
/// As the command line says it.
pub fn list(text: &str) -> std::result::Result<Vec<String>, String> {
    told(images::names_in(Path::new(NAME), text)).map(|names| names.iter().map(|&name| name.to_owned()).collect())
}

/// Parameters from JSON.
///
/// # Errors
/// As the command line says it.
pub fn parameters(text: &str) -> std::result::Result<Params, String> {
    let mut params = Params::default();
    told(settings::apply(&mut params, Path::new(NAME), text)).map(|()| params)
}

/// A setting of the command line, `key=value`.
///
/// # Errors
/// As the command line says it.
pub fn setting(text: &str) -> std::result::Result<Params, String> {
    let (name, value) = settings::parse_setting(text)?;
    let mut params = Params::default();
    params.set(&name, &value).map(|()| params).map_err(|e| e.to_string())
}
