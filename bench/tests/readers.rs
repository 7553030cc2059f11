//! Files of ground truth with faults: nothing panics, and whatever comes out keeps its laws.

mod checks;
#[path = "../../cli/tests/readers/faulty.rs"]
mod faulty;

use faulty::{Reader, read_faulty, seeds};
use tracecut_bench::mat;
use tracecut_bench::measures::definition::{Definition, parse_pgm};
use tracecut_bench::measures::flow::FlowTruth;

const READERS: [Reader; 4] =
    [("mat", checks::mat), ("flo", checks::flo), ("pgm", checks::pgm), ("definition", checks::definition)];

#[test]
fn files_with_faults_are_an_error_or_keep_the_laws() {
    for (target, reader) in READERS {
        seeds(target).iter().for_each(|(_, file)| reader(file));
    }
    read_faulty(&READERS, 0..4000);
}

#[test]
#[ignore = "a minute; part of npm run test:long"]
fn many_more_files_with_faults() {
    read_faulty(&READERS, 4000..204_000);
}

#[test]
fn the_seeds_of_fuzzing_are_whole_files() {
    for (target, count) in [("mat", 2), ("flo", 2), ("pgm", 3), ("definition", 1)] {
        let files = seeds(target);
        assert_eq!(files.len(), count, "{target}");
        for (name, bytes) in files {
            let read = match target {
                "mat" => mat::parse(&bytes).map(drop),
                "flo" => FlowTruth::from_flo(&bytes).map(drop).map_err(|e| e.to_string()),
                "pgm" => parse_pgm(&bytes).map(drop).map_err(|e| e.to_string()),
                _ => Definition::parse(&String::from_utf8(bytes).unwrap()).map(drop).map_err(|e| e.to_string()),
            };
            assert_eq!(read, Ok(()), "{name}");
        }
    }
}
