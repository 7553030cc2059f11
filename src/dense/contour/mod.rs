//! Contours of an image, by changes of its brightness, colour and texture (section 4.1).
//!
//! In: a [`Frame`]. Out: [`BoundaryMap`], a boundary probability Pb for each pixel, and [`Segments`], straight lines
//! fitted to its ridges after thresholding.
//!
//! Pb compares, for each pixel and direction, the histograms of the image on both sides (Martin, Fowlkes and Malik,
//! PAMI 2004; at several scales: Arbelaez et al., PAMI 2011). Nothing is trained.
//!
//! 1. Each channel of Lab becomes 8 soft bins; small patterns of brightness become 9 fixed textons.
//! 2. The bins are blurred at three scales, standard deviation 1.5, 3 and 6 pixels, to local histograms `h_b`. Coarse
//!    scales are computed at half or quarter size (`gradient`).
//! 3. Half-discs a small distance apart have the chi-square distance `n^T J n` along their common normal `n`, up to a
//!    factor, with the tensor `J = sum_b grad h_b grad h_b^T / h_b`. The weighted tensors of all channels are added and
//!    blurred (`gradient`).
//! 4. The strength along each of 8 directions is the mean over the scales of `sqrt(n^T J n)`, averaged along the boundary.
//! 5. The largest strength becomes a probability by a logistic function, less its value at strength 0.
//! 6. The thin map has the maxima across the boundary only (`thin`).
//!
//! Borders are mirrored, so that the frame of the image is no boundary. There is no normalisation by image: a value means
//! the same in every frame of every clip. Only the thresholds of contours fall in images that have hardly any (`min_share`).
//!
//! **Deviations.** The works cited compare half-discs of finite size in each direction, with bins of various sizes and
//! textons that are clusters of the image's filter responses. The tensor needs one pass for all directions, and fixed
//! textons do not change between frames.
//!
//! **Frames of clips** with a side of at least `half_size_min_side` pixels are measured at half size by windows of the same
//! width: brightness is then as coarse as colour, and steps 2 to 5 take less than half of the time. The largest strength and
//! its direction are enlarged before step 6. On 40 images of BSDS500 the best F falls from .69 to .68, and with two pixels
//! of tolerance from .58 to .54; masks do not get worse, as their borders are refined.
//!
//! **Calibration.** The logistic is fitted to 40 images of BSDS500, so that Pb is the probability that a person drew an
//! outline within two pixels (a square of five by five). The best single threshold there is about 0.13.
//!
//! **Cost**: linear in pixels; 27 ms for 480x270 natively, when last measured. It fails on weak contrast and on texture
//! coarser than the windows.

mod fit;
mod gradient;
mod link;
mod thin;

pub use fit::Segments;
pub(crate) use gradient::{mean_along_boundary, oriented_strengths};
use thin::thin;
pub(crate) use thin::{ORIENTATIONS, normals};

use crate::image::{Frame, Plane};
use crate::order::{larger, nth_smallest};

crate::params! {
    /// Boundary probability and contours.
    pub struct ContourParams {
        /// Contours are linked where Pb is above this value.
        pub low_threshold: f32 = 0.03, in 0.0..=1.0, expert;
        /// A contour is kept if its Pb is above this value somewhere.
        pub high_threshold: f32 = 0.08, in 0.0..=1.0;
        /// If fewer pixels than this share of an image exceed the high threshold, as in fog, both thresholds fall until as many do, at
        /// most to an eighth. Not in the paper.
        pub min_share: f32 = 0.01, in 0.0..=1.0, expert;
        /// Contours of fewer pixels with a free end are left out.
        pub min_length: u32 = 8, in 1..=10000, expert;
        /// Largest distance of a line from its contour, in pixels. Higher gives fewer lines.
        pub max_deviation: f32 = 1.5, in 0.1..=20.0, expert;
        /// Longer lines are split, in pixels, so that edges across a gap can begin in their middle; 0 keeps them.
        pub max_line_length: f32 = 0.0, in 0.0..=10000.0, expert;
        /// Least longer side, in pixels, from which Pb of a clip's frames is measured at half size, in less than half of
        /// the time; smaller frames and single images are measured at full size.
        pub half_size_min_side: u32 = 400, in 1..=65536, expert;
    }
}

