//! Videos of any kind, through an installed `ffmpeg` (5.1 or later).
//!
//! The contract is in `docs/frames.md`: each picture of the file once, in display order, with its own time; of the default
//! track; upright, with square pixels, at the size of the first picture; in the colour space of the file; and no damaged
//! picture. The package (`npm/node`) runs the same commands.
//!
//! `ffmpeg` runs twice. The first run lists the packets of all video tracks without decoding them, which tells the
//! track, the number of pictures, the duration of the last one and the times that pictures must have. The second decodes
//! that track: pixels come on standard output, the time and size of each picture on standard error. A picture is given
//! when both have come, and the next ones were looked at by the [`FaultFinder`].

mod faults;
mod listing;
mod log;

use crate::failure::{Failure, Result};
use crate::timeline::{Frames, Picture, StreamEnd, Timeline, check};
use faults::FaultFinder;
use listing::Track;
use log::{LogReader, Message, ShownPicture};
use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use tracecut::image::Frame;

/// Before the input, in both runs: each message with its level; times as they are in the file, without an offset.
const GENERAL: &[&str] = &["-hide_banner", "-nostdin", "-nostats", "-loglevel", "level+info", "-copyts"];

/// The first run: a line for each packet of each video track that is no attached picture, key pictures or not.
const LIST: &[&str] = &["-map", "0:V", "-c", "copy", "-copyinkf", "-f", "framecrc"];

/// Before the input, in the second run: a message for each packet that is read and each picture that is decoded; one
/// thread, as with several ffmpeg 5.1 forgets to call some pictures faulty; one chain of filters for all pictures, so that
/// later ones are scaled to the size of the first.
const DECODE: &[&str] = &["-debug_ts", "-threads", "1", "-reinit_filter", "0"];

/// After the input and the track, in the second run: each picture once, as bytes of RGB.
const WRITE: &[&str] = &["-fps_mode", "passthrough", "-vf", FILTERS, "-f", "rawvideo"];

/// Square pixels, never fewer of them; the same bytes of RGB from every version; a message for each picture. At last,
/// times that increase, as what writes the pictures wants them.
const FILTERS: &str = "\
scale=w='if(gt(sar,1),round(iw*sar),iw)':h='if(gt(sar,1),ih,round(ih/sar))':\
flags=bicubic+accurate_rnd+full_chroma_int+bitexact,\
setsar=1,format=rgb24,showinfo=checksum=0,settb=1/25,setpts=N";

/// Y4M to a pipe, in the colours that Y4M has by its nature (BT.601, limited range), for users to type.
const PIPE: &str = "-map 0:V:0 -fps_mode passthrough -vf scale=out_color_matrix=bt601:out_range=limited \
-pix_fmt yuv444p -f yuv4mpegpipe -";

/// Packets that are listed beyond the pictures wanted, as packets are not in the order of display.
const EXTRA_PACKETS: usize = 32;

/// Demuxers of ffmpeg that make pictures of text.
const TEXT_DEMUXERS: [&str; 5] = ["tty", "bin", "xbin", "adf", "idf"];

/// Returns the command that reads a video with an ffmpeg elsewhere.
pub(crate) fn pipe(video: &Path) -> String {
    format!("ffmpeg -i {} {PIPE} | tracecut segment - --out DIR", video.display())
}

/// A video file and the track of it that is read.
#[derive(Debug)]
pub(crate) struct Video {
    path: PathBuf,
    demuxer: String,
    track: Track,
}

impl Video {
    /// Opens a file for at most `max_frames` pictures; `start` has its first bytes.
    pub(crate) fn open(path: &Path, start: &[u8], max_frames: usize) -> Result<Self> {
        let max_packets = max_frames.saturating_add(EXTRA_PACKETS).to_string();
        let bound: &[&str] = if max_frames == usize::MAX { &[] } else { &["-frames:v", &max_packets] };
        let mut process = Process::start(path, &[], &[LIST, bound].concat())?;
        let errors = process.errors()?;
        let opening = thread::spawn(move || Opening::read(BufReader::new(errors)));
        let tracks = listing::parse_tracks(BufReader::new(process.output()?));
        let tracks =
            tracks.map_err(|e| Failure::new(format!("ffmpeg cannot be read: {e}")).with_subject(path.display()))?;
        let opening = opening.join().unwrap_or_default();
        process.finish().map_err(|e| e.with_subject(path.display()))?;
        let Some(demuxer) = opening.demuxer.filter(|name| !TEXT_DEMUXERS.contains(&name.as_str())) else {
            return Err(Failure::about(path.display(), describe_unreadable(start)));
        };
        let reason = if opening.defaults.is_empty() {
            "has no video track"
        } else if tracks.is_empty() {
            "has a video track of a kind that this ffmpeg cannot read"
        } else {
            "holds no picture (it may be cut off)"
        };
        let track = listing::choose_track(tracks, &opening.defaults);
        let track = track.ok_or_else(|| Failure::about(path.display(), reason))?;
        Ok(Self { path: path.to_owned(), demuxer, track })
    }

