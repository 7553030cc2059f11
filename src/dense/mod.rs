//! Contours and superpixels of frames, and the labelling of superpixels.

pub mod contour;
pub mod cut;
pub mod superpixel;
