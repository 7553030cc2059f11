//! What every other room may use: errors, parameters, images, matrices and small tools.

pub(crate) mod delaunay;
pub(crate) mod error;
pub(crate) mod grid;
pub mod image;
pub(crate) mod order;
pub mod params;
#[doc(hidden)]
pub mod rng;
#[doc(hidden)]
pub mod sets;
pub mod sparse;
