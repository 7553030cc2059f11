//! Merging clusters across weak borders (section 2.3).

use crate::discontinuity::Discontinuities;
use crate::evidence::UNLABELLED;
use crate::order;

/// Fewest trajectories on either side of a border for its mean to count. Chosen by eye: a single outlier, which the
/// rotation gave to another object's cluster, is like all its neighbours and would merge both objects.
const MIN_BORDER_TRACKS: u32 = 3;

/// Sum and number of the discontinuities along the border of each pair of clusters, `k × k`, symmetric.
struct BorderSums {
    k: usize,
    sum: Vec<f64>,
    count: Vec<u32>,
    /// Number of trajectories of the first cluster that have a neighbour in the second.
    tracks: Vec<u32>,
}

impl BorderSums {
    fn new(label: &[u32], k: usize, discontinuities: &Discontinuities) -> Self {
        let mut borders = Self { k, sum: vec![0.0; k * k], count: vec![0; k * k], tracks: vec![0; k * k] };
        // Trajectories, each with a neighbouring cluster.
        let mut neighbours: Vec<(u32, u32)> = Vec::new();
        for (&(i, j), &d) in discontinuities.neighborhoods.pairs.iter().zip(&discontinuities.d) {
            let (p, q) = (label[i as usize], label[j as usize]);
            if p != q && p != UNLABELLED && q != UNLABELLED {
                for slot in [p as usize * k + q as usize, q as usize * k + p as usize] {
                    borders.sum[slot] += d;
                    borders.count[slot] += 1;
                }
                neighbours.extend([(i, q), (j, p)]);
            }
        }
        order::sort_by_key(&mut neighbours, |&(i, q)| order::pair_key(i, q));
        neighbours.dedup();
        for (i, q) in neighbours {
            borders.tracks[label[i as usize] as usize * k + q as usize] += 1;
        }
        borders
    }

    /// Returns the least mean discontinuity along a border of enough trajectories, with its two clusters, the lower first;
    /// the first of equal ones.
    fn weakest(&self) -> Option<(f64, usize, usize)> {
        let k = self.k;
        let is_long = |p: usize, q: usize| self.tracks[p * k + q].min(self.tracks[q * k + p]) >= MIN_BORDER_TRACKS;
        let mean = |p: usize, q: usize| self.sum[p * k + q] / f64::from(self.count[p * k + q]);
        let pairs = (0..k).flat_map(|p| (p + 1..k).map(move |q| (p, q)));
        let borders = pairs.filter(|&(p, q)| self.count[p * k + q] > 0 && is_long(p, q));
        borders.map(|(p, q)| (mean(p, q), p, q)).reduce(|best, next| if next.0 < best.0 { next } else { best })
    }

    /// Merges `q` into `p`: sums and counts add up.
    fn merge(&mut self, p: usize, q: usize) {
        for r in 0..self.k {
            if r != p && r != q {
                self.sum[p * self.k + r] += self.sum[q * self.k + r];
                self.count[p * self.k + r] += self.count[q * self.k + r];
                (self.sum[r * self.k + p], self.count[r * self.k + p]) =
                    (self.sum[p * self.k + r], self.count[p * self.k + r]);
                self.tracks[p * self.k + r] += self.tracks[q * self.k + r];
                self.tracks[r * self.k + p] += self.tracks[r * self.k + q];
            }
            self.count[q * self.k + r] = 0;
            self.count[r * self.k + q] = 0;
        }
    }
}

/// Merges neighbouring clusters while the least mean discontinuity along a common border is below `threshold` (section
/// 2.3). Labels may be any numbers; unlabelled trajectories stay so.
pub(super) fn merge_by_borders(label: &mut [u32], discontinuities: &Discontinuities, threshold: f64) {
    let k = label.iter().filter(|&&l| l != UNLABELLED).max().map_or(0, |&l| l as usize + 1);
    let mut borders = BorderSums::new(label, k, discontinuities);
    let mut merged_into: Vec<usize> = (0..k).collect();
    while let Some((_, p, q)) = borders.weakest().filter(|border| border.0 < threshold) {
        borders.merge(p, q);
        merged_into.iter_mut().filter(|target| **target == q).for_each(|target| *target = p);
    }
    for l in label.iter_mut().filter(|l| **l != UNLABELLED) {
        *l = merged_into[*l as usize] as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::chain;
    use super::*;

    /// Three copies of the links side by side: every trajectory `i` becomes `3 i`, `3 i + 1` and `3 i + 2`.
    fn threefold(mut links: Discontinuities) -> Discontinuities {
        let copies = |(i, j): (u32, u32)| (0..3).map(move |c| (3 * i + c, 3 * j + c));
        links.neighborhoods.pairs = links.neighborhoods.pairs.into_iter().flat_map(copies).collect();
        links.d = links.d.into_iter().flat_map(|d| [d; 3]).collect();
        links
    }

    fn merged(label: &[u32], links: Discontinuities) -> Vec<u32> {
        let mut label: Vec<u32> = label.iter().flat_map(|&l| [l; 3]).collect();
        merge_by_borders(&mut label, &threefold(links), 0.4);
        assert!(label.chunks(3).all(|copies| copies.iter().all(|&l| l == copies[0])));
        label.into_iter().step_by(3).collect()
    }

    #[test]
    fn only_weak_borders_are_merged() {
        assert_eq!(merged(&[0, 0, 1, 1, 2, 2], chain(&[0.1, 0.3, 0.1, 0.9, 0.1])), [0, 0, 0, 0, 2, 2]);
    }

    #[test]
    fn means_are_updated_after_each_merge() {
        // 0-1 (0.1) merges first; its border to 2 is then (0.1 + 0.9 + 0.9) / 3 > 0.4, though 0-2 label would merge.
        let mut links = chain(&[0.1, 0.9, 0.0]);
        links.neighborhoods.pairs.extend([(0, 2), (1, 3)]);
        links.d.extend([0.15, 0.9]);
        assert_eq!(merged(&[0, 1, 2, 2], links), [0, 0, 2, 2]);
    }

    #[test]
    fn a_single_outlier_does_not_merge_two_objects() {
        // Trajectory 3 lies in the first object, with weak discontinuities to all of it, but has the second one's
        // label.
        let mut label = vec![0, 0, 0, 1, 1, 1, 1];
        let mut links = chain(&[0.1, 0.1, 0.1, 0.9, 0.1, 0.1]);
        links.neighborhoods.pairs.extend([(0, 3), (1, 3)]);
        links.d.extend([0.1, 0.1]);
        merge_by_borders(&mut label, &links, 0.4);
        assert_eq!(label, [0, 0, 0, 1, 1, 1, 1]);
    }

    #[test]
    fn unlabelled_trajectories_stay_unlabelled() {
        let mut label = vec![0, UNLABELLED];
        merge_by_borders(&mut label, &chain(&[0.0]), 0.4);
        assert_eq!(label, [0, UNLABELLED]);
    }
}
