//! What `segment` leaves on disk, whatever happens: long clips, runs that are ended, what lies there already.

use super::*;
use image::{Delay, RgbaImage};
use serde_json::{Value, json as value};
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStderr};
use std::sync::LazyLock;

/// Frames of the long clip, and where it is cut.
const LONG: i32 = 34;
const CUT: i32 = 21;
/// Of several windows; all forms of results.
pub(crate) const WINDOWS: [&str; 4] = ["--window", "14", "--format", "png,rle,npz,tracks,overlay"];

/// The moving clip in two shots, as Y4M.
pub(crate) fn long_y4m() -> Vec<u8> {
    let mut bytes = y4m(CUT);
    for t in 0..LONG - CUT {
        bytes.extend(b"FRAME\n");
        let other = |x: i32, y: i32| if on_object(x, y, t) { texture(x - 2 * t, y, 7) } else { texture(x + t, y, 8) };
        bytes.extend(rgb(SIZE.0, SIZE.1, &other).iter().step_by(3));
    }
    bytes
}

/// The long clip in a file of a folder of this test's own.
pub(crate) fn long_clip(name: &str) -> PathBuf {
    let file = folder(name).join("clip.y4m");
    fs::write(&file, long_y4m()).unwrap();
    file
}

/// The long clip in a file that several tests read.
pub(crate) fn shared_long_clip() -> &'static Path {
    static FILE: LazyLock<PathBuf> = LazyLock::new(|| long_clip("shared-in"));
    &FILE
}

/// The results of this clip in windows by a run that nothing disturbs.
pub(crate) fn undisturbed_results() -> &'static Path {
    static RESULTS: LazyLock<PathBuf> = LazyLock::new(|| {
        let out = absent("undisturbed-out");
        assert_done(&segment(shared_long_clip(), &out, &WINDOWS));
        out
    });
    &RESULTS
}

/// All files below a folder with their bytes; of the report what depends neither on the time nor on the file of the input.
pub(crate) fn all_files(root: &Path) -> BTreeMap<String, Vec<u8>> {
    let (mut found, mut folders) = (BTreeMap::new(), vec![root.to_owned()]);
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
            let name = path.strip_prefix(root).unwrap().to_str().unwrap().to_owned();
            if path.is_dir() {
                folders.push(path);
            } else if name == "result.json" {
                let mut report = json(&path);
                for key in ["seconds", "cpuSeconds", "peakMemoryBytes", "input", "source"] {
                    report.as_object_mut().unwrap().remove(key);
                }
                found.insert(name, report.to_string().into_bytes());
            } else {
                found.insert(name, fs::read(&path).unwrap());
            }
        }
    }
    found
}

pub(crate) fn assert_same(one: &Path, other: &Path) {
    let (one, other) = (all_files(one), all_files(other));
    assert_eq!(one.keys().collect::<Vec<_>>(), other.keys().collect::<Vec<_>>());
    one.iter().for_each(|(name, bytes)| assert!(&other[name] == bytes, "{name} differs"));
}

pub(crate) fn beside(out: &Path, end: &str) -> PathBuf {
    out.with_file_name(format!("{}{end}", out.file_name().unwrap().to_str().unwrap()))
}

/// A folder of results that is not there, and none beside it that was left.
pub(crate) fn absent(name: &str) -> PathBuf {
    let out = folder(name);
    fs::remove_dir(&out).unwrap();
    let partial = beside(&out, ".partial");
    if partial.exists() {
        fs::remove_dir_all(partial).unwrap();
    }
    out
}

/// A run of `segment` whose events can be awaited.
pub(crate) struct Running {
    child: Child,
    events: BufReader<ChildStderr>,
}

impl Running {
    pub(crate) fn start(input: &Path, out: &Path, more: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tracecut"));
        command.arg("segment").arg(input).arg("--out").arg(out).args(more).args(["--log", "json"]);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let events = BufReader::new(child.stderr.take().unwrap());
        Self { child, events }
    }

    /// Waits for the next event with this name.
    pub(crate) fn wait_for(&mut self, event: &str) {
        let mut line = String::new();
        while !line.contains(&format!("\"event\":\"{event}\"")) {
            line.clear();
            assert!(self.events.read_line(&mut line).unwrap() > 0, "the run ended before its event {event}");
        }
    }

    #[cfg(unix)]
    pub(crate) fn signal(&self, signal: &str) {
        assert!(Command::new("kill").args([signal, &self.child.id().to_string()]).status().unwrap().success());
    }

