//! Single images for JavaScript: boundary map and superpixels with the parameters of a session, at the image's own size.

use super::{JsSession, convert};
use crate::contour::boundary_map;
use crate::image::Frame;
use crate::superpixel;
use wasm_bindgen::prelude::*;

#[wasm_bindgen(js_class = Session)]
impl JsSession {
    /// The boundary map of an image of `width * height` RGBA pixels.
    #[wasm_bindgen(js_name = boundariesOf)]
    pub fn boundaries_of(&self, rgba: &[u8], width: usize, height: usize) -> Result<JsValue, JsValue> {
        let frame = Frame::from_rgba(rgba, width, height).map_err(|e| convert::to_js_error(&e))?;
        Ok(convert::boundaries(&boundary_map(&frame, None, &self.params_in_force().contour)))
    }

    /// The superpixels of an image given as for `boundariesOf`; at most `count` of them if there is one.
    #[wasm_bindgen(js_name = superpixelsOf)]
    pub fn superpixels_of(
        &self,
        rgba: &[u8],
        width: usize,
        height: usize,
        count: Option<usize>,
    ) -> Result<JsValue, JsValue> {
        let frame = Frame::from_rgba(rgba, width, height).map_err(|e| convert::to_js_error(&e))?;
        let params = self.params_in_force();
        Ok(convert::superpixels(&superpixel::superpixels_of(&frame, count, &params.contour, &params.superpixel)))
    }
}
