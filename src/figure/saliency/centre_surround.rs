//! Centre-surround contrast (Rahtu, Kannala, Salo and Heikkilä, "Segmenting salient objects from images and videos",
//! ECCV 2010) of a map of bins.
//!
//! In: the bin of each pixel of a map, and queried pixels with a bin each. Out: the saliency of these pixels.
//!
//! 1. Windows of [`WINDOWS`] slide over the map: an inner rectangle K and a ring B around it, both cropped at the frame.
//! 2. The histograms of K and of B, smoothed along the bins, are `p(b | K)` and `p(b | B)`.
//! 3. With the prior `p0`, a pixel of K in bin `b` is salient with `S = p(b|K) p0 / (p(b|K) p0 + p(b|B) (1 − p0))`.
//! 4. A pixel has the greatest `S` of all windows whose K covers it.
//!
//! Exact, but without a pass over the pixels of each window: `S` depends on the bin alone, so that a window is a row of
//! numbers, one a bin, from integral histograms, and step 4 is a sliding maximum over the windows' grid, bin by bin. The
//! windows that cover a pixel are contiguous along either axis; the maximum of a run is that over two overlapping runs of
//! a power of two. Cost: O(pixels + windows) · bins.
//!
//! A window counts if at least [`MIN_INNER_SHARE`] of K and [`MIN_RING_SHARE`] of B lie in the frame.

use crate::image::Plane;
use crate::order::larger;

/// Rows and columns of K and the step of its grid, in parts of the frame's longer side (Rahtu et al.'s program).
const WINDOWS: [[f64; 3]; 4] = [[0.25, 0.10, 0.010], [0.30, 0.30, 0.015], [0.50, 0.50, 0.030], [0.70, 0.40, 0.040]];

/// Width of the ring, as a part of K's longer side (Rahtu et al.'s program).
const RING_WIDTH: f64 = 0.1;

/// Least share of K that must lie in the frame: half of either side. Chosen by eye.
const MIN_INNER_SHARE: f64 = 0.25;

/// Least share of a ring that must lie in the frame. Chosen by eye.
const MIN_RING_SHARE: f64 = 0.1;

/// Standard deviation of the smoothing of histograms along the bins, in bins (Rahtu et al.: 1).
const SMOOTHING_BINS: f32 = 1.0;

/// Number of bins, and prior.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ContrastParams {
    pub(super) num_bins: usize,
    /// `p0`.
    pub(super) prior: f32,
}

/// Sides of K, width of the ring and step of the grid, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
struct WindowShape {
    width: usize,
    height: usize,
    ring: usize,
    step: usize,
}

impl WindowShape {
    fn of_frame(width: usize, height: usize) -> [Self; 4] {
        let side = width.max(height) as f64;
        WINDOWS.map(|[rows, columns, step]| {
            let pixels = |part: f64| ((part * side).round() as usize).max(1);
            let ring = ((RING_WIDTH * rows.max(columns) * side).round() as usize).max(1);
            Self { width: pixels(columns), height: pixels(rows), ring, step: ((step * side).ceil() as usize).max(1) }
        })
    }
}

/// Positions of a window along one axis: all that cover any pixel, a step apart.
#[derive(Debug, Clone, Copy)]
struct WindowAxis {
    length: usize,
    step: usize,
    count: usize,
}

impl WindowAxis {
    fn new(length: usize, step: usize, side: usize) -> Self {
        let step = step.min(length);
        Self { length, step, count: (side + length - 2) / step + 1 }
    }

    /// First pixel of window `k`, negative where the window is cropped.
    fn start(&self, k: usize) -> isize {
        (k * self.step) as isize - (self.length - 1) as isize
    }

    /// First and last window that covers pixel `x`.
    fn covering(&self, x: usize) -> (usize, usize) {
        (x.div_ceil(self.step), (x + self.length - 1) / self.step)
    }

    /// Largest power of two up to the number of windows that cover a pixel. That number varies by at most one, so that two
    /// runs of this length make up each.
    fn run_length(&self) -> usize {
        1 << (self.length / self.step).ilog2()
    }

