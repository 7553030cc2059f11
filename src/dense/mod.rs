//! From frames to superpixels, and from labelled trajectories to a label for each.

pub mod contour;
pub mod cut;
pub mod superpixel;