    /// Waits for the end; the output has the events that nobody waited for.
    pub(crate) fn finish(mut self) -> Output {
        let mut stderr = Vec::new();
        self.events.read_to_end(&mut stderr).unwrap();
        Output { stderr, ..self.child.wait_with_output().unwrap() }
    }
}

#[test]
fn a_long_clip_is_taken_in_windows_with_the_labels_of_the_library() {
    let (input, out) = (long_clip("long-in"), absent("long-out"));
    assert_done(&segment(&input, &out, &WINDOWS[..2]));
    let names = ["masks", "objects.csv", "result.json", "tracks"];
    assert_eq!(names_in(&out), names);
    let report = json(&out.join("result.json"));
    assert_eq!((&report["frames"], &report["shots"]), (&LONG.into(), &2.into()));

    let grey = |t: i32| {
        let frame = t.rem_euclid(CUT);
        let seed = if t < CUT { 1 } else { 7 };
        let of = |x, y| {
            if on_object(x, y, frame) { texture(x - 2 * frame, y, seed) } else { texture(x + frame, y, seed + 1) }
        };
        tracecut::image::Frame::from_rgb(rgb(SIZE.0, SIZE.1, &of), SIZE.0 as usize, SIZE.1 as usize)
    };
    let windows = tracecut::Windows::new(tracecut::Params::default(), (0..LONG).map(grey)).unwrap();
    let mut windows = windows.with_window(14, 10).unwrap();
    let (mut t, mut objects) = (0, std::collections::BTreeSet::new());
    while let Some(window) = windows.next_window(|_| ()) {
        let window = window.unwrap();
        let reported = &report["windows"][window.index];
        assert_eq!((&reported["shot"], &reported["firstFrame"]), (&window.shot.into(), &window.first_frame.into()));
        for settled in window.settled {
            let mask = windows.session().labels(settled).unwrap();
            assert_eq!(read_labels(&out, t), mask.data(), "frame {t}");
            objects.extend(mask.data().iter().copied().filter(|&label| label > 0));
            t += 1;
        }
    }
    assert_eq!((t, names_in(&out.join("masks")).len()), (LONG as usize, LONG as usize));
    let labels: Vec<u64> = report["objects"].as_array().unwrap().iter().map(|o| o["label"].as_u64().unwrap()).collect();
    assert_eq!(labels, objects.into_iter().map(u64::from).collect::<Vec<_>>());
    assert!(labels.len() > 1, "{labels:?}");
    assert_eq!(names_in(&out.join("tracks")).len(), report["windows"].as_array().unwrap().len());
}

fn read_labels(out: &Path, t: usize) -> Vec<u8> {
    png_bytes(&out.join(format!("masks/{t:05}.png")))
}

#[test]
fn every_form_holds_the_same_masks() {
    let (input, out) = (shared_long_clip(), undisturbed_results());
    let size = (SIZE.0 * SIZE.1) as usize;
    let mut zip = zip::ZipArchive::new(fs::File::open(out.join("masks.npz")).unwrap()).unwrap();
    let mut npy = Vec::new();
    std::io::Read::read_to_end(&mut zip.by_name("masks.npy").unwrap(), &mut npy).unwrap();
    let header = 10 + usize::from(u16::from_le_bytes([npy[8], npy[9]]));
    assert_eq!((&npy[..8], header % 64, npy[header - 1]), (&b"\x93NUMPY\x01\x00"[..], 0, b'\n'));
    let shape = format!("'descr': '|u1', 'fortran_order': False, 'shape': ({LONG}, {}, {})", SIZE.1, SIZE.0);
    assert!(text(&npy[..header]).contains(&shape), "{}", text(&npy[..header]));
    assert_eq!(npy.len(), header + LONG as usize * size);

    let coco = json(&out.join("masks.json"));
    assert_eq!(coco["images"].as_array().unwrap().len(), LONG as usize);
    let mut from_runs = vec![vec![0_u8; size]; LONG as usize];
    for annotation in coco["annotations"].as_array().unwrap() {
        let t = annotation["image_id"].as_u64().unwrap() as usize - 1;
        paint(&mut from_runs[t], annotation);
    }
    for (t, labels) in from_runs.iter().enumerate() {
        let expected = read_labels(out, t);
        assert!(labels == &expected, "runs of frame {t}");
        assert!(npy[header + t * size..header + (t + 1) * size] == expected, "array of frame {t}");
    }
    for pictures in ["overlay", "overlay-masks"] {
        assert_eq!(names_in(&out.join(pictures)).len(), LONG as usize);
    }
    // What is made from masks needs no pictures of them.
    let only = absent("forms-only");
    assert_done(&segment(input, &only, &["--window", "14", "--format", "npz"]));
    assert_eq!(names_in(&only), ["masks.npz", "objects.csv", "result.json"]);
    assert_eq!(fs::read(only.join("masks.npz")).unwrap(), fs::read(out.join("masks.npz")).unwrap());
}

