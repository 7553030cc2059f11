//! Centre-surround contrast (Rahtu, Kannala, Salo and Heikkilä, "Segmenting salient objects from images and videos",
//! ECCV 2010) of one number a pixel, given as its bin.
//!
//! In: the bin of each pixel, and pixels that are asked for with a bin of their own each. Out: how salient each of these
//! is.
//!
//! 1. A window of [`SHAPES`] at every place of its grid: an inner rectangle K and a ring B around it, both cut at the
//!    frame.
//! 2. The histograms of K and of B, smoothed along the bins, are `p(b | K)` and `p(b | B)`.
//! 3. With the prior `p0`, a pixel of K in bin `b` is salient with `S = p(b|K) p0 / (p(b|K) p0 + p(b|B) (1 − p0))`.
//! 4. A pixel takes the greatest `S` of all windows whose K covers it.
//!
//! Exact, but not by writing windows: `S` depends on the bin alone, so each window is a row of numbers, one a bin,
//! found from integral histograms, and step 4 is a sliding maximum over the windows' grid, bin by bin, looked up for the
//! pixels asked for. The windows that cover a pixel are contiguous along either axis; the greatest of a run comes from
//! two overlapping runs of a power of two, which doubling yields.
//!
//! Windows may exceed the frame, where they are cut, as long as [`LEAST_INNER`] of K and [`LEAST_RING`] of B remain to
//! be compared.

use crate::image::Plane;
use crate::order::larger;

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

    /// Where the two runs begin that make up the places that cover pixel `x`.
    fn runs(&self, x: usize) -> [usize; 2] {
        let (first, last) = self.covering(x);
        [first, (last + 1).saturating_sub(self.run()).max(first)]
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

    /// A rectangle, cut at the frame.
    fn cut(&self, (x, y): (isize, isize), (width, height): (usize, usize)) -> Cut {
        let within = |from: isize, length: usize, side: usize| {
            [from.clamp(0, side as isize) as usize, (from + length as isize).clamp(0, side as isize) as usize]
        };
        Cut { columns: within(x, width, self.size.0), rows: within(y, height, self.size.1) }
    }

    /// Counts each bin's pixels in a rectangle.
    fn count(&self, Cut { columns: [left, right], rows: [top, bottom] }: Cut, counts: &mut [u32]) {
        let [a, b, c, d] = [(left, top), (right, top), (left, bottom), (right, bottom)].map(|(x, y)| self.corner(x, y));
        for (((count, a), b), (c, d)) in counts.iter_mut().zip(a).zip(b).zip(c.iter().zip(d)) {
            *count = (d + a) - (b + c);
        }
    }
}

/// Columns and rows of a rectangle: the first, and the first behind it.
#[derive(Debug, Clone, Copy)]
struct Cut {
    columns: [usize; 2],
    rows: [usize; 2],
}

impl Cut {
    fn area(&self) -> usize {
        (self.columns[1] - self.columns[0]) * (self.rows[1] - self.rows[0])
    }
}

/// Bins that smoothing reaches to either side.
const REACH: usize = 2;

/// The saliency of each bin in a window, step by step.
struct Posterior<'a> {
    contrast: &'a Contrast,
    /// Weights of the smoothing from the middle outwards.
    kernel: [f32; REACH + 1],
    inner: Vec<u32>,
    outer: Vec<u32>,
    /// Counts with the outermost ones again beyond either end.
    padded: Vec<u32>,
    smooth: [Vec<f32>; 2],
}

impl<'a> Posterior<'a> {
    fn new(contrast: &'a Contrast) -> Self {
        let kernel = std::array::from_fn(|k| libm::expf(-0.5 * (k as f32 / SMOOTHING).powi(2)));
        let n = contrast.num_bins;
        let (inner, outer, padded) = (vec![0; n], vec![0; n], vec![0; n + 2 * REACH]);
        Self { contrast, kernel, inner, outer, padded, smooth: [vec![0.0; n], vec![0.0; n]] }
    }

