//! Where frames come from: a folder of images, a `.bmf` list, an animated GIF, or Y4M from a file or standard input.
//!
//! Frames are read one at a time. They are read three times, once to find the motion, once for the masks and once to draw
//! over them, so that no decoded clip has to be held; what comes from standard input is kept in a file until then.

use crate::failure::{Failure, Result, cannot_write, read};
use crate::images;
use crate::y4m::Y4m;
use image::AnimationDecoder;
use image::codecs::gif::GifDecoder;
use std::cell::Cell;
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use tracecut::image::Frame;

/// A clip that can be read from its start more than once.
#[derive(Debug)]
pub(crate) struct Input {
    kind: Kind,
    max_frames: usize,
}

#[derive(Debug)]
enum Kind {
    Images(Vec<PathBuf>),
    Gif(PathBuf),
    Y4m(PathBuf),
    Stdin(Spool),
}

/// A frame and what to call it in an error.
pub(crate) type NamedFrame = (String, Frame);
type Frames = Box<dyn Iterator<Item = Result<NamedFrame>>>;

impl Input {
    /// Finds out what `path` is. `spool` is the file that keeps what comes from standard input (`-`).
    pub(crate) fn open(path: &Path, frames: Option<u32>, spool: &Path) -> Result<Self> {
        let max_frames = frames.map_or(usize::MAX, |n| n as usize);
        Ok(Self { kind: Kind::of(path, spool)?, max_frames })
    }

    /// Number of frames, where known before reading them.
    pub(crate) fn num_frames(&self) -> Option<usize> {
        match &self.kind {
            Kind::Images(paths) => Some(paths.len().min(self.max_frames)),
            _ => None,
        }
    }

    /// The frames from the first on.
    pub(crate) fn frames(&self) -> Result<impl Iterator<Item = Result<NamedFrame>> + use<>> {
        let all: Frames = match &self.kind {
            Kind::Images(paths) => Box::new(paths.clone().into_iter().map(|path| decode(&path))),
            Kind::Gif(path) => gif_frames(path)?,
            Kind::Y4m(path) => y4m_frames(path, open(path)?)?,
            Kind::Stdin(spool) => spool.frames()?,
        };
        Ok(all.take(self.max_frames))
    }
}

impl Kind {
    fn of(path: &Path, spool: &Path) -> Result<Self> {
        if path == Path::new("-") {
            return Ok(Self::Stdin(Spool { path: spool.to_owned(), filled: Cell::new(false) }));
        }
        if path.is_dir() {
            return images::in_folder(path).map(Self::Images);
        }
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("bmf")) {
            return images::in_list(path).map(Self::Images);
        }
        if path.exists() && !path.is_file() {
            let reason = "is not a file that can be read twice (pipe it in: COMMAND | tracecut segment - --out DIR)";
            return Err(Failure::about(path.display(), reason));
        }
        let mut start = Vec::new();
        open(path)?.take(9).read_to_end(&mut start).map_err(|e| Failure::about(path.display(), e))?;
        if start.starts_with(b"GIF8") {
            Ok(Self::Gif(path.to_owned()))
        } else if start == b"YUV4MPEG2" {
            Ok(Self::Y4m(path.to_owned()))
        } else {
            Err(Failure::about(
                path.display(),
                "is not a folder of images, a .bmf list, a GIF or a Y4M file \
                 (other videos: ffmpeg -i VIDEO -pix_fmt yuv420p -f yuv4mpegpipe - | tracecut segment - --out DIR)",
            ))
        }
    }
}

fn open(path: &Path) -> Result<BufReader<File>> {
    let file = File::open(path).map_err(|e| Failure::about(path.display(), format_args!("cannot be read: {e}")))?;
    Ok(BufReader::new(file))
}

/// Decodes an image file.
pub(crate) fn decode(path: &Path) -> Result<NamedFrame> {
    let frame = Frame::decode(&read(path)?).map_err(|e| Failure::about(path.display(), e))?;
    Ok((path.display().to_string(), frame))
}

fn gif_frames(path: &Path) -> Result<Frames> {
    let name = path.display().to_string();
    let broken = |e: &dyn std::fmt::Display| Failure::about(path.display(), format_args!("is not a whole GIF: {e}"));
    let frames = GifDecoder::new(open(path)?).map_err(|e| broken(&e))?.into_frames();
    Ok(Box::new(frames.enumerate().map(move |(index, frame)| {
        let about = format!("{name}, frame {index}");
        let image = match frame {
            Ok(frame) => frame.into_buffer(),
            Err(e) => {
                return Err(Failure::about(&about, format_args!("cannot be decoded: {e}{}", advice(index))));
            }
        };
        let (width, height) = (image.width() as usize, image.height() as usize);
        let frame = Frame::from_rgba(image.as_raw(), width, height).map_err(|e| Failure::about(&about, e))?;
        Ok((about, frame))
    })))
}

/// What to do about a clip whose first `whole` frames only can be read.
pub(crate) fn advice(whole: usize) -> String {
    if whole < 2 { String::new() } else { format!(" (--frames {whole} takes the whole ones before it)") }
}

fn y4m_frames(path: &Path, reader: impl BufRead + 'static) -> Result<Frames> {
    let name = path.display().to_string();
    let y4m = Y4m::new(reader).map_err(|e| Failure::about(&name, e))?;
    Ok(Box::new(y4m.enumerate().map(move |(index, frame)| match frame {
        Ok(frame) => Ok((format!("{name}, frame {index}"), frame)),
        Err(e) => Err(Failure::about(&name, e)),
    })))
}

/// Keeps the bytes of standard input while they are read for the first time; removes the file when dropped.
#[derive(Debug)]
struct Spool {
    path: PathBuf,
    filled: Cell<bool>,
}

impl Spool {
    fn frames(&self) -> Result<Frames> {
        let input = Path::new("standard input");
        if self.filled.replace(true) {
            return y4m_frames(input, open(&self.path)?);
        }
        let copy = File::create(&self.path).map_err(|e| cannot_write(&self.path, &e))?;
        let tee = Tee { from: std::io::stdin(), copy: BufWriter::new(copy) };
        y4m_frames(input, BufReader::with_capacity(1 << 16, tee))
    }
}

impl Drop for Spool {
    fn drop(&mut self) {
        // Nothing to do about a file that cannot be removed, or that never came to be.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Reads and copies what it read.
struct Tee<R, W> {
    from: R,
    copy: W,
}

impl<R: Read, W: Write> Read for Tee<R, W> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let length = self.from.read(buffer)?;
        self.copy.write_all(&buffer[..length])?;
        Ok(length)
    }
}
