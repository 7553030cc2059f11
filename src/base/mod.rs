//! Tools for all other rooms: errors, parameters, images, matrices, sorting and triangulation.

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
