//! A scene: its layers, and their frames, masks and flow.

use super::affine::Affine;
use super::brush::{Colour, blend};
use crate::flow::FlowField;
use crate::image::{Frame, Plane};

/// Longest side of a scene in pixels, to bound its memory; longer ones are clamped. Chosen by eye.
const MAX_SIDE: usize = 4096;

/// A clip with known masks and flow.
#[derive(Debug, Clone)]
pub struct Scene {
    size: (usize, usize),
    num_frames: usize,
    sprites: Vec<Sprite>,
    layers: Vec<Layer>,
}

impl Scene {
    /// Creates an empty scene; the first layer added becomes the backdrop and covers every pixel. Sides are clamped to
    /// `1..=`[`MAX_SIDE`].
    pub(crate) fn new(width: usize, height: usize, num_frames: usize) -> Self {
        let size = (width.clamp(1, MAX_SIDE), height.clamp(1, MAX_SIDE));
        Self { size, num_frames, sprites: Vec::new(), layers: Vec::new() }
    }

    /// Adds a sprite for one or more layers and returns its number.
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

    /// Returns width and height in pixels.
    pub fn size(&self) -> (usize, usize) {
        self.size
    }

    /// Returns the number of frames.
    pub fn num_frames(&self) -> usize {
        self.num_frames
    }

    /// Returns the number of objects without the background, which is the largest value of masks.
    #[doc(hidden)] // For tests and benchmarks.
    pub fn num_objects(&self) -> usize {
        self.layers.iter().map(|l| usize::from(l.label)).max().unwrap_or(0)
    }

    /// Renders frame `t`; after the last frame nothing moves.
    pub fn frame(&self, t: usize) -> Frame {
        let (width, height) = self.size;
        let mut canvas: Vec<Colour> = vec![[0.0; 3]; width * height];
        self.visit_layers(t, &mut |_, x, y, colour, coverage| {
            let pixel = &mut canvas[y * width + x];
            *pixel = blend(*pixel, colour, coverage);
        });
        let rgb = canvas.iter().flat_map(|pixel| pixel.map(|c| (c + 0.5) as u8)).collect();
        Frame::from_rgb(rgb, width, height).expect("sides are checked in new")
    }

    /// Returns the object of each pixel at frame `t`; 0 is the background.
    pub fn mask(&self, t: usize) -> Plane<u8> {
        self.frontmost(t).map(|layer| self.layers.get(usize::from(layer)).map_or(0, |l| l.label))
    }

    /// Computes the true flow from frame `t` to frame `t + 1`, in pixels. A point that becomes occluded or leaves the frame
    /// has the motion of its surface.
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

    /// Returns the number of the frontmost layer that covers at least half of each pixel.
    fn frontmost(&self, t: usize) -> Plane<u16> {
        let mut plane = Plane::filled(self.size.0, self.size.1, 0);
        self.visit_layers(t, &mut |layer, x, y, _, coverage| {
            if coverage >= 0.5 {
                plane[(x, y)] = layer as u16;
            }
        });
        plane
    }

    /// Calls `visit(layer, x, y, colour, coverage)` for every pixel of every layer, from back to front.
    fn visit_layers(&self, t: usize, visit: &mut dyn FnMut(usize, usize, usize, Colour, f32)) {
        for (index, layer) in self.layers.iter().enumerate() {
            let sprite = &self.sprites[layer.sprite];
            layer.visit_pixels(sprite, t, self.size.0, self.size.1, index == 0, &mut |x, y, colour, coverage| {
                visit(index, x, y, colour, coverage);
            });
        }
    }
}

// Sprites and layers: painted once, then moved.

/// A painted shape: colour and signed distance to its edge on a grid of texels.
///
/// Distances are in the sprite's own units, negative inside. Between texels both are interpolated bilinearly; the edge is
/// defined as the zero line of the interpolated distance, so that masks and flow are exact.
#[derive(Debug, Clone)]
pub(crate) struct Sprite {
    texels: Plane<[f32; 4]>,
    /// From the sprite's units to texels.
    to_texels: Affine,
}

impl Sprite {
    /// Paints a sprite from `(left, top)` to `(right, bottom)` in its own units with `density` texels per unit: `paint`
    /// returns colour and signed distance at a point.
    pub(crate) fn paint(bounds: [f32; 4], density: f32, mut paint: impl FnMut(f32, f32) -> (Colour, f32)) -> Self {
        Self::paint_dyn(bounds, density, &mut paint)
    }

