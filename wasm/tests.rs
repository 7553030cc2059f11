//! The JavaScript interface as JavaScript calls it: compiled to wasm and run in Node by `wasm-pack test --node`.

#![cfg(all(test, target_arch = "wasm32"))]

use js_sys::{Array, Object, Reflect};
use tracecut::wasm::{JsSession, parameters};
use wasm_bindgen::JsValue;
use wasm_bindgen_test::wasm_bindgen_test;

fn get(value: &JsValue, name: &str) -> JsValue {
    Reflect::get(value, &name.into()).unwrap()
}

fn number(value: &JsValue, name: &str) -> f64 {
    get(value, name).as_f64().unwrap_or_else(|| panic!("{name} is not a number"))
}

/// `{section: {name: value}}`
fn option(section: &str, name: &str, value: impl Into<JsValue>) -> JsValue {
    let (inner, outer) = (Object::new(), Object::new());
    Reflect::set(&inner, &name.into(), &value.into()).unwrap();
    Reflect::set(&outer, &section.into(), &inner).unwrap();
    outer.into()
}

fn code_and_message(error: &JsValue) -> (String, String) {
    (get(error, "code").as_string().unwrap(), get(error, "message").as_string().unwrap())
}

#[wasm_bindgen_test]
fn every_parameter_is_listed_with_a_default_in_its_range() {
    let list: Array = parameters().unwrap().into();
    assert!(list.length() > 20, "{} parameters", list.length());
    for parameter in list.iter() {
        let (min, max, default) = (number(&parameter, "min"), number(&parameter, "max"), number(&parameter, "default"));
        assert!((min..=max).contains(&default), "{:?}: {default} outside of {min}..={max}", get(&parameter, "name"));
    }
}

#[wasm_bindgen_test]
fn options_reach_the_parameters() {
    let session = JsSession::new(option("clip", "maxSide", 320)).unwrap();
    assert_eq!(number(&get(&session.params().unwrap(), "clip"), "maxSide"), 320.0);
}

#[wasm_bindgen_test]
fn a_choice_is_an_option_by_its_name() {
    let session = JsSession::new(option("connectedness", "mode", "foreground-only")).unwrap();
    let mode = get(&get(&session.params().unwrap(), "connectedness"), "mode");
    assert_eq!(mode.as_string().unwrap(), "foreground-only");
    let (code, message) = code_and_message(&JsSession::new(option("connectedness", "mode", 1)).unwrap_err());
    assert_eq!(
        (code.as_str(), message.as_str()),
        ("param", "connectedness.mode = 1 (expected one of off, paper, agents, foreground-only)")
    );
}

#[wasm_bindgen_test]
fn wrong_options_are_errors_that_say_what_is_legal() {
    let (code, message) = code_and_message(&JsSession::new(option("clip", "maxSize", 320)).unwrap_err());
    assert_eq!(code, "param");
    assert!(message.contains("clip.maxSide"), "{message}");
    let (code, message) = code_and_message(&JsSession::new(option("clip", "maxSide", "wide")).unwrap_err());
    assert_eq!(
        (code.as_str(), message.as_str()),
        ("param", "clip.maxSide = \"wide\" (expected a whole number, 16..=4096)")
    );
    assert_eq!(code_and_message(&JsSession::new(7.into()).unwrap_err()).0, "param");
}

#[wasm_bindgen_test]
fn a_frame_of_the_wrong_length_is_an_error() {
    let mut session = JsSession::new(JsValue::UNDEFINED).unwrap();
    assert_eq!(code_and_message(&session.push_rgba(&[0; 15], 2, 2).unwrap_err()).0, "frame-bytes");
}

