//! Boundary strength of each pixel in each of eight directions, over channels and scales: histogram gradients.

use super::thin::{Normal, ORIENTATIONS, normals};
use crate::image::{Frame, convolve_symmetric, lab};
use crate::order::larger;
use std::ops::Range;

/// Standard deviation of the windows, in pixels of each level: on the frame the coarser ones are two and four times as
/// wide. Lower finds finer detail and more noise. Chosen by eye.
const WINDOW_SIGMA_PX: f32 = 1.5;
/// Weight of changes of colour (a and b of Lab), against 1 for brightness and texture. Chosen by eye.
const COLOUR_WEIGHT: f32 = 0.6;
/// Bins of a colour channel's histogram. Chosen by eye.
const COLOUR_BINS: usize = 8;
/// Levels: full size, a half and a quarter.
const NUM_LEVELS: usize = 3;
/// Standard deviation of the blur of the tensors, as a part of the windows'. Without it the best F on BSDS500 is lower by
/// 0.005 to 0.01; more of it costs precision at two pixels.
const TENSOR_SIGMA_RATIO: f32 = 0.7;
/// Standard deviation of the mean along a boundary, and the offsets of its samples. Chosen by eye.
const ALONG_SIGMA_PX: f32 = 3.0;
const ALONG_OFFSETS_PX: [f32; 7] = [-6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0];

/// Computes the change of the histograms along each direction of [`normals`], as planes of the frame's size.
pub(crate) fn oriented_strengths(frame: &Frame) -> [Vec<f32>; ORIENTATIONS] {
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
        *plane = mean_along_boundary(plane, w, normal, 1.0);
    }
    strength
}

/// Same as [`oriented_strengths`] for a frame whose half is `small`, as planes of the half's size.
pub(super) fn half_size_oriented_strengths(small: &Frame) -> [Vec<f32>; ORIENTATIONS] {
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
        *plane = mean_along_boundary(plane, w, normal, 0.5);
    }
    strength
}

/// Tensors at three scales. Colour and texture have half the size at the finest scale: in most images and videos colour
/// has no more detail.
struct Pyramid {
    /// `true` if the finest level has the size of the next one.
    is_half: bool,
    sides: [(usize, usize); NUM_LEVELS],
    tensors: [Tensors; NUM_LEVELS],
    coarse_finest: Tensors,
    first: [Blur; 2],
    next: Blur,
    small: Vec<f32>,
}

impl Pyramid {
    fn new(w: usize, h: usize) -> Self {
        Self::with_sides([(w, h), (half(w), half(h)), (half(half(w)), half(half(h)))], false)
    }

    /// Pyramid of a frame whose half has `w × h` pixels.
    fn of_half(w: usize, h: usize) -> Self {
        Self::with_sides([(w, h), (w, h), (half(w), half(h))], true)
    }

    fn with_sides(sides: [(usize, usize); NUM_LEVELS], is_half: bool) -> Self {
        Self {
            is_half,
            sides,
            tensors: sides.map(|(w, h)| Tensors::zero(w * h)),
            coarse_finest: Tensors::zero(sides[1].0 * sides[1].1),
            first: [Blur::new(WINDOW_SIGMA_PX), Blur::new(0.5 * WINDOW_SIGMA_PX)],
            // Halving leaves half of the finer level's sigma.
            next: Blur::new(WINDOW_SIGMA_PX * 0.75_f32.sqrt()),
            small: Vec::new(),
        }
    }

    /// Adds a channel of values in `0..=1`, of the size of `level`, 0 or 1.
    fn add_channel(&mut self, values: &[f32], weight: f32, level: usize) {
        for b in 0..COLOUR_BINS {
            let mut shares = Vec::new();
            if share_of_bin(values, b, COLOUR_BINS, &mut shares) {
                self.add_bin(shares, weight, level);
            }
        }
    }

