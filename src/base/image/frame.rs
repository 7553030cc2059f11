//! `Frame`: one colour image of the clip, eight bits a channel.

use super::Plane;
use crate::Error;
use crate::error::{MAX_PIXELS, check_size};
use std::ops::Range;

/// An RGB image; three bytes a pixel, row by row.
///
/// Invariants: `rgb.len() == 3 * width * height`, both sides in `1..=MAX_SIDE`.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    rgb: Vec<u8>,
    width: usize,
    height: usize,
}

impl Frame {
    /// Creates a frame from RGBA bytes, four a pixel, as `ImageData` holds them; alpha is ignored.
    ///
    /// # Errors
    /// [`Error::FrameSize`] or [`Error::FrameBytes`].
    pub fn from_rgba(rgba: &[u8], width: usize, height: usize) -> Result<Self, Error> {
        Ok(Picture::<4>::new(rgba, width, height)?.part(0..width, 0..height))
    }

    /// Creates a frame from RGB bytes, three a pixel.
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

    /// Decodes a PNG or JPEG file of at most [`MAX_PIXELS`] pixels and turns it upright by its EXIF orientation.
    ///
    /// # Errors
    /// [`Error::Decode`] when the file is truncated, broken or of another kind; [`Error::FrameSize`] or
    /// [`Error::TooLarge`] when it is too large.
    pub fn decode(bytes: &[u8]) -> Result<Self, Error> {
        Self::decode_within(bytes, MAX_PIXELS)
    }

    /// Decodes a PNG or JPEG file of at most `max_pixels` pixels. The size is checked before memory is allocated.
    ///
    /// # Errors
    /// As [`Frame::decode`].
    #[doc(hidden)]
    pub fn decode_within(bytes: &[u8], max_pixels: usize) -> Result<Self, Error> {
        let (rgb, width, height) = super::decode::decode(bytes, max_pixels)?;
        Self::from_rgb(rgb, width, height)
    }

    /// Returns the width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Returns the height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Returns the bytes, three a pixel, row by row.
    pub fn rgb(&self) -> &[u8] {
        &self.rgb
    }

    /// Computes the brightness in `0.0..=255.0` (weights of ITU-R BT.601).
    #[doc(hidden)] // For benchmarks.
    pub fn luma(&self) -> Plane<f32> {
        let data = self
            .rgb
            .chunks_exact(3)
            .map(|p| 0.299 * f32::from(p[0]) + 0.587 * f32::from(p[1]) + 0.114 * f32::from(p[2]))
            .collect();
        Plane::from_vec(self.width, self.height, data).unwrap_or_default()
    }

    /// Returns colour channel `c` (0 red, 1 green, 2 blue) in `0.0..=255.0`.
    pub(crate) fn channel(&self, c: usize) -> Plane<f32> {
        Plane::from_vec(self.width, self.height, self.rgb[c..].iter().step_by(3).map(|&v| f32::from(v)).collect())
            .unwrap_or_default()
    }

    /// Returns a copy of half the size, means of 2×2 pixels; the last row or column of an odd side counts twice.
    pub(crate) fn halved(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let row = |y: usize| &self.rgb[3 * self.width * y.min(self.height - 1)..][..3 * self.width];
        let mut rgb = Vec::with_capacity(3 * width * height);
        for y in 0..height {
            let ((tops, end), (bottoms, below)) = (row(2 * y).as_chunks::<6>(), row(2 * y + 1).as_chunks::<6>());
            for (top, bottom) in tops.iter().zip(bottoms) {
                let four = |c: usize| [top[c], top[c + 3], bottom[c], bottom[c + 3]].map(u16::from);
                let mean = |[a, b, c, d]: [u16; 4]| ((a + b + c + d + 2) / 4) as u8;
                rgb.extend([mean(four(0)), mean(four(1)), mean(four(2))]);
            }
            rgb.extend(end.iter().zip(below).map(|(&a, &b)| ((2 * (u16::from(a) + u16::from(b)) + 2) / 4) as u8));
        }
        Self { rgb, width, height }
    }

    /// Returns a copy of `width × height` pixels, each the mean of the area that it covers. Meant for reducing frames.
    pub(crate) fn resized(&self, width: usize, height: usize) -> Self {
        if (width, height) == (self.width, self.height) {
            return self.clone();
        }
        self.picture().reduced((width, height), 0..width, 0..height)
    }

