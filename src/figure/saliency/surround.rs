//! Centre-surround contrast (Rahtu, Kannala, Salo and Heikkilä, "Segmenting salient objects from images and videos",
//! ECCV 2010) of one number a pixel, given as its bin.
//!
//! In: the bin of each pixel. Out: for each bin and each pixel how salient a pixel there would be if it were in this
//! bin.
//!
//! 1. A window of [`SHAPES`] at every place of its grid: an inner rectangle K and a ring B around it, both cut at the
//!    frame.
//! 2. The histograms of K and of B, smoothed along the bins, are `p(b | K)` and `p(b | B)`.
//! 3. With the prior `p0`, a pixel of K in bin `b` is salient with `S = p(b|K) p0 / (p(b|K) p0 + p(b|B) (1 − p0))`.
//! 4. A pixel takes the greatest `S` of all windows whose K covers it.
//!
//! Exact, but not by writing windows: `S` depends on the bin alone, so each window is a row of numbers, one a bin,
//! found from integral histograms, and step 4 is a sliding maximum over the windows' grid, bin by bin. The windows that
//! cover a pixel are contiguous along either axis; the greatest of a run comes from two overlapping runs of a power of
//! two, which doubling yields.
//!
//! Windows may exceed the frame, where they are cut, as long as [`LEAST_INNER`] of K and [`LEAST_RING`] of B remain to
//! be compared.

use crate::image::Plane;

/// Rows and columns of K and the step of its grid, in parts of the frame's longer side (Rahtu et al.'s program).
const SHAPES: [[f64; 3]; 4] = [[0.25, 0.10, 0.010], [0.30, 0.30, 0.015], [0.50, 0.50, 0.030], [0.70, 0.40, 0.040]];

/// Width of the ring, in parts of K's longer side.
const RING: f64 = 0.1;

/// Least part of K that must lie in the frame: half of either side.
const LEAST_INNER: f64 = 0.25;

/// Least part of a ring that must lie in the frame.
const LEAST_RING: f64 = 0.1;

/// Standard deviation of the smoothing of histograms along the bins, in bins (Rahtu et al.: 1).
const SMOOTHING: f32 = 1.0;

/// Settings of the contrast.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Contrast {
    pub(super) num_bins: usize,
    /// `p0`.
    pub(super) prior: f32,
}

/// A window at any place: sides of K, width of the ring, step of the grid; in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Shape {
    width: usize,
    height: usize,
    ring: usize,
    step: usize,
}

impl Shape {
    fn all(width: usize, height: usize) -> [Self; 4] {
        let side = width.max(height) as f64;
        SHAPES.map(|[rows, columns, step]| {
            let pixels = |part: f64| ((part * side).round() as usize).max(1);
            let ring = ((RING * rows.max(columns) * side).round() as usize).max(1);
            Self { width: pixels(columns), height: pixels(rows), ring, step: ((step * side).ceil() as usize).max(1) }
        })
    }
}

/// Places of a window along one axis: all that cover a pixel at all, a step apart.
#[derive(Debug, Clone, Copy)]
struct Places {
    length: usize,
    step: usize,
    count: usize,
}

impl Places {
    fn new(length: usize, step: usize, side: usize) -> Self {
        let step = step.min(length);
        Self { length, step, count: (side + length - 2) / step + 1 }
    }

    /// First pixel of place `k`, negative where the window is cut.
    fn begin(&self, k: usize) -> isize {
        (k * self.step) as isize - (self.length - 1) as isize
    }

    /// First and last place that covers pixel `x`.
    fn covering(&self, x: usize) -> (usize, usize) {
        (x.div_ceil(self.step), (x + self.length - 1) / self.step)
    }

    /// The greatest power of two that is not more than the number of places that cover any pixel. Numbers differ by at
    /// most one, so two runs of this length make up each.
    fn run(&self) -> usize {
        1 << (self.length / self.step).ilog2()
    }
}

/// Counts of the pixels of each bin left of and above a corner.
struct Integral {
    num_bins: usize,
    stride: usize,
    size: (usize, usize),
    sums: Vec<u32>,
}

