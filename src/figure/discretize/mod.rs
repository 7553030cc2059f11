//! Discontinuity-aware discretization (section 2.3): from embedding and discontinuities to cluster labels.
//!
//! In: the embedding, the trajectories with their motion ([`EvidenceInput`]), and the discontinuities between neighbours.
//! Out: one label per trajectory.
//!
//! 1. Eigenvector rotation (Yu and Shi 2003) into a cluster for each eigenvector: an over-segmentation (`rotation`).
//! 2. Clusters that are likely one object are merged ([`crate::evidence`]).
//!    Both steps run for five numbers of clusters, from all eigenvectors down to half of them, and the clustering that is
//!    nearest to the others is kept (`median`): one that depends on a single eigenvector is not.
//! 3. Trajectories outside the embedding take the majority label of their neighbours.
//! 4. Labels are numbered by falling number of trajectory points.
//!
//! The paper merges by discontinuities alone in step 2 (`border_merging`, rotation-merge): for each pair of neighbouring
//! clusters it takes the mean `d^C` over all neighbour pairs between them, and merges the smallest while it is below ρ.
//! It does not fix the order (greedy here, so that chains through small clusters do not form); its ρ is 0.4 (0.77 here,
//! since the rotation cuts where the embedding changes fastest, and true borders have a mean `d` above 0.9); and it has
//! no least length of a border (three trajectories on either side here).
//!
//! For comparison, step 2 can be left out, K-means can replace the rotation (`kmeans`), and the number of clusters can
//! follow from the gap between two consecutive eigenvalues (`cluster_count`): the five methods of Figure 10.
//! `threshold_segmentation` is the segmentation of Figure 1(c).
//!
//! Cost: O(rotations · rows · K²). It fails where one object needs more eigenvectors than there are.

mod border_merging;
mod kmeans;
mod median;
mod rotation;

#[doc(inline)]
pub use crate::evidence::EvidenceInput;
pub(crate) use rotation::{NormalizedRows, rotate};

use crate::discontinuity::Discontinuities;
use crate::embedding::Embedding;
use crate::evidence::{UNLABELLED, merge_by_evidence};
use crate::order;
use crate::sets::DisjointSets;
use crate::trajectory::Trajectories;
use border_merging::merge_by_borders;
use kmeans::k_means;
use median::median_clustering;
use rotation::label_embedded;

crate::choices! {
    /// Method from embedding to labels.
    pub enum DiscretizeMethod {
        /// Rotation, then merging across weak borders: the discontinuity-aware discretization.
        RotationMerge = "rotation-merge",
        /// Rotation alone.
        Rotation = "rotation",
        /// K-means alone.
        KMeans = "k-means",
        /// Rotation, then merging by discontinuities, motion and size.
        RotationEvidence = "rotation-evidence",
    }
}

crate::choices! {
    /// Number of clusters before merging.
    pub enum CountRule {
        /// As many as the embedding has eigenvectors: those whose eigenvalues reach a threshold.
        Eigenvalues = "eigenvalues",
        /// As many as there are eigenvalues before the first large gap of two.
        Gap = "gap",
    }
}

crate::params! {
    /// Discretization.
    pub struct DiscretizeParams {
        /// rotation-evidence merges by discontinuities, motion and size, rotation-merge by discontinuities alone
        /// (section 2.3); rotation and k-means do not merge (Figure 10).
        pub method: DiscretizeMethod = DiscretizeMethod::RotationEvidence, in 0..=3, expert;
        /// Number of clusters before merging: eigenvalues takes one for each eigenvector of the embedding, gap one for
        /// each eigenvalue before the first gap of at least `minGap`.
        pub count: CountRule = CountRule::Eigenvalues, in 0..=1, expert;
        /// With the count by gap: K is the least number for which λ_K − λ_K+1 reaches this, or all eigenvalues of the
        /// embedding if none does. Higher gives more clusters.
        pub min_gap: f64 = 0.02, in 0.0..=1.0, expert;
        /// With rotation-evidence: log-odds above which two clusters are merged, lower for small ones. Higher splits more,
        /// lower makes fewer, larger clusters.
        pub merge_log_odds: f64 = 2.8, in 0.0..=20.0;
        /// Masks that agree less than this with the masks of nearby frames along the flow are made again from other clusters;
        /// the masks that agree most are kept. 0 keeps the first. Not in the paper; docs/choices.md.
        pub min_agreement: f32 = 0.7, in 0.0..=1.0, expert;
        /// ρ of rotation-merge: clusters whose mean discontinuity along their common border is below it are merged
        /// (section 2.3: 0.4). Higher merges more.
        pub merge_threshold: f64 = 0.77, in 0.0..=1.0, expert;
    }
}

