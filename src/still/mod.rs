//! Embedding discontinuities of single images (end of section 2.2, Figure 3b).
//!
//! In: a [`Frame`]. Out: [`ImageDiscontinuities`]: where the embedding of its pixels changes, and what that adds to Pb.
//!
//! 1. Pixels up to 5 apart have the affinity `exp(-max Pb / σ)`, the maximum along the line between them (`graph`).
//! 2. The leading eigenvectors of `P = D^-1 W`, from coarse to fine (`levels`).
//! 3. Embedding affinities `Ŵ = V Λ Vᵀ` of each pixel with the four around it, their greatest `δ`, and `d = 1 − Ŵ /
//!    max(δ, δ)`: as between trajectories (`discontinuity`).
//! 4. To compare with, the gradients of the same eigenvectors, by `1 / sqrt(1 - λ)`: the spectral part of the detector
//!    of Arbelaez et al. (PAMI 2011).
//! 5. Pb with the discontinuities added, calibrated as Pb is.
//!
//! The maps are made by one procedure from their strengths along eight directions: a mean along the boundary, the
//! strongest direction, thinning across it. There is no normalisation by image: a value means the same in all.
//!
//! **Deviations.** The paper's figure has one `Ŵ` of all eigenvectors (`grouping` "joint"). With two eigenvectors at a
//! time, the constant one and another, and a mean of the roots of `d` by the weights of step 4 ("single"), boundaries
//! agree better with those that people drew. F on 40 images of BSDS500, one-to-one at the benchmark's tolerance, as
//! `bench contours --embedding` prints it:
//!
//! | Pb | d, single | d, joint | gradients | Pb with d, single |
//! |---|---|---|---|---|
//! | 0.686 | 0.693 | 0.668 | 0.699 | 0.696 |
//!
//! As a mean, the strength of "single" is one only where all eigenvectors change; between two flat halves of an image
//! it is about
//! 0.7, where the strength of "joint" is 1.
//!
//! **Cost**: linear in pixels, `r²` and the number of eigenvectors; 1.5 to 2 seconds of processor time for 481x321 in
//! Node. Memory: some 800 bytes a pixel. One piece of work, without steps between.
//!
//! **Limits**: on the finer levels the eigenvectors are not iterated to convergence (`info` says how far they are);
//! twice the products changed F by at most 0.002 on half of these images.

mod discontinuity;
mod graph;
mod params;
#[cfg(test)]
mod tests;

use crate::contour::{
    BoundaryMap, Logistic, ORIENTATIONS, PB_LOGISTIC, boundaries_from_strengths, mean_along_boundary, normals,
    oriented_strengths, strongest_ridges,
};
use crate::embedding::EigenInfo;
use crate::image::{Frame, Plane, fit_within, gaussian_blur};
use discontinuity::{Part, Products, Slopes, add_change, cracks};
use graph::{PixelEmbedding, embed_pixels};
pub use params::{Grouping, StillParams};

/// A strength for each pixel.
///
/// Law: both planes have the size of the image and values in `0.0..=1.0`; `thin` is `strength` or 0.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct StrengthMap {
    /// The largest over all directions.
    pub strength: Plane<f32>,
    /// The same on ridges one pixel wide, 0 elsewhere.
    pub thin: Plane<f32>,
}

/// Where the pixel embedding of an image changes.
///
/// Law: all planes have the size that the image was looked at.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct ImageDiscontinuities {
    /// Boundary probability, which the embedding comes from.
    pub pb: BoundaryMap,
    /// Embedding discontinuities: the root of `d`.
    pub d: StrengthMap,
    /// Gradients of the eigenvectors, to compare with.
    pub spectral: StrengthMap,
    /// Pb and discontinuities together, as a probability.
    pub combined: BoundaryMap,
    /// Eigenvalues of `P = D^-1 W`, largest first.
    pub eigenvalues: Vec<f64>,
    /// Its eigenvectors `V`, with `Vᵀ D V = 1`, a plane for each.
    pub eigenvectors: Vec<Plane<f32>>,
    /// What the eigensolver reports of the finest level.
    pub info: EigenInfo,
}

