//! Numbers against those of benchmarks, where their data are at hand.

use crate::helpers::shared;
use std::path::Path;
use tracecut::flow::{FlowParams, FlowPyramid, flow_between};
use tracecut::image::Frame;
use tracecut::tracks;
use tracecut_bench::measures::{definition, flow, moseg};

fn score(shot: &Path, track_file: &Path) -> moseg::Scores {
    let name = shot.file_name().unwrap().to_str().unwrap();
    let text = std::fs::read_to_string(shot.join(format!("{name}Def.dat"))).unwrap();
    let definition = definition::Definition::parse(&text).unwrap();
    let (tracks, clusters) = tracks::parse(&std::fs::read_to_string(track_file).unwrap()).unwrap();
    let maps: Vec<_> = definition
        .labelled_within(tracks.num_frames)
        .map(|frame| {
            let bytes = std::fs::read(shot.join(&frame.mask)).unwrap();
            definition.regions(&definition::parse_pgm(&bytes).unwrap())
        })
        .collect();
    moseg::score(&definition, &maps, &tracks, &clusters).unwrap()
}

#[test]
fn scores_agree_with_the_benchmarks_own_program() {
    let (Some(folder), Some(shots)) = (shared("moseg_eval"), shared("bms26")) else { return };
    let text = std::fs::read_to_string(folder.join("expected.json")).unwrap();
    let expected: serde_json::Map<String, serde_json::Value> = serde_json::from_str(&text).unwrap();
    assert!(!expected.is_empty());
    for (key, want) in &expected {
        let (sequence, _) = key.rsplit_once('_').unwrap();
        let got = score(&shots.join(sequence), &folder.join(format!("{key}.dat")));
        let got = serde_json::to_value(&got).unwrap();
        for (name, want) in want.as_object().unwrap() {
            let (got, want) = (got[name].as_f64().unwrap(), want.as_f64().unwrap());
            assert!((got - want).abs() <= 1e-4 * want.abs(), "{key}: {name} is {got} (expected {want})");
        }
    }
}

#[test]
fn every_definition_and_mask_of_the_benchmark_can_be_read() {
    let Some(shots) = shared("bms26") else { return };
    for entry in std::fs::read_dir(shots).unwrap() {
        let shot = entry.unwrap().path();
        let name = shot.file_name().unwrap().to_str().unwrap();
        let text = std::fs::read_to_string(shot.join(format!("{name}Def.dat"))).unwrap();
        let definition = definition::Definition::parse(&text).unwrap();
        for frame in &definition.labelled {
            let Ok(bytes) = std::fs::read(shot.join(&frame.mask)) else { continue };
            let mask = definition::parse_pgm(&bytes).unwrap();
            let named = mask.data().iter().filter(|&grey| definition.grey.contains(grey)).count();
            assert!(named * 1000 >= mask.data().len() * 999, "{name} {}: {named} pixels in named regions", frame.index);
        }
    }
}

#[test]
fn middlebury_error_stays_below_a_third_of_a_pixel() {
    let Some(folder) = shared("middlebury") else { return };
    let names = ["Dimetrodon", "Grove2", "Grove3", "Hydrangea", "RubberWhale", "Urban2", "Urban3", "Venus"];
    let error = |name: &str| {
        let read = |file: &str| std::fs::read(folder.join(name).join(file)).unwrap();
        let pyramid = |file: &str| FlowPyramid::new(&Frame::decode(&read(file)).unwrap());
        let found = flow_between(&pyramid("frame10.png"), &pyramid("frame11.png"), &FlowParams::default());
        flow::end_point_error(&found, &flow::FlowTruth::from_flo(&read("flow10.flo")).unwrap()).unwrap()
    };
    let mean = names.map(error).iter().sum::<f64>() / names.len() as f64;
    assert!(mean < 0.333, "mean end-point error {mean}");
}
