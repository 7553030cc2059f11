//! From thin ridges of Pb to chains of pixels.
//!
//! 1. Hysteresis: pixels above `low` that hang together with one above `high` (Canny 1986).
//! 2. Thinning to lines one pixel wide: pixels whose removal changes no connection go, weakest first.
//! 3. Welding: gaps of one pixel at the end of a line are filled, and ends near the image border run straight into it.
//! 4. Tracing: lines are broken at junctions into chains; short ones with a free end are dropped, and what remains is
//!    traced again.
//!
//! Two pixels are linked if they share a side, or a corner beside which no other pixel of a line lies. Chains are walks
//! over such links, so that no two of them cross.

use crate::image::Plane;
use crate::order;

/// An end at most this far from the image border, in pixels, is run into it; boundary maps fade out there.
const BORDER: usize = 4;

/// The eight neighbours, anticlockwise from the right; even ones share a side.
const AROUND: [(isize, isize); 8] = [(1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1), (0, 1), (1, 1)];

/// Chains of points, each beside the one before it.
///
/// Law: chain `c` is `points[offset[c]..offset[c + 1]]` and has at least two points; a closed one ends where it begins.
#[derive(Debug)]
pub(super) struct Chains {
    /// In half pixels, so that the image border at -0.5 has whole coordinates too.
    pub(super) points: Vec<(i32, i32)>,
    pub(super) offset: Vec<usize>,
}

/// The chains of `thin`: pixels above `low` connected with one above `high`; those of fewer than `min_chain` pixels
/// with a free end are left out.
pub(super) fn link(thin: &Plane<f32>, low: f32, high: f32, min_chain: usize) -> Chains {
    let mut lines = Lines::above(thin, low, high);
    lines.thin();
    lines.weld();
    lines.reach_border();
    lines.thin();
    for short in lines.trace(min_chain).1 {
        lines.on[short] = false;
    }
    lines.trace(min_chain).0
}

/// Which pixels lie on a line, with a margin of one pixel around the image.
struct Lines {
    on: Vec<bool>,
    /// Pb where it is above `low`, as numbers of the same order; 0 elsewhere.
    strength: Vec<u32>,
    width: usize,
    height: usize,
    stride: usize,
}

impl Lines {
    /// 1. Hysteresis.
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
        let (dx, dy) = AROUND[k % 8];
        p.wrapping_add_signed(dy * self.stride as isize + dx)
    }

    /// Column and row; beyond the image for the margin.
    fn place(&self, p: usize) -> (usize, usize) {
        ((p % self.stride).wrapping_sub(1), (p / self.stride).wrapping_sub(1))
    }

    fn all(&self) -> Vec<usize> {
        (0..self.on.len()).filter(|&p| self.on[p]).collect()
    }

    /// Which neighbours lie on a line, a bit each.
    fn ring(&self, p: usize) -> u8 {
        (0..8).fold(0, |bits, k| bits | u8::from(self.on[self.neighbour(p, k)]) << k)
    }

    /// Which neighbours `p` is linked with, a bit each.
    fn links(&self, p: usize) -> u8 {
        let ring = self.ring(p);
        let sides = ring & 0b0101_0101;
        ring & !(sides.rotate_left(1) | sides.rotate_right(1))
    }

    /// 2. Thinning. A pass looks at the pixels beside those that the pass before removed.
    fn thin(&mut self) {
        let mut pass = self.all();
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

    /// 3. Fills the pixel between an end and another line two pixels away.
    fn weld(&mut self) {
        for p in self.all() {
            let ring = self.ring(p);
            if ring.count_ones() != 1 {
                continue;
            }
            let back = ring.trailing_zeros() as usize;
            // Straight on first, then ever more to the side.
            for turn in [4, 3, 5, 2, 6] {
                let q = self.neighbour(p, back + turn);
                let (x, y) = self.place(q);
                if x >= self.width || y >= self.height {
                    continue;
                }
                let touches = (0..8).map(|k| self.neighbour(q, k)).any(|r| r != p && self.on[r] && !self.beside(r, p));
                if touches {
                    self.on[q] = true;
                    break;
                }
            }
        }
    }

    fn beside(&self, p: usize, q: usize) -> bool {
        (0..8).any(|k| self.neighbour(p, k) == q)
    }

    /// 3. Runs ends near the border straight into it.
    fn reach_border(&mut self) {
        for p in self.all() {
            if self.ring(p).count_ones() > 1 {
                continue;
            }
            let (distance, k) = self.to_border(p);
            let path: Vec<usize> = (1..=distance).map(|i| self.ahead(p, k, i)).collect();
            if distance <= BORDER && !path.iter().any(|&q| self.on[q]) {
                for q in path {
                    self.on[q] = true;
                }
            }
        }
    }

    fn ahead(&self, p: usize, k: usize, steps: usize) -> usize {
        (0..steps).fold(p, |q, _| self.neighbour(q, k))
    }

    /// Steps to the nearest pixel on the image border, and which way.
    fn to_border(&self, p: usize) -> (usize, usize) {
        let (x, y) = self.place(p);
        let ways = [(x, 4), (y, 2), (self.width - 1 - x, 0), (self.height - 1 - y, 6)];
        ways.into_iter().min().unwrap_or_default()
    }

    /// 4. The chains, and the pixels that only short ones with a free end have.
    fn trace(&self, min_chain: usize) -> (Chains, Vec<usize>) {
        let pixels = self.all();
        let mut links = vec![0_u8; self.on.len()];
        for &p in &pixels {
            links[p] = self.links(p);
        }
        // Links not yet walked over.
        let mut open = links.clone();
        let is_node = |p: usize| links[p].count_ones() != 2;
        let mut chains = Chains { points: Vec::new(), offset: vec![0] };
        let mut short = Vec::new();
        let (nodes, others): (Vec<usize>, Vec<usize>) = pixels.iter().partition(|&&p| is_node(p));
        for &start in nodes.iter().chain(&others) {
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

    /// From `start` over open links to the next junction, end, or back.
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
            let (x, y) = self.place(p);
            (2 * x as i32, 2 * y as i32)
        };
        let (first, last) = (walk[0], walk[walk.len() - 1]);
        chains.points.extend(self.outside(first));
        chains.points.extend(walk.iter().map(|&p| point(p)));
        chains.points.extend(self.outside(last));
        chains.offset.push(chains.points.len());
    }

    /// The point on the image border beside the end `p` of a line.
    fn outside(&self, p: usize) -> Option<(i32, i32)> {
        let (distance, k) = self.to_border(p);
        let (x, y) = self.place(p);
        let (dx, dy) = AROUND[k];
        let is_end = distance == 0 && self.links(p).count_ones() == 1;
        is_end.then_some((2 * x as i32 + dx as i32, 2 * y as i32 + dy as i32))
    }
}

/// How many separate runs of line pixels the pixel joins (Yokoi's connectivity number for eight neighbours).
fn connections(ring: u8) -> u32 {
    let off = !ring;
    let sides = off & 0b0101_0101;
    (sides & !(off.rotate_right(1) & off.rotate_right(2))).count_ones()
}