/// Paints the compressed run lengths of a COCO annotation, column by column.
fn paint(labels: &mut [u8], annotation: &serde_json::Value) {
    let codes = annotation["segmentation"]["counts"].as_str().unwrap().bytes().map(|code| i64::from(code) - 48);
    let (mut counts, mut value, mut shift) = (Vec::new(), 0_i64, 0);
    for code in codes {
        value |= (code & 31) << shift;
        shift += 5;
        if code & 32 == 0 {
            if code & 16 != 0 {
                value |= -1 << shift;
            }
            let before = if counts.len() > 2 { counts[counts.len() - 2] } else { 0 };
            counts.push(value + before);
            (value, shift) = (0, 0);
        }
    }
    let (width, height) = (SIZE.0 as usize, SIZE.1 as usize);
    let mut k = 0;
    for (i, &count) in counts.iter().enumerate() {
        for _ in 0..count {
            if i % 2 == 1 {
                labels[k % height * width + k / height] = annotation["track_id"].as_u64().unwrap() as u8;
            }
            k += 1;
        }
    }
    assert_eq!(k, width * height);
}

#[cfg(unix)]
#[test]
fn a_run_that_was_killed_goes_on_to_the_same_result() {
    let (input, out) = (shared_long_clip(), absent("killed-out"));
    let mut run = Running::start(input, &out, &WINDOWS);
    let partial = beside(&out, ".partial");
    run.wait_for("window");
    run.wait_for("window");
    run.signal("-KILL");
    run.finish();
    assert!(!out.exists() && partial.is_dir());

    let left = segment(input, &out, &WINDOWS);
    assert_refused(&left, 2, &["killed-out.partial", "--resume", "--overwrite"]);
    let others = segment(input, &out, &["--resume", "--window", "14", "--format", "png"]);
    assert_refused(&others, 2, &["checkpoint", "options.formats was [\"png\",", "is [\"png\"]", "--overwrite"]);
    let mut other = long_y4m();
    other[100] ^= 64;
    fs::write(input.with_file_name("other.y4m"), other).unwrap();
    let resumed = |input: &Path| segment(input, &out, &[&WINDOWS[..], &["--resume", "--log", "json"]].concat());
    let refused = text(&resumed(&input.with_file_name("other.y4m")).stderr);
    assert!(refused.contains("\"code\":2") && refused.contains("source.firstFrameSum was"), "{refused}");

    let output = resumed(input);
    assert_done(&output);
    assert!(!text(&output.stderr).contains("\"index\":0"), "it began again: {}", text(&output.stderr));
    assert_same(undisturbed_results(), &out);
    // The times of frames that the run before it read are there too.
    assert_eq!(json(&out.join("result.json"))["times"].as_array().unwrap().len(), LONG as usize);
    assert!(!partial.exists());
    // There is nothing left to do.
    assert_done(&resumed(input));
}

#[cfg(unix)]
#[test]
fn signals_leave_no_half_result_and_have_codes_of_their_own() {
    let (input, out) = (long_clip("signal-in"), absent("signal-out"));
    let partial = beside(&out, ".partial");
    for (signal, code, event) in [("-TERM", 143, "begin"), ("-INT", 130, "begin"), ("-TERM", 143, "window")] {
        let mut run = Running::start(&input, &out, &WINDOWS);
        run.wait_for(event);
        run.signal(signal);
        let output = run.finish();
        assert_eq!(output.status.code(), Some(code), "{}", text(&output.stderr));
        assert!(!out.exists());
        // A finished window stays, so that another run can continue.
        let is_resumable = event == "window";
        assert_eq!(partial.exists(), is_resumable, "{signal}");
        assert_eq!(text(&output.stderr).contains("--resume"), is_resumable, "{}", text(&output.stderr));
    }
}

