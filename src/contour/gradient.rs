//! Strength of the change at each pixel across each of eight directions, over colour channels and scales.

use super::blur::Blur;
use super::lab::lab;
use super::thin::normals;
use crate::image::{Frame, Plane};

/// Standard deviations of the windows, in pixels.
const SIGMAS: [f32; 3] = [1.5, 3.0, 5.0];
/// Bins of each channel's histogram.
const BINS: usize = 8;
/// Weights of the channels L, a and b.
const WEIGHTS: [f32; 3] = [1.0, 0.6, 0.6];
/// Added to a bin's share before dividing by it: changes of nearly empty bins count for less.
const EMPTY: f32 = 0.02;

/// Symmetric 2x2 matrices, one a pixel: their xx, xy and yy parts.
#[derive(Debug)]
struct Tensors([Vec<f32>; 3]);

/// For each direction of [`normals`], how much the histograms change along it.
pub(super) fn oriented_strength(frame: &Frame) -> Vec<Plane<f32>> {
    let (w, h) = (frame.width(), frame.height());
    let mut tensors = SIGMAS.map(|_| Tensors([0; 3].map(|_| vec![0.0; w * h])));
    let mut blurs = {
        let mut before = 0.0;
        SIGMAS.map(|sigma| {
            let step = (sigma * sigma - before * before).sqrt();
            before = sigma;
            Blur::new(step)
        })
    };
    let mut bin = vec![0.0; w * h];
    for (channel, weight) in lab(frame).iter().zip(WEIGHTS) {
        for b in 0..BINS {
            share_of_bin(channel.data(), b, &mut bin);
            for ((tensors, blur), sigma) in tensors.iter_mut().zip(&mut blurs).zip(SIGMAS) {
                blur.apply(&mut bin, w);
                tensors.add(&bin, w, weight * sigma * sigma);
            }
        }
    }
    normals().iter().map(|&normal| along(&tensors, normal, w, h)).collect()
}

/// Share of each pixel that belongs to bin `b`: a value between two bins' centres is shared by both.
fn share_of_bin(values: &[f32], b: usize, bin: &mut [f32]) {
    for (share, value) in bin.iter_mut().zip(values) {
        *share = (1.0 - (value.clamp(0.0, 1.0) * (BINS - 1) as f32 - b as f32).abs()).max(0.0);
    }
}

impl Tensors {
    /// Adds `weight * g g^T / (h + EMPTY)` for the share `h` of one bin, `g` its gradient by central differences.
    fn add(&mut self, bin: &[f32], w: usize, weight: f32) {
        let h = bin.len() / w;
        for y in 0..h {
            let rows = [y.saturating_sub(1), y, (y + 1).min(h - 1)].map(|y| &bin[y * w..(y + 1) * w]);
            let out = self.0.each_mut().map(|part| &mut part[y * w..(y + 1) * w]);
            for x in 0..w {
                let gx = 0.5 * (rows[1][(x + 1).min(w - 1)] - rows[1][x.saturating_sub(1)]);
                let gy = 0.5 * (rows[2][x] - rows[0][x]);
                let k = weight / (rows[1][x] + EMPTY);
                out[0][x] += k * gx * gx;
                out[1][x] += k * gx * gy;
                out[2][x] += k * gy * gy;
            }
        }
    }
}

/// Mean over the scales of the root of `n^T J n`.
fn along(tensors: &[Tensors], (nx, ny): (f32, f32), w: usize, h: usize) -> Plane<f32> {
    let mut out = Plane::filled(w, h, 0.0);
    for Tensors([xx, xy, yy]) in tensors {
        for (((o, xx), xy), yy) in out.data_mut().iter_mut().zip(xx).zip(xy).zip(yy) {
            let square = nx * nx * xx + 2.0 * nx * ny * xy + ny * ny * yy;
            *o += square.max(0.0).sqrt() / SIGMAS.len() as f32;
        }
    }
    out
}
