//! Small clips of any content, under any legal parameters, in any order of calls, and files with faults: nothing
//! panics, and whatever comes out keeps its laws. The fuzz targets of `fuzz/` call the same functions.
//!
//! `TRACECUT_SEEDS=FIRST..LAST` runs other seeds than the usual ones and prints what takes long.

use crate::made::choices::Choices;
use crate::made::{images, mutate, readers, recorded, seeds, sessions};
use std::ops::Range;
use std::path::Path;
use std::time::Instant;

/// Runs `one` with each seed.
fn run(name: &str, seeds: Range<u64>, one: fn(&mut Choices<'_>)) {
    let asked = asked_for();
    for seed in asked.clone().unwrap_or(seeds) {
        let begin = Instant::now();
        let outcome = std::panic::catch_unwind(|| one(&mut Choices::of_seed(seed, name)));
        assert!(outcome.is_ok(), "seed {seed}");
        let seconds = begin.elapsed().as_secs_f64();
        if asked.is_some() && seconds > 1.0 {
            println!("{name}, seed {seed}: {seconds:.1} s");
        }
    }
}

fn asked_for() -> Option<Range<u64>> {
    let text = std::env::var("TRACECUT_SEEDS").ok()?;
    let (first, last) = text.split_once("..").expect("TRACECUT_SEEDS=FIRST..LAST");
    Some(first.parse().unwrap()..last.parse().unwrap())
}

#[test]
fn any_small_clip_under_any_legal_parameters_keeps_the_laws() {
    run("random", 0..150, sessions::any_calls);
}

#[test]
fn any_outside_trajectories_keep_the_laws() {
    run("tracks", 0..300, sessions::outside_tracks);
}

#[test]
fn a_stroke_whose_label_loses_its_last_trajectory_holds_nothing() {
    // Found by the run of many more: the mask had a label that no cluster had.
    run("tracks", 4459..4460, sessions::outside_tracks);
}

#[test]
fn corrections_that_are_taken_back_leave_nothing() {
    run("corrections", 0..60, sessions::corrections);
}

#[test]
fn a_run_in_two_halves_on_any_threads_is_a_run_in_one() {
    run("halves", 0..60, sessions::two_ways);
}

#[test]
fn windows_that_stop_and_resume_are_windows_that_do_not() {
    run("windows", 0..30, sessions::windows);
}

#[test]
fn any_image_under_any_legal_parameters_keeps_the_laws() {
    run("image", 0..200, images::any_image);
}

#[test]
#[ignore = "some minutes; part of npm run test:long"]
fn many_more_small_clips() {
    run("random", 1000..21_000, sessions::any_calls);
}

#[test]
#[ignore = "some minutes; part of npm run test:long"]
fn many_more_of_the_others() {
    run("tracks", 1000..11_000, sessions::outside_tracks);
    run("corrections", 1000..4000, sessions::corrections);
    run("halves", 1000..4000, sessions::two_ways);
    run("windows", 1000..2000, sessions::windows);
    run("image", 1000..11_000, images::any_image);
}

#[test]
fn numbers_that_do_not_fit_end_a_test() {
    use tracecut::trajectory::Trajectories;
    let mut tracks = Trajectories::empty(9, (5, 5));
    tracks.push(5, [(1.0, 1.0, 0.0)]);
    // Compiled with the library, not with this test.
    let before_its_begin = std::panic::catch_unwind(|| tracks.point(0, std::hint::black_box(2)));
    assert!(before_its_begin.is_err(), "overflow-checks are off in the profile of tests");
}

/// For `tests/differ.mjs`, which names the folder, and what `TRACECUT_SEEDS` are to be written there.
#[test]
#[ignore = "called by tests/differ.mjs"]
fn sessions_are_written_down() {
    let folder = std::env::var_os("TRACECUT_SESSIONS");
    let (Some(folder), Some(seeds)) = (folder, asked_for()) else { return };
    seeds.for_each(|seed| recorded::write(Path::new(&folder), seed));
}

/// A target, and what it calls.
type Reader = (&'static str, fn(&[u8]));

/// A reader of the library, and the target whose seeds it reads.
const READERS: [Reader; 3] =
    [("image_file", readers::image_file), ("tracks_dat", readers::tracks_dat), ("parameters", readers::parameters)];

fn read_faulty(seeds: Range<u64>) {
    for (target, reader) in READERS {
        let files: Vec<Vec<u8>> = seeds::all().into_iter().filter(|s| s.0 == target).map(|s| s.2).collect();
        assert!(!files.is_empty(), "{target}");
        files.iter().for_each(|file| reader(file));
        for seed in seeds.clone() {
            let mut choices = Choices::of_seed(seed, target);
            let (file, other) = (choices.below(files.len()), choices.below(files.len()));
            let bytes = mutate::mutated(&mut choices, &files[file], &files[other]);
            let outcome = std::panic::catch_unwind(|| reader(&bytes));
            assert!(outcome.is_ok(), "{target}, seed {seed}: {bytes:?}");
        }
    }
}

#[test]
fn files_with_faults_are_an_error_or_keep_the_laws() {
    read_faulty(0..4000);
}

#[test]
#[ignore = "a minute; part of npm run test:long"]
fn many_more_files_with_faults() {
    read_faulty(4000..204_000);
}

#[test]
fn images_and_files_that_fuzzing_begins_with_are_whole() {
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
fn seeds_of_fuzzing_are_written() {
    for (target, name, bytes) in seeds::all() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds").join(target);
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join(&name), &bytes).unwrap();
    }
}
