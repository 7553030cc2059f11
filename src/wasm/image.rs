//! Functions of single images for JavaScript: boundary map, superpixels, flow and embedding discontinuities; and synthetic clips
//! with true masks and flow.

use super::JsSession;
use super::convert::{self, object};
use crate::contour::boundary_map;
use crate::flow::{FlowPyramid, flow_between};
use crate::image::Frame;
use crate::still::image_discontinuities;
use crate::superpixel;
use crate::synth::Scene;
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

/// The sample scene; see [`Scene::sample`].
#[wasm_bindgen(js_name = Scene)]
#[derive(Debug)]
pub struct JsScene(Scene);

#[wasm_bindgen(js_class = Scene)]
impl JsScene {
    /// Creates a clip of `frames` frames of `width` × `height` pixels; another `seed` gives other textures.
    #[wasm_bindgen(constructor)]
    pub fn new(width: usize, height: usize, frames: usize, seed: u32) -> JsScene {
        Self(Scene::sample((width, height), frames, u64::from(seed)))
    }

    /// `{data, width, height}` of frame `t`: RGBA, opaque.
    pub fn frame(&self, t: usize) -> JsValue {
        let frame = self.0.frame(t);
        object([
            ("data", convert::rgba(frame.rgb())),
            ("width", frame.width().into()),
            ("height", frame.height().into()),
        ])
    }

    /// Returns the object of each pixel of frame `t`; 0 is the background.
    pub fn mask(&self, t: usize) -> JsValue {
        convert::uint8_array(self.0.mask(t).data())
    }

    /// Returns the true motion from frame `t` to `t + 1`: `{width, height, u, v}`.
    pub fn flow(&self, t: usize) -> JsValue {
        convert::flow(&self.0.flow(t))
    }

    /// Returns the number of objects without the background.
    #[wasm_bindgen(getter, js_name = numObjects)]
    pub fn num_objects(&self) -> usize {
        self.0.num_objects()
    }
}
