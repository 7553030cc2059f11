//! Frames of a clip with their times, from any source.

use crate::failure::Result;
use tracecut::Error;
use tracecut::image::{Frame, MAX_SIDE};

/// A frame of a clip.
#[derive(Debug, Clone)]
pub struct ClipFrame {
    /// Its name in errors: the file name, with the number of the frame if the file has several.
    pub name: String,
    /// Its pixels.
    pub frame: Frame,
    /// `None` in lists of image files.
    pub timing: Option<FrameTiming>,
}

/// The presentation time of a frame in its file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameTiming {
    /// Presentation time in seconds.
    pub time: f64,
    /// Seconds until the next frame, or the end.
    pub duration: f64,
}

pub(crate) type Frames = Box<dyn Iterator<Item = Result<ClipFrame>>>;

/// Checks a size before memory is allocated for it.
pub(crate) fn check(width: usize, height: usize, max_pixels: usize) -> std::result::Result<(), Error> {
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(Error::FrameSize { width, height });
    }
    if width * height > max_pixels {
        return Err(Error::TooLarge {
            what: "pixels in a frame",
            actual: width * height,
            limit: max_pixels,
            name: "clip.max_pixels".to_owned(),
        });
    }
    Ok(())
}
