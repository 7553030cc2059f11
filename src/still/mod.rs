//! Embedding discontinuities of single images (end of section 2.2, Figure 3b).
//!
//! In: a [`Frame`]. Out: [`ImageDiscontinuities`]: the changes of its pixel embedding, alone and combined with Pb.
//!
//! 1. Pixels at most 5 apart have the affinity `exp(-max Pb / σ)`, the maximum along the line between them (`graph`).
//! 2. The leading eigenvectors of `P = D^-1 W` are computed from coarse to fine (`graph`).
//! 3. From the embedding affinities `Ŵ = V Λ Vᵀ` of each pixel with its four neighbours, and their maximum `δ`, follow the
//!    discontinuities `d_ij = 1 − Ŵ_ij / max(δ_i, δ_j)`, as between trajectories (`discontinuity`).
//! 4. For comparison, the gradients of the same eigenvectors, weighted by `1 / sqrt(1 - λ)`: the spectral part of gPb
//!    (Arbelaez et al., PAMI 2011).
//! 5. Discontinuities are added to Pb, and the sum is calibrated as Pb is.
//!
//! All maps come from strengths along eight directions: mean along the boundary, maximum over the directions, thinning
//! across the boundary. Values are comparable between images, as nothing is normalised by image.
//!
//! **Deviations.** The paper's figure has one `Ŵ` of all eigenvectors (`grouping` "joint"). Two eigenvectors at a time, the
//! constant one and another, with a mean of the roots of `d` by the weights of step 4 ("single"), agree better with
//! boundaries drawn by people. F on 40 images of BSDS500, one-to-one at the benchmark's tolerance:
//!
//! | Pb | d, single | d, joint | gradients | Pb with d, single |
//! |---|---|---|---|---|
//! | 0.686 | 0.693 | 0.668 | 0.699 | 0.696 |
//!
//! As a mean, the strength of "single" is 1 only where all eigenvectors change; between two flat halves of an image it is
//! about 0.7, and the strength of "joint" is 1.
//!
//! **Cost**: linear in pixels, `r²` and the number of eigenvectors; 1.5 to 2 seconds of processor time for 481x321 in Node.
//! Memory: about 800 bytes a pixel. It cannot be interrupted.
//!
//! **Limits**: eigenvectors of the finer levels are not iterated to convergence (`info` has the residual); twice the
//! products changed F by at most 0.002 on half of these images.

mod discontinuity;
mod graph;

use crate::contour::{
    BoundaryMap, Logistic, ORIENTATIONS, PB_LOGISTIC, boundaries_from_strengths, oriented_strengths, strongest_ridges,
};
use crate::embedding::EigenInfo;
use crate::image::{Frame, Plane, fit_within};
use discontinuity::{Changes, changes};
use graph::{PixelEmbedding, embed_pixels};

/// Strengths of boundaries at all pixels.
///
/// Invariants: both planes have the size of the image and values in `0.0..=1.0`; `thin` is `strength` or 0.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct StrengthMap {
    /// The maximum over all directions.
    pub strength: Plane<f32>,
    /// The same on ridges one pixel wide, 0 elsewhere.
    pub thin: Plane<f32>,
}

/// Boundaries of an image by the changes of its pixel embedding.
///
/// Invariant: all planes have the size of the image, reduced to [`StillParams::max_side`].
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct ImageDiscontinuities {
    /// Boundary probability Pb, from which the embedding is computed.
    pub pb: BoundaryMap,
    /// Embedding discontinuities: the root of `d`.
    pub d: StrengthMap,
    /// Gradients of the eigenvectors, for comparison.
    pub spectral: StrengthMap,
    /// Pb and discontinuities combined, as a probability.
    pub combined: BoundaryMap,
    /// Eigenvalues of `P = D^-1 W`, largest first.
    pub eigenvalues: Vec<f64>,
    /// Its eigenvectors `V`, with `Vᵀ D V = 1`, a plane for each.
    pub eigenvectors: Vec<Plane<f32>>,
    /// The eigensolver's report for the finest level.
    pub info: EigenInfo,
}

