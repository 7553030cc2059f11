//! Conversion between JavaScript values and the types of the core.

use crate::connectedness::Components;
use crate::contour::BoundaryMap;
use crate::discretize::Clusters;
use crate::flow::FlowField;
use crate::image::Plane;
use crate::mask::{Agreement, Objects};
use crate::params::ParamValue;
use crate::saliency::Saliency;
use crate::still::ImageDiscontinuities;
use crate::superpixel::{Edge, EdgeKind, SuperpixelBorder, Superpixels};
use crate::trajectory::Trajectories;
use crate::{Error, Params};
use js_sys::{
    Array, Float32Array, Float64Array, Int32Array, Object, Reflect, Uint8Array, Uint8ClampedArray, Uint32Array,
};
use serde::Serialize;
use serde_wasm_bindgen::Serializer;
use std::collections::BTreeMap;
use std::ops::Range;
use wasm_bindgen::prelude::*;

/// Returns a JavaScript `Error` with the message of `error` and its code in the property `code`.
pub(super) fn to_js_error(error: &Error) -> JsValue {
    let value = js_sys::Error::new(&error.to_string());
    // Setting a property of a fresh, extensible object cannot fail.
    let _ = Reflect::set(&value, &"code".into(), &error.code().into());
    value.into()
}

/// Converts small values: numbers, strings and lists of plain objects; `None` becomes `null`.
pub(super) fn to_js(value: &impl Serialize) -> Result<JsValue, JsValue> {
    Ok(value.serialize(&Serializer::new().serialize_missing_as_null(true))?)
}

/// Returns the default parameters changed by a tree of options such as `{flow: {patchStride: 5}}`.
pub(super) fn to_params(options: JsValue) -> Result<Params, Error> {
    let mut params = Params::default();
    if !options.is_undefined() {
        params.apply(&tree(&options).ok_or_else(|| Error::Param {
            name: "options".to_owned(),
            value: "something else".to_owned(),
            expected: "an object such as {flow: {patchStride: 5}}".to_owned(),
        })?)?;
    }
    Ok(params)
}

/// Reads the properties of an object and of the objects in it. Written by hand, since `serde` would add several KiB to the wasm file.
fn tree(value: &JsValue) -> Option<BTreeMap<String, ParamValue>> {
    let object = value.dyn_ref::<Object>().filter(|_| !Array::is_array(value))?;
    let list = Object::entries(object);
    let entries = list.iter().map(|entry| {
        let entry: Array = entry.into();
        let value = entry.get(1);
        let parsed = if let Some(text) = value.as_string() {
            ParamValue::Text(text)
        } else if let Some(number) = value.as_f64() {
            ParamValue::Number(number)
        } else if let Some(truth) = value.as_bool() {
            ParamValue::Bool(truth)
        } else {
            tree(&value).map_or(ParamValue::Null, ParamValue::Section)
        };
        (entry.get(0).as_string().unwrap_or_default(), parsed)
    });
    Some(entries.collect())
}

/// Returns a plain object with these properties.
pub(super) fn object<const N: usize>(properties: [(&str, JsValue); N]) -> JsValue {
    let object = Object::new();
    for (name, value) in properties {
        // Setting a property of a fresh, extensible object cannot fail.
        let _ = Reflect::set(&object, &name.into(), &value);
    }
    object.into()
}

pub(super) fn uint8_array(values: &[u8]) -> JsValue {
    Uint8Array::from(values).into()
}

pub(super) fn clusters(clusters: &Clusters) -> JsValue {
    object([("count", clusters.count.into()), ("label", uint32_array(&clusters.label))])
}

/// Converts RGB to RGBA bytes, as `ImageData` has them.
pub(super) fn rgba(rgb: &[u8]) -> JsValue {
    let rgba: Vec<u8> = rgb.chunks_exact(3).flat_map(|p| [p[0], p[1], p[2], 255]).collect();
    Uint8ClampedArray::from(rgba.as_slice()).into()
}

/// `{width, height, data}`, as `ImageData` has them.
pub(super) fn picture(plane: &Plane<[u8; 4]>) -> JsValue {
    let data = Uint8ClampedArray::from(plane.data().as_flattened());
    object([("width", plane.width().into()), ("height", plane.height().into()), ("data", data.into())])
}

pub(super) fn uint32_array(values: &[u32]) -> JsValue {
    Uint32Array::from(values).into()
}

pub(super) fn float32_array(values: &[f32]) -> JsValue {
    Float32Array::from(values).into()
}

pub(super) fn float64_array(values: &[f64]) -> JsValue {
    Float64Array::from(values).into()
}

/// Converts to single precision, which halves the data that crosses to the page.
pub(super) fn single_precision(values: &[f64]) -> JsValue {
    float32_array(&values.iter().map(|&v| v as f32).collect::<Vec<_>>())
}

/// `{width, height, u, v}`.
pub(super) fn flow(field: &FlowField) -> JsValue {
    object([
        ("width", field.u.width().into()),
        ("height", field.u.height().into()),
        ("u", float32_array(field.u.data())),
        ("v", float32_array(field.v.data())),
    ])
}

/// `{count, startFrame, offset, x, y, id}`.
pub(super) fn trajectories(t: &Trajectories, numbers: &[u32]) -> JsValue {
    object([
        ("count", t.len().into()),
        ("startFrame", uint32_array(&t.start_frame)),
        ("offset", uint32_array(&t.offset)),
        ("x", float32_array(&t.x)),
        ("y", float32_array(&t.y)),
        ("id", uint32_array(numbers)),
    ])
}

