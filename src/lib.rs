//! TraceCut finds the moving objects in a video, without a trained model and without a click.

pub mod affinity;
pub mod connectedness;
pub mod contour;
pub mod correction;
pub mod cut;
pub mod delaunay;
pub mod discontinuity;
pub mod discretize;
pub mod embedding;
mod error;
pub mod eval;
pub mod flow;
pub mod identity;
pub mod image;
pub mod order;
pub mod params;
pub mod pipeline;
pub mod rng;
pub mod saliency;
mod sets;
pub mod shot;
pub mod sparse;
pub mod still;
pub mod superpixel;
pub mod synth;
pub mod trajectory;
#[cfg(all(target_arch = "wasm32", feature = "wasm"))]
pub mod wasm;

pub use error::Error;
pub use params::Params;
pub use pipeline::{Progress, Session, Stage, Step};

/// The README's Rust, tested with the examples in comments.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
