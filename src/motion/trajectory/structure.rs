//! Trackability of points: the smaller eigenvalue of the structure tensor.

use crate::image::{Plane, gaussian_blur};

/// Standard deviation of the blur before the gradient, in pixels (published tracker).
const GRADIENT_SMOOTHING_PX: f32 = 0.8;
/// Standard deviation of the blur of the tensor, in pixels (published tracker).
const TENSOR_SMOOTHING_PX: f32 = 3.0;

/// Computes the smaller eigenvalue λmin of the smoothed structure tensor of each 2×2 pixels, in grey levels squared per
/// pixel squared: `ceil(w / 2) × ceil(h / 2)` values, as the smoothing leaves no finer detail.
///
/// `luma` is in `0.0..=255.0`. Gradients are central differences with replicated borders (Sundaram, Brox and Keutzer
/// 2010).
///
/// # Examples
/// A corner can be tracked, a straight edge cannot.
///
/// ```
/// use tracecut::image::Plane;
/// use tracecut::trajectory::structure;
///
/// let image = Plane::from_fn(60, 60, |x, y| if x >= 30 && y >= 30 { 200.0 } else { 50.0 });
/// let structure = structure(&image);
/// assert_eq!((structure.width(), structure.height()), (30, 30));
/// assert!(structure[(15, 15)] > 100.0);
/// assert!(structure[(15, 27)] < 1.0 && structure[(2, 2)] < 1.0);
/// ```
#[must_use]
pub fn structure(luma: &Plane<f32>) -> Plane<f32> {
    if luma.data().is_empty() {
        return Plane::default();
    }
    let image = gaussian_blur(luma, GRADIENT_SMOOTHING_PX);
    let (w, h) = (image.width(), image.height());
    let (half_w, half_h) = (w.div_ceil(2), h.div_ceil(2));
    let mut tensor = [(); 3].map(|()| Plane::filled(half_w, half_h, 0.0));
    let mut gradient = [(); 2].map(|()| vec![0.0; w]);
    for y in 0..h {
        let (above, row, below) = (image.row(y.saturating_sub(1)), image.row(y), image.row((y + 1).min(h - 1)));
        let [row_gx, row_gy] = &mut gradient;
        for ((gx, left), right) in row_gx[1..].iter_mut().zip(row).zip(&row[2.min(w)..]) {
            *gx = 0.5 * (right - left);
        }
        for x in [0, w - 1] {
            row_gx[x] = 0.5 * (row[(x + 1).min(w - 1)] - row[x.saturating_sub(1)]);
        }
        row_gy.iter_mut().zip(above).zip(below).for_each(|((gy, above), below)| *gy = 0.5 * (below - above));
        // A single last row or column counts twice.
        let share = if y + 1 == h && y % 2 == 0 { 0.5 } else { 0.25 };
        let [xx, xy, yy] = tensor.each_mut().map(|plane| plane.row_mut(y / 2));
        let ((gx, gx_end), (gy, gy_end)) = (row_gx.as_chunks::<2>(), row_gy.as_chunks::<2>());
        for (x, (gx, gy)) in gx.iter().zip(gy).enumerate() {
            xx[x] += share * (gx[0] * gx[0] + gx[1] * gx[1]);
            xy[x] += share * (gx[0] * gy[0] + gx[1] * gy[1]);
            yy[x] += share * (gy[0] * gy[0] + gy[1] * gy[1]);
        }
        for (gx, gy) in gx_end.iter().zip(gy_end) {
            xx[half_w - 1] += share * (gx * gx + gx * gx);
            xy[half_w - 1] += share * (gx * gy + gx * gy);
            yy[half_w - 1] += share * (gy * gy + gy * gy);
        }
    }
    // The mean of 2×2 pixels is a blur of variance 1/4.
    let sigma = 0.5 * (TENSOR_SMOOTHING_PX * TENSOR_SMOOTHING_PX - 0.25).sqrt();
    let [xx, xy, yy] = tensor.map(|plane| gaussian_blur(&plane, sigma));
    let tensor = xx.data().iter().zip(xy.data()).zip(yy.data());
    let smaller = tensor.map(|((a, b), c)| 0.5 * (a + c) - (0.25 * (a - c) * (a - c) + b * b).sqrt());
    Plane::from_vec(half_w, half_h, smaller.collect()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_score_above_edges_and_flat_areas_score_nothing() {
        let corner = Plane::from_fn(64, 64, |x, y| if x >= 32 && y >= 32 { 200.0 } else { 20.0 });
        let lambda = structure(&corner);
        assert!(lambda[(16, 16)] > 10.0 * lambda[(16, 27)].max(1.0), "{} {}", lambda[(16, 16)], lambda[(16, 27)]);
        assert!(lambda[(2, 2)].abs() < 1e-3);
    }
}