/// Least factor on the thresholds of an image of little contrast. Chosen by eye.
const MIN_THRESHOLD_FACTOR: f32 = 0.125;

/// Boundary probability of each pixel.
///
/// Law: both planes have the size of the image; `0 <= thin <= pb <= 1`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BoundaryMap {
    /// Boundary probability, the largest over all orientations.
    pub pb: Plane<f32>,
    /// Boundary probability on ridges one pixel wide, 0 elsewhere.
    pub thin: Plane<f32>,
}

/// Computes Pb of `frame`.
///
/// # Examples
/// A bright block on a dark ground, each digit 12 by 12 pixels.
///
/// ```
/// use tracecut::contour::boundary_map;
/// use tracecut::image::Frame;
///
/// let rows = ["1111111", "1111111", "1198811", "1198811", "1111111"];
/// let grey = |x: usize, y: usize| 25 * (rows[y / 12].as_bytes()[x / 12] - b'0');
/// let rgb = (0..60).flat_map(|y| (0..84).flat_map(move |x| [grey(x, y); 3])).collect();
/// let map = boundary_map(&Frame::from_rgb(rgb, 84, 60)?);
/// let across: Vec<usize> = (0..84).filter(|&x| map.thin[(x, 36)] > 0.3).collect();
/// assert!(across.iter().any(|x| x.abs_diff(24) <= 1) && across.iter().any(|x| x.abs_diff(60) <= 1), "{across:?}");
/// assert!(map.pb[(6, 6)] < 0.1);
/// # Ok::<(), tracecut::Error>(())
/// ```
#[must_use]
pub fn boundary_map(frame: &Frame) -> BoundaryMap {
    boundaries_from_strengths(&oriented_strengths(frame), (frame.width(), frame.height()), PB_LOGISTIC)
}

/// Computes Pb of a frame of a clip.
pub(crate) fn frame_boundaries(frame: &Frame, params: &ContourParams) -> BoundaryMap {
    let (strength, ridges) = frame_strengths(frame, params);
    to_boundaries(&strength, &ridges, PB_LOGISTIC)
}

/// Computes the thin map of a frame of a clip, with fewer probabilities than [`frame_boundaries`].
pub(crate) fn frame_ridges(frame: &Frame, params: &ContourParams) -> Plane<f32> {
    to_thin_map(&frame_strengths(frame, params).1, &LogisticTable::new(PB_LOGISTIC))
}

/// Largest strength of a frame of a clip, and its ridges. Large frames are measured at half size, and thinned at full size.
fn frame_strengths(frame: &Frame, params: &ContourParams) -> (Plane<f32>, Plane<f32>) {
    let (w, h) = (frame.width(), frame.height());
    if w.max(h) < params.half_size_min_side as usize {
        return strongest_ridges(&oriented_strengths(frame), (w, h));
    }
    let small = frame.halved();
    let strengths = gradient::half_size_oriented_strengths(&small);
    let (small, orientation) = largest_strength(&strengths, (small.width(), small.height()));
    let mut strength = Plane::filled(w, h, 0.0);
    gradient::add_doubled(small.data(), strength.data_mut(), w);
    let orientation = Plane::from_fn(w, h, |x, y| orientation[(x / 2, y / 2)]);
    let ridges = thin(&strength, &orientation);
    (strength, ridges)
}

/// Width and height, in pixels.
type Size = (usize, usize);

/// Computes Pb from the strength along each direction, planes of `size`.
pub(crate) fn boundaries_from_strengths(
    strengths: &[Vec<f32>; ORIENTATIONS],
    size: Size,
    logistic: Logistic,
) -> BoundaryMap {
    let (strength, ridges) = strongest_ridges(strengths, size);
    to_boundaries(&strength, &ridges, logistic)
}

