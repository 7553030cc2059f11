//! Appearance of objects and background, learned from one cut for the next.
//!
//! In: the superpixels of a clip, what they look like, and the labels of a cut. Out: log-odds of object against background of
//! each superpixel. Extremely randomized trees (`forest`) learn the labels of superpixels near objects, and of some far from
//! them, from colour, texture, surroundings and place (`features`); labels that the cut was sure of and large superpixels
//! count more. Cuts and models that learn from each other are GrabCut (Rother, Kolmogorov and Blake, 2004), there with
//! mixtures of colours. Not in the paper. Cost: O(pixels) for the features, O(superpixels) for
//! the trees. It fails where objects look like their surroundings, and where the first cut is mostly wrong.

use super::forest::{Forest, Sample};
use super::terms::margins;
use super::{CutInput, CutLabels, CutParams};
use crate::image::{Frame, Plane, gaussian_blur, lab, sample_bilinear};
use crate::rng::Rng;
use crate::superpixel::Superpixels;
use std::ops::Range;

/// Reach of the background near an object, in columns and rows, as a part of the frame's longer side. Chosen by eye.
const NEAR_SIDE_SHARE: f32 = 0.25;
/// Share of the farther superpixels that are learned from. Chosen by eye.
const FAR_SHARE: f64 = 0.15;
/// Most samples of each class, for the time that the trees take. Twice as many score no better (docs/speed.md).
const MAX_CLASS_SAMPLES: usize = 1500;
/// Least factor of a sample's weight, of a superpixel that could as well have another label. Chosen by eye.
const MIN_CERTAINTY: f32 = 0.15;
/// Bound of the log-odds. Chosen by eye.
const MAX_LOG_ODDS: f32 = 2.5;

/// Computes the log-odds of object against background by appearance for each superpixel, frame by frame, learned from the
/// labels of a cut: [`CutInput::appearance`] of the next one.
///
/// `input`, `params` and `cut` are the input, the parameters and the labels of that cut, `frames` its pictures. Empty if a
/// picture is missing or has another size than its superpixels; zeros if no label, or every one, is an object's.
#[must_use]
pub fn appearance_log_odds(
    input: &CutInput,
    params: &CutParams,
    cut: &CutLabels,
    frames: &[Frame],
    seed: u32,
) -> Vec<f32> {
    let mut features = ClipFeatures::default();
    for (t, superpixels) in input.superpixels.iter().enumerate() {
        let has_size = |frame: &&Frame| (frame.width(), frame.height()) == superpixels.runs().size();
        let Some(frame) = frames.get(t).filter(has_size) else { return Vec::new() };
        features.add_frame(superpixel_features(frame, superpixels), superpixels);
    }
    let margins = margins(input, params, cut, &label_kinds(input));
    features.log_odds(input, cut, &margins, seed)
}

/// Features of the superpixels of a clip, frame by frame.
#[derive(Debug, Clone, Default)]
pub(crate) struct ClipFeatures {
    features: Vec<Features>,
    areas: Vec<f32>,
}

impl ClipFeatures {
    /// Adds the features of the next frame's superpixels.
    pub(crate) fn add_frame(&mut self, features: Vec<Features>, superpixels: &Superpixels) {
        self.features.extend(features);
        self.areas.extend(superpixels.areas().into_iter().map(|area| area as f32));
    }

    /// As [`appearance_log_odds`], with the margins of the cut between objects and background.
    pub(crate) fn log_odds(&self, input: &CutInput, cut: &CutLabels, margins: &[f32], seed: u32) -> Vec<f32> {
        let mut rng = Rng::for_stage(seed.into(), "appearance");
        let samples = self.samples(input, cut, margins, &mut rng);
        let Some(samples) = samples else { return vec![0.0; self.features.len()] };
        let forest = Forest::grow(&samples, &mut rng);
        // A p of 0 or 1 gives an infinity, which the bound takes.
        let log_odds = |p: f32| libm::logf(p / (1.0 - p)).clamp(-MAX_LOG_ODDS, MAX_LOG_ODDS);
        forest.probabilities(&self.features).into_iter().map(log_odds).collect()
    }

