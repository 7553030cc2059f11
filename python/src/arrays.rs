//! Results as arrays, and groups of them as dictionaries.

use crate::error::Result;
use numpy::ndarray::{Array2, Array3};
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tracecut::contour::BoundaryMap;
use tracecut::flow::FlowField;
use tracecut::image::{Frame, Plane};
use tracecut::superpixel::{Edge, EdgeKind, SuperpixelBorder, Superpixels};
use tracecut::trajectory::Trajectories;

/// Rows of values as a matrix, without a copy.
pub(crate) fn matrix<T>(py: Python<'_>, rows: usize, columns: usize, data: Vec<T>) -> Bound<'_, PyArray2<T>>
where
    T: Element + Default,
{
    // The callers checked the number of values.
    Array2::from_shape_vec((rows, columns), data).unwrap_or_default().into_pyarray(py)
}

/// A plane as a matrix of its rows, without a copy.
pub(crate) fn plane<T: Element + Copy + Default>(py: Python<'_>, plane: Plane<T>) -> Bound<'_, PyArray2<T>> {
    let (width, height) = (plane.width(), plane.height());
    matrix(py, height, width, plane.into_data())
}

/// The pixels of an image with `C` channels: shape (height, width, channels).
pub(crate) fn pixels<const C: usize>(py: Python<'_>, plane: Plane<[u8; C]>) -> Bound<'_, PyArray3<u8>> {
    let shape = (plane.height(), plane.width(), C);
    Array3::from_shape_vec(shape, plane.into_data().into_flattened()).unwrap_or_default().into_pyarray(py)
}

/// RGB of a frame.
pub(crate) fn rgb<'py>(py: Python<'py>, frame: &Frame) -> Bound<'py, PyArray3<u8>> {
    let shape = (frame.height(), frame.width(), 3);
    Array3::from_shape_vec(shape, frame.rgb().to_vec()).unwrap_or_default().into_pyarray(py)
}

/// A list as an array, without a copy.
pub(crate) fn list<T: Element>(py: Python<'_>, values: Vec<T>) -> Bound<'_, PyArray1<T>> {
    values.into_pyarray(py)
}

/// A copy of values that a session keeps.
pub(crate) fn copy<'py, T: Element + Copy>(py: Python<'py>, values: &[T]) -> Bound<'py, PyArray1<T>> {
    PyArray1::from_slice(py, values)
}

/// Both components of a flow.
pub(crate) type FlowArrays<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<f32>>);

pub(crate) fn flow(py: Python<'_>, field: FlowField) -> FlowArrays<'_> {
    (plane(py, field.u), plane(py, field.v))
}

pub(crate) fn boundaries(py: Python<'_>, map: BoundaryMap) -> FlowArrays<'_> {
    (plane(py, map.pb), plane(py, map.thin))
}

/// `{num_frames, width, height, start_frame, offset, x, y, id}`.
pub(crate) fn trajectories<'py>(py: Python<'py>, t: &Trajectories, numbers: &[u32]) -> Result<Bound<'py, PyDict>> {
    let fields = PyDict::new(py);
    fields.set_item("num_frames", t.num_frames)?;
    fields.set_item("width", t.size.0)?;
    fields.set_item("height", t.size.1)?;
    fields.set_item("start_frame", copy(py, &t.start_frame))?;
    fields.set_item("offset", copy(py, &t.offset))?;
    fields.set_item("x", copy(py, &t.x))?;
    fields.set_item("y", copy(py, &t.y))?;
    fields.set_item("id", copy(py, numbers))?;
    Ok(fields)
}

/// `{count, label, border_pair, border_length, border_pb, edge, edge_kind}`.
pub(crate) fn superpixels<'py>(py: Python<'py>, s: &Superpixels) -> Result<Bound<'py, PyDict>> {
    let sides = s.borders.iter().flat_map(|b| [b.a, b.b]).collect();
    let ends = s.edges.iter().flat_map(|e| [e.from.0, e.from.1, e.to.0, e.to.1]).collect();
    let column = |field: fn(&SuperpixelBorder) -> f32| list(py, s.borders.iter().map(field).collect());
    let fields = PyDict::new(py);
    fields.set_item("count", s.count)?;
    fields.set_item("label", plane(py, s.label()))?;
    fields.set_item("border_pair", matrix::<u32>(py, s.borders.len(), 2, sides))?;
    fields.set_item("border_length", column(|b| b.length))?;
    fields.set_item("border_pb", column(|b| b.pb))?;
    fields.set_item("edge", matrix::<f32>(py, s.edges.len(), 4, ends))?;
    fields.set_item("edge_kind", list::<u8>(py, s.edges.iter().map(kind_number).collect()))?;
    Ok(fields)
}

/// Returns the numbers of `tracecut.EdgeKind`, as in the npm package.
fn kind_number(edge: &Edge) -> u8 {
    match edge.kind {
        EdgeKind::Constraint => 0,
        EdgeKind::Frame => 1,
        EdgeKind::Gabriel => 2,
        _ => 3,
    }
}
