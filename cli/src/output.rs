//! A folder of results, complete or absent: it is written beside the one that was named, and renamed when all is there.

use crate::failure::{Failure, Result, cannot_write, create_folder};
use fs4::{FileExt, TryLockError};
use std::ffi::OsStr;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// What is not a result lies here until the end: what a run needs that goes on, and parts of the report.
const WORK: &str = ".tracecut";

/// What to do with what lies there already.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Existing {
    pub(crate) overwrite: bool,
    pub(crate) resume: bool,
}

/// A folder of results that is being written.
#[derive(Debug, Clone)]
pub(crate) struct Place {
    target: PathBuf,
    partial: PathBuf,
    /// Held from when the folder is this run's; the system lets go of it however the run ends.
    lock: Arc<OnceLock<Option<File>>>,
}

impl Place {
    /// The place of results that are to be in `target`.
    pub(crate) fn new(target: &Path) -> Result<Self> {
        let name = target.file_name().ok_or_else(|| refused(target, "is no name for a folder of results"))?;
        let mut partial = name.to_owned();
        partial.push(".partial");
        Ok(Self { target: target.to_owned(), partial: target.with_file_name(partial), lock: Arc::default() })
    }

    /// Whether the results are there, and a run that goes on has nothing to do.
    pub(crate) fn is_complete(&self) -> bool {
        is_result(&self.target) && !self.partial.exists()
    }

    /// Makes the folder, empty unless the run goes on; an error where that would cost what nobody gave up.
    pub(crate) fn claim(&self, existing: Existing) -> Result<()> {
        self.check_target(existing)?;
        if self.partial.exists() {
            let others = self.take_lock()?;
            if existing.resume && self.checkpoint().is_file() {
                return self.hold(others);
            }
            if !existing.overwrite && !existing.resume {
                let reason = "was left by a run that did not end (--resume goes on with it, --overwrite begins again)";
                return Err(refused(&self.partial, reason));
            }
            if !self.work().is_dir() && !is_empty(&self.partial) {
                return Err(refused(&self.partial, "is not of this program and is not replaced: remove it yourself"));
            }
            drop(others);
            remove(&self.partial)?;
        }
        create_folder(&self.work()).inspect_err(|_| {
            // Where there was room for the one folder and not for the other.
            let _ = fs::remove_dir(&self.partial);
        })?;
        let own = self.take_lock()?;
        self.hold(own)
    }

    /// The lock of the folder, which one run at a time has; none where there is no folder, or no locks.
    fn take_lock(&self) -> Result<Option<File>> {
        let Ok(file) = File::create(self.work().join("lock")) else { return Ok(None) };
        match FileExt::try_lock(&file) {
            Ok(()) => Ok(Some(file)),
            Err(TryLockError::WouldBlock) => {
                Err(refused(&self.partial, "is being written by another run (wait for it, or name another folder)"))
            }
            // File systems of networks may have none.
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
            Err(refused(target, "exists already (--overwrite replaces results, or name another folder)"))
        } else if !is_result(target) {
            Err(refused(target, "holds no result of this program and is not replaced: name another folder"))
        } else {
            Ok(())
        }
    }

    /// The folder named, which is there at the end.
    pub(crate) fn target(&self) -> &Path {
        &self.target
    }

    /// Where `name` of the results is written.
    pub(crate) fn file(&self, name: impl AsRef<Path>) -> PathBuf {
        self.partial.join(name)
    }

    /// Where what is not a result is kept.
    pub(crate) fn work(&self) -> PathBuf {
        self.partial.join(WORK)
    }

    pub(crate) fn checkpoint(&self) -> PathBuf {
        self.work().join("checkpoint")
    }

    /// All results are written: puts them where they were asked for.
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

    /// The run has failed or was ended: nothing stays but what a run can go on with; whether there is such. What is not
    /// this run's stays in any case.
    pub(crate) fn give_up(&self) -> bool {
        if self.lock.get().is_none() {
            return false;
        }
        let goes_on = self.checkpoint().is_file();
        if !goes_on {
            // What cannot be removed either was never made, or the next run says so.
            let _ = fs::remove_dir_all(&self.partial);
        }
        goes_on
    }
}

fn refused(path: &Path, reason: &str) -> Failure {
    Failure::usage(reason).of(path.display())
}

fn lossy(name: Option<&OsStr>) -> String {
    name.unwrap_or_default().to_string_lossy().into_owned()
}

fn is_empty(folder: &Path) -> bool {
    fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_none())
}

/// Whether a folder holds a report of this program.
fn is_result(folder: &Path) -> bool {
    fs::read_to_string(folder.join("result.json")).is_ok_and(|text| text.contains("\"workingWidth\""))
}

fn remove(folder: &Path) -> Result<()> {
    fs::remove_dir_all(folder).map_err(|e| Failure::new(format!("cannot be removed: {e}")).of(folder.display()))
}