    /// Returns a view of the pixels.
    pub(crate) fn picture(&self) -> Picture<'_, 3> {
        Picture { bytes: &self.rgb, width: self.width, height: self.height }
    }
}

/// A view of a picture of `CHANNELS` bytes a pixel, of which the first three are red, green and blue.
///
/// Invariants: as of [`Frame`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Picture<'a, const CHANNELS: usize> {
    bytes: &'a [u8],
    pub(crate) width: usize,
    pub(crate) height: usize,
}

/// Largest whole ratio of sizes whose sums are 16-bit integers.
const MAX_WHOLE_RATIO: usize = 16;

impl<'a, const CHANNELS: usize> Picture<'a, CHANNELS> {
    /// # Errors
    /// [`Error::FrameSize`] or [`Error::FrameBytes`].
    pub(crate) fn new(bytes: &'a [u8], width: usize, height: usize) -> Result<Self, Error> {
        check_size(width, height)?;
        if bytes.len() != CHANNELS * width * height {
            return Err(Error::FrameBytes { expected: CHANNELS * width * height, actual: bytes.len() });
        }
        Ok(Self { bytes, width, height })
    }

    /// Returns the pixels of row `y` in these columns.
    pub(crate) fn row(&self, y: usize, columns: Range<usize>) -> &'a [[u8; CHANNELS]] {
        self.bytes[CHANNELS * (y * self.width + columns.start)..][..CHANNELS * columns.len()].as_chunks().0
    }

    /// Returns a part of the picture.
    pub(crate) fn part(&self, columns: Range<usize>, rows: Range<usize>) -> Frame {
        let mut rgb = Vec::with_capacity(3 * columns.len() * rows.len());
        let (width, height) = (columns.len(), rows.len());
        for y in rows {
            self.row(y, columns.clone()).iter().for_each(|pixel| rgb.extend_from_slice(&pixel[..3]));
        }
        Frame { rgb, width, height }
    }

    /// Returns a part of the picture reduced to `size`, each pixel the mean of the area that it covers.
    pub(crate) fn reduced(&self, size: (usize, usize), columns: Range<usize>, rows: Range<usize>) -> Frame {
        let ratio = self.width / size.0;
        let is_whole = ratio.is_power_of_two()
            && ratio <= MAX_WHOLE_RATIO
            && (self.width, self.height) == (ratio * size.0, ratio * size.1);
        let (width, height) = (columns.len(), rows.len());
        let rgb = if is_whole { self.reduced_by(ratio, columns, rows) } else { self.reduced_to(size, columns, rows) };
        Frame { rgb, width, height }
    }

    /// As [`Picture::reduced_to`], in integers: sums and means of a power of two of bytes are exact in either.
    fn reduced_by(&self, ratio: usize, columns: Range<usize>, rows: Range<usize>) -> Vec<u8> {
        let (half, shift) = (ratio * ratio / 2, 2 * ratio.trailing_zeros());
        let mut rgb = vec![0; 3 * columns.len() * rows.len()];
        let mut line = vec![0_u16; CHANNELS * ratio * columns.len()];
        for (out, row) in rgb.chunks_exact_mut(3 * columns.len().max(1)).zip(rows) {
            line.fill(0);
            for y in ratio * row..ratio * (row + 1) {
                let source = self.row(y, ratio * columns.start..ratio * columns.end).as_flattened();
                line.iter_mut().zip(source).for_each(|(sum, &value)| *sum += u16::from(value));
            }
            for (pixel, cell) in out.as_chunks_mut::<3>().0.iter_mut().zip(line.chunks_exact(CHANNELS * ratio)) {
                let mut sums = [half as u32; 3];
                for part in cell.as_chunks::<CHANNELS>().0 {
                    (0..3).for_each(|c| sums[c] += u32::from(part[c]));
                }
                *pixel = sums.map(|sum| (sum >> shift) as u8);
            }
        }
        rgb
    }

    fn reduced_to(&self, size: (usize, usize), columns: Range<usize>, rows: Range<usize>) -> Vec<u8> {
        let (all_columns, all_rows) = (coverage(self.width, size.0), coverage(self.height, size.1));
        let mut rgb = vec![0; 3 * columns.len() * rows.len()];
        // One more, as four values are read at a time.
        let mut line = vec![0.0_f32; CHANNELS * self.width + 1];
        for (out, row) in rgb.chunks_exact_mut(3 * columns.len().max(1)).zip(&all_rows[rows]) {
            line.fill(0.0);
            for &(y, weight) in row {
                let source = self.row(y, 0..self.width).as_flattened();
                line.iter_mut().zip(source).for_each(|(sum, &value)| *sum += weight * f32::from(value));
            }
            for (pixel, column) in out.as_chunks_mut::<3>().0.iter_mut().zip(&all_columns[columns.clone()]) {
                let mut sums = [0.0_f32; 4];
                for &(x, weight) in column {
                    let source = &line[CHANNELS * x..][..4];
                    (0..4).for_each(|c| sums[c] += weight * source[c]);
                }
                let [r, g, b, _] = sums.map(|value| (value + 0.5) as u8);
                *pixel = [r, g, b];
            }
        }
        rgb
    }
}

