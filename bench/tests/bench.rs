//! The `bench` program from outside: what it prints and writes, and what it answers to folders that it cannot use.

mod davis;
mod wild;

use crate::helpers::*;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::OnceLock;
use tracecut::image::Frame;
use tracecut::{Params, Session};

fn bench<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bench")).args(arguments).output().unwrap()
}

/// Runs a command on a folder.
fn score(command: &str, folder: &Path, more: &[&str]) -> Output {
    bench([&[command, folder.to_str().unwrap()], more].concat())
}

/// What a command prints of a folder, and the file of figures that it writes.
fn scored(command: &str, folder: &Path, more: &[&str]) -> (String, serde_json::Value) {
    let file = folder.join("scores.json");
    let output = score(command, folder, &[&["--json", file.to_str().unwrap()], more].concat());
    assert_done(&output);
    (text(&output.stdout), json(&file))
}

/// Of a frame: true where a pixel has a label.
type Found = Vec<bool>;

/// What is found in the moving clip, frame by frame.
fn found() -> &'static [Found] {
    static FOUND: OnceLock<Vec<Found>> = OnceLock::new();
    FOUND.get_or_init(|| {
        let mut session = Session::new(Params::default()).unwrap();
        for t in 0..FRAMES {
            let bytes = rgb(SIZE.0, SIZE.1, &|x, y| moving(x, y, t));
            session.push_frame(Frame::from_rgb(bytes, SIZE.0 as usize, SIZE.1 as usize).unwrap()).unwrap();
        }
        session.run().unwrap();
        let of_frame = |t: i32| session.labels(t as usize).unwrap().data().iter().map(|&label| label != 0).collect();
        (0..FRAMES).map(of_frame).collect()
    })
}

/// Writes the moving clip into `frames`, and into `masks` what `truth` makes of each pixel and of whether it has a label.
fn write_clip(frames: &Path, masks: &Path, truth: &dyn Fn(usize, bool) -> u8) {
    fs::create_dir_all(frames).unwrap();
    fs::create_dir_all(masks).unwrap();
    for (t, found) in (0..FRAMES).zip(found()) {
        png(&frames.join(format!("{t:05}.png")), SIZE.0, SIZE.1, &|x, y| moving(x, y, t));
        let at = |x: i32, y: i32| (y * SIZE.0 as i32 + x) as usize;
        png(&masks.join(format!("{t:05}.png")), SIZE.0, SIZE.1, &|x, y| truth(at(x, y), found[at(x, y)]));
    }
}

/// The words of the row that begins with `name`.
fn row<'a>(table: &'a str, name: &str) -> Vec<&'a str> {
    let line = table.lines().find(|l| l.starts_with(name)).unwrap_or_else(|| panic!("no row {name}: {table}"));
    line.split_whitespace().collect()
}

/// A shot in the layout of the Moseg benchmark: the moving clip with frames 0 and 9 labelled.
fn write_shot(root: &Path) {
    let shot = root.join("toy");
    fs::create_dir_all(&shot).unwrap();
    clip(&shot, FRAMES, SIZE, &moving);
    let names: String = (0..FRAMES).map(|t| format!("f{t}.ppm\n")).collect();
    fs::write(shot.join("toy.bmf"), format!("{FRAMES} 1\n{names}")).unwrap();
    let mut definition = "Total number of regions:\n2\nScale of region 0:\n0\nScale of region 1:\n255\n\
        Confusion penality matrix:\n0 1\n1 0\nTotal number of frames in this shot:\n10\n\
        Total number of labeled frames for this shot:\n2\n"
        .to_owned();
    for t in [0, 9] {
        definition += &format!("Frame number:\n{t}\nFile name:\nm{t}.pgm\nInput file name:\nf{t}.ppm\n");
        let mut mask = format!("P5\r\n{} {}\r\n255\r\n", SIZE.0, SIZE.1).into_bytes();
        mask.extend(rgb(SIZE.0, SIZE.1, &|x, y| if on_object(x, y, t) { 255 } else { 0 }).iter().step_by(3));
        fs::write(shot.join(format!("m{t}.pgm")), mask).unwrap();
    }
    fs::write(shot.join("toyDef.dat"), definition).unwrap();
}