    /// Starts of the two runs that make up the windows that cover pixel `x`.
    fn runs(&self, x: usize) -> [usize; 2] {
        let (first, last) = self.covering(x);
        [first, (last + 1).saturating_sub(self.run_length()).max(first)]
    }
}

/// Number of pixels of each bin left of and above each corner.
struct IntegralHistogram {
    num_bins: usize,
    stride: usize,
    size: (usize, usize),
    sums: Vec<u32>,
}

impl IntegralHistogram {
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
        let start = y * self.stride + x * self.num_bins;
        &self.sums[start..start + self.num_bins]
    }

    /// Crops the rectangle that begins at `(x, y)` at the frame.
    fn crop(&self, x: isize, y: isize, width: usize, height: usize) -> Rect {
        let clamp = |start: isize, length: usize, side: usize| {
            [start.clamp(0, side as isize) as usize, (start + length as isize).clamp(0, side as isize) as usize]
        };
        Rect { columns: clamp(x, width, self.size.0), rows: clamp(y, height, self.size.1) }
    }

    /// Counts each bin's pixels in a rectangle.
    fn count(&self, rect: Rect, counts: &mut [u32]) {
        let Rect { columns: [x0, x1], rows: [y0, y1] } = rect;
        let [a, b, c, d] = [(x0, y0), (x1, y0), (x0, y1), (x1, y1)].map(|(x, y)| self.corner(x, y));
        for (((count, a), b), (c, d)) in counts.iter_mut().zip(a).zip(b).zip(c.iter().zip(d)) {
            *count = (d + a) - (b + c);
        }
    }
}

/// Columns and rows of a rectangle: the first, and the one after the last.
#[derive(Debug, Clone, Copy)]
struct Rect {
    columns: [usize; 2],
    rows: [usize; 2],
}

impl Rect {
    fn area(&self) -> usize {
        (self.columns[1] - self.columns[0]) * (self.rows[1] - self.rows[0])
    }
}

/// Radius of the smoothing kernel, in bins: two standard deviations (Rahtu et al.).
const SMOOTHING_RADIUS: usize = 2;

/// Saliency of each bin in a window, and its buffers.
struct Posterior<'a> {
    contrast: &'a ContrastParams,
    /// Smoothing weights from the centre outwards.
    kernel: [f32; SMOOTHING_RADIUS + 1],
    inner: Vec<u32>,
    outer: Vec<u32>,
    /// Counts, extended by the outermost ones.
    padded: Vec<u32>,
    smooth: [Vec<f32>; 2],
}

impl<'a> Posterior<'a> {
    fn new(contrast: &'a ContrastParams) -> Self {
        let kernel = std::array::from_fn(|k| libm::expf(-0.5 * (k as f32 / SMOOTHING_BINS).powi(2)));
        let n = contrast.num_bins;
        let (inner, outer, padded) = (vec![0; n], vec![0; n], vec![0; n + 2 * SMOOTHING_RADIUS]);
        Self { contrast, kernel, inner, outer, padded, smooth: [vec![0.0; n], vec![0.0; n]] }
    }

    /// Writes `S` of each bin for the window that begins at `(x, y)`; zero for a window that is mostly outside.
    fn evaluate(
        &mut self,
        integral: &IntegralHistogram,
        shape: &WindowShape,
        x: isize,
        y: isize,
        saliency: &mut [f32],
    ) {
        let (width, height, ring) = (shape.width, shape.height, shape.ring);
        let inner = integral.crop(x, y, width, height);
        let (outer_width, outer_height) = (width + 2 * ring, height + 2 * ring);
        let outer = integral.crop(x - ring as isize, y - ring as isize, outer_width, outer_height);
        let ring_area = outer_width * outer_height - width * height;
        let is_too_small = |area: usize, full_area: usize, min_share: f64| (area as f64) < min_share * full_area as f64;
        let inner_area = inner.area();
        if is_too_small(inner_area, width * height, MIN_INNER_SHARE)
            || is_too_small(outer.area() - inner_area, ring_area, MIN_RING_SHARE)
        {
            saliency.fill(0.0);
            return;
        }
        integral.count(inner, &mut self.inner);
        integral.count(outer, &mut self.outer);
        for (outer, inner) in self.outer.iter_mut().zip(&self.inner) {
            *outer -= inner;
        }
        smooth(&self.inner, &self.kernel, &mut self.padded, &mut self.smooth[0]);
        smooth(&self.outer, &self.kernel, &mut self.padded, &mut self.smooth[1]);
        let total = |v: &[f32]| v.iter().sum::<f32>();
        // Both histograms brought to the same sum, with the prior.
        let inside = self.contrast.prior * total(&self.smooth[1]);
        let outside = (1.0 - self.contrast.prior) * total(&self.smooth[0]);
        for (saliency, (k, b)) in saliency.iter_mut().zip(self.smooth[0].iter().zip(&self.smooth[1])) {
            let (k, b) = (k * inside, b * outside);
            let s = k / (k + b);
            *saliency = if k > 0.0 { s } else { 0.0 };
        }
    }
}

