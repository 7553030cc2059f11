//! Planes, frames, run lengths, and filters that several stages share.

mod decode;
mod filter;
mod frame;
mod lab;
mod plane;
mod runs;

pub(crate) use self::{
    filter::{BilinearAxis, BilinearPoint, convolve_symmetric},
    frame::{Picture, fit_within},
    lab::lab,
    runs::Runs,
};
#[doc(hidden)] // For the command line, the Python package and benchmarks.
pub use crate::error::{MAX_PIXELS, MAX_SIDE};
#[doc(hidden)]
pub use filter::{gaussian_blur, sample_bilinear};
pub use frame::Frame;
pub use plane::Plane;