/// Detects boundaries of `frame` by the discontinuities of its pixel embedding.
///
/// Images with a side longer than [`StillParams::max_side`] are reduced first. An image without boundaries is not embedded
/// and has no discontinuities.
///
/// # Examples
/// Between a dark and a bright half the embedding changes, elsewhere it does not.
///
/// ```
/// use tracecut::image::Frame;
/// use tracecut::still::{StillParams, image_discontinuities};
///
/// let rgb = (0..40 * 30).flat_map(|p| if p % 40 < 20 { [60; 3] } else { [180; 3] }).collect();
/// let frame = Frame::from_rgb(rgb, 40, 30)?;
/// let mut params = StillParams::default();
/// params.dimensions = 4;
/// let boundaries = image_discontinuities(&frame, &params, 0);
/// let row = boundaries.d.strength.row(15);
/// let strongest = (0..40).max_by(|&a, &b| row[a].total_cmp(&row[b]));
/// assert!(strongest.is_some_and(|x| x.abs_diff(20) <= 1), "{row:?}");
/// assert!(row[8] < 0.5 * row[20].max(row[19]));
/// # Ok::<(), tracecut::Error>(())
/// ```
#[must_use]
pub fn image_discontinuities(frame: &Frame, params: &StillParams, seed: u32) -> ImageDiscontinuities {
    let (w, h) = fit_within(frame.width(), frame.height(), params.max_side as usize);
    let strengths = oriented_strengths(&frame.resized(w, h));
    let pb = boundaries_from_strengths(&strengths, (w, h), PB_LOGISTIC);
    if pb.thin.data().iter().all(|&v| v <= MIN_PB) {
        let empty = StrengthMap { strength: Plane::filled(w, h, 0.0), thin: Plane::filled(w, h, 0.0) };
        let combined = pb.clone();
        return ImageDiscontinuities {
            pb,
            d: empty.clone(),
            spectral: empty,
            combined,
            ..ImageDiscontinuities::default()
        };
    }
    let embedding = embed_pixels(&pb.thin, params, seed);
    let Changes { d, spectral } = changes(&embedding, params.grouping);
    let combined = combine(&strengths, &d, w, h, params.weight);
    let PixelEmbedding { eigenvalues, vectors, info, .. } = embedding;
    let eigenvectors = vectors.into_iter().filter_map(|v| Plane::from_vec(w, h, v)).collect();
    let d = strength_map(&d, w, h, |s| s.clamp(0.0, 1.0));
    let spectral = strength_map(&spectral, w, h, |s| s * s / (s * s + HALF_STRENGTH_GRADIENT * HALF_STRENGTH_GRADIENT));
    ImageDiscontinuities { pb, d, spectral, combined, eigenvalues, eigenvectors, info }
}

/// Smallest Pb that counts as a boundary: less is rounding. Chosen by eye.
const MIN_PB: f32 = 1e-4;
/// Sum of weighted gradients that is mapped to a strength of one half. Chosen by eye.
const HALF_STRENGTH_GRADIENT: f32 = 15.0;
/// Weight of a discontinuity relative to a strength of Pb. Chosen by F on BSDS500, as the table above.
const DISCONTINUITY_WEIGHT: f32 = 2.5;
/// The slope of Pb's logistic is divided by 1 plus this times the parameter `weight`. Fitted like the logistic of Pb, at
/// weight 1.
const LOGISTIC_FLATTENING: f32 = 1.333;
/// The centre of Pb's logistic is raised by this times the parameter `weight` (same fit).
const LOGISTIC_SHIFT: f32 = 0.5;

/// Combines changes along all directions to a map whose values are mapped by `scaled`.
fn strength_map(
    changes: &[Vec<f32>; ORIENTATIONS],
    width: usize,
    height: usize,
    scaled: impl Fn(f32) -> f32,
) -> StrengthMap {
    let (strength, thin) = strongest_ridges(changes, (width, height));
    StrengthMap { strength: strength.map(&scaled), thin: thin.map(&scaled) }
}