#[wasm_bindgen_test]
fn a_small_clip_runs_to_its_end_and_gives_arrays_that_fit_together() {
    let mut session = JsSession::new(JsValue::UNDEFINED).unwrap();
    for t in 0..3 {
        let rgba: Vec<u8> =
            (0..48 * 32).flat_map(|p| [((p % 48 + t) * 37 % 251) as u8, (p / 48 * 7) as u8, 90, 255]).collect();
        session.push_rgba(&rgba, 48, 32).unwrap();
    }
    let mut stages = Vec::new();
    loop {
        let progress = session.step().unwrap();
        if progress.is_undefined() {
            break;
        }
        let stage = get(&progress, "stage").as_string().unwrap();
        // Flow and trajectories take turns; each stage counts once.
        if !stages.contains(&stage) {
            stages.push(stage);
        }
    }
    assert_eq!(
        stages,
        [
            "flow",
            "trajectories",
            "affinities",
            "embedding",
            "discontinuities",
            "saliency",
            "connectedness",
            "clusters",
            "superpixels",
            "cut",
            "masks"
        ]
    );
    let count = number(&session.trajectories(), "count") as u32;
    assert!(count > 0);
    assert_eq!(Array::from(&get(&session.clusters(), "label")).length(), count);
    assert_eq!(Array::from(&get(&session.trajectories(), "offset")).length(), count + 1);
    assert_eq!(Array::from(&get(&session.edges(), "frameOffset")).length(), 4);
    assert_eq!(number(&session.info(), "numFrames"), 3.0);
    let flow = session.flow(0).unwrap();
    assert_eq!((number(&flow, "width"), number(&flow, "height")), (48.0, 32.0));
    assert_eq!(Array::from(&session.labels(2).unwrap()).length(), 48 * 32);
    assert_eq!(code_and_message(&session.labels(3).unwrap_err()).0, "state");
    let clusters = number(&session.clusters(), "count") as u32;
    assert_eq!(Array::from(&get(&session.objects(), "ofCluster")).length(), clusters);
    let length = |table: &JsValue, name: &str| Array::from(&get(table, name)).length();
    for name in ["ofPoints", "inContext", "foreground"] {
        assert_eq!(length(&session.saliency(), name), count, "{name}");
    }
    assert_eq!(length(&session.components(), "count"), 3);
    assert_eq!(length(&session.components(), "ofPoint"), length(&session.trajectories(), "x"));
    assert_eq!(length(&session.saliency_map(2).unwrap(), "saliency"), 48 * 32);
    assert_eq!(code_and_message(&session.saliency_map(3).unwrap_err()).0, "state");
    assert_eq!(length(&session.background(2).unwrap(), "data"), 4 * 48 * 32);
    assert_eq!(code_and_message(&session.background(3).unwrap_err()).0, "state");
    partition_fits(&session.superpixels(0).unwrap(), 48, 32);
    boundaries_fit(&session.boundaries(0).unwrap(), 48, 32);
}

#[wasm_bindgen_test]
fn what_a_pixel_has_none_of_is_null_in_its_explanation() {
    let mut session = JsSession::new(JsValue::UNDEFINED).unwrap();
    assert_eq!(code_and_message(&session.explain(0, 0, 0).unwrap_err()).0, "state");
    for _ in 0..3 {
        session.push_rgba(&[90; 4 * 48 * 32], 48, 32).unwrap();
    }
    while !session.step().unwrap().is_undefined() {}
    let why = session.explain(1, 5, 5).unwrap();
    assert_eq!((number(&why, "label"), number(&why, "nearest")), (0.0, -1.0));
    assert!(get(&why, "flip").is_null() && get(&why, "border").is_null());
    assert_eq!(get(&why, "source").as_string().unwrap(), "superpixel");
    assert_eq!(code_and_message(&session.explain(1, 48, 5).unwrap_err()).0, "param");
}

fn partition_fits(superpixels: &JsValue, width: u32, height: u32) {
    assert_eq!((number(superpixels, "width"), number(superpixels, "height")), (f64::from(width), f64::from(height)));
    let label = Array::from(&get(superpixels, "label"));
    assert_eq!(label.length(), width * height);
    let count = number(superpixels, "count");
    assert!(label.iter().all(|l| l.as_f64().unwrap() < count));
    let length = |group: &str, name: &str| Array::from(&get(&get(superpixels, group), name)).length();
    for name in ["b", "length", "pb"] {
        assert_eq!(length("borders", name), length("borders", "a"), "{name}");
    }
    for name in ["y0", "x1", "y1", "kind"] {
        assert_eq!(length("edges", name), length("edges", "x0"), "{name}");
    }
}

fn boundaries_fit(map: &JsValue, width: u32, height: u32) {
    assert_eq!((number(map, "width"), number(map, "height")), (f64::from(width), f64::from(height)));
    for name in ["pb", "thin"] {
        assert_eq!(Array::from(&get(map, name)).length(), width * height, "{name}");
    }
}

#[wasm_bindgen_test]
fn single_images_have_boundaries_and_superpixels_at_their_own_size() {
    let session = JsSession::new(option("clip", "maxSide", 16)).unwrap();
    let rgba: Vec<u8> = (0..40 * 24).flat_map(|p| [if p % 40 < 20 { 30 } else { 200 }, 90, 90, 255]).collect();
    boundaries_fit(&session.boundaries_of(&rgba, 40, 24).unwrap(), 40, 24);
    partition_fits(&session.superpixels_of(&rgba, 40, 24, None).unwrap(), 40, 24);
    assert!(number(&session.superpixels_of(&rgba, 40, 24, Some(2)).unwrap(), "count") <= 2.0);
    assert_eq!(code_and_message(&session.boundaries_of(&rgba, 40, 25).unwrap_err()).0, "frame-bytes");
}
