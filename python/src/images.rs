//! Single images: boundaries, superpixels, discontinuities of the pixel embedding, flow between two, masks enlarged.

use crate::arrays::{self, FlowArrays, frame_from, image_from, mask_from, plane};
use crate::error::Result;
use crate::params::params_from;
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tracecut::contour::boundary_map;
use tracecut::flow::{FlowPyramid, flow_between};
use tracecut::still;
use tracecut::superpixel::superpixels_of;

type Image<'a, 'py> = &'a Bound<'py, PyAny>;
type Options<'a, 'py> = &'a Bound<'py, PyDict>;

/// Pb, and the same on ridges one pixel wide.
#[pyfunction]
pub(crate) fn boundaries<'py>(
    py: Python<'py>,
    image: Image<'_, 'py>,
    params: Options<'_, 'py>,
) -> Result<FlowArrays<'py>> {
    let params = params_from(params)?;
    let frame = image_from(image, &params)?;
    Ok(arrays::boundaries(py, py.detach(|| boundary_map(&frame))))
}

#[pyfunction]
pub(crate) fn superpixels<'py>(
    py: Python<'py>,
    image: Image<'_, 'py>,
    count: Option<usize>,
    params: Options<'_, 'py>,
) -> Result<Bound<'py, PyDict>> {
    let params = params_from(params)?;
    let frame = image_from(image, &params)?;
    let superpixels = py.detach(|| superpixels_of(&frame, count, &params.contour, &params.superpixel));
    arrays::superpixels(py, &superpixels)
}

/// `{pb, discontinuity, spectral, combined, eigenvalues}`.
#[pyfunction]
pub(crate) fn image_discontinuities<'py>(
    py: Python<'py>,
    image: Image<'_, 'py>,
    params: Options<'_, 'py>,
) -> Result<Bound<'py, PyDict>> {
    let params = params_from(params)?;
    let frame = image_from(image, &params)?;
    let image = py.detach(|| still::image_discontinuities(&frame, &params.still, params.clip.seed));
    let fields = PyDict::new(py);
    fields.set_item("pb", plane(py, image.pb.pb))?;
    fields.set_item("discontinuity", plane(py, image.d.strength))?;
    fields.set_item("spectral", plane(py, image.spectral.strength))?;
    fields.set_item("combined", plane(py, image.combined.pb))?;
    fields.set_item("eigenvalues", arrays::list(py, image.eigenvalues))?;
    Ok(fields)
}

#[pyfunction]
pub(crate) fn flow<'py>(
    py: Python<'py>,
    first: Image<'_, 'py>,
    second: Image<'_, 'py>,
    params: Options<'_, 'py>,
) -> Result<FlowArrays<'py>> {
    let params = params_from(params)?;
    let (first, second) = (image_from(first, &params)?, image_from(second, &params)?);
    let size = |frame: &tracecut::image::Frame| (frame.width(), frame.height());
    if size(&first) != size(&second) {
        return Err(
            tracecut::Error::FrameSizeChanged { index: 1, expected: size(&first), actual: size(&second) }.into()
        );
    }
    let field = py.detach(|| flow_between(&FlowPyramid::new(&first), &FlowPyramid::new(&second), &params.flow));
    Ok(arrays::flow(py, field))
}

/// Labels and opacity at the size of `picture`.
#[pyfunction]
#[allow(clippy::type_complexity, reason = "two arrays")]
pub(crate) fn enlarge<'py>(
    py: Python<'py>,
    mask: Image<'_, 'py>,
    picture: Image<'_, 'py>,
) -> Result<(Bound<'py, PyArray2<u8>>, Bound<'py, PyArray2<u8>>)> {
    let (mask, picture) = (mask_from(mask)?, frame_from(picture)?);
    let enlarged = py.detach(|| tracecut::mask::enlarge(&mask, &picture, |label| label > 0))?;
    Ok((plane(py, enlarged.labels), plane(py, enlarged.alpha)))
}