/// Combines the strengths of Pb and `weight` times the discontinuities to a boundary probability.
fn combine(
    pb: &[Vec<f32>; ORIENTATIONS],
    d: &[Vec<f32>; ORIENTATIONS],
    width: usize,
    height: usize,
    weight: f32,
) -> BoundaryMap {
    let d_weight = weight * DISCONTINUITY_WEIGHT;
    let sums = std::array::from_fn(|k| pb[k].iter().zip(&d[k]).map(|(s, d)| s + d_weight * d).collect());
    let logistic = Logistic {
        slope: PB_LOGISTIC.slope / (1.0 + weight * LOGISTIC_FLATTENING),
        centre: PB_LOGISTIC.centre + weight * LOGISTIC_SHIFT,
    };
    boundaries_from_strengths(&sums, (width, height), logistic)
}

crate::choices! {
    /// The eigenvectors that a discontinuity of pixels is computed from.
    pub enum Grouping {
        /// All eigenvectors together, as between trajectories: the paper's Ŵ.
        Joint = "joint",
        /// Each eigenvector with the constant one, and then a mean over all of them.
        Single = "single",
    }
}

crate::params! {
    /// Pixel embedding of single images, and its discontinuities.
    pub struct StillParams {
        /// Longest side at which an image is processed, in pixels; larger ones are reduced. Higher is slower and takes more
        /// memory.
        pub max_side: u32 = 640, in 16..=4096;
        /// Radius within which pixels are compared, in pixels. Higher is slower.
        pub radius: u32 = 5, in 1..=10, expert;
        /// Pb between two pixels that lowers their affinity to 1/e.
        pub sigma: f32 = 0.1, in 0.001..=10.0, expert;
        /// Number of eigenvectors, the constant one included. Higher is slower.
        pub dimensions: u32 = 24, in 2..=64, expert;
        /// Eigenvectors that d is computed from: all together (the paper: joint), or each with the constant one and then a
        /// mean.
        pub grouping: Grouping = Grouping::Single, in 0..=1, expert;
        /// Weight of the discontinuities in the combined map; 0 gives Pb.
        pub weight: f32 = 1.0, in 0.0..=100.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    fn frame(w: usize, h: usize, mut grey: impl FnMut(usize, usize) -> u8) -> Frame {
        let rgb = (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).flat_map(|(x, y)| [grey(x, y); 3]).collect();
        Frame::from_rgb(rgb, w, h).unwrap()
    }

    /// Rectangles of random greys, and noise.
    fn clutter(w: usize, h: usize, seed: u64) -> Frame {
        let mut rng = Rng::for_stage(seed, "clutter");
        let boxes: Vec<[usize; 5]> =
            (0..10).map(|_| [w, h, w, h, 256].map(|n| (rng.uniform() * n as f64) as usize)).collect();
        let mut noise = Rng::for_stage(seed, "noise");
        frame(w, h, |x, y| {
            let inside =
                |b: &&[usize; 5]| (b[0]..=b[0] + b[2] / 2).contains(&x) && (b[1]..=b[1] + b[3] / 2).contains(&y);
            let grey = boxes.iter().rev().find(inside).map_or(90, |b| b[4]);
            (grey as u8 / 16 * 15).saturating_add((noise.uniform() * 16.0) as u8)
        })
    }

    fn detect(frame: &Frame, params: &StillParams) -> ImageDiscontinuities {
        image_discontinuities(frame, params, 0)
    }

    fn check(result: &ImageDiscontinuities, size: (usize, usize)) {
        let pairs = [
            (&result.pb.pb, &result.pb.thin),
            (&result.d.strength, &result.d.thin),
            (&result.spectral.strength, &result.spectral.thin),
            (&result.combined.pb, &result.combined.thin),
        ];
        for (map, thin) in pairs {
            assert_eq!((map.width(), map.height()), size);
            assert_eq!((thin.width(), thin.height()), size);
            for (&v, &t) in map.data().iter().zip(thin.data()) {
                assert!((0.0..=1.0).contains(&v) && (t == 0.0 || t == v), "strength {v}, thin {t}");
            }
        }
        assert_eq!(result.eigenvalues.len(), result.eigenvectors.len());
        assert!(result.eigenvalues.is_sorted_by(|a, b| a >= b));
    }

    #[test]
    fn two_flat_halves_have_their_discontinuity_between_them() {
        for (w, h) in [(64, 48), (160, 100)] {
            let halves = frame(w, h, |x, _| if x < w / 2 { 40 } else { 210 });
            for (grouping, least, most) in [(Grouping::Joint, 0.95, 0.5), (Grouping::Single, 0.6, 0.3)] {
                let result = detect(&halves, &StillParams { grouping, ..StillParams::default() });
                check(&result, (w, h));
                for y in 0..h {
                    let row = result.d.strength.row(y);
                    let cut = row[w / 2 - 2..w / 2 + 2].iter().fold(0.0_f32, |m, &v| m.max(v));
                    assert!(cut > least, "{cut} on the cut of {w}x{h} {grouping:?}");
                    let inside = row.iter().enumerate().filter(|(x, _)| x.abs_diff(w / 2) > 3);
                    inside.for_each(|(x, &d)| assert!(d < most, "{d} at {x}, {y} of {w}x{h} {grouping:?}"));
                }
            }
        }
    }

    #[test]
    fn flat_images_have_no_discontinuities() {
        for (w, h) in [(1, 1), (1, 30), (30, 1), (2, 2), (5, 3), (60, 45)] {
            let result = detect(&frame(w, h, |_, _| 120), &StillParams::default());
            check(&result, (w, h));
            for map in [&result.d.strength, &result.spectral.strength] {
                assert!(map.data().iter().all(|&v| v == 0.0), "{w}x{h}");
            }
            assert_eq!(result.combined, result.pb);
        }
    }

    #[test]
    fn images_of_any_small_size_have_legal_maps() {
        for (w, h) in [(1, 1), (1, 2), (2, 1), (1, 40), (40, 1), (2, 2), (3, 5), (16, 4), (19, 18)] {
            for grouping in [Grouping::Joint, Grouping::Single] {
                let params = StillParams { grouping, ..StillParams::default() };
                check(&detect(&clutter(w, h, 5), &params), (w, h));
            }
        }
    }

    #[test]
    fn the_finest_level_is_embedded_with_orthonormal_vectors_every_time_the_same() {
        let image = clutter(140, 100, 1);
        let params = StillParams::default();
        let first = detect(&image, &params);
        check(&first, (140, 100));
        assert!(first.info.residual < 0.1, "{:?}", first.info);
        assert!((first.eigenvalues[0] - 1.0).abs() < 1e-4, "{:?}", first.eigenvalues);
        let graph = graph::PixelGraph::new(&first.pb.thin, params.radius, params.sigma);
        let product = |a: &Plane<f32>, b: &Plane<f32>| -> f64 {
            let terms = a.data().iter().zip(b.data()).zip(&graph.scale);
            terms.map(|((&a, &b), &s)| f64::from(a) * f64::from(b) / f64::from(s * s)).sum()
        };
        for (i, a) in first.eigenvectors.iter().enumerate() {
            for (j, b) in first.eigenvectors.iter().enumerate() {
                let expected = f64::from(u8::from(i == j));
                assert!((product(a, b) - expected).abs() < 1e-4, "VᵀDV has {} at {i}, {j}", product(a, b));
            }
        }
        assert_eq!(detect(&image, &params), first);
    }

    #[test]
    fn parameters_at_the_ends_of_their_ranges_give_legal_maps() {
        let ends = [
            StillParams { sigma: 0.001, ..StillParams::default() },
            StillParams { sigma: 10.0, radius: 10, ..StillParams::default() },
            StillParams { radius: 1, dimensions: 2, ..StillParams::default() },
            StillParams { dimensions: 64, weight: 100.0, ..StillParams::default() },
        ];
        for params in ends {
            check(&detect(&clutter(40, 31, 6), &params), (40, 31));
            check(&detect(&clutter(125, 97, 6), &params), (125, 97));
        }
    }

    #[test]
    fn without_weight_the_combined_map_is_pb() {
        let image = clutter(60, 45, 2);
        let plain = detect(&image, &StillParams { weight: 0.0, ..StillParams::default() });
        assert_eq!(plain.combined, plain.pb);
        let default = detect(&image, &StillParams::default());
        assert_eq!(default.pb, plain.pb);
        assert_ne!(default.combined, default.pb);
    }

    #[test]
    fn large_images_are_reduced() {
        let image = clutter(120, 61, 2);
        let small = detect(&image, &StillParams { max_side: 60, ..StillParams::default() });
        check(&small, (60, 31));
        assert_eq!(small.pb, detect(&image.resized(60, 31), &StillParams::default()).pb);
    }
}
