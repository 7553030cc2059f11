//! Image files to pixels, for JavaScript; see `www/lib/decode.js`.

#![cfg(target_arch = "wasm32")]

use js_sys::{Array, Reflect, Uint8Array};
use tracecut::image::Frame;
use wasm_bindgen::prelude::*;

/// RGBA bytes, width and height of a PNG or JPEG file.
#[wasm_bindgen]
pub fn decode(bytes: &[u8]) -> Result<Array, JsValue> {
    let frame = Frame::decode(bytes).map_err(|error| {
        let value = js_sys::Error::new(&error.to_string());
        // Setting a property of a fresh, extensible object cannot fail.
        let _ = Reflect::set(&value, &"code".into(), &error.code().into());
        JsValue::from(value)
    })?;
    let mut rgba = Vec::with_capacity(4 * frame.width() * frame.height());
    for pixel in frame.rgb().chunks_exact(3) {
        rgba.extend_from_slice(&[pixel[0], pixel[1], pixel[2], 255]);
    }
    Ok(Array::of3(&Uint8Array::from(rgba.as_slice()).into(), &frame.width().into(), &frame.height().into()))
}
