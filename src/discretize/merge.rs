//! Merging clusters whose common border shows no discontinuity.

use super::UNLABELLED;
use crate::discontinuity::Discontinuities;

/// Sum and number of the discontinuities between every two clusters, `k × k`, symmetric.
struct Borders {
    k: usize,
    sum: Vec<f64>,
    count: Vec<u32>,
}

impl Borders {
    fn new(label: &[u32], k: usize, discontinuities: &Discontinuities) -> Self {
        let mut borders = Self { k, sum: vec![0.0; k * k], count: vec![0; k * k] };
        for (&(i, j), &d) in discontinuities.neighborhoods.pairs.iter().zip(&discontinuities.d) {
            let (p, q) = (label[i as usize], label[j as usize]);
            if p != q && p != UNLABELLED && q != UNLABELLED {
                for slot in [p as usize * k + q as usize, q as usize * k + p as usize] {
                    borders.sum[slot] += d;
                    borders.count[slot] += 1;
                }
            }
        }
        borders
    }

    /// `d^C_pq`, if the clusters are neighbours.
    fn mean(&self, p: usize, q: usize) -> Option<f64> {
        let slot = p * self.k + q;
        (self.count[slot] > 0).then(|| self.sum[slot] / f64::from(self.count[slot]))
    }

    /// The neighbour of `p` with the smallest mean, lowest index on ties.
    fn nearest(&self, p: usize) -> Option<(f64, usize)> {
        (0..self.k).filter_map(|q| self.mean(p, q).map(|d| (d, q))).min_by(|a, b| a.0.total_cmp(&b.0))
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
            self.count[q * self.k + r] = 0;
            self.count[r * self.k + q] = 0;
        }
    }
}

/// Merges neighbouring clusters, least discontinuous pair first, while their mean discontinuity is below `threshold`; then joins
/// clusters of fewer than `min_cluster` trajectories, smallest first, to their least discontinuous neighbour.
///
/// Labels may be any numbers; unlabelled trajectories take no part. A small cluster without neighbours stays.
pub fn merge_clusters(label: &mut [u32], discontinuities: &Discontinuities, threshold: f64, min_cluster: usize) {
    let k = label.iter().filter(|&&l| l != UNLABELLED).max().map_or(0, |&l| l as usize + 1);
    let mut borders = Borders::new(label, k, discontinuities);
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
        let best = (0..k).filter_map(|p| borders.nearest(p).map(|(d, q)| (d, p, q))).min_by(|a, b| a.0.total_cmp(&b.0));
        match best {
            Some((d, p, q)) if d < threshold => join(&mut borders, &mut size, p.min(q), p.max(q)),
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

    #[test]
    fn only_weak_borders_are_merged() {
        let mut label = vec![0, 0, 1, 1, 2, 2];
        merge_clusters(&mut label, &chain(&[0.1, 0.3, 0.1, 0.9, 0.1]), 0.4, 0);
        assert_eq!(label, [0, 0, 0, 0, 2, 2]);
    }

    #[test]
    fn means_are_taken_anew_after_each_merge() {
        // 0-1 (0.1) merges first; its border to 2 is then (0.1 + 0.9 + 0.9) / 3 > 0.4, though 0-2 alone would merge.
        let mut label = vec![0, 1, 2, 2];
        let mut links = chain(&[0.1, 0.9, 0.0]);
        links.neighborhoods.pairs.extend([(0, 2), (1, 3)]);
        links.d.extend([0.15, 0.9]);
        merge_clusters(&mut label, &links, 0.4, 0);
        assert_eq!(label, [0, 0, 2, 2]);
    }

    #[test]
    fn small_clusters_join_their_least_discontinuous_neighbour() {
        let mut label = vec![0, 0, 0, 1, 2, 2, 2];
        merge_clusters(&mut label, &chain(&[0.0, 0.0, 0.95, 0.9, 0.0, 0.0]), 0.4, 2);
        assert_eq!(label, [0, 0, 0, 2, 2, 2, 2]);
        let mut alone = vec![0, UNLABELLED];
        merge_clusters(&mut alone, &chain(&[1.0]), 0.4, 5);
        assert_eq!(alone, [0, UNLABELLED]);
    }
}
