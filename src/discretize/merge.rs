//! Merging clusters whose common border speaks for it.

use super::UNLABELLED;
use crate::order;

/// Fewest trajectories on either side of a border for its mean to count. A single stray trajectory, which the rotation
/// gave to another object's cluster, is like all that is around it and would merge both objects.
const MIN_WITNESSES: u32 = 3;

/// Sum and number of what speaks for joining along the border of every two clusters, `k × k`, symmetric.
struct Borders {
    k: usize,
    sum: Vec<f64>,
    count: Vec<u32>,
    /// Number of trajectories of the first cluster that have a neighbour in the second.
    witnesses: Vec<u32>,
}

impl Borders {
    fn new(label: &[u32], k: usize, pairs: &[(u32, u32)], evidence: &[f64]) -> Self {
        let mut borders = Self { k, sum: vec![0.0; k * k], count: vec![0; k * k], witnesses: vec![0; k * k] };
        let mut seen: Vec<(u32, u32)> = Vec::new();
        for (&(i, j), &e) in pairs.iter().zip(evidence) {
            let (p, q) = (label[i as usize], label[j as usize]);
            if p != q && p != UNLABELLED && q != UNLABELLED {
                for slot in [p as usize * k + q as usize, q as usize * k + p as usize] {
                    borders.sum[slot] += e;
                    borders.count[slot] += 1;
                }
                seen.extend([(i, q), (j, p)]);
            }
        }
        order::sort_by_key(&mut seen, |&(i, q)| order::pair(i, q));
        seen.dedup();
        for (i, q) in seen {
            borders.witnesses[label[i as usize] as usize * k + q as usize] += 1;
        }
        borders
    }

    /// The mean along the border, if the clusters are neighbours.
    fn mean(&self, p: usize, q: usize) -> Option<f64> {
        let slot = p * self.k + q;
        (self.count[slot] > 0).then(|| self.sum[slot] / f64::from(self.count[slot]))
    }

    /// The neighbour of `p` that most speaks for, lowest index on ties.
    fn nearest(&self, p: usize) -> Option<(f64, usize)> {
        first_greatest((0..self.k).filter_map(|q| self.mean(p, q).map(|e| (e, q))))
    }

    /// The same among borders that enough trajectories bear out.
    fn nearest_borne_out(&self, p: usize) -> Option<(f64, usize)> {
        let borne_out = |q: usize| self.witnesses[p * self.k + q].min(self.witnesses[q * self.k + p]) >= MIN_WITNESSES;
        first_greatest((0..self.k).filter(|&q| borne_out(q)).filter_map(|q| self.mean(p, q).map(|e| (e, q))))
    }

    /// Joins `q` into `p`: sums and counts add up.
    fn join(&mut self, p: usize, q: usize) {
        for r in 0..self.k {
            if r != p && r != q {
                self.sum[p * self.k + r] += self.sum[q * self.k + r];
                self.count[p * self.k + r] += self.count[q * self.k + r];
                (self.sum[r * self.k + p], self.count[r * self.k + p]) =
                    (self.sum[p * self.k + r], self.count[p * self.k + r]);
            }
            if r != p && r != q {
                self.witnesses[p * self.k + r] += self.witnesses[q * self.k + r];
                self.witnesses[r * self.k + p] += self.witnesses[r * self.k + q];
            }
            self.count[q * self.k + r] = 0;
            self.count[r * self.k + q] = 0;
        }
    }
}

/// The first of those with the greatest number.
fn first_greatest<T>(all: impl Iterator<Item = (f64, T)>) -> Option<(f64, T)> {
    all.reduce(|best, next| if next.0 > best.0 { next } else { best })
}

