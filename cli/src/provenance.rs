//! Provenance of results, which `--resume` compares, and the saved state of an unfinished run.

use crate::failure::{Failure, Result, cannot_write, read, write};
use crate::output::OutputFolder;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::fs;
use std::path::Path;
use tracecut::Checkpoint;
use tracecut::Params;
use tracecut::image::Frame;

/// Options that results depend on. The number of threads changes nothing.
#[derive(Debug, Serialize)]
pub(crate) struct Options {
    pub(crate) window: u16,
    /// Largest number of frames; `null` for all.
    pub(crate) frames: Option<u32>,
    pub(crate) formats: Vec<String>,
    pub(crate) background: bool,
    pub(crate) dump: bool,
    /// True if trajectories come from a file.
    pub(crate) tracks: bool,
}

/// Everything that results depend on, except the input.
#[derive(Debug, Serialize)]
pub(crate) struct Recipe<'a> {
    pub(crate) version: &'static str,
    pub(crate) options: Options,
    pub(crate) params: &'a Params,
}

/// Identity of an input.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Origin {
    width: usize,
    height: usize,
    /// Number of frames; `None` if it is not known before reading them.
    frames: Option<usize>,
    /// Length of the file; `None` for folders and streams.
    bytes: Option<u64>,
    /// Sum over the pixels of the first frame, in hexadecimal digits.
    first_frame_sum: String,
}

impl Origin {
    pub(crate) fn new(path: &Path, num_frames: Option<usize>, first: &Frame) -> Self {
        let file = fs::metadata(path).ok().filter(|file| file.is_file() && path != Path::new("-"));
        Self {
            width: first.width(),
            height: first.height(),
            frames: num_frames,
            bytes: file.map(|file| file.len()),
            first_frame_sum: format!("{:016x}", sum(first.rgb())),
        }
    }
}

/// Input and recipe of results: runs of the same provenance give the same results.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Provenance<'a> {
    #[serde(flatten)]
    pub(crate) recipe: &'a Recipe<'a>,
    pub(crate) source: Origin,
}

impl Provenance<'_> {
    pub(crate) fn to_json(&self) -> Result<String> {
        serde_json::to_string(self).map_err(|e| Failure::new(e.to_string()))
    }

    /// Checks that the results in `path`, described by `json`, have this provenance. Ignores other fields of `json`.
    pub(crate) fn check(&self, path: &Path, json: &Value) -> Result<()> {
        let expected = serde_json::from_str(&self.to_json()?).map_err(|e| Failure::new(e.to_string()))?;
        difference("", json, &expected).map_or(Ok(()), |difference| {
            let reason = "was not made from this input with these options and this version";
            Err(Failure::usage(format!("{reason}: {difference} (--overwrite starts again)"))
                .with_subject(path.display()))
        })
    }
}

/// Names the first entry of `new` that is missing or different in `old`.
fn difference(path: &str, old: &Value, new: &Value) -> Option<String> {
    let Value::Object(entries) = new else {
        return (old != new).then(|| format!("{path} was {old} and is {new}"));
    };
    let separator = if path.is_empty() { "" } else { "." };
    entries.iter().find_map(|(name, new)| difference(&format!("{path}{separator}{name}"), &old[name], new))
}

/// FNV-1a.
pub(crate) fn sum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, &b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3))
}

/// The saved state of a run.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct SavedRun {
    /// Provenance of the run, as JSON.
    pub(crate) provenance: String,
    pub(crate) checkpoint: Checkpoint,
}

impl SavedRun {
    /// Replaces the previous state atomically.
    pub(crate) fn write(&self, place: &OutputFolder) -> Result<()> {
        let file = place.checkpoint();
        let mut bytes = postcard::to_stdvec(self).map_err(|e| Failure::new(format!("checkpoint: {e}")))?;
        bytes.extend(sum(&bytes).to_le_bytes());
        let new = file.with_extension("new");
        write(&new, bytes)?;
        fs::rename(&new, &file).map_err(|e| cannot_write(&file, &e))
    }

    /// Reads the checkpoint that was written last, if any.
    pub(crate) fn read(place: &OutputFolder) -> Result<Option<Self>> {
        let file = place.checkpoint();
        if !file.is_file() {
            return Ok(None);
        }
        let bytes = read(&file)?;
        let checked = bytes.split_last_chunk::<8>().filter(|(data, tail)| sum(data) == u64::from_le_bytes(**tail));
        let saved_run = checked.and_then(|(data, _)| postcard::from_bytes(data).ok());
        saved_run
            .map(Some)
            .ok_or_else(|| Failure::usage("is damaged (--overwrite starts again)").with_subject(file.display()))
    }

    /// Checks that the run has this provenance.
    pub(crate) fn check(&self, provenance: &Provenance<'_>, place: &OutputFolder) -> Result<()> {
        let saved_provenance = serde_json::from_str(&self.provenance).unwrap_or_default();
        provenance.check(&place.checkpoint(), &saved_provenance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_is_the_published_one() {
        assert_eq!((sum(b""), sum(b"a")), (0xcbf2_9ce4_8422_2325, 0xaf63_dc4c_8601_ec8c));
    }
}
