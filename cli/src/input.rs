//! Where frames come from: a folder of images, a `.bmf` list, an animated image, Y4M from a file, a pipe or standard
//! input, or any video by `ffmpeg`. What a file is, its content says, whatever its name. `docs/frames.md` tells which
//! pictures a file gives.
//!
//! Frames are read one at a time and once: no decoded clip is held, and none is kept in a file.

use crate::animation;
use crate::clip_frame::Frames;
pub use crate::clip_frame::{ClipFrame, FrameTiming};
use crate::failure::{Failure, Result, cannot_read, read};
use crate::ffmpeg::Video;
use crate::images;
use crate::timeline::{Picture, Stop, Timeline};
use crate::y4m::Y4m;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use tracecut::Params;
use tracecut::image::{Frame, MAX_PIXELS};

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
    Animation(animation::Kind, PathBuf),
    /// A file, or a pipe with a name.
    Y4m(PathBuf),
    Video(Video),
    Stdin,
}

impl Input {
    /// Finds out what `path` is; `-` is standard input.
    pub fn open(path: &Path, frames: Option<u32>) -> Result<Self> {
        let max_frames = frames.map_or(usize::MAX, |n| n as usize);
        Ok(Self { kind: Kind::of(path, max_frames)?, max_frames, max_pixels: MAX_PIXELS })
    }

    /// With the limits of a run.
    pub(crate) fn within(self, params: &Params) -> Self {
        Self { max_pixels: params.clip.max_pixels as usize, ..self }
    }

    /// Number of frames, where known before reading them.
    pub fn num_frames(&self) -> Option<usize> {
        let count = match &self.kind {
            Kind::Images(paths) => paths.len(),
            Kind::Video(video) => video.num_pictures(),
            _ => return None,
        };
        Some(count.min(self.max_frames))
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
            Kind::Animation(kind, path) => animation::frames(*kind, &path.display().to_string(), open(path)?, most)?,
            Kind::Y4m(path) => y4m_frames(path, open(path)?, most)?,
            Kind::Video(video) => video.frames(most)?,
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
    fn of(path: &Path, max_frames: usize) -> Result<Self> {
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
        open(path)?.take(START_BYTES).read_to_end(&mut start).map_err(|e| cannot_read(path, &e))?;
        let path = path.to_owned();
        Ok(match start.as_slice() {
            [] => return Err(Failure::about(path.display(), "is empty")),
            [b'G', b'I', b'F', b'8', ..] => Self::Animation(animation::Kind::Gif, path),
            [0x89, b'P', b'N', b'G', ..] => Self::Animation(animation::Kind::Png, path),
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P'] => {
                Self::Animation(animation::Kind::WebP, path)
            }
            [0xff, 0xd8, 0xff, ..] => return Err(Failure::about(path.display(), animation::STILL)),
            start if start.starts_with(b"YUV4MPEG2") => Self::Y4m(path),
            start => Self::Video(Video::open(&path, start, max_frames)?),
        })
    }
}

/// Bytes that tell what a file is.
const START_BYTES: u64 = 12;

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

pub(crate) fn y4m_frames(path: &Path, reader: impl BufRead + 'static, most: usize) -> Result<Frames> {
    let name = path.display().to_string();
    let y4m = Y4m::new(reader, most).map_err(|e| e.of(&name))?;
    let duration = y4m.frame_duration();
    let pictures = y4m.enumerate().map(move |(index, frame)| match frame {
        Ok(frame) => Ok(Picture { frame, time: Some(index as f64 * duration), duration: Some(duration) }),
        Err(e) => Err(Stop::Damage(e)),
    });
    Ok(Box::new(Timeline::new(name, pictures)))
}
