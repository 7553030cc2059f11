//! Gabriel superpixels (section 4.1): closed regions from contours that have gaps.
//!
//! In: [`Segments`] and the [`BoundaryMap`] that they come from. Out: [`Superpixels`].
//!
//! 1. Triangulates the segments and the image rectangle (constrained Delaunay triangulation).
//! 2. Deletes the edges without the Gabriel property (Gabriel and Sokal, "A New Statistical Approach to Geographic
//!    Variation Analysis", 1969), except for the segments. The remaining edges bridge the gaps of contours.
//! 3. Assigns every pixel to the face of its centre.
//! 4. Merges faces without a pixel with a neighbour.
//!
//! **Beyond the paper.** For a given number of superpixels, fainter contours are used, and neighbours with the least Pb
//! between them are merged down to that number; `merge_threshold` merges without a number.
//!
//! **Cost**: O(n log n) in the number of segments, and linear in pixels. It fails where contours are missing over a length
//! larger than the region's width.

mod gabriel;
#[cfg(test)]
mod tests;

pub use gabriel::{Edge, EdgeKind};

use crate::contour::{BoundaryMap, ContourParams, Segments, boundary_map, frame_ridges, ridge_segments};
use crate::image::{Frame, Plane, Runs};
use crate::order;
use gabriel::{Graph, Regions};

crate::params! {
    /// Gabriel superpixels.
    pub struct SuperpixelParams {
        /// Superpixels of areas p and q in pixels are merged while the mean Pb between them, times pq / (p + q), is
        /// below this. 0 keeps the faces of the Gabriel graph.
        pub merge_threshold: f32 = 0.0, in 0.0..=1000000.0;
    }
}

/// The common border of two superpixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SuperpixelBorder {
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
    /// The superpixel of each pixel, in less than a quarter of the memory of a plane.
    runs: Runs<u32>,
    /// Number of superpixels.
    pub count: usize,
    /// Common borders of neighbouring superpixels.
    pub borders: Vec<SuperpixelBorder>,
    /// The triangulation's edges, for drawing.
    pub edges: Vec<Edge>,
}

impl Superpixels {
    pub(crate) fn new(runs: Runs<u32>, borders: Vec<SuperpixelBorder>, edges: Vec<Edge>) -> Self {
        let count = runs.ends().iter().fold(0, |count, &(_, label)| count.max(label as usize + 1));
        Self { runs, count, borders, edges }
    }

    /// Computes the superpixel of each pixel.
    pub fn label(&self) -> Plane<u32> {
        self.runs.to_plane()
    }

    /// The superpixel of each pixel, in runs.
    pub(crate) fn runs(&self) -> &Runs<u32> {
        &self.runs
    }

    /// Number of pixels of each superpixel.
    pub(crate) fn areas(&self) -> Vec<u32> {
        let mut areas = vec![0; self.count];
        self.runs.rows().for_each(|(_, columns, p)| areas[p as usize] += columns.len() as u32);
        areas
    }
}

/// Converts another partition that keeps the law. It has no borders.
impl From<&Plane<u32>> for Superpixels {
    fn from(label: &Plane<u32>) -> Self {
        Self::new(Runs::from_plane(label), Vec::new(), Vec::new())
    }
}

/// Computes the Gabriel superpixels of an image.
///
/// A face of the Gabriel graph is connected, but its pixels may not be where it is thinner than a pixel.
///
/// # Examples
/// The block in [`boundary_map`]'s example: no superpixel has both its centre and the background.
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
#[doc(hidden)] // For benchmarks.
#[must_use]
pub fn gabriel_superpixels(segments: &Segments, map: &BoundaryMap, params: &SuperpixelParams) -> Superpixels {
    partition(segments, &map.thin, None, 0.0, params.merge_threshold)
}

/// Longest line, and largest distance of points on the image border, if contours give too few superpixels. Chosen by eye.
const SHORT_LINE_PX: f32 = 6.0;
/// Thresholds of the contours that are merged down to a given count: all but the faintest. Chosen by eye.
const FAINT_THRESHOLD: f32 = 0.01;

/// Computes the superpixels of an image: `count` of them, or the faces of the contours above the thresholds.
///
/// For a given count, faces of all contours are merged across the weakest borders; an image with few contours has fewer.
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
/// let superpixels = superpixels_of(&frame, Some(3), &ContourParams::default(), &SuperpixelParams::default());
/// let label = superpixels.label();
/// assert!(label.data().iter().all(|&label| (label as usize) < superpixels.count));
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

