//! The examples, run as their first lines say.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tracecut::image::Frame;
use tracecut::synth::Scene;
use tracecut::{Params, Session, Stage, Step};

/// Runs an example, built here unless `npm test` has built it.
fn run(example: &str, arguments: &[&Path]) -> Output {
    if std::env::var_os("TRACECUT_BUILT").is_none() {
        let cargo = Command::new(env!("CARGO")).args(["build", "--quiet", "--example", example]).output().unwrap();
        assert!(cargo.status.success(), "{}", String::from_utf8_lossy(&cargo.stderr));
    }
    let program = format!("../debug/examples/{example}{}", std::env::consts::EXE_SUFFIX);
    Command::new(Path::new(env!("CARGO_TARGET_TMPDIR")).join(program)).args(arguments).output().unwrap()
}

fn masks(input: &str, output: &Path) -> Output {
    run("masks", &[Path::new(input), output])
}

fn frames_of(scene: &Scene) -> Vec<Frame> {
    (0..scene.num_frames()).map(|t| scene.frame(t)).collect()
}

/// A textured square that crosses the view of a camera that stands still.
fn still_camera_clip() -> Vec<Frame> {
    let [background, object] = [3, 8].map(|seed| Scene::still((192, 144), 1, seed).frame(0));
    let frame = |t: usize| {
        let mut rgb = background.rgb().to_vec();
        for (y, x) in (50..100).flat_map(|y| (10..60).map(move |x| (y, x))) {
            let [from, to] = [x, x + 4 * t].map(|x| 3 * (y * 192 + x));
            rgb[to..to + 3].copy_from_slice(&object.rgb()[from..from + 3]);
        }
        Frame::from_rgb(rgb, 192, 144).unwrap()
    };
    (0..16).map(frame).collect()
}

/// Writes frames into a new folder.
fn write_frames(clip: &[Frame], folder: &Path) {
    fs::create_dir_all(folder).unwrap();
    for (t, frame) in clip.iter().enumerate() {
        let (width, height) = (frame.width() as u32, frame.height() as u32);
        let picture = image::RgbImage::from_raw(width, height, frame.rgb().to_vec()).unwrap();
        picture.save(folder.join(format!("{t:03}.png"))).unwrap();
    }
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
    write_frames(&frames_of(&Scene::sample((256, 144), 10, 1)), &frames);
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

/// Masks as the example `method` prints them.
fn printed(session: &Session) -> String {
    let line = |t: usize| {
        let mask = session.labels(t).unwrap();
        let runs = mask.data().chunk_by(|a, b| a == b).map(|run| format!(" {}x{}", run[0], run.len()));
        format!("{t:05}{}\n", runs.collect::<String>())
    };
    (0..session.num_frames()).map(line).collect()
}

/// A session that has run over a clip, and the steps that connectedness took in it.
fn run_session(clip: &[Frame], params: Params) -> (Session, u32) {
    let mut session = Session::new(params).unwrap();
    clip.iter().for_each(|frame| session.push_frame(frame.clone()).unwrap());
    let mut steps = 0;
    while let Step::Working(progress) = session.step().unwrap() {
        steps = if progress.stage == Stage::Connectedness { progress.total } else { steps };
    }
    (session, steps)
}

#[test]
fn the_method_top_to_bottom_gives_the_masks_of_the_session() {
    // Where the foreground keeps some apart, that takes a second embedding: three steps in place of one.
    let clips = [
        ("sample", frames_of(&Scene::sample((240, 136), 10, 1)), false, 3),
        ("players", frames_of(&Scene::entangled((288, 192), 24, 3)), false, 3),
        ("still-camera", still_camera_clip(), true, 1),
    ];
    for (name, clip, is_still, connectedness_steps) in clips {
        let frames = folder(&format!("example-method-{name}"));
        write_frames(&clip, &frames);
        let (session, steps) = run_session(&clip, Params::default());
        assert_eq!(steps, connectedness_steps, "{name}: steps of connectedness");
        assert!(!session.objects().unwrap().labels().is_empty());
        let output = run("method", &[&frames]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let masks = printed(&session);
        assert!(String::from_utf8_lossy(&output.stdout) == masks, "{name}: other masks");

        let mut params = Params::default();
        params.cut.appearance_rounds = 0;
        assert!(printed(&run_session(&clip, params.clone()).0) != masks, "{name}: appearance changes no mask");
        params.clip.dense = false;
        let camera = run_session(&clip, params).0.cluster_terms().map(|(is_still, _)| is_still);
        assert_eq!(camera, Some(is_still), "{name}: whether the camera stands still");
    }
}

#[test]
fn the_method_says_which_frames_it_takes() {
    let frames = folder("example-method-one");
    write_frames(&frames_of(&Scene::sample((32, 24), 1, 3)), &frames);
    let output = run("method", &[&frames]);
    assert!(!output.status.success() && String::from_utf8_lossy(&output.stderr).contains("at least two frames"));
}
