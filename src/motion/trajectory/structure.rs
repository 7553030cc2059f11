//! Where a point can be tracked: the smaller eigenvalue of the structure tensor.

use crate::image::{Plane, gaussian_blur};

/// Smoothing of the image before its gradient, in pixels (the published tracker's value).
const PRE_SMOOTHING: f32 = 0.8;
/// Smoothing of the tensor, in pixels (the published tracker's value).
const TENSOR_SMOOTHING: f32 = 3.0;

/// The smaller eigenvalue λmin of the smoothed structure tensor in each two by two pixels, in grey levels squared per
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
    let image = gaussian_blur(luma, PRE_SMOOTHING);
    let (w, h) = (image.width(), image.height());
    let (half_w, half_h) = (w.div_ceil(2), h.div_ceil(2));
    let mut tensor = [(); 3].map(|()| Plane::filled(half_w, half_h, 0.0));
    let mut slopes = [(); 2].map(|()| vec![0.0; w]);
    for y in 0..h {
        let (above, row, below) = (image.row(y.saturating_sub(1)), image.row(y), image.row((y + 1).min(h - 1)));
        let [across, down] = &mut slopes;
        for x in 0..w {
            across[x] = 0.5 * (row[(x + 1).min(w - 1)] - row[x.saturating_sub(1)]);
            down[x] = 0.5 * (below[x] - above[x]);
        }
        // A lone last row or column stands for two.
        let share = if y + 1 == h && y % 2 == 0 { 0.5 } else { 0.25 };
        let [xx, xy, yy] = tensor.each_mut().map(|plane| plane.row_mut(y / 2));
        for (x, (gx, gy)) in across.chunks(2).zip(down.chunks(2)).enumerate() {
            let last = gx.len() - 1;
            xx[x] += share * (gx[0] * gx[0] + gx[last] * gx[last]);
            xy[x] += share * (gx[0] * gy[0] + gx[last] * gy[last]);
            yy[x] += share * (gy[0] * gy[0] + gy[last] * gy[last]);
        }
    }
    // The mean of two by two pixels has smoothed a little already.
    let sigma = 0.5 * (TENSOR_SMOOTHING * TENSOR_SMOOTHING - 0.25).sqrt();
    let [xx, xy, yy] = tensor.map(|plane| gaussian_blur(&plane, sigma));
    let data = (0..half_w * half_h)
        .map(|i| {
            let (a, b, c) = (xx.data()[i], xy.data()[i], yy.data()[i]);
            0.5 * (a + c) - (0.25 * (a - c) * (a - c) + b * b).sqrt()
        })
        .collect();
    Plane::from_vec(half_w, half_h, data).unwrap_or_default()
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
