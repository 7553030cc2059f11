//! Files of ground truth with faults: nothing panics, and whatever comes out keeps its laws.

mod checks;

use crate::made::{Reader, read_faulty, seeds};
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
fn the_seeds_of_fuzzing_are_whole_files_and_every_part_of_one_is_an_error() {
    for (target, count) in [("mat", 2), ("flo", 2), ("pgm", 3), ("definition", 1)] {
        let files = seeds(target);
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
    let [plain, packed] = [0, 1].map(|k| mat::parse(&seeds("mat")[k].1).unwrap());
    assert_eq!(plain.len(), 2);
    assert_eq!(plain[0].segmentation.data(), [1, 2, 1, 2, 2, 3]);
    assert_eq!(plain[1].segmentation.data(), [1, 2, 1, 300, 2, 3]);
    assert_eq!(plain[0].boundaries.data(), [false, true, true, true, false, false]);
    assert_eq!((plain[0].boundaries.width(), plain[0].boundaries.height()), (2, 3));
    assert_eq!(packed, plain);
}

#[test]
fn every_damaged_byte_of_a_segmentation_is_an_error_or_segmentations_but_no_panic() {
    let whole = &seeds("mat")[0].1;
    let damaged = (124..whole.len()).flat_map(|index| [0, 1, 0x7f, 0xff].map(|value| (index, value)));
    let errors = damaged.filter(|&(index, value)| {
        let mut bytes = whole.clone();
        bytes[index] = value;
        mat::parse(&bytes).is_err()
    });
    assert!(errors.count() > 100);
    assert!(mat::parse(b"not a MATLAB file at all").unwrap_err().contains("level 5"));
}