    /// Adds one bin's shares, of the size of `level`, 0 or 1.
    fn add_bin(&mut self, mut shares: Vec<f32>, weight: f32, level: usize) {
        let width = self.sides[level].0;
        let weight = weight * WINDOW_SIGMA_PX * WINDOW_SIGMA_PX;
        // Most bins are empty in most of the image.
        let mut spans = nonzero_spans(&shares, width);
        self.first[level].apply_to_spans(&mut shares, width, &mut spans);
        if level == 0 {
            self.tensors[0].add_bin(&shares, width, weight, &spans);
        } else {
            // At the finest level, gradients by pixel are half as large as here.
            self.coarse_finest.add_bin(&shares, width, 0.25 * weight, &spans);
        }
        for coarse in 1..NUM_LEVELS {
            if coarse > level {
                halve(&shares, self.sides[coarse - 1].0, &mut self.small);
                std::mem::swap(&mut shares, &mut self.small);
                spans = halve_spans(&spans);
            }
            let width = self.sides[coarse].0;
            self.next.apply_to_spans(&mut shares, width, &mut spans);
            self.tensors[coarse].add_bin(&shares, width, weight, &spans);
        }
    }

    /// Computes the mean over the scales of the change along each direction.
    fn finish(mut self) -> [Vec<f32>; ORIENTATIONS] {
        let to_finest = if self.is_half { add } else { add_doubled };
        for (fine, coarse) in self.tensors[0].0.iter_mut().zip(&self.coarse_finest.0) {
            to_finest(coarse, fine, self.sides[0].0);
        }
        let wide = TENSOR_SIGMA_RATIO * WINDOW_SIGMA_PX;
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
            fine.iter_mut().for_each(|v| *v *= 1.0 / NUM_LEVELS as f32);
            fine
        })
    }
}

/// Adds a plane of the same size.
fn add(plane: &[f32], out: &mut [f32], _: usize) {
    out.iter_mut().zip(plane).for_each(|(o, v)| *o += v);
}

/// Gaussian mean along the line across `normal`, with mirrored borders. `scale` is the size of the plane as a part of the
/// frame's.
pub(crate) fn mean_along_boundary(plane: &[f32], width: usize, normal: Normal, scale: f32) -> Vec<f32> {
    let (nx, ny) = normal;
    let height = plane.len() / width;
    let weights = ALONG_OFFSETS_PX.map(|s| libm::expf(-0.5 * s * s / (ALONG_SIGMA_PX * ALONG_SIGMA_PX)));
    let total: f32 = weights.iter().sum();
    let steps =
        ALONG_OFFSETS_PX.map(|s| s * scale).map(|s| (libm::roundf(-ny * s) as isize, libm::roundf(nx * s) as isize));
    let margin = 6;
    let mut padded = Vec::new();
    let mut out = vec![0.0; plane.len()];
    let stride = width + 2 * margin;
    let mut wide = Vec::with_capacity(stride * height);
    for row in plane.chunks_exact(width) {
        pad(row, margin, &mut padded);
        wide.extend_from_slice(&padded);
    }
    for (y, out) in out.chunks_exact_mut(width).enumerate() {
        for (&(dx, dy), w) in steps.iter().zip(weights) {
            let row = mirror(y as isize + dy, height) * stride;
            let source = &wide[row + (margin as isize + dx) as usize..][..width];
            let w = w / total;
            for (o, s) in out.iter_mut().zip(source) {
                *o += w * s;
            }
        }
    }
    out
}

// Textons, as nine fixed patterns: flat, and a bright or a dark line in one of four directions. Clusters of filter responses
// differ between images and change between the frames of a video. A pattern's share of a pixel is its response (a second
// difference) over the sum of all responses and [`FLAT_RESPONSE`], so that contrast matters only where it is low.

/// Number of patterns.
const NUM_TEXTONS: usize = 9;
/// Sum of responses, in brightness `0..=1`, at which a pixel is half flat. Lower finds texture in noise. Chosen by eye.
const FLAT_RESPONSE: f32 = 0.05;

