//! Synthetic scenes with known masks and flow, for tests, benchmarks and the demo's first screen.
//!
//! In: a size in pixels, a number of frames and a seed. Out: for each frame the image ([`Scene::frame`]), the object of each
//! pixel ([`Scene::mask`]) and the motion of each visible point ([`Scene::flow`]). No file is read.
//!
//! A scene is a stack of layers, painted from back to front. A layer is a sprite, painted once with colour and
//! the signed distance to the edge of its shape, and a pose for each frame: an affine map from the sprite's units to
//! pixels:
//!
//! ```text
//! frame   each layer over the ones behind it, weighted by coverage = clamp(½ − distance, 0, 1): sub-pixel motion, soft edges
//! mask    the object of the frontmost layer that covers at least half of the pixel
//! flow    that layer's pose at t + 1 after the inverse of its pose at t, less the pixel's position: exact
//! ```
//!
//! Affine maps suffice: a ground plane seen by a camera that moves sideways is a sheared layer, a walking person a chain of
//! rotated layers (`person`).
//!
//! The bytes are the same on every target: they depend on sums, products, square roots and integer hashes only (see
//! `affine::sin_turns`). **Cost**: O(area of the layers) per frame, 16 bytes of memory per texel. **Limits**: no shadows, no
//! motion blur, no change of light; objects are flat.

mod affine;
mod brush;
mod entangled;
mod landscape;
mod person;
mod scene;
mod toys;

pub use scene::Scene;
