//! What takes too long for every time: `npm run test:long`.

use crate::helpers::{assert_done, folder, png_bytes, shared};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// A small grey one, and one in colour.
const CLIPS: [&str; 2] = ["ucsd--cyclists", "davis-train--dog-agility"];

/// The bytes of all files of a folder, in name order.
fn all_bytes(folder: &Path) -> Vec<Vec<u8>> {
    let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.iter().map(|file| png_bytes(file)).collect()
}

/// The labels of a clip's masks by the command line, which leaves them in `out`.
fn by_command_line(frames: &Path, out: &Path, settings: &[&str]) -> Vec<Vec<u8>> {
    let mut segment = Command::new(env!("CARGO_BIN_EXE_tracecut"));
    assert_done(&segment.arg("segment").arg(frames).arg("--out").arg(out).args(settings).output().unwrap());
    all_bytes(&out.join("masks"))
}

/// Runs an example, built as these tests are.
fn run_example(name: &str, arguments: &[&Path]) -> Output {
    let mut example = Command::new(env!("CARGO"));
    example.args(["run", "--quiet", "--package", "tracecut", "--features", "pnm", "--example", name, "--"]);
    let output = example.args(arguments).output().unwrap();
    assert_done(&output);
    output
}

/// A mask as the example `method` prints it: runs of a label and a number of pixels.
fn printed(t: usize, mask: &[u8]) -> String {
    let runs = mask.chunk_by(|a, b| a == b).map(|run| format!(" {}x{}", run[0], run.len()));
    format!("{t:05}{}", runs.collect::<String>())
}

#[test]
#[ignore = "real clips, whole"]
fn the_method_in_straight_lines_prints_the_labels_of_the_command_line() {
    let Some(clips) = shared("wild") else { return };
    let mut objects = 0;
    for clip in CLIPS {
        let (frames, out) = (clips.join(clip).join("frames"), folder(&format!("method-{clip}")));
        // The example tries no other clusters.
        let labels = by_command_line(&frames, &out, &["--set", "discretize.minAgreement=0"]);
        assert_eq!(labels.len(), fs::read_dir(&frames).unwrap().count(), "{clip}");
        let lines = String::from_utf8(run_example("method", &[&frames]).stdout).unwrap();
        let expected: Vec<String> = labels.iter().enumerate().map(|(t, mask)| printed(t, mask)).collect();
        for (t, (line, expected)) in lines.lines().zip(&expected).enumerate() {
            assert!(line == expected, "{clip}, frame {t}");
        }
        assert_eq!(lines.lines().count(), expected.len(), "{clip}");
        let highest = labels.iter().flatten().copied().max().unwrap();
        println!("{clip}: the same {} masks of {highest} objects", expected.len());
        objects += usize::from(highest);
    }
    assert!(objects > 0, "clips without objects show nothing");
}

#[test]
#[ignore = "real clips, whole"]
fn the_example_makes_the_masks_of_the_command_line() {
    let Some(clips) = shared("wild") else { return };
    for clip in CLIPS {
        let (frames, out) = (clips.join(clip).join("frames"), folder(clip));
        let (ours, theirs) = (out.join("command-line"), out.join("example"));
        let labels = by_command_line(&frames, &ours, &[]);
        run_example("masks", &[&frames, &theirs]);

        let greys = all_bytes(&theirs);
        assert_eq!((labels.len(), greys.len()), (fs::read_dir(&frames).unwrap().count(), labels.len()), "{clip}");
        let objects = labels.iter().flatten().copied().max().unwrap();
        println!("{clip}: {} frames, {objects} objects", labels.len());
        let step = 255 / objects.max(1);
        for (t, (mask, grey)) in labels.iter().zip(&greys).enumerate() {
            assert!(mask.iter().map(|label| label * step).eq(grey.iter().copied()), "{clip}, frame {t}");
        }
    }
}
