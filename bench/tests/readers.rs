//! Readers of ground truth: any bytes give an error or a valid value. The fuzz targets call them too.

use tracecut_bench::measures::definition::{Definition, parse_pgm};
use tracecut_bench::measures::flow::{FlowTruth, end_point_error};

/// A `.flo` file.
pub fn flo(bytes: &[u8]) {
    let Ok(truth) = FlowTruth::from_flo(bytes) else { return };
    let (flow, known) = (&truth.flow, &truth.known);
    assert_eq!((flow.u.data().len(), flow.v.data().len()), (known.data().len(), known.data().len()));
    assert!(flow.u.data().iter().chain(flow.v.data()).all(|v| v.is_finite()));
    assert_eq!(end_point_error(flow, &truth), Ok(0.0));
}

/// A mask of the Moseg benchmark.
pub fn pgm(bytes: &[u8]) {
    let Ok(mask) = parse_pgm(bytes) else { return };
    assert_eq!(mask.data().len(), mask.width() * mask.height());
    let plain = [format!("P5\n{} {}\n255\n", mask.width(), mask.height()).as_bytes(), mask.data()].concat();
    // A first pixel of 10 after a line end of one byte stays a pixel, as no byte is left over.
    assert_eq!(parse_pgm(&plain).unwrap(), mask);
}

/// A shot's definition.
pub fn definition(bytes: &[u8]) {
    let Ok(definition) = Definition::parse(&String::from_utf8_lossy(bytes)) else { return };
    let regions = definition.num_regions();
    assert!((1..=256).contains(&regions) && !definition.labelled.is_empty());
    assert!(definition.penalty.len() == regions && definition.penalty.iter().all(|row| row.len() == regions));
    assert!(definition.labelled_within(usize::MAX).count() <= definition.labelled.len());
}

#[cfg(test)]
mod tests {
    use crate::helpers::seeds::{Reader, of_target, read_with_faults};
    use tracecut_bench::measures::definition::{Definition, parse_pgm};
    use tracecut_bench::measures::flow::FlowTruth;

    const READERS: [Reader; 3] = [("flo", super::flo), ("pgm", super::pgm), ("definition", super::definition)];

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
}
