//! What ends the program: a sentence for standard error, and a code.

use std::fmt::Display;
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

/// Fewest frames of a clip: motion needs two.
pub(crate) const MIN_FRAMES: usize = 2;

/// Why the program cannot go on, in words, with what to do.
#[derive(Debug)]
pub struct Failure {
    pub kind: Kind,
    pub reason: String,
    /// Set where whole frames came before the fault.
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

/// Whose fault it is; the number is the exit code. `ending::CODES` tells users.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A fault of the machine or the program, which may be gone later: a file that is missing, cannot be opened or cannot be
    /// written, no `ffmpeg`.
    Other = 1,
    /// Options that mean nothing, or that do not fit what lies there.
    Usage = 2,
    /// Data that cannot be used, now or later.
    Input = 3,
    /// More than fits into memory.
    Memory = 4,
}

pub type Result<T> = std::result::Result<T, Failure>;

impl Failure {
    /// A fault that is nobody's input.
    pub fn new(reason: impl Into<String>) -> Self {
        Self::of_kind(Kind::Other, reason.into())
    }

    /// A session that is done and lacks a result.
    pub fn lost() -> Self {
        Self::new("the session ended without a result: please report this")
    }

    /// Options that cannot be followed.
    pub fn usage(reason: impl Into<String>) -> Self {
        Self::of_kind(Kind::Usage, reason.into())
    }

    /// Bad input: `error` with the file or thing it is about before it.
    pub fn about(subject: impl Display, error: impl Display) -> Self {
        Self::of_kind(Kind::Input, format!("{subject}: {error}"))
    }

    /// Bad input, in words.
    pub fn input(reason: impl Into<String>) -> Self {
        Self::of_kind(Kind::Input, reason.into())
    }

    /// Bad input after `frames` whole frames of `subject`; plain bad input where there are none.
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

    /// The same failure with the file or thing it is about before it.
    pub fn of(self, subject: impl Display) -> Self {
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
        Self::of_kind(kind, error.to_string())
    }
}

pub fn read(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|e| cannot_read(path, &e))
}

pub fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read(path)?).map_err(|_| Failure::about(path.display(), "is not a text file"))
}

/// Writes a file; where there is not room for all of it there is none.
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
    Failure::new(format!("cannot be read: {error}")).of(path.display())
}

pub fn cannot_write(path: &Path, error: &io::Error) -> Failure {
    let reason = format!("cannot be written: {error} (name a folder that you may write to)");
    Failure::new(reason).of(path.display())
}

/// Tells `line` on standard error. Who does not listen any more does not end the program.
pub(crate) fn tell(line: impl Display) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Prints `line`. A reader that has gone away (`| head`) ends the program quietly, as other tools do.
pub fn print(line: impl Display) -> Result<()> {
    let mut out = io::stdout().lock();
    match writeln!(out, "{line}").and_then(|()| out.flush()) {
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => std::process::exit(0),
        Err(e) => Err(Failure::new(format!("cannot print: {e}"))),
        Ok(()) => Ok(()),
    }
}
