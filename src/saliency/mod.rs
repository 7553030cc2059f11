//! Context-aware saliency (section 3): which trajectories stand out against what surrounds them.
//!
//! In: the flow of each frame, trajectories, their embedding. Out: a saliency in `0.0..=1.0` for each pixel and each trajectory, and the
//! foreground.
//!
//! 1. The motion of the camera, the *dominant motion* of each frame, is taken from its flow; what is left has a magnitude (`dominant`).
//! 2. Magnitudes become bins over a range that the whole clip sets.
//! 3. A pixel is salient as far as its bin is commoner inside some window than in the ring around it (`surround`).
//! 4. A trajectory's own saliency `s` is nearly the greatest of its points'; in context, `s̄`, it is the mean over the trajectories near it in the
//!    embedding, and above a threshold it is foreground (`context`).
//!
//! **Deviations from the paper**, all undone by [`SaliencyParams::paper`].
//!
//! Steps 1 to 3 are the same bits on every target.

mod context;
mod dominant;
mod surround;
#[cfg(test)]
mod tests;

pub use context::{context_saliency, trajectory_saliency};
pub use dominant::DominantMotion;

use crate::flow::FlowField;
use crate::image::Plane;
use dominant::{Search, dominant_motion};
use surround::{Contrast, surround};

crate::choices! {
    /// Which motion of the camera is taken from the flow before its magnitude counts.
    pub enum Compensation {
        /// None: the magnitude of the flow as it is, as the paper has it.
        Off = "off",
        /// The dominant affine motion of each frame.
        Affine = "affine",
        /// The dominant homography of each frame.
        Homography = "homography",
    }
}

crate::choices! {
    /// Which of two trajectories' densities an affinity is compared with.
    pub enum Neighborhood {
        /// The greater, as discontinuities do: both must be as near as the denser of them has its neighbours.
        Max = "max",
        /// The smaller, as the paper prints it: it is enough to be as near as the sparser has them.
        Min = "min",
    }
}

crate::params! {
    /// Saliency, and the foreground that follows from it.
    pub struct SaliencyParams {
        /// Motion of the camera that is taken from the flow before its magnitude is looked at (the paper: off).
        pub compensation: Compensation = Compensation::Affine, in 0..=2;
        /// Difference from the dominant motion at which a point of the flow counts half when that motion is fitted, in pixels.
        pub tolerance: f64 = 0.5, in 0.01..=100.0;
        /// How many times as much a point at the frame's rim counts in that fit as one in its middle.
        pub rim_weight: f64 = 2.0, in 1.0..=100.0;
        /// Longest side of the maps that windows are laid over, in pixels; saliency is looked up for every pixel. Higher is slower.
        pub map_side: u32 = 160, in 16..=1024;
        /// Bins of the magnitude (Rahtu et al.: 15). Higher is slower.
        pub bins: u32 = 15, in 2..=64;
        /// Magnitude at which the last bin ends, in pixels a frame (Rahtu et al.: 15); 0 takes it from the clip.
        pub range: f64 = 0.0, in 0.0..=1000.0;
        /// Where the clip sets the range: this part of all its magnitudes lies within.
        pub range_quantile: f64 = 0.995, in 0.0..=1.0;
        /// Where the clip sets the range: its least end, in pixels a frame. Lower makes smaller motions salient, and noise.
        pub range_floor: f64 = 2.0, in 0.01..=1000.0;
        /// Standard deviation of the smoothing of histograms, in bins (Rahtu et al.: 1).
        pub smoothing: f32 = 1.0, in 0.0..=10.0;
        /// Probability that a pixel of a window is salient before its magnitude is looked at (Rahtu et al.: 0.2).
        pub prior: f32 = 0.2, in 0.001..=0.999;
        /// Factor on the sizes of all windows.
        pub window_scale: f64 = 1.0, in 0.1..=2.0;
        /// A trajectory is as salient as this part of its points do not exceed; 1 is the greatest of all (section 3).
        pub quantile: f64 = 1.0, in 0.0..=1.0;
        /// ℓ: trajectories count as close in the embedding while their embedding affinity is above this part of their density
        /// (section 3; the value is not given there). Higher averages over fewer.
        pub neighborhood: f64 = 0.4, in 0.0..=1.0;
        /// Which of two trajectories' densities that is (the paper: min).
        pub form: Neighborhood = Neighborhood::Max, in 0..=1;
        /// Trajectories of a context-aware saliency above this are foreground (section 3: 0.5).
        pub threshold: f64 = 0.5, in 0.0..=1.0;
    }
}

impl SaliencyParams {
    /// As the paper has it: the magnitude of the flow as it is, in 15 bins over 0 to 15 pixels, and the greatest saliency of a trajectory's points.
    pub fn paper() -> Self {
        Self { compensation: Compensation::Off, range: 15.0, quantile: 1.0, form: Neighborhood::Min, ..Self::default() }
    }