/// Computes the share of each pattern, as planes of the size of `brightness`; they sum to one at each pixel.
fn textons(brightness: &[f32], width: usize) -> [Vec<f32>; NUM_TEXTONS] {
    let height = brightness.len() / width;
    let mut shares = [0; NUM_TEXTONS].map(|_| vec![0.0; brightness.len()]);
    let mut rows = [Vec::new(), Vec::new(), Vec::new()];
    for y in 0..height {
        for (dy, row) in rows.iter_mut().enumerate() {
            pad(&brightness[mirror(y as isize + dy as isize - 1, height) * width..][..width], 1, row);
        }
        let [above, centre, below] = rows.each_ref().map(|row| [0, 1, 2].map(|dx| &row[dx..][..width]));
        let out = shares.each_mut().map(|plane| &mut plane[y * width..][..width]);
        for x in 0..width {
            let twice = 2.0 * centre[1][x];
            let lines = [
                twice - centre[0][x] - centre[2][x],
                twice - above[0][x] - below[2][x],
                twice - above[1][x] - below[1][x],
                twice - above[2][x] - below[0][x],
            ];
            let scale = 1.0 / (lines[0].abs() + lines[1].abs() + lines[2].abs() + lines[3].abs() + FLAT_RESPONSE);
            out[0][x] = FLAT_RESPONSE * scale;
            for k in 0..4 {
                out[1 + k][x] = larger(lines[k], 0.0) * scale;
                out[5 + k][x] = larger(-lines[k], 0.0) * scale;
            }
        }
    }
    shares
}

// Gradient tensors of local histograms: the small-window limit of the chi-square distance between two half-discs.

/// Added to a bin's share before dividing by it, so that changes of nearly empty bins count for less. Chosen by eye.
const SHARE_FLOOR: f32 = 0.02;

/// Computes the share of each pixel that belongs to bin `b` of `bins`; a value between the centres of two bins is shared by
/// both. Returns `true` if any pixel has a share.
fn share_of_bin(values: &[f32], b: usize, bins: usize, shares: &mut Vec<f32>) -> bool {
    let (scale, centre) = ((bins - 1) as f32, b as f32);
    shares.clear();
    shares.extend(values.iter().map(|v| larger(1.0 - (v.clamp(0.0, 1.0) * scale - centre).abs(), 0.0)));
    shares.iter().any(|&s| s > 0.0)
}

/// Symmetric 2x2 matrices, one a pixel: planes of their xx, xy and yy parts.
#[derive(Debug, Clone)]
struct Tensors([Vec<f32>; 3]);

impl Tensors {
    fn zero(len: usize) -> Self {
        Self([vec![0.0; len], vec![0.0; len], vec![0.0; len]])
    }

    /// Adds `weight * g g^T / (h + SHARE_FLOOR)` for the blurred shares `h` of one bin, `g` their gradient by central
    /// differences. Outside of `spans`, a range of columns for each row, shares are 0.
    fn add_bin(&mut self, shares: &[f32], width: usize, weight: f32, spans: &[Range<usize>]) {
        let height = shares.len() / width;
        let mut padded = Vec::new();
        for (y, span) in dilate_spans(spans, 1, width).into_iter().enumerate().filter(|(_, span)| !span.is_empty()) {
            let row = |y: usize| &shares[y * width..][..width];
            pad(row(y), 1, &mut padded);
            let n = span.len();
            let (before, centre, behind) =
                (&padded[span.start..][..n], &row(y)[span.clone()], &padded[span.start + 2..][..n]);
            let (above, below) = (&row(y.saturating_sub(1))[span.clone()], &row((y + 1).min(height - 1))[span.clone()]);
            let [xx, xy, yy] = self.0.each_mut().map(|part| &mut part[y * width..][span.clone()]);
            for x in 0..n {
                let gx = 0.5 * (behind[x] - before[x]);
                let gy = 0.5 * (below[x] - above[x]);
                let k = weight / (centre[x] + SHARE_FLOOR);
                xx[x] += k * gx * gx;
                xy[x] += k * gx * gy;
                yy[x] += k * gy * gy;
            }
        }
    }

