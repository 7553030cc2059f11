//! Planes, frames and the filters that several stages share.

mod decode;
mod filter;
mod frame;
mod plane;

pub use filter::{gaussian_blur, sample_bilinear};
pub use frame::{Frame, MAX_PIXELS, MAX_SIDE};
pub use plane::Plane;