    /// Returns the number of pictures, up to the number requested.
    pub(crate) fn num_pictures(&self) -> usize {
        self.track.num_pictures()
    }

    /// Returns the pictures, each of at most `max_pixels` pixels.
    pub(crate) fn frames(&self, max_pixels: usize) -> Result<Frames> {
        let map = format!("0:V:{}", self.track.position);
        let mut process = Process::start(&self.path, DECODE, &[&["-map", &map], WRITE].concat())?;
        let (pixels, errors) = (process.output()?, process.errors()?);
        let (sender, messages) = channel();
        let mut log = LogReader::new(&self.demuxer);
        // Reads in a thread of its own, so that ffmpeg never blocks on its messages.
        thread::spawn(move || {
            for line in lines(BufReader::new(errors)) {
                // The receiver may be gone if not all pictures were requested.
                log.read_line(&line).into_iter().for_each(|message| _ = sender.send(message));
            }
        });
        let name = self.path.display().to_string();
        let pictures = Pictures {
            process,
            pixels,
            messages,
            faults: FaultFinder::new(&self.track, &self.demuxer),
            track: self.track.clone(),
            name: name.clone(),
            max_pixels,
            num_given: 0,
            waits_for_key: false,
            has_no_decoder: false,
            is_old: false,
        };
        Ok(Box::new(Timeline::new(name, pictures)))
    }
}

/// Describes a file that ffmpeg cannot open.
fn describe_unreadable(start: &[u8]) -> &'static str {
    match (start.get(4..8), start.get(8..12)) {
        (Some(b"ftyp"), Some(b"avif" | b"avis")) => "is an AVIF, which this ffmpeg cannot read, or is cut off",
        (Some(b"ftyp"), _) => "is cut off: the index, which MP4 files may have at their end, is missing",
        _ => "is not a video, or one that this ffmpeg cannot read",
    }
}

/// Information that `ffmpeg` logs when it opens a file.
#[derive(Debug, Default)]
struct Opening {
    /// The name of the demuxer; `None` if ffmpeg cannot open the file.
    demuxer: Option<String>,
    /// For each video track that is no attached picture: whether it is a default one.
    defaults: Vec<bool>,
}

impl Opening {
    fn read(errors: impl BufRead) -> Self {
        let (mut opening, mut is_input) = (Self::default(), false);
        for line in lines(errors) {
            let text = line.trim_start_matches("[info]").trim_start();
            if let Some(name) = text.strip_prefix("Input #0, ").and_then(|rest| rest.split(", from '").next()) {
                (opening.demuxer, is_input) = (Some(name.to_owned()), true);
            }
            is_input &= !text.starts_with("Output #0");
            let is_video = text.starts_with("Stream #0:") && text.contains(": Video: ");
            if is_input && is_video && !text.contains("(attached pic)") {
                opening.defaults.push(text.contains("(default)"));
            }
        }
        opening
    }
}

/// Returns the lines of a stream until it ends or fails.
fn lines(stream: impl BufRead) -> impl Iterator<Item = String> {
    stream.split(b'\n').map_while(io::Result::ok).map(|line| String::from_utf8_lossy(&line).into_owned())
}

/// A running `ffmpeg` process, which is killed when dropped.
#[derive(Debug)]
struct Process(Child);

impl Process {
    /// Starts it on a file, with these arguments before and after that.
    fn start(path: &Path, before: &[&str], after: &[&str]) -> Result<Self> {
        // With its protocol named, no file name means anything else.
        let mut file = OsString::from("file:");
        file.push(path);
        let mut command = Command::new("ffmpeg");
        command.args(GENERAL).args(before).arg("-i").arg(file).args(after).arg("-");
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command.env("AV_LOG_FORCE_NOCOLOR", "1").env_remove("AV_LOG_FORCE_COLOR");
        command.spawn().map(Self).map_err(|e| cannot_start(path, &e))
    }

    fn output(&mut self) -> Result<ChildStdout> {
        self.0.stdout.take().ok_or_else(|| Failure::new("ffmpeg was started without its output"))
    }

    fn errors(&mut self) -> Result<ChildStderr> {
        self.0.stderr.take().ok_or_else(|| Failure::new("ffmpeg was started without its output"))
    }

