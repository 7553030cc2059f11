//! The ground truth of a Moseg shot: its definition file (`Def.dat`) and the PGM masks of its labelled frames.
//!
//! The definition names the grey value of each region, a matrix of how bad it is to confuse two regions, the number of
//! frames of the whole shot, and the labelled frames with their masks. Headings end in a colon and the values follow on
//! the next line. The region numbers within the headings are unreliable in the published files (typing errors); their
//! order is right and is what counts here.

use image::codecs::pnm::{PnmDecoder, PnmSubtype, SampleEncoding};
use tracecut::Error;
use tracecut::image::Plane;

/// A shot's definition file.
#[derive(Debug, Clone, PartialEq)]
pub struct Definition {
    /// Grey value of each region in the masks.
    pub grey: Vec<u8>,
    /// `penalty[a][b]`, for every region's pair: weight of a point of region `b` in a cluster that stands for region
    /// `a`.
    pub penalty: Vec<Vec<f64>>,
    /// Number of frames of the whole shot.
    pub num_frames: usize,
    /// The labelled frames, in the file's order.
    pub labelled: Vec<LabelledFrame>,
}

/// A frame with ground truth.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LabelledFrame {
    /// Index in the shot's list of frames, from 0.
    pub index: usize,
    /// File name of its mask.
    pub mask: String,
    /// File name of the image.
    pub image: String,
}

impl Definition {
    /// Reads the text of a definition file.
    ///
    /// # Errors
    /// [`Error::Data`] naming what is missing or not legal.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let mut values = Values { lines: text.lines() };
        let num_regions: usize = values.after("Total number of regions")?;
        let grey = (0..num_regions).map(|_| values.after("Scale of region")).collect::<Result<Vec<u8>, _>>()?;
        values.heading("Confusion pen")?;
        let penalty = (0..num_regions).map(|_| values.numbers(num_regions)).collect::<Result<Vec<_>, _>>()?;
        let num_frames = values.after("Total number of frames")?;
        let num_labelled: usize = values.after("Total number of labeled frames")?;
        let mut labelled = Vec::new();
        for _ in 0..num_labelled {
            labelled.push(LabelledFrame {
                index: values.after("Frame number")?,
                mask: values.after("File name")?,
                image: values.after("Input file name")?,
            });
        }
        if !(1..=255).contains(&num_regions) || labelled.is_empty() {
            return Err(broken(format!(
                "it has {num_regions} regions (expected 1..=255) and {num_labelled} labelled frames (expected at least 1)"
            )));
        }
        Ok(Self { grey, penalty, num_frames, labelled })
    }

    /// Number of regions, the background included.
    pub fn num_regions(&self) -> usize {
        self.grey.len()
    }

    /// The labelled frames within the first `num_frames` frames of the shot.
    pub fn labelled_within(&self, num_frames: usize) -> impl Iterator<Item = &LabelledFrame> {
        self.labelled.iter().filter(move |frame| frame.index < num_frames)
    }

    /// The region of each pixel of a mask. Grey values that the definition does not name count as region 0.
    pub fn regions(&self, mask: &Plane<u8>) -> Plane<u8> {
        let mut region = [0_u8; 256];
        for (r, &grey) in self.grey.iter().enumerate().rev() {
            region[grey as usize] = r as u8;
        }
        mask.map(|grey| region[grey as usize])
    }
}

fn broken(reason: String) -> Error {
    Error::Data { reason: format!("definition file: {reason}") }
}

/// Walks from heading to heading.
struct Values<'a> {
    lines: std::str::Lines<'a>,
}

impl<'a> Values<'a> {
    /// Skips to the heading that starts with `name`.
    fn heading(&mut self, name: &str) -> Result<(), Error> {
        match self.lines.find(|l| l.trim_start().starts_with(name)) {
            Some(_) => Ok(()),
            None => Err(broken(format!("no (further) line \"{name} ...:\""))),
        }
    }

    /// The next line with something on it.
    fn line(&mut self, after: &str) -> Result<&'a str, Error> {
        let line = self.lines.by_ref().map(str::trim).find(|l| !l.is_empty());
        line.ok_or_else(|| broken(format!("it ends after \"{after}\" (expected a value)")))
    }

    /// The value on the line below the heading that starts with `name`.
    fn after<T: std::str::FromStr>(&mut self, name: &str) -> Result<T, Error> {
        self.heading(name)?;
        let text = self.line(name)?;
        text.parse().map_err(|_| broken(format!("\"{name} ...:\" is \"{text}\" (expected a value of its kind)")))
    }

    /// A line of `count` numbers.
    fn numbers(&mut self, count: usize) -> Result<Vec<f64>, Error> {
        let text = self.line("Confusion penality matrix")?;
        let row: Option<Vec<f64>> = text.split_whitespace().map(|w| w.parse().ok()).collect();
        row.filter(|r| r.len() == count && r.iter().all(|p| p.is_finite()))
            .ok_or_else(|| broken(format!("row \"{text}\" of the penalty matrix (expected {count} numbers)")))
    }
}

