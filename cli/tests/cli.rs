//! The `tracecut` program from outside: its outputs, its errors for unusable input, and `docs/cli.md` against its help.

mod faults;
mod files;
mod images;
mod masks;

use crate::helpers::*;
use crate::videos::ffmpeg;
use image::ExtendedColorType;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tracecut::tracks;

fn tracecut<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tracecut")).args(arguments).output().unwrap()
}

fn segment(input: &Path, out: &Path, more: &[&str]) -> Output {
    let mut arguments = vec!["segment", input.to_str().unwrap(), "--out", out.to_str().unwrap()];
    arguments.extend(more);
    tracecut(arguments)
}

/// The first frames of the moving clip in a folder of this test's own, and where results of it may go.
fn moving_clip(name: &str, frames: i32) -> (PathBuf, PathBuf) {
    let input = folder(&format!("{name}-in"));
    clip(&input, frames, SIZE, &moving);
    (input, files::absent(&format!("{name}-out")))
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
    let (input, out) = moving_clip("moving", FRAMES);
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
    let (input, out) = moving_clip("labels", FRAMES);
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
    assert_refused(&segment(&input, &out, &[]), 3, &["has no images"]);
    fs::write(input.join("masks.pgm"), "P5").unwrap();
    assert_refused(&segment(&input, &out, &[]), 3, &["has no images"]);
    assert_refused(&segment(&input.join("nowhere"), &out, &[]), 1, &["nowhere", "cannot be read"]);
    fs::write(input.join("film.mp4"), [0; 64]).unwrap();
    assert_refused(&segment(&input.join("film.mp4"), &out, &[]), 3, &["film.mp4", "ffmpeg"]);
}

#[test]
fn one_frame_is_refused_and_two_are_enough() {
    let (input, out) = moving_clip("few", 1);
    assert_refused(&segment(&input, &out, &[]), 3, &["few-in: 1 frame(s) given", "at least 2"]);
    clip(&input, 2, SIZE, &moving);
    assert_refused(&segment(&input, &out, &["--frames", "1"]), 2, &["1 is not in 2.."]);
    assert_done(&segment(&input, &out, &[]));
    let (trajectories, _) = tracks::parse(&fs::read_to_string(out.join("tracks.dat")).unwrap()).unwrap();
    assert_eq!(trajectories.num_frames, 2);
}

#[test]
fn a_frame_of_another_size_is_named() {
    let (input, out) = moving_clip("sizes", 4);
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
        let options = ["--dump", "--format", "png,tracks,overlay", "--set", "shot.maxUnmatched=1"];
        assert_done(&segment(&input, &out, &options));
        let (trajectories, clusters) = tracks::parse(&fs::read_to_string(out.join("tracks.dat")).unwrap()).unwrap();
        assert_eq!(trajectories.num_frames, 8, "{name}");
        assert!(clusters.count <= 1, "{name}: {} clusters", clusters.count);
        assert!(out.join("overlay/00007.png").is_file(), "{name}");
    }
}

#[test]
fn truncated_files_are_named_with_the_reason() {
    let (input, out) = moving_clip("truncated", 4);
    let whole = fs::read(input.join("f2.png")).unwrap();
    fs::write(input.join("f2.png"), &whole[..whole.len() / 2]).unwrap();
    assert_refused(&segment(&input, &out, &[]), 3, &["f2.png", "cannot be decoded"]);

    let film = y4m(4);
    fs::write(input.join("clip.y4m"), &film[..film.len() - 5]).unwrap();
    assert_refused(&segment(&input.join("clip.y4m"), &out, &[]), 3, &["clip.y4m", "truncated", "after frame 2"]);
    assert_done(&segment(&input.join("clip.y4m"), &folder("truncated-three"), &["--frames", "3"]));

    let mut bytes = Vec::new();
    let mut encoder = image::codecs::gif::GifEncoder::new(&mut bytes);
    for t in 0..4 {
        encoder.encode(&rgb(SIZE.0, SIZE.1, &|x, y| moving(x, y, t)), SIZE.0, SIZE.1, ExtendedColorType::Rgb8).unwrap();
    }
    drop(encoder);
    fs::write(input.join("clip.gif"), &bytes[..bytes.len() - 100]).unwrap();
    let gif = segment(&input.join("clip.gif"), &out, &["--overwrite"]);
    assert_refused(&gif, 3, &["clip.gif: frame 3 cannot be decoded", "after frame 2"]);
    assert_eq!(json(&out.join("result.json"))["truncated"]["frames"], 3);

    fs::write(input.join("clip.bmf"), "5 1\nf0.ppm\nf1.ppm\n").unwrap();
    assert_refused(
        &segment(&input.join("clip.bmf"), &out, &["--overwrite"]),
        3,
        &["clip.bmf", "names 2 images (expected 5"],
    );
}

