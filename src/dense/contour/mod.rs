//! Contours of one image: where its brightness, colour and texture change (section 4.1).
//!
//! In: a [`Frame`]. Out: [`BoundaryMap`], a boundary probability Pb for each pixel, and [`Segments`], straight pieces
//! fitted to what is left of it after thinning and thresholding.
//!
//! Pb asks, for each pixel and direction, how much the histograms of the image on one side differ from those on the
//! other (Martin, Fowlkes and Malik, PAMI 2004; at several scales: Arbelaez et al., PAMI 2011). Nothing is trained.
//!
//! 1. Each channel of Lab becomes 8 soft bins; small patterns of brightness become 9 fixed textons.
//! 2. The bins are blurred at three scales, standard deviation 1.5, 3 and 6 pixels: `h_b` is then the local histogram.
//!    What is coarse is computed at half or quarter size (`gradient`).
//! 3. Half-discs a small way apart have the chi-square distance `n^T J n` along their common normal `n`, up to a
//!    factor, with the tensor `J = sum_b grad h_b grad h_b^T / h_b`. Tensors of all channels are added by weight and
//!    blurred (`gradient`).
//! 4. The strength along each of 8 directions is the mean over the scales of `sqrt(n^T J n)`, and then a mean along the
//!    boundary.
//! 5. The strongest direction counts. A logistic function makes it a probability, minus what it gives where nothing
//!    changes.
//! 6. Pixels that are not the largest across the boundary are left out of the thin map (`thin`).
//!
//! Borders are mirrored, so the frame of the image is no boundary. There is no normalisation by image: a value means
//! the same in every frame of every clip.
//!
//! **Deviations.** The works cited measure half-discs of finite size for each direction, with bins of their own sizes,
//! and textons that are clusters of filter responses of the image. The tensor needs one pass for all directions, and
//! fixed textons do not jump between frames.
//!
//! **Frames of clips** with a side of at least `half_size_min_side` pixels are measured at half size by windows of the same width:
//! brightness is then as coarse as colour, and steps 2 to 5 take less than half of the time. The strongest and its
//! direction are enlarged before step 6. Of 40 images of BSDS500 the best F falls from .69 to .68, and with two pixels
//! of tolerance from .58 to .54; masks do not get worse, as their borders are refined.
//!
//! **Calibration.** The logistic's two numbers are fitted to 40 images of BSDS500 such that Pb is the probability that
//! a person drew an outline within two pixels (a square of five by five). The best single threshold there is about
//! 0.13.
//!
//! **Cost**: linear in pixels; 27 ms for 480x270 natively, where it was measured last.

mod fit;
mod gradient;
mod link;
#[cfg(test)]
mod tests;
mod thin;

pub use fit::Segments;
pub(crate) use gradient::mean_along;
#[doc(hidden)]
pub use thin::{ORIENTATIONS, normals, thin};

use crate::image::{Frame, Plane};
use crate::order::larger;

crate::params! {
    /// Boundary probability and contours.
    pub struct ContourParams {
        /// Contours are followed where Pb is above this value.
        pub low_threshold: f32 = 0.03, in 0.0..=1.0, expert;
        /// A contour is kept if its Pb is above this value somewhere.
        pub high_threshold: f32 = 0.08, in 0.0..=1.0;
        /// Contours of fewer pixels that end in nothing are left out.
        pub min_length: u32 = 8, in 1..=10000, expert;
        /// How far a line may be from the contour that it stands for, in pixels. Higher gives fewer lines.
        pub max_deviation: f32 = 1.5, in 0.1..=20.0, expert;
        /// Longer lines are broken, in pixels, so that edges that bridge a gap can begin in their middle; 0 leaves them
        /// whole.
        pub max_line_length: f32 = 0.0, in 0.0..=10000.0, expert;
        /// Pb of a clip's frames with a side of so many pixels is measured at half size, in less than half of the time;
        /// in smaller frames, where things are small, and in single images at full size.
        pub half_size_min_side: u32 = 400, in 1..=65536, expert;
    }
}

/// How likely each pixel lies on a boundary between two things.
///
/// Law: both planes have the size of the image; `0 <= thin <= pb <= 1`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BoundaryMap {
    /// Boundary probability, the largest over all orientations.
    pub pb: Plane<f32>,
    /// The same on ridges one pixel wide, 0 elsewhere.
    pub thin: Plane<f32>,
}

/// Pb of `frame`.
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
    let strengths = strengths_of(frame);
    from_strengths(&strengths, (frame.width(), frame.height()), OF_PB)
}

/// Pb of a frame of a clip.
pub(crate) fn frame_boundaries(frame: &Frame, params: &ContourParams) -> BoundaryMap {
    let (strength, ridges) = frame_strengths(frame, params);
    probabilities(&strength, &ridges, OF_PB)
}

/// The thin map alone: it takes fewer probabilities.
pub(crate) fn frame_ridges(frame: &Frame, params: &ContourParams) -> Plane<f32> {
    on_ridges(&frame_strengths(frame, params).1, &Probability::new(OF_PB))
}

