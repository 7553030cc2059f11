//! Merging clusters across weak borders (section 2.3).

use crate::discontinuity::Discontinuities;
use crate::evidence::UNLABELLED;
use crate::order;

/// Fewest trajectories on either side of a border for its mean to count. A single stray trajectory, which the rotation
/// gave to another object's cluster, is like all that is around it and would merge both objects.
const MIN_WITNESSES: u32 = 3;

/// Sum and number of the discontinuities along the border of every two clusters, `k × k`, symmetric.
struct Borders {
    k: usize,
    sum: Vec<f64>,
    count: Vec<u32>,
    /// Number of trajectories of the first cluster that have a neighbour in the second.
    witnesses: Vec<u32>,
}

impl Borders {
    fn new(label: &[u32], k: usize, found: &Discontinuities) -> Self {
        let mut borders = Self { k, sum: vec![0.0; k * k], count: vec![0; k * k], witnesses: vec![0; k * k] };
        let mut seen: Vec<(u32, u32)> = Vec::new();
        for (&(i, j), &d) in found.neighborhoods.pairs.iter().zip(&found.d) {
            let (p, q) = (label[i as usize], label[j as usize]);
            if p != q && p != UNLABELLED && q != UNLABELLED {
                for slot in [p as usize * k + q as usize, q as usize * k + p as usize] {
                    borders.sum[slot] += d;
                    borders.count[slot] += 1;
                }
                seen.extend([(i, q), (j, p)]);
            }
        }
        order::sort_by_key(&mut seen, |&(i, q)| order::pair_key(i, q));
        seen.dedup();
        for (i, q) in seen {
            borders.witnesses[label[i as usize] as usize * k + q as usize] += 1;
        }
        borders
    }

    /// The two clusters with the least mean discontinuity along a border that enough trajectories bear out, the lower
    /// first; the first of equal ones.
    fn weakest(&self) -> Option<(f64, usize, usize)> {
        let k = self.k;
        let is_borne_out =
            |p: usize, q: usize| self.witnesses[p * k + q].min(self.witnesses[q * k + p]) >= MIN_WITNESSES;
        let mean = |p: usize, q: usize| self.sum[p * k + q] / f64::from(self.count[p * k + q]);
        let borders = (0..k).flat_map(|p| (p + 1..k).map(move |q| (p, q)));
        let known = borders.filter(|&(p, q)| self.count[p * k + q] > 0 && is_borne_out(p, q));
        known.map(|(p, q)| (mean(p, q), p, q)).reduce(|best, next| if next.0 < best.0 { next } else { best })
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

/// Merges neighbouring clusters while the mean discontinuity along a common border, the least of all first, is below
/// `threshold` (section 2.3).
///
/// Labels may be any numbers; unlabelled trajectories take no part.
pub(super) fn merge_clusters(label: &mut [u32], found: &Discontinuities, threshold: f64) {
    let k = label.iter().filter(|&&l| l != UNLABELLED).max().map_or(0, |&l| l as usize + 1);
    let mut borders = Borders::new(label, k, found);
    let mut into: Vec<usize> = (0..k).collect();
    while let Some((_, p, q)) = borders.weakest().filter(|border| border.0 < threshold) {
        borders.join(p, q);
        into.iter_mut().filter(|into| **into == q).for_each(|into| *into = p);
    }
    for l in label.iter_mut().filter(|l| **l != UNLABELLED) {
        *l = into[*l as usize] as u32;
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
        merge_clusters(&mut label, &threefold(links), 0.4);
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
        merge_clusters(&mut label, &links, 0.4);
        assert_eq!(label, [0, 0, 0, 1, 1, 1, 1]);
    }

    #[test]
    fn unlabelled_ones_take_no_part() {
        let mut alone = vec![0, UNLABELLED];
        merge_clusters(&mut alone, &chain(&[0.0]), 0.4);
        assert_eq!(alone, [0, UNLABELLED]);
    }
}
