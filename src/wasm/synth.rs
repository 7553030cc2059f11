//! The scene generator: clips with known masks and known flow.

use super::convert::{self, object};
use crate::synth::Scene;
use wasm_bindgen::prelude::*;

/// The sample scene; see [`Scene::sample`].
#[wasm_bindgen(js_name = Scene)]
#[derive(Debug)]
pub struct JsScene(Scene);

#[wasm_bindgen(js_class = Scene)]
impl JsScene {
    /// A clip of `frames` frames of `width` × `height` pixels; another `seed` gives other textures.
    #[wasm_bindgen(constructor)]
    pub fn new(width: usize, height: usize, frames: usize, seed: u32) -> JsScene {
        Self(Scene::sample(width, height, frames, u64::from(seed)))
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

    /// The object that each pixel belongs to at frame `t`; 0 is the background.
    pub fn mask(&self, t: usize) -> JsValue {
        convert::bytes(self.0.mask(t).data())
    }

    /// The true motion from frame `t` to `t + 1`: `{width, height, u, v}`.
    pub fn flow(&self, t: usize) -> JsValue {
        convert::flow(&self.0.flow(t))
    }

    /// Number of objects, background not counted.
    #[wasm_bindgen(getter, js_name = numObjects)]
    pub fn num_objects(&self) -> usize {
        self.0.num_objects()
    }
}
