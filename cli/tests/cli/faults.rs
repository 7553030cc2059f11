//! Faults of the machine around `segment`: full disks, folders that cannot be written, another run in the same folder,
//! lists that name what is no file. A folder of results is whole or absent.

use super::files::{Running, WINDOWS, absent, assert_same, beside, long_clip, shared_long_clip, undisturbed_results};
use super::*;

/// Runs `segment` from a shell that says first what is to be different; `$0` is the program.
#[cfg(unix)]
fn shell(before: &str, input: &Path, out: &Path, more: &[&str]) -> Output {
    let script = format!("{before}; exec \"$0\" segment \"$@\"");
    let mut command = Command::new("sh");
    command.args(["-c", &script, env!("CARGO_BIN_EXE_tracecut")]).arg(input).arg("--out").arg(out).args(more);
    command.output().unwrap()
}

/// Nothing that looks like results: neither the folder, nor a part of it without what a run goes on with.
fn assert_nothing_half(out: &Path) {
    assert!(!out.exists(), "{} is there", out.display());
    let partial = beside(out, ".partial");
    assert!(!partial.exists() || partial.join(".tracecut/checkpoint").is_file(), "{:?}", names_in(&partial));
    assert!(!partial.join("result.json").exists());
}

#[cfg(unix)]
#[test]
fn a_file_that_cannot_be_completed_is_an_error_and_leaves_no_partial_results() {
    let (input, out) = (shared_long_clip(), absent("room-out"));
    // A limit on the size of files, in blocks of 512 bytes, and its signal ignored: writing fails as on a full disk.
    for blocks in [0, 4] {
        let output = shell(&format!("trap '' XFSZ; ulimit -f {blocks}"), input, &out, &WINDOWS);
        assert_refused(&output, 1, &["room-out", "cannot be written"]);
        assert_nothing_half(&out);
        let _ = fs::remove_dir_all(beside(&out, ".partial"));
    }
    // Heard, it ends the program in the middle of a file; what is left is not taken for results.
    let output = shell("ulimit -f 4", input, &out, &WINDOWS);
    assert!(!output.status.success());
    assert!(!out.exists());
    assert_done(&segment(input, &out, &[&WINDOWS[..], &["--overwrite"]].concat()));
    assert_same(undisturbed_results(), &out);
}

