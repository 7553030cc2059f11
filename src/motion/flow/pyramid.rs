//! Pyramid of one frame at halving sizes, with padded levels so that no kernel needs to test for the border.

use super::PATCH_SIDE_PX;
use crate::image::{Frame, Plane, fit_within, gaussian_blur};

/// Pixels of replicated border around a level: twice the side of a patch and one more.
pub(super) const PAD: usize = 17;

/// Standard deviation of the blur of frames, in pixels. Higher is smoother and loses fine structure. Chosen by eye (the
/// published tracker blurs by 0.8).
const PRE_SMOOTHING_PX: f32 = 0.7;

/// Weights at distance 0.5, 1.5 and 2.5 for halving a level: a Gaussian of one pixel. A narrower one aliases stripes, and
/// patches lock onto the wrong period (measured, see the module `flow`).
const HALVING_WEIGHTS: [f32; 3] = [0.351_75, 0.129_40, 0.018_85];

/// A plane of `width × height` values inside a border of [`PAD`] replicated pixels.
#[derive(Debug, Clone, Default)]
pub(super) struct PaddedPlane {
    /// All values with the border, row by row, `stride` apart, and maybe unused ones at the end.
    pub(super) data: Vec<f32>,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) stride: usize,
}

impl PaddedPlane {
    /// Sets the size; values are unspecified.
    pub(super) fn resize(&mut self, width: usize, height: usize) {
        (self.width, self.height, self.stride) = (width, height, width + 2 * PAD);
        grow(&mut self.data, self.stride * (height + 2 * PAD), 0.0);
    }

    /// Returns the index of pixel `(x, y)` in `data`; either coordinate may reach [`PAD`] pixels outside.
    pub(super) fn index(&self, x: isize, y: isize) -> usize {
        (y + PAD as isize) as usize * self.stride + (x + PAD as isize) as usize
    }

    /// Returns row `y` with its border; pixel `x` is at `PAD + x`.
    pub(super) fn padded_row(&self, y: isize) -> &[f32] {
        &self.data[self.index(-(PAD as isize), y)..][..self.stride]
    }

    /// Returns row `y` without its border.
    pub(super) fn row(&self, y: usize) -> &[f32] {
        &self.data[(y + PAD) * self.stride + PAD..][..self.width]
    }

    /// Returns row `y` without its border, mutably.
    pub(super) fn row_mut(&mut self, y: usize) -> &mut [f32] {
        &mut self.data[(y + PAD) * self.stride + PAD..][..self.width]
    }

    /// Copies the outermost pixels into the border; to be called after writing rows.
    pub(super) fn replicate_border(&mut self) {
        let (stride, width, height) = (self.stride, self.width, self.height);
        for row in self.data[PAD * stride..(PAD + height) * stride].chunks_exact_mut(stride) {
            let (first, last) = (row[PAD], row[PAD + width - 1]);
            row[..PAD].fill(first);
            row[PAD + width..].fill(last);
        }
        for y in 0..PAD {
            self.data.copy_within(PAD * stride..(PAD + 1) * stride, y * stride);
            self.data.copy_within((PAD + height - 1) * stride..(PAD + height) * stride, (PAD + height + y) * stride);
        }
    }
}

/// Extends a buffer to at least `length` values. One that shrank for a coarse level would be filled again for a fine one.
pub(super) fn grow<T: Clone>(values: &mut Vec<T>, length: usize, fill: T) {
    values.resize(values.len().max(length), fill);
}

/// One size of a frame: brightness and its central differences, per pixel of this level.
#[derive(Debug, Clone, Default)]
pub(super) struct Level {
    pub(super) image: PaddedPlane,
    pub(super) slope_x: PaddedPlane,
    pub(super) slope_y: PaddedPlane,
}

impl Level {
    fn new(image: PaddedPlane) -> Self {
        let (width, height) = (image.width, image.height);
        let mut level = Self { image, slope_x: PaddedPlane::default(), slope_y: PaddedPlane::default() };
        level.slope_x.resize(width, height);
        level.slope_y.resize(width, height);
        for y in 0..height {
            let row = level.image.padded_row(y as isize);
            let above = level.image.padded_row(y as isize - 1);
            let below = level.image.padded_row(y as isize + 1);
            let horizontal = row[PAD + 1..].iter().zip(&row[PAD - 1..]);
            for (slope, (right, left)) in level.slope_x.row_mut(y).iter_mut().zip(horizontal) {
                *slope = 0.5 * (right - left);
            }
            let vertical = below[PAD..].iter().zip(&above[PAD..]);
            for (slope, (lower, upper)) in level.slope_y.row_mut(y).iter_mut().zip(vertical) {
                *slope = 0.5 * (lower - upper);
            }
        }
        // The border of the gradient stays zero: it does not move a patch.
        level
    }