#[test]
fn existing_folders_are_replaced_only_with_overwrite_and_only_if_they_are_results() {
    let (input, out) = moving_clip("there", 4);
    assert_done(&segment(&input, &out, &[]));
    let before = all_files(&out);
    assert_refused(&segment(&input, &out, &["--frames", "3"]), 2, &["there-out", "exists already", "--overwrite"]);
    assert!(all_files(&out) == before);
    assert_done(&segment(&input, &out, &["--frames", "3", "--overwrite"]));
    assert_eq!(names_in(&out.join("masks")), ["00000.png", "00001.png", "00002.png"]);
    assert!(!beside(&out, ".partial").exists() && !beside(&out, ".replaced").exists());
    // A run that fails leaves what was there.
    fs::write(input.join("f2.png"), "no image").unwrap();
    assert_refused(&segment(&input, &out, &["--overwrite"]), 3, &["f2.png"]);
    assert_eq!(names_in(&out.join("masks")).len(), 3);

    let dear = folder("there-dear");
    fs::write(dear.join("thesis.txt"), "years").unwrap();
    assert_refused(&segment(&input, &dear, &["--overwrite"]), 2, &["there-dear", "not replaced"]);
    assert_eq!(names_in(&dear), ["thesis.txt"]);
    let partial = folder("there-new.partial");
    fs::write(partial.join("thesis.txt"), "years").unwrap();
    let new = partial.with_file_name("there-new");
    assert_refused(&segment(&input, &new, &["--overwrite"]), 2, &["there-new.partial", "not replaced"]);
    assert_eq!(names_in(&partial), ["thesis.txt"]);
}

#[test]
fn a_failure_leaves_no_results_and_after_a_window_a_resumable_run() {
    let (input, out) = moving_clip("late", 4);
    fs::write(input.join("f3.png"), "no image").unwrap();
    assert_refused(&segment(&input, &out, &[]), 3, &["f3.png"]);
    assert!(!out.exists() && !beside(&out, ".partial").exists());

    // A file of a list is not the end of a clip: it can be mended, and the run goes on.
    clip(&input, LONG, SIZE, &moving);
    let late = input.join("f33.png");
    let whole = fs::read(&late).unwrap();
    fs::write(&late, &whole[..whole.len() / 2]).unwrap();
    assert_refused(&segment(&input, &out, &WINDOWS), 3, &["f33.png", "cannot be decoded"]);
    assert!(!out.exists() && beside(&out, ".partial").is_dir());
    fs::write(&late, &whole).unwrap();
    assert_done(&segment(&input, &out, &[&WINDOWS[..], &["--resume"]].concat()));
    let undisturbed = absent("late-whole");
    assert_done(&segment(&input, &undisturbed, &WINDOWS));
    assert_same(&undisturbed, &out);
}

/// The long clip without the end of its last frame, in a file of a folder of this test's own.
fn cut_clip(name: &str) -> PathBuf {
    let file = folder(name).join("cut.y4m");
    let whole = long_y4m();
    fs::write(&file, &whole[..whole.len() - 5]).unwrap();
    file
}

#[test]
fn a_clip_that_is_cut_off_gives_the_results_of_its_whole_frames() {
    let (input, out, first) = (cut_clip("cut-in"), absent("cut-out"), absent("cut-first"));
    let words = ["cut.y4m", "truncated", "frame 33", "results end after frame 32"];
    assert_refused(&segment(&input, &out, &WINDOWS), 3, &words);
    assert_done(&segment(&input, &first, &[&WINDOWS[..], &["--frames", "33"]].concat()));
    let (mut cut, mut first) = (all_files(&out), all_files(&first));
    let [cut_report, first_report] = [&mut cut, &mut first].map(|files| {
        let mut report: serde_json::Value = serde_json::from_slice(&files.remove("result.json").unwrap()).unwrap();
        report.as_object_mut().unwrap().remove("options");
        report
    });
    assert!(cut == first, "{:?} and {:?}", cut.keys(), first.keys());
    let mut expected = first_report;
    let reason = cut_report["truncated"]["reason"].as_str().unwrap();
    assert!(reason.starts_with("is truncated: frame 33"), "{reason}");
    expected["truncated"] = serde_json::json!({ "frames": 33, "reason": reason });
    assert_eq!(cut_report, expected);

    // They are all that the file holds.
    let before = fs::read(out.join("result.json")).unwrap();
    let again = segment(&input, &out, &[&WINDOWS[..], &["--resume", "--json"]].concat());
    assert_refused(&again, 3, &words);
    let printed: serde_json::Value = serde_json::from_slice(&again.stdout).unwrap();
    assert_eq!(printed, json(&out.join("result.json")));
    assert_eq!(fs::read(out.join("result.json")).unwrap(), before);
    // When the rest has come, they are not taken for it.
    fs::write(&input, long_y4m()).unwrap();
    let resumed = segment(&input, &out, &[&WINDOWS[..], &["--resume"]].concat());
    assert_refused(&resumed, 2, &["cut-out", "source.bytes was", "--overwrite"]);
    assert_done(&segment(&input, &out, &[&WINDOWS[..], &["--overwrite"]].concat()));
    let whole = json(&out.join("result.json"));
    assert_eq!((&whole["frames"], whole.get("truncated")), (&LONG.into(), None));
}

