//! Numbered PNG files (`00000.png`, `00001.png`, ...), and trajectory points drawn over frames.

use crate::failure::{Failure, Result, cannot_write, create_folder, write};
use crate::window::WindowResult;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use png::{BitDepth, ColorType, Compression, Encoder, Filter};
use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use tracecut::discretize::Clusters;
use tracecut::image::Frame;
use tracecut::trajectory::Trajectories;

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

/// Colours of labels 0, 1, ...: a pale grey for the largest cluster, which is mostly the background, then the palette
/// of Okabe and Ito (2008), designed to be distinguishable with any colour vision, then darker and lighter variants of it.
/// Starts again after the last.
pub(crate) const PALETTE: [[u8; 3]; 16] = [
    [222, 222, 222],
    [230, 159, 0],
    [86, 180, 233],
    [0, 158, 115],
    [240, 228, 66],
    [213, 94, 0],
    [0, 114, 178],
    [204, 121, 167],
    [138, 90, 0],
    [180, 225, 255],
    [0, 90, 66],
    [255, 182, 138],
    [120, 40, 0],
    [150, 140, 255],
    [110, 50, 85],
    [160, 235, 120],
];

/// Brightness of the frame under the points, so that pale and dark points are both visible; chosen by eye.
const FRAME_SHARE: f32 = 0.75;

/// Draws the trajectories of a window over the frames that it settles, into `folder`.
pub(crate) fn write_points(window: &WindowResult<'_>, folder: PathBuf) -> Result<()> {
    let (points, results) = (Series::open(folder)?, window.results()?);
    for t in window.settled.clone() {
        let frame = window.frame(t)?;
        let picture = draw_points(frame, t, results.tracks, results.clusters);
        points.write(window.first + t, (frame.width(), frame.height()), Pixels::Rgb(&picture))?;
    }
    Ok(())
}

/// The frame, dimmed, with a disc for each trajectory alive in it; RGB.
fn draw_points(frame: &Frame, index: usize, tracks: &Trajectories, clusters: &Clusters) -> Vec<u8> {
    let mut canvas = Canvas {
        rgb: frame.rgb().iter().map(|&v| (f32::from(v) * FRAME_SHARE) as u8).collect(),
        width: frame.width(),
        height: frame.height(),
    };
    // About 2 pixels in a 640-pixel image: apart at the default spacing, and still visible when the image is shown
    // small.
    let radius = (frame.width().max(frame.height()) as f32 / 280.0).max(0.9);
    for (i, x, y) in tracks.alive(index) {
        canvas.disc((x, y), radius + 0.35 * radius.min(2.5), [0, 0, 0], 0.6);
        canvas.disc((x, y), radius, PALETTE[clusters.label[i] as usize % PALETTE.len()], 1.0);
    }
    canvas.rgb
}

struct Canvas {
    rgb: Vec<u8>,
    width: usize,
    height: usize,
}

impl Canvas {
    /// Blends a disc over the picture; its edge is a ramp one pixel wide.
    fn disc(&mut self, (cx, cy): (f32, f32), radius: f32, colour: [u8; 3], opacity: f32) {
        let reach = radius + 0.5;
        let span =
            |c: f32, end: usize| (c - reach).ceil().max(0.0) as usize..((c + reach + 1.0).max(0.0) as usize).min(end);
        for y in span(cy, self.height) {
            for x in span(cx, self.width) {
                let distance = (x as f32 - cx).hypot(y as f32 - cy);
                let cover = (reach - distance).clamp(0.0, 1.0) * opacity;
                let pixel = 3 * (y * self.width + x);
                for (value, new) in self.rgb[pixel..pixel + 3].iter_mut().zip(colour) {
                    *value = (f32::from(*value) + cover * (f32::from(new) - f32::from(*value)) + 0.5) as u8;
                }
            }
        }
    }
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

    #[test]
    fn discs_cover_their_area_and_stay_inside_the_picture() {
        let mut canvas = Canvas { rgb: vec![0; 3 * 21 * 15], width: 21, height: 15 };
        canvas.disc((10.3, 7.6), 4.0, [255, 0, 0], 1.0);
        let area: f32 = canvas.rgb.iter().step_by(3).map(|&v| f32::from(v) / 255.0).sum();
        assert!((area - 16.0 * std::f32::consts::PI).abs() < 1.0, "area {area}");
        for place in [(-30.0, 2.0), (0.0, 0.0), (20.0, 14.0), (1e9, -1e9)] {
            canvas.disc(place, 2.0, [0, 255, 0], 1.0);
        }
        assert_eq!(canvas.rgb[1], 255);
    }

    #[test]
    fn colours_are_distinct() {
        for (a, first) in PALETTE.iter().enumerate() {
            for second in &PALETTE[..a] {
                let distance: u32 = first.iter().zip(second).map(|(&p, &q)| u32::from(p.abs_diff(q))).sum();
                assert!(distance > 60, "{first:?} {second:?}");
            }
        }
    }
}