/// Boundaries of `frame` by the discontinuities of its pixel embedding.
///
/// Images with a side longer than [`StillParams::max_side`] are reduced first. An image without any boundary has no
/// discontinuities; nothing is embedded then.
///
/// # Examples
/// A bright half and a dark half: the embedding changes between them, and nowhere else.
///
/// ```
/// use tracecut::image::Frame;
/// use tracecut::still::{StillParams, image_discontinuities};
///
/// let rgb = (0..40 * 30).flat_map(|p| if p % 40 < 20 { [60; 3] } else { [180; 3] }).collect();
/// let frame = Frame::from_rgb(rgb, 40, 30)?;
/// let params = StillParams { dimensions: 4, ..StillParams::default() };
/// let found = image_discontinuities(&frame, &params, 0);
/// let row = found.d.strength.row(15);
/// let strongest = (0..40).max_by(|&a, &b| row[a].total_cmp(&row[b]));
/// assert!(strongest.is_some_and(|x| x.abs_diff(20) <= 1), "{row:?}");
/// assert!(row[8] < 0.5 * row[20].max(row[19]));
/// # Ok::<(), tracecut::Error>(())
/// ```
#[must_use]
pub fn image_discontinuities(frame: &Frame, params: &StillParams, seed: u32) -> ImageDiscontinuities {
    let (w, h) = fit_within((frame.width(), frame.height()), params.max_side as usize);
    let strengths = oriented_strengths(&frame.resized(w, h));
    let pb = boundaries_from_strengths(&strengths, (w, h), PB_LOGISTIC);
    if pb.thin.data().iter().all(|&v| v <= FAINTEST) {
        let none = StrengthMap { strength: Plane::filled(w, h, 0.0), thin: Plane::filled(w, h, 0.0) };
        let combined = pb.clone();
        return ImageDiscontinuities {
            pb,
            d: none.clone(),
            spectral: none,
            combined,
            ..ImageDiscontinuities::default()
        };
    }
    let embedding = embed_pixels(&pb.thin, params, seed);
    let Changes { d, spectral } = changes(&embedding, params.grouping);
    let combined = combine(&strengths, &d, (w, h), params.weight);
    let PixelEmbedding { eigenvalues, vectors, info, .. } = embedding;
    let eigenvectors = vectors.into_iter().filter_map(|v| Plane::from_vec(w, h, v)).collect();
    let d = strength_map(&d, (w, h), |s| s.clamp(0.0, 1.0));
    let spectral = strength_map(&spectral, (w, h), |s| s * s / (s * s + HALF_GRADIENT * HALF_GRADIENT));
    ImageDiscontinuities { pb, d, spectral, combined, eigenvalues, eigenvectors, info }
}

/// Images whose Pb is nowhere above this have no boundary: what is left is rounding.
const FAINTEST: f32 = 1e-4;
/// Standard deviation of the blur before gradients are taken, in pixels (Arbelaez et al.: 1).
const GRADIENT_SIGMA: f32 = 1.0;
/// Sum of weighted gradients that counts as one half.
const HALF_GRADIENT: f32 = 15.0;
/// Weights of eigenvectors stop growing where an eigenvalue is this near to 1.
const NEAREST_TO_ONE: f64 = 1e-6;
/// By what a discontinuity is multiplied to stand beside a strength of Pb.
const BESIDE_PB: f32 = 2.5;
/// How the logistic of Pb changes with the weight of the discontinuities: its slope is divided by one plus `FLATTER`
/// times the weight, its centre moves by `HIGHER` times the weight. Fitted as those of Pb are, at weight 1.
const FLATTER: f32 = 1.333;
const HIGHER: f32 = 0.5;

/// Changes of an embedding along each direction.
struct Changes {
    /// Roots of `d`, `0.0..=1.0`.
    d: [Vec<f32>; ORIENTATIONS],
    spectral: [Vec<f32>; ORIENTATIONS],
}