/// Labels each trajectory, by the method and the count of `params`. `seed` is for K-means.
///
/// # Examples
/// The trajectories of [`discontinuities`](crate::discontinuity::discontinuities)' example, clustered again.
///
/// ```
/// # use tracecut::discontinuity::{DiscontinuityParams, discontinuities, neighborhoods};
/// # use tracecut::embedding::{EmbeddingParams, embed};
/// # use tracecut::sparse::SymCsr;
/// # use tracecut::trajectory::Trajectories;
/// #
/// # // A trajectory for each digit; equal digits move alike.
/// # let digits = ["00011", "00011", "00011"].concat().into_bytes();
/// # let mut tracks = Trajectories::empty(1, (50, 30));
/// # (0..15).for_each(|i| tracks.push(0, [(10.0 * (i % 5) as f32, 10.0 * (i / 5) as f32 + (i % 5 % 2) as f32, 0.0)]));
/// # let pairs = (0..15_u32).flat_map(|i| (i + 1..15).map(move |j| (i, j)));
/// # let alike = pairs.filter(|&(i, j)| digits[i as usize] == digits[j as usize]);
/// # let a = SymCsr::from_upper(15, &alike.map(|(i, j)| (i, j, 1.0)).collect::<Vec<_>>());
/// # let mut params = EmbeddingParams::default();
/// # params.min_component = 2;
/// # params.min_dimensions = 1;
/// # let embedding = embed(&a, &params, 0);
/// # let d = discontinuities(neighborhoods(&tracks), &embedding, &DiscontinuityParams::default());
/// use tracecut::affinity::AffinityParams;
/// use tracecut::discretize::{DiscretizeMethod, DiscretizeParams, EvidenceInput, discretize};
///
/// let affinity = AffinityParams::default();
/// let mut params = DiscretizeParams::default();
/// params.method = DiscretizeMethod::RotationMerge;
/// let clusters = discretize(&embedding, &EvidenceInput::new(&tracks, &d, &affinity, None, None), &params, 0);
/// assert_eq!((clusters.count, clusters.label.len()), (2, 15));
/// assert!(clusters.label.iter().zip(&digits).all(|(&label, digit)| label == u32::from(digit - b'0')));
/// ```
#[must_use]
pub fn discretize(embedding: &Embedding, input: &EvidenceInput, params: &DiscretizeParams, seed: u32) -> Clusters {
    discretize_with(embedding, input, params, seed, |count| NormalizedRows::new(embedding, count).rotate())
}

/// Same as [`discretize`], with `rotate(count)` for the labels of the embedded rows by `count` eigenvectors.
pub(crate) fn discretize_with(
    embedding: &Embedding,
    input: &EvidenceInput,
    params: &DiscretizeParams,
    seed: u32,
    mut rotate: impl FnMut(usize) -> Vec<u32>,
) -> Clusters {
    if params.method != DiscretizeMethod::RotationEvidence {
        return discretize_into(embedding, input, cluster_count(embedding, params), params, seed);
    }
    let mut clusterings: Vec<(usize, Clusters)> = Vec::new();
    for count in rotation_counts(embedding, params) {
        // Few eigenvectors have equal counts.
        let last = clusterings.last().filter(|last| last.0 == count).map(|(_, clusters)| clusters.clone());
        let clusters = last.unwrap_or_else(|| merge(label_embedded(embedding, rotate(count)), input, params));
        clusterings.push((count, clusters));
    }
    median_clustering(clusterings.into_iter().map(|(_, clusters)| clusters).collect())
}

