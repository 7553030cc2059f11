//! Input and output of the cut.

use crate::superpixel::Superpixels;
use crate::trajectory::Trajectories;

/// Label of a trajectory without a known one.
pub(crate) const UNKNOWN: u32 = u32::MAX;

/// Label of a trajectory that moves unlike the labelled ones around it.
pub(crate) const OUTLIER: u32 = u32::MAX - 1;

/// Superpixels, labelled trajectories and evidence. Positions are in pixels of the superpixels' frames.
#[derive(Debug, Clone, Copy)]
pub struct CutInput<'a> {
    /// One partition for each frame.
    pub superpixels: &'a [Superpixels],
    /// Trajectories; there may be more than were clustered.
    pub tracks: &'a Trajectories,
    /// Label of each trajectory. Those that are not below `num_labels` do not vote, but for `u32::MAX - 1` (moves unlike all
    /// around it), which votes for all objects; their trajectories still link superpixels of consecutive frames.
    pub label: &'a [u32],
    /// Number of labels.
    pub num_labels: usize,
    /// `true` for each label that is an object, for `outlier_weight`; may be empty.
    pub objects: &'a [bool],
    /// Log-odds of each superpixel to be an object's, frame by frame: a cost of the background's labels where positive, of
    /// the objects' where negative; may be empty.
    pub evidence: &'a [f32],
    /// The same by appearance, learned from an earlier cut; empty in the first.
    pub appearance: &'a [f32],
}

/// Label of each superpixel of each frame.
///
/// Law: `labels[t].len() == superpixels[t].count`; every label is below the number of labels, or 0 if there are none.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CutLabels {
    /// Frame by frame, superpixel by superpixel.
    pub labels: Vec<Vec<u32>>,
}
