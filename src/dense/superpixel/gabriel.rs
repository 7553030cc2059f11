//! The constrained Gabriel graph: its faces, and the pixels in each.
//!
//! Points are rounded to 1/256 pixel and all decisions made in whole numbers, so that they are exact and everywhere the
//! same.

use crate::contour::Segments;
use crate::delaunay::{Triangulation, TriangulationEdge, constrained_delaunay};
use crate::image::Plane;
use crate::order::{pair, signed, sort_by_key};

/// What an edge of the constrained Delaunay triangulation became.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum EdgeKind {
    /// A piece of a contour.
    Constraint,
    /// A piece of the image frame.
    Frame,
    /// A Delaunay edge with the Gabriel property: it bridges a gap.
    Gabriel,
    /// It separates nothing: a Delaunay edge without that property, or an edge across which superpixels were joined.
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

/// Units in a pixel.
pub(super) const UNIT: i64 = 256;
/// Where the image begins, at -0.5 pixels.
const LOW: i64 = -UNIT / 2;

/// A point in 1/256 pixel.
pub(super) type Point = (i64, i64);

/// The constrained Gabriel graph of an image rectangle.
pub(super) struct Graph {
    pub(super) points: Vec<Point>,
    pub(super) triangulation: Triangulation,
    /// What became of each edge of the triangulation.
    pub(super) kinds: Vec<EdgeKind>,
    /// The face of each triangle.
    face: Vec<u32>,
    /// Number of faces, at least 1.
    pub(super) num_faces: usize,
}

/// An edge of the graph between two faces.
pub(super) struct Side {
    /// Its number among the edges of the triangulation.
    pub(super) edge: usize,
    pub(super) faces: [u32; 2],
}

impl Graph {
    /// The graph of `segments` in an image of `width × height` pixels, with points on its frame at most `frame_step`
    /// apart.
    pub(super) fn new(segments: &Segments, width: usize, height: usize, frame_step: f32) -> Self {
        let corner = (width as i64 * UNIT - UNIT / 2, height as i64 * UNIT - UNIT / 2);
        let mut points: Vec<Point> =
            segments.points.iter().map(|&(x, y)| (settle(x, corner.0), settle(y, corner.1))).collect();
        let in_range = |&(a, b): &(u32, u32)| (a.max(b) as usize) < segments.points.len();
        let lines: Vec<(u32, u32)> = segments.lines.iter().copied().filter(in_range).collect();
        add_frame(&mut points, corner, f64::from(frame_step));
        let places: Vec<(f32, f32)> = points.iter().map(|&(x, y)| (to_pixels(x), to_pixels(y))).collect();
        let triangulation = constrained_delaunay(&places, &lines);
        let kinds: Vec<EdgeKind> = triangulation.edges.iter().map(|e| kind(e, &triangulation, &points)).collect();
        let (face, num_faces) = faces(&triangulation, &kinds);
        Self { points, triangulation, kinds, face, num_faces }
    }

    /// Ends in pixels and kind of each edge of the triangulation.
    pub(super) fn edges(&self) -> impl Iterator<Item = Edge> {
        let place = |i: u32| {
            let (x, y) = self.points[i as usize];
            (to_pixels(x), to_pixels(y))
        };
        self.triangulation.edges.iter().zip(&self.kinds).map(move |(edge, &kind)| Edge {
            from: place(edge.ends[0]),
            to: place(edge.ends[1]),
            kind,
        })
    }

    /// The edges that separate two faces.
    pub(super) fn sides(&self) -> Vec<Side> {
        let mut sides = Vec::new();
        for (index, edge) in self.triangulation.edges.iter().enumerate() {
            if let [Some(s), Some(t)] = edge.triangles {
                let faces = [s, t].map(|t| self.face[t as usize]);
                if faces[0] != faces[1] {
                    sides.push(Side { edge: index, faces });
                }
            }
        }
        sides
    }

    /// The face of each pixel: that in which its centre lies, or of those that meet there the one to the right, or
    /// below.
    pub(super) fn raster(&self, width: usize, height: usize) -> Plane<u32> {
        let mut label = Plane::filled(width, height, 0);
        for (triangle, &face) in self.triangulation.triangles.iter().zip(&self.face) {
            self.fill(triangle.map(|i| self.points[i as usize]), face, &mut label);
        }
        label
    }

    /// Top-left rule: of the rows from the top corner (included) to the bottom one (excluded), the pixels from the left
    /// side (included) to the right one (excluded). Neighbouring triangles compute the same bound for their common
    /// side.
    fn fill(&self, corners: [Point; 3], face: u32, label: &mut Plane<u32>) {
        let mut c = corners;
        sort_by_key(&mut c, |&(x, y)| pair(signed(y as i32), signed(x as i32)));
        let [top, middle, bottom] = c;
        for y in rows(top.1, middle.1) {
            span(label.row_mut(y as usize), bound(top, middle, y), bound(top, bottom, y), face);
        }
        for y in rows(middle.1, bottom.1) {
            span(label.row_mut(y as usize), bound(middle, bottom, y), bound(top, bottom, y), face);
        }
    }
}