/// Reduces a size in proportion until its longer side is at most `max_side`, rounded to at least 1 pixel a side.
pub(crate) fn fit_within(width: usize, height: usize, max_side: usize) -> (usize, usize) {
    let long = width.max(height);
    let side = |side: usize| if long > max_side { ((side * max_side + long / 2) / long).max(1) } else { side };
    (side(width), side(height))
}

/// Returns, for each of `to` cells over `from` pixels, the pixels that it covers and their shares, whose sum is 1.
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
    fn halving_counts_the_last_pixels_of_odd_sides_twice() {
        let rgb: Vec<u8> = [0, 20, 40, 10, 30, 50, 90, 100, 200].iter().flat_map(|&v| [v, 0, v]).collect();
        let half = Frame::from_rgb(rgb, 3, 3).unwrap().halved();
        assert_eq!(half.rgb(), [15, 0, 15, 45, 0, 45, 95, 0, 95, 200, 0, 200]);
    }

    #[test]
    fn resizing_keeps_a_flat_colour_at_any_ratio() {
        let flat = Frame::from_rgb(vec![90; 3 * 17 * 13], 17, 13).unwrap();
        assert!(flat.resized(5, 4).rgb().iter().all(|&v| v == 90));
    }

    #[test]
    fn whole_ratios_in_integers_give_what_others_do_and_a_part_gives_that_part() {
        let mut rng = crate::rng::Rng::for_stage(1, "frame");
        let rgba: Vec<u8> = (0..4 * 64 * 32).map(|_| rng.below(256) as u8).collect();
        let (picture, frame) = (Picture::<4>::new(&rgba, 64, 32).unwrap(), Frame::from_rgba(&rgba, 64, 32).unwrap());
        for size in [(32, 16), (16, 8), (4, 2), (24, 12), (19, 9)] {
            let whole = frame.resized(size.0, size.1);
            assert_eq!(whole.rgb(), frame.picture().reduced_to(size, 0..size.0, 0..size.1));
            let (columns, rows) = (1..size.0 - 1, 1..size.1);
            let part = picture.reduced(size, columns.clone(), rows.clone());
            assert_eq!(part, whole.picture().part(columns, rows));
        }
    }

    #[test]
    fn truncated_files_are_an_error() {
        assert_eq!(Frame::decode(b"\x89PNG\r\n\x1a\n").unwrap_err().code(), "decode");
        assert_eq!(Frame::decode(b"").unwrap_err().code(), "decode");
    }

    #[test]
    fn a_palette_of_broken_colours_is_an_error() {
        let file = [
            &b"\x89PNG\r\n\x1a\n"[..],
            b"\x00\x00\x00\x0dIHDR\x00\x00\x00\x01\x00\x00\x00\x01\x08\x03\x00\x00\x00(\xcb4\xbb",
            b"\x00\x00\x00\x04PLTE\x01\x02\x03\x04#\xdb\x8a\xab",
            b"\x00\x00\x00\x0aIDATx\x9cc`\x04\x00\x00\x03\x00\x02K\xf5\xdd\xea",
            b"\x00\x00\x00\x00IEND\xaeB`\x82",
        ];
        let error = Frame::decode(&file.concat()).unwrap_err();
        assert_eq!(error.code(), "decode");
        assert!(error.to_string().contains("its palette has 4 bytes"), "{error}");
    }
}