    /// Adds the root of `n^T J n` at each pixel to `out`: the change along the unit vector `n`.
    fn add_change_along(&self, normal: Normal, out: &mut [f32]) {
        let ([xx, xy, yy], (nx, ny)) = (&self.0, normal);
        let (a, b, c) = (nx * nx, 2.0 * nx * ny, ny * ny);
        for (((o, xx), xy), yy) in out.iter_mut().zip(xx).zip(xy).zip(yy) {
            *o += larger(a * xx + b * xy + c * yy, 0.0).sqrt();
        }
    }
}

// Gaussian blur with mirrored borders, and images of half the size; the same bits on every machine.

/// Weights at `0..=r`, `r = ceil(2.5 sigma)`, such that those at `-r..=r` sum to one; `[1]` for `sigma <= 0`.
fn half_kernel(sigma: f32) -> Vec<f32> {
    if sigma <= 0.0 {
        return vec![1.0];
    }
    let radius = libm::ceilf(2.5 * sigma) as usize;
    let weight = |k: usize| libm::expf(-0.5 * (k * k) as f32 / (sigma * sigma));
    let weights: Vec<f32> = (0..=radius).map(weight).collect();
    let total = weights[0] + 2.0 * weights[1..].iter().sum::<f32>();
    weights.iter().map(|w| w / total).collect()
}

/// Mirrors the index `i` into `0..n`: `-1` becomes `0`, `n` becomes `n - 1`.
fn mirror(i: isize, n: usize) -> usize {
    if (0..n as isize).contains(&i) {
        return i as usize;
    }
    let period = 2 * n as isize;
    let wrapped = i.rem_euclid(period);
    wrapped.min(period - 1 - wrapped) as usize
}

/// Pads `row` with `radius` mirrored values on both sides.
fn pad(row: &[f32], radius: usize, padded: &mut Vec<f32>) {
    padded.clear();
    let n = row.len();
    padded.extend((0..radius).map(|k| row[mirror(k as isize - radius as isize, n)]));
    padded.extend_from_slice(row);
    padded.extend((0..radius).map(|k| row[mirror((n + k) as isize, n)]));
}

/// Gaussian blur in place, with reused buffers.
#[derive(Debug)]
struct Blur {
    kernel: Vec<f32>,
    padded: Vec<f32>,
    /// The image blurred along its rows; zeros between two images.
    across: Vec<f32>,
}

impl Blur {
    fn new(sigma: f32) -> Self {
        Self { kernel: half_kernel(sigma), padded: Vec::new(), across: Vec::new() }
    }

    /// Blurs an image of rows of `width` values.
    fn apply(&mut self, image: &mut [f32], width: usize) {
        let mut spans = vec![0..width; image.len() / width];
        self.apply_to_spans(image, width, &mut spans);
    }

    /// Blurs an image that is 0 outside of `spans`, and updates these.
    fn apply_to_spans(&mut self, image: &mut [f32], width: usize, spans: &mut Vec<Range<usize>>) {
        let radius = self.kernel.len() - 1;
        let height = image.len() / width;
        self.across.resize(self.across.len().max(image.len()), 0.0);
        let rows = image.chunks_exact(width).zip(self.across.chunks_exact_mut(width));
        for ((row, out), span) in rows.zip(&*spans).filter(|(_, span)| !span.is_empty()) {
            pad(row, radius, &mut self.padded);
            let span = dilate_span(span, radius, width);
            let start = |k: isize| (span.start + radius).wrapping_add_signed(k);
            convolve_symmetric(&mut out[span.clone()], &self.kernel, |k| &self.padded[start(k)..][..span.len()]);
        }
        *spans = dilate_spans(spans, radius, width);
        for (y, out) in image.chunks_exact_mut(width).enumerate() {
            let span = &spans[y];
            let row = |k: isize| mirror(y as isize + k, height) * width;
            convolve_symmetric(&mut out[span.clone()], &self.kernel, |k| {
                &self.across[row(k) + span.start..][..span.len()]
            });
        }
        for (row, span) in self.across.chunks_exact_mut(width).zip(&*spans) {
            row[span.clone()].fill(0.0);
        }
    }
}

