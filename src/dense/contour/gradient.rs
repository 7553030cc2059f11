//! Strength of the change at each pixel across each of eight directions, over channels and scales.

use super::blur::{Blur, add_doubled, half, halve, spans, spans_of_half};
use super::histogram::{Tensors, share_of_bin};
use super::lab::lab;
use super::texton::textons;
use super::thin::{ORIENTATIONS, normals};
use crate::image::Frame;

/// Standard deviation of the windows, in pixels of each level: on the frame the coarser ones are two and four times as
/// wide. Lower finds finer detail and more noise.
const SIGMA: f32 = 1.5;
/// Weight of changes of colour (a and b of Lab), those of changes of brightness and of texture being 1.
const COLOUR_WEIGHT: f32 = 0.6;
/// Bins of a colour channel's histogram.
const BINS: usize = 8;
/// Levels: full size, half of it, a quarter.
const LEVELS: usize = 3;
/// Standard deviation of the blur of the tensors, as a part of the windows'. Without it the best F is lower by 0.005 to
/// 0.01; more of it costs precision at two pixels.
const TENSOR_BLUR: f32 = 0.7;
/// Standard deviation of the mean along a boundary, in pixels, and the steps at which it looks.
const ALONG_SIGMA: f32 = 3.0;
const ALONG_STEPS: [f32; 7] = [-6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0];

/// For each direction of [`normals`], how much the histograms change along it; planes of the frame's size.
pub(super) fn oriented_strength(frame: &Frame) -> [Vec<f32>; ORIENTATIONS] {
    let (w, h) = (frame.width(), frame.height());
    let mut pyramid = Pyramid::new(w, h);
    let [brightness, a, b] = lab(frame);
    pyramid.add_channel(&brightness, 1.0, 0);
    let mut small = Vec::new();
    for color in [a, b] {
        halve(&color, w, &mut small);
        pyramid.add_channel(&small, COLOUR_WEIGHT, 1);
    }
    halve(&brightness, w, &mut small);
    for shares in textons(&small, half(w)) {
        pyramid.add_bin(shares, 1.0, 1);
    }
    let mut strength = pyramid.finish();
    for (plane, normal) in strength.iter_mut().zip(normals()) {
        *plane = mean_along(plane, w, normal, 1.0);
    }
    strength
}

/// The same of a frame whose half is `small`, in planes of the half's size: brightness, too, has no more detail.
pub(super) fn oriented_strength_of_half(small: &Frame) -> [Vec<f32>; ORIENTATIONS] {
    let (w, h) = (small.width(), small.height());
    let mut pyramid = Pyramid::of_half(w, h);
    let [brightness, a, b] = lab(small);
    for (channel, weight) in [(&brightness, 1.0), (&a, COLOUR_WEIGHT), (&b, COLOUR_WEIGHT)] {
        pyramid.add_channel(channel, weight, 1);
    }
    for shares in textons(&brightness, w) {
        pyramid.add_bin(shares, 1.0, 1);
    }
    let mut strength = pyramid.finish();
    for (plane, normal) in strength.iter_mut().zip(normals()) {
        *plane = mean_along(plane, w, normal, 0.5);
    }
    strength
}

/// Tensors at three scales. Those of colour and texture at the finest scale are kept at half size: in most images and
/// videos colour has no more detail.
struct Pyramid {
    /// The finest level has the size of the next: nothing is known at full size.
    is_half: bool,
    sides: [(usize, usize); LEVELS],
    tensors: [Tensors; LEVELS],
    coarse_finest: Tensors,
    first: [Blur; 2],
    next: Blur,
    small: Vec<f32>,
}

impl Pyramid {
    fn new(w: usize, h: usize) -> Self {
        Self::of_levels([(w, h), (half(w), half(h)), (half(half(w)), half(half(h)))], false)
    }

    /// Of a frame whose half has `w × h` pixels.
    fn of_half(w: usize, h: usize) -> Self {
        Self::of_levels([(w, h), (w, h), (half(w), half(h))], true)
    }

    fn of_levels(sides: [(usize, usize); LEVELS], is_half: bool) -> Self {
        Self {
            is_half,
            sides,
            tensors: sides.map(|(w, h)| Tensors::zero(w * h)),
            coarse_finest: Tensors::zero(sides[1].0 * sides[1].1),
            first: [Blur::new(SIGMA), Blur::new(0.5 * SIGMA)],
            // From half of `SIGMA`, what halving leaves of the finer level's blur, to `SIGMA`.
            next: Blur::new(SIGMA * 0.75_f32.sqrt()),
            small: Vec::new(),
        }
    }

