//! Gabriel superpixels (section 4.1): closed regions from contours that have gaps.
//!
//! In: [`Segments`] and the [`BoundaryMap`] that they come from. Out: [`Superpixels`].
//!
//! 1. The constrained Delaunay triangulation of the segments and the image rectangle.
//! 2. Its edges without the Gabriel property are deleted, but for the segments themselves. What is left bridges the
//!    gaps of contours where their geometry suggests it. (Gabriel and Sokal, "A New Statistical Approach to Geographic
//!    Variation Analysis", 1969)
//! 3. Every pixel goes to the face in which its centre lies.
//! 4. Faces without a pixel are joined with a neighbour.
//!
//! **Beyond the paper.** Where a number of superpixels is asked for, fainter contours count too, and neighbours with the
//! least Pb between them are joined down to that number; `merge_threshold` joins without a number.
//!
//! **Cost**: O(n log n) in the number of segments, and linear in pixels.

mod gabriel;
#[cfg(test)]
mod tests;

pub use gabriel::{Edge, EdgeKind};

use crate::contour::{BoundaryMap, ContourParams, Segments, boundary_map, frame_ridges, ridge_segments};
use crate::image::{Frame, Plane, Runs};
use crate::order;
use gabriel::{Graph, Regions, Side};

crate::params! {
    /// Gabriel superpixels.
    pub struct SuperpixelParams {
        /// Superpixels of areas p and q in pixels are joined while the mean Pb between them, times pq / (p + q), is
        /// below this. 0 leaves the faces of the Gabriel graph as they are.
        pub merge_threshold: f32 = 0.0, in 0.0..=1000000.0;
    }
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
/// Law: [`label`](Self::label) holds the numbers `0..count`, each at least once, in the order of first occurrence row by row;
/// `borders` are sorted by `(a, b)`, `a < b`, each pair once.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Superpixels {
    /// The superpixel of each pixel: less than a quarter of what a plane holds.
    runs: Runs<u32>,
    /// Number of superpixels.
    pub count: usize,
    /// Which superpixels touch, and how.
    pub borders: Vec<Border>,
    /// The triangulation's edges, for drawing.
    pub edges: Vec<Edge>,
}

impl Superpixels {
    pub(crate) fn new(runs: Runs<u32>, borders: Vec<Border>, edges: Vec<Edge>) -> Self {
        let count = runs.ends().iter().fold(0, |count, &(_, label)| count.max(label as usize + 1));
        Self { runs, count, borders, edges }
    }

    /// The superpixel of each pixel; made anew with each call.
    pub fn label(&self) -> Plane<u32> {
        self.runs.plane()
    }

    /// The same in little memory.
    pub(crate) fn runs(&self) -> &Runs<u32> {
        &self.runs
    }

    /// Number of pixels of each superpixel.
    pub(crate) fn areas(&self) -> Vec<u32> {
        let mut areas = vec![0; self.count];
        self.runs.lengths().for_each(|(length, p)| areas[p as usize] += length);
        areas
    }
}

/// A partition made elsewhere, which keeps the law; without borders nothing parts its superpixels.
impl From<&Plane<u32>> for Superpixels {
    fn from(label: &Plane<u32>) -> Self {
        Self::new(Runs::of(label), Vec::new(), Vec::new())
    }
}

/// The Gabriel superpixels of an image.
///
/// A face of the Gabriel graph is connected, but the pixels whose centres lie in it need not be where it is thinner
/// than a pixel.
///
/// # Examples
/// Of the block in [`boundary_map`]'s example: no superpixel holds both the block's middle
/// and the ground.
///
/// ```
/// # use tracecut::contour::{ContourParams, boundary_map};
/// # use tracecut::image::Frame;
/// #
/// # let rows = ["1111111", "1111111", "1198811", "1198811", "1111111"];
/// # let grey = |x: usize, y: usize| 25 * (rows[y / 12].as_bytes()[x / 12] - b'0');
/// # let rgb = (0..60).flat_map(|y| (0..84).flat_map(move |x| [grey(x, y); 3])).collect();
/// # let map = boundary_map(&Frame::from_rgb(rgb, 84, 60)?);
/// use tracecut::contour::contour_segments;
/// use tracecut::superpixel::{SuperpixelParams, gabriel_superpixels};
///
/// let segments = contour_segments(&map, &ContourParams::default());
/// let superpixels = gabriel_superpixels(&segments, &map, &SuperpixelParams::default());
/// assert!(superpixels.count >= 2);
/// assert_ne!(superpixels.label()[(42, 36)], superpixels.label()[(6, 6)]);
/// # Ok::<(), tracecut::Error>(())
/// ```
#[must_use]
pub fn gabriel_superpixels(segments: &Segments, map: &BoundaryMap, params: &SuperpixelParams) -> Superpixels {
    partition(segments, &map.thin, None, (0.0, params.merge_threshold))
}