    /// Returns the level at half the size, each pixel a weighted mean of six by six.
    fn halved(&self) -> Self {
        let image = &self.image;
        let (width, height) = (image.width.div_ceil(2), image.height.div_ceil(2));
        let mut half = PaddedPlane::default();
        half.resize(width, height);
        let mut line = vec![0.0_f32; image.stride];
        let [inner, middle, outer] = HALVING_WEIGHTS;
        for y in 0..height {
            let rows: [&[f32]; 6] = std::array::from_fn(|k| image.padded_row((2 * y + k) as isize - 2));
            for (x, value) in line.iter_mut().enumerate() {
                let sum = inner * (rows[2][x] + rows[3][x]) + middle * (rows[1][x] + rows[4][x]);
                *value = sum + outer * (rows[0][x] + rows[5][x]);
            }
            let taps = line[PAD - 2..].windows(6).step_by(2);
            for (out, tap) in half.row_mut(y).iter_mut().zip(taps) {
                *out = inner * (tap[2] + tap[3]) + middle * (tap[1] + tap[4]) + outer * (tap[0] + tap[5]);
            }
        }
        half.replicate_border();
        Self::new(half)
    }
}

/// A frame prepared for optical flow, used for the pairs before and after it.
///
/// Memory: 16 bytes a pixel of the frame. Cost: a few additions a pixel.
#[derive(Debug, Clone, Default)]
pub struct FlowPyramid {
    pub(super) levels: Vec<Level>,
}

impl FlowPyramid {
    /// Builds the pyramid of a frame.
    pub fn new(frame: &Frame) -> Self {
        Self::from_luma(&frame.luma())
    }

    /// Builds the pyramid from brightness in `0.0..=255.0`; other values are clamped, NaN counts as 0.
    #[doc(hidden)] // For benchmarks.
    pub fn from_luma(luma: &Plane<f32>) -> Self {
        Self::from_smooth(&gaussian_blur(&luma.map(|v| if v > 0.0 { v.min(255.0) } else { 0.0 }), PRE_SMOOTHING_PX))
    }

    /// Builds the pyramid of a frame, reduced to a longest side of `max_side` pixels if it is larger.
    #[doc(hidden)] // For `examples/method.rs`.
    pub fn reduced(frame: &Frame, max_side: u32) -> Self {
        let (width, height) = fit_within(frame.width(), frame.height(), max_side as usize);
        Self::new(&frame.resized(width, height))
    }

    /// Builds the pyramid from blurred brightness.
    pub(super) fn from_smooth(smooth: &Plane<f32>) -> Self {
        let (width, height) = (smooth.width(), smooth.height());
        if width == 0 || height == 0 {
            return Self::default();
        }
        let mut image = PaddedPlane::default();
        image.resize(width, height);
        for y in 0..height {
            image.row_mut(y).copy_from_slice(smooth.row(y));
        }
        image.replicate_border();
        let mut levels = vec![Level::new(image)];
        for _ in 0..coarsest_level(width, height) {
            let next = levels.last().map(Level::halved);
            levels.extend(next);
        }
        Self { levels }
    }

    /// Returns width and height of the finest level, in pixels.
    pub(crate) fn size(&self) -> (usize, usize) {
        self.levels.first().map_or((0, 0), |level| (level.image.width, level.image.height))
    }
}

/// Returns the coarsest level: its longer side is about four patches long, its shorter one at least one (OpenCV's DIS).
fn coarsest_level(width: usize, height: usize) -> usize {
    let patch = PATCH_SIDE_PX;
    let (longer, shorter) = (width.max(height), width.min(height));
    let mut level = 0;
    // log2 rounded to the nearest: one level more while the longer side exceeds four patches by more than sqrt(2).
    while (longer >> level) * 100 > 4 * patch * 141 && (shorter >> (level + 1)) >= patch {
        level += 1;
    }
    level
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halving_keeps_flat_brightness_and_shifts_a_ramp_by_half_a_pixel() {
        let ramp = Plane::from_fn(64, 64, |x, y| x as f32 + 2.0 * y as f32);
        let pyramid = FlowPyramid::from_smooth(&ramp);
        let half = &pyramid.levels[1].image;
        for (x, y) in [(5, 5), (20, 9)] {
            let expected = (2 * x) as f32 + 0.5 + 2.0 * ((2 * y) as f32 + 0.5);
            assert!((half.row(y)[x] - expected).abs() < 1e-3, "{} for {expected}", half.row(y)[x]);
        }
        let flat = FlowPyramid::from_luma(&Plane::filled(33, 41, 7.0));
        for level in &flat.levels {
            assert!(level.image.data.iter().all(|v| (v - 7.0).abs() < 1e-3));
        }
    }

    #[test]
    fn borders_repeat_the_outermost_pixel() {
        let pyramid = FlowPyramid::from_smooth(&Plane::from_fn(3, 2, |x, y| (10 * y + x) as f32));
        let image = &pyramid.levels[0].image;
        let pad = PAD as isize;
        assert_eq!(image.data[image.index(-pad, -pad)], 0.0);
        assert_eq!(image.data[image.index(2 + pad, 1 + pad)], 12.0);
        assert_eq!(image.data[image.index(-1, 1)], 10.0);
    }
}