    /// Adds a channel of values in `0..=1`, of the size of `level`, 0 or 1.
    fn add_channel(&mut self, values: &[f32], weight: f32, level: usize) {
        for b in 0..BINS {
            let mut shares = Vec::new();
            if share_of_bin(values, b, BINS, &mut shares) {
                self.add_bin(shares, weight, level);
            }
        }
    }

    /// Adds one bin's shares, of the size of `level`, 0 or 1.
    fn add_bin(&mut self, mut shares: Vec<f32>, weight: f32, level: usize) {
        let width = self.sides[level].0;
        let weight = weight * SIGMA * SIGMA;
        // Most bins have a share in a part of the image only.
        let mut within = spans(&shares, width);
        self.first[level].apply_within(&mut shares, width, &mut within);
        if level == 0 {
            self.tensors[0].add_bin(&shares, width, weight, &within);
        } else {
            // The same window as of the finest level, where slopes by pixel are half of those here.
            self.coarse_finest.add_bin(&shares, width, 0.25 * weight, &within);
        }
        for coarse in 1..LEVELS {
            if coarse > level {
                halve(&shares, self.sides[coarse - 1].0, &mut self.small);
                std::mem::swap(&mut shares, &mut self.small);
                within = spans_of_half(&within);
            }
            let width = self.sides[coarse].0;
            self.next.apply_within(&mut shares, width, &mut within);
            self.tensors[coarse].add_bin(&shares, width, weight, &within);
        }
    }

    /// Mean over the scales of the change along each direction.
    fn finish(mut self) -> [Vec<f32>; ORIENTATIONS] {
        let to_finest = if self.is_half { add } else { add_doubled };
        for (fine, coarse) in self.tensors[0].0.iter_mut().zip(&self.coarse_finest.0) {
            to_finest(coarse, fine, self.sides[0].0);
        }
        let wide = TENSOR_BLUR * SIGMA;
        for (level, (tensors, (w, _))) in self.tensors.iter_mut().zip(self.sides).enumerate() {
            let mut blur = Blur::new(if self.is_half && level == 0 { 0.5 * wide } else { wide });
            tensors.0.iter_mut().for_each(|part| blur.apply(part, w));
        }
        normals().map(|normal| {
            let [mut fine, mut middle, mut coarse] = self.sides.map(|(w, h)| vec![0.0; w * h]);
            self.tensors[2].add_change_along(normal, &mut coarse);
            self.tensors[1].add_change_along(normal, &mut middle);
            add_doubled(&coarse, &mut middle, self.sides[1].0);
            self.tensors[0].add_change_along(normal, &mut fine);
            to_finest(&middle, &mut fine, self.sides[0].0);
            fine.iter_mut().for_each(|v| *v *= 1.0 / LEVELS as f32);
            fine
        })
    }
}

/// Adds a plane of the same size.
fn add(plane: &[f32], out: &mut [f32], _: usize) {
    out.iter_mut().zip(plane).for_each(|(o, v)| *o += v);
}

/// Weighted mean of each pixel and those along the line across `normal`; borders are mirrored. `size` is that of the
/// plane as a part of the frame's.
pub(crate) fn mean_along(plane: &[f32], width: usize, (nx, ny): (f32, f32), size: f32) -> Vec<f32> {
    let height = plane.len() / width;
    let weights = ALONG_STEPS.map(|s| libm::expf(-0.5 * s * s / (ALONG_SIGMA * ALONG_SIGMA)));
    let total: f32 = weights.iter().sum();
    let steps = ALONG_STEPS.map(|s| s * size).map(|s| (libm::roundf(-ny * s) as isize, libm::roundf(nx * s) as isize));
    let reach = 6;
    let mut padded = Vec::new();
    let mut out = vec![0.0; plane.len()];
    let stride = width + 2 * reach;
    let mut wide = Vec::with_capacity(stride * height);
    for row in plane.chunks_exact(width) {
        super::blur::pad(row, reach, &mut padded);
        wide.extend_from_slice(&padded);
    }
    for (y, out) in out.chunks_exact_mut(width).enumerate() {
        for (&(dx, dy), w) in steps.iter().zip(weights) {
            let row = super::blur::mirror(y as isize + dy, height) * stride;
            let source = &wide[row + (reach as isize + dx) as usize..][..width];
            let w = w / total;
            for (o, s) in out.iter_mut().zip(source) {
                *o += w * s;
            }
        }
    }
    out
}