fn to_boundaries(strength: &Plane<f32>, ridges: &Plane<f32>, logistic: Logistic) -> BoundaryMap {
    let table = LogisticTable::new(logistic);
    BoundaryMap { pb: strength.map(|s| table.probability(s)), thin: to_thin_map(ridges, &table) }
}

fn to_thin_map(ridges: &Plane<f32>, table: &LogisticTable) -> Plane<f32> {
    ridges.map(|s| if s > 0.0 { table.probability(s) } else { 0.0 })
}

/// Returns the largest strength over all directions, and its ridges.
pub(crate) fn strongest_ridges(strengths: &[Vec<f32>; ORIENTATIONS], size: Size) -> (Plane<f32>, Plane<f32>) {
    let (strength, orientation) = largest_strength(strengths, size);
    let ridges = thin(&strength, &orientation);
    (strength, ridges)
}

/// Returns the largest strength over all directions, and its direction.
fn largest_strength(strengths: &[Vec<f32>; ORIENTATIONS], size: Size) -> (Plane<f32>, Plane<u8>) {
    let mut strength = Plane::filled(size.0, size.1, 0.0_f32);
    let mut orientation = Plane::filled(size.0, size.1, 0_u8);
    for (k, plane) in strengths.iter().enumerate() {
        for ((best, o), &v) in strength.data_mut().iter_mut().zip(orientation.data_mut()).zip(plane) {
            *o = if v > *best { k as u8 } else { *o };
            *best = larger(v, *best);
        }
    }
    (strength, orientation)
}

/// Logistic function from strengths to probabilities.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Logistic {
    pub(crate) slope: f32,
    /// Strength at which it is one half.
    pub(crate) centre: f32,
}

impl Logistic {
    fn at(self, strength: f32) -> f32 {
        1.0 / (1.0 + libm::expf(-self.slope * (strength - self.centre)))
    }
}

/// A logistic function less its value at 0, by linear interpolation in a table: the error is at most 1e-5.
struct LogisticTable {
    values: Vec<f32>,
    steps_per_unit: f32,
}

impl LogisticTable {
    /// Intervals of the table.
    const STEPS: usize = 1024;

    fn new(logistic: Logistic) -> Self {
        let at_zero = logistic.at(0.0);
        // At the end, the function is within 1e-5 of one.
        let end = logistic.centre + 12.0 / logistic.slope;
        let value = |k: usize| (logistic.at(k as f32 * end / Self::STEPS as f32) - at_zero).clamp(0.0, 1.0);
        Self { values: (0..=Self::STEPS).map(value).collect(), steps_per_unit: Self::STEPS as f32 / end }
    }

    fn probability(&self, strength: f32) -> f32 {
        let position = strength * self.steps_per_unit;
        let index = (position as usize).min(Self::STEPS - 1);
        let (low, high) = (self.values[index], self.values[index + 1]);
        let fraction = position - index as f32;
        low + if fraction < 1.0 { fraction } else { 1.0 } * (high - low)
    }
}

/// Logistic of Pb, fitted to 40 images of BSDS500 (see above).
pub(crate) const PB_LOGISTIC: Logistic = Logistic { slope: 7.05, centre: 0.77 };

/// Fits line segments to the contours of `map`.
///
/// # Examples
/// The block in [`boundary_map`]'s example.
///
/// ```
/// # use tracecut::contour::boundary_map;
/// # use tracecut::image::Frame;
/// #
/// # let rows = ["1111111", "1111111", "1198811", "1198811", "1111111"];
/// # let grey = |x: usize, y: usize| 25 * (rows[y / 12].as_bytes()[x / 12] - b'0');
/// # let rgb = (0..60).flat_map(|y| (0..84).flat_map(move |x| [grey(x, y); 3])).collect();
/// # let map = boundary_map(&Frame::from_rgb(rgb, 84, 60)?);
/// use tracecut::contour::{ContourParams, contour_segments};
///
/// let segments = contour_segments(&map, &ContourParams::default());
/// assert!(!segments.lines.is_empty());
/// # Ok::<(), tracecut::Error>(())
/// ```
#[doc(hidden)] // For benchmarks and tests.
#[must_use]
pub fn contour_segments(map: &BoundaryMap, params: &ContourParams) -> Segments {
    ridge_segments(&map.thin, params)
}

