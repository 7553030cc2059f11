//! Saliency maps of the frames of a clip: residual flow, its bins, their centre-surround contrast.

use super::centre_surround::{ContrastParams, centre_surround};
use super::{Compensation, SaliencyParams};
use crate::camera::{DominantMotion, MotionFit, RowMotion, dominant_motion};
use crate::flow::{Field, FlowField};
use crate::image::Plane;

/// Longest side of the reduced maps that windows are evaluated on; each pixel is then looked up by its own bin. Higher is
/// slower. Chosen by eye.
const MAX_MAP_SIDE_PX: usize = 120;
/// Quantile of the clip's magnitudes at which the last bin ends. Chosen by eye.
const RANGE_QUANTILE: f64 = 0.99;
/// Least end of the last bin, in pixels a frame. Lower makes smaller motions salient, and noise. Chosen by eye.
const MIN_RANGE_PX: f64 = 2.0;

/// Resolution of the histogram of magnitudes, the same as in stored flow.
const COUNTS_PER_PX: f32 = 64.0;

/// Bins of that histogram: 256 pixels; the last bin has all larger magnitudes.
const NUM_COUNTS: usize = 64 * 256;

/// Saliency maps of the frames of a clip. All flows are added first, then maps can be computed.
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
/// maps.add_flow(&flow);
/// let map = maps.map(0, &flow);
/// assert!(map[(32, 24)] > 0.8 && map[(4, 4)] < 0.5);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SaliencyMaps {
    params: SaliencyParams,
    /// Dominant motion of each flow.
    motions: Vec<DominantMotion>,
    /// Histogram of the magnitudes of all flows.
    counts: Vec<u32>,
}

impl SaliencyMaps {
    /// Starts without any flow.
    pub fn new(params: &SaliencyParams) -> Self {
        Self { params: params.clone(), motions: Vec::new(), counts: vec![0; NUM_COUNTS] }
    }

    /// Fits the dominant motion of the next frame's flow and counts its magnitudes. To be called for each flow of the clip,
    /// in order.
    pub fn add_flow(&mut self, flow: &FlowField) {
        self.add_field(flow);
    }

    /// Same as [`add_flow`](Self::add_flow), for any field.
    pub(crate) fn add_field(&mut self, flow: &impl Field) {
        let fit = MotionFit {
            perspective: self.params.compensation == Compensation::Homography,
            tolerance: self.params.tolerance,
        };
        let motion = match self.params.compensation {
            Compensation::Off => DominantMotion::still(flow),
            _ => dominant_motion(flow, &fit, self.motions.last()),
        };
        for &magnitude in reduced_residuals(flow, &motion).data() {
            // Casts saturate, and convert NaN to 0.
            self.counts[((magnitude * COUNTS_PER_PX) as usize).min(NUM_COUNTS - 1)] += 1;
        }
        self.motions.push(motion);
    }

    #[doc(hidden)]
    /// The dominant motion of each flow.
    pub fn motions(&self) -> &[DominantMotion] {
        &self.motions
    }

    /// Magnitude at which the last bin ends, in pixels.
    pub(crate) fn range(&self) -> f64 {
        if self.params.range > 0.0 {
            return self.params.range;
        }
        let total: u64 = self.counts.iter().map(|&c| u64::from(c)).sum();
        let mut sum = 0.0;
        let is_quantile = |&count: &u32| {
            sum += f64::from(count);
            sum >= RANGE_QUANTILE * total as f64
        };
        let last = self.counts.iter().position(is_quantile).unwrap_or(0);
        ((last + 1) as f64 / f64::from(COUNTS_PER_PX)).max(MIN_RANGE_PX)
    }

    /// Computes the saliency of each pixel of frame `t` from its flow, in `0.0..=1.0`. Windows are evaluated on a reduced
    /// map, but each pixel is looked up by its own bin, so that outlines follow the flow.
    pub fn map(&self, t: usize, flow: &FlowField) -> Plane<f32> {
        self.map_of_field(t, flow)
    }

    /// Same as [`map`](Self::map), for any field.
    pub(crate) fn map_of_field(&self, t: usize, flow: &impl Field) -> Plane<f32> {
        let (width, height) = flow.size();
        let mut pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let saliency = self.query(t, flow, &mut pixels).evaluate(&self.params);
        Plane::from_vec(width, height, saliency).unwrap_or_default()
    }

    /// Gathers the input of the saliency of some pixels of frame `t` from its flow.
    pub(crate) fn query(
        &self,
        t: usize,
        flow: &impl Field,
        pixels: &mut dyn Iterator<Item = (usize, usize)>,
    ) -> SaliencyQuery {
        let motion = self.motions.get(t).copied().unwrap_or_else(|| DominantMotion::still(flow));
        let reduced = reduced_residuals(flow, &motion);
        let scale = (f64::from(self.params.bins) / self.range()) as f32;
        let last = (self.params.bins - 1) as u8;
        // Casts saturate, and convert NaN to 0.
        let bin = |magnitude: f32| ((magnitude * scale) as u8).min(last);
        let rows: Vec<RowMotion> = (0..flow.size().1).map(|y| motion.along_row(y)).collect();
        let (step, width) = (map_step(flow), reduced.width());
        let pixel = |(x, y): (usize, usize)| {
            let index = (y / step) * width + x / step;
            (index as u32) << 8 | u32::from(bin(rows[y].residual(x, flow.at(x, y))))
        };
        SaliencyQuery { pixels: pixels.map(pixel).collect(), bins: reduced.map(bin) }
    }
}

/// Magnitudes of the residual flow, reduced by sampling.
fn reduced_residuals(flow: &impl Field, motion: &DominantMotion) -> Plane<f32> {
    let (step, (width, height)) = (map_step(flow), flow.size());
    let mut magnitudes = Plane::filled(width.div_ceil(step), height.div_ceil(step), 0.0);
    // The centre of each step, inside the frame.
    let first = (step / 2).min((width - 1) % step);
    for y in 0..magnitudes.height() {
        let row = (y * step + step / 2).min(height - 1);
        let row_motion = motion.along_row(row);
        for (k, magnitude) in magnitudes.row_mut(y).iter_mut().enumerate() {
            let x = first + k * step;
            *magnitude = row_motion.residual(x, flow.at(x, row));
        }
    }
    magnitudes
}

/// Pixels of the flow in a pixel of the reduced maps, along one axis.
fn map_step(flow: &impl Field) -> usize {
    let (width, height) = flow.size();
    width.max(height).div_ceil(MAX_MAP_SIDE_PX).max(1)
}

/// Pixels of a frame, and the map that their saliency is computed from.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SaliencyQuery {
    /// Bins of the reduced map.
    pub(crate) bins: Plane<u8>,
    /// Index of each pixel in the reduced map, times 256, plus its own bin.
    pub(crate) pixels: Vec<u32>,
}

impl SaliencyQuery {
    /// Computes the saliency of each pixel, in `0.0..=1.0`.
    pub(crate) fn evaluate(&self, params: &SaliencyParams) -> Vec<f32> {
        let contrast = ContrastParams { num_bins: params.bins as usize, prior: params.prior };
        centre_surround(&self.bins, &contrast, &self.pixels)
    }
}
