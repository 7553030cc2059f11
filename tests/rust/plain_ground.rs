//! Drawn clips of a thing that moves over plain ground before a still camera: the mask must not flood it. (Before a moving
//! camera it does: docs/limits.md.)

use image::ExtendedColorType::Rgb8;
use image::ImageEncoder;
use image::codecs::jpeg::JpegEncoder;
use tracecut::image::{Frame, Plane};
use tracecut::rng::Rng;
use tracecut::{Params, Session};

const NUM_FRAMES: usize = 16;
/// Pixels a frame, before scaling.
const SPEED: f32 = 3.0;

/// What changes nothing about who moves.
#[derive(Debug, Clone, Copy)]
struct Variant {
    light: f32,
    /// Largest change of a value by noise.
    noise: usize,
    /// JPEG quality; `None` for exact frames.
    quality: Option<u8>,
    scale: f32,
    /// Where the thing begins, in pixels before scaling.
    start: f32,
}

fn variants() -> [Variant; 20] {
    let plain = Variant { light: 1.0, noise: 2, quality: None, scale: 1.0, start: 40.0 };
    [
        plain,
        Variant { light: 0.7, ..plain },
        Variant { light: 1.25, ..plain },
        Variant { noise: 0, ..plain },
        Variant { noise: 8, ..plain },
        Variant { quality: Some(85), ..plain },
        Variant { quality: Some(50), noise: 4, ..plain },
        Variant { scale: 0.75, ..plain },
        Variant { scale: 1.3, light: 0.85, ..plain },
        Variant { start: 61.5, quality: Some(70), ..plain },
        Variant { light: 0.85, noise: 5, ..plain },
        Variant { light: 1.1, quality: Some(90), ..plain },
        Variant { light: 0.6, scale: 1.15, ..plain },
        Variant { noise: 6, scale: 0.9, ..plain },
        Variant { noise: 3, start: 25.0, ..plain },
        Variant { quality: Some(60), start: 80.0, ..plain },
        Variant { quality: Some(95), scale: 1.1, ..plain },
        Variant { scale: 0.8, start: 52.3, noise: 0, ..plain },
        Variant { light: 1.2, start: 33.7, quality: Some(75), ..plain },
        Variant { light: 0.75, noise: 4, quality: Some(80), scale: 1.2, start: 70.0 },
    ]
}

impl Variant {
    fn size(&self) -> (usize, usize) {
        ((240.0 * self.scale) as usize, (160.0 * self.scale) as usize)
    }

    /// Whether a pixel of frame `t` is on the thing.
    fn is_object(&self, t: usize, x: usize, y: usize) -> bool {
        let (x, y) = (x as f32 / self.scale, y as f32 / self.scale);
        let left = self.start + SPEED * t as f32;
        (left..left + 56.0).contains(&x) && (62.0..98.0).contains(&y)
    }

    fn frame(&self, t: usize) -> Frame {
        let mut rng = Rng::for_stage(t as u64, "plain ground");
        let (width, height) = self.size();
        let mut rgb = Vec::new();
        for i in 0..width * height {
            let (column, row) = (i % width, i / width);
            let (x, y) = (column as f32 / self.scale, row as f32 / self.scale);
            let colour = if self.is_object(t, column, row) {
                texture(x - SPEED * t as f32 + 500.0, y, [150.0, 60.0, 50.0])
            } else if (24.0..136.0).contains(&y) {
                [118.0, 120.0, 116.0]
            } else {
                texture(x, y + 300.0, [80.0, 110.0, 60.0])
            };
            for value in colour {
                let noise = rng.below(2 * self.noise + 1) as f32 - self.noise as f32;
                rgb.push((self.light * value + noise).clamp(0.0, 255.0) as u8);
            }
        }
        let Some(quality) = self.quality else { return Frame::from_rgb(rgb, width, height).unwrap() };
        let mut bytes = Vec::new();
        let encoder = JpegEncoder::new_with_quality(&mut bytes, quality);
        encoder.write_image(&rgb, width as u32, height as u32, Rgb8).unwrap();
        Frame::decode(&bytes).unwrap()
    }
}

/// A colour with patches of 7 pixels around the place, lighter and darker by chance.
fn texture(x: f32, y: f32, colour: [f32; 3]) -> [f32; 3] {
    let cell = (x / 7.0).floor() as i64 * 1000 + (y / 7.0).floor() as i64;
    let change = (tracecut::rng::mix(cell as u64) % 81) as f32 - 40.0;
    colour.map(|value| value + change)
}

#[test]
fn no_mask_floods_plain_ground_before_a_still_camera() {
    for variant in variants() {
        let mut session = Session::new(Params::default()).unwrap();
        (0..NUM_FRAMES).for_each(|t| session.push_frame(variant.frame(t)).unwrap());
        session.run().unwrap();
        let (width, height) = variant.size();
        let mut found = 0;
        for t in 0..NUM_FRAMES {
            let truth = Plane::from_fn(width, height, |x, y| variant.is_object(t, x, y));
            let count = |is_counted: &dyn Fn(bool, u8) -> bool| {
                let labels = session.labels(t).unwrap();
                truth.data().iter().zip(labels.data()).filter(|&(&object, &label)| is_counted(object, label)).count()
            };
            let (mask, object) = (count(&|_, label| label > 0), count(&|object, _| object));
            assert!(mask as f32 <= 1.5 * object as f32, "frame {t} of {variant:?}: {mask} pixels for {object}");
            found += usize::from(count(&|object, label| object && label > 0) > object / 2);
        }
        assert!(found >= NUM_FRAMES - 2, "{variant:?}: found in {found} frames");
    }
}
