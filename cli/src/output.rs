//! A folder of results that is complete or absent: it is written under a temporary name beside the target, and renamed at the end.

use crate::failure::{Failure, Result, cannot_write, create_folder};
use fs4::{FileExt, TryLockError};
use std::ffi::OsStr;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// Folder of working files until the end: the checkpoint, and parts of the report.
const WORK: &str = ".tracecut";

/// Treatment of existing files.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Existing {
    pub(crate) overwrite: bool,
    pub(crate) resume: bool,
}

/// A folder of results that is being written.
#[derive(Debug, Clone)]
pub(crate) struct OutputFolder {
    target: PathBuf,
    partial: PathBuf,
    /// Held while this run owns the folder; the system releases it however the run ends.
    lock: Arc<OnceLock<Option<File>>>,
}

impl OutputFolder {
    /// Returns the folder for results in `target`.
    pub(crate) fn new(target: &Path) -> Result<Self> {
        let name = target.file_name().ok_or_else(|| refused(target, "is not the name of a folder"))?;
        let mut partial = name.to_owned();
        partial.push(".partial");
        Ok(Self { target: target.to_owned(), partial: target.with_file_name(partial), lock: Arc::default() })
    }

    /// Returns whether the results are complete.
    pub(crate) fn is_complete(&self) -> bool {
        is_result(&self.target) && !self.partial.exists()
    }

    /// Creates the folder, which is empty unless a run is resumed. Fails if that would destroy files without permission.
    pub(crate) fn claim(&self, existing: Existing) -> Result<()> {
        self.check_target(existing)?;
        if self.partial.exists() {
            let lock = self.take_lock()?;
            if existing.resume && self.checkpoint().is_file() {
                return self.hold(lock);
            }
            if !existing.overwrite && !existing.resume {
                let reason = "was left by an unfinished run (--resume continues it, --overwrite starts again)";
                return Err(refused(&self.partial, reason));
            }
            if !self.work().is_dir() && !is_empty(&self.partial) {
                return Err(refused(
                    &self.partial,
                    "was not written by this program and is not replaced: remove it yourself",
                ));
            }
            drop(lock);
            remove(&self.partial)?;
        }
        create_folder(&self.work()).inspect_err(|_| {
            // There may be space for one folder only.
            let _ = fs::remove_dir(&self.partial);
        })?;
        let lock = self.take_lock()?;
        self.hold(lock)
    }

    /// Locks the folder for this run; returns no lock if there is no folder, or if the file system has no locks.
    fn take_lock(&self) -> Result<Option<File>> {
        let Ok(file) = File::create(self.work().join("lock")) else { return Ok(None) };
        match FileExt::try_lock(&file) {
            Ok(()) => Ok(Some(file)),
            Err(TryLockError::WouldBlock) => {
                Err(refused(&self.partial, "is being written by another run (wait for it, or choose another folder)"))
            }
            // Network file systems may have no locks.
            Err(TryLockError::Error(_)) => Ok(None),
        }
    }

    fn hold(&self, lock: Option<File>) -> Result<()> {
        self.lock.set(lock).map_err(|_| Failure::new("claimed twice"))
    }

    fn check_target(&self, existing: Existing) -> Result<()> {
        let target = &self.target;
        if !target.exists() || is_empty(target) {
            Ok(())
        } else if !existing.overwrite {
            Err(refused(target, "exists already (use --overwrite to replace results, or choose another folder)"))
        } else if !is_result(target) {
            Err(refused(target, "has no results of this program and is not replaced: choose another folder"))
        } else {
            Ok(())
        }
    }

    /// Returns the final path.
    pub(crate) fn target(&self) -> &Path {
        &self.target
    }

    /// Returns the path under which a result is written.
    pub(crate) fn file(&self, name: impl AsRef<Path>) -> PathBuf {
        self.partial.join(name)
    }

    /// Returns the folder of working files.
    pub(crate) fn work(&self) -> PathBuf {
        self.partial.join(WORK)
    }

    pub(crate) fn checkpoint(&self) -> PathBuf {
        self.work().join("checkpoint")
    }

    /// Renames the folder to its final path.
    pub(crate) fn finish(&self) -> Result<()> {
        remove(&self.work())?;
        let rename = |from: &Path, to: &Path| fs::rename(from, to).map_err(|e| cannot_write(to, &e));
        if !self.target.exists() || fs::remove_dir(&self.target).is_ok() {
            return rename(&self.partial, &self.target);
        }
        let old = self.target.with_file_name(format!("{}.replaced", lossy(self.target.file_name())));
        rename(&self.target, &old)?;
        rename(&self.partial, &self.target)?;
        remove(&old)
    }

    /// Removes the folder after a failure or an interruption, unless a run can be resumed from it. Returns whether it can. Folders
    /// of other runs stay.
    pub(crate) fn give_up(&self) -> bool {
        if self.lock.get().is_none() {
            return false;
        }
        let is_resumable = self.checkpoint().is_file();
        if !is_resumable {
            // If it cannot be removed, it does not exist or the next run reports it.
            let _ = fs::remove_dir_all(&self.partial);
        }
        is_resumable
    }
}

fn refused(path: &Path, reason: &str) -> Failure {
    Failure::usage(reason).with_subject(path.display())
}

fn lossy(name: Option<&OsStr>) -> String {
    name.unwrap_or_default().to_string_lossy().into_owned()
}

fn is_empty(folder: &Path) -> bool {
    fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_none())
}

/// Returns whether a folder has a report of this program.
fn is_result(folder: &Path) -> bool {
    fs::read_to_string(folder.join("result.json")).is_ok_and(|text| text.contains("\"workingWidth\""))
}

fn remove(folder: &Path) -> Result<()> {
    fs::remove_dir_all(folder)
        .map_err(|e| Failure::new(format!("cannot be removed: {e}")).with_subject(folder.display()))
}