/// Same as [`contour_segments`], from a thin map.
pub(crate) fn ridge_segments(thin: &Plane<f32>, params: &ContourParams) -> Segments {
    let factor = threshold_factor(thin, params);
    let [low, high] = [params.low_threshold, params.high_threshold].map(|threshold| factor * threshold);
    let chains = link::link(thin, low, high, params.min_length as usize);
    fit::fit(&chains, params.max_deviation, params.max_line_length)
}

/// Returns the factor on both thresholds that leaves enough pixels of a thin map above the high one, at most 1.
fn threshold_factor(thin: &Plane<f32>, params: &ContourParams) -> f32 {
    let pixels = thin.data();
    let num_above = (params.min_share * pixels.len() as f32) as usize;
    if num_above == 0 || params.high_threshold == 0.0 {
        return 1.0;
    }
    (nth_smallest(pixels, pixels.len() - num_above) / params.high_threshold).clamp(MIN_THRESHOLD_FACTOR, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    fn frame(w: usize, h: usize, mut color: impl FnMut(usize, usize) -> [u8; 3]) -> Frame {
        let rgb = (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).flat_map(|(x, y)| color(x, y)).collect();
        Frame::from_rgb(rgb, w, h).unwrap()
    }

    /// Rectangles of random colours, and noise.
    fn clutter(w: usize, h: usize, seed: u64) -> Frame {
        let mut rng = Rng::for_stage(seed, "clutter");
        let mut byte = move || rng.below(256) as u8;
        let boxes: Vec<([usize; 4], [u8; 3])> = (0..12)
            .map(|_| {
                let [x, y, dx, dy] = [w, h, w, h].map(|n| usize::from(byte()) * n / 256);
                ([x, y, x + dx, y + dy], [byte(), byte(), byte()])
            })
            .collect();
        frame(w, h, |x, y| {
            let inside = |b: &[usize; 4]| (b[0]..=b[2]).contains(&x) && (b[1]..=b[3]).contains(&y);
            let color = boxes.iter().rev().find(|(b, _)| inside(b)).map_or([90; 3], |&(_, color)| color);
            color.map(|v| v / 16 * 15 + byte() / 16)
        })
    }

    fn map_of(frame: &Frame) -> BoundaryMap {
        boundary_map(frame)
    }

    #[test]
    fn values_are_probabilities_and_thin_keeps_them_or_nothing() {
        for seed in 0..4 {
            let map = map_of(&clutter(61, 47, seed));
            let mut num_kept = 0;
            for (&pb, &thin) in map.pb.data().iter().zip(map.thin.data()) {
                assert!((0.0..=1.0).contains(&pb), "pb {pb}");
                assert!(thin == 0.0 || thin == pb, "thin {thin}, pb {pb}");
                num_kept += usize::from(thin > 0.1);
            }
            assert!(num_kept > 30, "{num_kept} pixels on ridges");
        }
    }

    #[test]
    fn a_flat_image_has_no_boundary_not_even_at_its_frame() {
        for (w, h) in [(40, 31), (1, 1), (1, 9), (7, 1), (2, 2), (3, 3)] {
            for color in [[0; 3], [255; 3], [200, 30, 90]] {
                let map = map_of(&frame(w, h, |_, _| color));
                assert_eq!((map.pb.width(), map.pb.height()), (w, h));
                assert!(map.pb.data().iter().chain(map.thin.data()).all(|v| v.abs() < 1e-6), "{w}x{h} {color:?}");
            }
        }
    }

    #[test]
    fn images_of_any_small_size_give_probabilities() {
        for (w, h) in [(1, 1), (1, 2), (2, 1), (1, 40), (40, 1), (2, 2), (3, 5), (5, 4)] {
            let map = map_of(&clutter(w, h, 3));
            assert!(map.pb.data().iter().all(|v| (0.0..=1.0).contains(v)), "{w}x{h}");
        }
    }

    #[test]
    fn a_step_gives_a_strong_line_beside_it_from_frame_to_frame() {
        let (w, h) = (64, 48);
        for (slope_x, slope_y) in [(1.0_f32, 0.0_f32), (0.0, 1.0), (0.707, 0.707), (0.6, -0.8)] {
            let side = |x: usize, y: usize| slope_x * (x as f32 - 31.5) + slope_y * (y as f32 - 23.5);
            let map = map_of(&frame(w, h, |x, y| if side(x, y) < 0.0 { [60, 70, 60] } else { [190, 150, 120] }));
            let mut on_line = 0;
            for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
                let thin = map.thin[(x, y)];
                let distance = side(x, y).abs();
                // Mirroring bends a slanting step where it meets the frame.
                let inside = (6..w - 6).contains(&x) && (6..h - 6).contains(&y);
                assert!(!inside || thin < 0.05 || distance <= 1.2, "{thin} at {x}, {y}, {distance} from the step");
                on_line += usize::from(thin > 0.4);
            }
            assert!((h - 4..=2 * w).contains(&on_line), "{on_line} pixels on the step ({slope_x}, {slope_y})");
        }
    }

    #[test]
    fn thresholds_fall_in_fog_and_not_elsewhere() {
        let params = ContourParams::default();
        // Bars, each darker than the last.
        let bars = |x: usize, part: u8| u8::from(x % 20 < 10) * (part + (x / 20) as u8);
        let (clear, foggy) = (clutter(61, 47, 2), |part: u8| frame(61, 47, |x, _| [100 + bars(x, part); 3]));
        assert_eq!(threshold_factor(&map_of(&clear).thin, &params), 1.0);
        let factors = [40, 12, 8].map(|part| threshold_factor(&map_of(&foggy(part)).thin, &params));
        assert!(factors[0] == 1.0 && factors.is_sorted_by(|a, b| a > b), "{factors:?}");
        let segments = |min_share| contour_segments(&map_of(&foggy(8)), &ContourParams { min_share, ..params.clone() });
        let num_lines = [0.0, 0.04].map(|share| segments(share).lines.len());
        assert!(num_lines[0] < num_lines[1], "{num_lines:?} {factors:?}");
    }

    #[test]
    fn a_step_of_colour_alone_or_texture_alone_is_seen() {
        let color = map_of(&frame(64, 48, |x, _| if x < 32 { [150, 110, 110] } else { [95, 133, 110] }));
        let texture = map_of(&frame(64, 48, |x, y| {
            let bright = if x < 32 { x % 6 < 3 } else { y % 6 < 3 };
            [if bright { 150 } else { 100 }; 3]
        }));
        for (name, map) in [("colour", color), ("texture", texture)] {
            let (middle, side) = (map.pb[(31, 24)].max(map.pb[(32, 24)]), map.pb[(14, 24)]);
            assert!(middle > 0.03 && middle > 2.0 * side, "{name}: {middle} at the step, {side} beside it");
        }
    }

    #[test]
    fn mirrored_and_transposed_images_give_mirrored_and_transposed_maps() {
        // Sides divisible by four, as halving starts at the top left.
        let (w, h) = (48, 40);
        let image = clutter(w, h, 9);
        let at = |x: usize, y: usize| {
            let i = 3 * (y * w + x);
            [image.rgb()[i], image.rgb()[i + 1], image.rgb()[i + 2]]
        };
        let map = map_of(&image);
        let mirrored = map_of(&frame(w, h, |x, y| at(w - 1 - x, y)));
        let transposed = map_of(&frame(h, w, |x, y| at(y, x)));
        for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
            let pb = map.pb[(x, y)];
            let transformed = [mirrored.pb[(w - 1 - x, y)], transposed.pb[(y, x)]];
            assert!(transformed.iter().all(|o| (o - pb).abs() < 1e-3), "{pb} and {transformed:?} at {x}, {y}");
        }
    }
}
