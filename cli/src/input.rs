//! Input clips: a folder of images, a `.bmf` list, an animated image, Y4M from a file, a pipe or standard input, or any video
//! with `ffmpeg`. Files are recognised by their content, not by their name. `docs/frames.md` defines the pictures of a file.
//!
//! Frames are read one at a time and once: no decoded clip is held in memory or in a file.

use crate::animation::{self, AnimationKind};
use crate::failure::{Failure, Result, cannot_read, read};
use crate::ffmpeg::Video;
use crate::images;
pub use crate::timeline::{ClipFrame, FrameTiming};
use crate::timeline::{Frames, Picture, StreamEnd, Timeline};
use crate::y4m::Y4m;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use tracecut::Params;
use tracecut::image::{Frame, MAX_PIXELS};

/// The kinds of input, for `--help`.
pub(crate) const KINDS: &str = "Folder of PNG, JPEG or PPM images in name order, .bmf list, animated GIF, PNG or WebP, Y4M, \
    other video (with ffmpeg installed), or - for Y4M on standard input";

/// An input clip.
#[derive(Debug)]
pub struct Input {
    kind: InputKind,
    max_frames: usize,
    /// Largest number of pixels of a frame.
    max_pixels: usize,
}

#[derive(Debug)]
enum InputKind {
    Images(Vec<PathBuf>),
    Animation(AnimationKind, PathBuf),
    /// A file, or a pipe with a name.
    Y4m(PathBuf),
    Video(Video),
    Stdin,
}

impl Input {
    /// Detects the kind of `path`; `-` is standard input.
    pub fn open(path: &Path, frames: Option<u32>) -> Result<Self> {
        let max_frames = frames.map_or(usize::MAX, |n| n as usize);
        Ok(Self { kind: InputKind::detect(path, max_frames)?, max_frames, max_pixels: MAX_PIXELS })
    }

    /// Sets the limits of a run.
    pub(crate) fn with_limits(self, params: &Params) -> Self {
        Self { max_pixels: params.clip.max_pixels as usize, ..self }
    }

    /// Returns the number of frames, if known before reading them.
    pub fn num_frames(&self) -> Option<usize> {
        let count = match &self.kind {
            InputKind::Images(paths) => paths.len(),
            InputKind::Video(video) => video.num_pictures(),
            _ => return None,
        };
        Some(count.min(self.max_frames))
    }

    /// Returns the file names of the frames, if each has a file of its own.
    pub(crate) fn names(&self) -> Option<Vec<String>> {
        let InputKind::Images(paths) = &self.kind else { return None };
        let name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Some(paths.iter().take(self.max_frames).map(name).collect())
    }

    /// Returns the frames from the first on; standard input and pipes can be read only once. A failure with
    /// [`damage`](Failure::damage) follows the whole frames before it and is the last item.
    pub fn frames(&self) -> Result<impl Iterator<Item = Result<ClipFrame>> + use<>> {
        let max_pixels = self.max_pixels;
        let frames: Frames = match &self.kind {
            InputKind::Images(paths) => Box::new(ImageFiles { paths: paths.clone().into_iter(), max_pixels }),
            InputKind::Animation(kind, path) => {
                animation::frames(*kind, &path.display().to_string(), open(path)?, max_pixels)?
            }
            InputKind::Y4m(path) => y4m_frames(path, open(path)?, max_pixels)?,
            InputKind::Video(video) => video.frames(max_pixels)?,
            InputKind::Stdin => y4m_frames(
                Path::new("standard input"),
                BufReader::with_capacity(1 << 16, std::io::stdin()),
                max_pixels,
            )?,
        };
        Ok(frames.take(self.max_frames))
    }
}

/// Decodes files one by one; skipped files are not decoded.
struct ImageFiles {
    paths: std::vec::IntoIter<PathBuf>,
    max_pixels: usize,
}

impl ImageFiles {
    fn read_frame(&self, path: &Path) -> Result<ClipFrame> {
        let frame = decode_within(path, self.max_pixels)?;
        Ok(ClipFrame { name: path.display().to_string(), frame, timing: None })
    }
}

impl Iterator for ImageFiles {
    type Item = Result<ClipFrame>;

    fn next(&mut self) -> Option<Self::Item> {
        self.paths.next().map(|path| self.read_frame(&path))
    }

    fn nth(&mut self, n: usize) -> Option<Self::Item> {
        self.paths.nth(n).map(|path| self.read_frame(&path))
    }
}

impl InputKind {
    fn detect(path: &Path, max_frames: usize) -> Result<Self> {
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
            // Bytes read to detect the kind would be lost.
            return Ok(Self::Y4m(path.to_owned()));
        }
        let mut start = Vec::new();
        open(path)?.take(START_BYTES).read_to_end(&mut start).map_err(|e| cannot_read(path, &e))?;
        let path = path.to_owned();
        Ok(match start.as_slice() {
            [] => return Err(Failure::about(path.display(), "is empty")),
            [b'G', b'I', b'F', b'8', ..] => Self::Animation(AnimationKind::Gif, path),
            [0x89, b'P', b'N', b'G', ..] => Self::Animation(AnimationKind::Png, path),
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P'] => Self::Animation(AnimationKind::WebP, path),
            [0xff, 0xd8, 0xff, ..] => return Err(Failure::about(path.display(), animation::STILL)),
            start if start.starts_with(b"YUV4MPEG2") => Self::Y4m(path),
            start => Self::Video(Video::open(&path, start, max_frames)?),
        })
    }
}

/// Number of bytes that identify a file.
const START_BYTES: u64 = 12;

fn open(path: &Path) -> Result<BufReader<File>> {
    File::open(path).map(BufReader::new).map_err(|e| cannot_read(path, &e))
}

/// Decodes an image file.
pub fn decode(path: &Path) -> Result<Frame> {
    decode_within(path, MAX_PIXELS)
}

/// Decodes an image file of at most `max_pixels` pixels.
pub(crate) fn decode_within(path: &Path, max_pixels: usize) -> Result<Frame> {
    Frame::decode_within(&read(path)?, max_pixels).map_err(|e| Failure::from(e).with_subject(path.display()))
}

pub(crate) fn y4m_frames(path: &Path, reader: impl BufRead + 'static, max_pixels: usize) -> Result<Frames> {
    let name = path.display().to_string();
    let y4m = Y4m::new(reader, max_pixels).map_err(|e| e.with_subject(&name))?;
    let duration = y4m.frame_duration();
    let pictures = y4m.enumerate().map(move |(index, frame)| match frame {
        Ok(frame) => Ok(Picture { frame, time: Some(index as f64 * duration), duration: Some(duration) }),
        Err(e) => Err(StreamEnd::Damage(e)),
    });
    Ok(Box::new(Timeline::new(name, pictures)))
}
