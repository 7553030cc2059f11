//! What superpixels look like: colour and texture of each and around it, and its place.

use crate::image::{Frame, Plane, gaussian_blur, lab, sample_bilinear};
use crate::superpixel::Superpixels;

/// Number of features of a superpixel.
pub(super) const NUM_FEATURES: usize = 13;

/// Mean of L, a and b; their standard deviations; ln(1 + mean gradient of L); the gradient, L, a and b around the centroid,
/// and the centroid.
pub(crate) type Features = [f32; NUM_FEATURES];

/// Standard deviations, in pixels, of the blurs around the centroid. Chosen by eye.
const GRADIENT_SIGMA_PX: f32 = 4.0;
const COLOUR_SIGMA_PX: f32 = 6.0;
/// Blurs are computed on planes that are this much smaller, as they keep no finer detail. Chosen by eye.
const REDUCTION: usize = 4;
/// Scale of the gradient of L, which is 0 to 1, in its logarithm: L is 0 to 100 there.
const GRADIENT_SCALE: f32 = 100.0;

/// Computes the features of the superpixels of a frame, which has their size.
pub(crate) fn superpixel_features(frame: &Frame, superpixels: &Superpixels) -> Vec<Features> {
    let width = frame.width();
    let lab = lab(frame);
    let gradient = gradient(&lab[0], width);
    let reduced = |plane: &[f32], sigma: f32| gaussian_blur(&reduce(plane, width), sigma / REDUCTION as f32);
    let around = [
        reduced(&gradient, GRADIENT_SIGMA_PX),
        reduced(&lab[0], COLOUR_SIGMA_PX),
        reduced(&lab[1], COLOUR_SIGMA_PX),
        reduced(&lab[2], COLOUR_SIGMA_PX),
    ];
    let mut sums = vec![Sums::default(); superpixels.count];
    for (y, columns, p) in superpixels.runs().rows() {
        let run = y * width + columns.start..y * width + columns.end;
        let (sum, count) = (&mut sums[p as usize], columns.len() as f32);
        // All sums side by side: each waits for its last addition.
        let (mut values, mut squares, mut gradients) = ([0.0; 3], [0.0; 3], 0.0);
        let [lightness, a, b] = lab.each_ref().map(|plane| &plane[run.clone()]);
        for (((lightness, a), b), gradient) in lightness.iter().zip(a).zip(b).zip(&gradient[run]) {
            for (channel, value) in [lightness, a, b].into_iter().enumerate() {
                values[channel] += value;
                squares[channel] += value * value;
            }
            gradients += gradient;
        }
        for channel in 0..3 {
            sum.values[channel] += values[channel];
            sum.squares[channel] += squares[channel];
        }
        sum.gradient += gradients;
        sum.x += 0.5 * count * (columns.start + columns.end - 1) as f32;
        sum.y += count * y as f32;
        sum.count += count;
    }
    sums.iter().map(|sum| sum.features(&around)).collect()
}

/// Sums over the pixels of a superpixel.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    values: [f32; 3],
    squares: [f32; 3],
    gradient: f32,
    x: f32,
    y: f32,
    count: f32,
}

impl Sums {
    fn features(&self, around: &[Plane<f32>; 4]) -> Features {
        let mean = |sum: f32| sum / self.count.max(1.0);
        let means = self.values.map(mean);
        let deviation = |k: usize| (mean(self.squares[k]) - means[k] * means[k]).max(0.0).sqrt();
        let (x, y) = (mean(self.x), mean(self.y));
        let reduced = |v: f32| (v + 0.5) / REDUCTION as f32 - 0.5;
        let around = around.each_ref().map(|plane| sample_bilinear(plane, reduced(x), reduced(y)));
        let texture = libm::log1pf(GRADIENT_SCALE * mean(self.gradient));
        [
            means[0],
            means[1],
            means[2],
            deviation(0),
            deviation(1),
            deviation(2),
            texture,
            around[0],
            around[1],
            around[2],
            around[3],
            x,
            y,
        ]
    }
}

/// Computes the gradient's magnitude by central differences, borders replicated.
fn gradient(plane: &[f32], width: usize) -> Vec<f32> {
    let height = plane.len() / width;
    let mut magnitudes = Vec::with_capacity(plane.len());
    let mut padded = vec![0.0; width + 2];
    for y in 0..height {
        let [above, row, below] =
            [y.saturating_sub(1), y, (y + 1).min(height - 1)].map(|y| &plane[y * width..][..width]);
        padded[1..=width].copy_from_slice(row);
        (padded[0], padded[width + 1]) = (row[0], row[width - 1]);
        let along = padded.iter().zip(&padded[2..]).map(|(left, right)| 0.5 * (right - left));
        let across = above.iter().zip(below).map(|(above, below)| 0.5 * (below - above));
        magnitudes.extend(along.zip(across).map(|(x, y)| (x * x + y * y).sqrt()));
    }
    magnitudes
}

