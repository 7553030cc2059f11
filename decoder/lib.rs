//! Image files to pixels, and masks to the size of their pictures, for JavaScript; see `www/lib/worker/decode.js` and
//! `www/lib/edit/enlarge.js`.

#![cfg(target_arch = "wasm32")]

use js_sys::{Array, Reflect, Uint8Array};
use tracecut::Error;
use tracecut::image::{Frame, Plane};
use tracecut::mask;
use wasm_bindgen::prelude::*;

/// RGBA bytes, width and height of a PNG or JPEG file of at most `max_pixels` pixels.
#[wasm_bindgen]
pub fn decode(bytes: &[u8], max_pixels: usize) -> Result<Array, JsValue> {
    let frame = Frame::decode_within(bytes, max_pixels).map_err(|error| thrown(&error))?;
    let mut rgba = Vec::with_capacity(4 * frame.width() * frame.height());
    for pixel in frame.rgb().chunks_exact(3) {
        rgba.extend_from_slice(&[pixel[0], pixel[1], pixel[2], 255]);
    }
    Ok(Array::of3(&Uint8Array::from(rgba.as_slice()).into(), &frame.width().into(), &frame.height().into()))
}

/// Labels and opacity of a mask at the size of its picture, RGBA bytes. `labels` are of `width` columns, a divisor of their
/// number; `chosen` holds 1 for each label whose opacity is wanted.
#[wasm_bindgen]
pub fn enlarge(
    labels: Vec<u8>,
    width: usize,
    rgba: Vec<u8>,
    picture_width: usize,
    picture_height: usize,
    chosen: &[u8],
) -> Result<Array, JsValue> {
    let picture = Frame::from_rgba(&rgba, picture_width, picture_height).map_err(|error| thrown(&error))?;
    drop(rgba);
    let height = labels.len() / width.max(1);
    let mask = Plane::from_vec(width, height, labels).unwrap_or_default();
    let enlarged = mask::enlarge(&mask, &picture, |label| chosen.get(usize::from(label)) == Some(&1))
        .map_err(|error| thrown(&error))?;
    let bytes = |plane: &Plane<u8>| JsValue::from(Uint8Array::from(plane.data()));
    Ok(Array::of2(&bytes(&enlarged.labels), &bytes(&enlarged.alpha)))
}

fn thrown(error: &Error) -> JsValue {
    let value = js_sys::Error::new(&error.to_string());
    // Setting a property of a fresh, extensible object cannot fail.
    let _ = Reflect::set(&value, &"code".into(), &error.code().into());
    value.into()
}
