//! What ends the program: a sentence for standard error.

use std::fmt::Display;
use std::io::{self, Write};
use std::path::Path;

/// Why the program cannot go on, in words, with what to do.
#[derive(Debug)]
pub(crate) struct Failure(pub(crate) String);

pub(crate) type Result<T> = std::result::Result<T, Failure>;

impl Failure {
    /// `error` with the file or thing it is about before it.
    pub(crate) fn about(subject: impl Display, error: impl Display) -> Self {
        Self(format!("{subject}: {error}"))
    }
}

impl From<tracecut::Error> for Failure {
    fn from(error: tracecut::Error) -> Self {
        Self(error.to_string())
    }
}

pub(crate) fn read(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|e| Failure::about(path.display(), format_args!("cannot be read: {e}")))
}

pub(crate) fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read(path)?).map_err(|_| Failure::about(path.display(), "is not a text file"))
}

pub(crate) fn write(path: &Path, bytes: impl AsRef<[u8]>) -> Result<()> {
    std::fs::write(path, bytes).map_err(|e| cannot_write(path, &e))
}

pub(crate) fn create_folder(path: &Path) -> Result<()> {
    std::fs::create_dir_all(path).map_err(|e| cannot_write(path, &e))
}

pub(crate) fn cannot_write(path: &Path, error: &io::Error) -> Failure {
    Failure::about(path.display(), format_args!("cannot be written: {error} (name a folder that you may write to)"))
}

/// Prints `line`. A reader that has gone away (`| head`) ends the program quietly, as other tools do.
pub(crate) fn print(line: impl Display) -> Result<()> {
    let mut out = io::stdout().lock();
    match writeln!(out, "{line}").and_then(|()| out.flush()) {
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => std::process::exit(0),
        Err(e) => Err(Failure(format!("cannot print: {e}"))),
        Ok(()) => Ok(()),
    }
}
