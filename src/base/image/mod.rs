//! Planes, frames and the filters that several stages share.

mod decode;
mod filter;
mod frame;
mod plane;
mod runs;

pub use crate::error::{MAX_PIXELS, MAX_SIDE};
pub(crate) use filter::{Spot, weigh};
#[doc(hidden)]
pub use filter::{gaussian_blur, sample_bilinear};
pub use frame::Frame;
pub(crate) use frame::fit_within;
pub use plane::Plane;
pub(crate) use runs::Runs;
