//! Input size, working size and the mapping between them.

use crate::image::fit_within;
use crate::trajectory::Trajectories;

/// Size of the input and size at which it is processed, in pixels.
///
/// Both images cover the same area, so a pixel centre `x` of the working image lies at `(x + 1/2) · s − 1/2` in the
/// input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Scale {
    pub(crate) input: (usize, usize),
    pub(crate) working: (usize, usize),
}

impl Scale {
    /// Limits the long side of the working size to `max_side`.
    pub(crate) fn new(input: (usize, usize), max_side: usize) -> Self {
        Self { input, working: fit_within(input.0, input.1, max_side) }
    }

    /// Returns the input pixels per working pixel, horizontally.
    pub(crate) fn x(&self) -> f64 {
        self.input.0 as f64 / self.working.0 as f64
    }

    /// Returns the input pixels per working pixel, vertically.
    pub(crate) fn y(&self) -> f64 {
        self.input.1 as f64 / self.working.1 as f64
    }

    /// Returns the working pixel that covers the centre of an input pixel.
    pub(crate) fn working_pixel(&self, x: usize, y: usize) -> (usize, usize) {
        let map = |v: usize, s: f64, limit: usize| (((v as f64 + 0.5) / s) as usize).min(limit - 1);
        (map(x, self.x(), self.working.0), map(y, self.y(), self.working.1))
    }

    pub(crate) fn to_input(self, tracks: &Trajectories) -> Trajectories {
        self.mapped(tracks, self.input, self.x(), self.y())
    }

    pub(crate) fn to_working(self, tracks: &Trajectories) -> Trajectories {
        self.mapped(tracks, self.working, 1.0 / self.x(), 1.0 / self.y())
    }

    fn mapped(self, tracks: &Trajectories, size: (usize, usize), sx: f64, sy: f64) -> Trajectories {
        let mut mapped = tracks.clone();
        mapped.size = size;
        if self.input != self.working {
            let centre = |v: &mut f32, s: f64| *v = ((f64::from(*v) + 0.5) * s - 0.5) as f32;
            mapped.x.iter_mut().for_each(|v| centre(v, sx));
            mapped.y.iter_mut().for_each(|v| centre(v, sy));
            mapped.variation.iter_mut().for_each(|v| *v *= (0.5 * (sx + sy)) as f32);
        }
        mapped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_larger_frames_are_reduced() {
        assert_eq!(Scale::new((640, 480), 640).working, (640, 480));
        assert_eq!(Scale::new((1920, 1080), 640).working, (640, 360));
        assert_eq!(Scale::new((10_000, 1), 640).working, (640, 1));
    }

    #[test]
    fn corners_map_to_corners_and_back() {
        let scale = Scale::new((1280, 960), 640);
        let mut tracks = Trajectories::empty(2, scale.working);
        tracks.push(0, [(-0.5, 479.5, 0.1), (0.0, 0.0, 0.1)]);
        let input = scale.to_input(&tracks);
        assert_eq!((input.x[0], input.y[0], input.x[1]), (-0.5, 959.5, 0.5));
        assert_eq!(input.size, (1280, 960));
        assert_eq!(scale.to_working(&input).x, tracks.x);
    }
}
