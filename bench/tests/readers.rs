//! Ground-truth files with faults: nothing panics, and values are valid.

mod checks;

use crate::helpers::seeds::{Reader, of_target, read_with_faults};
use tracecut_bench::mat;
use tracecut_bench::measures::definition::{Definition, parse_pgm};
use tracecut_bench::measures::flow::FlowTruth;

const READERS: [Reader; 4] =
    [("mat", checks::mat), ("flo", checks::flo), ("pgm", checks::pgm), ("definition", checks::definition)];

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
        "mat" => mat::parse(bytes).map(drop),
        "flo" => FlowTruth::from_flo(bytes).map(drop).map_err(|e| e.to_string()),
        "pgm" => parse_pgm(bytes).map(drop).map_err(|e| e.to_string()),
        _ => Definition::parse(str::from_utf8(bytes).unwrap()).map(drop).map_err(|e| e.to_string()),
    }
}

#[test]
fn seed_files_are_valid_and_truncated_ones_are_an_error() {
    for (target, count) in [("mat", 2), ("flo", 2), ("pgm", 3), ("definition", 1)] {
        let files = of_target(target);
        assert_eq!(files.len(), count, "{target}");
        for (name, bytes) in files {
            assert_eq!(read(target, &bytes), Ok(()), "{name}");
            // Padding may be missing, a name may be shorter, and a line end of two bytes may be one and a pixel.
            let least = match name.as_str() {
                "plain.mat" | "packed.mat" => bytes.len() - 8,
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

#[test]
fn packed_and_plain_segmentations_are_the_same_row_by_row() {
    let [plain, packed] = [0, 1].map(|k| mat::parse(&of_target("mat")[k].1).unwrap());
    assert_eq!(plain.len(), 2);
    assert_eq!(plain[0].segmentation.data(), [1, 2, 1, 2, 2, 3]);
    assert_eq!(plain[1].segmentation.data(), [1, 2, 1, 300, 2, 3]);
    assert_eq!(plain[0].boundaries.data(), [false, true, true, true, false, false]);
    assert_eq!((plain[0].boundaries.width(), plain[0].boundaries.height()), (2, 3));
    assert_eq!(packed, plain);
}

#[test]
fn every_damaged_byte_of_a_segmentation_is_an_error_or_segmentations_but_no_panic() {
    let whole = &of_target("mat")[0].1;
    let damaged = (124..whole.len()).flat_map(|index| [0, 1, 0x7f, 0xff].map(|value| (index, value)));
    let errors = damaged.filter(|&(index, value)| {
        let mut bytes = whole.clone();
        bytes[index] = value;
        mat::parse(&bytes).is_err()
    });
    assert!(errors.count() > 100);
    assert!(mat::parse(b"not a MATLAB file at all").unwrap_err().contains("level 5"));
}
