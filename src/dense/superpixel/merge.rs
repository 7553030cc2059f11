//! Joining regions across weak borders: those without a pixel, those hardly parted, and as many more as a wanted number asks for.

use super::gabriel::{Sets, Side};
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