impl Integral {
    fn new(bins: &Plane<u8>, num_bins: usize) -> Self {
        let size = (bins.width(), bins.height());
        let stride = (size.0 + 1) * num_bins;
        let mut sums = vec![0_u32; stride * (size.1 + 1)];
        let mut row = vec![0_u32; num_bins];
        for y in 0..size.1 {
            row.fill(0);
            let (above, below) = sums[y * stride..(y + 2) * stride].split_at_mut(stride);
            let corners = below.chunks_exact_mut(num_bins).zip(above.chunks_exact(num_bins)).skip(1);
            for ((below, above), &bin) in corners.zip(bins.row(y)) {
                row[bin as usize] += 1;
                for ((below, above), row) in below.iter_mut().zip(above).zip(&row) {
                    *below = above + row;
                }
            }
        }
        Self { num_bins, stride, size, sums }
    }

    fn corner(&self, x: usize, y: usize) -> &[u32] {
        let at = y * self.stride + x * self.num_bins;
        &self.sums[at..at + self.num_bins]
    }

    /// Counts each bin's pixels in a rectangle, cut at the frame, and returns how many they are.
    fn count(&self, (x, y): (isize, isize), (width, height): (usize, usize), counts: &mut [u32]) -> u32 {
        let cut = |from: isize, length: usize, side: usize| {
            (from.clamp(0, side as isize) as usize, (from + length as isize).clamp(0, side as isize) as usize)
        };
        let ((left, right), (top, bottom)) = (cut(x, width, self.size.0), cut(y, height, self.size.1));
        let [a, b, c, d] = [(left, top), (right, top), (left, bottom), (right, bottom)].map(|(x, y)| self.corner(x, y));
        for (((count, a), b), (c, d)) in counts.iter_mut().zip(a).zip(b).zip(c.iter().zip(d)) {
            *count = (d + a) - (b + c);
        }
        ((right - left) * (bottom - top)) as u32
    }
}

/// The saliency of each bin in a window, step by step.
struct Posterior<'a> {
    contrast: &'a Contrast,
    /// Weights of the smoothing from the middle outwards.
    kernel: Vec<f32>,
    inner: Vec<u32>,
    outer: Vec<u32>,
    smooth: [Vec<f32>; 2],
}

impl<'a> Posterior<'a> {
    fn new(contrast: &'a Contrast) -> Self {
        let reach = (2.0 * SMOOTHING).ceil() as usize;
        let kernel = (0..=reach).map(|k| libm::expf(-0.5 * (k as f32 / SMOOTHING).powi(2))).collect();
        let n = contrast.num_bins;
        Self { contrast, kernel, inner: vec![0; n], outer: vec![0; n], smooth: [vec![0.0; n], vec![0.0; n]] }
    }

    /// Writes `S` of each bin for the window that begins at `(x, y)`; zero for a window without a ring.
    fn of_window(&mut self, integral: &Integral, shape: &Shape, (x, y): (isize, isize), into: &mut [f32]) {
        let (width, height, ring) = (shape.width, shape.height, shape.ring);
        let within = integral.count((x, y), (width, height), &mut self.inner);
        let (left, top) = (x - ring as isize, y - ring as isize);
        let whole = (width + 2 * ring, height + 2 * ring);
        let around = integral.count((left, top), whole, &mut self.outer) - within;
        let nominal = whole.0 * whole.1 - width * height;
        let too_little = |part: u32, whole: usize, least: f64| f64::from(part) < least * whole as f64;
        if too_little(within, width * height, LEAST_INNER) || too_little(around, nominal, LEAST_RING) {
            into.fill(0.0);
            return;
        }
        for (outer, inner) in self.outer.iter_mut().zip(&self.inner) {
            *outer -= inner;
        }
        smooth(&self.inner, &self.kernel, &mut self.smooth[0]);
        smooth(&self.outer, &self.kernel, &mut self.smooth[1]);
        let total = |v: &[f32]| v.iter().sum::<f32>();
        // Both histograms brought to the same sum, with the prior.
        let inside = self.contrast.prior * total(&self.smooth[1]);
        let outside = (1.0 - self.contrast.prior) * total(&self.smooth[0]);
        for (into, (k, b)) in into.iter_mut().zip(self.smooth[0].iter().zip(&self.smooth[1])) {
            let (k, b) = (k * inside, b * outside);
            *into = if k > 0.0 { k / (k + b) } else { 0.0 };
        }
    }
}