/// As `shell`, with a disk of this many kilobytes at `/mnt`, which only this program sees.
#[cfg(target_os = "linux")]
fn on_small_disk(kilobytes: u32, script: &str, input: &Path) -> Option<Output> {
    let mount = format!("mount -t tmpfs -o size={kilobytes}k none /mnt || exit 99");
    let mut command = Command::new("unshare");
    command.args(["-rm", "sh", "-c", &format!("{mount}; {script}")]);
    command.arg(env!("CARGO_BIN_EXE_tracecut")).arg(input).args(WINDOWS);
    let output = command.output().ok()?;
    let cannot = output.status.code() == Some(99) || text(&output.stderr).contains("unshare:");
    if cannot {
        eprintln!("!!! SKIPPED: no disk of its own for a test here: {}", text(&output.stderr));
    }
    (!cannot).then_some(output)
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_loses_nothing_that_was_there() {
    let input = long_clip("disk-in");
    // Results that lie there stay when those that are to replace them find no room.
    let script = "mkdir /mnt/out; echo '{\"workingWidth\": 1}' > /mnt/out/result.json; echo kept > /mnt/out/file; \
        \"$0\" segment \"$@\" --out /mnt/out --overwrite; code=$?; cat /mnt/out/file; ls -A /mnt/out; exit $code";
    let Some(output) = on_small_disk(96, script, &input) else { return };
    assert_refused(&output, 1, &["cannot be written", "No space left"]);
    assert_eq!(text(&output.stdout), "kept\nfile\nresult.json\n");
    // With room again the run goes on, or begins again, to the same results.
    let script = "\"$0\" segment \"$@\" --out /mnt/out 2> /dev/null && exit 98; mount -o remount,size=8m /mnt; \
        \"$0\" segment \"$@\" --out /mnt/out --resume; code=$?; ls -A /mnt; exit $code";
    let output = on_small_disk(96, script, &input).unwrap();
    assert_done(&output);
    assert!(text(&output.stdout).ends_with("\nout\n"), "{}", text(&output.stdout));
    // A disk that cannot be written at all.
    let output = on_small_disk(96, "mount -o remount,ro /mnt; \"$0\" segment \"$@\" --out /mnt/out", &input).unwrap();
    assert_refused(&output, 1, &["/mnt/out", "cannot be written", "Read-only"]);
}

#[test]
fn a_place_that_cannot_be_written_is_named_and_what_is_there_stays() {
    let (input, around) = (folder("place-in"), folder("place-out"));
    clip(&input, 4, SIZE, &moving);
    let file = around.join("file");
    fs::write(&file, "mine").unwrap();
    assert_refused(&segment(&input, &file.join("out"), &[]), 1, &["place-out", "cannot be written", "choose a folder"]);
    assert_refused(&segment(&input, &file, &["--overwrite"]), 2, &["file", "has no results"]);
    fs::write(around.join("other.partial"), "mine").unwrap();
    let refused = segment(&input, &around.join("other"), &["--overwrite"]);
    assert_refused(&refused, 2, &["other.partial", "not replaced"]);
    assert_eq!(names_in(&around), ["file", "other.partial"]);
    for name in ["file", "other.partial"] {
        assert_eq!(fs::read_to_string(around.join(name)).unwrap(), "mine");
    }
    if cfg!(target_os = "linux") {
        // No user may make anything there, root neither.
        assert_refused(&segment(&input, Path::new("/proc/out"), &[]), 1, &["/proc/out", "cannot be written"]);
        let output = shell("exec > /dev/full", &input, &around.join("told"), &["--json"]);
        assert_refused(&output, 1, &["cannot print"]);
        assert!(json(&around.join("told/result.json")).is_object(), "the results are whole");
    }
}

#[cfg(unix)]
#[test]
fn of_two_runs_into_one_folder_the_first_goes_on_and_the_other_is_refused() {
    let (input, out) = (shared_long_clip(), absent("two-out"));
    let mut first = Running::start(input, &out, &WINDOWS);
    let work = beside(&out, ".partial").join(".tracecut");
    first.wait_for("window");
    first.signal("-STOP");
    assert_refused(&segment(input, &out, &WINDOWS), 2, &["two-out.partial"]);
    for more in ["--overwrite", "--resume"] {
        let second = segment(input, &out, &[&WINDOWS[..], &[more]].concat());
        assert_refused(&second, 2, &["two-out.partial", "another run"]);
    }
    // A signal to one that is refused takes nothing from the other either.
    assert!(work.join("checkpoint").is_file());
    first.signal("-CONT");
    let output = first.finish();
    assert_done(&output);
    assert_same(undisturbed_results(), &out);
    assert!(!beside(&out, ".partial").exists());
}

#[test]
fn failures_that_may_pass_have_exit_code_1_and_bad_data_has_3() {
    let (input, out) = moving_clip("later", 4);
    let bad = input.join("bad.y4m");
    fs::write(&bad, &y4m(2)[..3000]).unwrap();
    let missing = input.join("missing.mp4");
    let code = |inputs: &[&Path]| {
        let inputs = inputs.iter().map(|path| path.as_os_str());
        let words = ["segment", "--quiet", "--overwrite", "--out", out.to_str().unwrap()].map(std::ffi::OsStr::new);
        tracecut(words.into_iter().chain(inputs)).status.code().unwrap()
    };
    assert_eq!([code(&[&missing]), code(&[&input.join("missing")]), code(&[&input.join("missing.bmf")])], [1; 3]);
    fs::write(input.join("list.bmf"), "2 1\nf0.png\nnot-yet.png\n").unwrap();
    assert_eq!([code(&[&input.join("list.bmf")]), code(&[&bad])], [1, 3]);
    #[cfg(unix)]
    {
        // Nobody can open a link that leads to itself, root neither.
        std::os::unix::fs::symlink("loop.mp4", input.join("loop.mp4")).unwrap();
        assert_eq!(code(&[&input.join("loop.mp4")]), 1);
    }
    // Of several inputs the code says that one of them may work later.
    assert_eq!([code(&[&bad, &missing, &input]), code(&[&missing, &bad]), code(&[&bad, &input])], [1, 1, 3]);
    let help = text(&tracecut(["--help"]).stdout);
    assert!(help.contains("1    may succeed later: an input is missing"), "{help}");
}

#[cfg(unix)]
#[test]
fn a_killed_ffmpeg_is_not_reported_as_damage() {
    use std::os::unix::fs::PermissionsExt;
    let (input, out) = moving_clip("killed-ffmpeg", 8);
    let video = input.join("clip.mkv");
    if !ffmpeg(&input, "-i f%d.png -c:v ffv1 -pix_fmt bgr0 clip.mkv") {
        return;
    }
    let path = std::env::var("PATH").unwrap();
    let real = std::env::split_paths(&path).map(|folder| folder.join("ffmpeg")).find(|file| file.is_file()).unwrap();
    // Of the decoding, and then of the listing, half the frames come.
    for (kind, bytes) in [("rawvideo", 4 * 3 * SIZE.0 * SIZE.1), ("framecrc", 300)] {
        let script = format!(
            "#!/bin/sh\ncase \"$*\" in *'-f {kind}'*) '{0}' \"$@\" | head -c {bytes}; kill -KILL $$ ;; esac\nexec '{0}' \"$@\"\n",
            real.display()
        );
        fs::write(input.join("ffmpeg"), script).unwrap();
        fs::set_permissions(input.join("ffmpeg"), fs::Permissions::from_mode(0o755)).unwrap();
        let before = format!("PATH='{}':\"$PATH\"", input.display());
        assert_refused(&shell(&before, &video, &out, &[]), 1, &["clip.mkv: ffmpeg was killed"]);
        assert_nothing_half(&out);
    }
}

#[test]
fn many_runs_begun_at_once_leave_one_whole_result() {
    let (input, out) = (shared_long_clip(), absent("many-out"));
    let runs: Vec<_> = (0..6).map(|_| Running::start(input, &out, &WINDOWS)).collect();
    let codes: Vec<_> = runs.into_iter().map(|run| run.finish().status.code().unwrap()).collect();
    assert!(
        codes.iter().filter(|&&code| code == 0).count() == 1 && codes.iter().all(|code| [0, 2].contains(code)),
        "{codes:?}"
    );
    assert_same(undisturbed_results(), &out);
}

#[cfg(unix)]
#[test]
fn lists_may_name_files_anywhere_but_no_devices_and_pipes() {
    let (input, out) = moving_clip("named", 4);
    let lists = input.join("lists");
    fs::create_dir(&lists).unwrap();
    let list = |names: &[&str]| {
        let path = lists.join("clip.bmf");
        fs::write(&path, format!("{} 1\n{}\n", names.len(), names.join("\n"))).unwrap();
        path
    };
    for name in ["/dev/zero", "/dev/stdin", "../../named-in"] {
        let path = list(&["../f0.png", name]);
        assert_refused(&segment(&path, &out, &[]), 3, &["clip.bmf", name, "not a file"]);
    }
    // Results are named by the number of the frame, whatever the list says.
    let last = input.join("f3.png");
    assert_done(&segment(&list(&["../f0.png", "../lists/../f1.png", "../f2.png", last.to_str().unwrap()]), &out, &[]));
    assert_eq!(names_in(&out), ["masks", "objects.csv", "result.json", "tracks.dat"]);
    assert_eq!(names_in(&out.join("masks")), ["00000.png", "00001.png", "00002.png", "00003.png"]);
    assert_eq!(names_in(&lists), ["clip.bmf"]);
}

#[cfg(unix)]
#[test]
fn a_full_disk_leaves_no_partial_picture() {
    let (input, out) = moving_clip("single", 1);
    let image = input.join("f0.png");
    for command in ["superpixels", "boundaries"] {
        let script = "trap '' XFSZ; ulimit -f 1; exec \"$0\" \"$@\"";
        let mut limited = Command::new("sh");
        limited.args(["-c", script, env!("CARGO_BIN_EXE_tracecut"), command]).arg(&image).arg("--out").arg(&out);
        assert_refused(&limited.output().unwrap(), 1, &["single-out", "cannot be written"]);
        for name in names_in(&out) {
            image::open(out.join(&name)).unwrap_or_else(|e| panic!("{name} is half a file: {e}"));
        }
    }
}
