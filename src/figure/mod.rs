//! What is an object: what stands out before the camera's motion, in which pieces and clusters, and what the background
//! says.

pub mod background;
pub mod camera;
pub mod connectedness;
pub mod discretize;
#[doc(hidden)]
pub mod evidence;
pub(crate) mod judge;
pub(crate) mod objects;
pub mod saliency;
