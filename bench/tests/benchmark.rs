//! Our Moseg numbers against those of the benchmark's own program, where its data are at hand.
//!
//! The data are nobody's to pass on. Put them into `shared/data` beside the repository, or name another `shared` folder
//! in `TRACECUT_SHARED`; without them the test says so and passes.

use std::path::{Path, PathBuf};
use tracecut::tracks;
use tracecut_bench::measures::{definition, moseg};

fn shared_data() -> Option<PathBuf> {
    let shared = std::env::var_os("TRACECUT_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"), PathBuf::from);
    let data = shared.join("data");
    if !data.is_dir() {
        println!("skipped: no data in {}", data.display());
        return None;
    }
    Some(data)
}

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
    let Some(data) = shared_data() else { return };
    let folder = data.join("moseg_eval");
    let text = std::fs::read_to_string(folder.join("expected.json")).unwrap();
    let expected: serde_json::Map<String, serde_json::Value> = serde_json::from_str(&text).unwrap();
    assert!(!expected.is_empty());
    for (key, want) in &expected {
        let (sequence, _) = key.rsplit_once('_').unwrap();
        let got = score(&data.join("bms26").join(sequence), &folder.join(format!("{key}.dat")));
        let got = serde_json::to_value(&got).unwrap();
        for (name, want) in want.as_object().unwrap() {
            let (got, want) = (got[name].as_f64().unwrap(), want.as_f64().unwrap());
            assert!((got - want).abs() <= 1e-4 * want.abs(), "{key}: {name} is {got} (expected {want})");
        }
    }
}

#[test]
fn every_definition_and_mask_of_the_benchmark_can_be_read() {
    let Some(data) = shared_data() else { return };
    for entry in std::fs::read_dir(data.join("bms26")).unwrap() {
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
