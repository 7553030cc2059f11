//! The constrained Gabriel graph: its faces, and the pixels in each.
//!
//! Points are rounded to 1/256 pixel and all decisions made in whole numbers, so that they are exact and everywhere the
//! same.

use crate::contour::Segments;
use crate::delaunay::{Triangulation, TriangulationEdge, constrained_delaunay};
use crate::image::Plane;
use crate::order::{i32_key, pair_key, sort_by_key};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

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
        sort_by_key(&mut c, |&(x, y)| pair_key(i32_key(y as i32), i32_key(x as i32)));
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
    sort_by_key(&mut on_side, |&v| i32_key(v as i32).into());
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
struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    /// The member that stands for the set of `i`.
    fn find(&mut self, mut i: u32) -> u32 {
        while self.parent[i as usize] != i {
            let above = self.parent[self.parent[i as usize] as usize];
            self.parent[i as usize] = above;
            i = above;
        }
        i
    }

    /// Joins two sets; the second's member stands for both.
    fn join(&mut self, i: u32, j: u32) {
        let (i, j) = (self.find(i), self.find(j));
        self.parent[i as usize] = j;
    }
}

// Joining regions across weak borders: those without a pixel, those hardly parted, and as many more as a wanted number asks for.

/// What is between a region and one beside it.
#[derive(Clone, Copy)]
struct Link {
    to: u32,
    length: f32,
    /// Pb, summed over the length.
    strength: f32,
}

/// Regions and their borders.
pub(super) struct Regions {
    sets: Sets,
    area: Vec<u32>,
    /// The links of each region, sorted by `to`; empty for one that has become part of another.
    links: Vec<Vec<Link>>,
    count: usize,
}

impl Regions {
    /// One region for each face. `sides` lie between them; `measure` gives length and mean Pb of each.
    pub(super) fn new(area: Vec<u32>, sides: &[Side], measure: &[(f32, f32)]) -> Self {
        let mut links = vec![Vec::new(); area.len()];
        for (side, &(length, pb)) in sides.iter().zip(measure) {
            let [a, b] = side.faces;
            for (from, to) in [(a, b), (b, a)] {
                add(&mut links[from as usize], Link { to, length, strength: length * pb });
            }
        }
        Self { sets: Sets::new(area.len()), count: area.len(), area, links }
    }

    /// The region that `face` is in now, by the number of one of its faces.
    pub(super) fn find(&mut self, face: u32) -> u32 {
        self.sets.find(face)
    }

    /// Joins every region without a pixel with the one behind its weakest border.
    pub(super) fn join_empty(&mut self) {
        let empty: Vec<u32> = (0..self.area.len() as u32).filter(|&r| self.area[r as usize] == 0).collect();
        for r in empty {
            let mut region = self.sets.find(r);
            while self.area[region as usize] == 0 {
                let weakest = self.links[region as usize]
                    .iter()
                    .min_by(|p, q| (p.strength * q.length).total_cmp(&(q.strength * p.length)).then(p.to.cmp(&q.to)));
                let Some(&Link { to, .. }) = weakest else { break };
                region = self.join(region, to);
            }
        }
    }

    /// Joins the two regions with the least cost again and again, until `count` are left and no cost is below `enough`.
    pub(super) fn join_weak(&mut self, count: usize, enough: f32) {
        let mut heap = BinaryHeap::new();
        for region in 0..self.links.len() as u32 {
            for link in self.links[region as usize].iter().filter(|l| region < l.to) {
                heap.push(Reverse((self.cost(region, link), region, link.to)));
            }
        }
        while let Some(Reverse((cost, a, b))) = heap.pop() {
            if self.count <= count.max(1) && f32::from_bits(cost) >= enough {
                return;
            }
            // A cost that is no longer true belongs to a border that has changed since.
            let links = &self.links[a as usize];
            let still = links.binary_search_by_key(&b, |l| l.to).is_ok_and(|at| self.cost(a, &links[at]) == cost);
            if still {
                let joined = self.join(a, b);
                for link in &self.links[joined as usize] {
                    heap.push(Reverse((self.cost(joined, link), joined.min(link.to), joined.max(link.to))));
                }
            }
        }
    }

    /// What joining a region with the region of a link costs, as a number with the order of the costs. As in Ward's
    /// clustering ("Hierarchical Grouping to Optimize an Objective Function", 1963) the areas count, so that none is
    /// left very small; the mean Pb between them stands for the squared difference of their means.
    fn cost(&self, region: u32, link: &Link) -> u32 {
        let [p, q] = [region, link.to].map(|r| self.area[r as usize] as f32);
        // Bits of positive floats are ordered as the floats are. The strength is summed in the same order in both
        // regions' links, so that both give the same cost.
        (link.strength / link.length * (p * q / (p + q))).to_bits()
    }

    /// Makes one region of two; returns its number.
    fn join(&mut self, a: u32, b: u32) -> u32 {
        let (gone, kept) = if self.links[a as usize].len() < self.links[b as usize].len() { (a, b) } else { (b, a) };
        let moved = std::mem::take(&mut self.links[gone as usize]);
        for link in moved {
            let beside = &mut self.links[link.to as usize];
            if let Ok(at) = beside.binary_search_by_key(&gone, |l| l.to) {
                beside.remove(at);
            }
            if link.to != kept {
                add(beside, Link { to: kept, ..link });
                add(&mut self.links[kept as usize], link);
            }
        }
        self.area[kept as usize] += self.area[gone as usize];
        self.sets.join(gone, kept);
        self.count -= 1;
        kept
    }
}

/// Adds a link to sorted ones, as part of one to the same region if there is one.
fn add(links: &mut Vec<Link>, link: Link) {
    match links.binary_search_by_key(&link.to, |l| l.to) {
        Ok(at) => {
            links[at].length += link.length;
            links[at].strength += link.strength;
        }
        Err(at) => links.insert(at, link),
    }
}
