//! What lies on disk of a run that is not done, so that `--resume` goes on with it.

use crate::failure::{Failure, Result, read, write};
use crate::output::Place;
use serde::{Deserialize, Serialize};
use std::fs;
use tracecut::Checkpoint;
use tracecut::image::Frame;

/// By what an input is known again.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Origin {
    size: (usize, usize),
    /// Number of frames, where known before reading them.
    count: Option<usize>,
    /// Sum over the pixels of the first frame.
    first: u64,
}

impl Origin {
    pub(crate) fn of(first: &Frame, count: Option<usize>) -> Self {
        Self { size: (first.width(), first.height()), count, first: sum(first.rgb()) }
    }
}

/// Where a run is.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Saved {
    /// The options that results depend on, as JSON.
    pub(crate) options: String,
    pub(crate) origin: Origin,
    pub(crate) checkpoint: Checkpoint,
}

impl Saved {
    /// Takes the place of the one before, at once.
    pub(crate) fn write(&self, place: &Place) -> Result<()> {
        let file = place.checkpoint();
        let mut bytes = postcard::to_stdvec(self).map_err(|e| Failure::new(format!("checkpoint: {e}")))?;
        bytes.extend(sum(&bytes).to_le_bytes());
        let new = file.with_extension("new");
        write(&new, bytes)?;
        fs::rename(&new, &file).map_err(|e| crate::failure::cannot_write(&file, &e))
    }

    /// The one that was written last; an error unless it is of a run with these options.
    pub(crate) fn read(place: &Place, options: &str) -> Result<Option<Self>> {
        let file = place.checkpoint();
        if !file.is_file() {
            return Ok(None);
        }
        let broken = || Failure::about(file.display(), "is damaged (--overwrite begins again)");
        let bytes = read(&file)?;
        let (data, own) = bytes.split_last_chunk::<8>().ok_or_else(broken)?;
        if sum(data) != u64::from_le_bytes(*own) {
            return Err(broken());
        }
        let saved: Self = postcard::from_bytes(data).map_err(|_| broken())?;
        if saved.options != options {
            let reason =
                "was made with other options or parameters, or by another version (use the same, or --overwrite)";
            return Err(Failure::usage(reason).of(file.display()));
        }
        Ok(Some(saved))
    }

    /// An error unless the input is the one that the run began with.
    pub(crate) fn check(&self, origin: &Origin, place: &Place) -> Result<()> {
        if self.origin == *origin {
            return Ok(());
        }
        let reason =
            "was made of another input: size, number of frames or the first frame differ (--overwrite begins again)";
        Err(Failure::usage(reason).of(place.checkpoint().display()))
    }
}

/// FNV-1a.
fn sum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, &b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3))
}