/// Longest line and widest gap between points of the frame where a wanted number of superpixels needs more than
/// contours give.
const SHORT: f32 = 6.0;

/// The superpixels of one image, on their own: `count` of them, or without it as many as the contours above the
/// thresholds give.
///
/// To come to a given count, faces of all contours however weak are joined across the weakest borders; an image with
/// few contours has fewer.
///
/// # Examples
/// ```
/// use tracecut::contour::ContourParams;
/// use tracecut::image::Frame;
/// use tracecut::superpixel::{SuperpixelParams, superpixels_of};
///
/// let rows = ["1111111", "1111111", "1198811", "1198811", "1111111"];
/// let grey = |x: usize, y: usize| 25 * (rows[y / 12].as_bytes()[x / 12] - b'0');
/// let rgb = (0..60).flat_map(|y| (0..84).flat_map(move |x| [grey(x, y); 3])).collect();
/// let frame = Frame::from_rgb(rgb, 84, 60)?;
/// let found = superpixels_of(&frame, Some(3), &ContourParams::default(), &SuperpixelParams::default());
/// let label = found.label();
/// assert!(label.data().iter().all(|&label| (label as usize) < found.count));
/// assert_ne!(label[(42, 36)], label[(6, 6)]);
/// # Ok::<(), tracecut::Error>(())
/// ```
#[must_use]
pub fn superpixels_of(
    frame: &Frame,
    count: Option<usize>,
    contour: &ContourParams,
    superpixel: &SuperpixelParams,
) -> Superpixels {
    superpixels_in(&boundary_map(frame), count, contour, superpixel)
}

/// The superpixels of a frame of a clip.
pub(crate) fn frame_superpixels(frame: &Frame, contour: &ContourParams, superpixel: &SuperpixelParams) -> Superpixels {
    superpixels_on(&frame_ridges(frame, contour), None, contour, superpixel)
}

#[doc(hidden)]
/// As [`superpixels_of`], from a boundary map.
#[must_use]
pub fn superpixels_in(
    map: &BoundaryMap,
    count: Option<usize>,
    contour: &ContourParams,
    superpixel: &SuperpixelParams,
) -> Superpixels {
    superpixels_on(&map.thin, count, contour, superpixel)
}

fn superpixels_on(
    thin: &Plane<f32>,
    count: Option<usize>,
    contour: &ContourParams,
    superpixel: &SuperpixelParams,
) -> Superpixels {
    let merge_threshold = superpixel.merge_threshold;
    let Some(wanted) = count else {
        return partition(&ridge_segments(thin, contour), thin, None, (0.0, merge_threshold));
    };
    let fine = ContourParams { low_threshold: 0.0, high_threshold: 0.01, ..contour.clone() };
    let found = partition(&ridge_segments(thin, &fine), thin, count, (0.0, merge_threshold));
    if found.count >= wanted {
        return found;
    }
    // Too few: shorter lines give more points that edges can join.
    let finer = ContourParams { high_threshold: 0.0, min_length: 3, max_line_length: SHORT, ..fine };
    partition(&ridge_segments(thin, &finer), thin, count, (SHORT, merge_threshold))
}

