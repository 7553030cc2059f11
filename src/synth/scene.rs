//! A scene: its layers, and what is seen of them.

use super::affine::Affine;
use super::brush::{Colour, blend};
use super::layer::{Layer, Sprite};
use crate::flow::FlowField;
use crate::image::{Frame, Plane};

/// Longest side of a scene in pixels; larger ones are made this large.
pub(super) const MAX_SIDE: usize = 4096;

/// A clip with known masks and flow.
#[derive(Debug, Clone)]
pub struct Scene {
    size: (usize, usize),
    num_frames: usize,
    sprites: Vec<Sprite>,
    layers: Vec<Layer>,
}

impl Scene {
    /// An empty scene; the first layer added becomes the backdrop and covers every pixel. Sides are clamped to
    /// `1..=`[`MAX_SIDE`].
    pub(crate) fn new(width: usize, height: usize, num_frames: usize) -> Self {
        let size = (width.clamp(1, MAX_SIDE), height.clamp(1, MAX_SIDE));
        Self { size, num_frames, sprites: Vec::new(), layers: Vec::new() }
    }

    /// Adds a sprite and gives its number, for one or more layers to show.
    pub(crate) fn add_sprite(&mut self, sprite: Sprite) -> usize {
        self.sprites.push(sprite);
        self.sprites.len() - 1
    }

    /// Adds a layer in front of all others: sprite number `sprite` as part of object `label` (0: background), whose
    /// pose at frame `t` is `pose(t)`, from the sprite's units to pixels. The pose must be invertible.
    ///
    /// # Panics
    /// If there is no such sprite.
    pub(crate) fn add_layer(&mut self, sprite: usize, label: u8, pose: impl Fn(f64) -> Affine) {
        self.add_layer_dyn(sprite, label, &pose);
    }

    fn add_layer_dyn(&mut self, sprite: usize, label: u8, pose: &dyn Fn(f64) -> Affine) {
        assert!(sprite < self.sprites.len(), "sprite {sprite} (expected 0..{})", self.sprites.len());
        let poses = (0..=self.num_frames).map(|t| pose(t as f64)).collect();
        self.layers.push(Layer { sprite, label, poses });
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (usize, usize) {
        self.size
    }

    /// Number of frames.
    pub fn num_frames(&self) -> usize {
        self.num_frames
    }

    /// Number of objects, background not counted; masks hold values up to this.
    pub fn num_objects(&self) -> usize {
        self.layers.iter().map(|l| usize::from(l.label)).max().unwrap_or(0)
    }

    /// The image at frame `t`; after the last frame, everything stays where it is.
    pub fn frame(&self, t: usize) -> Frame {
        let (width, height) = self.size;
        let mut canvas: Vec<Colour> = vec![[0.0; 3]; width * height];
        self.paint(t, &mut |_, x, y, colour, coverage| {
            let pixel = &mut canvas[y * width + x];
            *pixel = blend(*pixel, colour, coverage);
        });
        let rgb = canvas.iter().flat_map(|pixel| pixel.map(|c| (c + 0.5) as u8)).collect();
        Frame::from_rgb(rgb, width, height).expect("sides are checked in new")
    }

    /// The object that each pixel belongs to at frame `t`: 0 is the background.
    pub fn mask(&self, t: usize) -> Plane<u8> {
        self.frontmost(t).map(|layer| self.layers.get(usize::from(layer)).map_or(0, |l| l.label))
    }

    /// The true motion of what is seen at frame `t` to frame `t + 1`, in pixels. A point that disappears behind
    /// another, or leaves the frame, has the motion of its surface all the same.
    pub fn flow(&self, t: usize) -> FlowField {
        let steps: Vec<Affine> = self.layers.iter().map(|l| l.step(t)).collect();
        let frontmost = self.frontmost(t);
        let (width, height) = self.size;
        let motion = |x: usize, y: usize| {
            let step = steps.get(usize::from(frontmost[(x, y)])).unwrap_or(&Affine::IDENTITY);
            let (to_x, to_y) = step.apply(x as f64, y as f64);
            ((to_x - x as f64) as f32, (to_y - y as f64) as f32)
        };
        FlowField {
            u: Plane::from_fn(width, height, |x, y| motion(x, y).0),
            v: Plane::from_fn(width, height, |x, y| motion(x, y).1),
        }
    }

    /// The number of the frontmost layer that covers at least half of each pixel.
    fn frontmost(&self, t: usize) -> Plane<u16> {
        let mut plane = Plane::filled(self.size.0, self.size.1, 0);
        self.paint(t, &mut |layer, x, y, _, coverage| {
            if coverage >= 0.5 {
                plane[(x, y)] = layer as u16;
            }
        });
        plane
    }

    /// Calls `visit(layer, x, y, colour, coverage)` for every pixel of every layer, from back to front.
    fn paint(&self, t: usize, visit: &mut dyn FnMut(usize, usize, usize, Colour, f32)) {
        for (index, layer) in self.layers.iter().enumerate() {
            let sprite = &self.sprites[layer.sprite];
            layer.cover(sprite, t, self.size, index == 0, &mut |x, y, colour, coverage| {
                visit(index, x, y, colour, coverage);
            });
        }
    }
}
