//! Trajectories with labels, and the labels that are objects.

use crate::cut::OUTLIER;
use crate::discretize::Clusters;
use crate::trajectory::Trajectories;

/// Trajectories, the label of each, and the labels that are objects. Other labels do not count.
#[derive(Debug, Clone, Copy)]
pub struct SegmentedTracks<'a> {
    /// The trajectories.
    pub tracks: &'a Trajectories,
    /// Label of each trajectory.
    pub label: &'a [u32],
    /// `true` for each label that is an object.
    pub is_object: &'a [bool],
}

impl SegmentedTracks<'_> {
    /// Returns `true` if trajectory `i` is an object's, `None` if it has no label. [`OUTLIER`]s are objects'.
    pub(super) fn is_object_track(&self, i: usize) -> Option<bool> {
        let &label = self.label.get(i)?;
        if label == OUTLIER { Some(true) } else { self.is_object.get(label as usize).copied() }
    }
}

/// Clusters, and which of them are objects.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ObjectClusters {
    pub(crate) clusters: Clusters,
    /// `true` for each cluster that is an object.
    pub(crate) is_object: Vec<bool>,
}