#[test]
fn misspelt_options_and_settings_are_refused_with_what_is_known() {
    let (input, out) = moving_clip("misspelt", 2);
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
    let (input, out) = moving_clip("dump", 8);
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

#[test]
fn parameters_are_listed_with_range_default_and_meaning() {
    let listed = |words: &[&str]| {
        let output = tracecut(words);
        assert_done(&output);
        text(&output.stdout)
    };
    let (shown, expert) = (listed(&["params"]), listed(&["params", "--expert"]));
    assert!(shown.contains("shot.maxUnmatched  (number, 0..=1, default 0.72)"), "{shown}");
    assert!(shown.ends_with("more parameters, for research: tracecut params --expert\n"), "{shown}");
    assert!(
        expert.contains("flow.patchStride  (whole number, 1..=8, default ") && !expert.contains("shot.maxUnmatched")
    );
    let count = |list: &str| list.lines().filter(|line| line.contains(", default ")).count();
    assert!(count(&shown) <= 20 && count(&expert) > 40, "{shown}{expert}");
}

/// `selftest` gives the hashes of the wasm build, from which the file of expected ones is made.
#[test]
fn this_machine_gives_the_hashes_of_every_engine() {
    let found = tracecut(["selftest", "--threads", "2"]);
    let printed = text(&found.stdout);
    assert!(found.status.success(), "{printed}{}", text(&found.stderr));
    let expected: serde_json::Value =
        serde_json::from_str(include_str!("../src/selftest/expected.json")).expect("a list of hashes");
    let expected: BTreeMap<&str, &str> =
        expected["hashes"].as_object().unwrap().iter().map(|(k, v)| (k.as_str(), v.as_str().unwrap())).collect();
    let lines = printed.lines().filter(|line| line.contains("  same  ("));
    let hashes: BTreeMap<&str, &str> = lines
        .map(|line| line.split_once(' ').unwrap())
        .map(|(k, v)| (k, v.trim_start().split(' ').next().unwrap()))
        .collect();
    assert_eq!(hashes, expected);
    assert!(hashes.len() >= 15, "{} hashes", hashes.len());
}

#[test]
fn a_mistyped_option_or_command_suggests_one_of_the_same_place() {
    let cases = [
        (["superpixels", "image.png", "--cuont", "4"], "'--count'"),
        (["segment", "clip.mp4", "--thraeds", "4"], "'--threads'"),
        (["explain", "clip.mp4", "--frame", "4"], "'--frames'"),
        (["segmnt", "clip.mp4", "--out", "result"], "'segment'"),
    ];
    for (words, suggested) in cases {
        assert_refused(&tracecut(words), 2, &["similar", suggested]);
    }
    // No command has such an option, and none is suggested.
    let output = tracecut(["segment", "clip.mp4", "--wroker", "4"]);
    assert_refused(&output, 2, &["unexpected argument '--wroker'"]);
    assert!(!text(&output.stderr).contains("similar"), "{}", text(&output.stderr));
}

fn document() -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/cli.md")).unwrap().replace('\r', "")
}

fn help(command: &str) -> String {
    text(&tracecut([command, "--help"]).stdout)
}

/// Returns the names of the commands, as the program lists them.
fn commands() -> Vec<String> {
    let help = text(&tracecut(["--help"]).stdout);
    let list = help.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap().to_owned();
    let names: Vec<String> = list.lines().map(|line| line.split_whitespace().next().unwrap().to_owned()).collect();
    names.into_iter().filter(|name| name != "help").collect()
}

