//! Where a point can be tracked: the smaller eigenvalue of the structure tensor.

use crate::image::{Plane, gaussian_blur};

/// Smoothing of the image before its gradient, in pixels (the published tracker's value).
const PRE_SMOOTHING: f32 = 0.8;
/// Smoothing of the tensor, in pixels (the published tracker's value).
const TENSOR_SMOOTHING: f32 = 3.0;

/// The smaller eigenvalue λmin of the smoothed structure tensor at each pixel, in grey levels squared per pixel
/// squared.
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
/// assert!(structure[(30, 30)] > 100.0);
/// assert!(structure[(30, 55)] < 1.0 && structure[(5, 5)] < 1.0);
/// ```
#[must_use]
pub fn structure(luma: &Plane<f32>) -> Plane<f32> {
    let image = gaussian_blur(luma, PRE_SMOOTHING);
    let (w, h) = (image.width(), image.height());
    let mut tensor = [Plane::filled(w, h, 0.0), Plane::filled(w, h, 0.0), Plane::filled(w, h, 0.0)];
    for y in 0..h {
        let (above, row, below) = (image.row(y.saturating_sub(1)), image.row(y), image.row((y + 1).min(h - 1)));
        for x in 0..w {
            let gx = 0.5 * (row[(x + 1).min(w - 1)] - row[x.saturating_sub(1)]);
            let gy = 0.5 * (below[x] - above[x]);
            tensor[0].row_mut(y)[x] = gx * gx;
            tensor[1].row_mut(y)[x] = gx * gy;
            tensor[2].row_mut(y)[x] = gy * gy;
        }
    }
    let [xx, xy, yy] = tensor.map(|plane| gaussian_blur(&plane, TENSOR_SMOOTHING));
    let data = (0..w * h)
        .map(|i| {
            let (a, b, c) = (xx.data()[i], xy.data()[i], yy.data()[i]);
            0.5 * (a + c) - (0.25 * (a - c) * (a - c) + b * b).sqrt()
        })
        .collect();
    Plane::from_vec(w, h, data).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_score_above_edges_and_flat_areas_score_nothing() {
        let corner = Plane::from_fn(64, 64, |x, y| if x >= 32 && y >= 32 { 200.0 } else { 20.0 });
        let lambda = structure(&corner);
        assert!(lambda[(32, 32)] > 10.0 * lambda[(32, 55)].max(1.0), "{} {}", lambda[(32, 32)], lambda[(32, 55)]);
        assert!(lambda[(5, 5)].abs() < 1e-3);
    }
}
