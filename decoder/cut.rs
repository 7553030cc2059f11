//! What borders are moved with: colours and the expansion of `src/dense/cut`.

#[path = "../src/dense/cut/colour.rs"]
mod colour;
#[path = "../src/dense/cut/expansion.rs"]
mod expansion;
#[path = "../src/dense/cut/maxflow.rs"]
mod maxflow;

pub(crate) use colour::{Colour, Corners, Histogram, UNSEEN_SHARE};
pub(crate) use expansion::{Expansion, Potts, to_steps};
