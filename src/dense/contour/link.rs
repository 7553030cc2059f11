//! Edge linking: from thin ridges of Pb to chains of pixels.
//!
//! 1. Hysteresis: keeps pixels above `low` that are connected with one above `high` (Canny 1986).
//! 2. Thinning to lines one pixel wide: removes pixels that do not change the connectivity, weakest first.
//! 3. Gap closing: fills gaps of one pixel at the end of a line, and extends ends near the image border straight to it.
//! 4. Tracing: splits lines at junctions into chains; drops short ones with a free end, and traces the rest again.
//!
//! Two pixels are linked if they share a side, or a corner beside which no other pixel of a line lies. Chains are walks
//! over such links, so that no two of them cross. Cost: O(pixels of lines).

use crate::image::Plane;
use crate::order;

/// Largest distance at which the end of a line is extended to the image border: boundary maps fade out there. Chosen by eye.
const MAX_BORDER_GAP_PX: usize = 4;

/// Offsets of the eight neighbours, anticlockwise from the right; even ones share a side.
const NEIGHBOURS: [(isize, isize); 8] = [(1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1), (0, 1), (1, 1)];

/// Chains of neighbouring points.
///
/// Law: chain `c` is `points[offset[c]..offset[c + 1]]` and has at least two points; a closed one ends where it begins.
#[derive(Debug)]
pub(super) struct Chains {
    /// In half pixels, so that the image border at -0.5 has whole coordinates too.
    pub(super) points: Vec<(i32, i32)>,
    pub(super) offset: Vec<usize>,
}

/// Links the ridges of `thin` to chains. Chains of fewer than `min_chain` pixels with a free end are left out.
pub(super) fn link(thin: &Plane<f32>, low: f32, high: f32, min_chain: usize) -> Chains {
    let mut lines = LineMap::above(thin, low, high);
    lines.thin();
    lines.close_gaps();
    lines.extend_to_border();
    lines.thin();
    for short in lines.trace(min_chain).1 {
        lines.on[short] = false;
    }
    lines.trace(min_chain).0
}

/// Pixels that lie on a line, with a margin of one pixel around the image.
struct LineMap {
    on: Vec<bool>,
    /// Pb where it is above `low`, as numbers of the same order; 0 elsewhere.
    strength: Vec<u32>,
    width: usize,
    height: usize,
    stride: usize,
}

impl LineMap {
    /// Keeps pixels by hysteresis (step 1).
    fn above(thin: &Plane<f32>, low: f32, high: f32) -> Self {
        let (width, height) = (thin.width(), thin.height());
        let stride = width + 2;
        let mut strength = vec![0; stride * (height + 2)];
        let mut stack = Vec::new();
        for y in 0..height {
            let begin = (y + 1) * stride + 1;
            for (x, &value) in thin.row(y).iter().enumerate() {
                if value > low {
                    strength[begin + x] = order::f32_key(value);
                    if value > high {
                        stack.push(begin + x);
                    }
                }
            }
        }
        let mut lines = Self { on: vec![false; strength.len()], strength, width, height, stride };
        while let Some(p) = stack.pop() {
            if !lines.on[p] {
                lines.on[p] = true;
                stack.extend((0..8).map(|k| lines.neighbour(p, k)).filter(|&q| lines.strength[q] > 0 && !lines.on[q]));
            }
        }
        lines
    }

    fn neighbour(&self, p: usize, k: usize) -> usize {
        let (dx, dy) = NEIGHBOURS[k % 8];
        p.wrapping_add_signed(dy * self.stride as isize + dx)
    }

    /// Returns column and row, outside of the image for the margin.
    fn position(&self, p: usize) -> (usize, usize) {
        ((p % self.stride).wrapping_sub(1), (p / self.stride).wrapping_sub(1))
    }

    fn line_pixels(&self) -> Vec<usize> {
        (0..self.on.len()).filter(|&p| self.on[p]).collect()
    }

    /// Returns a bit for each neighbour that lies on a line.
    fn ring(&self, p: usize) -> u8 {
        (0..8).fold(0, |bits, k| bits | u8::from(self.on[self.neighbour(p, k)]) << k)
    }

    /// Returns a bit for each neighbour that `p` is linked with.
    fn links(&self, p: usize) -> u8 {
        let ring = self.ring(p);
        let sides = ring & 0b0101_0101;
        ring & !(sides.rotate_left(1) | sides.rotate_right(1))
    }

    /// Thins lines to one pixel (step 2). Each pass visits the neighbours of the pixels that the last one removed.
    fn thin(&mut self) {
        let mut pass = self.line_pixels();
        while !pass.is_empty() {
            order::sort_by_key(&mut pass, |&p| order::pair_key(self.strength[p], p as u32));
            pass.dedup();
            let mut next = Vec::new();
            for p in pass {
                let ring = self.ring(p);
                if self.on[p] && ring.count_ones() > 1 && connections(ring) == 1 {
                    self.on[p] = false;
                    next.extend((0..8).map(|k| self.neighbour(p, k)).filter(|&q| self.on[q]));
                }
            }
            pass = next;
        }
    }

