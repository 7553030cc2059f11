//! Point trajectories: scene points followed from frame to frame along the flow (section 2.1).
//!
//! In: frames and their flow, forward and backward. Out: [`Trajectories`]. The tracker is the paper's, by Sundaram, Brox and
//! Keutzer (ECCV 2010):
//!
//! 1. Seed points on a grid where the structure tensor's smaller eigenvalue shows structure in two directions.
//! 2. Move each point by the forward flow, sampled bilinearly.
//! 3. End it where the backward flow does not lead back, `|w + w'|² ≥ 0.01 (|w|² + |w'|²) + 0.5` (occlusion), or where the
//!    flow changes too fast, `|∇u|² + |∇v|² > 0.01 |w|² + 0.002` (motion boundary).
//! 4. Seed again wherever no live point is near; drop short trajectories.
//!
//! **Deviations** from the published tracker: structure is measured on brightness instead of colour, and flow is sampled
//! bilinearly instead of at the nearest pixel, which keeps velocities smooth. **Cost**: O(pixels + points) per frame.
//! **Limits**: drift adds up; points on an object's border may slide to the background; areas without texture have no
//! points.

mod tracker;
mod trajectories;

use crate::image::{Plane, gaussian_blur};
pub use tracker::Tracker;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use tracker::TrackerState;
pub use trajectories::Trajectories;

crate::params! {
    /// Point trajectories.
    pub struct TrajectoryParams {
        /// Spacing of the seed grid, in pixels of the processed frames. Lower is slower and finds smaller objects.
        /// Default: the published tracker's 8.
        pub grid_step: f32 = 8.0, in 3.0..=64.0;
        /// Shortest trajectory kept, in frames (section 5: 7). Clips of fewer than 13 frames use half their length, but
        /// at least 2.
        pub min_length: u32 = 7, in 2..=1000;
        /// Spacing of the denser trajectories that the masks are made from, in pixels of the processed frames.
        pub mask_step: f32 = 4.0, in 2.0..=64.0;
        /// Shortest trajectory that the masks are made from, in frames.
        pub mask_min_length: u32 = 2, in 2..=1000, expert;
        /// A seed needs a structure of more than this fraction of the frame's mean, and eleven times as much on the border
        /// (published tracker: 0.1). Lower tracks weaker texture, which the checks below then have to judge.
        pub structure_mean: f32 = 0.03, in 0.0..=10.0, expert;
        /// A seed needs more than this structure, in grey levels squared (published tracker: 1). 0 seeds all but
        /// constant areas.
        pub structure_floor: f32 = 0.02, in 0.0..=1000.0, expert;
    }
}

impl TrajectoryParams {
    /// Returns these parameters with the spacing and minimum length of the denser trajectories for masks.
    #[doc(hidden)] // For `examples/method.rs`.
    pub fn for_masks(&self) -> Self {
        Self { grid_step: self.mask_step, min_length: self.mask_min_length, ..self.clone() }
    }
}

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
#[doc(hidden)] // For benchmarks.
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
