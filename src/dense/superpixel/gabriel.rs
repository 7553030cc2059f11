//! Constrained Gabriel graph: its faces, their pixels, and merging of faces.
//!
//! Points are rounded to 1/256 pixel and all decisions are made in integers, so that they are exact and the same
//! everywhere.

use crate::contour::Segments;
use crate::delaunay::{Triangulation, TriangulationEdge, constrained_delaunay};
use crate::image::Plane;
use crate::order::{i32_key, pair_key, sort_by_key};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Kind of an edge of the constrained Delaunay triangulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum EdgeKind {
    /// A piece of a contour.
    Constraint,
    /// A piece of the image frame.
    Frame,
    /// A Delaunay edge with the Gabriel property: it bridges a gap.
    Gabriel,
    /// A Delaunay edge without that property, or an edge between merged superpixels.
    Deleted,
}

/// An edge of the triangulation that the superpixels come from, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// One end.
    pub from: (f32, f32),
    /// The other end.
    pub to: (f32, f32),
    /// Its kind.
    pub kind: EdgeKind,
}

/// Units in a pixel.
pub(super) const UNITS_PER_PX: i64 = 256;
/// Left and upper border of the image, at -0.5 pixels.
const LOW: i64 = -UNITS_PER_PX / 2;

/// A point in 1/256 pixel.
pub(super) type Point = (i64, i64);

/// The constrained Gabriel graph of an image rectangle.
pub(super) struct Graph {
    pub(super) points: Vec<Point>,
    pub(super) triangulation: Triangulation,
    /// Kind of each edge of the triangulation.
    pub(super) kinds: Vec<EdgeKind>,
    /// The face of each triangle.
    face: Vec<u32>,
    /// Number of faces, at least 1.
    pub(super) num_faces: usize,
}

/// An edge of the graph between two faces.
pub(super) struct Side {
    /// Its index among the edges of the triangulation.
    pub(super) edge: usize,
    pub(super) faces: [u32; 2],
}

impl Graph {
    /// Builds the graph of `segments` in an image of `width × height` pixels, with points on its border at most
    /// `frame_step` apart.
    pub(super) fn new(segments: &Segments, width: usize, height: usize, frame_step: f32) -> Self {
        let corner = (width as i64 * UNITS_PER_PX - UNITS_PER_PX / 2, height as i64 * UNITS_PER_PX - UNITS_PER_PX / 2);
        let mut points: Vec<Point> =
            segments.points.iter().map(|&(x, y)| (to_units(x, corner.0), to_units(y, corner.1))).collect();
        let in_range = |&(a, b): &(u32, u32)| (a.max(b) as usize) < segments.points.len();
        let lines: Vec<(u32, u32)> = segments.lines.iter().copied().filter(in_range).collect();
        add_frame(&mut points, corner, f64::from(frame_step));
        let pixels: Vec<(f32, f32)> = points.iter().map(|&(x, y)| (to_pixels(x), to_pixels(y))).collect();
        let triangulation = constrained_delaunay(&pixels, &lines);
        let kinds: Vec<EdgeKind> = triangulation.edges.iter().map(|e| edge_kind(e, &triangulation, &points)).collect();
        let (face, num_faces) = number_faces(&triangulation, &kinds);
        Self { points, triangulation, kinds, face, num_faces }
    }

