//! What lies on disk of a run that is not done, so that `--resume` goes on with it.

use crate::failure::{Failure, Result, cannot_write, read, write};
use crate::output::Place;
use crate::provenance::{Provenance, sum};
use serde::{Deserialize, Serialize};
use std::fs;
use tracecut::Checkpoint;

/// Where a run is.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Saved {
    /// Provenance of the run, as JSON.
    pub(crate) provenance: String,
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
        fs::rename(&new, &file).map_err(|e| cannot_write(&file, &e))
    }

    /// Reads the checkpoint that was written last, if any.
    pub(crate) fn read(place: &Place) -> Result<Option<Self>> {
        let file = place.checkpoint();
        if !file.is_file() {
            return Ok(None);
        }
        let bytes = read(&file)?;
        let whole = bytes.split_last_chunk::<8>().filter(|(data, own)| sum(data) == u64::from_le_bytes(**own));
        let saved = whole.and_then(|(data, _)| postcard::from_bytes(data).ok());
        saved.map(Some).ok_or_else(|| Failure::usage("is damaged (--overwrite begins again)").of(file.display()))
    }

    /// Checks that the run has this provenance.
    pub(crate) fn check(&self, provenance: &Provenance<'_>, place: &Place) -> Result<()> {
        let saved = serde_json::from_str(&self.provenance).unwrap_or_default();
        provenance.check(&place.checkpoint(), &saved)
    }
}
