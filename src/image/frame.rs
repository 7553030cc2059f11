//! `Frame`: one colour image of the clip, eight bits a channel.

use super::Plane;
use crate::Error;

/// Longest side accepted, in pixels.
pub const MAX_SIDE: usize = 16_384;
/// Most pixels accepted in one frame.
pub const MAX_PIXELS: usize = 1 << 26;

/// An RGB image; three bytes a pixel, row by row.
///
/// Law: `rgb.len() == 3 * width * height`, both sides in `1..=MAX_SIDE`.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    rgb: Vec<u8>,
    width: usize,
    height: usize,
}

impl Frame {
    /// From RGBA bytes, four a pixel, as `ImageData` holds them; alpha is ignored.
    ///
    /// # Errors
    /// [`Error::FrameSize`] or [`Error::FrameBytes`].
    pub fn from_rgba(rgba: &[u8], width: usize, height: usize) -> Result<Self, Error> {
        check_size(width, height)?;
        if rgba.len() != 4 * width * height {
            return Err(Error::FrameBytes { expected: 4 * width * height, actual: rgba.len() });
        }
        let mut rgb = Vec::with_capacity(3 * width * height);
        for pixel in rgba.chunks_exact(4) {
            rgb.extend_from_slice(&pixel[..3]);
        }
        Ok(Self { rgb, width, height })
    }

    /// From RGB bytes, three a pixel.
    ///
    /// # Errors
    /// [`Error::FrameSize`] or [`Error::FrameBytes`].
    pub fn from_rgb(rgb: Vec<u8>, width: usize, height: usize) -> Result<Self, Error> {
        check_size(width, height)?;
        if rgb.len() != 3 * width * height {
            return Err(Error::FrameBytes { expected: 3 * width * height, actual: rgb.len() });
        }
        Ok(Self { rgb, width, height })
    }