/// Numbers of clusters of the rotations whose median is taken, largest first; none with other methods.
pub(crate) fn rotation_counts(embedding: &Embedding, params: &DiscretizeParams) -> Vec<usize> {
    let count = cluster_count(embedding, params);
    let counts = ROTATION_EIGHTHS.iter().map(|eighths| (eighths * count / 8).max(2));
    counts.filter(|_| params.method == DiscretizeMethod::RotationEvidence).collect()
}

/// Number of rotations whose median is taken.
pub(crate) const NUM_ROTATIONS: usize = ROTATION_EIGHTHS.len();
/// Their numbers of clusters, in eighths of the number of eigenvectors. Chosen by eye.
const ROTATION_EIGHTHS: [usize; 5] = [8, 7, 6, 5, 4];

/// Over-segments the trajectories, by the method and the count of `params`. Trajectories that are not embedded are
/// [`UNLABELLED`]. `seed` is for K-means.
pub(crate) fn oversegment(embedding: &Embedding, params: &DiscretizeParams, seed: u32) -> Vec<u32> {
    oversegment_into(embedding, cluster_count(embedding, params), params, seed)
}

fn oversegment_into(embedding: &Embedding, count: usize, params: &DiscretizeParams, seed: u32) -> Vec<u32> {
    match params.method {
        DiscretizeMethod::KMeans => k_means(embedding, count, seed),
        _ => rotate(embedding, count),
    }
}

/// Merges clusters by the method of `params` (steps 2 to 4).
fn merge(mut label: Vec<u32>, input: &EvidenceInput, params: &DiscretizeParams) -> Clusters {
    match params.method {
        DiscretizeMethod::RotationEvidence => merge_by_evidence(&mut label, input, params.merge_log_odds),
        DiscretizeMethod::RotationMerge => merge_by_borders(&mut label, input.discontinuities, params.merge_threshold),
        DiscretizeMethod::Rotation | DiscretizeMethod::KMeans => {}
    }
    spread_labels(&mut label, input.discontinuities);
    Clusters::from_labels(input.tracks, label)
}

/// Discretizes by the leading `count` eigenvectors into `count` clusters before merging, without `params.count`.
pub(crate) fn discretize_into(
    embedding: &Embedding,
    input: &EvidenceInput,
    count: usize,
    params: &DiscretizeParams,
    seed: u32,
) -> Clusters {
    merge(oversegment_into(embedding, count, params, seed), input, params)
}

/// Moves all background trajectories to a cluster of their own.
pub(crate) fn with_background(tracks: &Trajectories, clusters: Clusters, foreground: &[bool]) -> Clusters {
    let background = clusters.count as u32;
    let label = clusters.label.iter().zip(foreground).map(|(&l, &f)| if f { l } else { background }).collect();
    Clusters::from_labels(tracks, label)
}

/// Number of clusters by the rule of `params`, at most the number of eigenvectors.
fn cluster_count(embedding: &Embedding, params: &DiscretizeParams) -> usize {
    match params.count {
        CountRule::Eigenvalues => embedding.dimensions,
        CountRule::Gap => {
            let gap = embedding.eigenvalues.windows(2).position(|pair| pair[0] - pair[1] >= params.min_gap);
            gap.map_or(embedding.dimensions, |last| last + 1)
        }
    }
}

/// Connected components of the edges with `d` at most `threshold`, 0.6 in Figure 1(c).
#[must_use]
pub(crate) fn threshold_segmentation(
    tracks: &Trajectories,
    discontinuities: &Discontinuities,
    threshold: f64,
) -> Clusters {
    let mut sets = DisjointSets::new(tracks.len());
    for (&(i, j), &d) in discontinuities.neighborhoods.pairs.iter().zip(&discontinuities.d) {
        if d <= threshold {
            sets.join(i as usize, j as usize);
        }
    }
    let label = (0..tracks.len()).map(|i| sets.root(i) as u32).collect();
    Clusters::from_labels(tracks, label)
}