/// `{count, ofCluster, labels, doubts}`.
pub(super) fn objects(o: &Objects, doubts: JsValue) -> JsValue {
    object([
        ("count", o.highest_label.into()),
        ("ofCluster", uint8_array(&o.of_cluster)),
        ("labels", uint8_array(&o.labels())),
        ("doubts", doubts),
    ])
}

/// Returns the size of the instance's linear memory in bytes.
pub(super) fn memory_bytes() -> u32 {
    let memory: js_sys::WebAssembly::Memory = wasm_bindgen::memory().unchecked_into();
    js_sys::ArrayBuffer::from(memory.buffer()).byte_length()
}

/// `{width, height, pb, thin}`.
pub(super) fn boundaries(map: &BoundaryMap) -> JsValue {
    object([
        ("width", map.pb.width().into()),
        ("height", map.pb.height().into()),
        ("pb", float32_array(map.pb.data())),
        ("thin", float32_array(map.thin.data())),
    ])
}

/// `{width, height, saliency}`.
pub(super) fn saliency_map(map: &Plane<f32>) -> JsValue {
    object([("width", map.width().into()), ("height", map.height().into()), ("saliency", float32_array(map.data()))])
}

/// `{clip, frames, objects, mergeLogOdds}`; NaN stands for `None`.
pub(super) fn agreement(agreement: &Agreement) -> JsValue {
    let list = |values: &[Option<f32>]| {
        float32_array(&values.iter().map(|value| value.unwrap_or(f32::NAN)).collect::<Vec<_>>())
    };
    let objects: js_sys::Array = agreement.objects.iter().map(|frames| list(frames)).collect();
    object([
        ("clip", agreement.clip.unwrap_or(f32::NAN).into()),
        ("frames", list(&agreement.frames)),
        ("objects", objects.into()),
        ("mergeLogOdds", agreement.merge_log_odds.unwrap_or(f64::NAN).into()),
    ])
}

/// A list of `{from, to}`.
pub(super) fn doubts(agreement: &Agreement) -> JsValue {
    let range = |doubt: Range<usize>| object([("from", doubt.start.into()), ("to", doubt.end.into())]);
    agreement.doubts().into_iter().map(range).collect::<Array>().into()
}

/// `{ofPoints, inContext, foreground}`; truth values as 0 and 1.
pub(super) fn saliency(s: &Saliency) -> JsValue {
    let foreground: Vec<u8> = s.foreground.iter().map(|&f| u8::from(f)).collect();
    object([
        ("ofPoints", float32_array(&s.of_points)),
        ("inContext", float32_array(&s.in_context)),
        ("foreground", uint8_array(&foreground)),
    ])
}

/// `{count, ofPoint}`; -1 stands for none.
pub(super) fn components(c: &Components) -> JsValue {
    let number = |component: &Option<u32>| component.map_or(-1, |number| number as i32);
    let of_point: Vec<i32> = c.of_point.iter().map(number).collect();
    object([("count", uint32_array(&c.count)), ("ofPoint", Int32Array::from(of_point.as_slice()).into())])
}

/// `{width, height, scaleX, scaleY, pb, discontinuity, spectral, combined}` of an image of `input` pixels.
pub(super) fn image_discontinuities(image: &ImageDiscontinuities, input: (usize, usize)) -> JsValue {
    let (width, height) = (image.pb.pb.width(), image.pb.pb.height());
    object([
        ("width", width.into()),
        ("height", height.into()),
        ("scaleX", (input.0 as f64 / width as f64).into()),
        ("scaleY", (input.1 as f64 / height as f64).into()),
        ("pb", float32_array(image.pb.pb.data())),
        ("discontinuity", float32_array(image.d.strength.data())),
        ("spectral", float32_array(image.spectral.strength.data())),
        ("combined", float32_array(image.combined.pb.data())),
    ])
}

/// `{width, height, count, label, borders: {a, b, length, pb}, edges: {x0, y0, x1, y1, kind}}`.
pub(super) fn superpixels(s: &Superpixels) -> JsValue {
    let label = s.label();
    object([
        ("width", label.width().into()),
        ("height", label.height().into()),
        ("count", s.count.into()),
        ("label", uint32_array(label.data())),
        ("borders", borders(&s.borders)),
        ("edges", edges(&s.edges)),
    ])
}

fn borders(list: &[SuperpixelBorder]) -> JsValue {
    let column = |field: fn(&SuperpixelBorder) -> f32| float32_array(&list.iter().map(field).collect::<Vec<_>>());
    let side = |field: fn(&SuperpixelBorder) -> u32| uint32_array(&list.iter().map(field).collect::<Vec<_>>());
    object([("a", side(|b| b.a)), ("b", side(|b| b.b)), ("length", column(|b| b.length)), ("pb", column(|b| b.pb))])
}

fn edges(list: &[Edge]) -> JsValue {
    let column = |field: fn(&Edge) -> f32| float32_array(&list.iter().map(field).collect::<Vec<_>>());
    object([
        ("x0", column(|e| e.from.0)),
        ("y0", column(|e| e.from.1)),
        ("x1", column(|e| e.to.0)),
        ("y1", column(|e| e.to.1)),
        ("kind", uint8_array(&list.iter().map(|e| kind_number(e.kind)).collect::<Vec<_>>())),
    ])
}

/// Returns the numbers of `EdgeKind` in `npm/stages/image.ts`.
fn kind_number(kind: EdgeKind) -> u8 {
    match kind {
        EdgeKind::Constraint => 0,
        EdgeKind::Frame => 1,
        EdgeKind::Gabriel => 2,
        EdgeKind::Deleted => 3,
    }
}
