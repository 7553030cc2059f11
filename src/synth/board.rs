//! The board on which a scene is laid out, fitted into the frame, and the swing of its camera.

use super::affine::{Affine, sin_turns};
use super::brush::Noise;
use super::scene::Scene;

/// A board with its origin at the upper left corner.
pub(super) struct Board {
    /// From board units to pixels.
    pub view: Affine,
    /// Pixels per unit.
    pub density: f32,
    /// The middle of the clip, in frames.
    pub middle: f64,
    /// Left, top, right and bottom of the visible part of the board in all frames.
    pub visible: [f32; 4],
    pub noise: Noise,
}

impl Board {
    /// Fits a board of `size` units into the frame, before a camera with a pan of `pan_speed` units per frame. The visible part
    /// has a margin of `reach_factor` times the camera's reach and two units at the sides, and of `margin_y` units above and
    /// below.
    pub(super) fn new(
        scene: &Scene,
        size: [f64; 2],
        pan_speed: f64,
        [reach_factor, margin_y]: [f64; 2],
        seed: u64,
    ) -> Self {
        let (width, height) = (scene.size().0 as f64, scene.size().1 as f64);
        let scale = (width / size[0]).min(height / size[1]);
        let view = Affine::translation(-0.5 * size[0], -0.5 * size[1])
            .then(&Affine::scaling(scale, scale))
            .then(&Affine::translation(0.5 * (width - 1.0), 0.5 * (height - 1.0)));
        let middle = 0.5 * (scene.num_frames() as f64 - 1.0);
        let noise = Noise(crate::rng::mix(seed));
        let mut board = Self { view, density: scale as f32, middle, visible: [0.0; 4], noise };
        let reach = (0..=scene.num_frames()).map(|t| board.drift(t as f64, pan_speed).abs()).fold(0.0, f64::max);
        let half = [0.5 * width / scale + reach_factor * reach + 2.0, 0.5 * height / scale + margin_y];
        let corner = |sign: f64| [0, 1].map(|k| (0.5 * size[k] + sign * half[k]) as f32);
        let ([left, top], [right, bottom]) = (corner(-1.0), corner(1.0));
        board.visible = [left, top, right, bottom];
        board
    }

    /// Returns the displacement since the middle of the clip at `speed` units per frame; it swings back in 360 frames.
    pub(super) fn drift(&self, t: f64, speed: f64) -> f64 {
        speed * 360.0 / std::f64::consts::TAU * sin_turns((t - self.middle) / 360.0)
    }

    /// Returns the pose at a point of the board, not moved by the camera.
    pub(super) fn pose(&self, x: f64, y: f64) -> Affine {
        Affine::translation(x, y).then(&self.view)
    }

    /// Returns the size of the finest grain that survives resampling, in units.
    pub(super) fn finest(&self) -> f32 {
        2.4 / self.density
    }
}