/// Faces, joined down to `count`, or else where the cost is below `merge_threshold`. Points on the image border are at most
/// `frame_step` pixels apart; with 0 there are none but corners.
fn partition(
    segments: &Segments,
    thin: &Plane<f32>,
    count: Option<usize>,
    (frame_step, merge_threshold): (f32, f32),
) -> Superpixels {
    let (width, height) = (thin.width(), thin.height());
    if width == 0 || height == 0 {
        return Superpixels::default();
    }
    let graph = Graph::new(segments, width, height, frame_step);
    let mut label = graph.raster(width, height);
    let mut area = vec![0; graph.num_faces];
    label.data().iter().for_each(|&f| area[f as usize] += 1);
    let mut edges: Vec<Edge> = graph.edges().collect();
    let sides = graph.sides();
    let measure = along_edges(&sides, &edges, thin);
    let mut regions = Regions::new(area, &sides, &measure);
    regions.join_empty();
    match count {
        Some(count) => regions.join_weak(count, 0.0),
        None => regions.join_weak(usize::MAX, merge_threshold),
    }
    let numbers = number(&mut regions, &mut label, graph.num_faces);
    let mut parts = Vec::new();
    for (side, &(length, pb)) in sides.iter().zip(&measure) {
        let [p, q] = side.faces.map(|f| numbers[regions.find(f) as usize]);
        let edge = &mut edges[side.edge];
        if p != q {
            parts.push(Border { a: p.min(q), b: p.max(q), length, pb });
        } else {
            edge.kind = EdgeKind::Deleted;
        }
    }
    Superpixels::new(Runs::of(&label), borders(parts), edges)
}

/// Replaces faces by the numbers of their regions, in the order of first occurrence; returns the number of each region.
fn number(regions: &mut Regions, label: &mut Plane<u32>, num_faces: usize) -> Vec<u32> {
    let region: Vec<u32> = (0..num_faces as u32).map(|f| regions.find(f)).collect();
    let mut numbers = vec![u32::MAX; num_faces];
    let mut count = 0;
    for value in label.data_mut() {
        let number = &mut numbers[region[*value as usize] as usize];
        if *number == u32::MAX {
            *number = count;
            count += 1;
        }
        *value = *number;
    }
    numbers
}

/// One border for each pair, from its parts.
fn borders(mut parts: Vec<Border>) -> Vec<Border> {
    order::sort_by_key(&mut parts, |p| order::pair(p.a, p.b));
    let mut borders = Vec::with_capacity(parts.len());
    for group in parts.chunk_by(|p, q| (p.a, p.b) == (q.a, q.b)) {
        let length: f32 = group.iter().map(|p| p.length).sum();
        let strength: f32 = group.iter().map(|p| p.length * p.pb).sum();
        borders.push(Border { length, pb: strength / length, ..group[0] });
    }
    borders
}

/// Length of each side in pixels, and mean Pb along it.
fn along_edges(sides: &[Side], edges: &[Edge], thin: &Plane<f32>) -> Vec<(f32, f32)> {
    let strongest = strongest_around(thin);
    sides.iter().map(|side| along(&edges[side.edge], &strongest)).collect()
}

/// Samples about one pixel apart, each of the pixel nearest to it.
fn along(edge: &Edge, plane: &Plane<f32>) -> (f32, f32) {
    let (dx, dy) = (edge.to.0 - edge.from.0, edge.to.1 - edge.from.1);
    let length = (dx * dx + dy * dy).sqrt();
    let samples = (length as usize).max(1);
    let nearest = |v: f32, end: usize| ((v + 0.5).max(0.0) as usize).min(end - 1);
    let mut sum = 0.0;
    for k in 0..samples {
        let share = (k as f32 + 0.5) / samples as f32;
        let x = nearest(edge.from.0 + share * dx, plane.width());
        let y = nearest(edge.from.1 + share * dy, plane.height());
        sum += plane.row(y)[x];
    }
    (length, sum / samples as f32)
}

/// The largest value in the 3×3 pixels around each: a fitted line lies beside its contour by up to the tolerance.
fn strongest_around(plane: &Plane<f32>) -> Plane<f32> {
    let (width, height) = (plane.width(), plane.height());
    let mut across = plane.clone();
    for y in 0..height {
        let (row, out) = (plane.row(y), across.row_mut(y));
        for x in 1..width {
            out[x] = order::larger(row[x], row[x - 1]);
        }
        for x in 1..width {
            out[x - 1] = order::larger(out[x - 1], row[x]);
        }
    }
    let mut down = across.clone();
    for y in 0..height {
        let out = down.row_mut(y);
        for other in [y.saturating_sub(1), (y + 1).min(height - 1)] {
            for (value, &beside) in out.iter_mut().zip(across.row(other)) {
                *value = order::larger(*value, beside);
            }
        }
    }
    down
}