/// `counts` smoothed by a kernel; beyond either end the outermost bin goes on.
fn smooth(counts: &[u32], kernel: &[f32], into: &mut [f32]) {
    let last = counts.len() - 1;
    for (b, into) in into.iter_mut().enumerate() {
        let mut sum = kernel[0] * counts[b] as f32;
        for (k, weight) in kernel.iter().enumerate().skip(1) {
            sum += weight * (counts[b.saturating_sub(k)] + counts[(b + k).min(last)]) as f32;
        }
        *into = sum;
    }
}

/// For each bin and each pixel the saliency that a pixel of this bin has there: a plane for each bin, one after the
/// other.
pub(super) fn surround(bins: &Plane<u8>, contrast: &Contrast) -> Vec<f32> {
    let (width, height) = (bins.width(), bins.height());
    let mut found = vec![0.0_f32; contrast.num_bins * width * height];
    let integral = Integral::new(bins, contrast.num_bins);
    let mut posterior = Posterior::new(contrast);
    for shape in Shape::all(width, height) {
        let across = Places::new(shape.width, shape.step, width);
        let down = Places::new(shape.height, shape.step, height);
        let windows = evaluate(&integral, &mut posterior, &shape, (&across, &down));
        let grids = windows.chunks_exact(across.count * down.count);
        for (grid, found) in grids.zip(found.chunks_exact_mut(width * height)) {
            spread(grid, (&across, &down), found, width);
        }
    }
    found
}

/// `S` of every bin of every window of a shape: a grid of windows for each bin, one after the other.
fn evaluate(
    integral: &Integral,
    posterior: &mut Posterior<'_>,
    shape: &Shape,
    (across, down): (&Places, &Places),
) -> Vec<f32> {
    let size = across.count * down.count;
    let mut windows = vec![0.0; size * integral.num_bins];
    let mut row = vec![0.0; integral.num_bins];
    for j in 0..down.count {
        for i in 0..across.count {
            posterior.of_window(integral, shape, (across.begin(i), down.begin(j)), &mut row);
            for (b, &s) in row.iter().enumerate() {
                windows[b * size + j * across.count + i] = s;
            }
        }
    }
    windows
}

/// Step 4 for one bin: raises each pixel of `found` to the greatest of the windows that cover it.
fn spread(grid: &[f32], (across, down): (&Places, &Places), found: &mut [f32], width: usize) {
    let columns = across.count;
    let (tall, long) = (down.run(), across.run());
    // `runs[j]` is the greatest of the rows `j..j + tall`.
    let mut runs = grid.to_vec();
    doubled(&mut runs, columns, tall);
    let mut row = vec![0.0_f32; columns];
    for (y, found) in found.chunks_exact_mut(width).enumerate() {
        let (first, last) = down.covering(y);
        let second = (last + 1).saturating_sub(tall).max(first);
        let (a, b) = (&runs[first * columns..][..columns], &runs[second * columns..][..columns]);
        for (row, (a, b)) in row.iter_mut().zip(a.iter().zip(b)) {
            *row = a.max(*b);
        }
        doubled(&mut row, 1, long);
        for (x, found) in found.iter_mut().enumerate() {
            let (first, last) = across.covering(x);
            let second = (last + 1).saturating_sub(long).max(first);
            *found = found.max(row[first]).max(row[second]);
        }
    }
}

