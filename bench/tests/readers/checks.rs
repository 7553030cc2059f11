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
