//! What is known of clusters, weighed: which of them are one thing.
//!
//! In: trajectories with their labels and discontinuities, the camera's motion. Out: for each two neighbouring clusters
//! the log-odds that they are one (`along_borders`), by which they are merged (`discretize`).
//!
//! It is a sum of three terms with weights that were fitted on clips with true masks, by logistic regression
//! (`weights`; `tracecut eval fit` makes the table). None of them decides alone, and none has a threshold: mean
//! discontinuity along the common border (section 2.3 of the paper), how much worse one affine motion explains two
//! clusters than one each (model selection as in Torr, Philosophical Transactions 1998), and whether they differ in
//! how far they are from the camera's motion. What connectedness keeps apart is against it whatever these say.
//!
//! Merging goes on while the mean along a border speaks for it, as in the paper with discontinuities alone: greedy
//! contraction for the best partition, as in Keuper, Andres and Brox (ICCV 2015). Colours, and what single affine motions
//! leave over, were tried as terms: kinds of clips that were left out of the fit lose by them.

mod affine;
mod object;
mod pair;
mod unite;
mod weights;

pub(crate) use object::{Signs, strangeness};
pub use pair::Known;
#[doc(hidden)]
pub use pair::Pair;
pub(crate) use pair::pairs;
pub(crate) use unite::unite;

/// The label of a trajectory that has none yet.
pub(crate) const UNLABELLED: u32 = u32::MAX;
