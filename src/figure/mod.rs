//! What is an object: what stands out before the camera's motion, in which pieces and clusters, and what the background
//! says.

pub(crate) mod background;
pub(crate) mod camera;
pub mod connectedness;
pub mod discretize;
#[doc(hidden)]
pub mod evidence;
pub(crate) mod objects;
pub mod saliency;