    /// Writes `S` of each bin for the window that begins at `(x, y)`; zero for a window without a ring.
    fn of_window(&mut self, integral: &Integral, shape: &Shape, (x, y): (isize, isize), into: &mut [f32]) {
        let (width, height, ring) = (shape.width, shape.height, shape.ring);
        let inner = integral.cut((x, y), (width, height));
        let whole = (width + 2 * ring, height + 2 * ring);
        let outer = integral.cut((x - ring as isize, y - ring as isize), whole);
        let nominal = whole.0 * whole.1 - width * height;
        let too_little = |part: usize, whole: usize, least: f64| (part as f64) < least * whole as f64;
        let within = inner.area();
        if too_little(within, width * height, LEAST_INNER) || too_little(outer.area() - within, nominal, LEAST_RING) {
            into.fill(0.0);
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
        for (into, (k, b)) in into.iter_mut().zip(self.smooth[0].iter().zip(&self.smooth[1])) {
            let (k, b) = (k * inside, b * outside);
            let s = k / (k + b);
            *into = if k > 0.0 { s } else { 0.0 };
        }
    }
}

/// `counts` smoothed by a kernel; beyond either end the outermost bin goes on.
fn smooth(counts: &[u32], kernel: &[f32; REACH + 1], padded: &mut [u32], into: &mut [f32]) {
    let n = counts.len();
    padded[..REACH].fill(counts[0]);
    padded[REACH..REACH + n].copy_from_slice(counts);
    padded[REACH + n..].fill(counts[n - 1]);
    let from = |k: usize| &padded[k..k + n];
    let [far_left, left, own, right, far_right] = [0, 1, 2, 3, 4].map(from);
    // Counts of a frame fit into signed numbers, which become floats faster.
    let float = |count: u32| count as i32 as f32;
    for (b, into) in into[..n].iter_mut().enumerate() {
        let near = kernel[0] * float(own[b]) + kernel[1] * float(left[b] + right[b]);
        *into = near + kernel[2] * float(far_left[b] + far_right[b]);
    }
}

/// The saliency of what is `asked`: a pixel's number, row by row, and before the lowest eight bits, which are its bin.
pub(super) fn surround(bins: &Plane<u8>, contrast: &Contrast, asked: &[u32]) -> Vec<f32> {
    let (width, height) = (bins.width(), bins.height());
    let mut found = vec![0.0_f32; asked.len()];
    let bin_of = |asked: u32| (asked & 0xff) as usize;
    let mut is_asked = vec![false; contrast.num_bins];
    asked.iter().for_each(|&asked| is_asked[bin_of(asked)] = true);
    let integral = Integral::new(bins, contrast.num_bins);
    let mut posterior = Posterior::new(contrast);
    for shape in Shape::all(width, height) {
        let across = Places::new(shape.width, shape.step, width);
        let down = Places::new(shape.height, shape.step, height);
        let mut windows = evaluate(&integral, &mut posterior, &shape, (&across, &down));
        let size = across.count * down.count;
        for (grid, _) in windows.chunks_exact_mut(size).zip(&is_asked).filter(|(_, asked)| **asked) {
            let runs = doubled(grid.to_vec(), across.count, down.run());
            grid.copy_from_slice(&doubled(runs, 1, across.run()));
        }
        let columns: Vec<[usize; 2]> = (0..width).map(|x| across.runs(x)).collect();
        let rows: Vec<[usize; 2]> = (0..height).map(|y| down.runs(y).map(|k| k * across.count)).collect();
        for (found, &asked) in found.iter_mut().zip(asked) {
            let grid = &windows[bin_of(asked) * size..][..size];
            let pixel = (asked >> 8) as usize;
            let (columns, rows) = (columns[pixel % width], rows[pixel / width]);
            for row in rows {
                columns.iter().for_each(|column| *found = larger(*found, grid[row + column]));
            }
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

/// Each block of `size` values becomes the greatest, place by place, of itself and those after it, `length` blocks in
/// all (a power of two); at the end of those that there are.
fn doubled(mut values: Vec<f32>, size: usize, length: usize) -> Vec<f32> {
    let mut greater = values.clone();
    let mut reach = 1;
    while reach < length {
        let ahead = &values[(reach * size).min(values.len())..];
        for (greater, (&own, &ahead)) in greater.iter_mut().zip(values.iter().zip(ahead)) {
            *greater = larger(own, ahead);
        }
        values.copy_from_slice(&greater);
        reach *= 2;
    }
    values
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
        let asked: Vec<u32> = bins.data().iter().zip(0..).map(|(&bin, pixel)| pixel << 8 | u32::from(bin)).collect();
        Plane::from_vec(bins.width(), bins.height(), surround(bins, contrast, &asked)).unwrap()
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
