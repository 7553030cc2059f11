//! A frame's colours in CIE Lab, in which equal steps look about equally large.

use crate::image::Frame;

/// Steps of the table of the cube root over `0..=1`: lightness is off by 0.0011 of its range at most.
const STEPS: usize = 4096;
/// The histogram's range of a and b: from minus this to this. Colours beyond it share the outermost bins.
const COLOR_RANGE: f32 = 40.0;

/// Lightness, a and b of sRGB pixels under daylight D65: `L / 100`, `(a + 40) / 80`, `(b + 40) / 80`, row by row.
/// Strong colours leave `0..=1`.
pub(super) fn lab(frame: &Frame) -> [Vec<f32>; 3] {
    let linear: Vec<f32> = (0..256).map(|v| linear(v as f32 / 255.0)).collect();
    let roots: Vec<f32> = (0..=STEPS).map(|i| root(i as f32 / STEPS as f32)).collect();
    let root = |t: f32| roots[((t * STEPS as f32 + 0.5) as usize).min(STEPS)];
    let mut planes = [0; 3].map(|_| Vec::with_capacity(frame.width() * frame.height()));
    for p in frame.rgb().chunks_exact(3) {
        let [r, g, b] = [0, 1, 2].map(|c| linear[usize::from(p[c])]);
        // To XYZ, each relative to white.
        let x = root(0.433_953 * r + 0.376_219 * g + 0.189_828 * b);
        let y = root(0.212_671 * r + 0.715_160 * g + 0.072_169 * b);
        let z = root(0.017_758 * r + 0.109_477 * g + 0.872_765 * b);
        planes[0].push(1.16 * y - 0.16);
        planes[1].push(0.5 + 500.0 / (2.0 * COLOR_RANGE) * (x - y));
        planes[2].push(0.5 + 200.0 / (2.0 * COLOR_RANGE) * (y - z));
    }
    planes
}

/// Light of an sRGB value.
fn linear(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { libm::powf((v + 0.055) / 1.055, 2.4) }
}

/// Cube root, straight near 0.
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
            let found = [100.0 * l[i], 80.0 * a[i] - 40.0, 80.0 * b[i] - 40.0];
            assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 0.3), "{found:?} for {expected:?}");
        }
    }
}
