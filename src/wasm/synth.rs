//! The generator of synthetic clips with true masks and flow.

use super::convert::{self, object};
use crate::synth::Scene;
use wasm_bindgen::prelude::*;

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
