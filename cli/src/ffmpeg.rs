//! Videos of any kind, through an installed `ffmpeg`.

use crate::failure::{Failure, Result};
use crate::input::{Frames, y4m_frames};
use std::ffi::OsString;
use std::io::{self, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::thread::JoinHandle;

/// What `ffmpeg` is told: the first video stream, decoded, to standard output.
const FORM: [&str; 6] = ["-map", "0:v:0", "-pix_fmt", "yuv420p", "-f", "yuv4mpegpipe"];

/// The same as one types it, for a video and a folder of results.
pub(crate) fn pipe(video: &Path) -> String {
    format!("ffmpeg -i {} {} - | tracecut segment - --out DIR", video.display(), FORM.join(" "))
}

/// The frames of a video.
pub(crate) fn frames(video: &Path, most: usize) -> Result<Frames> {
    // With its protocol named, no file name means anything else.
    let mut file = OsString::from("file:");
    file.push(video);
    let mut command = Command::new("ffmpeg");
    command.args(["-nostdin", "-v", "error", "-i"]).arg(file).args(FORM).arg("-");
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|e| cannot_start(video, &e))?;
    let (Some(frames), Some(errors)) = (child.stdout.take(), child.stderr.take()) else {
        return Err(Failure::new("ffmpeg was started without its output"));
    };
    let errors = std::thread::spawn(move || io::read_to_string(errors).unwrap_or_default());
    let decoder = Decoder { child, frames, errors: Some(errors) };
    y4m_frames(video, BufReader::with_capacity(1 << 16, decoder), most)
}

fn cannot_start(video: &Path, error: &io::Error) -> Failure {
    let reason = if error.kind() == io::ErrorKind::NotFound {
        "is not a folder of images, a .bmf list, a GIF or a Y4M file, and there is no ffmpeg on the PATH to read it"
    } else {
        return Failure::new(format!("ffmpeg cannot be started: {error}")).of(video.display());
    };
    let pipe = pipe(video);
    Failure::new(format!("{reason} (install it, or where there is one type: {pipe})")).of(video.display())
}

/// What `ffmpeg` writes; that it failed is an error at the end. It is ended when dropped.
struct Decoder {
    child: Child,
    frames: ChildStdout,
    errors: Option<JoinHandle<String>>,
}

impl Read for Decoder {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = self.frames.read(buffer)?;
        if length > 0 || buffer.is_empty() {
            return Ok(length);
        }
        let Some(errors) = self.errors.take() else { return Ok(0) };
        let status = self.child.wait()?;
        let said = errors.join().unwrap_or_default();
        if status.success() {
            return Ok(0);
        }
        let last = said.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or("it said nothing");
        Err(io::Error::other(format!("ffmpeg cannot read it: {}", last.trim())))
    }
}

impl Drop for Decoder {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