    /// Ends in pixels and kind of each edge of the triangulation.
    pub(super) fn edges(&self) -> impl Iterator<Item = Edge> {
        let point = |i: u32| {
            let (x, y) = self.points[i as usize];
            (to_pixels(x), to_pixels(y))
        };
        self.triangulation.edges.iter().zip(&self.kinds).map(move |(edge, &kind)| Edge {
            from: point(edge.ends[0]),
            to: point(edge.ends[1]),
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

    /// Rasterises the faces by pixel centres, with ties to the right and below.
    pub(super) fn raster(&self, width: usize, height: usize) -> Plane<u32> {
        let mut label = Plane::filled(width, height, 0);
        for (triangle, &face) in self.triangulation.triangles.iter().zip(&self.face) {
            self.fill(triangle.map(|i| self.points[i as usize]), face, &mut label);
        }
        label
    }

    /// Fills a triangle by the top-left rule: rows from the top corner (included) to the bottom one (excluded), pixels from
    /// the left side (included) to the right one (excluded). Neighbours compute the same bound for their common side.
    fn fill(&self, corners: [Point; 3], face: u32, label: &mut Plane<u32>) {
        let mut c = corners;
        sort_by_key(&mut c, |&(x, y)| pair_key(i32_key(y as i32), i32_key(x as i32)));
        let [top, middle, bottom] = c;
        for y in pixel_rows(top.1, middle.1) {
            fill_span(label.row_mut(y as usize), first_pixel(top, middle, y), first_pixel(top, bottom, y), face);
        }
        for y in pixel_rows(middle.1, bottom.1) {
            fill_span(label.row_mut(y as usize), first_pixel(middle, bottom, y), first_pixel(top, bottom, y), face);
        }
    }
}

/// Pixel rows from `begin` (included) to `end` (excluded), in units.
fn pixel_rows(begin: i64, end: i64) -> std::ops::Range<i64> {
    ceil_div(begin, UNITS_PER_PX)..ceil_div(end, UNITS_PER_PX)
}

/// The first pixel of row `y` at or right of the line through `a` and `b`, `a` above `b`.
fn first_pixel(a: Point, b: Point, y: i64) -> i64 {
    let height = b.1 - a.1;
    ceil_div(a.0 * height + (y * UNITS_PER_PX - a.1) * (b.0 - a.0), height * UNITS_PER_PX)
}

fn ceil_div(a: i64, b: i64) -> i64 {
    -(-a).div_euclid(b)
}

/// Fills the pixels between two bounds, in either order.
fn fill_span(row: &mut [u32], a: i64, b: i64, face: u32) {
    row[a.min(b) as usize..a.max(b) as usize].fill(face);
}

/// Converts a coordinate to units, clamped to the image.
fn to_units(coordinate: f32, corner: i64) -> i64 {
    let units = (f64::from(coordinate) * UNITS_PER_PX as f64 + 0.5).floor() as i64;
    units.clamp(LOW, corner)
}

fn to_pixels(units: i64) -> f32 {
    units as f32 / UNITS_PER_PX as f32
}

/// Adds the corners of the image, and points on its border so that neighbours are at most `step` pixels apart.
fn add_frame(points: &mut Vec<Point>, corner: Point, step: f64) {
    // At most a point for each pixel of the border.
    let step = if step > 0.0 { (step.max(1.0) * UNITS_PER_PX as f64) as i64 } else { i64::MAX };
    for x in [LOW, corner.0] {
        let on_side = points.iter().filter(|p| p.0 == x).map(|p| p.1).collect();
        points.extend(missing_points(on_side, corner.1, step).map(|y| (x, y)));
    }
    for y in [LOW, corner.1] {
        let on_side = points.iter().filter(|p| p.1 == y).map(|p| p.0).collect();
        points.extend(missing_points(on_side, corner.0, step).map(|x| (x, y)));
    }
}

/// Both ends of a side, and the points that are missing on it for gaps of at most `step`.
fn missing_points(mut on_side: Vec<i64>, end: i64, step: i64) -> impl Iterator<Item = i64> {
    on_side.extend([LOW, end]);
    sort_by_key(&mut on_side, |&v| i32_key(v as i32).into());
    let gaps: Vec<(i64, i64)> = on_side.windows(2).map(|pair| (pair[0], pair[1] - pair[0])).collect();
    let between = gaps.into_iter().flat_map(move |(begin, gap)| {
        let num_intervals = ceil_div(gap, step);
        (1..num_intervals).map(move |i| begin + gap * i / num_intervals)
    });
    between.chain([LOW, end])
}

/// Classifies an edge. It lacks the Gabriel property if the third corner of an adjacent triangle lies inside its diametral
/// circle, which sees it under an obtuse angle. If neither corner does, no point that sees the edge does.
fn edge_kind(edge: &TriangulationEdge, triangulation: &Triangulation, points: &[Point]) -> EdgeKind {
    let [Some(s), Some(t)] = edge.triangles else {
        return EdgeKind::Frame;
    };
    if edge.is_constraint {
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

/// Numbers the faces: triangles with a deleted edge between them are in one. Returns the face of each triangle, and the number
/// of faces.
fn number_faces(triangulation: &Triangulation, kinds: &[EdgeKind]) -> (Vec<u32>, usize) {
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
struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    /// Returns the representative of the set of `i`.
    fn find(&mut self, mut i: u32) -> u32 {
        while self.parent[i as usize] != i {
            let above = self.parent[self.parent[i as usize] as usize];
            self.parent[i as usize] = above;
            i = above;
        }
        i
    }

    /// Joins two sets under the representative of the second.
    fn join(&mut self, i: u32, j: u32) {
        let (i, j) = (self.find(i), self.find(j));
        self.parent[i as usize] = j;
    }
}

// Merging regions across weak borders.

/// Border of a region to a neighbour.
#[derive(Clone, Copy)]
struct RegionLink {
    to: u32,
    length: f32,
    /// Pb, summed over the length.
    strength: f32,
}

/// Regions and their borders.
pub(super) struct Regions {
    sets: Sets,
    area: Vec<u32>,
    /// The links of each region, sorted by `to`; empty for merged regions.
    links: Vec<Vec<RegionLink>>,
    count: usize,
}

impl Regions {
    /// Starts with one region for each face. `lengths_and_pb` has the length and mean Pb of each side.
    pub(super) fn new(area: Vec<u32>, sides: &[Side], lengths_and_pb: &[(f32, f32)]) -> Self {
        let mut links = vec![Vec::new(); area.len()];
        for (side, &(length, pb)) in sides.iter().zip(lengths_and_pb) {
            let [a, b] = side.faces;
            for (from, to) in [(a, b), (b, a)] {
                add_link(&mut links[from as usize], RegionLink { to, length, strength: length * pb });
            }
        }
        Self { sets: Sets::new(area.len()), count: area.len(), area, links }
    }

    /// Returns the current region of `face`, by the number of one of its faces.
    pub(super) fn find(&mut self, face: u32) -> u32 {
        self.sets.find(face)
    }

    /// Merges every region without a pixel with its neighbour across the weakest border.
    pub(super) fn merge_empty(&mut self) {
        let empty: Vec<u32> = (0..self.area.len() as u32).filter(|&r| self.area[r as usize] == 0).collect();
        for r in empty {
            let mut region = self.sets.find(r);
            while self.area[region as usize] == 0 {
                let weakest = self.links[region as usize]
                    .iter()
                    .min_by(|p, q| (p.strength * q.length).total_cmp(&(q.strength * p.length)).then(p.to.cmp(&q.to)));
                let Some(&RegionLink { to, .. }) = weakest else { break };
                region = self.merge(region, to);
            }
        }
    }

    /// Repeatedly merges the two regions of least cost, until at most `count` remain and no cost is below `min_cost`.
    pub(super) fn merge_weak(&mut self, count: usize, min_cost: f32) {
        let mut heap = BinaryHeap::new();
        for region in 0..self.links.len() as u32 {
            for link in self.links[region as usize].iter().filter(|l| region < l.to) {
                heap.push(Reverse((self.cost(region, link), region, link.to)));
            }
        }
        while let Some(Reverse((cost, a, b))) = heap.pop() {
            if self.count <= count.max(1) && f32::from_bits(cost) >= min_cost {
                return;
            }
            // The border may have changed since.
            let links = &self.links[a as usize];
            let is_current = links.binary_search_by_key(&b, |l| l.to).is_ok_and(|k| self.cost(a, &links[k]) == cost);
            if is_current {
                let region = self.merge(a, b);
                for link in &self.links[region as usize] {
                    heap.push(Reverse((self.cost(region, link), region.min(link.to), region.max(link.to))));
                }
            }
        }
    }

    /// Cost of merging a region with its neighbour at a link, as an integer of the same order. As in Ward's clustering
    /// ("Hierarchical Grouping to Optimize an Objective Function", 1963) the areas count, so that no region stays very
    /// small; the mean Pb replaces the squared difference of the means.
    fn cost(&self, region: u32, link: &RegionLink) -> u32 {
        let [p, q] = [region, link.to].map(|r| self.area[r as usize] as f32);
        // Bits of positive floats are ordered as the floats. Strengths are summed in the same order in both regions' links,
        // so that both have the same cost.
        (link.strength / link.length * (p * q / (p + q))).to_bits()
    }

    /// Merges two regions, the one with fewer links into the other. Returns the number of the result.
    fn merge(&mut self, a: u32, b: u32) -> u32 {
        let (from, into) = if self.links[a as usize].len() < self.links[b as usize].len() { (a, b) } else { (b, a) };
        for link in std::mem::take(&mut self.links[from as usize]) {
            let neighbour_links = &mut self.links[link.to as usize];
            if let Ok(k) = neighbour_links.binary_search_by_key(&from, |l| l.to) {
                neighbour_links.remove(k);
            }
            if link.to != into {
                add_link(neighbour_links, RegionLink { to: into, ..link });
                add_link(&mut self.links[into as usize], link);
            }
        }
        self.area[into as usize] += self.area[from as usize];
        self.sets.join(from, into);
        self.count -= 1;
        into
    }
}

/// Adds a link to sorted ones, to one of the same region if there is one.
fn add_link(links: &mut Vec<RegionLink>, link: RegionLink) {
    match links.binary_search_by_key(&link.to, |l| l.to) {
        Ok(k) => {
            links[k].length += link.length;
            links[k].strength += link.strength;
        }
        Err(k) => links.insert(k, link),
    }
}