/// Gives unlabelled trajectories the majority label of their neighbours, ring by ring; 0 without labelled neighbours.
fn spread_labels(label: &mut [u32], discontinuities: &Discontinuities) {
    loop {
        let mut votes: Vec<(u32, u32)> = Vec::new();
        for &(i, j) in &discontinuities.neighborhoods.pairs {
            match (label[i as usize], label[j as usize]) {
                (UNLABELLED, UNLABELLED) => {}
                (UNLABELLED, vote) => votes.push((i, vote)),
                (vote, UNLABELLED) => votes.push((j, vote)),
                _ => {}
            }
        }
        if votes.is_empty() {
            break;
        }
        order::sort_by_key(&mut votes, |&(i, vote)| order::pair_key(i, vote));
        for ballot in votes.chunk_by(|a, b| a.0 == b.0) {
            let equal_votes = ballot.chunk_by(|a, b| a == b).rev();
            let winner = equal_votes.max_by_key(|votes| votes.len()).map_or(0, |votes| votes[0].1);
            label[ballot[0].0 as usize] = winner;
        }
    }
    for l in label.iter_mut().filter(|l| **l == UNLABELLED) {
        *l = 0;
    }
}

/// A label for each trajectory.
///
/// Law: every label is in `0..count`, every label occurs, label 0 has the most trajectory points, and so on.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Clusters {
    /// Number of clusters.
    pub count: usize,
    /// Label of each trajectory.
    pub label: Vec<u32>,
}

