//! K-means on the embedding, a baseline of the discontinuity-aware discretization (section 5, Figure 10).
//!
//! Trajectory `i` lies at `x_i = (√λ_k V_ik)_k`: as the embedding affinity of two trajectories is `Ŵ_ij = Σ_k λ_k V_ik
//! V_jk`, their squared distance is `Ŵ_ii + Ŵ_jj − 2 Ŵ_ij`. (Shi and Malik, whom the paper names for its embedding
//! distances, leave out the `√λ_k`; these lie between 0.8 and 1 for the eigenvectors that are kept by default.)
//!
//! 1. Centres are drawn from the rows, with a probability proportional to the squared distance to the nearest centre so
//!    far (k-means++: Arthur and Vassilvitskii 2007). If all rows lie on centres there are fewer clusters.
//! 2. Every row moves to its nearest centre, every centre to the mean of its rows; a centre without rows moves to the row
//!    farthest from its own. Repeated until no row changes.
//! 3. The best of [`NUM_STARTS`] starts by inertia is kept, the first of equal ones.
//!
//! Cost: O(starts · iterations · rows · K²). It fails where clusters of the embedding are elongated.

use crate::embedding::Embedding;
use crate::evidence::UNLABELLED;
use crate::rng::Rng;

/// Number of random starts. Chosen by eye.
const NUM_STARTS: u32 = 10;
/// Most iterations of a start. Chosen by eye: rows along lines converge slowly, without a visible change.
const MAX_ITERATIONS: usize = 100;
/// Most multiplications for each row and start: fewer iterations from 18 centres on. Chosen by eye.
const MAX_ROW_PRODUCTS: usize = 30_000;
/// Centres whose distances are summed in parallel: the width of vector registers.
const LANES: usize = 8;

/// Labels every embedded trajectory in `0..count`, by the leading `count` eigenvectors; the others stay unlabelled.
pub(super) fn k_means(embedding: &Embedding, count: usize, seed: u32) -> Vec<u32> {
    let count = count.min(embedding.dimensions);
    let mut label = vec![UNLABELLED; embedding.num_rows];
    let embedded: Vec<usize> = (0..embedding.num_rows).filter(|&i| embedding.embedded[i]).collect();
    if embedded.is_empty() || count == 0 {
        return label;
    }
    let scale: Vec<f64> = embedding.eigenvalues[..count].iter().map(|l| l.max(0.0).sqrt()).collect();
    let coordinates = |&i: &usize| embedding.row(i).iter().zip(&scale).map(|(v, s)| v * s);
    let rows: Vec<f64> = embedded.iter().flat_map(coordinates).collect();
    let mut rng = Rng::for_stage(seed.into(), "k-means");
    let mut best = Partition::new(&rows, count, count, &mut rng);
    best.iterate(&rows);
    for _ in 1..NUM_STARTS {
        let mut next = Partition::new(&rows, count, count, &mut rng);
        next.iterate(&rows);
        if next.inertia < best.inertia {
            best = next;
        }
    }
    embedded.iter().zip(best.label).for_each(|(&i, l)| label[i] = l);
    label
}

/// Partition of the rows by nearest centre.
struct Partition {
    dimensions: usize,
    /// Number of centres, at most the number asked for.
    count: usize,
    /// `dimensions` lines for each [`LANES`] centres, one coordinate a line. Lines are padded with infinity, which is near
    /// no row.
    centres: Vec<[f64; LANES]>,
    label: Vec<u32>,
    /// Squared distance of each row to its centre, and their sum.
    distance: Vec<f64>,
    inertia: f64,
}

impl Partition {
    /// Draws centres (step 1) and assigns every row. There must be a row, of `dimensions` numbers.
    fn new(rows: &[f64], dimensions: usize, count: usize, rng: &mut Rng) -> Self {
        let num = rows.len() / dimensions;
        let row = |i: usize| &rows[i * dimensions..(i + 1) * dimensions];
        let mut seeds = vec![rng.below(num)];
        let mut distance = vec![f64::INFINITY; num];
        loop {
            let newest = row(seeds[seeds.len() - 1]);
            for (d, row) in distance.iter_mut().zip(rows.chunks_exact(dimensions)) {
                *d = d.min(row.iter().zip(newest).map(|(a, b)| (a - b) * (a - b)).sum());
            }
            let total: f64 = distance.iter().sum();
            if seeds.len() == count || total <= 0.0 {
                break;
            }
            let mut remainder = total * rng.uniform();
            let drawn = distance.iter().position(|&d| {
                remainder -= d;
                remainder < 0.0
            });
            // None by rounding.
            seeds.push(drawn.unwrap_or_else(|| farthest(&distance)));
        }
        let count = seeds.len();
        let coordinate = |i: Option<&usize>, c: usize| i.map_or(f64::INFINITY, |&i| rows[i * dimensions + c]);
        let line = |group: &[usize], c: usize| std::array::from_fn(|k| coordinate(group.get(k), c));
        let centres = seeds.chunks(LANES).flat_map(|group| (0..dimensions).map(move |c| line(group, c))).collect();
        let mut partition = Self { dimensions, count, centres, label: vec![0; num], distance, inertia: 0.0 };
        partition.assign(rows);
        partition
    }

