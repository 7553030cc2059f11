//! The `tracecut` program from outside: what it writes, and what it answers to input that it cannot use.

mod clusters;
mod davis;
mod faults;
mod files;
mod images;
mod masks;
mod selftest;
mod wild;

use image::{ExtendedColorType, ImageEncoder};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tracecut::tracks;

/// An empty folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    if path.exists() {
        fs::remove_dir_all(&path).unwrap();
    }
    fs::create_dir_all(&path).unwrap();
    path
}

fn tracecut<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tracecut")).args(arguments).output().unwrap()
}

fn segment(input: &Path, out: &Path, more: &[&str]) -> Output {
    let mut arguments = vec!["segment", input.to_str().unwrap(), "--out", out.to_str().unwrap()];
    arguments.extend(more);
    tracecut(arguments)
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Fails the test unless the program ended with `code` and named each of `words` after `error: `.
fn assert_refused(output: &Output, code: i32, words: &[&str]) {
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{message}");
    assert!(message.starts_with("error: ") && !message.contains("panicked"), "{message}");
    for word in words {
        assert!(message.contains(word), "\"{word}\" is missing: {message}");
    }
}

/// What is in a folder, by name.
fn names_in(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

fn assert_done(output: &Output) {
    assert!(output.status.success(), "{}", text(&output.stderr));
}

/// A grey value for each pixel of a frame.
type Picture<'a> = &'a dyn Fn(i32, i32) -> u8;

fn rgb(width: u32, height: u32, picture: Picture) -> Vec<u8> {
    let pixel = |i: u32| picture((i % width) as i32, (i / width) as i32);
    (0..width * height).flat_map(|i| [pixel(i); 3]).collect()
}

fn png(path: &Path, width: u32, height: u32, picture: Picture) {
    let encoder = image::codecs::png::PngEncoder::new(fs::File::create(path).unwrap());
    encoder.write_image(&rgb(width, height, picture), width, height, ExtendedColorType::Rgb8).unwrap();
}

fn clip(folder: &Path, frames: i32, (width, height): (u32, u32), picture: &dyn Fn(i32, i32, i32) -> u8) {
    for t in 0..frames {
        png(&folder.join(format!("f{t}.png")), width, height, &|x, y| picture(x, y, t));
    }
}

/// Smooth noise: bilinear between random values on a grid of 4 pixels.
fn texture(x: i32, y: i32, seed: u64) -> u8 {
    let value = |x: i32, y: i32| f64::from(tracecut::rng::mix(seed ^ ((x as u64) << 32) ^ u64::from(y as u32)) as u8);
    let (i, j) = (x.div_euclid(4), y.div_euclid(4));
    let (a, b) = (f64::from(x.rem_euclid(4)) / 4.0, f64::from(y.rem_euclid(4)) / 4.0);
    let row = |j: i32| (1.0 - a) * value(i, j) + a * value(i + 1, j);
    ((1.0 - b) * row(j) + b * row(j + 1)) as u8
}

const SIZE: (u32, u32) = (128, 96);
const FRAMES: i32 = 10;

/// Whether pixel `(x, y)` of frame `t` belongs to the object: 48 x 40 pixels that go right by two a frame.
fn on_object(x: i32, y: i32, t: i32) -> bool {
    (20 + 2 * t..68 + 2 * t).contains(&x) && (28..68).contains(&y)
}

/// A textured object in front of a background that goes left by one pixel a frame.
fn moving(x: i32, y: i32, t: i32) -> u8 {
    if on_object(x, y, t) { texture(x - 2 * t, y, 1) } else { texture(x + t, y, 2) }
}

/// Header of a Y4M stream, and its frames of brightness only.
fn y4m(frames: i32) -> Vec<u8> {
    let mut bytes = format!("YUV4MPEG2 W{} H{} F25:1 Cmono XCOLORRANGE=FULL\n", SIZE.0, SIZE.1).into_bytes();
    for t in 0..frames {
        bytes.extend(b"FRAME\n");
        bytes.extend(rgb(SIZE.0, SIZE.1, &|x, y| moving(x, y, t)).iter().step_by(3));
    }
    bytes
}

#[test]
fn a_moving_clip_gives_tracks_pictures_and_a_report() {
    let (input, out) = (folder("moving-in"), folder("moving-out"));
    clip(&input, FRAMES, SIZE, &moving);
    fs::write(input.join("notes.txt"), "not an image").unwrap();
    let options = ["--track-step", "6", "--set", "clip.seed=3", "--format", "png,tracks,overlay"];
    assert_done(&segment(&input, &out, &options));

    let (trajectories, clusters) = tracks::parse(&fs::read_to_string(out.join("tracks.dat")).unwrap()).unwrap();
    assert_eq!(trajectories.num_frames, FRAMES as usize);
    assert!(trajectories.len() > 100, "{} trajectories", trajectories.len());

    let report = json(&out.join("result.json"));
    assert_eq!(report["width"], SIZE.0);
    assert_eq!(report["frames"], FRAMES);
    assert_eq!(report["trajectories"], trajectories.len());
    assert_eq!(report["clusters"], clusters.count);
    assert_eq!(report["labels"].as_array().unwrap().len(), clusters.count);
    assert_eq!(report["params"]["trajectory"]["gridStep"], 6.0);
    assert_eq!(report["params"]["clip"]["seed"], 3);
    for stage in ["read", "flow", "trajectories", "affinities", "embedding", "discontinuities", "clusters", "total"] {
        assert!(report["seconds"][stage].as_f64().is_some(), "{stage}: {}", report["seconds"]);
    }

    let picture = image::open(out.join("overlay/00000.png")).unwrap();
    assert_eq!((picture.width(), picture.height()), SIZE);
    assert_eq!(fs::read_dir(out.join("overlay")).unwrap().count(), FRAMES as usize);
}

#[test]
fn object_and_background_get_labels_of_their_own() {
    let (input, out) = (folder("labels-in"), folder("labels-out"));
    clip(&input, FRAMES, SIZE, &moving);
    assert_done(&segment(&input, &out, &["--track-step", "4"]));
    let (trajectories, clusters) = tracks::parse(&fs::read_to_string(out.join("tracks.dat")).unwrap()).unwrap();
    // votes[label] = points on (background, object)
    let mut votes = vec![(0, 0); clusters.count];
    for t in 0..FRAMES {
        for (i, x, y) in trajectories.alive(t as usize) {
            let vote = &mut votes[clusters.label[i] as usize];
            if on_object(x.round() as i32, y.round() as i32, t) { vote.1 += 1 } else { vote.0 += 1 }
        }
    }
    let wrong: usize = votes.iter().map(|v| v.0.min(v.1)).sum();
    let all: usize = votes.iter().map(|v| v.0 + v.1).sum();
    assert!(votes.iter().any(|v| v.1 > v.0) && wrong * 20 < all, "background and object points by label: {votes:?}");
}

#[test]
fn folder_list_gif_file_and_pipe_agree_and_a_second_run_repeats_the_first() {
    let input = folder("formats-in");
    let run = |name: &str, from: &Path| {
        let out = folder(&format!("formats-{name}"));
        assert_done(&segment(from, &out, &["--frames", "8"]));
        fs::read(out.join("tracks.dat")).unwrap()
    };
    clip(&input, FRAMES, SIZE, &moving);
    let expected = run("folder", &input);
    assert_eq!(run("again", &input), expected);

    let names: String = (0..FRAMES).map(|t| format!("f{t}.ppm\n")).collect();
    fs::write(input.join("clip.bmf"), format!("{FRAMES} 1\n{names}")).unwrap();
    assert_eq!(run("list", &input.join("clip.bmf")), expected);

    fs::write(input.join("clip.y4m"), y4m(FRAMES)).unwrap();
    assert_eq!(run("y4m", &input.join("clip.y4m")), expected);

    // 256 greys fit into a GIF's palette: nothing is lost.
    let mut encoder = image::codecs::gif::GifEncoder::new(fs::File::create(input.join("clip.gif")).unwrap());
    for t in 0..FRAMES {
        encoder.encode(&rgb(SIZE.0, SIZE.1, &|x, y| moving(x, y, t)), SIZE.0, SIZE.1, ExtendedColorType::Rgb8).unwrap();
    }
    drop(encoder);
    assert_eq!(run("gif", &input.join("clip.gif")), expected);
}

#[test]
fn standard_input_gives_what_the_file_gives_and_leaves_no_copy() {
    let (input, from_file, from_pipe) = (folder("pipe-in"), folder("pipe-file"), folder("pipe-out"));
    fs::write(input.join("clip.y4m"), y4m(8)).unwrap();
    assert_done(&segment(&input.join("clip.y4m"), &from_file, &["--format", "png,tracks,overlay"]));
    let mut child = Command::new(env!("CARGO_BIN_EXE_tracecut"))
        .args(["segment", "-", "--format", "png,tracks,overlay", "--out", from_pipe.to_str().unwrap()])
        .stdin(Stdio::piped())
        .stderr(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(&y4m(8)).unwrap();
    assert_done(&child.wait_with_output().unwrap());
    for file in ["tracks.dat", "masks/00007.png", "overlay/00007.png", "overlay-masks/00007.png"] {
        assert_eq!(fs::read(from_pipe.join(file)).unwrap(), fs::read(from_file.join(file)).unwrap(), "{file}");
    }
    assert_eq!(names_in(&from_pipe), ["masks", "objects.csv", "overlay", "overlay-masks", "result.json", "tracks.dat"]);
}

#[test]
fn missing_and_empty_folders_are_refused() {
    let (input, out) = (folder("empty-in"), folder("empty-out"));
    assert_refused(&segment(&input, &out, &[]), 3, &["holds no images"]);
    fs::write(input.join("masks.pgm"), "P5").unwrap();
    assert_refused(&segment(&input, &out, &[]), 3, &["holds no images"]);
    assert_refused(&segment(&input.join("nowhere"), &out, &[]), 3, &["nowhere", "cannot be read"]);
    fs::write(input.join("film.mp4"), [0; 64]).unwrap();
    assert_refused(&segment(&input.join("film.mp4"), &out, &[]), 3, &["film.mp4", "ffmpeg"]);
}

#[test]
fn one_frame_is_refused_and_two_are_enough() {
    let (input, out) = (folder("few-in"), folder("few-out"));
    clip(&input, 2, SIZE, &moving);
    assert_refused(&segment(&input, &out, &["--frames", "1"]), 3, &["1 frame(s) given", "at least 2"]);
    assert_done(&segment(&input, &out, &[]));
    let (trajectories, _) = tracks::parse(&fs::read_to_string(out.join("tracks.dat")).unwrap()).unwrap();
    assert_eq!(trajectories.num_frames, 2);
}

#[test]
fn a_frame_of_another_size_is_named() {
    let (input, out) = (folder("sizes-in"), folder("sizes-out"));
    clip(&input, 4, SIZE, &moving);
    png(&input.join("f3.png"), 100, 96, &|x, y| moving(x, y, 3));
    assert_refused(&segment(&input, &out, &[]), 3, &["f3.png", "100x96", "128x96"]);
}

#[test]
fn tiny_black_and_still_clips_end_in_a_result() {
    for (name, size, picture) in [
        ("1x1", (1, 1), &moving as &dyn Fn(i32, i32, i32) -> u8),
        ("17x3", (17, 3), &moving),
        ("black", (64, 48), &|_, _, _| 0),
        ("still", SIZE, &|x, y, _| texture(x, y, 5)),
    ] {
        let (input, out) = (folder(&format!("{name}-in")), folder(&format!("{name}-out")));
        clip(&input, 8, size, picture);
        // Of a pixel or two, any change is a cut.
        let options = ["--dump", "--format", "png,tracks,overlay", "--set", "shot.unmatched=1"];
        assert_done(&segment(&input, &out, &options));
        let (trajectories, clusters) = tracks::parse(&fs::read_to_string(out.join("tracks.dat")).unwrap()).unwrap();
        assert_eq!(trajectories.num_frames, 8, "{name}");
        assert!(clusters.count <= 1, "{name}: {} clusters", clusters.count);
        assert!(out.join("overlay/00007.png").is_file(), "{name}");
    }
}

#[test]
fn truncated_files_are_named_with_the_reason() {
    let (input, out) = (folder("truncated-in"), folder("truncated-out"));
    clip(&input, 4, SIZE, &moving);
    let whole = fs::read(input.join("f2.png")).unwrap();
    fs::write(input.join("f2.png"), &whole[..whole.len() / 2]).unwrap();
    assert_refused(&segment(&input, &out, &[]), 3, &["f2.png", "cannot be decoded"]);

    let film = y4m(4);
    fs::write(input.join("clip.y4m"), &film[..film.len() - 5]).unwrap();
    assert_refused(&segment(&input.join("clip.y4m"), &out, &[]), 3, &["clip.y4m", "truncated", "--frames 3"]);
    assert_done(&segment(&input.join("clip.y4m"), &folder("truncated-three"), &["--frames", "3"]));

    let mut gif = Vec::new();
    let mut encoder = image::codecs::gif::GifEncoder::new(&mut gif);
    for t in 0..4 {
        encoder.encode(&rgb(SIZE.0, SIZE.1, &|x, y| moving(x, y, t)), SIZE.0, SIZE.1, ExtendedColorType::Rgb8).unwrap();
    }
    drop(encoder);
    fs::write(input.join("clip.gif"), &gif[..gif.len() - 100]).unwrap();
    assert_refused(&segment(&input.join("clip.gif"), &out, &[]), 3, &["clip.gif, frame 3", "--frames 3"]);

    fs::write(input.join("clip.bmf"), "5 1\nf0.ppm\nf1.ppm\n").unwrap();
    assert_refused(&segment(&input.join("clip.bmf"), &out, &[]), 3, &["clip.bmf", "names 2 images (expected 5"]);
}

#[test]
fn misspelt_options_and_settings_are_refused_with_what_is_known() {
    let (input, out) = (folder("misspelt-in"), folder("misspelt-out"));
    clip(&input, 2, SIZE, &moving);
    assert_refused(&segment(&input, &out, &["--set", "flow.patchstride=5"]), 2, &["flow.patchStride"]);
    assert_refused(&segment(&input, &out, &["--set", "flow.patchStride=big"]), 2, &["\"big\"", "1..=8"]);
    assert_refused(&segment(&input, &out, &["--track-step", "0"]), 2, &["trajectory.gridStep = 0"]);
    assert_refused(&segment(&input, &out, &["--set", "flow.patchStride"]), 2, &["KEY=VALUE"]);
    assert_refused(&segment(&input, &out, &["--frame", "3"]), 2, &["--frames"]);
    assert_refused(&segment(&input, &out, &["--frames", "0"]), 2, &["--frames"]);
    let file = input.join("params.json");
    fs::write(&file, r#"{"flow": {"patchStride": 99}}"#).unwrap();
    let named = ["params.json", "flow.patchStride = 99"];
    assert_refused(&segment(&input, &out, &["--params", file.to_str().unwrap()]), 2, &named);
    fs::write(&file, "{").unwrap();
    assert_refused(&segment(&input, &out, &["--params", file.to_str().unwrap()]), 2, &["params.json", "JSON"]);
}

#[test]
fn results_that_cannot_be_written_are_refused_before_the_work() {
    let input = folder("unwritable-in");
    clip(&input, 2, SIZE, &moving);
    let under_a_file = input.join("f0.png/out");
    assert_refused(&segment(&input, &under_a_file, &[]), 1, &["f0.png", "cannot be written"]);
}

#[test]
fn dumped_numbers_describe_the_written_tracks() {
    let (input, out) = (folder("dump-in"), folder("dump-out"));
    clip(&input, 8, SIZE, &moving);
    assert_done(&segment(&input, &out, &["--dump"]));
    let lines = |name: &str| -> Vec<Vec<f64>> {
        let text = fs::read_to_string(out.join("dump").join(name)).unwrap();
        let rows = text.lines().filter(|l| !l.starts_with('%'));
        rows.map(|l| l.split(' ').map(|w| w.parse().unwrap()).collect()).collect()
    };
    let n = tracks::parse(&fs::read_to_string(out.join("tracks.dat")).unwrap()).unwrap().0.len();
    let matrix = lines("affinity.mtx");
    assert_eq!(matrix[0], [n as f64, n as f64, (matrix.len() - 1) as f64]);
    assert!(matrix[1..].iter().all(|e| e[0] >= e[1] && e[2] > 0.0 && e[2] <= 1.0));
    let values: Vec<f64> = lines("eigenvalues.txt").concat();
    let vectors = lines("eigenvectors.txt");
    assert_eq!((vectors.len(), vectors[0].len()), (n, values.len()));
    for pair in lines("neighbours.txt") {
        assert!(pair[0] < pair[1] && pair[1] < n as f64 && (0.0..=1.0).contains(&pair[3]), "{pair:?}");
    }
    let saliency = lines("saliency.txt");
    assert_eq!(saliency.len(), n);
    assert!(saliency.iter().all(|s| s.iter().all(|v| (0.0..=1.0).contains(v)) && (s[1] > 0.5) == (s[2] == 1.0)));
    let foreground = saliency.iter().filter(|s| s[2] == 1.0).count();
    assert!((1..n).contains(&foreground), "{foreground} of {n}");
}

/// A shot in the layout of the Moseg benchmark: the moving clip with frames 0 and 9 labelled.
fn write_shot(root: &Path) -> PathBuf {
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
    let path = shot.join("toyDef.dat");
    fs::write(&path, definition).unwrap();
    path
}

#[test]
fn a_hand_made_track_file_is_scored() {
    let root = folder("score");
    let definition = write_shot(&root);
    let file = root.join("tracks.dat");
    // Three points on the object, one of them with the background's label; two on the background.
    fs::write(&file, "10\n5\n1 1\n30 40 0\n1 1\n31 40 0\n0 1\n32 40 0\n0 1\n0 0 0\n0 1\n9.4 0 9\n").unwrap();
    let output = tracecut(["eval", "tracks", definition.to_str().unwrap(), file.to_str().unwrap(), "--json"]);
    assert_done(&output);
    let scores: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let pixels = f64::from(2 * SIZE.0 * SIZE.1);
    for (name, value) in [
        ("density", 100.0 * 5.0 / pixels),
        ("overall", 20.0),
        ("average", 100.0 / 6.0),
        ("oversegmentation", 0.0),
        ("extracted", 0.0),
        ("visible", 2.0),
        ("labeled", 2.0),
    ] {
        let got = scores[name].as_f64().unwrap();
        assert!((got - value).abs() < 1e-9, "{name}: {got} (expected {value})");
    }
    fs::write(&file, "10\n1\n0 1\n30 x 0\n").unwrap();
    let refused = tracecut(["eval", "tracks", definition.to_str().unwrap(), file.to_str().unwrap()]);
    assert_refused(&refused, 3, &["tracks.dat", "line 4", "\"x\""]);
}

#[test]
fn a_folder_of_shots_is_run_and_scored() {
    let root = folder("shots");
    write_shot(&root);
    let file = root.join("scores.json");
    let output = tracecut(["eval", "moseg", root.to_str().unwrap(), "--json", file.to_str().unwrap()]);
    assert_done(&output);
    let table = text(&output.stdout);
    assert!(table.lines().any(|l| l.starts_with("toy ")) && table.contains("\ntrimmed mean"), "{table}");
    let report = json(&file);
    let scores = &report["sequences"][0];
    assert!(report["pixels"].is_null() && scores["pixels"].is_null(), "{report}");
    assert_eq!((&scores["name"], &scores["frames"], &scores["labeled"]), (&"toy".into(), &10.into(), &2.0.into()));
    assert_eq!(scores["overall"], report["mean"]["overall"]);
    assert!(scores["overall"].as_f64().unwrap() < 5.0, "{scores}");
    // One rigid object in one piece: connectedness changes nothing, and can be left out.
    let without = &scores["withoutConnectedness"];
    assert_eq!((&without["overall"], without), (&scores["overall"], &report["withoutConnectedness"]["mean"]));
    assert!(table.contains("\ntrimmed mean, without ") && !table.contains("    without"), "{table}");
    let off = ["--set", "connectedness.mode=off", "--json", file.to_str().unwrap()];
    let output = tracecut(["eval", "moseg", root.to_str().unwrap()].into_iter().chain(off));
    assert_done(&output);
    assert!(json(&file)["withoutConnectedness"].is_null() && !text(&output.stdout).contains("without"));

    let output = tracecut(["eval", "moseg", root.to_str().unwrap(), "--dense", "--json", file.to_str().unwrap()]);
    assert_done(&output);
    assert!(text(&output.stdout).contains("\npixels by mask label, trimmed mean"), "{}", text(&output.stdout));
    let dense = json(&file);
    // Masks leave the trajectories as they are, and label every pixel.
    assert_eq!((&dense["sequences"][0]["overall"], &dense["mean"]), (&scores["overall"], &report["mean"]));
    for way in ["pixels", "masks"] {
        let (pixels, mean) = (&dense["sequences"][0][way], &dense[way]["mean"]);
        assert_eq!((&pixels["density"], pixels), (&100.0.into(), mean), "{way}");
        assert!(pixels["overall"].as_f64().unwrap() < 10.0, "{way}: {pixels}");
    }

    assert_refused(&tracecut(["eval", "moseg", folder("no-shots").to_str().unwrap()]), 3, &["holds no sequence"]);
    fs::remove_file(root.join("toy/m9.pgm")).unwrap();
    assert_refused(&tracecut(["eval", "moseg", root.to_str().unwrap()]), 3, &["toy", "m9.pgm"]);
}

#[test]
fn the_foreground_of_shots_is_scored() {
    let root = folder("foreground");
    write_shot(&root);
    let file = root.join("scores.json");
    let output = tracecut(["eval", "foreground", root.to_str().unwrap(), "--json", file.to_str().unwrap()]);
    assert_done(&output);
    let report = json(&file);
    let scores = &report["sequences"][0];
    assert!(text(&output.stdout).lines().any(|l| l.starts_with("toy ")), "{}", text(&output.stdout));
    assert_eq!((&scores["name"], &scores["iou"]), (&"toy".into(), &report["mean"]["iou"]));
    assert!(scores["iou"].as_f64().unwrap() > 0.8 && scores["falseAlarms"].as_f64().unwrap() < 0.05, "{scores}");
    assert_refused(&tracecut(["eval", "foreground", folder("none").to_str().unwrap()]), 3, &["holds no sequence"]);
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
    let output = tracecut(["eval", "flow", root.to_str().unwrap()]);
    assert_done(&output);
    let table = text(&output.stdout);
    let mean = table.lines().find(|l| l.starts_with("mean of 1")).unwrap();
    let error: f64 = mean.split_whitespace().nth(3).unwrap().parse().unwrap();
    assert!(error < 0.1, "{table}");
    fs::write(pair.join("flow10.flo"), &truth[..100]).unwrap();
    assert_refused(&tracecut(["eval", "flow", root.to_str().unwrap()]), 3, &["flow10.flo"]);
}

#[test]
fn parameters_are_listed_with_range_default_and_meaning() {
    let output = tracecut(["params"]);
    assert_done(&output);
    let list = text(&output.stdout);
    assert!(list.contains("flow.patchStride  (whole number, 1..=8, default "), "{list}");
    assert!(list.lines().count() > 40, "{list}");
}
