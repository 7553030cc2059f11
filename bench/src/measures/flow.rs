//! End-point error of optical flow, and the `.flo` files of the Middlebury benchmark.
//!
//! A `.flo` file holds, little-endian: the float 202021.25, width and height as 32-bit integers, then `(u, v)` pairs of
//! floats row by row. A magnitude above `1e9` means that the true flow there is not known. Source: Baker et al., "A
//! Database and Evaluation Methodology for Optical Flow", IJCV 2011.

use tracecut::Error;
use tracecut::flow::FlowField;
use tracecut::image::{MAX_PIXELS, MAX_SIDE, Plane};

/// The first four bytes of a `.flo` file, as a float.
const TAG: f32 = 202_021.25;
/// Components beyond this mark unknown flow.
const UNKNOWN: f32 = 1e9;

/// True flow of one pair of frames.
///
/// Law: `known` has the size of the flow's planes; where it is false the flow is 0.
#[derive(Debug, Clone, PartialEq)]
pub struct FlowTruth {
    /// True displacement in pixels.
    pub flow: FlowField,
    /// True for pixels with known flow.
    pub known: Plane<bool>,
}

impl FlowTruth {
    /// From the bytes of a `.flo` file.
    ///
    /// # Errors
    /// [`Error::Data`] when the tag is wrong, a side is not in `1..=16384`, or bytes are missing.
    pub fn from_flo(bytes: &[u8]) -> Result<Self, Error> {
        let data = |reason: String| Error::Data { reason };
        let (numbers, _) = bytes.as_chunks::<4>();
        let &[tag, width, height, ref values @ ..] = numbers else {
            return Err(data(format!("flow file has {} bytes (expected at least 12)", bytes.len())));
        };
        if f32::from_le_bytes(tag) != TAG {
            return Err(data(format!("flow file begins with {} (expected {TAG})", f32::from_le_bytes(tag))));
        }
        let (width, height) = (i32::from_le_bytes(width), i32::from_le_bytes(height));
        let legal = 1..=MAX_SIDE as i32;
        let pixels = i64::from(width) * i64::from(height);
        if !legal.contains(&width) || !legal.contains(&height) || pixels > MAX_PIXELS as i64 {
            return Err(data(format!("flow file is {width}x{height} (expected sides in 1..={MAX_SIDE})")));
        }
        let (width, height) = (width as usize, height as usize);
        if values.len() < 2 * width * height {
            let expected = 12 + 8 * width * height;
            return Err(data(format!(
                "flow file has {} bytes (expected {expected} for {width}x{height})",
                bytes.len()
            )));
        }
        let component = |x: usize, y: usize, c: usize| f32::from_le_bytes(values[2 * (y * width + x) + c]);
        // Written so that not-a-number counts as unknown.
        let is_known = Plane::from_fn(width, height, |x, y| (0..2).all(|c| component(x, y, c).abs() <= UNKNOWN));
        let plane = |c| Plane::from_fn(width, height, |x, y| if is_known[(x, y)] { component(x, y, c) } else { 0.0 });
        Ok(Self { flow: FlowField { u: plane(0), v: plane(1) }, known: is_known })
    }
}

/// Mean end-point error in pixels over the pixels whose flow is known; 0 if there are none.
///
/// # Errors
/// [`Error::Data`] when the sizes differ.
pub fn end_point_error(flow: &FlowField, truth: &FlowTruth) -> Result<f64, Error> {
    let size = |f: &FlowField| (f.u.width(), f.u.height());
    let (actual, expected) = (size(flow), size(&truth.flow));
    if actual != expected {
        let reason = format!("flow is {}x{} (expected {}x{})", actual.0, actual.1, expected.0, expected.1);
        return Err(Error::Data { reason });
    }
    let (mut sum, mut count) = (0.0, 0_usize);
    for (i, _) in truth.known.data().iter().enumerate().filter(|(_, known)| **known) {
        let du = f64::from(flow.u.data()[i] - truth.flow.u.data()[i]);
        let dv = f64::from(flow.v.data()[i] - truth.flow.v.data()[i]);
        sum += du.hypot(dv);
        count += 1;
    }
    Ok(sum / count.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flo(width: i32, height: i32, values: &[f32]) -> Vec<u8> {
        let mut bytes = TAG.to_le_bytes().to_vec();
        bytes.extend([width, height].iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        bytes
    }

    #[test]
    fn a_file_is_read_and_unknown_pixels_do_not_count() {
        let truth = FlowTruth::from_flo(&flo(3, 1, &[1.0, 2.0, 1.7e9, 0.0, f32::NAN, 0.0])).unwrap();
        assert_eq!(truth.known.data(), [true, false, false]);
        assert_eq!(truth.flow.v.data(), [2.0, 0.0, 0.0]);
        let guess = FlowField { u: Plane::filled(3, 1, 4.0), v: Plane::filled(3, 1, 6.0) };
        assert_eq!(end_point_error(&guess, &truth), Ok(5.0));
        assert!(end_point_error(&FlowField::default(), &truth).is_err());
    }

    #[test]
    fn broken_files_are_errors() {
        let whole = flo(2, 2, &[0.5; 8]);
        assert!(FlowTruth::from_flo(&whole).is_ok());
        assert_eq!(FlowTruth::from_flo(&whole[..12]).unwrap_err().code(), "data");
        for (width, height) in [(0, 2), (-1, 2), (i32::MAX, i32::MAX), (16_384, 16_384)] {
            assert!(FlowTruth::from_flo(&flo(width, height, &[0.0; 8])).is_err(), "{width}x{height}");
        }
        assert!(FlowTruth::from_flo(&[0; 64]).is_err());
    }
}