fn changes(embedding: &PixelEmbedding, grouping: Grouping) -> Changes {
    let PixelEmbedding { width, height, eigenvalues, vectors, .. } = embedding;
    let n = width * height;
    let none = || std::array::from_fn(|_| vec![0.0_f32; n]);
    let mut changes = Changes { d: none(), spectral: none() };
    let weights = weights(eigenvalues);
    let total: f32 = weights.iter().sum();
    let mut all = Products::zero(n);
    for (k, vector) in vectors.iter().enumerate() {
        let slopes = smooth_slopes(vector, *width);
        all.add(&slopes, eigenvalues[k] as f32);
        if k == 0 {
            continue;
        }
        add_gradient(&slopes, weights[k - 1] / root_mean_square(vector), &mut changes.spectral);
        if grouping == Grouping::Single {
            let mut own = Products::zero(n);
            own.add(&slopes, 1.0);
            let pair = [vectors[0].as_slice(), vector.as_slice()];
            let part = Part { width: *width, eigenvalues: &[eigenvalues[0], eigenvalues[k]], vectors: &pair };
            add_change(&cracks(&part), &own, *width, weights[k - 1] / total, &mut changes.d);
        }
    }
    if grouping == Grouping::Joint && vectors.len() > 1 {
        let vectors: Vec<&[f32]> = vectors.iter().map(Vec::as_slice).collect();
        let part = Part { width: *width, eigenvalues, vectors: &vectors };
        add_change(&cracks(&part), &all, *width, 1.0, &mut changes.d);
    }
    for planes in [&mut changes.d, &mut changes.spectral] {
        for (plane, normal) in planes.iter_mut().zip(normals()) {
            *plane = mean_along_boundary(plane, *width, normal, 1.0);
        }
    }
    changes
}

/// `1 / sqrt(1 - λ)` of all eigenvalues but the first.
fn weights(eigenvalues: &[f64]) -> Vec<f32> {
    eigenvalues.iter().skip(1).map(|l| 1.0 / (1.0 - l).max(NEAREST_TO_ONE).sqrt() as f32).collect()
}

fn smooth_slopes(vector: &[f32], width: usize) -> Slopes {
    let plane = Plane::from_vec(width, vector.len() / width, vector.to_vec()).unwrap_or_default();
    Slopes::of(gaussian_blur(&plane, GRADIENT_SIGMA).data(), width)
}

fn root_mean_square(vector: &[f32]) -> f32 {
    let sum: f64 = vector.iter().map(|&v| f64::from(v) * f64::from(v)).sum();
    ((sum / vector.len().max(1) as f64).sqrt() as f32).max(f32::MIN_POSITIVE)
}

/// Adds `weight` times the size of the slope along each direction.
fn add_gradient(slopes: &Slopes, weight: f32, out: &mut [Vec<f32>; ORIENTATIONS]) {
    for (plane, (nx, ny)) in out.iter_mut().zip(normals()) {
        for ((o, x), y) in plane.iter_mut().zip(&slopes.x).zip(&slopes.y) {
            *o += weight * (nx * x + ny * y).abs();
        }
    }
}

fn strength_map(changes: &[Vec<f32>; ORIENTATIONS], size: (usize, usize), scaled: impl Fn(f32) -> f32) -> StrengthMap {
    let (strength, thin) = strongest_ridges(changes, size);
    StrengthMap { strength: strength.map(&scaled), thin: thin.map(&scaled) }
}

/// Pb from the strengths that it is made of and `weight` times those of the discontinuities.
fn combine(
    pb: &[Vec<f32>; ORIENTATIONS],
    d: &[Vec<f32>; ORIENTATIONS],
    size: (usize, usize),
    weight: f32,
) -> BoundaryMap {
    let beside = weight * BESIDE_PB;
    let sums = std::array::from_fn(|k| pb[k].iter().zip(&d[k]).map(|(s, d)| s + beside * d).collect());
    let logistic =
        Logistic { slope: PB_LOGISTIC.slope / (1.0 + weight * FLATTER), centre: PB_LOGISTIC.centre + weight * HIGHER };
    boundaries_from_strengths(&sums, size, logistic)
}
