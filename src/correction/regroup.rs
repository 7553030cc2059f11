//! Clusters that agree with corrected labels.

use crate::discretize::Clusters;
use crate::trajectory::Trajectories;

/// Clusters of which each has one mask label, and what has become of those before.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Regrouped {
    /// The clusters, by the law of [`Clusters`].
    pub clusters: Clusters,
    /// Mask label of each.
    pub of_cluster: Vec<u8>,
    /// For each cluster before, the one that stands for it: of those with its label the largest, without any the
    /// largest of all.
    pub heir: Vec<u32>,
}

/// Parts the clusters whose trajectories now have different labels. `before` has the label of each cluster, `label`
/// the label of each trajectory.
pub(crate) fn regroup(tracks: &Trajectories, clusters: &Clusters, before: &[u8], label: &[u8]) -> Regrouped {
    let part = clusters.label.iter().zip(label).map(|(&c, &l)| c << 8 | u32::from(l)).collect();
    let parted = Clusters::from_labels(tracks, part);
    let mut of_cluster = vec![0; parted.count];
    // Whether the heir has another label, and its number, which is lower the larger it is.
    let mut heir = vec![(true, u32::MAX); clusters.count];
    for ((&new, &old), &l) in parted.label.iter().zip(&clusters.label).zip(label) {
        of_cluster[new as usize] = l;
        let best = &mut heir[old as usize];
        *best = (*best).min((before.get(old as usize) != Some(&l), new));
    }
    Regrouped { clusters: parted, of_cluster, heir: heir.into_iter().map(|h| h.1).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clusters_part_where_their_labels_do_and_leave_an_heir() {
        let mut tracks = Trajectories::empty(1, (9, 9));
        (0..9).for_each(|k| tracks.push(0, [(k as f32, 0.0, 0.0)]));
        let clusters = Clusters { count: 3, label: vec![0, 0, 0, 0, 1, 1, 1, 2, 2] };
        let found = regroup(&tracks, &clusters, &[0, 1, 2], &[0, 0, 0, 0, 1, 4, 4, 5, 5]);
        assert_eq!(found.clusters, Clusters { count: 4, label: vec![0, 0, 0, 0, 3, 1, 1, 2, 2] });
        assert_eq!((found.of_cluster, found.heir), (vec![0, 4, 5, 1], vec![0, 3, 2]));
        assert_eq!(regroup(&Trajectories::default(), &Clusters::default(), &[], &[]), Regrouped::default());
    }
}