/// The largest strength of a frame of a clip, and the same on ridges. In large frames strengths are measured at half
/// size; the strongest is enlarged, and thinned at full size.
fn frame_strengths(frame: &Frame, params: &ContourParams) -> (Plane<f32>, Plane<f32>) {
    let (w, h) = (frame.width(), frame.height());
    if w.max(h) < params.half_size_min_side as usize {
        return strongest(&strengths_of(frame), (w, h));
    }
    let small = frame.halved();
    let (small, orientation) = largest(&gradient::oriented_strength_of_half(&small), (small.width(), small.height()));
    let mut strength = Plane::filled(w, h, 0.0);
    gradient::add_doubled(small.data(), strength.data_mut(), w);
    let orientation = Plane::from_fn(w, h, |x, y| orientation[(x / 2, y / 2)]);
    let ridges = thin(&strength, &orientation);
    (strength, ridges)
}

/// How much the histograms of `frame` change along each direction: what [`from_strengths`] makes Pb of.
pub(crate) fn strengths_of(frame: &Frame) -> [Vec<f32>; ORIENTATIONS] {
    gradient::oriented_strength(frame)
}

/// Probabilities from the strength along each direction, planes of `w × h` pixels.
pub(crate) fn from_strengths(
    strengths: &[Vec<f32>; ORIENTATIONS],
    size: (usize, usize),
    logistic: Logistic,
) -> BoundaryMap {
    let (strength, ridges) = strongest(strengths, size);
    probabilities(&strength, &ridges, logistic)
}

fn probabilities(strength: &Plane<f32>, ridges: &Plane<f32>, logistic: Logistic) -> BoundaryMap {
    let probability = Probability::new(logistic);
    BoundaryMap { pb: strength.map(|s| probability.at(s)), thin: on_ridges(ridges, &probability) }
}

fn on_ridges(ridges: &Plane<f32>, probability: &Probability) -> Plane<f32> {
    ridges.map(|s| if s > 0.0 { probability.at(s) } else { 0.0 })
}

/// The largest strength over all directions, and the same on its ridges across the direction that has it.
pub(crate) fn strongest(strengths: &[Vec<f32>; ORIENTATIONS], size: (usize, usize)) -> (Plane<f32>, Plane<f32>) {
    let (strength, orientation) = largest(strengths, size);
    let ridges = thin(&strength, &orientation);
    (strength, ridges)
}

/// The largest strength over all directions, and which it is.
fn largest(strengths: &[Vec<f32>; ORIENTATIONS], (w, h): (usize, usize)) -> (Plane<f32>, Plane<u8>) {
    let mut strength = Plane::filled(w, h, 0.0_f32);
    let mut orientation = Plane::filled(w, h, 0_u8);
    for (k, plane) in strengths.iter().enumerate() {
        for ((best, o), &v) in strength.data_mut().iter_mut().zip(orientation.data_mut()).zip(plane) {
            *o = if v > *best { k as u8 } else { *o };
            *best = larger(v, *best);
        }
    }
    (strength, orientation)
}

/// A logistic function, which turns strengths into probabilities.
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

/// A logistic function above its value at 0, from a table with straight lines between: off by 1e-5 at most.
struct Probability {
    table: Vec<f32>,
    per_unit: f32,
}

impl Probability {
    /// Lines of the table.
    const STEPS: usize = 1024;

    fn new(logistic: Logistic) -> Self {
        let none = logistic.at(0.0);
        // Where it ends, the function is within 1e-5 of one.
        let end = logistic.centre + 12.0 / logistic.slope;
        let at = |k: usize| (logistic.at(k as f32 * end / Self::STEPS as f32) - none).clamp(0.0, 1.0);
        Self { table: (0..=Self::STEPS).map(at).collect(), per_unit: Self::STEPS as f32 / end }
    }

    fn at(&self, strength: f32) -> f32 {
        let place = strength * self.per_unit;
        let whole = (place as usize).min(Self::STEPS - 1);
        let (low, high) = (self.table[whole], self.table[whole + 1]);
        let part = place - whole as f32;
        low + if part < 1.0 { part } else { 1.0 } * (high - low)
    }
}

/// The logistic of Pb.
pub(crate) const OF_PB: Logistic = Logistic { slope: 7.05, centre: 0.77 };

/// The contours of `map` as line segments.
///
/// # Examples
/// Of the block in [`boundary_map`]'s example.
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
#[must_use]
pub fn contour_segments(map: &BoundaryMap, params: &ContourParams) -> Segments {
    ridge_segments(&map.thin, params)
}

/// The same of a thin map.
pub(crate) fn ridge_segments(thin: &Plane<f32>, params: &ContourParams) -> Segments {
    let chains = link::link(thin, params.low_threshold, params.high_threshold, params.min_length as usize);
    fit::fit(&chains, params.max_deviation, params.max_line_length)
}