/// The whole pixel rows from `begin` (included) to `end` (excluded).
fn rows(begin: i64, end: i64) -> std::ops::Range<i64> {
    ceil_div(begin, UNIT)..ceil_div(end, UNIT)
}

/// The first pixel of row `y` at or right of the line through `a` and `b`, `a` above `b`.
fn bound(a: Point, b: Point, y: i64) -> i64 {
    let height = b.1 - a.1;
    ceil_div(a.0 * height + (y * UNIT - a.1) * (b.0 - a.0), height * UNIT)
}

fn ceil_div(a: i64, b: i64) -> i64 {
    -(-a).div_euclid(b)
}

fn span(row: &mut [u32], one: i64, other: i64, face: u32) {
    row[one.min(other) as usize..one.max(other) as usize].fill(face);
}

/// A coordinate in units, inside the image.
fn settle(coordinate: f32, corner: i64) -> i64 {
    let units = (f64::from(coordinate) * UNIT as f64 + 0.5).floor() as i64;
    units.clamp(LOW, corner)
}

fn to_pixels(units: i64) -> f32 {
    units as f32 / UNIT as f32
}

/// Adds the corners of the image, and points on its border where the next one is farther than `step` pixels.
fn add_frame(points: &mut Vec<Point>, corner: Point, step: f64) {
    // No more than a point for each pixel of the border.
    let step = if step > 0.0 { (step.max(1.0) * UNIT as f64) as i64 } else { i64::MAX };
    for x in [LOW, corner.0] {
        let on_side = points.iter().filter(|p| p.0 == x).map(|p| p.1).collect();
        points.extend(stops(on_side, corner.1, step).map(|y| (x, y)));
    }
    for y in [LOW, corner.1] {
        let on_side = points.iter().filter(|p| p.1 == y).map(|p| p.0).collect();
        points.extend(stops(on_side, corner.0, step).map(|x| (x, y)));
    }
}

/// Both ends of a side, and what must be added to those already on it so that no gap is wider than `step`.
fn stops(mut on_side: Vec<i64>, end: i64, step: i64) -> impl Iterator<Item = i64> {
    on_side.extend([LOW, end]);
    sort_by_key(&mut on_side, |&v| signed(v as i32).into());
    let gaps: Vec<(i64, i64)> = on_side.windows(2).map(|pair| (pair[0], pair[1] - pair[0])).collect();
    let between = gaps.into_iter().flat_map(move |(begin, gap)| {
        let pieces = ceil_div(gap, step);
        (1..pieces).map(move |i| begin + gap * i / pieces)
    });
    between.chain([LOW, end])
}

/// Deletes what is neither given nor has the Gabriel property. An edge loses it to the third corner of a triangle
/// beside it inside the circle around it: one that sees it under an obtuse angle. If neither corner does, no point that
/// sees the edge does.
fn kind(edge: &TriangulationEdge, triangulation: &Triangulation, points: &[Point]) -> EdgeKind {
    let [Some(s), Some(t)] = edge.triangles else {
        return EdgeKind::Frame;
    };
    if edge.constraint {
        return EdgeKind::Constraint;
    }
    let [a, b] = edge.ends.map(|i| points[i as usize]);
    let obtuse = |t: u32| {
        triangulation.triangles[t as usize].iter().filter(|i| !edge.ends.contains(i)).any(|&i| {
            let c = points[i as usize];
            (a.0 - c.0) * (b.0 - c.0) + (a.1 - c.1) * (b.1 - c.1) < 0
        })
    };
    if obtuse(s) || obtuse(t) { EdgeKind::Deleted } else { EdgeKind::Gabriel }
}

/// The face of each triangle, and their number: triangles with a deleted edge between them are in one.
fn faces(triangulation: &Triangulation, kinds: &[EdgeKind]) -> (Vec<u32>, usize) {
    let mut sets = Sets::new(triangulation.triangles.len());
    for (edge, &kind) in triangulation.edges.iter().zip(kinds) {
        if let ([Some(s), Some(t)], EdgeKind::Deleted) = (edge.triangles, kind) {
            sets.join(s, t);
        }
    }
    let mut number = vec![u32::MAX; triangulation.triangles.len()];
    let mut count = 0;
    let mut face = Vec::with_capacity(number.len());
    for t in 0..number.len() as u32 {
        let root = sets.find(t) as usize;
        if number[root] == u32::MAX {
            number[root] = count;
            count += 1;
        }
        face.push(number[root]);
    }
    (face, (count as usize).max(1))
}

/// Disjoint sets.
pub(super) struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    pub(super) fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    /// The member that stands for the set of `i`.
    pub(super) fn find(&mut self, mut i: u32) -> u32 {
        while self.parent[i as usize] != i {
            let above = self.parent[self.parent[i as usize] as usize];
            self.parent[i as usize] = above;
            i = above;
        }
        i
    }

    /// Joins two sets; the second's member stands for both.
    pub(super) fn join(&mut self, i: u32, j: u32) {
        let (i, j) = (self.find(i), self.find(j));
        self.parent[i as usize] = j;
    }
}
