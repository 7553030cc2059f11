//! Leading eigenvectors of an image's pixel graph, from coarse to fine.
//!
//! Eigenvalues of such graphs are crowded below 1: the larger the image, the closer. So the image is halved until it is
//! small, solved there by block Lanczos, and each finer level starts from the coarser one's vectors, doubled in size.
//! There a Chebyshev filter does what is left: it moves what doubling smeared across contours to the side where it
//! belongs.

use super::graph::PixelGraph;
use super::params::StillParams;
use crate::embedding::{EigenInfo, EigenParams, largest_eigenpairs, refine_eigenpairs};
use crate::image::Plane;

/// Images of at most this many pixels are solved directly.
const COARSEST: usize = 12_000;
/// Products with each eigenvector on the finer levels. Higher is slower and nearer to the exact eigenvectors.
const DEGREE: u32 = 10;
/// Residual at which an eigenpair of the coarsest level is good enough. Lower is slower.
const TOLERANCE: f64 = 1e-3;
/// Products after which the coarsest level is good enough as it is.
const MAX_PRODUCTS: f64 = 4000.0;
/// The same in multiplications, about two seconds.
const MOST_WORK: f64 = 8e9;
/// Multiplications for each pixel and product that go into the basis of the eigensolver.
const OF_BASIS: f64 = 300.0;

/// Leading eigenvectors of `P = D^-1 W`.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct PixelEmbedding {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Largest first.
    pub(super) eigenvalues: Vec<f64>,
    /// `V = D^-1/2 U`, so that `Vᵀ D V = 1`; a plane for each eigenvalue.
    pub(super) vectors: Vec<Vec<f32>>,
    pub(super) info: EigenInfo,
}

/// The embedding of the pixels of an image with the boundary strengths `pb`, thin lines.
pub(super) fn embed_pixels(pb: &Plane<f32>, params: &StillParams, seed: u32) -> PixelEmbedding {
    if pb.width() * pb.height() <= COARSEST {
        return solve(pb, params, seed);
    }
    let coarse = embed_pixels(&halved(pb), params, seed);
    refine(pb, &coarse, params)
}

fn solve(pb: &Plane<f32>, params: &StillParams, seed: u32) -> PixelEmbedding {
    let graph = PixelGraph::new(pb, params.radius, params.sigma);
    let settings = EigenParams { tolerance: TOLERANCE, max_products: most_products(&graph), multiplicity: 0, seed };
    let pairs = largest_eigenpairs(&graph, params.dimensions as usize, &settings);
    let k = pairs.values.len();
    unscaled(&graph, pb, pairs.values, &pairs.vectors, k, pairs.info)
}

/// Fewer where each takes long: large radii.
fn most_products(graph: &PixelGraph) -> u32 {
    let of_one = (graph.neighbours() as f64 + OF_BASIS) * graph.scale.len() as f64;
    (MOST_WORK / of_one).min(MAX_PRODUCTS) as u32
}

fn refine(pb: &Plane<f32>, coarse: &PixelEmbedding, params: &StillParams) -> PixelEmbedding {
    let graph = PixelGraph::new(pb, params.radius, params.sigma);
    let mut start = Vec::with_capacity(pb.data().len() * coarse.vectors.len());
    for vector in &coarse.vectors {
        let large = doubled(vector, coarse.width, (pb.width(), pb.height()));
        // U = D^1/2 V.
        start.extend(large.iter().zip(&graph.scale).map(|(v, &s)| if s > 0.0 { f64::from(v / s) } else { 0.0 }));
    }
    match refine_eigenpairs(&graph, start, DEGREE, TOLERANCE) {
        Some(pairs) => {
            let k = pairs.values.len();
            unscaled(&graph, pb, pairs.values, &pairs.vectors, k, pairs.info)
        }
        None => PixelEmbedding { width: pb.width(), height: pb.height(), ..PixelEmbedding::default() },
    }
}

/// From eigenvectors of N, row by row, to planes of those of P.
fn unscaled(
    graph: &PixelGraph,
    pb: &Plane<f32>,
    eigenvalues: Vec<f64>,
    rows: &[f64],
    k: usize,
    info: EigenInfo,
) -> PixelEmbedding {
    let plane = |c: usize| -> Vec<f32> {
        rows.iter().skip(c).step_by(k).zip(&graph.scale).map(|(&u, &s)| u as f32 * s).collect()
    };
    let vectors = (0..k).map(plane).collect();
    PixelEmbedding { width: pb.width(), height: pb.height(), eigenvalues, vectors, info }
}

/// The largest of each 2x2 pixels.
fn halved(pb: &Plane<f32>) -> Plane<f32> {
    let (w, h) = (pb.width(), pb.height());
    Plane::from_fn(w.div_ceil(2), h.div_ceil(2), |x, y| {
        let (x1, y1) = ((2 * x + 1).min(w - 1), (2 * y + 1).min(h - 1));
        pb[(2 * x, 2 * y)].max(pb[(x1, 2 * y)]).max(pb[(2 * x, y1)]).max(pb[(x1, y1)])
    })
}

/// Twice as large: each pixel is copied.
fn doubled(small: &[f32], small_width: usize, (w, h): (usize, usize)) -> Vec<f32> {
    (0..h).flat_map(|y| (0..w).map(move |x| small[y / 2 * small_width + x / 2])).collect()
}