/// Reads a binary PGM file (`P5`, at most 255 grey values).
///
/// Some masks of the benchmark end their header in CR LF; both bytes are skipped where the file is long enough for
/// that.
///
/// # Errors
/// [`Error::Data`] when the file is of another kind or truncated.
pub fn parse_pgm(bytes: &[u8]) -> Result<Plane<u8>, Error> {
    let broken = |reason: &dyn std::fmt::Display| Error::Data {
        reason: format!("mask: {reason} (expected a binary PGM file, P5, 8 bit)"),
    };
    let (rest, header) = PnmDecoder::new(bytes).map_err(|e| broken(&e))?.into_inner();
    if header.subtype() != PnmSubtype::Graymap(SampleEncoding::Binary) || header.maximal_sample() > 255 {
        return Err(broken(&"it is of another kind"));
    }
    let (width, height) = (header.width() as usize, header.height() as usize);
    let size = width.checked_mul(height).filter(|&size| size > 0).ok_or_else(|| broken(&"its size is broken"))?;
    let ends_in_two =
        bytes[..bytes.len() - rest.len()].ends_with(b"\r") && rest.starts_with(b"\n") && rest.len() > size;
    let pixels = rest.get(usize::from(ends_in_two)..).and_then(|pixels| pixels.get(..size));
    let pixels = pixels.ok_or_else(|| broken(&"it is truncated"))?;
    Plane::from_vec(width, height, pixels.to_vec()).ok_or_else(|| broken(&"its size is broken"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "Ground truth definition file\n\nTotal number of regions:\n2\nScale of region 0:\n0\nScale of region 7:\n255\n\n\
        Confusion penality matrix:\n0 0.5 \n1   0\n\nTotal number of frames in this shot:\n30\n\
        Total number of labeled frames for this shot:\n2\nFrame number:\n0\nFile name:\na_01.pgm\nInput file name:\na_01.ppm\n\
        Frame number:\n9\r\nFile name:\na_10.pgm\nInput file name:\na_10.ppm";

    #[test]
    fn definition_files_are_read_by_the_order_of_their_lines() {
        let definition = Definition::parse(TEXT).unwrap();
        assert_eq!(definition.grey, [0, 255]);
        assert_eq!(definition.penalty, [[0.0, 0.5], [1.0, 0.0]]);
        assert_eq!(definition.num_frames, 30);
        assert_eq!(definition.labelled_within(9).count(), 1);
        assert_eq!(definition.labelled_within(10).count(), 2);
        assert_eq!(definition.labelled[1].mask, "a_10.pgm");
        assert_eq!(definition.labelled[1].image, "a_10.ppm");
    }

    #[test]
    fn penalties_of_other_numbers_are_an_error() {
        let error = Definition::parse(&TEXT.replace("0 0.5", "0 0.5 3")).unwrap_err();
        assert!(error.to_string().contains("expected 2 numbers"), "{error}");
    }

    #[test]
    fn unnamed_grey_values_count_as_region_0() {
        let mask = Plane::from_vec(3, 1, vec![255, 57, 0]).unwrap();
        assert_eq!(Definition::parse(TEXT).unwrap().regions(&mask).data(), [1, 0, 0]);
    }

    #[test]
    fn pgm_headers_may_end_in_either_line_end() {
        let pixels = [10, 13, 10, 200];
        for header in ["P5\n2 2\n255\n", "P5\r\n2 2\r\n255\r\n", "P5 2 2 255 ", "P5\n# a b\n2 2\n# c\n255\n"] {
            let mask = parse_pgm(&[header.as_bytes(), &pixels].concat()).unwrap();
            assert_eq!((mask.width(), mask.data()), (2, &pixels[..]), "{header:?}");
        }
        // A lone CR, and a first pixel that happens to be 10.
        assert_eq!(parse_pgm(&[b"P5 2 2 255\r", &pixels[..]].concat()).unwrap().data(), pixels);
    }

    #[test]
    fn broken_pgm_files_are_an_error() {
        for text in [
            "P6\n1 1\n255\n123",
            "P5\n0 1\n255\n1",
            "P5\n9999999 9999999\n255\n",
            "P5\n1 1\n65535\n12",
            "P5\n-1 1\n255\n1",
        ] {
            assert!(parse_pgm(text.as_bytes()).is_err(), "{text}");
        }
    }
}