    /// Waits for its end and returns true if it succeeded. Fails if it did not end by itself, which says nothing about the
    /// video: it cannot be loaded (a shell's codes 126 and 127), or a signal ended it, as where memory runs out.
    fn finish(&mut self) -> Result<bool> {
        let status = self.0.wait().map_err(|e| Failure::new(format!("ffmpeg cannot be waited for: {e}")))?;
        match status.code() {
            None => Err(Failure::new("ffmpeg was killed while it read the file")),
            Some(code @ (126 | 127)) => Err(Failure::new(format!("ffmpeg cannot run (exit code {code})"))),
            Some(code) => Ok(code == 0),
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn cannot_start(video: &Path, error: &io::Error) -> Failure {
    let reason = if error.kind() == io::ErrorKind::NotFound {
        "is not a folder of images, a .bmf list, an animated image or a Y4M file, and there is no ffmpeg on the PATH to read it"
    } else {
        return Failure::new(format!("ffmpeg cannot be started: {error}")).with_subject(video.display());
    };
    let pipe = pipe(video);
    Failure::new(format!("{reason} (install it, or run on a machine that has it: {pipe})"))
        .with_subject(video.display())
}

/// The pictures of a track until the first damaged one.
struct Pictures {
    process: Process,
    pixels: ChildStdout,
    messages: Receiver<Message>,
    faults: FaultFinder,
    track: Track,
    name: String,
    max_pixels: usize,
    num_given: usize,
    /// Set where the first picture is faulty or missing: those after it may be made of it, up to the next key picture.
    waits_for_key: bool,
    has_no_decoder: bool,
    is_old: bool,
}

impl Iterator for Pictures {
    type Item = std::result::Result<Picture, StreamEnd>;

    fn next(&mut self) -> Option<Self::Item> {
        self.read_picture().transpose()
    }
}

impl Pictures {
    fn read_picture(&mut self) -> std::result::Result<Option<Picture>, StreamEnd> {
        while let Ok(message) = self.messages.recv() {
            self.faults.take(&message);
            match message {
                Message::DecodingFailed => self.waits_for_key |= self.num_given == 0,
                Message::NoDecoder => self.has_no_decoder = true,
                Message::UnknownOption => self.is_old = true,
                Message::Shown(shown) => {
                    let Some(frame) = self.read_pixels(&shown)? else { break };
                    if self.faults.is_whole(&shown) && (shown.is_key || !self.waits_for_key) {
                        return Ok(Some(self.give(&shown, frame)));
                    }
                    if self.num_given > 0 {
                        return Err(damage());
                    }
                    self.waits_for_key = true;
                }
                _ => {}
            }
        }
        self.finish().map(|()| None)
    }

    /// Reads a picture of standard output; `None` where that ends before it is whole.
    fn read_pixels(&mut self, shown: &ShownPicture) -> std::result::Result<Option<Frame>, StreamEnd> {
        let &ShownPicture { width, height, .. } = shown;
        let failure = |e: tracecut::Error| StreamEnd::Failure(Failure::from(e).with_subject(&self.name));
        check(width, height, self.max_pixels).map_err(failure)?;
        let length = 3 * width * height;
        let mut rgb = Vec::with_capacity(length);
        let read = self.pixels.by_ref().take(length as u64).read_to_end(&mut rgb);
        if read.is_err() || rgb.len() < length {
            return Ok(None);
        }
        Frame::from_rgb(rgb, width, height).map(Some).map_err(failure)
    }

    fn give(&mut self, shown: &ShownPicture, frame: Frame) -> Picture {
        self.faults.give(shown);
        self.waits_for_key = false;
        self.num_given += 1;
        Picture { frame, time: shown.time, duration: shown.time.and_then(|time| self.faults.duration_at(time)) }
    }

    /// Looks at how it ended.
    fn finish(&mut self) -> std::result::Result<(), StreamEnd> {
        let has_succeeded = self.process.finish().map_err(|e| StreamEnd::Failure(e.with_subject(&self.name)))?;
        if self.num_given == 0 {
            return Err(StreamEnd::Failure(self.describe_no_picture()));
        }
        let is_short = !has_succeeded && self.num_given < self.track.num_pictures();
        if is_short || !self.faults.is_whole_at_end() { Err(damage()) } else { Ok(()) }
    }

    fn describe_no_picture(&self) -> Failure {
        if self.is_old {
            return Failure::new("this ffmpeg is too old (expected 5.1 or later)").with_subject(&self.name);
        }
        let codec = &self.track.codec;
        let reason = if self.has_no_decoder {
            format!("this ffmpeg has no decoder for its video ({codec})")
        } else {
            format!(
                "none of its pictures can be decoded: they are damaged, or this ffmpeg cannot read their kind ({codec})"
            )
        };
        Failure::about(&self.name, reason)
    }
}

fn damage() -> StreamEnd {
    StreamEnd::Damage("is cut off or damaged".to_owned())
}