/// Computes the means of squares of `REDUCTION` pixels.
fn reduce(plane: &[f32], width: usize) -> Plane<f32> {
    let height = plane.len() / width;
    let mut sums = Plane::filled(width.div_ceil(REDUCTION), height.div_ceil(REDUCTION), 0.0);
    for (y, row) in plane.chunks_exact(width).enumerate() {
        let (squares, rest) = row.as_chunks::<REDUCTION>();
        let sums = sums.row_mut(y / REDUCTION);
        sums.iter_mut().zip(squares).for_each(|(sum, pixels)| *sum += pixels.iter().sum::<f32>());
        if !rest.is_empty() {
            sums[squares.len()] += rest.iter().sum::<f32>();
        }
    }
    let size = |k: usize, length: usize| REDUCTION.min(length - REDUCTION * k);
    Plane::from_fn(sums.width(), sums.height(), |x, y| sums[(x, y)] / (size(x, width) * size(y, height)) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    fn noise(width: usize, height: usize) -> Frame {
        let mut rng = Rng::for_stage(2, "noise");
        Frame::from_rgb((0..3 * width * height).map(|_| rng.below(256) as u8).collect(), width, height).unwrap()
    }

    /// Superpixels of 7 x 5 pixels.
    fn blocks(width: usize, height: usize) -> Superpixels {
        let columns = width.div_ceil(7);
        Superpixels::from(&Plane::from_fn(width, height, |x, y| (x / 7 + y / 5 * columns) as u32))
    }

    #[test]
    fn means_and_deviations_equal_naive_sums() {
        let (width, height) = (33, 22);
        let (frame, superpixels) = (noise(width, height), blocks(width, height));
        let (lab, label) = (lab(&frame), superpixels.label());
        for (p, features) in superpixel_features(&frame, &superpixels).iter().enumerate() {
            let pixels: Vec<usize> = (0..width * height).filter(|&i| label.data()[i] == p as u32).collect();
            let mean =
                |value: &dyn Fn(usize) -> f64| pixels.iter().map(|&i| value(i)).sum::<f64>() / pixels.len() as f64;
            for (channel, plane) in lab.iter().enumerate() {
                let expected = mean(&|i| f64::from(plane[i]));
                let deviation = mean(&|i| (f64::from(plane[i]) - expected).powi(2)).sqrt();
                assert!((f64::from(features[channel]) - expected).abs() < 1e-4);
                assert!((f64::from(features[3 + channel]) - deviation).abs() < 1e-3);
            }
            assert!((f64::from(features[11]) - mean(&|i| (i % width) as f64)).abs() < 1e-3);
            assert!((f64::from(features[12]) - mean(&|i| (i / width) as f64)).abs() < 1e-3);
        }
    }

    #[test]
    fn a_flat_picture_has_its_colour_everywhere_and_no_texture() {
        let frame = Frame::from_rgb([90, 140, 30].repeat(40 * 30), 40, 30).unwrap();
        let expected = lab(&frame).map(|plane| plane[0]);
        for features in superpixel_features(&frame, &blocks(40, 30)) {
            for (k, expected) in expected.iter().enumerate() {
                assert!((features[k] - expected).abs() < 1e-4 && (features[8 + k] - expected).abs() < 1e-4);
            }
            assert!(features[3..8].iter().all(|&v| v < 1e-2), "{features:?}");
        }
    }

    #[test]
    fn a_ramp_has_its_slope_and_its_surroundings() {
        // L of grey is not linear in its value: the slope is compared with that of the plane.
        let rgb = (0..64 * 48).flat_map(|i| [(i % 64 * 4) as u8; 3]).collect();
        let frame = Frame::from_rgb(rgb, 64, 48).unwrap();
        let (lightness, superpixels) = (&lab(&frame)[0], blocks(64, 48));
        let columns = 64_usize.div_ceil(7);
        let features = superpixel_features(&frame, &superpixels)[3 * columns + 4];
        let x = features[11] as usize;
        let slope = 0.5 * (lightness[x + 1] - lightness[x - 1]);
        assert!((features[6] - (1.0 + 100.0 * slope).ln()).abs() < 0.1, "{features:?}");
        assert!((features[7] - slope).abs() < 0.2 * slope && (features[8] - lightness[x]).abs() < 0.02, "{features:?}");
    }

    #[test]
    fn pictures_smaller_than_a_block_have_features() {
        for (width, height) in [(1, 1), (1, 9), (5, 2), (4, 4)] {
            let features = superpixel_features(&noise(width, height), &blocks(width, height));
            assert!(features.iter().flatten().all(|v| v.is_finite()));
        }
    }
}