impl Clusters {
    /// Renumbers any labels from 0 by falling number of trajectory points, ties by first trajectory.
    pub(crate) fn from_labels(tracks: &Trajectories, label: Vec<u32>) -> Self {
        let mut old_labels: Vec<u32> = label.clone();
        order::sort_by_key(&mut old_labels, |&l| l.into());
        old_labels.dedup();
        let index = |l: u32| old_labels.binary_search(&l).unwrap_or(0);
        // Points and first trajectory of each label.
        let mut size = vec![(0_usize, usize::MAX); old_labels.len()];
        for (i, &l) in label.iter().enumerate() {
            let entry = &mut size[index(l)];
            *entry = (entry.0 + tracks.points(i).len(), entry.1.min(i));
        }
        let mut by_size: Vec<usize> = (0..old_labels.len()).collect();
        order::sort_by_key(&mut by_size, |&k| order::pair_key(u32::MAX - size[k].0 as u32, size[k].1 as u32));
        let mut rank = vec![0_u32; old_labels.len()];
        for (new, &old) in by_size.iter().enumerate() {
            rank[old] = new as u32;
        }
        Self { count: old_labels.len(), label: label.into_iter().map(|l| rank[index(l)]).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::affinity::AffinityParams;
    use crate::discontinuity::Neighborhoods;

    fn still(n: usize, frames: usize) -> Trajectories {
        let mut tracks = Trajectories::empty(frames, (100, 100));
        for k in 0..n {
            tracks.push(0, (0..frames).map(|_| (k as f32, 0.0, 0.0)));
        }
        tracks
    }

    /// A chain 0 - 1 - 2 - ... with the given discontinuities.
    pub(super) fn chain(d: &[f64]) -> Discontinuities {
        let pairs = (0..d.len() as u32).map(|i| (i, i + 1)).collect();
        Discontinuities {
            neighborhoods: Neighborhoods { pairs, ..Neighborhoods::default() },
            d: d.to_vec(),
            ..Discontinuities::default()
        }
    }

    #[test]
    fn thresholding_cuts_the_chain_at_its_large_discontinuities() {
        let clusters = threshold_segmentation(&still(6, 3), &chain(&[0.1, 0.9, 0.2, 0.3, 0.7]), 0.6);
        assert_eq!(clusters, Clusters { count: 3, label: vec![1, 1, 0, 0, 0, 2] });
    }

    #[test]
    fn labels_are_numbered_by_trajectory_points() {
        let mut tracks = still(2, 2);
        tracks.num_frames = 9;
        tracks.push(0, (0..9).map(|_| (0.0, 0.0, 0.0)));
        assert_eq!(Clusters::from_labels(&tracks, vec![7, 7, 3]).label, [1, 1, 0]);
    }

    #[test]
    fn the_background_is_one_cluster_beside_the_others() {
        let clusters = Clusters { count: 1, label: vec![0; 4] };
        assert_eq!(with_background(&still(4, 3), clusters, &[true, true, false, false]).label, [0, 0, 1, 1]);
    }

    #[test]
    fn unlabelled_trajectories_follow_the_majority_of_their_neighbours() {
        let mut label = vec![1, UNLABELLED, UNLABELLED, 2, 2];
        let mut links = chain(&[0.0; 4]);
        links.neighborhoods.pairs.extend([(1, 3), (1, 4)]);
        spread_labels(&mut label, &links);
        assert_eq!(label, [1, 2, 2, 2, 2]);
        let mut single = vec![UNLABELLED];
        spread_labels(&mut single, &chain(&[]));
        assert_eq!(single, [0]);
    }

    #[test]
    fn no_trajectories_give_no_clusters() {
        for method in [
            DiscretizeMethod::RotationEvidence,
            DiscretizeMethod::RotationMerge,
            DiscretizeMethod::Rotation,
            DiscretizeMethod::KMeans,
        ] {
            for count in [CountRule::Eigenvalues, CountRule::Gap] {
                let params = DiscretizeParams { method, count, ..DiscretizeParams::default() };
                let (no_tracks, links, affinity) = (still(0, 3), chain(&[]), AffinityParams::default());
                let clusters = discretize(
                    &Embedding::default(),
                    &EvidenceInput::new(&no_tracks, &links, &affinity, None, None),
                    &params,
                    0,
                );
                assert_eq!(clusters, Clusters::default());
            }
        }
    }

    #[test]
    fn the_first_gap_that_is_large_enough_ends_the_count() {
        let embedding =
            Embedding { dimensions: 5, eigenvalues: vec![1.0, 0.99, 0.9, 0.65, 0.64], ..Embedding::default() };
        let count = |min_gap| {
            cluster_count(
                &embedding,
                &DiscretizeParams { count: CountRule::Gap, min_gap, ..DiscretizeParams::default() },
            )
        };
        assert_eq!([0.0, 0.005, 0.05, 0.2, 0.3].map(count), [1, 1, 2, 3, 5]);
        assert_eq!(cluster_count(&embedding, &DiscretizeParams::default()), 5);
    }

    #[test]
    fn only_the_first_method_merges() {
        // Two groups of rows in a plane, and weak discontinuities all along: the rotation parts them, the merging joins
        // them.
        let rows = [[1.0, 0.1], [1.0, 0.0], [0.9, 0.1], [0.0, 1.0], [0.1, 0.9], [0.1, 1.0]];
        let embedding = Embedding {
            num_rows: 6,
            dimensions: 2,
            eigenvalues: vec![1.0, 0.9],
            vectors: rows.concat(),
            embedded: vec![true; 6],
            ..Embedding::default()
        };
        let mut links = chain(&[0.0; 5]);
        links.neighborhoods.pairs.extend([(0, 3), (1, 4), (2, 5)]);
        links.d.extend([0.0; 3]);
        let labels = |method, count| {
            let params = DiscretizeParams { method, ..DiscretizeParams::default() };
            let (tracks, affinity) = (still(6, 3), AffinityParams::default());
            discretize_into(&embedding, &EvidenceInput::new(&tracks, &links, &affinity, None, None), count, &params, 0)
                .label
        };
        for method in [DiscretizeMethod::Rotation, DiscretizeMethod::KMeans] {
            assert_eq!(labels(method, 2), [0, 0, 0, 1, 1, 1], "{method:?}");
            assert_eq!(labels(method, 1), [0; 6], "{method:?}");
        }
        assert_eq!(labels(DiscretizeMethod::RotationMerge, 2), [0; 6]);
    }
}