    /// Repeats step 2 until no row changes.
    fn iterate(&mut self, rows: &[f64]) {
        let max_iterations = (MAX_ROW_PRODUCTS / (self.count * self.dimensions).max(1)).min(MAX_ITERATIONS);
        for _ in 0..max_iterations {
            self.move_centres(rows);
            if !self.assign(rows) {
                break;
            }
        }
    }

    /// Assigns every row to its nearest centre, the first of equal ones. Returns `true` if any row changed.
    fn assign(&mut self, rows: &[f64]) -> bool {
        let mut changed = false;
        self.inertia = 0.0;
        for (i, row) in rows.chunks_exact(self.dimensions).enumerate() {
            let mut nearest = (f64::INFINITY, 0_u32);
            for (group, lines) in self.centres.chunks_exact(self.dimensions).enumerate() {
                let mut sums = [0.0_f64; LANES];
                for (x, line) in row.iter().zip(lines) {
                    for (sum, centre) in sums.iter_mut().zip(line) {
                        *sum += (x - centre) * (x - centre);
                    }
                }
                let candidates = sums.into_iter().zip((group * LANES) as u32..);
                nearest = candidates.fold(nearest, |best, next| if next.0 < best.0 { next } else { best });
            }
            changed |= self.label[i] != nearest.1;
            self.label[i] = nearest.1;
            self.distance[i] = nearest.0;
            self.inertia += nearest.0;
        }
        changed
    }

    /// Moves every centre to the mean of its rows.
    fn move_centres(&mut self, rows: &[f64]) {
        let mut size = vec![0.0_f64; self.count];
        let mut sums = vec![0.0_f64; self.count * self.dimensions];
        for (row, &l) in rows.chunks_exact(self.dimensions).zip(&self.label) {
            size[l as usize] += 1.0;
            sums[l as usize * self.dimensions..].iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
        }
        for (c, sums) in sums.chunks_exact_mut(self.dimensions).enumerate().filter(|&(c, _)| size[c] > 0.0) {
            sums.iter_mut().for_each(|sum| *sum /= size[c]);
            self.set_centre(c, sums);
        }
        for c in (0..self.count).filter(|&c| size[c] <= 0.0) {
            let outlier = farthest(&self.distance);
            // The next empty centre takes another row.
            self.distance[outlier] = 0.0;
            self.set_centre(c, &rows[outlier * self.dimensions..]);
        }
    }

    fn set_centre(&mut self, c: usize, coordinates: &[f64]) {
        let lines = &mut self.centres[c / LANES * self.dimensions..][..self.dimensions];
        lines.iter_mut().zip(coordinates).for_each(|(line, x)| line[c % LANES] = *x);
    }
}

