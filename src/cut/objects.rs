//! Which clusters are objects, and which are the scene behind them.

use super::CutLabels;
use crate::superpixel::Superpixels;

/// The mask label of each cluster.
///
/// Law: 0 is the background; objects are numbered 1, 2, ... by falling number of pixels in the clip.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Objects {
    /// Number of objects.
    pub count: usize,
    /// Mask label of each cluster, 0 for the background.
    pub of_cluster: Vec<u8>,
}

/// Tells objects from background.
pub fn find_objects(superpixels: &[Superpixels], cut: &CutLabels, num_clusters: usize) -> Objects {
    let mut area = vec![0_usize; num_clusters];
    for (s, labels) in superpixels.iter().zip(&cut.labels) {
        for &p in s.label.data() {
            area[labels[p as usize] as usize] += 1;
        }
    }
    let mut order: Vec<usize> = (0..num_clusters).collect();
    order.sort_by_key(|&c| std::cmp::Reverse(area[c]));
    let mut of_cluster = vec![0; num_clusters];
    for (rank, &c) in order.iter().enumerate() {
        of_cluster[c] = rank.min(255) as u8;
    }
    Objects { count: num_clusters.saturating_sub(1), of_cluster }
}
