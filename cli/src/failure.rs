//! Failures of the program: a message for standard error, and an exit code.

use std::fmt::Display;
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

/// Least number of frames of a clip: motion needs two.
pub(crate) const MIN_FRAMES: usize = 2;

/// A failure: what is wrong, and what to do about it.
#[derive(Debug)]
pub struct Failure {
    pub kind: Kind,
    pub reason: String,
    /// Set if whole frames came before the fault.
    pub damage: Option<Damage>,
}

/// A clip that is damaged or cut off after whole frames.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Damage {
    /// Number of whole frames before it.
    pub frames: usize,
    /// The cause, without the name of the file.
    pub reason: String,
}

/// The kind of a failure; the number is the exit code. `ending::CODES` explains them to users.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A fault of the machine or the program, which may be gone later: a file that is missing, cannot be opened or cannot be
    /// written, no `ffmpeg`.
    Other = 1,
    /// Illegal options, or options that do not fit existing files.
    Usage = 2,
    /// Data that cannot be used, now or later.
    Input = 3,
    /// More than fits into memory.
    Memory = 4,
}

pub type Result<T> = std::result::Result<T, Failure>;

impl Failure {
    /// A failure of the machine or the program.
    pub fn new(reason: impl Into<String>) -> Self {
        Self::of_kind(Kind::Other, reason.into())
    }

    /// A finished session without a result.
    pub fn missing_result() -> Self {
        Self::new("the session ended without a result: please report this")
    }

    /// Illegal options.
    pub fn usage(reason: impl Into<String>) -> Self {
        Self::of_kind(Kind::Usage, reason.into())
    }

    /// Bad input: `error`, preceded by its subject, such as a file.
    pub fn about(subject: impl Display, error: impl Display) -> Self {
        Self::of_kind(Kind::Input, format!("{subject}: {error}"))
    }

    /// Bad input.
    pub fn input(reason: impl Into<String>) -> Self {
        Self::of_kind(Kind::Input, reason.into())
    }

    /// Bad input after `frames` whole frames of `subject`; plain bad input if there are none.
    pub fn damaged(subject: impl Display, frames: usize, reason: impl Into<String>) -> Self {
        let reason = reason.into();
        let failure = Self::about(subject, &reason);
        let damage = (frames > 0).then_some(Damage { frames, reason });
        Self { damage, ..failure }
    }

    /// Returns true if enough whole frames came before the damage to make a clip.
    pub(crate) fn is_after_clip(&self) -> bool {
        self.damage.as_ref().is_some_and(|damage| damage.frames >= MIN_FRAMES)
    }

    fn of_kind(kind: Kind, reason: String) -> Self {
        Self { kind, reason, damage: None }
    }

    /// Prepends the subject of the failure, such as a file.
    pub fn with_subject(self, subject: impl Display) -> Self {
        Self { reason: format!("{subject}: {}", self.reason), ..self }
    }
}

impl From<tracecut::Error> for Failure {
    fn from(error: tracecut::Error) -> Self {
        let kind = match error {
            tracecut::Error::Param { .. } => Kind::Usage,
            tracecut::Error::FrameSize { .. } | tracecut::Error::TooLarge { .. } => Kind::Memory,
            tracecut::Error::State { .. } => Kind::Other,
            _ => Kind::Input,
        };
        Self::of_kind(kind, error.in_camel_case().to_string())
    }
}

pub fn read(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|e| cannot_read(path, &e))
}

pub fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read(path)?).map_err(|_| Failure::about(path.display(), "is not a text file"))
}

/// Writes a file, and removes it if it cannot be written completely.
pub fn write(path: &Path, bytes: impl AsRef<[u8]>) -> Result<()> {
    let mut file = File::create(path).map_err(|e| cannot_write(path, &e))?;
    file.write_all(bytes.as_ref()).map_err(|e| {
        if path.is_file() {
            let _ = std::fs::remove_file(path);
        }
        cannot_write(path, &e)
    })
}

pub fn create_folder(path: &Path) -> Result<()> {
    std::fs::create_dir_all(path).map_err(|e| cannot_write(path, &e))
}

pub fn cannot_read(path: &Path, error: &io::Error) -> Failure {
    Failure::new(format!("cannot be read: {error}")).with_subject(path.display())
}

pub fn cannot_write(path: &Path, error: &io::Error) -> Failure {
    let reason = format!("cannot be written: {error} (choose a folder that you may write to)");
    Failure::new(reason).with_subject(path.display())
}

/// Prints `line` on standard error, and ignores that it may be closed.
pub(crate) fn print_error(line: impl Display) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Prints `line`. Ends the program quietly if the reader has closed the pipe (`| head`), as other tools do.
pub fn print(line: impl Display) -> Result<()> {
    let mut out = io::stdout().lock();
    match writeln!(out, "{line}").and_then(|()| out.flush()) {
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => std::process::exit(0),
        Err(e) => Err(Failure::new(format!("cannot print: {e}"))),
        Ok(()) => Ok(()),
    }
}
