//! The examples, run as their first lines say.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tracecut::synth::Scene;

/// Runs the example `masks`, built as these tests are.
fn masks(input: &str, output: &Path) -> Output {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["run", "--quiet", "--example", "masks"]);
    if cfg!(feature = "cli") {
        cargo.args(["--features", "cli"]);
    }
    cargo.args(["--", input]).arg(output).output().unwrap()
}

fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    if path.exists() {
        fs::remove_dir_all(&path).unwrap();
    }
    path
}

/// The grey levels of all masks, and the number of files.
fn greys_in(folder: &Path) -> (Vec<u8>, usize) {
    let files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    let mut seen = [false; 256];
    for file in &files {
        for grey in image::open(file).unwrap().into_luma8().into_raw() {
            seen[usize::from(grey)] = true;
        }
    }
    ((0..=255).filter(|&grey| seen[usize::from(grey)]).collect(), files.len())
}

#[test]
fn masks_of_the_made_clip_show_its_three_objects() {
    let out = folder("example-made");
    let output = masks("-", &out);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(String::from_utf8_lossy(&output.stdout), "3 objects in 10 frames\n");
    assert_eq!(greys_in(&out), (vec![0, 85, 170, 255], 10));
}

#[test]
fn masks_of_a_folder_of_images_are_those_of_its_frames() {
    let (frames, out) = (folder("example-frames"), folder("example-masks"));
    fs::create_dir_all(&frames).unwrap();
    let scene = Scene::sample(256, 144, 10, 1);
    for t in 0..scene.num_frames() {
        let frame = scene.frame(t);
        let picture = image::RgbImage::from_raw(256, 144, frame.rgb().to_vec()).unwrap();
        picture.save(frames.join(format!("{t:03}.png"))).unwrap();
    }
    fs::write(frames.join("notes.txt"), "not a frame").unwrap();
    let output = masks(frames.to_str().unwrap(), &out);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(greys_in(&out), (vec![0, 85, 170, 255], 10));
}

#[test]
fn what_is_missing_is_said() {
    let output = masks("nowhere", &folder("example-none"));
    assert!(!output.status.success());
}