/// Columns from the first to the last nonzero value of each row.
fn nonzero_spans(image: &[f32], width: usize) -> Vec<Range<usize>> {
    let span = |row: &[f32]| {
        let first = row.iter().position(|&v| v != 0.0);
        first.map_or(0..0, |first| first..row.iter().rposition(|&v| v != 0.0).unwrap_or(first) + 1)
    };
    image.chunks_exact(width).map(span).collect()
}

fn dilate_span(span: &Range<usize>, radius: usize, width: usize) -> Range<usize> {
    if span.is_empty() { 0..0 } else { span.start.saturating_sub(radius)..(span.end + radius).min(width) }
}

/// Returns the least span that contains all of some rows' spans.
fn union(spans: &[Range<usize>]) -> Range<usize> {
    let nonempty = || spans.iter().filter(|span| !span.is_empty());
    let (start, end) = (nonempty().map(|span| span.start).min(), nonempty().map(|span| span.end).max());
    start.unwrap_or(0)..end.unwrap_or(0)
}

/// Extends spans by `radius` rows and columns.
fn dilate_spans(spans: &[Range<usize>], radius: usize, width: usize) -> Vec<Range<usize>> {
    let rows = |y: usize| &spans[y.saturating_sub(radius)..(y + radius + 1).min(spans.len())];
    (0..spans.len()).map(|y| dilate_span(&union(rows(y)), radius, width)).collect()
}

/// Spans of the image of half the size.
fn halve_spans(spans: &[Range<usize>]) -> Vec<Range<usize>> {
    spans.chunks(2).map(union).map(|span| span.start / 2..half(span.end)).collect()
}

/// Halves a side, rounding up.
fn half(side: usize) -> usize {
    side.div_ceil(2)
}

/// Averages 2x2 pixels; the last row or column of an odd side counts twice.
fn halve(image: &[f32], width: usize, out: &mut Vec<f32>) {
    let height = image.len() / width;
    out.clear();
    for y in 0..half(height) {
        let top = &image[2 * y * width..][..width];
        let bottom = &image[(2 * y + 1).min(height - 1) * width..][..width];
        let ((tops, end), (bottoms, below)) = (top.as_chunks::<2>(), bottom.as_chunks::<2>());
        out.extend(tops.iter().zip(bottoms).map(|(a, b)| 0.25 * ((a[0] + a[1]) + (b[0] + b[1]))));
        out.extend(end.iter().zip(below).map(|(a, b)| 0.25 * ((a + a) + (b + b))));
    }
}