    fn contrast(&self) -> Contrast {
        Contrast {
            num_bins: self.bins as usize,
            prior: self.prior,
            smoothing: self.smoothing,
            window_scale: self.window_scale,
        }
    }
}

/// How salient each trajectory is.
///
/// Law: the three have one entry for each trajectory; saliencies are in `0.0..=1.0`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Saliency {
    /// `s_i`: nearly the greatest saliency of the trajectory's points, or the greatest.
    pub of_points: Vec<f32>,
    /// `s̄_i`: the mean of `s` over the trajectory's neighbourhood in the embedding.
    pub in_context: Vec<f32>,
    /// Whether `s̄_i` is above the threshold.
    pub foreground: Vec<bool>,
}

/// Counts a pixel of magnitude.
const COUNTS_PER_PIXEL: f32 = 64.0;

/// Magnitudes at and beyond this many counts are counted as one.
const MOST_COUNTS: usize = 64 * 256;

/// Saliency maps of the frames of one clip: first all flows are looked at, then maps can be made.
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

    /// Takes note of the next frame's flow: its dominant motion and its magnitudes. Call once for each flow of the clip, in order.
    pub fn look_at(&mut self, flow: &FlowField) {
        let search = Search {
            perspective: self.params.compensation == Compensation::Homography,
            tolerance: self.params.tolerance,
            rim_weight: self.params.rim_weight,
        };
        let motion = match self.params.compensation {
            Compensation::Off => DominantMotion::none(flow),
            _ => dominant_motion(flow, &search, self.motions.last()),
        };
        for &magnitude in self.reduced(flow, &motion).data() {
            self.counts[((magnitude * COUNTS_PER_PIXEL) as usize).min(MOST_COUNTS - 1)] += 1;
        }
        self.motions.push(motion);
    }

    /// The motion of the camera in each flow looked at.
    pub fn motions(&self) -> &[DominantMotion] {
        &self.motions
    }

    /// Magnitude at which the last bin ends, in pixels.
    pub fn range(&self) -> f64 {
        if self.params.range > 0.0 {
            return self.params.range;
        }
        let total: u64 = self.counts.iter().map(|&c| u64::from(c)).sum();
        let wanted = self.params.range_quantile * total as f64;
        let mut within = 0.0;
        let enough = |&count: &u32| {
            within += f64::from(count);
            within >= wanted
        };
        let last = self.counts.iter().position(enough).unwrap_or(0);
        ((last + 1) as f64 / f64::from(COUNTS_PER_PIXEL)).max(self.params.range_floor)
    }

    /// Pixels of the flow a pixel of the reduced maps.
    fn step(&self, flow: &FlowField) -> usize {
        flow.u.width().max(flow.u.height()).div_ceil(self.params.map_side as usize).max(1)
    }

    /// What is left of the flow's magnitude at every few pixels.
    fn reduced(&self, flow: &FlowField, motion: &DominantMotion) -> Plane<f32> {
        let step = self.step(flow);
        let (width, height) = (flow.u.width().div_ceil(step), flow.u.height().div_ceil(step));
        let mut magnitudes = Plane::filled(width, height, 0.0);
        let middle = |at: usize, side: usize| (at * step + step / 2).min(side - 1);
        for y in 0..height {
            let first = (step / 2).min(flow.u.width() - 1);
            let row = middle(y, flow.u.height());
            motion.residuals(flow, row, (first, step), magnitudes.row_mut(y));
        }
        magnitudes
    }

    /// The saliency of each pixel of frame `t`, whose flow this is, in `0.0..=1.0`.
    pub fn map(&self, t: usize, flow: &FlowField) -> Plane<f32> {
        let motion = self.motions.get(t).copied().unwrap_or_else(|| DominantMotion::none(flow));
        let (width, height) = (flow.u.width(), flow.u.height());
        let contrast = self.params.contrast();
        let bin = bin_of(self.range(), contrast.num_bins);
        let bins = self.reduced(flow, &motion).map(&bin);
        let found = surround(&bins, &contrast);
        let (step, size) = (self.step(flow), (bins.width(), bins.width() * bins.height()));
        let mut map = Plane::filled(width, height, 0.0);
        let mut magnitudes = vec![0.0; width];
        for y in 0..height {
            motion.residuals(flow, y, (0, 1), &mut magnitudes);
            let line = (y / step) * size.0;
            for (x, (s, &magnitude)) in map.row_mut(y).iter_mut().zip(&magnitudes).enumerate() {
                *s = found[usize::from(bin(magnitude)) * size.1 + line + x / step];
            }
        }
        map
    }
}

/// The bin of a magnitude: bins are closed above, as Rahtu et al. have them.
fn bin_of(range: f64, num_bins: usize) -> impl Fn(f32) -> u8 {
    let scale = (num_bins as f64 / range) as f32;
    let last = (num_bins - 1) as f32;
    move |magnitude| ((magnitude * scale).ceil() - 1.0).clamp(0.0, last) as u8
}
