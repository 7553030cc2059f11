//! What the cut is made from, and what it makes.

use crate::superpixel::Superpixels;
use crate::trajectory::Trajectories;

/// The label of a trajectory of which none is known.
pub const UNKNOWN: u32 = u32::MAX;

/// The label of a trajectory that moves like none of the labelled ones around it.
pub const STRANGER: u32 = u32::MAX - 1;

/// What the cut is made from. Positions are in pixels of the superpixels' frames.
#[derive(Debug, Clone, Copy)]
pub struct CutInput<'a> {
    /// One partition for each frame.
    pub superpixels: &'a [Superpixels],
    /// Trajectories; there may be more than were clustered.
    pub tracks: &'a Trajectories,
    /// Label of each trajectory. A [`STRANGER`] votes for all objects. Others that are not below `num_labels`, such as
    /// [`UNKNOWN`], vote for nothing; their trajectories still link superpixels of consecutive frames.
    pub label: &'a [u32],
    /// Number of labels.
    pub num_labels: usize,
    /// Whether each label is an object, for `outlier_weight`; may be empty.
    pub objects: &'a [bool],
    /// What else speaks for an object in each superpixel, numbered frame by frame, and against it where negative: a cost
    /// of the labels that are no objects, or of those that are; may be empty.
    pub evidence: &'a [f32],
}

/// A label for each superpixel of each frame.
///
/// Law: `labels[t].len() == superpixels[t].count`; every label is below the number of labels, or 0 if there are none.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CutLabels {
    /// Frame by frame, superpixel by superpixel.
    pub labels: Vec<Vec<u32>>,
}
