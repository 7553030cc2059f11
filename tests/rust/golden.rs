//! Native code gives the labels and masks that the wasm build gave: the golden files are written by
//! `tests/node/golden.test.mjs`, from wasm.
//!
//! Floats may differ in their last bits between the two, so labels, masks and counts are compared exactly, sums of
//! floats roughly.

use crate::generators::sessions::fnv1a;
use serde_json::Value;
use std::fs;
use std::path::Path;
use tracecut::image::Plane;
use tracecut::mask::{ObjectRow, object_rows, object_table};
use tracecut::synth::Scene;
use tracecut::trajectory::Trajectories;
use tracecut::{Error, Params, Session, Windows};

fn agrees(name: &str) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
    let golden: Value = serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
    let setting = |key: &str| golden["scene"][key].as_u64().unwrap();
    let frames = setting("frames") as usize;
    let scene = Scene::sample((setting("width") as usize, setting("height") as usize), frames, setting("seed"));
    let mut session = Session::new(Params::default()).unwrap();
    for t in 0..frames {
        session.push_frame(scene.frame(t)).unwrap();
    }
    session.run().unwrap();
    let (tracks, clusters) = (session.trajectories().unwrap(), session.clusters().unwrap());
    let label: Vec<u64> = clusters.label.iter().map(|&l| u64::from(l)).collect();
    assert_eq!(label, numbers(&golden["label"]), "{name}: labels of native code and of wasm differ");
    assert_eq!(tracks.x.len() as u64, golden["points"].as_u64().unwrap(), "{name}: number of points");
    let mean = tracks.x.iter().map(|&x| f64::from(x)).sum::<f64>() / tracks.x.len() as f64;
    assert!((mean - golden["meanX"].as_f64().unwrap()).abs() < 0.002, "{name}: mean x {mean}");
    same_masks(&session, frames, &golden, name);
}

fn same_masks(session: &Session, frames: usize, golden: &Value, name: &str) {
    let objects = session.objects().unwrap();
    let of_cluster: Vec<u64> = objects.of_cluster.iter().map(|&l| u64::from(l)).collect();
    assert_eq!(of_cluster, numbers(&golden["objects"]), "{name}: objects of native code and of wasm differ");
    let masks: Vec<_> = (0..frames).map(|t| session.labels(t).unwrap()).collect();
    let mut area = vec![0_u64; objects.highest_label + 1];
    masks.iter().flat_map(|mask| mask.data()).for_each(|&l| area[usize::from(l)] += 1);
    assert_eq!(area, numbers(&golden["area"]), "{name}: pixels of each mask label in the clip");
    let hashes: Vec<String> = masks.iter().map(|mask| fnv1a(mask.data().iter().copied())).collect();
    assert_eq!(hashes.len(), golden["masks"].as_array().unwrap().len());
    for (t, (hash, expected)) in hashes.iter().zip(golden["masks"].as_array().unwrap()).enumerate() {
        assert_eq!(hash, expected.as_str().unwrap(), "{name}: masks of frame {t} differ");
    }
}

fn numbers(list: &Value) -> Vec<u64> {
    list.as_array().unwrap().iter().map(|n| n.as_u64().unwrap()).collect()
}

#[test]
fn the_sample_scene_has_the_labels_of_the_wasm_build() {
    agrees("golden-sample.json");
}

#[test]
fn a_scene_of_odd_size_has_the_labels_of_the_wasm_build() {
    agrees("golden-odd.json");
}

#[test]
fn windows_have_the_masks_of_the_package() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/golden-windows.json");
    let golden: Value = serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
    let number = |value: &Value, key: &str| value[key].as_u64().unwrap() as usize;
    let frames = golden["scene"]["shots"].as_array().unwrap().iter().flat_map(|shot| {
        let (width, height, frames) = (number(shot, "width"), number(shot, "height"), number(shot, "frames"));
        let scene = Scene::sample((width, height), frames, number(shot, "seed") as u64);
        (0..frames).map(move |t| Ok::<_, Error>(scene.frame(t)))
    });
    let (window, overlap) = (number(&golden["scene"], "window"), number(&golden["scene"], "overlap"));
    let mut windows = Windows::new(Params::default(), frames).unwrap().with_window(window, overlap).unwrap();
    let expected = golden["windows"].as_array().unwrap();
    for expected in expected {
        let found = windows.next_window(|_| ()).unwrap().unwrap();
        let place = [found.index, found.shot, found.first_frame, found.settled.start, found.settled.end];
        assert_eq!(place, ["index", "shot", "firstFrame", "from", "to"].map(|key| number(expected, key)));
        let masks: Vec<String> =
            found.settled.map(|t| fnv1a(windows.session().labels(t).unwrap().data().iter().copied())).collect();
        assert_eq!(&serde_json::json!(masks), &expected["masks"], "masks of window {}", found.index);
    }
    assert!(windows.next_window(|_| ()).is_none());
}

#[test]
fn a_made_clip_gives_the_table_that_the_package_gives() {
    // The package's test makes the same clip.
    let mask = |t: usize| {
        Plane::from_fn(12, 8, |x, y| {
            let block = (1 + t..5 + 2 * t).contains(&x) && (2..5).contains(&y);
            if block { 1 } else { u8::from(t != 1 && x + y > 16) * 7 }
        })
    };
    let mut tracks = Trajectories::empty(3, (12, 8));
    tracks.push(0, [(1.25, 2.0, 0.0), (2.5, 2.0625, 0.0), (4.0, 2.5, 0.0)]);
    tracks.push(0, [(4.49, 4.49, 0.0), (5.0, 4.0, 0.0)]);
    tracks.push(1, [(6.0, 4.5, 0.0), (5.75, 4.25, 0.0)]);
    tracks.push(0, [(11.5, 7.5, 0.0), (11.0, 7.0, 0.0)]);
    let rows: Vec<ObjectRow> = (0..3).flat_map(|t| object_rows(&mask(t), &tracks, t)).collect();
    let rows: Vec<ObjectRow> = rows.into_iter().map(|row| ObjectRow { doubt: Some(row.frame == 1), ..row }).collect();
    assert_eq!(object_table(&rows), include_str!("../data/objects.csv"));
}
