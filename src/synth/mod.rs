//! Scenes made by rule, with known masks and known flow: for tests, benchmarks and the demo's first screen.
//!
//! In: a size in pixels, a number of frames and a seed. Out: for each frame the image ([`Scene::frame`]), which object
//! each pixel belongs to ([`Scene::mask`]) and where each visible point goes ([`Scene::flow`]). No file is read.
//!
//! A scene is a stack of layers, painted from back to front. A layer is a sprite, painted once with colour and
//! the signed distance to the edge of its shape, and a pose for each frame: an affine map from the sprite's units to
//! pixels. Everything follows from these:
//!
//! ```text
//! frame   each layer over the ones behind it, weighted by coverage = clamp(½ − distance, 0, 1): sub-pixel motion, soft edges
//! mask    the object of the frontmost layer that covers at least half of the pixel
//! flow    that layer's pose at t + 1 after the inverse of its pose at t, less the pixel's position: exact
//! ```
//!
//! A ground plane seen by a camera that moves sideways is a sheared layer, a walking figure a chain of rotated ones
//! (`figure`), so affine maps are all that is needed.
//!
//! The bytes are the same on every target: only sums, products, square roots and integer hashes go into them
//! (see `affine::sin_turns`). Cost: O(layers' area) a frame, 16 bytes a texel of memory.
//!
//! Limits: no shadows, no motion blur, no change of light; objects are flat.

mod affine;
mod brush;
mod entangled;
mod figure;
mod landscape;
mod scene;
mod toys;

pub use scene::Scene;
