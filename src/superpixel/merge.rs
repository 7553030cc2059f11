//! Joining faces across weak borders: very small ones, and as many more as a wanted number of superpixels asks for.

use super::gabriel::{Sets, Side};
use crate::order::sort_by_key;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

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
                links[from as usize].push(Link { to, length, strength: length * pb });
            }
        }
        links.iter_mut().for_each(gather);
        Self { sets: Sets::new(area.len()), count: area.len(), area, links }
    }

    /// The region that `face` is in now, by the number of one of its faces.
    pub(super) fn find(&mut self, face: u32) -> u32 {
        self.sets.find(face)
    }

    /// Joins every region of fewer than `min_pixels` pixels, the smallest first, with the one behind its weakest border.
    pub(super) fn join_small(&mut self, min_pixels: u32) {
        let mut order: Vec<u32> = (0..self.area.len() as u32).filter(|&r| self.area[r as usize] < min_pixels).collect();
        sort_by_key(&mut order, |&r| self.area[r as usize].into());
        for r in order {
            let mut region = self.sets.find(r);
            while self.area[region as usize] < min_pixels {
                let weakest = self.links[region as usize]
                    .iter()
                    .min_by(|p, q| (p.strength * q.length).total_cmp(&(q.strength * p.length)).then(p.to.cmp(&q.to)));
                let Some(&Link { to, .. }) = weakest else { break };
                region = self.join(region, to);
            }
        }
    }

    /// Joins the two regions with the least cost again and again until `count` are left.
    pub(super) fn reduce_to(&mut self, count: usize) {
        let mut heap = BinaryHeap::new();
        for region in 0..self.links.len() as u32 {
            self.offer(region, &mut heap);
        }
        while self.count > count.max(1) {
            let Some(Reverse((cost, a, b))) = heap.pop() else { return };
            // A cost that is no longer true belongs to a border that has changed since.
            if self.cost(a, b) == Some(cost) {
                let joined = self.join(a, b);
                self.offer(joined, &mut heap);
            }
        }
    }

    fn offer(&self, region: u32, heap: &mut BinaryHeap<Reverse<(u32, u32, u32)>>) {
        for link in &self.links[region as usize] {
            let (a, b) = (region.min(link.to), region.max(link.to));
            if let Some(cost) = self.cost(a, b) {
                heap.push(Reverse((cost, a, b)));
            }
        }
    }

    /// What joining `a` and `b` costs, as a number with the order of the costs; `None` if they are not beside each other.
    fn cost(&self, a: u32, b: u32) -> Option<u32> {
        let links = &self.links[a as usize];
        let link = links[links.binary_search_by_key(&b, |l| l.to).ok()?];
        let smaller = self.area[a as usize].min(self.area[b as usize]) as f32;
        // Bits of positive floats are ordered as the floats are.
        Some((link.strength / link.length * smaller.sqrt()).to_bits())
    }

    /// Makes one region of two; returns its number.
    fn join(&mut self, a: u32, b: u32) -> u32 {
        let (gone, kept) = if self.links[a as usize].len() < self.links[b as usize].len() { (a, b) } else { (b, a) };
        let moved = std::mem::take(&mut self.links[gone as usize]);
        for link in &moved {
            let beside = &mut self.links[link.to as usize];
            beside.retain(|l| l.to != gone);
            if link.to != kept {
                beside.push(Link { to: kept, ..*link });
                gather(beside);
            }
        }
        let own = &mut self.links[kept as usize];
        own.extend(moved.into_iter().filter(|l| l.to != kept));
        gather(own);
        self.area[kept as usize] += self.area[gone as usize];
        self.sets.join(gone, kept);
        self.count -= 1;
        kept
    }
}

/// Sorts links and makes one of those to the same region.
fn gather(links: &mut Vec<Link>) {
    sort_by_key(links, |l| l.to.into());
    links.dedup_by(|next, first| {
        let same = next.to == first.to;
        if same {
            first.length += next.length;
            first.strength += next.strength;
        }
        same
    });
}
