//! One frame at halving sizes, with room around each level so that no kernel needs to test for the border.

use super::params::PATCH_SIDE;
use crate::image::{Frame, Plane, fit_within, gaussian_blur};

/// Pixels of replicated border around a level; a patch of 16 pixels fits into it whole.
pub(super) const PAD: usize = 17;

/// Standard deviation of the blur that frames get first, in pixels. Higher is smoother and loses fine structure.
const PRESMOOTHING: f32 = 0.7;

/// Weights at distance 0.5, 1.5 and 2.5 when a level is halved: a Gaussian of one pixel. A narrower one lets stripes
/// through that the smaller level shows with a wrong period, and patches then lock onto them.
const HALVING: [f32; 3] = [0.351_75, 0.129_40, 0.018_85];

/// A plane of `width × height` values inside a border of [`PAD`] replicated pixels.
#[derive(Debug, Clone, Default)]
pub(super) struct Padded {
    data: Vec<f32>,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) stride: usize,
}

impl Padded {
    /// Gives the plane this size; the values are left as they are.
    pub(super) fn resize(&mut self, width: usize, height: usize) {
        (self.width, self.height, self.stride) = (width, height, width + 2 * PAD);
        self.data.resize(self.stride * (height + 2 * PAD), 0.0);
    }

    /// All values with the border, row by row, `stride` apart.
    pub(super) fn data(&self) -> &[f32] {
        &self.data
    }

    /// Where pixel `(x, y)` lies in `data`; either coordinate may reach [`PAD`] pixels outside.
    pub(super) fn index(&self, x: isize, y: isize) -> usize {
        (y + PAD as isize) as usize * self.stride + (x + PAD as isize) as usize
    }

    /// Row `y` with its border; pixel `x` is at `PAD + x`.
    pub(super) fn padded_row(&self, y: isize) -> &[f32] {
        &self.data[self.index(-(PAD as isize), y)..][..self.stride]
    }

    /// Row `y` without its border.
    pub(super) fn row(&self, y: usize) -> &[f32] {
        &self.data[(y + PAD) * self.stride + PAD..][..self.width]
    }

    /// Row `y` without its border, to write.
    pub(super) fn row_mut(&mut self, y: usize) -> &mut [f32] {
        &mut self.data[(y + PAD) * self.stride + PAD..][..self.width]
    }

    /// Copies the outermost pixels into the border, after the rows have been written.
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

/// One size of a frame: brightness and its central differences, per pixel of this level.
#[derive(Debug, Clone, Default)]
pub(super) struct Level {
    pub(super) image: Padded,
    pub(super) slope_x: Padded,
    pub(super) slope_y: Padded,
}

impl Level {
    fn new(image: Padded) -> Self {
        let (width, height) = (image.width, image.height);
        let mut level = Self { image, slope_x: Padded::default(), slope_y: Padded::default() };
        level.slope_x.resize(width, height);
        level.slope_y.resize(width, height);
        for y in 0..height {
            let row = level.image.padded_row(y as isize);
            let above = level.image.padded_row(y as isize - 1);
            let below = level.image.padded_row(y as isize + 1);
            let across = row[PAD + 1..].iter().zip(&row[PAD - 1..]);
            for (slope, (right, left)) in level.slope_x.row_mut(y).iter_mut().zip(across) {
                *slope = 0.5 * (right - left);
            }
            let down = below[PAD..].iter().zip(&above[PAD..]);
            for (slope, (lower, upper)) in level.slope_y.row_mut(y).iter_mut().zip(down) {
                *slope = 0.5 * (lower - upper);
            }
        }
        // The slopes' border stays zero: a flat continuation pulls a patch nowhere.
        level
    }

    /// Half the size: each pixel a weighted mean of six by six, centred between the middle two.
    fn halved(&self) -> Self {
        let image = &self.image;
        let (width, height) = (image.width.div_ceil(2), image.height.div_ceil(2));
        let mut half = Padded::default();
        half.resize(width, height);
        let mut line = vec![0.0_f32; image.stride];
        let [inner, middle, outer] = HALVING;
        for y in 0..height {
            let rows: [&[f32]; 6] = std::array::from_fn(|k| image.padded_row((2 * y + k) as isize - 2));
            for (x, value) in line.iter_mut().enumerate() {
                let near = inner * (rows[2][x] + rows[3][x]) + middle * (rows[1][x] + rows[4][x]);
                *value = near + outer * (rows[0][x] + rows[5][x]);
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

/// What the flow needs of one frame, made once per frame and used for the pairs on both sides of it.
///
/// Memory: 16 bytes a pixel of the frame. Cost: a few additions a pixel.
#[derive(Debug, Clone, Default)]
pub struct FlowPyramid {
    pub(super) levels: Vec<Level>,
}

impl FlowPyramid {
    /// From brightness in `0.0..=255.0`; other values are held to that range, not-a-number counts as 0.
    pub fn new(luma: &Plane<f32>) -> Self {
        Self::of_smooth(&gaussian_blur(&luma.map(|v| if v > 0.0 { v.min(255.0) } else { 0.0 }), PRESMOOTHING))
    }

    /// From a frame, reduced to a longest side of `max_side` pixels where it is larger.
    pub fn of_frame(frame: &Frame, max_side: u32) -> Self {
        let (width, height) = fit_within((frame.width(), frame.height()), max_side as usize);
        Self::new(&frame.resized(width, height).luma())
    }

    /// From brightness that is smooth already.
    pub(super) fn of_smooth(smooth: &Plane<f32>) -> Self {
        let (width, height) = (smooth.width(), smooth.height());
        if width == 0 || height == 0 {
            return Self::default();
        }
        let mut image = Padded::default();
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

    /// Width and height of the frame, in pixels.
    pub(crate) fn size(&self) -> (usize, usize) {
        self.levels.first().map_or((0, 0), |level| (level.image.width, level.image.height))
    }
}

/// The level where the search begins: the longer side holds about four patches, the shorter at least one.
fn coarsest_level(width: usize, height: usize) -> usize {
    let patch = PATCH_SIDE;
    let (longer, shorter) = (width.max(height), width.min(height));
    let mut level = 0;
    // Rounding log2 to the nearest: one level more while the longer side exceeds four patches by more than sqrt(2).
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
        let pyramid = FlowPyramid::of_smooth(&ramp);
        let half = &pyramid.levels[1].image;
        for (x, y) in [(5, 5), (20, 9)] {
            let expected = (2 * x) as f32 + 0.5 + 2.0 * ((2 * y) as f32 + 0.5);
            assert!((half.row(y)[x] - expected).abs() < 1e-3, "{} for {expected}", half.row(y)[x]);
        }
        let flat = FlowPyramid::new(&Plane::filled(33, 41, 7.0));
        for level in &flat.levels {
            assert!(level.image.data().iter().all(|v| (v - 7.0).abs() < 1e-3));
        }
    }

    #[test]
    fn borders_repeat_the_outermost_pixel() {
        let pyramid = FlowPyramid::of_smooth(&Plane::from_fn(3, 2, |x, y| (10 * y + x) as f32));
        let image = &pyramid.levels[0].image;
        let pad = PAD as isize;
        assert_eq!(image.data()[image.index(-pad, -pad)], 0.0);
        assert_eq!(image.data()[image.index(2 + pad, 1 + pad)], 12.0);
        assert_eq!(image.data()[image.index(-1, 1)], 10.0);
    }
}
