//! Files: images in, masks and trajectories out; and prompts from masks.

use crate::arrays::{self, mask_from, plane};
use crate::error::{Failure, Result};
use numpy::{PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList};
use tracecut::discretize::Clusters;
use tracecut::image::Frame;
use tracecut::mask::{coco_counts, coco_mask, coco_runs, coco_text};
use tracecut::trajectory::Trajectories;
use tracecut::{Error, mask, tracks};

/// The pixels of a PNG or JPEG file, as the command line reads them.
#[pyfunction]
pub(crate) fn decode<'py>(py: Python<'py>, bytes: &[u8]) -> Result<Bound<'py, PyArray3<u8>>> {
    Ok(arrays::rgb(py, &py.detach(|| Frame::decode(bytes))?))
}

/// A mask as a PNG file whose pixels are the labels; `palette` has three bytes a label.
#[pyfunction]
pub(crate) fn palette_png<'py>(
    py: Python<'py>,
    mask: &Bound<'py, PyAny>,
    palette: Vec<u8>,
) -> Result<Bound<'py, PyBytes>> {
    let mask = mask_from(mask)?;
    let mut file = Vec::new();
    let written = py.detach(|| {
        let mut encoder = png::Encoder::new(&mut file, mask.width() as u32, mask.height() as u32);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_palette(palette);
        encoder.write_header()?.write_image_data(mask.data())
    });
    written.map_err(|e| Failure::data(format!("mask cannot be written: {e}")))?;
    Ok(PyBytes::new(py, &file))
}

/// Lengths of runs of a mask of 0 and 1, outside and inside in turn, column by column; the first is outside and may be 0.
#[pyfunction]
pub(crate) fn run_lengths(py: Python<'_>, mask: &Bound<'_, PyAny>) -> Result<Vec<u32>> {
    let mask = mask_from(mask)?;
    let pixels = mask.data().len() as u32;
    let inside = py.detach(|| coco_runs(&mask)).into_iter().find(|runs| runs.label == 1);
    Ok(inside.map_or_else(|| vec![pixels], |runs| runs.counts))
}

/// Such lengths as COCO's text.
#[pyfunction]
pub(crate) fn run_text(lengths: Vec<u32>) -> String {
    coco_text(&lengths)
}

/// The lengths of COCO's text.
#[pyfunction]
pub(crate) fn run_counts(text: &str) -> Result<Vec<u32>> {
    Ok(coco_counts(text)?)
}

/// The mask of 0 and 1 that lengths are of.
#[pyfunction]
pub(crate) fn run_mask(
    py: Python<'_>,
    lengths: Vec<u32>,
    width: usize,
    height: usize,
) -> Result<Bound<'_, PyArray2<u8>>> {
    Ok(arrays::plane(py, coco_mask(&lengths, (width, height))?))
}

/// The trajectories of a `tracks.dat`, whose size is not in it, and their labels.
#[pyfunction]
pub(crate) fn read_tracks<'py>(py: Python<'py>, text: &str) -> Result<(Bound<'py, PyDict>, Bound<'py, PyArray1<u32>>)> {
    let (tracks, clusters) = tracks::parse(text)?;
    Ok((arrays::trajectories(py, &tracks, &[])?, arrays::list(py, clusters.label)))
}

/// The text of a `tracks.dat`.
#[pyfunction]
pub(crate) fn write_tracks(
    num_frames: usize,
    start_frame: Vec<u32>,
    offset: Vec<u32>,
    x: Vec<f32>,
    y: Vec<f32>,
    label: Vec<u32>,
) -> Result<String> {
    let variation = vec![0.0; x.len()];
    let trajectories = Trajectories { num_frames, size: (1, 1), start_frame, offset, x, y, variation };
    trajectories.check()?;
    let count = label.iter().max().map_or(0, |&most| most as usize + 1);
    let written = tracks::write(&trajectories, &Clusters { count, label });
    written.map_err(|error: Error| error.into())
}

/// Looks for prompts in masks, one after the other.
#[pyclass(module = "tracecut._tracecut")]
#[derive(Default)]
pub(crate) struct Prompts {
    prompts: mask::Prompts,
    count: usize,
}

#[pymethods]
impl Prompts {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    fn add(&mut self, py: Python<'_>, mask: &Bound<'_, PyAny>) -> Result<()> {
        let mask = mask_from(mask)?;
        py.detach(|| self.prompts.add(self.count, &mask));
        self.count += 1;
        Ok(())
    }

    /// Returns `{object, frame, bounds, inside, outside, mask}` of each object, and starts again.
    fn finish<'py>(&mut self, py: Python<'py>) -> Result<Bound<'py, PyList>> {
        let prompts = std::mem::take(self).prompts;
        let list = PyList::empty(py);
        for prompt in py.detach(|| prompts.finish()) {
            let fields = PyDict::new(py);
            fields.set_item("object", prompt.object)?;
            fields.set_item("frame", prompt.frame)?;
            fields.set_item("bounds", prompt.bounds)?;
            fields.set_item("inside", prompt.inside)?;
            fields.set_item("outside", prompt.outside)?;
            fields.set_item("mask", plane(py, prompt.mask))?;
            list.append(fields)?;
        }
        Ok(list)
    }
}
