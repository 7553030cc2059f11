//! Property tests: small clips of any content under any legal parameters and in any order of calls, and files with faults.
//! Nothing panics, and results keep their invariants. The fuzz targets of `fuzz/` call the same functions.
//!
//! `TRACECUT_SEEDS=FIRST..LAST` runs other seeds, and prints those that take more than a second.

use crate::generators::choices::Choices;
use crate::generators::seeds::{self, Reader, read_with_faults};
use crate::generators::{invariants, sessions};
use std::ops::Range;
use std::path::Path;
use std::time::Instant;

/// Runs `property` with each seed.
fn run(name: &str, seeds: Range<u64>, property: fn(&mut Choices<'_>)) {
    let requested = seeds_of_environment();
    for seed in requested.clone().unwrap_or(seeds) {
        let begin = Instant::now();
        let outcome = std::panic::catch_unwind(|| property(&mut Choices::from_seed(seed, name)));
        assert!(outcome.is_ok(), "seed {seed}");
        let seconds = begin.elapsed().as_secs_f64();
        if requested.is_some() && seconds > 1.0 {
            println!("{name}, seed {seed}: {seconds:.1} s");
        }
    }
}

fn seeds_of_environment() -> Option<Range<u64>> {
    let text = std::env::var("TRACECUT_SEEDS").ok()?;
    let (first, last) = text.split_once("..").expect("TRACECUT_SEEDS=FIRST..LAST");
    Some(first.parse().unwrap()..last.parse().unwrap())
}

#[test]
fn random_calls_keep_the_invariants_of_sessions() {
    run("random", 0..150, sessions::check_random_calls);
}

#[test]
fn given_trajectories_keep_the_invariants_of_sessions() {
    run("tracks", 0..300, sessions::check_given_tracks);
}

#[test]
fn a_stroke_whose_label_loses_its_last_trajectory_leaves_no_label() {
    // Found by the run of many more: the mask had a label that no cluster had.
    run("tracks", 4459..4460, sessions::check_given_tracks);
}

#[test]
fn undone_corrections_restore_the_result() {
    run("corrections", 0..60, sessions::check_undo);
}

#[test]
fn interrupted_runs_on_any_number_of_threads_give_the_same_result() {
    run("halves", 0..60, sessions::check_interrupted_run);
}

#[test]
fn resumed_windows_give_the_same_masks() {
    run("windows", 0..30, sessions::check_resumed_windows);
}

#[test]
fn single_images_keep_the_invariants() {
    run("image", 0..200, sessions::check_image);
}

#[test]
#[ignore = "some minutes; part of npm run test:long"]
fn many_more_random_calls() {
    run("random", 1000..21_000, sessions::check_random_calls);
}

#[test]
#[ignore = "some minutes; part of npm run test:long"]
fn many_more_of_the_other_properties() {
    run("tracks", 1000..11_000, sessions::check_given_tracks);
    run("corrections", 1000..4000, sessions::check_undo);
    run("halves", 1000..4000, sessions::check_interrupted_run);
    run("windows", 1000..2000, sessions::check_resumed_windows);
    run("image", 1000..11_000, sessions::check_image);
}

#[test]
fn integer_overflow_ends_a_test() {
    use tracecut::trajectory::Trajectories;
    let mut tracks = Trajectories::empty(9, (5, 5));
    tracks.push(5, [(1.0, 1.0, 0.0)]);
    // Compiled with the library, not with this test.
    let before_its_start = std::panic::catch_unwind(|| tracks.point(0, std::hint::black_box(2)));
    assert!(before_its_start.is_err(), "overflow-checks are off in the profile of tests");
}

/// For `tests/native/differ.test.mjs`, which names the folder and the seeds in the environment.
#[test]
#[ignore = "called by tests/native/differ.test.mjs"]
fn sessions_are_recorded() {
    let folder = std::env::var_os("TRACECUT_SESSIONS");
    let (Some(folder), Some(seeds)) = (folder, seeds_of_environment()) else { return };
    seeds.for_each(|seed| sessions::write_session(Path::new(&folder), seed));
}

/// The readers of the library.
const READERS: [Reader; 3] = [
    ("image_file", invariants::image_file),
    ("tracks_dat", invariants::tracks_dat),
    ("parameters", invariants::parameters),
];

#[test]
fn files_with_faults_give_an_error_or_a_valid_value() {
    read_with_faults(&READERS, 0..4000);
}

#[test]
#[ignore = "a minute; part of npm run test:long"]
fn many_more_files_with_faults() {
    read_with_faults(&READERS, 4000..204_000);
}

#[test]
fn seed_files_are_valid() {
    use tracecut::tracks;
    for (target, name, bytes) in seeds::all() {
        let text = || String::from_utf8(bytes.clone()).unwrap();
        let read = match target {
            "image_file" => tracecut::image::Frame::decode(&bytes).map(drop),
            "tracks_dat" => tracks::parse(&text()).map(drop),
            _ => Ok(()),
        };
        assert_eq!(read.is_err(), name == "palette-of-4.png", "{target}/{name}: {read:?}");
    }
}

/// Called by `npm run fuzz`.
#[test]
#[ignore = "writes into fuzz/seeds"]
fn seed_files_are_written() {
    for (target, name, bytes) in seeds::all() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds").join(target);
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join(&name), &bytes).unwrap();
    }
}