    /// From the bytes of a PNG or JPEG file (and GIF's first image with the `cli` feature).
    ///
    /// # Errors
    /// [`Error::Decode`] when the file is truncated, broken or of another kind; [`Error::FrameSize`] when it is too large.
    pub fn decode(bytes: &[u8]) -> Result<Self, Error> {
        let decode_error = |e: &dyn std::fmt::Display| Error::Decode { reason: e.to_string() };
        let mut reader =
            image::ImageReader::new(std::io::Cursor::new(bytes)).with_guessed_format().map_err(|e| decode_error(&e))?;
        let mut limits = image::Limits::default();
        limits.max_image_width = Some(MAX_SIDE as u32);
        limits.max_image_height = Some(MAX_SIDE as u32);
        reader.limits(limits);
        if reader.format() == Some(image::ImageFormat::Jpeg) && !jpeg_is_whole(bytes) {
            return Err(Error::Decode { reason: "the JPEG data are truncated".to_owned() });
        }
        let rgb = reader.decode().map_err(|e| decode_error(&e))?.into_rgb8();
        let (width, height) = (rgb.width() as usize, rgb.height() as usize);
        Self::from_rgb(rgb.into_raw(), width, height)
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The bytes, three a pixel, row by row.
    pub fn rgb(&self) -> &[u8] {
        &self.rgb
    }

    /// Brightness in `0.0..=255.0` (ITU-R BT.601 weights).
    pub fn luma(&self) -> Plane<f32> {
        let data = self
            .rgb
            .chunks_exact(3)
            .map(|p| 0.299 * f32::from(p[0]) + 0.587 * f32::from(p[1]) + 0.114 * f32::from(p[2]))
            .collect();
        Plane::from_vec(self.width, self.height, data).unwrap_or_default()
    }

    /// Colour channel `c` (0 red, 1 green, 2 blue) in `0.0..=255.0`.
    pub fn channel(&self, c: usize) -> Plane<f32> {
        Plane::from_vec(self.width, self.height, self.rgb[c..].iter().step_by(3).map(|&v| f32::from(v)).collect())
            .unwrap_or_default()
    }

    /// A copy of `width × height` pixels, each the mean of the area that it covers. Meant for making frames smaller.
    pub fn resized(&self, width: usize, height: usize) -> Self {
        if (width, height) == (self.width, self.height) {
            return self.clone();
        }
        let columns = coverage(self.width, width);
        let rows = coverage(self.height, height);
        let mut rgb = Vec::with_capacity(3 * width * height);
        let mut line = vec![0.0_f32; 3 * self.width];
        for row in &rows {
            line.fill(0.0);
            for &(y, weight) in row {
                let source = &self.rgb[3 * y * self.width..3 * (y + 1) * self.width];
                for (sum, &value) in line.iter_mut().zip(source) {
                    *sum += weight * f32::from(value);
                }
            }
            for column in &columns {
                for c in 0..3 {
                    let value: f32 = column.iter().map(|&(x, weight)| weight * line[3 * x + c]).sum();
                    rgb.push((value + 0.5) as u8);
                }
            }
        }
        Self { rgb, width, height }
    }
}

/// Whether the end-of-image marker follows the first scan. The decoder paints what is missing of a truncated file grey instead
/// of failing, and grey areas that come and go would pass for motion.
fn jpeg_is_whole(bytes: &[u8]) -> bool {
    const START_OF_SCAN: u8 = 0xda;
    const END_OF_IMAGE: [u8; 2] = [0xff, 0xd9];
    // Walk over the header's segments by their lengths: a thumbnail in one of them has an end marker of its own.
    let mut rest = bytes.get(2..).unwrap_or(&[]);
    while let [0xff, marker, high, low, ..] = *rest {
        if marker == START_OF_SCAN {
            return rest.windows(2).any(|w| w == END_OF_IMAGE);
        }
        // A fill byte stands before some markers.
        let length = if marker == 0xff { 1 } else { 2 + usize::from(u16::from_be_bytes([high, low])) };
        rest = rest.get(length..).unwrap_or(&[]);
    }
    false
}

/// For each of `to` cells over `from` pixels: the pixels that it covers and their shares, summing to one.
fn coverage(from: usize, to: usize) -> Vec<Vec<(usize, f32)>> {
    let scale = from as f64 / to as f64;
    (0..to)
        .map(|cell| {
            let (begin, end) = (cell as f64 * scale, (cell + 1) as f64 * scale);
            let last = (end.ceil() as usize).min(from);
            (begin as usize..last)
                .map(|i| (i, ((end.min((i + 1) as f64) - begin.max(i as f64)) / scale) as f32))
                .filter(|&(_, share)| share > 0.0)
                .collect()
        })
        .collect()
}

fn check_size(width: usize, height: usize) -> Result<(), Error> {
    let legal = 1..=MAX_SIDE;
    if legal.contains(&width) && legal.contains(&height) && width * height <= MAX_PIXELS {
        Ok(())
    } else {
        Err(Error::FrameSize { width, height })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_byte_counts_are_checked() {
        assert_eq!(Frame::from_rgba(&[], 0, 5), Err(Error::FrameSize { width: 0, height: 5 }));
        assert_eq!(Frame::from_rgba(&[0; 15], 2, 2), Err(Error::FrameBytes { expected: 16, actual: 15 }));
        assert!(Frame::from_rgba(&[0; 4], 1, 1).is_ok());
        assert!(Frame::from_rgba(&[], usize::MAX, 2).is_err());
    }

    #[test]
    fn halving_averages_blocks_of_four() {
        let rgb: Vec<u8> = [0, 20, 40, 60, 10, 30, 50, 70].iter().flat_map(|&v| [v, v, v]).collect();
        let half = Frame::from_rgb(rgb, 4, 2).unwrap().resized(2, 1);
        assert_eq!(half.rgb(), [15, 15, 15, 55, 55, 55]);
    }

    #[test]
    fn resizing_keeps_a_flat_colour_at_any_ratio() {
        let flat = Frame::from_rgb(vec![90; 3 * 17 * 13], 17, 13).unwrap();
        assert!(flat.resized(5, 4).rgb().iter().all(|&v| v == 90));
    }

    #[test]
    fn truncated_files_are_an_error() {
        assert_eq!(Frame::decode(b"\x89PNG\r\n\x1a\n").unwrap_err().code(), "decode");
        assert_eq!(Frame::decode(b"").unwrap_err().code(), "decode");
    }

    #[test]
    fn every_truncation_of_a_jpeg_is_an_error() {
        let mut jpeg = Vec::new();
        let pixels: Vec<u8> = (0..3 * 24 * 16_u32).map(|i| ((i * i * 31) >> 4) as u8).collect();
        let encoder = image::codecs::jpeg::JpegEncoder::new(&mut jpeg);
        image::ImageEncoder::write_image(encoder, &pixels, 24, 16, image::ExtendedColorType::Rgb8).unwrap();
        assert_eq!(Frame::decode(&jpeg).unwrap().width(), 24);
        for length in 0..jpeg.len() {
            assert_eq!(
                Frame::decode(&jpeg[..length]).unwrap_err().code(),
                "decode",
                "{length} of {} bytes",
                jpeg.len()
            );
        }
    }
}