#[cfg(unix)]
#[test]
fn a_run_over_a_clip_that_is_cut_off_can_be_killed_and_goes_on() {
    let (input, whole, out) = (cut_clip("cut-killed-in"), absent("cut-killed-whole"), absent("cut-killed-out"));
    assert_refused(&segment(&input, &whole, &WINDOWS), 3, &["frame 32"]);
    let mut run = Running::start(&input, &out, &WINDOWS);
    run.wait_for("window");
    run.signal("-KILL");
    run.finish();
    assert_refused(&segment(&input, &out, &[&WINDOWS[..], &["--resume"]].concat()), 3, &["results end after frame 32"]);
    assert_same(&whole, &out);
}

fn json_lines(bytes: &[u8]) -> Vec<serde_json::Value> {
    text(bytes).lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Returns the stages that events of progress tell, in order.
fn stages(events: &[serde_json::Value]) -> Vec<&str> {
    let mut stages: Vec<&str> = events.iter().filter_map(|event| event["stage"].as_str()).collect();
    stages.dedup();
    stages
}

#[test]
fn events_report_the_progress_of_the_whole_clip_as_in_javascript() {
    let (frames, out) = (folder("progress-in"), absent("progress-out"));
    clip(&frames, LONG, SIZE, &moving);
    for (input, is_counted) in [(frames, true), (long_clip("progress-stream-in"), false)] {
        let options = ["--window", "14", "--format", "rle", "--log", "json", "--overwrite"];
        let output = segment(&input, &out, &options);
        assert_done(&output);
        let mut events = json_lines(&output.stderr);
        let last_window = events.rsplit(|event| event["event"] == "window").nth(1).unwrap();
        assert_eq!(stages(last_window).last(), Some(&"masks"));
        let num_windows = events.iter().filter(|event| event["event"] == "window").count();
        assert!(num_windows > 2);
        events.retain(|event| event["event"] == "progress");
        assert_eq!(stages(&events)[..3], ["decode", "flow", "affinities"]);
        assert_eq!(stages(&events).iter().filter(|&&stage| stage == "masks").count(), num_windows);
        for event in &events {
            let keys: Vec<&str> = event.as_object().unwrap().keys().map(String::as_str).collect();
            assert_eq!(keys, ["event", "secondsLeft", "share", "stage"]);
            assert!(event["secondsLeft"].is_null() || event["secondsLeft"].as_f64().unwrap() >= 0.0, "{event}");
        }
        let shares: Vec<f64> = events.iter().filter_map(|event| event["share"].as_f64()).collect();
        assert!(shares.is_sorted() && shares[0] >= 0.0, "{shares:?}");
        assert_eq!((shares.last(), &events.last().unwrap()["secondsLeft"]), (Some(&1.0), &0.0.into()));
        // The number of frames of a stream is known once its end was read; until then the share is 0.
        assert_eq!(shares.len(), events.len());
        let known = shares.iter().filter(|&&share| share > 0.0).count();
        assert_eq!(known + 2 > shares.len(), is_counted, "{known} of {}", shares.len());
        assert!(known > 30, "{known} of {} events have a share", shares.len());
    }
}

#[test]
fn damage_is_reported_as_an_event_and_does_not_stop_other_inputs() {
    let (input, out) = (folder("events-in"), absent("events-out"));
    let whole = y4m(6);
    for (name, bytes) in [("a-cut", &whole[..whole.len() - 5]), ("b-one", &whole[..20_000]), ("c-whole", &whole[..])] {
        fs::write(input.join(format!("{name}.y4m")), bytes).unwrap();
    }
    let inputs = names_in(&input).into_iter().map(|name| input.join(name).to_str().unwrap().to_owned());
    let words = ["segment", "--log", "json", "--json", "--format", "rle", "--out", out.to_str().unwrap()];
    let output = tracecut(words.map(str::to_owned).into_iter().chain(inputs));
    assert_eq!(output.status.code(), Some(3));
    let mut events = json_lines(&output.stderr);
    events.retain(|event| event["event"] != "progress");
    let names: Vec<String> = events
        .iter()
        .map(|event| {
            let input = Path::new(event["input"].as_str().unwrap_or_default()).file_stem().unwrap_or_default();
            format!("{} {}", event["event"].as_str().unwrap(), input.to_str().unwrap())
        })
        .collect();
    let expected = "begin a-cut,window ,done a-cut,truncated a-cut,error a-cut,begin b-one,error b-one,begin c-whole,\
        window ,done c-whole,error ";
    assert_eq!(names.join(","), expected);
    assert_eq!((&events[3]["frames"], &events[4]["code"]), (&5.into(), &3.into()));
    let reports = json_lines(&output.stdout);
    assert_eq!((reports.len(), &reports[0]["truncated"]["frames"]), (2, &5.into()));
    // Of one frame there is no motion, and no result.
    assert_eq!(names_in(&out), ["a-cut", "c-whole"]);
    assert_eq!(json(&out.join("a-cut/masks.json"))["images"].as_array().unwrap().len(), 5);
}

#[test]
fn resume_refuses_complete_results_of_another_clip_or_other_options() {
    let (input, out) = moving_clip("complete", 4);
    let options = ["--format", "png,rle", "--set", "shot.maxUnmatched=0.5"];
    let resume = |more: &[&str]| segment(&input, &out, &[&options[..], &["--resume"], more].concat());
    // There is nothing to go on with yet: it begins.
    assert_done(&resume(&[]));
    let before = all_files(&out);
    let complete = resume(&["--threads", "1", "--format", "rle,png,rle"]);
    assert_done(&complete);
    assert!(text(&complete.stdout).ends_with("complete-out is complete already\n"), "{}", text(&complete.stdout));

    for (more, difference) in [
        (&["--format", "npz"][..], "options.formats was [\"png\",\"rle\"] and is [\"png\",\"rle\",\"npz\"]"),
        (&["--frames", "3"], "options.frames was null and is 3"),
        (&["--window", "12"], "options.window was 50 and is 12"),
        (&["--background"], "options.background was false and is true"),
        (&["--set", "shot.maxUnmatched=0.25"], "params.shot.maxUnmatched was 0.5 and is 0.25"),
    ] {
        assert_refused(&resume(more), 2, &["complete-out: was not made", difference, "--overwrite"]);
    }
    let own = resume(&["--log", "json"]);
    assert!(text(&own.stderr).contains("\"event\":\"complete\""), "{}", text(&own.stderr));
    let mut report = json(&out.join("result.json"));
    report["version"] = "0.0.9".into();
    let kept = fs::read(out.join("result.json")).unwrap();
    fs::write(out.join("result.json"), report.to_string()).unwrap();
    assert_refused(&resume(&[]), 2, &["version was \"0.0.9\" and is "]);
    fs::write(out.join("result.json"), kept).unwrap();

    png(&input.join("f0.png"), SIZE.0, SIZE.1, &|x, y| moving(x, y, 9));
    assert_refused(&resume(&[]), 2, &["complete-out", "source.firstFrameSum was"]);
    clip(&input, 5, SIZE, &moving);
    assert_refused(&resume(&[]), 2, &["complete-out", "source.frames was 4 and is 5"]);
    fs::remove_dir_all(&input).unwrap();
    assert_refused(&resume(&[]), 1, &["complete-in", "cannot be read"]);
    assert!(all_files(&out) == before);
}

#[test]
fn seconds_are_wall_seconds_and_include_writing() {
    let (input, out) = (long_clip("seconds-in"), absent("seconds-out"));
    let begin = std::time::Instant::now();
    let output = segment(&input, &out, &[&WINDOWS[..], &["--background", "--dump"]].concat());
    let wall = begin.elapsed().as_secs_f64();
    assert_done(&output);
    let seconds = &json(&out.join("result.json"))["seconds"];
    let of = |name: &str| seconds[name].as_f64().unwrap();
    let parts: f64 = seconds.as_object().unwrap().keys().filter(|name| *name != "total").map(|name| of(name)).sum();
    assert!(of("write") > 0.0 && parts <= of("total") && of("total") <= wall, "{parts} {wall} {seconds}");
    let printed = format!(" {:.2} s; see ", of("total"));
    assert!(text(&output.stdout).contains(&printed), "{printed}{}", text(&output.stdout));
}

#[test]
fn several_inputs_have_folders_of_their_own_and_a_bad_one_does_not_stop_the_others() {
    let (input, out) = (folder("several-in"), folder("several-out"));
    let [one, two] = ["one", "two"].map(|name| input.join(name));
    for folder in [&one, &two] {
        fs::create_dir(folder).unwrap();
        clip(folder, 4, SIZE, &moving);
    }
    let bad = input.join("bad.y4m");
    fs::write(&bad, &y4m(4)[..3000]).unwrap();
    let arguments = |more: &[&str]| {
        let inputs = [&one, &bad, &two].map(|path| path.to_str().unwrap().to_owned());
        let more = more.iter().map(|&word| word.to_owned());
        ["segment".to_owned()]
            .into_iter()
            .chain(inputs)
            .chain(["--out".to_owned(), out.to_str().unwrap().to_owned()])
            .chain(more)
            .collect::<Vec<_>>()
    };
    let output = tracecut(arguments(&["--json"]));
    assert_refused(&output, 3, &["bad.y4m", "truncated", "1 of 3 inputs failed"]);
    assert_eq!(names_in(&out), ["one", "two"]);
    let reports: Vec<serde_json::Value> =
        text(&output.stdout).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(reports.len(), 2);
    for (report, (folder, name)) in reports.iter().zip([(&one, "one"), (&two, "two")]) {
        assert_eq!(report, &json(&out.join(name).join("result.json")));
        assert_eq!(report["input"], folder.to_str().unwrap());
        assert_eq!(report["frameNames"], serde_json::json!(["f0.png", "f1.png", "f2.png", "f3.png"]));
    }
    assert_same(&out.join("one"), &out.join("two"));
    // Names that would meet are refused before the work.
    let copy = input.join("more");
    fs::create_dir_all(copy.join("one")).unwrap();
    let [a, b, to] = [&one, &copy.join("one"), &absent("several-same")].map(|path| path.to_str().unwrap().to_owned());
    assert_refused(&tracecut(["segment", &a, &b, "--out", &to]), 2, &["would overwrite"]);
}

#[test]
fn progress_is_printed_in_the_requested_format() {
    let (input, out) = moving_clip("progress-format", 4);
    let quiet = segment(&input, &out, &["--quiet"]);
    assert_done(&quiet);
    assert_eq!((text(&quiet.stdout), text(&quiet.stderr)), (String::new(), String::new()));
    let events = json_lines(&segment(&input, &out, &["--overwrite", "--log", "json"]).stderr);
    let mut names: Vec<&str> = events.iter().map(|event| event["event"].as_str().unwrap()).collect();
    names.dedup();
    assert_eq!((names, &events.last().unwrap()["frames"]), (vec!["begin", "progress", "window", "done"], &4.into()));
    let events = json_lines(&segment(&input.join("nowhere"), &out, &["--overwrite", "--log", "json"]).stderr);
    assert_eq!((events.len(), &events[0]["event"], &events[0]["code"]), (1, &"error".into(), &1.into()));
}

#[test]
fn a_video_gives_what_its_frames_give() {
    let (input, frames, out) = (folder("video-in"), absent("video-frames"), absent("video-out"));
    clip(&input, 8, SIZE, &moving);
    // Lossless, so that the pixels are the same.
    if !ffmpeg(&input, "-framerate 25 -i f%d.png -c:v ffv1 -pix_fmt bgr0 clip.mkv") {
        return;
    }
    assert_done(&segment(&input.join("clip.mkv"), &out, &["--format", "png,tracks"]));
    assert_done(&segment(&input, &frames, &["--format", "png,tracks"]));
    for file in ["tracks.dat", "masks/00007.png"] {
        assert!(fs::read(out.join(file)).unwrap() == fs::read(frames.join(file)).unwrap(), "{file} differs");
    }
    // Images have no times.
    let mut table = fs::read_to_string(frames.join("objects.csv")).unwrap();
    for (frame, time) in ["0", "0.04", "0.08", "0.12", "0.16", "0.2", "0.24", "0.28"].iter().enumerate() {
        table = table.replacen(&format!("\n{frame},,"), &format!("\n{frame},{time},"), 1);
    }
    assert_eq!(fs::read_to_string(out.join("objects.csv")).unwrap(), table);
}

#[test]
fn completions_and_man_pages_name_the_options() {
    for shell in ["bash", "zsh", "fish"] {
        let output = tracecut(["completions", shell]);
        assert_done(&output);
        assert!(text(&output.stdout).contains("overwrite"), "{shell}");
    }
    let page = text(&tracecut(["man", "segment"]).stdout);
    assert!(page.starts_with(".ie") && page.contains("\\-\\-resume") && page.contains("masks.npz"), "{page}");
    assert!(text(&tracecut(["man"]).stdout).contains("143"));
    assert_refused(&tracecut(["man", "segmnet"]), 2, &["segmnet"]);
}

/// Milliseconds that the pictures of the test's GIF are shown, over and over.
const DELAYS_MS: [u32; 5] = [40, 120, 50, 40, 300];
const PICTURES: usize = 26;

/// An animated GIF of the moving clip with uneven delays.
fn uneven_gif(name: &str) -> PathBuf {
    let file = folder(name).join("clip.gif");
    let mut encoder = image::codecs::gif::GifEncoder::new(fs::File::create(&file).unwrap());
    for t in 0..PICTURES {
        let rgba = rgb(SIZE.0, SIZE.1, &|x, y| moving(x, y, t as i32 % 20));
        let rgba = rgba.chunks(3).flat_map(|pixel| [pixel[0], pixel[1], pixel[2], 255]).collect();
        let picture = RgbaImage::from_raw(SIZE.0, SIZE.1, rgba).unwrap();
        let delay = Delay::from_numer_denom_ms(DELAYS_MS[t % DELAYS_MS.len()], 1);
        encoder.encode_frame(image::Frame::from_parts(picture, 0, 0, delay)).unwrap();
    }
    drop(encoder);
    file
}

/// Times and durations of the GIF's first pictures, in seconds.
fn expected(count: usize) -> (Vec<f64>, Vec<f64>) {
    let durations: Vec<u32> = (0..count).map(|t| DELAYS_MS[t % DELAYS_MS.len()]).collect();
    let times = (0..count).map(|t| f64::from(durations[..t].iter().sum::<u32>()) / 1000.0).collect();
    (times, durations.into_iter().map(|ms| f64::from(ms) / 1000.0).collect())
}

#[track_caller]
fn assert_near(seconds: &Value, expected: &[f64]) {
    let seconds: Vec<f64> = seconds.as_array().unwrap().iter().map(|s| s.as_f64().unwrap()).collect();
    let is_near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-6;
    assert!(seconds.len() == expected.len() && seconds.iter().zip(expected).all(is_near), "{seconds:?} {expected:?}");
}

/// The array of doubles in a file for NumPy.
fn doubles(npz: &Path, name: &str) -> Option<Value> {
    let mut zip = zip::ZipArchive::new(fs::File::open(npz).unwrap()).unwrap();
    let mut npy = Vec::new();
    std::io::Read::read_to_end(&mut zip.by_name(name).ok()?, &mut npy).unwrap();
    let header = 10 + usize::from(u16::from_le_bytes([npy[8], npy[9]]));
    let count = (npy.len() - header) / 8;
    let words = format!("'descr': '<f8', 'fortran_order': False, 'shape': ({count},), }}");
    assert!(text(&npy[..header]).contains(&words), "{}", text(&npy[..header]));
    let numbers = npy[header..].chunks_exact(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap()));
    Some(numbers.collect())
}