/// Index of the largest distance, the first of equal ones.
fn farthest(distance: &[f64]) -> usize {
    (0..distance.len()).fold(0, |best, i| if distance[i] > distance[best] { i } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn embedding(eigenvalues: &[f64], rows: &[Vec<f64>]) -> Embedding {
        Embedding {
            num_rows: rows.len(),
            dimensions: eigenvalues.len(),
            eigenvalues: eigenvalues.to_vec(),
            vectors: rows.concat(),
            embedded: vec![true; rows.len()],
            ..Embedding::default()
        }
    }

    /// Four blobs of `each` rows, corners of a square of side 1, `spread` wide; row `i` belongs to blob `i % 4`.
    fn blobs(each: usize, spread: f64) -> Vec<Vec<f64>> {
        let mut rng = Rng::for_stage(11, "blobs");
        let mut around = |v: f64| v + rng.range(-spread, spread);
        (0..4 * each).map(|i| vec![around((i % 2) as f64), around((i / 2 % 2) as f64), 0.0, around(0.3)]).collect()
    }

    #[test]
    fn four_blobs_are_four_clusters() {
        let labels = k_means(&embedding(&[1.0; 4], &blobs(30, 0.2)), 4, 5);
        for (i, a) in labels.iter().enumerate() {
            for (j, b) in labels.iter().enumerate() {
                assert_eq!(a == b, i % 4 == j % 4, "rows {i} and {j}");
            }
        }
    }

    #[test]
    fn eigenvectors_count_by_their_eigenvalues() {
        // Along the first axis the groups are 1 apart, along the second 1.2.
        let rows: Vec<Vec<f64>> = (0..40).map(|i| vec![f64::from(i % 2), 1.2 * f64::from(i / 2 % 2)]).collect();
        let splits_along =
            |axis: i32| move |labels: &[u32]| (0..4).all(|i| (labels[0] == labels[i as usize]) == (i / axis % 2 == 0));
        assert!(splits_along(2)(&k_means(&embedding(&[1.0, 1.0], &rows), 2, 0)));
        assert!(splits_along(1)(&k_means(&embedding(&[1.0, 0.25], &rows), 2, 0)));
    }

    #[test]
    fn the_same_seed_gives_the_same_labels_and_only_leading_eigenvectors_count() {
        let noisy = embedding(&[1.0; 4], &blobs(25, 0.8));
        assert_eq!(k_means(&noisy, 4, 5), k_means(&noisy, 4, 5));
        let mut changed = noisy.clone();
        changed.vectors.iter_mut().skip(3).step_by(4).for_each(|v| *v *= 100.0);
        assert_eq!(k_means(&noisy, 3, 5), k_means(&changed, 3, 5));
    }

    #[test]
    fn inertia_never_rises_and_ends_at_a_fixed_point() {
        let mut rng = Rng::for_stage(2, "inertia");
        let rows: Vec<f64> = (0..600).map(|_| rng.range(0.0, 1.0)).collect();
        for count in [1, 2, 7, 40, 200] {
            let mut partition = Partition::new(&rows, 3, count, &mut rng);
            assert_eq!(partition.count, count);
            for _ in 0..30 {
                let before = partition.inertia;
                partition.move_centres(&rows);
                partition.assign(&rows);
                assert!(partition.inertia <= before * (1.0 + 1e-12), "{count}: {before} {}", partition.inertia);
            }
            partition.iterate(&rows);
            assert!(!partition.assign(&rows), "{count} centres");
        }
    }

    #[test]
    fn centres_without_rows_take_the_farthest_ones() {
        let rows = [0.0, 0.0, 1.0, 9.0, 4.0];
        let line = |of: [f64; 3]| std::array::from_fn(|k| of.get(k).copied().unwrap_or(f64::INFINITY));
        // Both last centres are too far away for any row.
        let mut partition = Partition {
            dimensions: 1,
            count: 3,
            centres: vec![line([0.0, 100.0, 200.0])],
            label: vec![0; 5],
            distance: vec![0.0; 5],
            inertia: 0.0,
        };
        partition.assign(&rows);
        assert_eq!((partition.inertia, &partition.label), (98.0, &vec![0; 5]));
        partition.move_centres(&rows);
        assert_eq!(partition.centres, [line([2.8, 9.0, 4.0])]);
        partition.assign(&rows);
        assert_eq!(partition.label, [0, 0, 0, 1, 2]);
    }

    #[test]
    fn more_clusters_than_different_rows_leave_some_out() {
        let equal = vec![vec![0.5, 0.25, -1.0]; 6];
        assert_eq!(k_means(&embedding(&[1.0; 3], &equal), 3, 1), [0; 6]);
        let two = [vec![0.0, 1.0, 2.0], vec![3.0, 4.0, 5.0]];
        let labels = k_means(&embedding(&[1.0; 3], &two), 3, 1);
        assert!(labels[0] != labels[1] && labels.iter().all(|&l| l < 2), "{labels:?}");
    }

    #[test]
    fn trajectories_outside_the_embedding_stay_unlabelled() {
        assert!(k_means(&Embedding::default(), 3, 1).is_empty());
        let mut e = embedding(&[1.0, 0.9], &[vec![1.0, 0.0], vec![0.0, 0.0], vec![0.0, 1.0]]);
        e.embedded[1] = false;
        let labels = k_means(&e, 2, 1);
        assert_eq!(labels[1], UNLABELLED);
        assert_ne!(labels[0], labels[2]);
        assert_eq!(k_means(&e, 0, 1), [UNLABELLED; 3]);
        e.embedded = vec![false; 3];
        assert_eq!(k_means(&e, 2, 1), [UNLABELLED; 3]);
    }
}
