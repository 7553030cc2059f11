//! Between JavaScript values and the core's types.

use crate::Error;
use crate::discretize::Clusters;
use crate::flow::FlowField;
use crate::params::ParamTree;
use crate::trajectory::Trajectories;
use js_sys::{Float32Array, Float64Array, Object, Reflect, Uint8Array, Uint8ClampedArray, Uint32Array};
use serde::Serialize;
use wasm_bindgen::prelude::*;

/// A JavaScript `Error` with the message of `error` and its code in the property `code`.
pub(super) fn to_js_error(error: &Error) -> JsValue {
    let value = js_sys::Error::new(&error.to_string());
    // Setting a property of a fresh, extensible object cannot fail.
    let _ = Reflect::set(&value, &"code".into(), &error.code().into());
    value.into()
}

/// Small values only: numbers, texts and lists of plain objects.
pub(super) fn to_js(value: &impl Serialize) -> Result<JsValue, JsValue> {
    Ok(serde_wasm_bindgen::to_value(value)?)
}

/// The option object as a tree of names and values.
pub(super) fn to_param_tree(options: JsValue) -> Result<ParamTree, Error> {
    if options.is_undefined() {
        return Ok(ParamTree::default());
    }
    serde_wasm_bindgen::from_value(options).map_err(|e| Error::Param {
        name: "options".to_owned(),
        value: e.to_string(),
        expected: "an object such as {flow: {patchStride: 5}}".to_owned(),
    })
}

/// A plain object with these properties.
pub(super) fn object<const N: usize>(properties: [(&str, JsValue); N]) -> JsValue {
    let object = Object::new();
    for (name, value) in properties {
        // Setting a property of a fresh, extensible object cannot fail.
        let _ = Reflect::set(&object, &name.into(), &value);
    }
    object.into()
}

pub(super) fn bytes(values: &[u8]) -> JsValue {
    Uint8Array::from(values).into()
}

pub(super) fn clusters(clusters: &Clusters) -> JsValue {
    object([("count", clusters.count.into()), ("label", words(&clusters.label))])
}

/// Three bytes a pixel inside, four outside, as `ImageData` wants them.
pub(super) fn rgba(rgb: &[u8]) -> JsValue {
    let rgba: Vec<u8> = rgb.chunks_exact(3).flat_map(|p| [p[0], p[1], p[2], 255]).collect();
    Uint8ClampedArray::from(rgba.as_slice()).into()
}

pub(super) fn words(values: &[u32]) -> JsValue {
    Uint32Array::from(values).into()
}

pub(super) fn floats(values: &[f32]) -> JsValue {
    Float32Array::from(values).into()
}

pub(super) fn doubles(values: &[f64]) -> JsValue {
    Float64Array::from(values).into()
}

/// Double precision inside, single precision outside: halves what crosses to the page.
pub(super) fn narrowed(values: &[f64]) -> JsValue {
    floats(&values.iter().map(|&v| v as f32).collect::<Vec<_>>())
}

/// `{width, height, u, v}`.
pub(super) fn flow(field: &FlowField) -> JsValue {
    object([
        ("width", field.u.width().into()),
        ("height", field.u.height().into()),
        ("u", floats(field.u.data())),
        ("v", floats(field.v.data())),
    ])
}

/// `{count, startFrame, offset, x, y}`.
pub(super) fn trajectories(t: &Trajectories) -> JsValue {
    object([
        ("count", t.len().into()),
        ("startFrame", words(&t.start_frame)),
        ("offset", words(&t.offset)),
        ("x", floats(&t.x)),
        ("y", floats(&t.y)),
    ])
}