#[test]
fn times_of_the_file_are_in_every_form() {
    let (input, out) = (uneven_gif("times-in"), absent("times-out"));
    for (count, more) in [(PICTURES, &WINDOWS[..2]), (20, &["--frames", "20"])] {
        assert_done(&segment(&input, &out, &[&["--format", "rle,npz,prompts", "--overwrite"], more].concat()));
        let (times, durations) = expected(count);
        let report = json(&out.join("result.json"));
        assert_near(&report["times"], &times);
        assert_near(&report["durations"], &durations);
        assert_near(&value!([report["frameRate"]]), &[count as f64 / durations.iter().sum::<f64>()]);
        let coco = json(&out.join("masks.json"));
        assert_near(&coco["videos"][0]["frame_times"], &times);
        let stamps: Value = coco["images"].as_array().unwrap().iter().map(|image| image["timestamp"].clone()).collect();
        assert_near(&stamps, &times);
        assert_near(&json(&out.join("prompts.json"))["times"], &times);
        assert_near(&doubles(&out.join("masks.npz"), "times.npy").unwrap(), &times);
        assert_near(&doubles(&out.join("masks.npz"), "durations.npy").unwrap(), &durations);
        let table = fs::read_to_string(out.join("objects.csv")).unwrap();
        let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|row| row.split(',').collect()).collect();
        assert!(rows.len() >= count, "{table}");
        for row in rows {
            let frame: usize = row[0].parse().unwrap();
            assert_near(&value!([row[1].parse::<f64>().unwrap()]), &times[frame..=frame]);
        }
    }
}

#[test]
fn frames_without_times_get_none() {
    let (input, out) = moving_clip("timeless", 4);
    assert_done(&segment(&input, &out, &["--format", "rle,npz,prompts"]));
    let report = json(&out.join("result.json"));
    for name in ["times", "durations", "frameRate"] {
        assert_eq!(report.get(name), None);
    }
    let coco = json(&out.join("masks.json"));
    assert_eq!((coco["videos"][0].get("frame_times"), coco["images"][0].get("timestamp")), (None, None));
    assert_eq!(json(&out.join("prompts.json")).get("times"), None);
    assert_eq!(doubles(&out.join("masks.npz"), "times.npy"), None);
    assert!(fs::read_to_string(out.join("objects.csv")).unwrap().contains("\n0,,1,"));
}
