//! Classical edge detectors on brightness, to compare boundary maps with.
//!
//! Both blur with the same Gaussian, measure a slope, and thin it as our own maps are thinned. [`sobel`] gives the
//! magnitude of the Sobel operator. [`canny`] gives central differences of the blurred brightness with Canny's
//! hysteresis: the strength of a pixel is the highest threshold at which it survives, where a pixel survives a
//! threshold `t` when its magnitude is at least [`LOW_SHARE`]` * t` and pixels of this kind connect it (8 neighbours)
//! to one of magnitude `t`.
//!
//! Source: Canny, "A Computational Approach to Edge Detection", PAMI 1986.

use tracecut::contour::{ORIENTATIONS, normals, thin};
use tracecut::image::{Frame, Plane, gaussian_blur};

/// Standard deviation of the blur, in pixels, usual for images of this benchmark.
pub const BLUR: f32 = 2.0;
/// Canny's lower threshold by his upper one.
pub const LOW_SHARE: f32 = 0.4;
/// Thresholds that [`canny`] tells apart.
const LEVELS: usize = 128;

/// Thin edges by the Sobel operator; strengths `0..=1`.
pub fn sobel(frame: &Frame) -> Plane<f32> {
    let luma = gaussian_blur(&frame.luma(), BLUR);
    edges(&luma, [1.0, 2.0, 1.0])
}

/// Thin edges by Canny's method; strengths `0..=1`.
pub fn canny(frame: &Frame) -> Plane<f32> {
    let luma = gaussian_blur(&frame.luma(), BLUR);
    hysteresis(&edges(&luma, [0.0, 1.0, 0.0]))
}

/// Central differences, smoothed across by `weights`, thinned; 1 is a step of the whole range in one pixel.
fn edges(luma: &Plane<f32>, weights: [f32; 3]) -> Plane<f32> {
    let (w, h) = (luma.width(), luma.height());
    let at = |x: usize, dx: usize, y: usize, dy: usize| {
        luma[((x + dx).saturating_sub(1).min(w - 1), (y + dy).saturating_sub(1).min(h - 1))]
    };
    let total: f32 = weights.iter().sum();
    let slope = |difference: &dyn Fn(usize) -> f32| -> f32 {
        (0..3).map(|k| weights[k] * difference(k)).sum::<f32>() / (total * 255.0)
    };
    let dx = Plane::from_fn(w, h, |x, y| slope(&|k| at(x, 2, y, k) - at(x, 0, y, k)));
    let dy = Plane::from_fn(w, h, |x, y| slope(&|k| at(x, k, y, 2) - at(x, k, y, 0)));
    let strength = Plane::from_fn(w, h, |x, y| (dx[(x, y)] * dx[(x, y)] + dy[(x, y)] * dy[(x, y)]).sqrt());
    let orientation = Plane::from_fn(w, h, |x, y| nearest_orientation(dx[(x, y)], dy[(x, y)]));
    thin(&strength, &orientation).map(|v| v.min(1.0))
}

fn nearest_orientation(dx: f32, dy: f32) -> u8 {
    let normals = normals();
    let along = |k: usize| (normals[k].0 * dx + normals[k].1 * dy).abs();
    (1..ORIENTATIONS).fold(0, |best, k| if along(k) > along(best) { k } else { best }) as u8
}

/// The highest threshold that each pixel of `thin` survives.
fn hysteresis(thin: &Plane<f32>) -> Plane<f32> {
    let (w, h) = (thin.width() as isize, thin.height() as isize);
    let top = thin.data().iter().copied().fold(0.0, f32::max);
    let mut out = thin.map(|_| 0.0);
    let mut visited = vec![0; thin.data().len()];
    let mut stack = Vec::new();
    for level in 1..=LEVELS {
        // Squared, as weak edges are many.
        let share = level as f32 / LEVELS as f32;
        let high = top * share * share;
        stack.extend((0..visited.len()).filter(|&i| thin.data()[i] > 0.0 && thin.data()[i] >= high));
        while let Some(i) = stack.pop() {
            if std::mem::replace(&mut visited[i], level) == level {
                continue;
            }
            out.data_mut()[i] = high;
            let (x, y) = (i as isize % w, i as isize / w);
            for (nx, ny) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy))) {
                if (0..w).contains(&nx) && (0..h).contains(&ny) {
                    let j = (ny * w + nx) as usize;
                    if thin.data()[j] > 0.0 && thin.data()[j] >= LOW_SHARE * high && visited[j] != level {
                        stack.push(j);
                    }
                }
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step() -> Frame {
        let rgb = (0..30).flat_map(|_| (0..40).flat_map(|x| [if x < 20 { 40 } else { 200 }; 3])).collect();
        Frame::from_rgb(rgb, 40, 30).unwrap()
    }

    #[test]
    fn a_step_gives_one_line_at_its_place() {
        for map in [sobel(&step()), canny(&step())] {
            for y in 0..30 {
                let line: Vec<usize> = (0..40).filter(|&x| map[(x, y)] > 0.0).collect();
                assert!(line == [19] || line == [20], "row {y}: {line:?}");
            }
        }
    }

    #[test]
    fn weak_pixels_live_by_strong_ones_they_touch() {
        let weak = |x: usize| [1.0, 0.5, 0.5, 0.0, 0.5, 0.0, 0.3][x];
        let out = hysteresis(&Plane::from_fn(7, 1, |x, _| weak(x)));
        assert_eq!(&out.data()[..4], [1.0, 1.0, 1.0, 0.0]);
        assert!((out[(4, 0)] - 0.5).abs() < 0.02 && (out[(6, 0)] - 0.3).abs() < 0.02, "{:?}", out.data());
    }
}