/// Returns the words of a text that begin with `--`.
fn options(text: &str) -> BTreeSet<String> {
    let parts = text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-'));
    parts.filter(|word| word.starts_with("--") && word.len() > 3).map(str::to_owned).collect()
}

/// Returns the part of a text from `begin` on, up to `end`.
fn between<'a>(text: &'a str, begin: &str, end: &str) -> &'a str {
    let (_, rest) = text.split_once(begin).unwrap_or_else(|| panic!("\"{begin}\" is missing: {text}"));
    rest.split(end).next().unwrap()
}

#[test]
fn every_command_and_option_is_described() {
    let document = document();
    let described = options(&document);
    let commands = commands();
    assert!(commands.len() >= 8, "{commands:?}");
    for command in commands {
        assert!(document.contains(&format!("tracecut {command}")), "{command}");
        let mut own = options(&help(&command));
        own.retain(|option| option != "--help" && !described.contains(option));
        assert!(own.is_empty(), "{command}: {own:?}");
    }
}

#[test]
fn every_format_and_file_of_results_is_described() {
    let (document, help) = (document(), help("segment"));
    let table = between(&document, "| format | file | content |", "\n\n");
    let values =
        between(&help, "Possible values:\n", "[default").lines().filter_map(|line| line.trim().strip_prefix("- "));
    let values: Vec<&str> = values.filter_map(|line| line.split(':').next()).collect();
    let is_missing = |name: &&str| !table.contains(&format!("\n| `{name}` | "));
    let missing: Vec<&str> = values.iter().copied().filter(is_missing).collect();
    assert!(values.len() >= 6 && missing.is_empty(), "{values:?}, {missing:?}");
    let files = between(&help, "Results in the folder:\n", "\n\n");
    let names = files.lines().filter_map(|line| line.strip_prefix("  ")).filter(|line| !line.starts_with(' '));
    for name in names.map(|line| line.split_whitespace().next().unwrap()) {
        assert!(table.contains(&format!("`{name}`")), "{name}");
    }
}

#[test]
fn segment_and_explain_list_the_same_kinds_of_input_as_the_document() {
    let kinds = |command: &str| {
        between(&help(command), "Arguments:\n", "\n\n")
            .split_once('>')
            .unwrap()
            .1
            .trim_matches(['.', ' ', '\n'])
            .to_owned()
    };
    let (segment, explain) = (kinds("segment"), kinds("explain"));
    assert_eq!(segment, explain);
    let document = document();
    let input = between(&document, "## Input\n", "\n\n`tracecut");
    for kind in ["PNG, JPEG or PPM", ".bmf", "animated GIF, PNG or WebP", "Y4M", "ffmpeg", "standard input"] {
        assert!(segment.contains(kind) && input.contains(kind), "{kind}: {segment}");
    }
}

#[test]
fn exit_codes_are_those_of_the_help() {
    let help = text(&tracecut(["--help"]).stdout);
    let told = between(&help, "Exit codes", "\u{0}").lines().skip(1);
    let told: BTreeSet<&str> = told.filter_map(|line| line.split_whitespace().next()).collect();
    let document = document();
    let table = between(&document, "| exit code | meaning |\n|---|---|\n", "\n\n");
    let rows: Vec<&str> = table.lines().map(|line| between(line, "| ", " |")).collect();
    assert_eq!(rows, ["0", "1", "2", "3", "4", "130, 143"]);
    assert!(rows.iter().all(|row| told.contains(row.split(',').next().unwrap())), "{told:?}");
}

#[test]
fn events_have_the_described_names_and_fields() {
    let document = document();
    let table = between(&document, "| `event` | fields |", "\n\n");
    for name in ["begin", "progress", "window", "done", "complete", "truncated", "error"] {
        assert!(table.contains(&format!("`{name}`")), "{name}");
    }
    for field in ["stage", "share", "secondsLeft"] {
        assert!(table.contains(&format!("`{field}`")), "{field}");
    }
}