/// Each block of `size` values becomes the greatest, place by place, of itself and those after it, `length` blocks in
/// all (a power of two); at the end of those that there are.
fn doubled(values: &mut [f32], size: usize, length: usize) {
    let mut reach = 1;
    while reach < length {
        let offset = reach * size;
        for at in 0..values.len().saturating_sub(offset) {
            values[at] = values[at].max(values[at + offset]);
        }
        reach *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    fn contrast(num_bins: usize) -> Contrast {
        Contrast { num_bins, prior: 0.2 }
    }

    /// Writes each window, pixel by pixel.
    fn naive(bins: &Plane<u8>, contrast: &Contrast) -> Plane<f32> {
        let (width, height) = (bins.width() as isize, bins.height() as isize);
        let mut map = bins.map(|_| 0.0_f32);
        let pixels = |left: isize, top: isize, w: isize, h: isize| {
            (top.max(0)..(top + h).min(height))
                .flat_map(move |y| (left.max(0)..(left + w).min(width)).map(move |x| (x as usize, y as usize)))
        };
        for shape in Shape::all(bins.width(), bins.height()) {
            let (w, h, ring) = (shape.width as isize, shape.height as isize, shape.ring as isize);
            let (step_x, step_y) = (shape.step.min(shape.width), shape.step.min(shape.height));
            for top in (1 - h..height).step_by(step_y) {
                for left in (1 - w..width).step_by(step_x) {
                    let (mut k, mut b) = (vec![0_u32; contrast.num_bins], vec![0_u32; contrast.num_bins]);
                    pixels(left, top, w, h).for_each(|at| k[bins[at] as usize] += 1);
                    let whole = pixels(left - ring, top - ring, w + 2 * ring, h + 2 * ring);
                    whole.for_each(|at| b[bins[at] as usize] += 1);
                    b.iter_mut().zip(&k).for_each(|(b, k)| *b -= k);
                    let nominal = ((w + 2 * ring) * (h + 2 * ring) - w * h) as f64;
                    let sum = |counts: &[u32]| f64::from(counts.iter().sum::<u32>());
                    if sum(&k) < 0.25 * (w * h) as f64 || sum(&b) < 0.1 * nominal {
                        continue;
                    }
                    let (k, b) = (density(&k), density(&b));
                    for at in pixels(left, top, w, h) {
                        let (k, b) = (k[bins[at] as usize], b[bins[at] as usize]);
                        let s = k * 0.2 / (k * 0.2 + b * 0.8);
                        map[at] = map[at].max(s as f32);
                    }
                }
            }
        }
        map
    }

    /// Counts smoothed with replicated ends, to a sum of 1.
    fn density(counts: &[u32]) -> Vec<f64> {
        let last = counts.len() as isize - 1;
        let sigma = f64::from(SMOOTHING);
        let reach = (2.0 * sigma).ceil() as isize;
        let smooth = |at: isize| {
            (-reach..=reach)
                .map(|k| {
                    (-0.5 * (k as f64 / sigma).powi(2)).exp() * f64::from(counts[(at + k).clamp(0, last) as usize])
                })
                .sum::<f64>()
        };
        let smoothed: Vec<f64> = (0..=last).map(smooth).collect();
        let sum: f64 = smoothed.iter().sum();
        smoothed.iter().map(|v| v / sum).collect()
    }

    fn looked_up(bins: &Plane<u8>, contrast: &Contrast) -> Plane<f32> {
        let found = surround(bins, contrast);
        let size = bins.width() * bins.height();
        Plane::from_fn(bins.width(), bins.height(), |x, y| {
            found[usize::from(bins[(x, y)]) * size + y * bins.width() + x]
        })
    }

    #[test]
    fn the_fast_contrast_is_that_of_every_window_written() {
        let mut rng = Rng::for_stage(5, "test");
        for (width, height, num_bins) in [(1, 1, 2), (7, 1, 3), (2, 9, 4), (31, 22, 15), (22, 47, 5), (80, 60, 15)] {
            let contrast = contrast(num_bins);
            // A block on noise, so that there is something to find.
            let bins = Plane::from_fn(width, height, |x, y| {
                let on = x > width / 3 && x < width / 2 && y > height / 4;
                if on { num_bins as u8 - 1 } else { rng.below(num_bins) as u8 / 2 }
            });
            let (fast, slow) = (looked_up(&bins, &contrast), naive(&bins, &contrast));
            for (a, b) in fast.data().iter().zip(slow.data()) {
                assert!((a - b).abs() < 1e-4, "{width} x {height}: {a} not {b}");
            }
        }
    }

    #[test]
    fn where_all_pixels_are_alike_each_has_the_prior() {
        let map = looked_up(&Plane::filled(64, 48, 3), &contrast(15));
        assert!(map.data().iter().all(|s| (s - 0.2).abs() < 1e-5));
    }

    #[test]
    fn a_block_of_its_own_kind_stands_out_and_its_ground_does_not() {
        let bins = Plane::from_fn(80, 60, |x, y| if (30..46).contains(&x) && (20..40).contains(&y) { 9 } else { 0 });
        let map = looked_up(&bins, &contrast(15));
        assert!(map[(38, 30)] > 0.9 && map[(30, 20)] > 0.9, "{}", map[(38, 30)]);
        assert!(map[(5, 5)] < 0.4 && map[(70, 50)] < 0.4, "{} {}", map[(5, 5)], map[(70, 50)]);
    }
}