    /// Draws the samples to learn from, of which each class has the same weight; `None` if a class has none.
    fn samples(&self, input: &CutInput, cut: &CutLabels, margins: &[f32], rng: &mut Rng) -> Option<Vec<Sample>> {
        let is_object = |label: &u32| input.objects.get(*label as usize) == Some(&true);
        let (mut background, mut objects, mut first) = (Vec::new(), Vec::new(), 0);
        for (superpixels, labels) in input.superpixels.iter().zip(&cut.labels) {
            let is_object: Vec<bool> = labels.iter().map(is_object).collect();
            for (k, &is_near) in near_objects(superpixels, &is_object).iter().enumerate() {
                if is_near || rng.uniform() < FAR_SHARE {
                    if is_object[k] { &mut objects } else { &mut background }.push(first + k);
                }
            }
            first += superpixels.count;
        }
        let mut samples = Vec::new();
        for (is_object, mut nodes) in [(false, background), (true, objects)] {
            draw(&mut nodes, MAX_CLASS_SAMPLES, rng);
            let weight = |node: usize| self.areas[node].sqrt() * (MIN_CERTAINTY + margins[node].max(0.0)).min(1.0);
            let total: f32 = nodes.iter().map(|&node| weight(node)).sum();
            let sample =
                |&node: &usize| Sample { features: self.features[node], is_object, weight: weight(node) / total };
            samples.extend(nodes.iter().map(sample));
        }
        let has_both = samples.iter().any(|sample| sample.is_object) && samples.iter().any(|sample| !sample.is_object);
        has_both.then_some(samples)
    }
}

/// Returns 1 for each label that is an object's, 0 for the others.
pub(crate) fn label_kinds(input: &CutInput) -> Vec<u8> {
    (0..input.num_labels).map(|label| u8::from(input.objects.get(label) == Some(&true))).collect()
}

/// Keeps `count` of the values, drawn at random.
fn draw(values: &mut Vec<usize>, count: usize, rng: &mut Rng) {
    for k in 0..values.len().min(count) {
        let drawn = k + rng.below(values.len() - k);
        values.swap(k, drawn);
    }
    values.truncate(count);
}

/// Marks superpixels that have a pixel near an object, by a dilation of the objects' pixels with one bit a pixel.
fn near_objects(superpixels: &Superpixels, is_object: &[bool]) -> Vec<bool> {
    let (w, h) = superpixels.runs().size();
    let radius = (NEAR_SIDE_SHARE * w.max(h) as f32) as usize;
    let row_words = w.div_ceil(64);
    let mut dilated = vec![0_u64; row_words * h];
    for (y, columns, _) in superpixels.runs().rows().filter(|&(.., s)| is_object[s as usize]) {
        let row = &mut dilated[y * row_words..];
        words_of(columns).for_each(|(word, bits)| row[word] |= bits);
    }
    dilated.chunks_exact_mut(row_words).for_each(|row| dilate(row, radius, 1));
    dilate(&mut dilated, radius, 64 * row_words);
    let mut is_near = vec![false; superpixels.count];
    for (y, columns, s) in superpixels.runs().rows() {
        let is_near = &mut is_near[s as usize];
        if !*is_near {
            let row = &dilated[y * row_words..];
            *is_near = words_of(columns).any(|(word, bits)| row[word] & bits != 0);
        }
    }
    is_near
}

/// Returns the words of a row that have some of these bits, each with these bits.
fn words_of(columns: Range<usize>) -> impl Iterator<Item = (usize, u64)> {
    (columns.start / 64..columns.end.div_ceil(64)).map(move |word| {
        let first = columns.start.max(64 * word) - 64 * word;
        let end = columns.end.min(64 * word + 64) - 64 * word;
        (word, (u64::MAX << first) & (u64::MAX >> (64 - end)))
    })
}

/// Sets all bits within `radius` times `stride` of a set bit, by shifts that double.
fn dilate(bits: &mut [u64], radius: usize, stride: usize) {
    let mut reached = 0;
    while reached < radius {
        let step = (reached + 1).min(radius - reached);
        spread(bits, step * stride);
        reached += step;
    }
}

