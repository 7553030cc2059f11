//! Cluster labels of trajectories.

use crate::order;
use crate::trajectory::Trajectories;

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