/// Smooths `counts` by a kernel, extended by the outermost bins.
fn smooth(counts: &[u32], kernel: &[f32; SMOOTHING_RADIUS + 1], padded: &mut [u32], smoothed: &mut [f32]) {
    let n = counts.len();
    padded[..SMOOTHING_RADIUS].fill(counts[0]);
    padded[SMOOTHING_RADIUS..SMOOTHING_RADIUS + n].copy_from_slice(counts);
    padded[SMOOTHING_RADIUS + n..].fill(counts[n - 1]);
    let shifted = |k: usize| &padded[k..k + n];
    let [minus2, minus1, centre, plus1, plus2] = [0, 1, 2, 3, 4].map(shifted);
    // Counts of a frame fit into signed numbers, which become floats faster.
    let float = |count: u32| count as i32 as f32;
    for (b, smoothed) in smoothed[..n].iter_mut().enumerate() {
        let sum = kernel[0] * float(centre[b]) + kernel[1] * float(minus1[b] + plus1[b]);
        *smoothed = sum + kernel[2] * float(minus2[b] + plus2[b]);
    }
}

/// Computes the saliency of each queried pixel, given as its index, row by row, times 256, plus its own bin.
pub(super) fn centre_surround(bins: &Plane<u8>, contrast: &ContrastParams, queries: &[u32]) -> Vec<f32> {
    let (width, height) = (bins.width(), bins.height());
    let mut saliency = vec![0.0_f32; queries.len()];
    let bin_of = |query: u32| (query & 0xff) as usize;
    let mut is_used = vec![false; contrast.num_bins];
    queries.iter().for_each(|&query| is_used[bin_of(query)] = true);
    let integral = IntegralHistogram::new(bins, contrast.num_bins);
    let mut posterior = Posterior::new(contrast);
    for shape in WindowShape::of_frame(width, height) {
        let across = WindowAxis::new(shape.width, shape.step, width);
        let down = WindowAxis::new(shape.height, shape.step, height);
        // A grid of windows for each bin.
        let size = across.count * down.count;
        let mut windows = vec![0.0; size * contrast.num_bins];
        let mut bin_saliency = vec![0.0; contrast.num_bins];
        for j in 0..down.count {
            for i in 0..across.count {
                posterior.evaluate(&integral, &shape, across.start(i), down.start(j), &mut bin_saliency);
                for (b, &s) in bin_saliency.iter().enumerate() {
                    windows[b * size + j * across.count + i] = s;
                }
            }
        }
        for (grid, _) in windows.chunks_exact_mut(size).zip(&is_used).filter(|(_, is_used)| **is_used) {
            let column_maxima = running_maximum(grid.to_vec(), across.count, down.run_length());
            grid.copy_from_slice(&running_maximum(column_maxima, 1, across.run_length()));
        }
        let columns: Vec<[usize; 2]> = (0..width).map(|x| across.runs(x)).collect();
        let rows: Vec<[usize; 2]> = (0..height).map(|y| down.runs(y).map(|k| k * across.count)).collect();
        for (saliency, &query) in saliency.iter_mut().zip(queries) {
            let grid = &windows[bin_of(query) * size..][..size];
            let pixel = (query >> 8) as usize;
            let (columns, rows) = (columns[pixel % width], rows[pixel / width]);
            for row in rows {
                columns.iter().for_each(|column| *saliency = larger(*saliency, grid[row + column]));
            }
        }
    }
    saliency
}