/// Doubles `image` by bilinear interpolation and adds it to `out`, whose rows have `width` pixels.
pub(super) fn add_doubled(image: &[f32], out: &mut [f32], width: usize) {
    let small = half(width);
    let height = image.len() / small;
    let mut line = vec![0.0; small + 2];
    for (y, out) in out.chunks_exact_mut(width).enumerate() {
        // A pixel lies a quarter of a coarse pixel from the centre of its coarse pixel.
        let nearest = &image[y / 2 * small..][..small];
        let next = if y % 2 == 0 { (y / 2).saturating_sub(1) } else { (y / 2 + 1).min(height - 1) };
        let next = &image[next * small..][..small];
        for ((l, a), b) in line[1..].iter_mut().zip(nearest).zip(next) {
            *l = 0.75 * a + 0.25 * b;
        }
        line[0] = line[1];
        line[small + 1] = line[small];
        let (pairs, end) = out.as_chunks_mut::<2>();
        for (((pair, before), centre), behind) in pairs.iter_mut().zip(&line).zip(&line[1..]).zip(&line[2..]) {
            pair[0] += 0.75 * centre + 0.25 * before;
            pair[1] += 0.75 * centre + 0.25 * behind;
        }
        end.iter_mut().for_each(|last| *last += 0.75 * line[small] + 0.25 * line[small - 1]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn shares_sum_to_one_and_name_the_pattern() {
        // A bright column in a dark image, and one bright dot.
        let image: Vec<f32> = (0..64).map(|i| if i % 8 == 2 || i == 46 { 1.0 } else { 0.0 }).collect();
        let shares = textons(&image, 8);
        for i in 0..64 {
            let sum: f32 = shares.iter().map(|s| s[i]).sum();
            assert!((sum - 1.0).abs() < 1e-5, "{sum} at {i}");
        }
        let on_line = 3 * 8 + 2;
        assert!(shares[1][on_line] > 0.3 && shares[3][on_line] == 0.0, "a column is a line across x");
        assert_eq!(shares[0][3 * 8 + 5 - 1], 1.0, "flat beside them");
        assert!(shares[5][on_line + 1] > 0.0, "dark beside bright");
        assert_eq!(textons(&[0.3], 1)[0], [1.0]);
    }

    fn noise(width: usize, height: usize) -> Vec<f32> {
        let mut rng = Rng::for_stage(3, "blur");
        (0..width * height).map(|_| rng.uniform() as f32).collect()
    }

    #[test]
    fn the_blur_equals_the_sum_over_its_window_at_any_size() {
        for (w, h, sigma) in [(9, 7, 1.5), (1, 1, 2.0), (1, 6, 1.0), (5, 2, 3.0), (4, 4, 0.0), (6, 3, 0.7)] {
            let image = noise(w, h);
            let mut fast = image.clone();
            Blur::new(sigma).apply(&mut fast, w);
            let kernel = half_kernel(sigma);
            let r = kernel.len() as isize - 1;
            for (i, value) in fast.iter().enumerate() {
                let (x, y) = ((i % w) as isize, (i / w) as isize);
                let mut sum = 0.0;
                for (dy, dx) in (-r..=r).flat_map(|dy| (-r..=r).map(move |dx| (dy, dx))) {
                    let weight = kernel[dx.unsigned_abs()] * kernel[dy.unsigned_abs()];
                    sum += weight * image[mirror(y + dy, h) * w + mirror(x + dx, w)];
                }
                assert!((sum - value).abs() < 1e-5, "{w}x{h}, sigma {sigma}: {value} for {sum} at {x}, {y}");
            }
        }
    }

    #[test]
    fn halving_and_doubling_keep_constants_and_doubling_keeps_slopes() {
        for (w, h) in [(7, 5), (8, 4), (1, 1), (2, 1), (1, 3)] {
            let mut small = Vec::new();
            halve(&vec![2.5; w * h], w, &mut small);
            assert_eq!(small, vec![2.5; half(w) * half(h)]);
            let mut large = vec![1.0; w * h];
            add_doubled(&small, &mut large, w);
            assert_eq!(large, vec![3.5; w * h]);
        }
        let ramp: Vec<f32> = (0..6).flat_map(|y| (0..10).map(move |x| (x + 3 * y) as f32)).collect();
        let mut small = Vec::new();
        halve(&ramp, 10, &mut small);
        let mut large = vec![0.0; 60];
        add_doubled(&small, &mut large, 10);
        for (y, x) in (1..5).flat_map(|y| (1..9).map(move |x| (y, x))) {
            assert!((large[y * 10 + x] - ramp[y * 10 + x]).abs() < 1e-5);
        }
    }
}
