//! Colour models and alpha-expansion of `src/dense/cut`, for the refinement of borders.

#[path = "../src/dense/cut/colour.rs"]
mod colour;
#[path = "../src/dense/cut/expansion.rs"]
mod expansion;
#[path = "../src/dense/cut/maxflow.rs"]
mod maxflow;

pub(crate) use colour::{Colour, Corners, Histogram, UNSEEN_SHARE};
pub(crate) use expansion::{Potts, minimize, to_steps};
