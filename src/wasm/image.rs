//! Functions of single images for JavaScript: boundary map, superpixels, flow and embedding discontinuities.

use super::{JsSession, convert};
use crate::contour::boundary_map;
use crate::flow::{FlowPyramid, flow_between};
use crate::image::Frame;
use crate::still::image_discontinuities;
use crate::superpixel;
use wasm_bindgen::prelude::*;

impl JsSession {
    /// Returns an image within the limits of the parameters.
    fn image(&self, rgba: &[u8], width: usize, height: usize) -> Result<Frame, JsValue> {
        let frame = Frame::from_rgba(rgba, width, height);
        let allowed = frame.and_then(|f| self.params_in_force().clip.check_pixels(width, height).map(|()| f));
        allowed.map_err(|e| convert::to_js_error(&e))
    }
}

#[wasm_bindgen(js_class = Session)]
impl JsSession {
    /// Computes the boundary map of an image of `width * height` RGBA pixels.
    #[wasm_bindgen(js_name = boundariesOf)]
    pub fn boundaries_of(&self, rgba: &[u8], width: usize, height: usize) -> Result<JsValue, JsValue> {
        let frame = self.image(rgba, width, height)?;
        Ok(convert::boundaries(&boundary_map(&frame)))
    }

    /// Computes the discontinuities of the pixel embedding of an image given as for `boundariesOf`.
    #[wasm_bindgen(js_name = discontinuitiesOf)]
    pub fn discontinuities_of(&self, rgba: &[u8], width: usize, height: usize) -> Result<JsValue, JsValue> {
        let frame = self.image(rgba, width, height)?;
        let params = self.params_in_force();
        let discontinuities = image_discontinuities(&frame, &params.still, params.clip.seed);
        Ok(convert::image_discontinuities(&discontinuities, (frame.width(), frame.height())))
    }

    /// Computes the flow between two images of `width * height` RGBA pixels, at their own size: `{width, height, u, v}`.
    #[wasm_bindgen(js_name = flowOf)]
    pub fn flow_of(&self, from: &[u8], to: &[u8], width: usize, height: usize) -> Result<JsValue, JsValue> {
        let params = &self.params_in_force().flow;
        let pyramid = |rgba: &[u8]| self.image(rgba, width, height).map(|f| FlowPyramid::new(&f));
        let (from, to) = (pyramid(from)?, pyramid(to)?);
        Ok(convert::flow(&flow_between(&from, &to, params)))
    }

    /// Computes the superpixels of an image given as for `boundariesOf`, at most `count` of them if it is set.
    #[wasm_bindgen(js_name = superpixelsOf)]
    pub fn superpixels_of(
        &self,
        rgba: &[u8],
        width: usize,
        height: usize,
        count: Option<usize>,
    ) -> Result<JsValue, JsValue> {
        let frame = self.image(rgba, width, height)?;
        let params = self.params_in_force();
        Ok(convert::superpixels(&superpixel::superpixels_of(&frame, count, &params.contour, &params.superpixel)))
    }
}