/// Sets the bits `distance` before and after each set bit.
fn spread(bits: &mut [u64], distance: usize) {
    let (skip, shift) = (distance / 64, distance % 64);
    for k in (skip..bits.len()).rev() {
        let carry = if shift > 0 && k > skip { bits[k - skip - 1] >> (64 - shift) } else { 0 };
        bits[k] |= bits[k - skip] << shift | carry;
    }
    for k in 0..bits.len().saturating_sub(skip) {
        let carry = if shift > 0 && k + skip + 1 < bits.len() { bits[k + skip + 1] << (64 - shift) } else { 0 };
        bits[k] |= bits[k + skip] >> shift | carry;
    }
}

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
    use crate::image::Plane;
    use crate::rng::Rng;
    use crate::trajectory::Trajectories;

    const SIZE: (usize, usize) = (160, 96);

    /// A frame of noise in two colours, an object of 6 x 6 superpixels on the background, and its superpixels of 8 x 8.
    fn scene(seed: u64) -> (Frame, Superpixels, Vec<bool>) {
        let mut rng = Rng::for_stage(seed, "scene");
        let is_object = |x: usize, y: usize| (7..13).contains(&(x / 8)) && (3..9).contains(&(y / 8));
        let mut rgb = Vec::new();
        for i in 0..SIZE.0 * SIZE.1 {
            let colour = if is_object(i % SIZE.0, i / SIZE.0) { [170, 80, 60] } else { [90, 120, 100] };
            rgb.extend(colour.map(|v| (v + rng.below(60)) as u8));
        }
        let superpixels = Superpixels::from(&Plane::from_fn(SIZE.0, SIZE.1, |x, y| (x / 8 + y / 8 * 20) as u32));
        let truth = (0..240).map(|p| is_object(p % 20 * 8, p / 20 * 8)).collect();
        (Frame::from_rgb(rgb, SIZE.0, SIZE.1).unwrap(), superpixels, truth)
    }

    /// Log-odds from a cut with these labels, of which 1 is an object.
    fn log_odds(frames: &[Frame], superpixels: &[Superpixels], labels: Vec<Vec<u32>>) -> Vec<f32> {
        let tracks = Trajectories::empty(superpixels.len(), SIZE);
        let objects = &[false, true];
        let input = CutInput {
            superpixels,
            tracks: &tracks,
            label: &[],
            num_labels: 2,
            objects,
            evidence: &[],
            appearance: &[],
        };
        appearance_log_odds(&input, &CutParams::default(), &CutLabels { labels }, frames, 3)
    }

    #[test]
    fn superpixels_that_the_cut_got_wrong_are_told_by_those_like_them() {
        let (frames, superpixels, truth) = ([scene(1).0, scene(2).0], vec![scene(1).1; 2], scene(1).2);
        // A third of the object was cut as background, and as much of the background as object.
        let wrong = |p: usize| (truth[p] && p.is_multiple_of(3)) || (!truth[p] && p.is_multiple_of(17));
        let labels: Vec<u32> = (0..240).map(|p| u32::from(truth[p] != wrong(p))).collect();
        let log_odds = log_odds(&frames, &superpixels, vec![labels; 2]);
        let is_right = |(p, &odds): (usize, &f32)| (odds > 0.0) == truth[p % 240];
        let right = log_odds.iter().enumerate().filter(|&(p, odds)| is_right((p, odds))).count();
        assert!(right >= 470, "{right} of 480");
        assert!(log_odds.iter().all(|odds| odds.abs() <= MAX_LOG_ODDS));
    }

    #[test]
    fn without_objects_or_background_the_log_odds_are_zero_and_without_frames_there_are_none() {
        let (frame, superpixels, _) = scene(1);
        let (frames, superpixels) = ([frame], [superpixels]);
        for label in [0, 1] {
            assert_eq!(log_odds(&frames, &superpixels, vec![vec![label; 240]]), [0.0; 240]);
        }
        let small = Frame::from_rgb(vec![0; 12], 2, 2).unwrap();
        for frames in [&[][..], &[small]] {
            assert!(log_odds(frames, &superpixels, vec![vec![1; 240]]).is_empty());
        }
    }

    #[test]
    fn draws_are_distinct_and_all_are_drawn_of_few() {
        let mut rng = Rng::for_stage(1, "draw");
        let mut values: Vec<usize> = (0..50).collect();
        draw(&mut values, 20, &mut rng);
        values.sort_unstable();
        values.dedup();
        assert_eq!(values.len(), 20);
        draw(&mut values, 30, &mut rng);
        assert_eq!(values.len(), 20);
    }

    #[test]
    fn near_objects_equals_a_naive_search() {
        let mut rng = crate::rng::Rng::for_stage(3, "near");
        for _ in 0..20 {
            let label = Plane::from_fn(40, 30, |x, y| (x / 4 + y / 3 * 10) as u32);
            let superpixels = Superpixels::from(&label);
            let object: Vec<bool> = (0..100).map(|_| rng.below(60) == 0).collect();
            let is_marked = near_objects(&superpixels, &object);
            let places = || (0..40 * 30).map(|i| (i % 40, i / 40));
            for s in 0..100_u32 {
                let is_inside = |&(x, y): &(usize, usize)| label[(x, y)] == s;
                let of_object = |&(x, y): &(usize, usize)| object[label[(x, y)] as usize];
                let is_near = places()
                    .filter(is_inside)
                    .any(|(x, y)| places().filter(of_object).any(|(a, b)| x.abs_diff(a) <= 10 && y.abs_diff(b) <= 10));
                assert_eq!(is_marked[s as usize], is_near);
            }
        }
    }

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