/// Merges neighbouring clusters while anything speaks for it: `evidence` of each pair of neighbours, of which those along
/// a common border count as their mean, and the border with the greatest comes first; then joins clusters of fewer than
/// `min_cluster` trajectories, smallest first, to the neighbour that most speaks for.
///
/// Labels may be any numbers; unlabelled trajectories take no part. A small cluster without neighbours stays.
pub(crate) fn merge_clusters(label: &mut [u32], pairs: &[(u32, u32)], evidence: &[f64], min_cluster: usize) {
    let k = label.iter().filter(|&&l| l != UNLABELLED).max().map_or(0, |&l| l as usize + 1);
    let mut borders = Borders::new(label, k, pairs, evidence);
    let mut size = vec![0_usize; k];
    for &l in label.iter().filter(|&&l| l != UNLABELLED) {
        size[l as usize] += 1;
    }
    let mut into: Vec<usize> = (0..k).collect();
    let mut join = |borders: &mut Borders, size: &mut [usize], p: usize, q: usize| {
        borders.join(p, q);
        size[p] += std::mem::take(&mut size[q]);
        into[q] = p;
    };
    loop {
        let of = |p| borders.nearest_borne_out(p).map(|(e, q)| (e, (p, q)));
        match first_greatest((0..k).filter_map(of)) {
            Some((e, (p, q))) if e > 0.0 => join(&mut borders, &mut size, p.min(q), p.max(q)),
            _ => break,
        }
    }
    loop {
        let small = (0..k).filter(|&p| size[p] > 0 && size[p] < min_cluster);
        let smallest = small.filter_map(|p| borders.nearest(p).map(|(_, q)| (size[p], p, q))).min();
        match smallest {
            Some((_, p, q)) => join(&mut borders, &mut size, q, p),
            None => break,
        }
    }
    for l in label.iter_mut().filter(|l| **l != UNLABELLED) {
        let mut cluster = *l as usize;
        while into[cluster] != cluster {
            cluster = into[cluster];
        }
        *l = cluster as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::chain;
    use super::*;
    use crate::discontinuity::Discontinuities;

    /// Merges while the mean discontinuity is below 0.4.
    fn merge_below(label: &mut [u32], links: &Discontinuities, min_cluster: usize) {
        let evidence: Vec<f64> = links.d.iter().map(|d| 0.4 - d).collect();
        merge_clusters(label, &links.neighborhoods.pairs, &evidence, min_cluster);
    }

    /// Three copies of the links side by side: every trajectory `i` becomes `3 i`, `3 i + 1` and `3 i + 2`.
    fn threefold(mut links: Discontinuities) -> Discontinuities {
        let copies = |(i, j): (u32, u32)| (0..3).map(move |c| (3 * i + c, 3 * j + c));
        links.neighborhoods.pairs = links.neighborhoods.pairs.into_iter().flat_map(copies).collect();
        links.d = links.d.into_iter().flat_map(|d| [d; 3]).collect();
        links
    }

    fn merged(label: &[u32], links: Discontinuities) -> Vec<u32> {
        let mut label: Vec<u32> = label.iter().flat_map(|&l| [l; 3]).collect();
        merge_below(&mut label, &threefold(links), 0);
        assert!(label.chunks(3).all(|copies| copies.iter().all(|&l| l == copies[0])));
        label.into_iter().step_by(3).collect()
    }

    #[test]
    fn only_weak_borders_are_merged() {
        assert_eq!(merged(&[0, 0, 1, 1, 2, 2], chain(&[0.1, 0.3, 0.1, 0.9, 0.1])), [0, 0, 0, 0, 2, 2]);
    }

    #[test]
    fn means_are_taken_anew_after_each_merge() {
        // 0-1 (0.1) merges first; its border to 2 is then (0.1 + 0.9 + 0.9) / 3 > 0.4, though 0-2 alone would merge.
        let mut links = chain(&[0.1, 0.9, 0.0]);
        links.neighborhoods.pairs.extend([(0, 2), (1, 3)]);
        links.d.extend([0.15, 0.9]);
        assert_eq!(merged(&[0, 1, 2, 2], links), [0, 0, 2, 2]);
    }

    #[test]
    fn a_single_stray_does_not_join_two_objects() {
        // Trajectory 3 lies in the first object, with weak discontinuities to all of it, but has the second one's
        // label.
        let mut label = vec![0, 0, 0, 1, 1, 1, 1];
        let mut links = chain(&[0.1, 0.1, 0.1, 0.9, 0.1, 0.1]);
        links.neighborhoods.pairs.extend([(0, 3), (1, 3)]);
        links.d.extend([0.1, 0.1]);
        merge_below(&mut label, &links, 0);
        assert_eq!(label, [0, 0, 0, 1, 1, 1, 1]);
    }

    #[test]
    fn small_clusters_join_their_least_discontinuous_neighbour() {
        let mut label = vec![0, 0, 0, 1, 2, 2, 2];
        merge_below(&mut label, &chain(&[0.0, 0.0, 0.95, 0.9, 0.0, 0.0]), 2);
        assert_eq!(label, [0, 0, 0, 2, 2, 2, 2]);
        let mut alone = vec![0, UNLABELLED];
        merge_below(&mut alone, &chain(&[1.0]), 5);
        assert_eq!(alone, [0, UNLABELLED]);
    }
}
