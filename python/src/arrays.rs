//! Frames and masks from arrays; results as arrays, and groups of them as dictionaries.

use crate::error::{Failure, Result};
use numpy::ndarray::{Array2, Array3};
use numpy::{
    Element, IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods,
    PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tracecut::contour::BoundaryMap;
use tracecut::explanation::{Explanation, LabelCost, LabelSource, SuperpixelLink, Voter};
use tracecut::flow::FlowField;
use tracecut::image::{Frame, MAX_SIDE, Plane};
use tracecut::superpixel::{Edge, EdgeKind, SuperpixelBorder, Superpixels};
use tracecut::trajectory::Trajectories;
use tracecut::{Error, Params};

const EXPECTED: &str = "expected uint8 of shape (height, width), (height, width, 3) or (height, width, 4)";

/// An array of bytes as a frame: RGB, RGBA (alpha is left out) or grey.
pub(crate) fn frame_from(array: &Bound<'_, PyAny>) -> Result<Frame> {
    frame_within(array, usize::MAX)
}

/// The same, where these parameters allow this number of pixels.
pub(crate) fn image_from(array: &Bound<'_, PyAny>, params: &Params) -> Result<Frame> {
    frame_within(array, params.clip.max_pixels as usize)
}

/// Sizes are looked at before anything is copied: an array that repeats itself takes no memory, its copy does.
fn frame_within(array: &Bound<'_, PyAny>, limit: usize) -> Result<Frame> {
    let bytes = array.cast::<PyArrayDyn<u8>>().map_err(|_| Failure::data(describe(array)))?.readonly();
    let view = bytes.as_array();
    if let [height, width, ..] = *view.shape() {
        check_size(width, height, limit)?;
    }
    // Borrows what lies row by row already.
    let rows = view.as_standard_layout();
    let data = rows.as_slice().unwrap_or_default();
    let frame = match *view.shape() {
        [height, width] | [height, width, 1] => {
            Frame::from_rgb(data.iter().flat_map(|&grey| [grey; 3]).collect(), width, height)
        }
        [height, width, 3] => Frame::from_rgb(data.to_vec(), width, height),
        [height, width, 4] => Frame::from_rgba(data, width, height),
        _ => return Err(Failure::data(describe(array))),
    };
    Ok(frame?)
}

fn check_size(width: usize, height: usize, limit: usize) -> std::result::Result<(), Error> {
    if width > MAX_SIDE || height > MAX_SIDE {
        return Err(Error::FrameSize { width, height });
    }
    let actual = width * height;
    if actual > limit {
        return Err(Error::TooLarge { what: "pixels in a frame", actual, limit, name: "clip.max_pixels".to_owned() });
    }
    Ok(())
}

/// Describes an argument that is not a frame.
fn describe(array: &Bound<'_, PyAny>) -> String {
    match array.cast::<PyUntypedArray>() {
        Ok(array) => {
            let shape: Vec<String> = array.shape().iter().map(usize::to_string).collect();
            let kind = array.dtype().typeobj().name().map_or_else(|_| "?".to_owned(), |n| n.to_string());
            format!("frame is an array of {kind} of shape ({}) ({EXPECTED})", shape.join(", "))
        }
        Err(_) => {
            let kind = array.get_type().name().map_or_else(|_| "?".to_owned(), |n| n.to_string());
            format!("frame is of type {kind} ({EXPECTED})")
        }
    }
}

/// A mask of bytes.
pub(crate) fn mask_from(array: &Bound<'_, PyAny>) -> Result<Plane<u8>> {
    let wrong = || Failure::data("mask is not an array (expected uint8 of shape (height, width))".to_owned());
    let bytes = array.cast::<PyArrayDyn<u8>>().map_err(|_| wrong())?.readonly();
    let view = bytes.as_array();
    let [height, width] = *view.shape() else { return Err(wrong()) };
    Plane::from_vec(width, height, view.iter().copied().collect()).ok_or_else(wrong)
}

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

/// The fields of `tracecut.Explanation` by their names; of lists of classes the fields in order.
pub(crate) fn explanation<'py>(py: Python<'py>, why: &Explanation) -> Result<Bound<'py, PyDict>> {
    let source = match why.source {
        LabelSource::Superpixel => "superpixel",
        LabelSource::Border => "border",
        LabelSource::Stroke => "stroke",
    };
    let cost = |c: &LabelCost| (c.cluster, c.label, c.votes, c.trajectories, c.evidence, c.links, c.forbidden, c.total);
    let link = |l: &SuperpixelLink| (l.t, l.superpixel, l.cluster, l.tracks, l.cost);
    let voter = |v: &Voter| (v.x, v.y, v.cluster.map_or(-1, i64::from));
    let fields = PyDict::new(py);
    fields.set_item("label", why.label)?;
    fields.set_item("source", source)?;
    fields.set_item("superpixel", why.superpixel)?;
    fields.set_item("cluster", why.cluster)?;
    fields.set_item("weight", why.weight)?;
    fields.set_item("evidence", (why.evidence.background, why.evidence.looks))?;
    fields.set_item("costs", why.costs.iter().map(cost).collect::<Vec<_>>())?;
    fields.set_item("links", why.links.iter().map(link).collect::<Vec<_>>())?;
    fields.set_item("voters", why.voters.iter().map(voter).collect::<Vec<_>>())?;
    fields.set_item("nearest", why.nearest)?;
    fields.set_item("affinities", why.affinities.iter().map(|entry| (entry.to, entry.affinity)).collect::<Vec<_>>())?;
    fields.set_item("flip", why.flip.map(|flip| (flip.cluster, flip.margin, flip.votes)))?;
    fields.set_item("border", why.border.map(|border| (border.edges, border.mean, border.i, border.j, border.d)))?;
    Ok(fields)
}
