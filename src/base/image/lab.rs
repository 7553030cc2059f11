//! Conversion to CIE Lab, in which equal steps look about equally large.

use super::Frame;
use std::sync::OnceLock;

/// Intervals of the table of the cube root over `0..=1`: the error of lightness is at most 0.0011 of its range.
const ROOT_STEPS: usize = 4096;
/// Size of a and b that is scaled to the ends of `0..=1`. Chosen by eye.
const MAX_CHROMA: f32 = 40.0;

/// Converts sRGB pixels to Lab under daylight D65: `L / 100`, `(a + 40) / 80`, `(b + 40) / 80`, row by row. Strong colours
/// leave `0..=1`.
pub(crate) fn lab(frame: &Frame) -> [Vec<f32>; 3] {
    let Tables { linear, roots } = TABLES.get_or_init(Tables::new);
    let root = |t: f32| roots[((t * ROOT_STEPS as f32 + 0.5) as usize).min(ROOT_STEPS)];
    let mut planes = [0; 3].map(|_| vec![0.0; frame.width() * frame.height()]);
    let [lightness, a, b] = &mut planes;
    let values = lightness.iter_mut().zip(a).zip(b);
    for (&[r, g, b], ((lightness, along_a), along_b)) in frame.rgb().as_chunks::<3>().0.iter().zip(values) {
        let (r, g, b) = (linear[usize::from(r)], linear[usize::from(g)], linear[usize::from(b)]);
        // To XYZ, each relative to white.
        let x = root(0.433_953 * r + 0.376_219 * g + 0.189_828 * b);
        let y = root(0.212_671 * r + 0.715_160 * g + 0.072_169 * b);
        let z = root(0.017_758 * r + 0.109_477 * g + 0.872_765 * b);
        *lightness = 1.16 * y - 0.16;
        *along_a = 0.5 + 500.0 / (2.0 * MAX_CHROMA) * (x - y);
        *along_b = 0.5 + 200.0 / (2.0 * MAX_CHROMA) * (y - z);
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