    fn paint_dyn(bounds: [f32; 4], density: f32, paint: &mut dyn FnMut(f32, f32) -> (Colour, f32)) -> Self {
        let [left, top, right, bottom] = bounds;
        // One texel of margin on every side, so that an edge on the bounds is still smooth.
        let width = ((right - left) * density).ceil() as usize + 3;
        let height = ((bottom - top) * density).ceil() as usize + 3;
        let texels = Plane::from_fn(width, height, |x, y| {
            let position = |texel: usize, begin: f32| begin + (texel as f32 - 1.0) / density;
            let ([r, g, b], distance) = paint(position(x, left), position(y, top));
            [r, g, b, distance]
        });
        let density = f64::from(density);
        let to_texels = Affine::translation(f64::from(-left), f64::from(-top))
            .then(&Affine::scaling(density, density))
            .then(&Affine::translation(1.0, 1.0));
        Self { texels, to_texels }
    }

    /// Interpolates colour and distance at a texel position, clamped to the sprite.
    fn sample(&self, x: f32, y: f32) -> [f32; 4] {
        let (width, height) = (self.texels.width(), self.texels.height());
        let (x, y) = (x.clamp(0.0, (width - 1) as f32), y.clamp(0.0, (height - 1) as f32));
        let (column, row) = ((x as usize).min(width - 2), (y as usize).min(height - 2));
        let (fx, fy) = (x - column as f32, y - row as f32);
        let top = &self.texels.row(row)[column..column + 2];
        let bottom = &self.texels.row(row + 1)[column..column + 2];
        std::array::from_fn(|c| {
            let above = top[0][c] + fx * (top[1][c] - top[0][c]);
            let below = bottom[0][c] + fx * (bottom[1][c] - bottom[0][c]);
            above + fy * (below - above)
        })
    }
}

/// A sprite in motion.
#[derive(Debug, Clone)]
struct Layer {
    /// Number of the sprite.
    sprite: usize,
    /// The object that it belongs to; 0 is the background.
    label: u8,
    /// From the sprite's units to pixels, for every frame and one more.
    poses: Vec<Affine>,
}

impl Layer {
    /// Returns the motion of this layer from frame `t` to `t + 1` as a map of pixel positions.
    fn step(&self, t: usize) -> Affine {
        let last = self.poses.len() - 1;
        self.poses[t.min(last)].inverse().then(&self.poses[(t + 1).min(last)])
    }

    /// Calls `visit(x, y, colour, coverage)` for every pixel of a frame of `width × height` pixels that the layer covers at
    /// frame `t`, at least in part. A backdrop covers every pixel in full.
    fn visit_pixels(
        &self,
        sprite: &Sprite,
        t: usize,
        width: usize,
        height: usize,
        is_backdrop: bool,
        visit: &mut dyn FnMut(usize, usize, Colour, f32),
    ) {
        let pose = self.poses[t.min(self.poses.len() - 1)];
        let to_texels = pose.inverse().then(&sprite.to_texels);
        let pixels_per_unit = pose.determinant().abs().sqrt() as f32;
        let (columns, rows) =
            if is_backdrop { (0..width, 0..height) } else { extent(&to_texels.inverse(), sprite, width, height) };
        let origin = to_texels.apply(0.0, 0.0);
        let right = to_texels.apply(1.0, 0.0);
        let (step_x, step_y) = ((right.0 - origin.0) as f32, (right.1 - origin.1) as f32);
        for y in rows {
            let (begin_x, begin_y) = to_texels.apply(0.0, y as f64);
            for x in columns.clone() {
                let [r, g, b, distance] =
                    sprite.sample(begin_x as f32 + x as f32 * step_x, begin_y as f32 + x as f32 * step_y);
                let coverage = if is_backdrop { 1.0 } else { (0.5 - distance * pixels_per_unit).clamp(0.0, 1.0) };
                if coverage > 0.0 {
                    visit(x, y, [r, g, b], coverage);
                }
            }
        }
    }
}

/// Returns the columns and rows of a frame of `width × height` pixels that a sprite can cover.
fn extent(
    from_texels: &Affine,
    sprite: &Sprite,
    width: usize,
    height: usize,
) -> (std::ops::Range<usize>, std::ops::Range<usize>) {
    let (right, bottom) = ((sprite.texels.width() - 1) as f64, (sprite.texels.height() - 1) as f64);
    let corners = [(0.0, 0.0), (right, 0.0), (0.0, bottom), (right, bottom)].map(|(x, y)| from_texels.apply(x, y));
    let range = |coordinate: &dyn Fn(&(f64, f64)) -> f64, end: usize| {
        let low = corners.iter().map(coordinate).fold(f64::INFINITY, f64::min);
        let high = corners.iter().map(coordinate).fold(f64::NEG_INFINITY, f64::max);
        // Casts saturate, so that a sprite outside the frame gives an empty range.
        (low.ceil().max(0.0) as usize)..((high.floor() + 1.0).max(0.0) as usize).min(end)
    };
    (range(&|c| c.0, width), range(&|c| c.1, height))
}
