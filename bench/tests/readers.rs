//! Ground-truth files with faults: nothing panics, and values are valid.

mod checks;

use crate::helpers::seeds::{Reader, of_target, read_with_faults};
use tracecut_bench::measures::definition::{Definition, parse_pgm};
use tracecut_bench::measures::flow::FlowTruth;

const READERS: [Reader; 3] = [("flo", checks::flo), ("pgm", checks::pgm), ("definition", checks::definition)];

#[test]
fn files_with_faults_give_an_error_or_a_valid_value() {
    read_with_faults(&READERS, 0..4000);
}

#[test]
#[ignore = "a minute; part of npm run test:long"]
fn many_more_files_with_faults() {
    read_with_faults(&READERS, 4000..204_000);
}

/// Reads a file of a target.
fn read(target: &str, bytes: &[u8]) -> Result<(), String> {
    match target {
        "flo" => FlowTruth::from_flo(bytes).map(drop).map_err(|e| e.to_string()),
        "pgm" => parse_pgm(bytes).map(drop).map_err(|e| e.to_string()),
        _ => Definition::parse(str::from_utf8(bytes).unwrap()).map(drop).map_err(|e| e.to_string()),
    }
}

#[test]
fn seed_files_are_valid_and_truncated_ones_are_an_error() {
    for (target, count) in [("flo", 2), ("pgm", 3), ("definition", 1)] {
        let files = of_target(target);
        assert_eq!(files.len(), count, "{target}");
        for (name, bytes) in files {
            assert_eq!(read(target, &bytes), Ok(()), "{name}");
            // A name may be shorter, and a line end of two bytes may be one and a pixel.
            let least = match name.as_str() {
                "Def.dat" => bytes.len() - "a_10.ppm\n".len(),
                "crlf.pgm" => bytes.len() - 1,
                _ => bytes.len(),
            };
            for length in 0..least {
                let reason = read(target, &bytes[..length]).expect_err(&format!("{length} bytes of {name}"));
                assert!(target != "definition" || reason.starts_with("definition file: "), "{reason}");
            }
        }
    }
}
