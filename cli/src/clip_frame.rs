//! Pictures of a clip with their times, whatever they come from.

use crate::failure::Result;
use tracecut::Error;
use tracecut::image::{Frame, MAX_SIDE};

/// A picture of a clip.
#[derive(Debug, Clone)]
pub struct ClipFrame {
    /// Its name in errors: the file's, with the number of the frame where the file holds several.
    pub name: String,
    pub frame: Frame,
    /// `None` in lists of image files.
    pub timing: Option<FrameTiming>,
}

/// The time at which a picture is shown, as its file says it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameTiming {
    /// Presentation time in seconds.
    pub time: f64,
    /// Seconds until the next picture, or the end.
    pub duration: f64,
}

pub(crate) type Frames = Box<dyn Iterator<Item = Result<ClipFrame>>>;

/// Refuses a size before memory is taken for it.
pub(crate) fn check(width: usize, height: usize, most: usize) -> std::result::Result<(), Error> {
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(Error::FrameSize { width, height });
    }
    if width * height > most {
        let (what, actual) = ("pixels in a frame", width * height);
        return Err(Error::TooLarge { what, actual, limit: most, name: "clip.maxPixels" });
    }
    Ok(())
}
