//! Shots of the Moseg benchmark: their ground truth.

use crate::measures::definition::{Definition, parse_pgm};
use std::ops::Range;
use std::path::Path;
use tracecut::Session;
use tracecut::image::Plane;
use tracecut_cli::failure::{Failure, Result, read, read_text};
use tracecut_cli::images::is_endless;

/// A shot's ground truth: its definition and the region maps of the labelled frames used.
pub(crate) struct Shot {
    pub(crate) definition: Definition,
    pub(crate) maps: Vec<Plane<u8>>,
}

impl Shot {
    /// Reads a definition file and the masks beside it of a range of frames; the range's first is frame 0 of the result.
    pub(crate) fn read(path: &Path, frames: Range<usize>) -> Result<Self> {
        let mut definition = read_definition(path)?;
        definition.num_frames = definition.num_frames.saturating_sub(frames.start);
        definition.labelled.retain(|frame| frames.contains(&frame.index));
        let mut maps = Vec::new();
        for frame in &mut definition.labelled {
            frame.index -= frames.start;
        }
        for frame in &definition.labelled {
            let mask_path = path.with_file_name(&frame.mask);
            if is_endless(&mask_path) {
                return Err(Failure::about(
                    path.display(),
                    format_args!("names {}, which is no file", mask_path.display()),
                ));
            }
            let mask = parse_pgm(&read(&mask_path)?).map_err(|e| Failure::about(mask_path.display(), e))?;
            maps.push(definition.regions(&mask));
        }
        Ok(Self { definition, maps })
    }
}

/// Reads a definition file.
pub(crate) fn read_definition(path: &Path) -> Result<Definition> {
    Definition::parse(&read_text(path)?).map_err(|e| Failure::about(path.display(), e))
}

/// Returns the number of labels of [`Session::cluster_labels`]: a clip without clusters has one.
pub(crate) fn num_clusters(session: &Session) -> usize {
    session.clusters().map_or(0, |c| c.count).max(1)
}
