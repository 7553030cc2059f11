//! Where frames come from: a folder of images, a `.bmf` list, an animated GIF, Y4M from a file, a pipe or standard
//! input, or any video by `ffmpeg`.
//!
//! Frames are read one at a time and once: no decoded clip is held, and none is kept in a file.

use crate::failure::{Failure, Result, cannot_read, read};
use crate::ffmpeg;
use crate::images;
use crate::y4m::Y4m;
use image::codecs::gif::GifDecoder;
use image::error::{DecodingError, ImageFormatHint};
use image::{AnimationDecoder, ImageDecoder, ImageError, Limits};
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use tracecut::image::{Frame, MAX_PIXELS, MAX_SIDE};
use tracecut::{Error, Params};

/// A clip.
#[derive(Debug)]
pub struct Input {
    kind: Kind,
    max_frames: usize,
    /// Most pixels of a frame.
    max_pixels: usize,
}

#[derive(Debug)]
enum Kind {
    Images(Vec<PathBuf>),
    Gif(PathBuf),
    /// A file, or a pipe with a name.
    Y4m(PathBuf),
    Video(PathBuf),
    Stdin,
}

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

impl Input {
    /// Finds out what `path` is; `-` is standard input.
    pub fn open(path: &Path, frames: Option<u32>) -> Result<Self> {
        let max_frames = frames.map_or(usize::MAX, |n| n as usize);
        Ok(Self { kind: Kind::of(path)?, max_frames, max_pixels: MAX_PIXELS })
    }

    /// With the limits of a run.
    pub(crate) fn within(self, params: &Params) -> Self {
        Self { max_pixels: params.clip.max_pixels as usize, ..self }
    }

    /// Number of frames, where known before reading them.
    pub(crate) fn num_frames(&self) -> Option<usize> {
        match &self.kind {
            Kind::Images(paths) => Some(paths.len().min(self.max_frames)),
            _ => None,
        }
    }

    /// The names of the files that the frames are in, where each is in one of its own.
    pub(crate) fn names(&self) -> Option<Vec<String>> {
        let Kind::Images(paths) = &self.kind else { return None };
        let name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Some(paths.iter().take(self.max_frames).map(name).collect())
    }

    /// The frames from the first on; those of standard input, and of a pipe, come once. A failure with
    /// [`damage`](Failure::damage) comes after the whole frames before it, and is the last item.
    pub fn frames(&self) -> Result<impl Iterator<Item = Result<ClipFrame>> + use<>> {
        let most = self.max_pixels;
        let all: Frames = match &self.kind {
            Kind::Images(paths) => Box::new(Images(paths.clone().into_iter(), most)),
            Kind::Gif(path) => gif_frames(&path.display().to_string(), open(path)?, most)?,
            Kind::Y4m(path) => y4m_frames(path, open(path)?, most)?,
            Kind::Video(path) => ffmpeg::frames(path, most)?,
            Kind::Stdin => {
                y4m_frames(Path::new("standard input"), BufReader::with_capacity(1 << 16, std::io::stdin()), most)?
            }
        };
        Ok(all.take(self.max_frames))
    }
}

/// Decodes files one by one, but none that is passed over.
struct Images(std::vec::IntoIter<PathBuf>, usize);

impl Images {
    fn read_frame(&self, path: &Path) -> Result<ClipFrame> {
        let frame = decode_within(path, self.1)?;
        Ok(ClipFrame { name: path.display().to_string(), frame, timing: None })
    }
}

impl Iterator for Images {
    type Item = Result<ClipFrame>;

    fn next(&mut self) -> Option<Self::Item> {
        self.0.next().map(|path| self.read_frame(&path))
    }

    fn nth(&mut self, n: usize) -> Option<Self::Item> {
        self.0.nth(n).map(|path| self.read_frame(&path))
    }
}

impl Kind {
    fn of(path: &Path) -> Result<Self> {
        if path == Path::new("-") {
            return Ok(Self::Stdin);
        }
        if path.is_dir() {
            return images::in_folder(path).map(Self::Images);
        }
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("bmf")) {
            return images::in_list(path).map(Self::Images);
        }
        if path.exists() && !path.is_file() {
            // What is read to look at it would be gone.
            return Ok(Self::Y4m(path.to_owned()));
        }
        let mut start = Vec::new();
        open(path)?.take(9).read_to_end(&mut start).map_err(|e| cannot_read(path, &e))?;
        let path = path.to_owned();
        Ok(if start.starts_with(b"GIF8") {
            Self::Gif(path)
        } else if start == b"YUV4MPEG2" {
            Self::Y4m(path)
        } else {
            Self::Video(path)
        })
    }
}

fn open(path: &Path) -> Result<BufReader<File>> {
    File::open(path).map(BufReader::new).map_err(|e| cannot_read(path, &e))
}

/// Decodes an image file.
pub fn decode(path: &Path) -> Result<Frame> {
    decode_within(path, MAX_PIXELS)
}

/// The same for one of at most `most` pixels.
pub(crate) fn decode_within(path: &Path, most: usize) -> Result<Frame> {
    Frame::decode_within(&read(path)?, most).map_err(|e| Failure::from(e).of(path.display()))
}

pub(crate) fn gif_frames(name: &str, reader: impl BufRead + Seek + 'static, most: usize) -> Result<Frames> {
    let broken = |e: &dyn std::fmt::Display| Failure::about(name, format_args!("is not a whole GIF: {e}"));
    let mut decoder = GifDecoder::new(reader).map_err(|e| broken(&e))?;
    // The decoder takes memory for what the header claims, before it reads a frame.
    let (width, height) = (decoder.dimensions().0 as usize, decoder.dimensions().1 as usize);
    check(width, height, most).map_err(|e| Failure::from(e).of(name))?;
    // A frame may claim to be larger than the picture. It is held, and what it is painted over, and what comes of it.
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(12 * most as u64);
    decoder.set_limits(limits).map_err(|e| broken(&e))?;
    let (name, mut frames) = (name.to_owned(), decoder.into_frames());
    // A decoder that panics on damaged bytes is an error of these.
    let next = move || catch_unwind(AssertUnwindSafe(|| frames.next())).unwrap_or_else(|_| Some(Err(panicked())));
    Ok(Box::new(std::iter::from_fn(next).enumerate().map(move |(index, frame)| {
        let about = format!("{name}, frame {index}");
        let image = match frame {
            Ok(frame) => frame.into_buffer(),
            Err(e) => return Err(Failure::damaged(&name, index, format!("frame {index} cannot be decoded: {e}"))),
        };
        let (width, height) = (image.width() as usize, image.height() as usize);
        let frame = Frame::from_rgba(image.as_raw(), width, height).map_err(|e| Failure::about(&about, e))?;
        Ok(ClipFrame { name: about, frame, timing: None })
    })))
}

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

fn panicked() -> ImageError {
    let words = "the decoder stopped on an internal error".to_owned();
    ImageError::Decoding(DecodingError::new(ImageFormatHint::Unknown, words))
}

pub(crate) fn y4m_frames(path: &Path, reader: impl BufRead + 'static, most: usize) -> Result<Frames> {
    let name = path.display().to_string();
    let y4m = Y4m::new(reader, most).map_err(|e| e.of(&name))?;
    Ok(Box::new(y4m.enumerate().map(move |(index, frame)| match frame {
        Ok(frame) => Ok(ClipFrame { name: format!("{name}, frame {index}"), frame, timing: None }),
        Err(e) => Err(Failure::damaged(&name, index, e)),
    })))
}