    /// Fills the pixel between an end and another line two pixels away (step 3).
    fn close_gaps(&mut self) {
        for p in self.line_pixels() {
            let ring = self.ring(p);
            if ring.count_ones() != 1 {
                continue;
            }
            let back = ring.trailing_zeros() as usize;
            // Straight ahead first, then to the sides.
            for turn in [4, 3, 5, 2, 6] {
                let q = self.neighbour(p, back + turn);
                let (x, y) = self.position(q);
                if x >= self.width || y >= self.height {
                    continue;
                }
                let is_free = |r: usize| r != p && self.on[r] && !self.are_neighbours(r, p);
                let touches = (0..8).map(|k| self.neighbour(q, k)).any(is_free);
                if touches {
                    self.on[q] = true;
                    break;
                }
            }
        }
    }

    fn are_neighbours(&self, p: usize, q: usize) -> bool {
        (0..8).any(|k| self.neighbour(p, k) == q)
    }

    /// Extends ends near the border straight to it (step 3).
    fn extend_to_border(&mut self) {
        for p in self.line_pixels() {
            if self.ring(p).count_ones() > 1 {
                continue;
            }
            let (distance, k) = self.to_border(p);
            let path: Vec<usize> = std::iter::successors(Some(self.neighbour(p, k)), |&q| Some(self.neighbour(q, k)))
                .take(distance)
                .collect();
            if distance <= MAX_BORDER_GAP_PX && !path.iter().any(|&q| self.on[q]) {
                for q in path {
                    self.on[q] = true;
                }
            }
        }
    }

    /// Returns the distance to the nearest pixel on the image border, and the neighbour in its direction.
    fn to_border(&self, p: usize) -> (usize, usize) {
        let (x, y) = self.position(p);
        let sides = [(x, 4), (y, 2), (self.width - 1 - x, 0), (self.height - 1 - y, 6)];
        sides.into_iter().min().unwrap_or_default()
    }

    /// Traces the chains (step 4). Returns them, and the pixels of dropped short ones.
    fn trace(&self, min_chain: usize) -> (Chains, Vec<usize>) {
        let pixels = self.line_pixels();
        let mut links = vec![0_u8; self.on.len()];
        for &p in &pixels {
            links[p] = self.links(p);
        }
        // Links not yet walked over.
        let mut open = links.clone();
        let is_node = |p: usize| links[p].count_ones() != 2;
        let mut chains = Chains { points: Vec::new(), offset: vec![0] };
        let mut short = Vec::new();
        let (nodes, inner): (Vec<usize>, Vec<usize>) = pixels.iter().partition(|&&p| is_node(p));
        for &start in nodes.iter().chain(&inner) {
            while open[start] != 0 {
                let walk = self.walk(start, &mut open, &is_node);
                let (first, last) = (walk[0], walk[walk.len() - 1]);
                let free = |p: usize| links[p].count_ones() == 1 && self.to_border(p).0 > 0;
                let closed = first == last && !is_node(first);
                if walk.len() < min_chain && (free(first) || free(last) || closed) {
                    short.extend(walk.iter().filter(|&&p| links[p].count_ones() <= 2));
                } else {
                    self.push(&walk, &mut chains);
                }
            }
            if links[start] == 0 {
                short.push(start);
            }
        }
        (chains, short)
    }

    /// Walks from `start` over open links to the next junction, end, or back.
    fn walk(&self, start: usize, open: &mut [u8], is_node: &impl Fn(usize) -> bool) -> Vec<usize> {
        let mut walk = vec![start];
        let mut p = start;
        while open[p] != 0 {
            let k = open[p].trailing_zeros() as usize;
            let q = self.neighbour(p, k);
            open[p] &= !(1 << k);
            open[q] &= !(1 << ((k + 4) % 8));
            walk.push(q);
            p = q;
            if is_node(p) {
                break;
            }
        }
        walk
    }

    fn push(&self, walk: &[usize], chains: &mut Chains) {
        let point = |p: usize| {
            let (x, y) = self.position(p);
            (2 * x as i32, 2 * y as i32)
        };
        let (first, last) = (walk[0], walk[walk.len() - 1]);
        chains.points.extend(self.border_point(first));
        chains.points.extend(walk.iter().map(|&p| point(p)));
        chains.points.extend(self.border_point(last));
        chains.offset.push(chains.points.len());
    }

    /// Returns the point on the image border beside the end `p` of a line.
    fn border_point(&self, p: usize) -> Option<(i32, i32)> {
        let (distance, k) = self.to_border(p);
        let (x, y) = self.position(p);
        let (dx, dy) = NEIGHBOURS[k];
        let is_end = distance == 0 && self.links(p).count_ones() == 1;
        is_end.then_some((2 * x as i32 + dx as i32, 2 * y as i32 + dy as i32))
    }
}

/// Number of separate runs of line pixels around a pixel (Yokoi's connectivity number for eight neighbours).
fn connections(ring: u8) -> u32 {
    let off = !ring;
    let sides = off & 0b0101_0101;
    (sides & !(off.rotate_right(1) & off.rotate_right(2))).count_ones()
}
