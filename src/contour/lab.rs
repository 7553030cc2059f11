//! CIE Lab planes of a frame, each scaled to about `0..=1`.

use crate::image::Frame;

/// Entries of the table of the cube root.
const STEPS: usize = 4096;

/// `L/100`, `(a + 40)/80` and `(b + 40)/80` of sRGB pixels under D65; strong colours leave `0..=1`.
pub(super) fn lab(frame: &Frame) -> [Vec<f32>; 3] {
    let linear: Vec<f32> = (0..256)
        .map(|v| {
            let v = v as f32 / 255.0;
            if v <= 0.04045 { v / 12.92 } else { libm::powf((v + 0.055) / 1.055, 2.4) }
        })
        .collect();
    let roots: Vec<f32> = (0..=STEPS + 1)
        .map(|i| {
            let t = i as f32 / STEPS as f32;
            if t > 0.008_856 { libm::cbrtf(t) } else { 7.787 * t + 16.0 / 116.0 }
        })
        .collect();
    let f = |t: f32| roots[((t * STEPS as f32 + 0.5) as usize).min(STEPS)];
    let mut planes = [0; 3].map(|_| Vec::with_capacity(frame.width() * frame.height()));
    for p in frame.rgb().chunks_exact(3) {
        let [r, g, b] = [0, 1, 2].map(|c| linear[usize::from(p[c])]);
        let x = f((0.412_453 * r + 0.357_580 * g + 0.180_423 * b) / 0.950_456);
        let y = f(0.212_671 * r + 0.715_160 * g + 0.072_169 * b);
        let z = f((0.019_334 * r + 0.119_193 * g + 0.950_227 * b) / 1.088_754);
        planes[0].push(1.16 * y - 0.16);
        planes[1].push((500.0 * (x - y) + 40.0) / 80.0);
        planes[2].push((200.0 * (y - z) + 40.0) / 80.0);
    }
    planes
}