/// Maximum of each value and the following ones at distances of `stride`, `length` in all (a power of two), by doubling.
fn running_maximum(mut values: Vec<f32>, stride: usize, length: usize) -> Vec<f32> {
    let mut maxima = values.clone();
    let mut run = 1;
    while run < length {
        let shifted = &values[(run * stride).min(values.len())..];
        for (maximum, (&value, &next)) in maxima.iter_mut().zip(values.iter().zip(shifted)) {
            *maximum = larger(value, next);
        }
        values.copy_from_slice(&maxima);
        run *= 2;
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    fn contrast(num_bins: usize) -> ContrastParams {
        ContrastParams { num_bins, prior: 0.2 }
    }

    /// Evaluates each window pixel by pixel.
    fn naive(bins: &Plane<u8>, contrast: &ContrastParams) -> Plane<f32> {
        let (width, height) = (bins.width() as isize, bins.height() as isize);
        let mut map = bins.map(|_| 0.0_f32);
        let pixels = |left: isize, top: isize, w: isize, h: isize| {
            (top.max(0)..(top + h).min(height))
                .flat_map(move |y| (left.max(0)..(left + w).min(width)).map(move |x| (x as usize, y as usize)))
        };
        for shape in WindowShape::of_frame(bins.width(), bins.height()) {
            let (w, h, ring) = (shape.width as isize, shape.height as isize, shape.ring as isize);
            let (step_x, step_y) = (shape.step.min(shape.width), shape.step.min(shape.height));
            for top in (1 - h..height).step_by(step_y) {
                for left in (1 - w..width).step_by(step_x) {
                    let (mut k, mut b) = (vec![0_u32; contrast.num_bins], vec![0_u32; contrast.num_bins]);
                    pixels(left, top, w, h).for_each(|at| k[bins[at] as usize] += 1);
                    pixels(left - ring, top - ring, w + 2 * ring, h + 2 * ring)
                        .for_each(|at| b[bins[at] as usize] += 1);
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
        let sigma = f64::from(SMOOTHING_BINS);
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

    fn centre_surround_map(bins: &Plane<u8>, contrast: &ContrastParams) -> Plane<f32> {
        let queries: Vec<u32> = bins.data().iter().zip(0..).map(|(&bin, pixel)| pixel << 8 | u32::from(bin)).collect();
        Plane::from_vec(bins.width(), bins.height(), centre_surround(bins, contrast, &queries)).unwrap()
    }

    #[test]
    fn the_fast_contrast_equals_the_naive_one() {
        let mut rng = Rng::for_stage(5, "test");
        for (width, height, num_bins) in [(1, 1, 2), (7, 1, 3), (2, 9, 4), (31, 22, 15), (22, 47, 5), (80, 60, 15)] {
            let contrast = contrast(num_bins);
            // A block on noise, so that there is something to find.
            let bins = Plane::from_fn(width, height, |x, y| {
                let on = x > width / 3 && x < width / 2 && y > height / 4;
                if on { num_bins as u8 - 1 } else { rng.below(num_bins) as u8 / 2 }
            });
            let (fast, slow) = (centre_surround_map(&bins, &contrast), naive(&bins, &contrast));
            for (a, b) in fast.data().iter().zip(slow.data()) {
                assert!((a - b).abs() < 1e-4, "{width} x {height}: {a} not {b}");
            }
        }
    }

    #[test]
    fn equal_pixels_have_the_prior() {
        let map = centre_surround_map(&Plane::filled(64, 48, 3), &contrast(15));
        assert!(map.data().iter().all(|s| (s - 0.2).abs() < 1e-5));
    }

    #[test]
    fn a_distinct_block_is_salient_and_its_surroundings_are_not() {
        let bins = Plane::from_fn(80, 60, |x, y| if (30..46).contains(&x) && (20..40).contains(&y) { 9 } else { 0 });
        let map = centre_surround_map(&bins, &contrast(15));
        assert!(map[(38, 30)] > 0.9 && map[(30, 20)] > 0.9, "{}", map[(38, 30)]);
        assert!(map[(5, 5)] < 0.4 && map[(70, 50)] < 0.4, "{} {}", map[(5, 5)], map[(70, 50)]);
    }
}
