//! Clusters that agree with corrected labels.

use crate::discretize::Clusters;
use crate::trajectory::Trajectories;

/// Clusters of one mask label each, and their relation to the clusters before.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct RegroupedClusters {
    pub(crate) clusters: Clusters,
    /// The mask label of each cluster.
    pub(crate) of_cluster: Vec<u8>,
    /// The new cluster that replaces each old one: the largest part with its label, or else its largest part.
    pub(crate) heir: Vec<u32>,
}

/// Splits the clusters whose trajectories now have different labels. `old_labels` has the old label of each cluster, `label`
/// the new label of each trajectory.
pub(crate) fn regroup(
    tracks: &Trajectories,
    clusters: &Clusters,
    old_labels: &[u8],
    label: &[u8],
) -> RegroupedClusters {
    let part = clusters.label.iter().zip(label).map(|(&c, &l)| c << 8 | u32::from(l)).collect();
    let regrouped = Clusters::from_labels(tracks, part);
    let mut of_cluster = vec![0; regrouped.count];
    // Whether the heir has another label, and its number: larger clusters have lower numbers.
    let mut heir = vec![(true, u32::MAX); clusters.count];
    for ((&new, &old), &l) in regrouped.label.iter().zip(&clusters.label).zip(label) {
        of_cluster[new as usize] = l;
        let best = &mut heir[old as usize];
        *best = (*best).min((old_labels.get(old as usize) != Some(&l), new));
    }
    RegroupedClusters { clusters: regrouped, of_cluster, heir: heir.into_iter().map(|h| h.1).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clusters_split_by_label_and_leave_an_heir() {
        let mut tracks = Trajectories::empty(1, (9, 9));
        (0..9).for_each(|k| tracks.push(0, [(k as f32, 0.0, 0.0)]));
        let clusters = Clusters { count: 3, label: vec![0, 0, 0, 0, 1, 1, 1, 2, 2] };
        let regrouped = regroup(&tracks, &clusters, &[0, 1, 2], &[0, 0, 0, 0, 1, 4, 4, 5, 5]);
        assert_eq!(regrouped.clusters, Clusters { count: 4, label: vec![0, 0, 0, 0, 3, 1, 1, 2, 2] });
        assert_eq!((regrouped.of_cluster, regrouped.heir), (vec![0, 4, 5, 1], vec![0, 3, 2]));
        assert_eq!(regroup(&Trajectories::default(), &Clusters::default(), &[], &[]), RegroupedClusters::default());
    }
}
