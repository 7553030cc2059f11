//! Conversion to CIE Lab, in which equal steps look about equally large.

use super::Frame;
use std::sync::OnceLock;

/// Intervals of the table of the cube root over `0..=1`: the error of lightness is at most 0.0011 of its range.
const ROOT_STEPS: usize = 4096;
/// Size of a and b that is scaled to the ends of `0..=1`. Chosen by eye.
const MAX_CHROMA: f32 = 40.0;
/// Linear RGB to XYZ, each relative to white.
const RGB_TO_XYZ: [[f32; 3]; 3] =
    [[0.433_953, 0.376_219, 0.189_828], [0.212_671, 0.715_160, 0.072_169], [0.017_758, 0.109_477, 0.872_765]];
/// Number of pixels that are converted together.
const BLOCK: usize = 16;

/// Converts sRGB pixels to Lab under daylight D65: `L / 100`, `(a + 40) / 80`, `(b + 40) / 80`, row by row. Strong colours
/// leave `0..=1`.
pub(crate) fn lab(frame: &Frame) -> [Vec<f32>; 3] {
    let Tables { linear, roots } = TABLES.get_or_init(Tables::new);
    let mut planes = [0; 3].map(|_| vec![0.0; frame.width() * frame.height()]);
    let [lightness, a, b] = planes.each_mut().map(|plane| plane.chunks_mut(BLOCK));
    // Tables are read one pixel after another; all else is computed for a block at a time.
    let (mut rgb, mut xyz) = ([[0.0_f32; BLOCK]; 3], [[0.0_f32; BLOCK]; 3]);
    for (((pixels, lightness), a), b) in frame.rgb().chunks(3 * BLOCK).zip(lightness).zip(a).zip(b) {
        for (k, pixel) in pixels.as_chunks::<3>().0.iter().enumerate() {
            (0..3).for_each(|c| rgb[c][k] = linear[usize::from(pixel[c])]);
        }
        for (roots_of, weights) in xyz.iter_mut().zip(RGB_TO_XYZ) {
            let mut steps = [0_i32; BLOCK];
            for k in 0..BLOCK {
                let t = weights[0] * rgb[0][k] + weights[1] * rgb[1][k] + weights[2] * rgb[2][k];
                steps[k] = (t * ROOT_STEPS as f32 + 0.5) as i32;
            }
            (0..BLOCK).for_each(|k| roots_of[k] = roots[(steps[k] as usize).min(ROOT_STEPS)]);
        }
        let [x, y, z] = &xyz;
        for (k, ((lightness, a), b)) in lightness.iter_mut().zip(a).zip(b).enumerate() {
            *lightness = 1.16 * y[k] - 0.16;
            *a = 0.5 + 500.0 / (2.0 * MAX_CHROMA) * (x[k] - y[k]);
            *b = 0.5 + 200.0 / (2.0 * MAX_CHROMA) * (y[k] - z[k]);
        }
    }
    planes
}

/// Both functions below at equal steps. Computed once, as that takes as long as a tenth of a frame.
struct Tables {
    linear: [f32; 256],
    roots: [f32; ROOT_STEPS + 1],
}

static TABLES: OnceLock<Tables> = OnceLock::new();

impl Tables {
    fn new() -> Self {
        Self {
            linear: std::array::from_fn(|v| linear(v as f32 / 255.0)),
            roots: std::array::from_fn(|i| root(i as f32 / ROOT_STEPS as f32)),
        }
    }
}

/// Linear intensity of an sRGB value.
fn linear(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { libm::powf((v + 0.055) / 1.055, 2.4) }
}

/// Cube root, linear near 0 (CIE Lab).
fn root(t: f32) -> f32 {
    if t > 0.008_856 { libm::cbrtf(t) } else { 7.787 * t + 16.0 / 116.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_colours_have_their_coordinates() {
        // White, black, pure red and pure blue; L, a, b as published for sRGB under D65.
        let expected = [[100.0, 0.0, 0.0], [0.0, 0.0, 0.0], [53.24, 80.09, 67.20], [32.30, 79.19, -107.86]];
        let rgb = vec![255, 255, 255, 0, 0, 0, 255, 0, 0, 0, 0, 255];
        let [l, a, b] = lab(&Frame::from_rgb(rgb, 4, 1).unwrap());
        for (i, expected) in expected.iter().enumerate() {
            let values = [100.0 * l[i], 80.0 * a[i] - 40.0, 80.0 * b[i] - 40.0];
            assert!(values.iter().zip(expected).all(|(f, e)| (f - e).abs() < 0.3), "{values:?} for {expected:?}");
        }
    }
}
