//! Frames from arrays.

use crate::error::{Failure, Result};
use numpy::{PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use tracecut::image::{Frame, MAX_SIDE, Plane};
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
        check(width, height, limit)?;
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

fn check(width: usize, height: usize, limit: usize) -> std::result::Result<(), Error> {
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
