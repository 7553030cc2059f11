//! Labels of trajectories, numbered by what they hold.

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

/// Renumbers labels from 0 by falling number of trajectory points, ties by first trajectory.
pub(crate) fn canonical(tracks: &Trajectories, label: Vec<u32>) -> Clusters {
    let mut names: Vec<u32> = label.clone();
    order::sort_by_key(&mut names, |&l| l.into());
    names.dedup();
    let place = |l: u32| names.binary_search(&l).unwrap_or(0);
    // (points, first trajectory) of each name
    let mut size = vec![(0_usize, usize::MAX); names.len()];
    for (i, &l) in label.iter().enumerate() {
        let entry = &mut size[place(l)];
        *entry = (entry.0 + tracks.points(i).len(), entry.1.min(i));
    }
    let mut by_size: Vec<usize> = (0..names.len()).collect();
    order::sort_by_key(&mut by_size, |&k| order::pair_key(u32::MAX - size[k].0 as u32, size[k].1 as u32));
    let mut rank = vec![0_u32; names.len()];
    for (new, &old) in by_size.iter().enumerate() {
        rank[old] = new as u32;
    }
    Clusters { count: names.len(), label: label.into_iter().map(|l| rank[place(l)]).collect() }
}
