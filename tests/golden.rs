//! Native code gives the labels that the wasm build gave: the golden files are written by `tests/node/golden.test.mjs`, from wasm.
//!
//! Floats differ in their last bits between the two, so only labels and counts are compared exactly.

use serde_json::Value;
use std::fs;
use std::path::Path;
use tracecut::synth::Scene;
use tracecut::{Params, Session};

fn agrees(name: &str) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
    let golden: Value = serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
    let setting = |key: &str| golden["scene"][key].as_u64().unwrap();
    let frames = setting("frames") as usize;
    let scene = Scene::sample(setting("width") as usize, setting("height") as usize, frames, setting("seed"));
    let mut session = Session::new(Params::default()).unwrap();
    for t in 0..frames {
        session.push_frame(scene.frame(t)).unwrap();
    }
    session.run().unwrap();
    let (tracks, clusters) = (session.trajectories().unwrap(), session.clusters().unwrap());
    let label: Vec<u64> = clusters.label.iter().map(|&l| u64::from(l)).collect();
    let expected: Vec<u64> = golden["label"].as_array().unwrap().iter().map(|l| l.as_u64().unwrap()).collect();
    assert_eq!(label, expected, "{name}: labels of native code and of wasm differ");
    assert_eq!(tracks.x.len() as u64, golden["points"].as_u64().unwrap(), "{name}: number of points");
    let mean = tracks.x.iter().map(|&x| f64::from(x)).sum::<f64>() / tracks.x.len() as f64;
    assert!((mean - golden["meanX"].as_f64().unwrap()).abs() < 0.002, "{name}: mean x {mean}");
}

#[test]
fn the_sample_scene_has_the_labels_of_the_wasm_build() {
    agrees("golden-sample.json");
}

#[test]
fn a_scene_of_odd_size_has_the_labels_of_the_wasm_build() {
    agrees("golden-odd.json");
}