/// Computes the superpixels of a frame of a clip.
pub(crate) fn frame_superpixels(frame: &Frame, contour: &ContourParams, superpixel: &SuperpixelParams) -> Superpixels {
    superpixels_of_ridges(&frame_ridges(frame, contour), None, contour, superpixel)
}

#[doc(hidden)]
/// Same as [`superpixels_of`], from a boundary map.
#[must_use]
pub fn superpixels_in(
    map: &BoundaryMap,
    count: Option<usize>,
    contour: &ContourParams,
    superpixel: &SuperpixelParams,
) -> Superpixels {
    superpixels_of_ridges(&map.thin, count, contour, superpixel)
}

fn superpixels_of_ridges(
    thin: &Plane<f32>,
    count: Option<usize>,
    contour: &ContourParams,
    superpixel: &SuperpixelParams,
) -> Superpixels {
    let merge_threshold = superpixel.merge_threshold;
    let Some(min_count) = count else {
        return partition(&ridge_segments(thin, contour), thin, None, 0.0, merge_threshold);
    };
    let faint = ContourParams { low_threshold: 0.0, high_threshold: FAINT_THRESHOLD, ..contour.clone() };
    let superpixels = partition(&ridge_segments(thin, &faint), thin, count, 0.0, merge_threshold);
    if superpixels.count >= min_count {
        return superpixels;
    }
    // Too few: shorter lines give more points for edges.
    let fine = ContourParams { high_threshold: 0.0, min_length: 3, max_line_length: SHORT_LINE_PX, ..faint };
    partition(&ridge_segments(thin, &fine), thin, count, SHORT_LINE_PX, merge_threshold)
}

/// Merges faces down to `count`, or else while the cost is below `merge_threshold`. Points on the image border are at most
/// `frame_step` pixels apart; with 0 there are only the corners.
fn partition(
    segments: &Segments,
    thin: &Plane<f32>,
    count: Option<usize>,
    frame_step: f32,
    merge_threshold: f32,
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
    // A fitted line lies beside its contour by up to the tolerance.
    let dilated = dilate3x3(thin);
    let lengths_and_pb: Vec<(f32, f32)> =
        sides.iter().map(|side| length_and_mean(&edges[side.edge], &dilated)).collect();
    let mut regions = Regions::new(area, &sides, &lengths_and_pb);
    regions.merge_empty();
    match count {
        Some(count) => regions.merge_weak(count, 0.0),
        None => regions.merge_weak(usize::MAX, merge_threshold),
    }
    let numbers = number_regions(&mut regions, &mut label, graph.num_faces);
    let mut parts = Vec::new();
    for (side, &(length, pb)) in sides.iter().zip(&lengths_and_pb) {
        let [p, q] = side.faces.map(|f| numbers[regions.find(f) as usize]);
        let edge = &mut edges[side.edge];
        if p != q {
            parts.push(SuperpixelBorder { a: p.min(q), b: p.max(q), length, pb });
        } else {
            edge.kind = EdgeKind::Deleted;
        }
    }
    Superpixels::new(Runs::from_plane(&label), sum_borders(parts), edges)
}

/// Replaces faces by the numbers of their regions, in the order of first occurrence. Returns the number of each region.
fn number_regions(regions: &mut Regions, label: &mut Plane<u32>, num_faces: usize) -> Vec<u32> {
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

/// Sums up the parts of each pair's border.
fn sum_borders(mut parts: Vec<SuperpixelBorder>) -> Vec<SuperpixelBorder> {
    order::sort_by_key(&mut parts, |p| order::pair_key(p.a, p.b));
    let mut borders = Vec::with_capacity(parts.len());
    for group in parts.chunk_by(|p, q| (p.a, p.b) == (q.a, q.b)) {
        let length: f32 = group.iter().map(|p| p.length).sum();
        let strength: f32 = group.iter().map(|p| p.length * p.pb).sum();
        borders.push(SuperpixelBorder { length, pb: strength / length, ..group[0] });
    }
    borders
}

/// Returns the length of an edge in pixels, and the mean of a plane along it, from nearest pixels about one pixel apart.
fn length_and_mean(edge: &Edge, plane: &Plane<f32>) -> (f32, f32) {
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

/// Largest value in the 3×3 pixels around each.
pub(crate) fn dilate3x3(plane: &Plane<f32>) -> Plane<f32> {
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
        for neighbour in [y.saturating_sub(1), (y + 1).min(height - 1)] {
            for (value, &next) in out.iter_mut().zip(across.row(neighbour)) {
                *value = order::larger(*value, next);
            }
        }
    }
    down
}
