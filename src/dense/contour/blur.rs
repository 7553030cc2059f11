//! Gaussian blur with mirrored borders, and images of half the size; the same bits on every machine.

use crate::image::weigh;
use std::ops::Range;

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

/// The index in `0..n` that stands at `i` behind a mirrored border: `-1` shows `0`, `n` shows `n - 1`.
pub(super) fn mirror(i: isize, n: usize) -> usize {
    if (0..n as isize).contains(&i) {
        return i as usize;
    }
    let period = 2 * n as isize;
    let wrapped = i.rem_euclid(period);
    wrapped.min(period - 1 - wrapped) as usize
}

/// `row` with `radius` mirrored values before and behind it.
pub(super) fn pad(row: &[f32], radius: usize, padded: &mut Vec<f32>) {
    padded.clear();
    let n = row.len();
    padded.extend((0..radius).map(|k| row[mirror(k as isize - radius as isize, n)]));
    padded.extend_from_slice(row);
    padded.extend((0..radius).map(|k| row[mirror((n + k) as isize, n)]));
}

/// Blurs images in place; keeps its memory from one to the next.
#[derive(Debug)]
pub(super) struct Blur {
    kernel: Vec<f32>,
    padded: Vec<f32>,
    across: Vec<f32>,
}

impl Blur {
    pub(super) fn new(sigma: f32) -> Self {
        Self { kernel: half_kernel(sigma), padded: Vec::new(), across: Vec::new() }
    }

    /// `image` holds rows of `width` values.
    pub(super) fn apply(&mut self, image: &mut [f32], width: usize) {
        let mut spans = vec![0..width; image.len() / width];
        self.apply_within(image, width, &mut spans);
    }

    /// The same of an image that is 0 outside of `spans`, which are those of the blurred one after that.
    pub(super) fn apply_within(&mut self, image: &mut [f32], width: usize, spans: &mut Vec<Range<usize>>) {
        let radius = self.kernel.len() - 1;
        let height = image.len() / width;
        self.across.clear();
        self.across.resize(image.len(), 0.0);
        let rows = image.chunks_exact(width).zip(self.across.chunks_exact_mut(width));
        for ((row, out), span) in rows.zip(&*spans).filter(|(_, span)| !span.is_empty()) {
            pad(row, radius, &mut self.padded);
            let span = wider(span, radius, width);
            let from = |k: isize| (span.start + radius).wrapping_add_signed(k);
            weigh(&mut out[span.clone()], &self.kernel, |k| &self.padded[from(k)..][..span.len()]);
        }
        *spans = widened(spans, radius, width);
        for (y, out) in image.chunks_exact_mut(width).enumerate() {
            let span = &spans[y];
            let row = |k: isize| mirror(y as isize + k, height) * width;
            weigh(&mut out[span.clone()], &self.kernel, |k| &self.across[row(k) + span.start..][..span.len()]);
        }
    }
}

/// The columns from the first to the last value of each row that is not 0.
pub(super) fn spans(image: &[f32], width: usize) -> Vec<Range<usize>> {
    let span = |row: &[f32]| {
        let first = row.iter().position(|&v| v != 0.0);
        first.map_or(0..0, |first| first..row.iter().rposition(|&v| v != 0.0).unwrap_or(first) + 1)
    };
    image.chunks_exact(width).map(span).collect()
}

fn wider(span: &Range<usize>, reach: usize, width: usize) -> Range<usize> {
    if span.is_empty() { 0..0 } else { span.start.saturating_sub(reach)..(span.end + reach).min(width) }
}

/// What holds all of some rows.
fn joined(spans: &[Range<usize>]) -> Range<usize> {
    let some = || spans.iter().filter(|span| !span.is_empty());
    let (start, end) = (some().map(|span| span.start).min(), some().map(|span| span.end).max());
    start.unwrap_or(0)..end.unwrap_or(0)
}

/// All that is at most `reach` rows and columns from what was in them, mirrored borders included.
pub(super) fn widened(spans: &[Range<usize>], reach: usize, width: usize) -> Vec<Range<usize>> {
    let near = |y: usize| &spans[y.saturating_sub(reach)..(y + reach + 1).min(spans.len())];
    (0..spans.len()).map(|y| wider(&joined(near(y)), reach, width)).collect()
}

/// Those of the image of half the size.
pub(super) fn spans_of_half(spans: &[Range<usize>]) -> Vec<Range<usize>> {
    spans.chunks(2).map(joined).map(|span| span.start / 2..half(span.end)).collect()
}

/// Half of a side, rounded up.
pub(super) fn half(side: usize) -> usize {
    side.div_ceil(2)
}

/// Means of 2x2 pixels; the last row or column of an odd side counts twice.
pub(super) fn halve(image: &[f32], width: usize, out: &mut Vec<f32>) {
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

/// Adds `image`, twice as large by bilinear interpolation, to `out`, whose rows have `width` pixels.
pub(super) fn add_doubled(image: &[f32], out: &mut [f32], width: usize) {
    let small = half(width);
    let height = image.len() / small;
    let mut line = vec![0.0; small + 2];
    for (y, out) in out.chunks_exact_mut(width).enumerate() {
        // A pixel lies a quarter of a coarse pixel from the centre of the coarse pixel over it.
        let near = &image[y / 2 * small..][..small];
        let far = if y % 2 == 0 { (y / 2).saturating_sub(1) } else { (y / 2 + 1).min(height - 1) };
        let far = &image[far * small..][..small];
        for ((l, a), b) in line[1..].iter_mut().zip(near).zip(far) {
            *l = 0.75 * a + 0.25 * b;
        }
        line[0] = line[1];
        line[small + 1] = line[small];
        let (pairs, end) = out.as_chunks_mut::<2>();
        for (((pair, before), here), behind) in pairs.iter_mut().zip(&line).zip(&line[1..]).zip(&line[2..]) {
            pair[0] += 0.75 * here + 0.25 * before;
            pair[1] += 0.75 * here + 0.25 * behind;
        }
        end.iter_mut().for_each(|last| *last += 0.75 * line[small] + 0.25 * line[small - 1]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

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
