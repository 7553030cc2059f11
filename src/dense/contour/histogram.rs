//! How quickly local histograms change: the small-window limit of the chi-square distance between two half-discs.

use super::blur::{pad, widened};
use crate::order::larger;
use std::ops::Range;

/// Added to a bin's share before dividing by it: changes of nearly empty bins count for less.
const EMPTY: f32 = 0.02;

/// Share of each pixel that belongs to bin `b` of `bins`; a value between the centres of two bins is shared by both.
/// Returns whether any pixel has a share.
pub(super) fn share_of_bin(values: &[f32], b: usize, bins: usize, shares: &mut Vec<f32>) -> bool {
    let (scale, centre) = ((bins - 1) as f32, b as f32);
    shares.clear();
    shares.extend(values.iter().map(|v| larger(1.0 - (v.clamp(0.0, 1.0) * scale - centre).abs(), 0.0)));
    shares.iter().any(|&s| s > 0.0)
}

/// Symmetric 2x2 matrices, one a pixel: planes of their xx, xy and yy parts.
#[derive(Debug, Clone)]
pub(super) struct Tensors(pub(super) [Vec<f32>; 3]);

impl Tensors {
    pub(super) fn zero(len: usize) -> Self {
        Self([vec![0.0; len], vec![0.0; len], vec![0.0; len]])
    }

    /// Adds `weight * g g^T / (h + EMPTY)` for the blurred shares `h` of one bin, `g` their gradient by central
    /// differences. Outside of `spans`, a range of columns for each row, shares are 0.
    pub(super) fn add_bin(&mut self, shares: &[f32], width: usize, weight: f32, spans: &[Range<usize>]) {
        let height = shares.len() / width;
        let mut padded = Vec::new();
        for (y, span) in widened(spans, 1, width).into_iter().enumerate().filter(|(_, span)| !span.is_empty()) {
            let row = |y: usize| &shares[y * width..][..width];
            pad(row(y), 1, &mut padded);
            let n = span.len();
            let (left, centre, right) =
                (&padded[span.start..][..n], &row(y)[span.clone()], &padded[span.start + 2..][..n]);
            let (above, below) = (&row(y.saturating_sub(1))[span.clone()], &row((y + 1).min(height - 1))[span.clone()]);
            let [xx, xy, yy] = self.0.each_mut().map(|part| &mut part[y * width..][span.clone()]);
            for x in 0..n {
                let gx = 0.5 * (right[x] - left[x]);
                let gy = 0.5 * (below[x] - above[x]);
                let k = weight / (centre[x] + EMPTY);
                xx[x] += k * gx * gx;
                xy[x] += k * gx * gy;
                yy[x] += k * gy * gy;
            }
        }
    }

    /// Adds the root of `n^T J n` at each pixel to `out`: the change along the unit vector `n`.
    pub(super) fn add_change_along(&self, (nx, ny): (f32, f32), out: &mut [f32]) {
        let [xx, xy, yy] = &self.0;
        let (a, b, c) = (nx * nx, 2.0 * nx * ny, ny * ny);
        for (((o, xx), xy), yy) in out.iter_mut().zip(xx).zip(xy).zip(yy) {
            *o += larger(a * xx + b * xy + c * yy, 0.0).sqrt();
        }
    }
}
