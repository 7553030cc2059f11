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
//! boundaries drawn by people. F on 40 images of BSDS500, one-to-one at the benchmark's tolerance, as
//! `bench contours --embedding` prints it:
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
mod params;
#[cfg(test)]
mod tests;

use crate::contour::{
    BoundaryMap, Logistic, ORIENTATIONS, PB_LOGISTIC, boundaries_from_strengths, oriented_strengths, strongest_ridges,
};
use crate::embedding::EigenInfo;
use crate::image::{Frame, Plane, fit_within};
use discontinuity::{Changes, changes};
use graph::{PixelEmbedding, embed_pixels};
pub use params::{Grouping, StillParams};

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
