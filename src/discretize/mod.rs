//! Discontinuity-aware discretization (section 2.3): from embedding and discontinuities to cluster labels.
//!
//! In: the embedding, the neighbour pairs with their `d`. Out: one label per trajectory.
//!
//! 1. Eigenvector rotation (Yu and Shi 2003) into as many clusters as there are eigenvectors: an over-segmentation (`rotation`).
//! 2. Small pieces apart from the rest of their cluster go to the cluster that holds them most, so that they cannot bridge two objects.
//! 3. For each two neighbouring clusters their mean discontinuity `d^C` over all neighbour pairs between them; merge the pair with the
//!    smallest while it is below ρ, sums added up at each merge.
//! 4. Clusters of very few trajectories join their least discontinuous neighbour.
//! 5. Trajectories outside the embedding take the label of most of their neighbours.
//! 6. Labels are numbered by how many trajectory points they hold, most first.
//!
//! Deviations: the paper does not fix the order of merging (greedy here: chains through small clusters do not form), its ρ is 0.4 (0.7
//! here, since the rotation cuts where the embedding changes fastest, and true borders have a mean `d` above 0.9), and it has no steps 2 and 4.
//!
//! [`threshold_segmentation`] is the other reading of the discontinuities, Figure 1(c): the connected components of all edges with
//! `d` below 0.6.

mod merge;
mod rotation;

use crate::discontinuity::Discontinuities;
use crate::embedding::Embedding;
use crate::trajectory::Trajectories;
pub use merge::merge_clusters;
pub use rotation::rotate;

