//! What is known of clusters, weighed: which of them are one thing, and which are objects.
//!
//! In: trajectories with their labels and discontinuities, the camera's motion, what is kept apart. Out: pieces of one
//! thing under one label (`pair`), and what speaks for each cluster to be an object (`pair`).
//!
//! Both are sums of a few terms with weights that were fitted on clips with true masks, by logistic regression
//! (`weights`; `bench fit` makes the table). No term decides alone.
//!
//! **One thing.** Of two neighbouring clusters: mean discontinuity along the common border (section 2.3 of the paper); how
//! much worse one affine motion explains both than one each (model selection as in Torr, Philosophical Transactions
//! 1998), and what one each leaves over; whether they differ in how far they are from the camera's motion. The two for
//! which most speaks are joined and weighed anew, as the paper does with discontinuities alone: greedy contraction for the
//! best partition, as in Keuper, Andres and Brox (ICCV 2015). A small piece is joined more readily than a large one, since
//! what a wrong join costs grows with it. What connectedness keeps apart counts against, in proportion to its part of the
//! border.
//!
//! **Objects.** Where the camera moves: how much of the frame's rim a cluster holds for its size, since the scene runs on
//! beyond the frame, and how far it is from the camera's motion. What holds more of the rim than its share is scene
//! whatever these say: the only bound. Where the camera stands still: how far it is from the background plate.

mod pair;
mod weights;

pub use pair::Known;
#[doc(hidden)]
pub use pair::Pair;
pub(crate) use pair::{Signs, UNLABELLED, pairs, strangeness, unite};