#[test]
fn a_folder_of_shots_is_run_and_scored() {
    let root = folder("shots");
    write_shot(&root);
    let (table, report) = scored("moseg", &root, &[]);
    assert!(table.lines().any(|l| l.starts_with("toy ")) && table.contains("\ntrimmed mean"), "{table}");
    let scores = &report["sequences"][0];
    assert!(report["pixels"].is_null() && scores["pixels"].is_null(), "{report}");
    assert_eq!((&scores["name"], &scores["frames"], &scores["labeled"]), (&"toy".into(), &10.into(), &2.0.into()));
    assert_eq!(scores["overall"], report["mean"]["overall"]);
    assert!(scores["overall"].as_f64().unwrap() < 5.0, "{scores}");
    // One rigid object in one piece: connectedness changes nothing, and can be left out.
    let without = &scores["withoutConnectedness"];
    assert_eq!((&without["overall"], without), (&scores["overall"], &report["withoutConnectedness"]["mean"]));
    assert!(table.contains("\ntrimmed mean, without ") && !table.contains("    without"), "{table}");
    let (table, off) = scored("moseg", &root, &["--set", "connectedness.mode=off"]);
    assert!(off["withoutConnectedness"].is_null() && !table.contains("without"));

    let (table, dense) = scored("moseg", &root, &["--dense"]);
    assert!(table.contains("\npixels by mask label, trimmed mean"), "{table}");
    // Masks leave the trajectories as they are, and label every pixel.
    assert_eq!((&dense["sequences"][0]["overall"], &dense["mean"]), (&scores["overall"], &report["mean"]));
    for way in ["pixels", "masks"] {
        let (pixels, mean) = (&dense["sequences"][0][way], &dense[way]["mean"]);
        assert_eq!((&pixels["density"], pixels), (&100.0.into(), mean), "{way}");
        assert!(pixels["overall"].as_f64().unwrap() < 10.0, "{way}: {pixels}");
    }

    // The true regions are mirrored too; and frame 9 is frame 4 of the second start.
    let runs = |more: &[&str]| scored("points", &root, more).1["clips"][0]["runs"].as_array().unwrap().clone();
    assert!(runs(&["--mirror"]).iter().all(|run| run["error"].as_f64().unwrap() < 5.0));
    let starts = runs(&["--frames", "5", "--starts", "2"]);
    assert!(starts.iter().all(|run| run["trueObjects"] == 1.0 && run["error"].is_f64()), "{starts:?}");
    assert_eq!(starts.iter().map(|run| run["start"].as_u64().unwrap()).collect::<Vec<_>>(), [0, 5]);

    assert_refused(&score("moseg", &folder("no-shots"), &[]), 3, &["holds no sequence"]);
    fs::remove_file(root.join("toy/m9.pgm")).unwrap();
    assert_refused(&score("moseg", &root, &[]), 1, &["toy", "m9.pgm"]);
}

#[test]
fn flow_is_measured_against_a_flo_file() {
    let root = folder("flow");
    let pair = root.join("shift");
    fs::create_dir_all(&pair).unwrap();
    for (name, shift) in [("frame10.png", 0), ("frame11.png", 2)] {
        png(&pair.join(name), 64, 48, &|x, y| texture(x - shift, y, 9));
    }
    let mut truth = 202_021.25_f32.to_le_bytes().to_vec();
    truth.extend([64_i32, 48].iter().flat_map(|n| n.to_le_bytes()));
    truth.extend((0..64 * 48).flat_map(|_| [2.0_f32, 0.0]).flat_map(f32::to_le_bytes));
    fs::write(pair.join("flow10.flo"), &truth).unwrap();
    let output = score("flow", &root, &[]);
    assert_done(&output);
    let table = text(&output.stdout);
    let mean = table.lines().find(|l| l.starts_with("mean of 1")).unwrap();
    let error: f64 = mean.split_whitespace().nth(3).unwrap().parse().unwrap();
    assert!(error < 0.1, "{table}");
    fs::write(pair.join("flow10.flo"), &truth[..100]).unwrap();
    assert_refused(&score("flow", &root, &[]), 3, &["flow10.flo"]);
}