crate::params! {
    /// Discontinuity-aware discretization.
    pub struct DiscretizeParams {
        /// ρ: clusters whose mean discontinuity along their common border is below it are merged (section 2.3: 0.4). Higher merges more.
        pub merge_threshold: f64 = 0.7, in 0.0..=1.0;
        /// Clusters of fewer trajectories join their least discontinuous neighbour; counted at a grid step of 8 pixels and scaled with
        /// the inverse square of the step. 0 keeps all.
        pub min_cluster: u32 = 20, in 0..=100000;
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

/// No label yet.
const UNLABELLED: u32 = u32::MAX;

/// The discontinuity-aware discretization; `min_cluster` counts trajectories.
pub fn discretize(
    tracks: &Trajectories,
    embedding: &Embedding,
    discontinuities: &Discontinuities,
    merge_threshold: f64,
    min_cluster: usize,
) -> Clusters {
    let mut label = rotate(embedding);
    let strays = release_strays(&mut label, discontinuities, merge_threshold, min_cluster);
    spread_labels(&mut label, discontinuities, |i| strays[i]);
    merge_clusters(&mut label, discontinuities, merge_threshold, min_cluster);
    spread_labels(&mut label, discontinuities, |_| true);
    canonical(tracks, label)
}

/// The segmentation of Figure 1(c): connected components of the edges with `d` at most `threshold`.
pub fn threshold_segmentation(tracks: &Trajectories, discontinuities: &Discontinuities, threshold: f64) -> Clusters {
    let mut parent: Vec<u32> = (0..tracks.len() as u32).collect();
    for (&(i, j), &d) in discontinuities.neighborhoods.pairs.iter().zip(&discontinuities.d) {
        if d <= threshold {
            let (a, b) = (root(&mut parent, i), root(&mut parent, j));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    let label = (0..tracks.len() as u32).map(|i| root(&mut parent, i)).collect();
    canonical(tracks, label)
}

/// Takes the label from small pieces of a cluster and tells which trajectories these are: groups of fewer than `min_cluster` trajectories that no edge with a discontinuity
/// below `threshold` joins to the cluster's largest group.
///
/// A single trajectory of one object that the rotation gave to another object's cluster has weak discontinuities to its
/// surroundings, and would make the two objects neighbours without a border between them.
fn release_strays(
    label: &mut [u32],
    discontinuities: &Discontinuities,
    threshold: f64,
    min_cluster: usize,
) -> Vec<bool> {
    let mut parent: Vec<u32> = (0..label.len() as u32).collect();
    for (&(i, j), &d) in discontinuities.neighborhoods.pairs.iter().zip(&discontinuities.d) {
        if d < threshold && label[i as usize] == label[j as usize] {
            let (a, b) = (root(&mut parent, i), root(&mut parent, j));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    let piece: Vec<usize> = (0..label.len() as u32).map(|i| root(&mut parent, i) as usize).collect();
    let mut size = vec![0_usize; label.len()];
    piece.iter().for_each(|&p| size[p] += 1);
    let clusters = label.iter().filter(|&&l| l != UNLABELLED).max().map_or(0, |&l| l as usize + 1);
    let mut largest = vec![0_usize; clusters];
    for (&l, &p) in label.iter().zip(&piece).filter(|&(&l, _)| l != UNLABELLED) {
        largest[l as usize] = largest[l as usize].max(size[p]);
    }
    let mut stray = vec![false; label.len()];
    for (i, (l, &p)) in label.iter_mut().zip(&piece).enumerate().filter(|(_, (l, _))| **l != UNLABELLED) {
        if size[p] < min_cluster && size[p] < largest[*l as usize] {
            (*l, stray[i]) = (UNLABELLED, true);
        }
    }
    stray
}

fn root(parent: &mut [u32], mut i: u32) -> u32 {
    while parent[i as usize] != i {
        parent[i as usize] = parent[parent[i as usize] as usize];
        i = parent[i as usize];
    }
    i
}

/// Gives the unlabelled trajectories that are `wanted` the label with which their neighbours hold them most, each with the weight
/// `1 − d`, ring by ring; where they have no labelled neighbours at all, the label 0.
fn spread_labels(label: &mut [u32], discontinuities: &Discontinuities, wanted: impl Fn(usize) -> bool) {
    loop {
        let mut votes: Vec<(u32, u32, f64)> = Vec::new();
        for (&(i, j), &d) in discontinuities.neighborhoods.pairs.iter().zip(&discontinuities.d) {
            // Trajectories outside the embedding have d = 1 everywhere: their neighbours count alike.
            let weight = 1.0 - d + 1e-6;
            match (label[i as usize], label[j as usize]) {
                (UNLABELLED, UNLABELLED) => {}
                (UNLABELLED, known) if wanted(i as usize) => votes.push((i, known, weight)),
                (known, UNLABELLED) if wanted(j as usize) => votes.push((j, known, weight)),
                _ => {}
            }
        }
        if votes.is_empty() {
            break;
        }
        votes.sort_by_key(|&(i, known, _)| (i, known));
        for ballot in votes.chunk_by(|a, b| a.0 == b.0) {
            let parties =
                ballot.chunk_by(|a, b| a.1 == b.1).map(|same| (same.iter().map(|v| v.2).sum::<f64>(), same[0].1));
            let winner = parties.rev().max_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |(_, known)| known);
            label[ballot[0].0 as usize] = winner;
        }
    }
    for (_, l) in label.iter_mut().enumerate().filter(|(i, l)| **l == UNLABELLED && wanted(*i)) {
        *l = 0;
    }
}

/// Renumbers labels from 0 by falling number of trajectory points, ties by first trajectory.
pub fn canonical(tracks: &Trajectories, label: Vec<u32>) -> Clusters {
    let mut names: Vec<u32> = label.clone();
    names.sort_unstable();
    names.dedup();
    let place = |l: u32| names.binary_search(&l).unwrap_or(0);
    // (points, first trajectory) of each name
    let mut size = vec![(0_usize, usize::MAX); names.len()];
    for (i, &l) in label.iter().enumerate() {
        let entry = &mut size[place(l)];
        *entry = (entry.0 + tracks.points(i).len(), entry.1.min(i));
    }
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by_key(|&k| (usize::MAX - size[k].0, size[k].1));
    let mut rank = vec![0_u32; names.len()];
    for (new, &old) in order.iter().enumerate() {
        rank[old] = new as u32;
    }
    Clusters { count: names.len(), label: label.into_iter().map(|l| rank[place(l)]).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
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
    fn a_stray_trajectory_does_not_bridge_two_objects() {
        // Two objects of three, and one stray beside the first that has the second one's label.
        let mut label = vec![0, 0, 0, 1, 1, 1, 1];
        let mut links = chain(&[0.1, 0.1, 0.1, 0.9, 0.1, 0.1]);
        release_strays(&mut label, &links, 0.7, 3);
        assert_eq!(label, [0, 0, 0, UNLABELLED, 1, 1, 1]);
        links.d[3] = 0.2;
        let mut joined = vec![0, 0, 0, 1, 1, 1, 1];
        release_strays(&mut joined, &links, 0.7, 3);
        assert_eq!(joined, [0, 0, 0, 1, 1, 1, 1], "a piece of its cluster stays");
    }

    #[test]
    fn labels_are_numbered_by_trajectory_points() {
        let mut tracks = still(2, 2);
        tracks.num_frames = 9;
        tracks.push(0, (0..9).map(|_| (0.0, 0.0, 0.0)));
        assert_eq!(canonical(&tracks, vec![7, 7, 3]).label, [1, 1, 0]);
    }

    #[test]
    fn unlabelled_trajectories_follow_the_majority_of_their_neighbours() {
        let mut label = vec![1, UNLABELLED, UNLABELLED, 2, 2];
        let mut links = chain(&[0.0; 4]);
        links.neighborhoods.pairs.extend([(1, 3), (1, 4)]);
        links.d.extend([0.0, 0.0]);
        spread_labels(&mut label, &links, |_| true);
        assert_eq!(label, [1, 2, 2, 2, 2]);
        let mut alone = vec![UNLABELLED];
        spread_labels(&mut alone, &chain(&[]), |_| true);
        assert_eq!(alone, [0]);
    }

    #[test]
    fn weak_discontinuities_count_more_than_many_neighbours() {
        let mut label = vec![0, UNLABELLED, 1, 1, 1];
        let mut links = chain(&[0.1, 0.95, 0.1, 0.1]);
        links.neighborhoods.pairs.extend([(1, 3), (1, 4)]);
        links.d.extend([0.95, 0.95]);
        spread_labels(&mut label, &links, |_| true);
        assert_eq!(label[1], 0);
    }

    #[test]
    fn no_trajectories_give_no_clusters() {
        let clusters = discretize(&still(0, 3), &Embedding::default(), &chain(&[]), 0.7, 20);
        assert_eq!(clusters, Clusters::default());
    }
}
