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

#[doc(hidden)] // For `examples/method.rs`.
/// Computes the superpixels of a frame of a clip.
#[must_use]
pub fn frame_superpixels(frame: &Frame, contour: &ContourParams, superpixel: &SuperpixelParams) -> Superpixels {
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

#[cfg(test)]
mod tests {
    use super::gabriel::{Point, UNITS_PER_PX};
    use super::*;
    use crate::rng::Rng;

    /// Checks the law of [`Superpixels`].
    fn check(s: &Superpixels, width: usize, height: usize) {
        let labels = s.label();
        assert_eq!((labels.width(), labels.height()), (width, height));
        let mut seen = 0;
        for &label in labels.data() {
            assert!(label <= seen, "label {label} before {seen}");
            seen += u32::from(label == seen);
        }
        assert_eq!(seen as usize, s.count);
        for pair in s.borders.windows(2) {
            assert!((pair[0].a, pair[0].b) < (pair[1].a, pair[1].b), "{pair:?}");
        }
        for border in &s.borders {
            assert!(border.a < border.b && (border.b as usize) < s.count, "{border:?} of {}", s.count);
            assert!(border.length > 0.0 && (0.0..=1.0).contains(&border.pb), "{border:?}");
        }
        let inside =
            |(x, y): (f32, f32)| (-0.5..=width as f32 - 0.5).contains(&x) && (-0.5..=height as f32 - 0.5).contains(&y);
        assert!(s.edges.iter().all(|e| inside(e.from) && inside(e.to) && e.from != e.to));
    }

    fn map_of(thin: Plane<f32>) -> BoundaryMap {
        BoundaryMap { pb: thin.clone(), thin }
    }

    fn run(map: &BoundaryMap) -> Superpixels {
        let s = superpixels_in(map, None, &ContourParams::default(), &SuperpixelParams::default());
        check(&s, map.pb.width(), map.pb.height());
        s
    }

    /// Ridges as a boundary map gives them: the pixels of random lines.
    fn random_lines(rng: &mut Rng, width: usize, height: usize, count: usize) -> Plane<f32> {
        let mut thin = Plane::filled(width, height, 0.0);
        for _ in 0..count {
            let mut end = || (rng.range(0.0, width as f64), rng.range(0.0, height as f64));
            let (a, b) = (end(), end());
            let strength = rng.range(0.05, 1.0) as f32;
            let steps = (b.0 - a.0).abs().max((b.1 - a.1).abs()) as usize + 1;
            for k in 0..steps {
                let share = k as f64 / steps as f64;
                thin[((a.0 + share * (b.0 - a.0)) as usize, (a.1 + share * (b.1 - a.1)) as usize)] = strength;
            }
        }
        thin
    }

    #[test]
    fn degenerate_images_give_a_valid_partition() {
        for (width, height) in [(1, 1), (1, 50), (50, 1), (2, 2), (3, 40), (64, 48)] {
            run(&map_of(Plane::filled(width, height, 0.0)));
            run(&map_of(Plane::filled(width, height, 1.0)));
            let mut rng = Rng::for_stage(1, "noise");
            run(&map_of(Plane::from_fn(width, height, |_, _| rng.uniform() as f32)));
            run(&map_of(Plane::from_fn(width, height, |x, y| if (x + y) % 2 == 0 { 0.5 } else { 0.0 })));
        }
        let empty =
            superpixels_in(&BoundaryMap::default(), None, &ContourParams::default(), &SuperpixelParams::default());
        assert_eq!(empty, Superpixels::default());
    }

    #[test]
    fn a_contour_across_the_image_separates_its_sides() {
        let map = map_of(Plane::from_fn(40, 30, |x, _| if x == 17 { 0.5 } else { 0.0 }));
        let s = superpixels_in(&map, Some(2), &ContourParams::default(), &SuperpixelParams::default());
        check(&s, 40, 30);
        // Pixels on the line go to its right.
        assert_eq!(s.label(), Plane::from_fn(40, 30, |x, _| u32::from(x >= 17)));
        assert_eq!(s.borders.len(), 1);
        let SuperpixelBorder { length, pb, .. } = s.borders[0];
        assert!((length - 30.0).abs() < 1e-3 && (pb - 0.5).abs() < 1e-6, "length {length}, pb {pb}");
    }

    #[test]
    fn borders_of_four_quarters_have_their_lengths_and_strengths() {
        let strength = |x: usize, y: usize| match (x, y) {
            (17, 0..11) => 0.2,
            (17, _) => 0.4,
            (0..17, 11) => 0.6,
            (_, 11) => 0.8,
            _ => 0.0,
        };
        let s = superpixels_in(
            &map_of(Plane::from_fn(40, 30, strength)),
            Some(4),
            &ContourParams::default(),
            &SuperpixelParams::default(),
        );
        check(&s, 40, 30);
        let expected = [(0, 1, 11.5, 0.2), (0, 2, 17.5, 0.6), (1, 3, 22.5, 0.8), (2, 3, 18.5, 0.4)];
        assert_eq!(s.borders.len(), 4, "{:?}", s.borders);
        for (border, (a, b, length, pb)) in s.borders.iter().zip(expected) {
            assert_eq!((border.a, border.b), (a, b));
            // Near the crossing the strongest of all arms counts.
            assert!((border.length - length).abs() < 1e-3 && (border.pb - pb).abs() < 0.1, "{border:?}");
        }
    }

    #[test]
    fn random_contours_give_a_valid_partition_at_every_count() {
        let mut rng = Rng::for_stage(2, "superpixels");
        for round in 0..200 {
            let (width, height) = (1 + rng.below(90), 1 + rng.below(70));
            let lines = rng.below(30);
            let map = map_of(random_lines(&mut rng, width, height, lines));
            run(&map);
            let [all, seven, one] = [usize::MAX, 7, 1].map(|count| {
                let s = superpixels_in(&map, Some(count), &ContourParams::default(), &SuperpixelParams::default());
                check(&s, width, height);
                s.count
            });
            assert_eq!((seven, one), (all.min(7), 1), "round {round}: {all} in all");
        }
    }

    fn cross(a: Point, b: Point, c: Point) -> i128 {
        i128::from(b.0 - a.0) * i128::from(c.1 - a.1) - i128::from(b.1 - a.1) * i128::from(c.0 - a.0)
    }

    /// Returns `true` if two lines cross inside both.
    fn cross_properly(a: Point, b: Point, c: Point, d: Point) -> bool {
        let side = |p, q, r| cross(p, q, r).signum();
        side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0
    }

    /// Positive if `d` lies inside the circle through `a`, `b`, `c`, which turn anticlockwise.
    fn in_circle(a: Point, b: Point, c: Point, d: Point) -> i128 {
        let row = |p: Point| {
            let (x, y) = (i128::from(p.0 - d.0), i128::from(p.1 - d.1));
            (x, y, x * x + y * y)
        };
        let (a, b, c) = (row(a), row(b), row(c));
        a.0 * (b.1 * c.2 - b.2 * c.1) - a.1 * (b.0 * c.2 - b.2 * c.0) + a.2 * (b.0 * c.1 - b.1 * c.0)
    }

    /// Random points on a fine grid, so that hardly ever four lie on a circle, and lines between them that do not cross.
    fn random_segments(rng: &mut Rng, width: usize, height: usize, num_points: usize) -> Segments {
        let place = |rng: &mut Rng, end: usize| (rng.range(0.0, end as f64 - 1.0) * 256.0).floor() as f32 / 256.0;
        let points: Vec<(f32, f32)> = (0..num_points).map(|_| (place(rng, width), place(rng, height))).collect();
        let units = |i: u32| {
            let (x, y) = points[i as usize];
            ((x * 256.0) as i64, (y * 256.0) as i64)
        };
        let mut lines: Vec<(u32, u32)> = Vec::new();
        for _ in 0..2 * num_points {
            let (a, b) = (rng.below(num_points) as u32, rng.below(num_points) as u32);
            let near = (units(a).0 - units(b).0).abs() < 12 * UNITS_PER_PX
                && (units(a).1 - units(b).1).abs() < 12 * UNITS_PER_PX;
            let free = lines.iter().all(|&(c, d)| !cross_properly(units(a), units(b), units(c), units(d)));
            if a < b && near && free && !lines.contains(&(a, b)) {
                lines.push((a, b));
            }
        }
        Segments { points, lines }
    }

    /// Checks that the triangulation covers the image and that each edge that is not given is locally Delaunay; with that
    /// it is the constrained Delaunay triangulation (Lee and Lin, "Generalized Delaunay Triangulation for Planar Graphs",
    /// 1986).
    fn check_triangulation(graph: &Graph, segments: &Segments, width: usize, height: usize) {
        let p = |i: u32| graph.points[i as usize];
        let triangles = &graph.triangulation.triangles;
        let area: i128 = triangles.iter().map(|&[a, b, c]| cross(p(a), p(b), p(c))).sum();
        assert_eq!(area, 2 * (width * height) as i128 * i128::from(UNITS_PER_PX * UNITS_PER_PX));
        let given: Vec<(u32, u32)> =
            graph.triangulation.edges.iter().filter(|e| e.is_constraint).map(|e| (e.ends[0], e.ends[1])).collect();
        let mut wanted = segments.lines.clone();
        wanted.sort();
        assert_eq!(given, wanted);
        for edge in &graph.triangulation.edges {
            let [Some(s), Some(t)] = edge.triangles else { continue };
            let apex = |t: u32| p(*triangles[t as usize].iter().find(|i| !edge.ends.contains(i)).unwrap());
            let [a, b, c] = triangles[s as usize].map(p);
            assert!(cross(a, b, c) > 0);
            assert!(edge.is_constraint || in_circle(a, b, c, apex(t)) <= 0, "{edge:?} is not Delaunay");
            let [e, f] = edge.ends.map(p);
            assert!(cross(e, f, apex(s)).signum() * cross(e, f, apex(t)).signum() < 0, "{edge:?} folds over");
        }
    }

    /// Classifies an edge by trying every point: it is deleted if one inside its diametral circle sees both of its ends.
    fn naive_kind(graph: &Graph, segments: &Segments, ends: [u32; 2], on_hull: bool) -> EdgeKind {
        let p = |i: u32| graph.points[i as usize];
        let [a, b] = ends.map(p);
        if on_hull {
            return EdgeKind::Frame;
        }
        if segments.lines.contains(&(ends[0], ends[1])) {
            return EdgeKind::Constraint;
        }
        let sees = |c: Point, d: Point| segments.lines.iter().all(|&(e, f)| !cross_properly(c, d, p(e), p(f)));
        let inside = |c: Point| (a.0 - c.0) * (b.0 - c.0) + (a.1 - c.1) * (b.1 - c.1) < 0;
        let violated = graph.points.iter().any(|&c| c != a && c != b && inside(c) && sees(a, c) && sees(b, c));
        if violated { EdgeKind::Deleted } else { EdgeKind::Gabriel }
    }

    /// The face of each triangle, by spreading over pairs of triangles with a deleted edge in common.
    fn naive_faces(graph: &Graph, kinds: &[EdgeKind]) -> Vec<usize> {
        let triangles = &graph.triangulation.triangles;
        let mut face: Vec<usize> = (0..triangles.len()).collect();
        for _ in 0..triangles.len() {
            for (edge, kind) in graph.triangulation.edges.iter().zip(kinds) {
                let beside: Vec<usize> =
                    (0..triangles.len()).filter(|&t| edge.ends.iter().all(|e| triangles[t].contains(e))).collect();
                if let (&[s, t], EdgeKind::Deleted) = (&beside[..], kind) {
                    let both = face[s].min(face[t]);
                    (face[s], face[t]) = (both, both);
                }
            }
        }
        face
    }

    #[test]
    fn faces_equal_a_brute_force_construction_on_random_segments() {
        let mut rng = Rng::for_stage(4, "gabriel");
        let params = SuperpixelParams { merge_threshold: 0.0 };
        for round in 0..60 {
            let (width, height) = (20 + rng.below(30), 20 + rng.below(30));
            let num_points = rng.below(30);
            let segments = random_segments(&mut rng, width, height, num_points);
            let graph = Graph::new(&segments, width, height, 0.0);
            check_triangulation(&graph, &segments, width, height);
            let edges = &graph.triangulation.edges;
            let hull = |e: &crate::delaunay::TriangulationEdge| e.triangles.contains(&None);
            let kinds: Vec<EdgeKind> = edges.iter().map(|e| naive_kind(&graph, &segments, e.ends, hull(e))).collect();
            assert_eq!(graph.kinds, kinds, "round {round}");
            let faces = naive_faces(&graph, &kinds);
            let found = gabriel_superpixels(&segments, &map_of(Plane::filled(width, height, 0.0)), &params);
            check(&found, width, height);
            // Superpixel and face of each pixel whose centre is inside a triangle name each other.
            let mut pairs = Vec::new();
            for (i, &label) in found.label().data().iter().enumerate() {
                let centre = ((i % width) as i64 * UNITS_PER_PX, (i / width) as i64 * UNITS_PER_PX);
                let holds = |&t: &usize| {
                    let [a, b, c] = graph.triangulation.triangles[t].map(|i| graph.points[i as usize]);
                    cross(a, b, centre) > 0 && cross(b, c, centre) > 0 && cross(c, a, centre) > 0
                };
                pairs.extend((0..faces.len()).find(holds).map(|t| (label, faces[t])));
            }
            assert!(pairs.len() > width * height / 2, "round {round}: {} centres", pairs.len());
            pairs.sort();
            pairs.dedup();
            let distinct = |mut v: Vec<usize>| {
                v.sort();
                v.dedup();
                v.len()
            };
            assert_eq!(distinct(pairs.iter().map(|p| p.0 as usize).collect()), pairs.len(), "round {round}");
            assert_eq!(distinct(pairs.iter().map(|p| p.1).collect()), pairs.len(), "round {round}");
        }
    }
}
