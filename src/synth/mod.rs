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
mod board;
mod brush;
mod entangled;
mod landscape;
mod person;
mod scene;

pub use scene::Scene;

use affine::Affine;
use brush::{Colour, Noise, disc, shade};
use scene::Sprite;

/// Largest displacement of a plane, in pixels, to bound its memory. Chosen by eye.
const MAX_REACH_PX: f64 = 4096.0;
/// Colours of the background and the object, chosen by eye.
const PLANE_COLOURS: [Colour; 2] = [[150.0, 140.0, 120.0], [110.0, 130.0, 160.0]];

impl Scene {
    #[doc(hidden)]
    /// Creates a textured plane in front of another, which move by `front` and `back` pixels per frame. Object 1 is the front
    /// plane: the right half of the frame in the middle frame of the clip.
    pub fn two_planes(
        width: usize,
        height: usize,
        num_frames: usize,
        back: (f64, f64),
        front: (f64, f64),
        seed: u64,
    ) -> Self {
        let mut scene = Self::new(width, height, num_frames);
        let middle = 0.5 * (num_frames as f64 - 1.0);
        let reach =
            (middle + 1.0) * [back.0, back.1, front.0, front.1].map(f64::abs).iter().copied().fold(0.0, f64::max);
        let reach = reach.min(MAX_REACH_PX) as f32 + 2.0;
        let bounds = [-reach, -reach, scene.size().0 as f32 + reach, scene.size().1 as f32 + reach];
        let edge = 0.5 * scene.size().0 as f32 - 0.25;
        for (k, (u, v)) in [back, front].into_iter().enumerate() {
            let distance = |x: f32| if k == 0 { -1e3 } else { edge - x };
            let paint = |x, y| (textured(PLANE_COLOURS[k], Noise(crate::rng::mix(seed + k as u64)), x, y), distance(x));
            let sprite = scene.add_sprite(Sprite::paint(bounds, 1.0, paint));
            scene.add_layer(sprite, k as u8, |t| Affine::translation(u * (t - middle), v * (t - middle)));
        }
        scene
    }

    /// Creates a scene of a disc on a textured plane, without motion. Object 1 is the disc.
    #[doc(hidden)] // For tests and benchmarks.
    pub fn still(size: (usize, usize), num_frames: usize, seed: u64) -> Self {
        Self::moving_disc(size, num_frames, 0.0, seed)
    }

    /// Creates a scene of a disc that moves by `speed` pixels a frame to the right before a textured plane without motion; it
    /// starts in the middle of the frame. Object 1 is the disc.
    pub(crate) fn moving_disc((width, height): (usize, usize), num_frames: usize, speed: f64, seed: u64) -> Self {
        let mut scene = Self::new(width, height, num_frames);
        let (right, bottom) = (scene.size().0 as f32, scene.size().1 as f32);
        let centre = (0.5 * right, 0.5 * bottom);
        for k in 0..2_usize {
            let noise = Noise(crate::rng::mix(seed + k as u64));
            let sprite = Sprite::paint([0.0, 0.0, right, bottom], 1.0, |x, y| {
                (textured(PLANE_COLOURS[k], noise, x, y), if k == 0 { -1e3 } else { disc(x, y, centre, 0.3 * bottom) })
            });
            let sprite = scene.add_sprite(sprite);
            scene.add_layer(sprite, k as u8, |t| Affine::translation(k as f64 * speed * t, 0.0));
        }
        scene
    }
}

fn textured(colour: Colour, noise: Noise, x: f32, y: f32) -> Colour {
    shade(colour, 0.6 * noise.fractal(x, y, 24.0, 3.0))
}
