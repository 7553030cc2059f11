//! Saliency maps of the frames of a clip: what is left of the flow, its bins, their contrast.

use super::params::{Compensation, SaliencyParams};
use super::surround::{Contrast, surround};
use crate::camera::{DominantMotion, Residuals, Search, dominant_motion};
use crate::flow::{Field, FlowField};
use crate::image::Plane;

/// Longest side of the maps that windows are laid over, in pixels; saliency is looked up for every pixel. Higher is
/// slower.
const MAP_SIDE: usize = 120;
/// Where the clip sets the range: this part of all its magnitudes lies within.
const RANGE_QUANTILE: f64 = 0.99;
/// Where the clip sets the range: its least end, in pixels a frame. Lower makes smaller motions salient, and noise.
const RANGE_FLOOR: f64 = 2.0;

/// Counts a pixel of magnitude.
const COUNTS_PER_PIXEL: f32 = 64.0;

/// Magnitudes at and beyond this many counts are counted as one.
const MOST_COUNTS: usize = 64 * 256;

/// Saliency maps of the frames of one clip: first all flows are looked at, then maps can be made.
///
/// # Examples
/// A square moves before a still scene.
///
/// ```
/// use tracecut::flow::FlowField;
/// use tracecut::image::Plane;
/// use tracecut::saliency::{SaliencyMaps, SaliencyParams};
///
/// let inside = |x: usize, y: usize| (24..40).contains(&x) && (16..32).contains(&y);
/// let u = Plane::from_fn(64, 48, |x, y| if inside(x, y) { 4.0 } else { 0.0 });
/// let flow = FlowField { u, v: Plane::filled(64, 48, 0.0) };
/// let mut maps = SaliencyMaps::new(&SaliencyParams::default());
/// maps.look_at(&flow);
/// let map = maps.map(0, &flow);
/// assert!(map[(32, 24)] > 0.8 && map[(4, 4)] < 0.5);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SaliencyMaps {
    params: SaliencyParams,
    /// Of each flow.
    motions: Vec<DominantMotion>,
    /// How many samples of all flows have which magnitude, in 64ths of a pixel.
    counts: Vec<u32>,
}

impl SaliencyMaps {
    /// Nothing looked at yet.
    pub fn new(params: &SaliencyParams) -> Self {
        Self { params: params.clone(), motions: Vec::new(), counts: vec![0; MOST_COUNTS] }
    }

    /// Takes note of the next frame's flow: its dominant motion and its magnitudes. Call once for each flow of the
    /// clip, in order.
    pub fn look_at(&mut self, flow: &FlowField) {
        self.look(flow);
    }

    /// The same for a field however it is kept.
    pub(crate) fn look(&mut self, flow: &impl Field) {
        let search = Search {
            perspective: self.params.compensation == Compensation::Homography,
            tolerance: self.params.tolerance,
        };
        let motion = match self.params.compensation {
            Compensation::Off => DominantMotion::none(flow),
            _ => dominant_motion(flow, &search, self.motions.last()),
        };
        for &magnitude in self.reduced(flow, &motion).data() {
            self.counts[count_of(magnitude).min(MOST_COUNTS - 1)] += 1;
        }
        self.motions.push(motion);
    }

    #[doc(hidden)]
    /// The motion of the camera in each flow looked at.
    pub fn motions(&self) -> &[DominantMotion] {
        &self.motions
    }

    /// Magnitude at which the last bin ends, in pixels.
    pub(crate) fn range(&self) -> f64 {
        if self.params.range > 0.0 {
            return self.params.range;
        }
        let total: u64 = self.counts.iter().map(|&c| u64::from(c)).sum();
        let wanted = RANGE_QUANTILE * total as f64;
        let mut within = 0.0;
        let enough = |&count: &u32| {
            within += f64::from(count);
            within >= wanted
        };
        let last = self.counts.iter().position(enough).unwrap_or(0);
        ((last + 1) as f64 / f64::from(COUNTS_PER_PIXEL)).max(RANGE_FLOOR)
    }

    /// The saliency of each pixel of frame `t`, whose flow this is, in `0.0..=1.0`.
    ///
    /// Windows are laid over magnitudes of every few pixels, but each pixel is looked up by its own, so that outlines
    /// are those of the flow.
    pub fn map(&self, t: usize, flow: &FlowField) -> Plane<f32> {
        self.whole(t, flow)
    }

    /// The same of a field however it is kept.
    pub(crate) fn whole(&self, t: usize, flow: &impl Field) -> Plane<f32> {
        let (width, height) = flow.size();
        let mut pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let found = self.asked(t, flow, &mut pixels).answer(&self.params);
        Plane::from_vec(width, height, found).unwrap_or_default()
    }

    /// What the saliency of these pixels of frame `t`, whose flow this is, is made from.
    pub(crate) fn asked(&self, t: usize, flow: &impl Field, pixels: &mut dyn Iterator<Item = (usize, usize)>) -> Asked {
        let motion = self.motions.get(t).copied().unwrap_or_else(|| DominantMotion::none(flow));
        let reduced = self.reduced(flow, &motion);
        let scale = (f64::from(self.params.bins) / self.range()) as f32;
        let last = (self.params.bins - 1) as u8;
        // Casts saturate, and take what is no number for 0.
        let bin = |magnitude: f32| ((magnitude * scale) as u8).min(last);
        let rows: Vec<Residuals> = (0..flow.size().1).map(|y| motion.along(y)).collect();
        let (step, across) = (step(flow), reduced.width());
        let pixel = |(x, y): (usize, usize)| {
            let place = (y / step) * across + x / step;
            (place as u32) << 8 | u32::from(bin(rows[y].at(x, flow.at(x, y))))
        };
        Asked { pixels: pixels.map(pixel).collect(), bins: reduced.map(bin) }
    }

    /// What is left of the flow's magnitude at every few pixels.
    fn reduced(&self, flow: &impl Field, motion: &DominantMotion) -> Plane<f32> {
        let (step, (width, height)) = (step(flow), flow.size());
        let mut magnitudes = Plane::filled(width.div_ceil(step), height.div_ceil(step), 0.0);
        // In the middle of each step, where the frame reaches as far.
        let first = (step / 2).min((width - 1) % step);
        for y in 0..magnitudes.height() {
            let row = (y * step + step / 2).min(height - 1);
            let residuals = motion.along(row);
            for (k, magnitude) in magnitudes.row_mut(y).iter_mut().enumerate() {
                let x = first + k * step;
                *magnitude = residuals.at(x, flow.at(x, row));
            }
        }
        magnitudes
    }
}

/// Pixels of the flow a pixel of the reduced maps.
fn step(flow: &impl Field) -> usize {
    let (width, height) = flow.size();
    width.max(height).div_ceil(MAP_SIDE).max(1)
}

/// Some pixels of a frame whose saliency is wanted.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Asked {
    /// The bin of every few pixels, which windows are laid over.
    pub(crate) bins: Plane<u8>,
    /// Of each pixel wanted the place among these, and its own bin in the lowest eight bits.
    pub(crate) pixels: Vec<u32>,
}

impl Asked {
    /// The saliency of each, in `0.0..=1.0`.
    pub(crate) fn answer(&self, params: &SaliencyParams) -> Vec<f32> {
        let contrast = Contrast { num_bins: params.bins as usize, prior: params.prior };
        surround(&self.bins, &contrast, &self.pixels)
    }
}

/// The count that a magnitude falls into; casts saturate, and take what is no number for 0.
fn count_of(magnitude: f32) -> usize {
    (magnitude * COUNTS_PER_PIXEL) as usize
}
