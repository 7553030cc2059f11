//! Numbered PNG files: `00000.png`, `00001.png`, ...

use crate::failure::{Failure, Result, cannot_write, create_folder, write};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use png::{BitDepth, ColorType, Compression, Encoder, Filter};
use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

/// The pixels of a picture by format.
#[derive(Debug, Clone, Copy)]
pub enum Pixels<'a> {
    /// Three bytes a pixel.
    Rgb(&'a [u8]),
    /// Four bytes a pixel.
    Rgba(&'a [u8]),
    /// One byte a pixel, black to white.
    Grey(&'a [u8]),
    /// One byte a pixel, the number of a colour of the palette of [`voc_colour`].
    Labels(&'a [u8]),
}

/// A folder of numbered pictures.
#[derive(Debug)]
pub struct Series(PathBuf);

impl Series {
    /// Creates `folder` and removes the pictures of an earlier run from number `keep` on.
    pub fn create(folder: PathBuf, keep: usize) -> Result<Self> {
        create_folder(&folder)?;
        let series = Self(folder);
        series.remove_from(keep);
        Ok(series)
    }

    /// Creates `folder` if it does not exist.
    pub fn open(folder: PathBuf) -> Result<Self> {
        create_folder(&folder)?;
        Ok(Self(folder))
    }

    fn remove_from(&self, first: usize) {
        (first..).map(|index| self.path(index)).take_while(|p| std::fs::remove_file(p).is_ok()).for_each(drop);
    }

    fn path(&self, index: usize) -> PathBuf {
        self.0.join(format!("{index:05}.png"))
    }

    /// Writes picture `index`.
    pub fn write(&self, index: usize, (width, height): (usize, usize), pixels: Pixels<'_>) -> Result<()> {
        let path = self.path(index);
        encode(&path, width as u32, height as u32, pixels)
    }
}

fn encode(path: &Path, width: u32, height: u32, pixels: Pixels<'_>) -> Result<()> {
    let file = File::create(path).map_err(|e| cannot_write(path, &e))?;
    encode_png(BufWriter::new(file), (width, height), pixels).map_err(|e| cannot_write(path, &e.into()))
}

/// Encodes a PNG file.
pub(crate) fn encode_png(
    to: impl Write,
    (width, height): (u32, u32),
    pixels: Pixels<'_>,
) -> std::result::Result<(), png::EncodingError> {
    let mut encoder = Encoder::new(to, width, height);
    encoder.set_depth(BitDepth::Eight);
    let (colour, bytes) = match pixels {
        Pixels::Rgb(bytes) => (ColorType::Rgb, bytes),
        Pixels::Rgba(bytes) => (ColorType::Rgba, bytes),
        Pixels::Grey(bytes) => (ColorType::Grayscale, bytes),
        Pixels::Labels(bytes) => (ColorType::Indexed, bytes),
    };
    encoder.set_color(colour);
    encoder.set_compression(Compression::Fast);
    if colour == ColorType::Indexed {
        encoder.set_palette((0..=255).flat_map(voc_colour).collect::<Vec<u8>>());
        encoder.set_compression(Compression::Balanced);
        // Labels compress better without a filter.
        encoder.set_filter(Filter::NoFilter);
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()
}

/// Writes a single picture, completely or not at all.
pub(crate) fn write_png(path: &Path, bytes: &[u8], size: (usize, usize), color: ExtendedColorType) -> Result<()> {
    let mut png = Vec::new();
    PngEncoder::new(&mut png)
        .write_image(bytes, size.0 as u32, size.1 as u32, color)
        .map_err(|e| Failure::new(format!("cannot be encoded: {e}")).with_subject(path.display()))?;
    write(path, png)
}

/// Reads back the labels of a picture, with its width and height.
pub(crate) fn read_labels(folder: &Path, index: usize) -> Result<(Vec<u8>, usize, usize)> {
    let path = folder.join(format!("{index:05}.png"));
    let failure = |e: &dyn std::fmt::Display| Failure::about(path.display(), format_args!("cannot be read back: {e}"));
    let file = File::open(&path).map_err(|e| failure(&e))?;
    let mut reader = png::Decoder::new(BufReader::new(file)).read_info().map_err(|e| failure(&e))?;
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    let mut labels = vec![0; width * height];
    reader.next_frame(&mut labels).map_err(|e| failure(&e))?;
    Ok((labels, width, height))
}

/// The colour of a label in the palette that the VOC and DAVIS benchmarks share: the label's bits, three at a time from
/// the lowest, become bits of red, green and blue from the highest. 0 is black, 1 (128, 0, 0), 2 (0, 128, 0), 3 (128,
/// 128, 0), 4 (0, 0, 128).
fn voc_colour(label: u8) -> [u8; 3] {
    let bit = |index: usize| (u16::from(label) >> index & 1) as u8;
    std::array::from_fn(|channel| (0..3).map(|place| bit(3 * place + channel) << (7 - place)).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_palette_is_the_one_of_voc() {
        let known = [
            (0, [0, 0, 0]),
            (1, [128, 0, 0]),
            (2, [0, 128, 0]),
            (3, [128, 128, 0]),
            (4, [0, 0, 128]),
            (7, [128, 128, 128]),
            (8, [64, 0, 0]),
            (20, [0, 64, 128]),
            (255, [224, 224, 192]),
        ];
        for (label, colour) in known {
            assert_eq!(voc_colour(label), colour, "label {label}");
        }
        let all: std::collections::BTreeSet<_> = (0..=255).map(voc_colour).collect();
        assert_eq!(all.len(), 256);
    }
}
