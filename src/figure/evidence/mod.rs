//! Log-odds that two clusters are one object, and that a cluster is an object.
//!
//! In: trajectories with labels and discontinuities, the camera's motion, pairs that connectedness separates. Out: merged
//! clusters, and the log-odds of each cluster to be an object, both in `log_odds`.
//!
//! Both are weighted sums of a few terms, fitted by logistic regression on clips with true masks (`weights`; `bench fit`
//! writes the table).
//!
//! **Merging.** The terms of two neighbouring clusters: mean discontinuity along the common border (section 2.3 of the
//! paper); by how much one affine motion for both fits worse than one each (model selection as in Torr, Philosophical
//! Transactions 1998), and the residual of one each; the difference of their contrasts to the camera's motion. The
//! likeliest pair is merged and its terms recomputed, as the paper does with discontinuities alone: greedy edge contraction as in
//! Keuper, Andres and Brox (ICCV 2015). The threshold is lower for small pieces, since the cost of a wrong merge grows
//! with the size. Where connectedness separates a part of the border, fixed log-odds replace the sum in proportion.
//!
//! **Objects.** Moving camera: a cluster's share of the frame border for its size, since the scene runs on beyond the frame,
//! and its contrast to the camera's motion; more than its share of the border always means scene. Still camera: its distance
//! from the background plate.
//!
//! Cost: O(points) for the sums, which add up under merging, and O(clusters) for each merge. It fails where two objects
//! move by one affine motion, and on objects that fill the frame border.

mod log_odds;
mod weights;

#[doc(hidden)]
pub use log_odds::ClusterPair;
pub use log_odds::EvidenceInput;
pub(crate) use log_odds::{ClusterCues, UNLABELLED, cluster_pairs, merge_by_evidence, motion_contrasts};
