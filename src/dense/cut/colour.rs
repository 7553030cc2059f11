//! Colour histograms in three dimensions, written and read with trilinear interpolation.

use serde::{Deserialize, Serialize};

/// Bins along one axis: 0 to 255 in steps of 16, both ends included. Chosen by eye.
const BINS_PER_AXIS: usize = 17;

/// A position in a histogram: the bin below it, and the distance from that on each axis, in sixteenths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Colour {
    bin: u16,
    fraction: [u8; 3],
}

impl Colour {
    /// Converts red, green and blue to brightness, red against blue, and green against both. The latter two vary little in
    /// natural images and are doubled.
    pub(crate) fn from_rgb(rgb: &[u8]) -> Self {
        let [r, g, b] = [rgb[0], rgb[1], rgb[2]].map(i32::from);
        let axes = [(r + 2 * g + b) / 4, r - b + 128, g - (r + b) / 2 + 128].map(|v| v.clamp(0, 255) as usize);
        let bin = axes.iter().fold(0, |bin, v| bin * BINS_PER_AXIS + v / 16);
        Self { bin: bin as u16, fraction: axes.map(|v| (v % 16) as u8) }
    }

    /// Returns the eight bins around it and their weights, which sum to one.
    pub(crate) fn corners(self) -> Corners {
        let [first, second, third] = self.fraction.map(|f| f32::from(f) / 16.0).map(|f| [1.0 - f, f]);
        std::array::from_fn(|k| {
            let (a, b, c) = (k / 4, k / 2 % 2, k % 2);
            let bin = usize::from(self.bin) + (a * BINS_PER_AXIS + b) * BINS_PER_AXIS + c;
            (bin, first[a] * second[b] * third[c])
        })
    }
}

/// Bins and weights of a colour, computed once for several histograms.
pub(crate) type Corners = [(usize, f32); 8];

/// Histogram of colours.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Histogram {
    bins: Vec<f32>,
    total: f32,
}

impl Histogram {
    pub(crate) fn new() -> Self {
        Self { bins: vec![0.0; BINS_PER_AXIS * BINS_PER_AXIS * BINS_PER_AXIS], total: 0.0 }
    }

    pub(crate) fn clear(&mut self) {
        self.bins.fill(0.0);
        self.total = 0.0;
    }

    pub(crate) fn add(&mut self, colour: &Corners, weight: f32) {
        for (bin, share) in colour {
            self.bins[*bin] += weight * share;
        }
        self.total += weight;
    }

    /// Returns the sum of all weights.
    pub(crate) fn total(&self) -> f32 {
        self.total
    }

    /// Returns the share of the weights at this colour, 0 to 1; 0 of an empty histogram.
    pub(crate) fn share(&self, colour: &Corners) -> f32 {
        let weight: f32 = colour.iter().map(|&(bin, share)| share * self.bins[bin]).sum();
        if self.total > 0.0 { weight / self.total } else { 0.0 }
    }

    /// Computes the similarity of two histograms, 0 to 1: the Bhattacharyya coefficient.
    pub(crate) fn similarity(&self, other: &Self) -> f32 {
        let common: f32 = self.bins.iter().zip(&other.bins).map(|(a, b)| (a * b).sqrt()).sum();
        let total = (self.total * other.total).sqrt();
        if total > 0.0 { common / total } else { 0.0 }
    }

    /// Returns the share of the weights at this colour without one sample of it, of weight 1.
    pub(crate) fn leave_one_out_share(&self, colour: &Corners) -> f32 {
        let weight: f32 = colour.iter().map(|&(bin, share)| share * (self.bins[bin] - share)).sum();
        if self.total > 1.0 { weight.max(0.0) / (self.total - 1.0) } else { 0.0 }
    }
}

/// Share that is added to each colour, for those that were never seen. Chosen by eye.
pub(crate) const UNSEEN_SHARE: f32 = 2e-4;

#[cfg(test)]
mod tests {
    use super::*;

    fn corners(rgb: [u8; 3]) -> Corners {
        Colour::from_rgb(&rgb).corners()
    }

    #[test]
    fn a_colour_at_a_bin_has_its_full_share_and_distant_ones_none() {
        let mut histogram = Histogram::new();
        assert_eq!(histogram.share(&corners([1, 2, 3])), 0.0);
        let grey = &corners([64, 64, 64]);
        histogram.add(grey, 3.0);
        assert_eq!(histogram.share(grey), 1.0);
        assert_eq!(histogram.share(&corners([72, 72, 72])), 0.5);
        assert_eq!(histogram.share(&corners([96, 96, 96])), 0.0);
        histogram.add(&corners([250, 10, 10]), 1.0);
        assert_eq!((histogram.share(grey), histogram.total()), (0.75, 4.0));
        assert_eq!(histogram.leave_one_out_share(grey), 2.0 / 3.0);
        assert_eq!(histogram.leave_one_out_share(&corners([250, 10, 10])), 0.0);
        histogram.clear();
        assert_eq!((histogram.share(grey), histogram.total()), (0.0, 0.0));
    }

    #[test]
    fn extreme_colours_have_a_place_of_their_own() {
        let mut places = Vec::new();
        for r in [0, 255] {
            for g in [0, 255] {
                for b in [0, 255] {
                    let mut histogram = Histogram::new();
                    histogram.add(&corners([r, g, b]), 1.0);
                    assert!((histogram.bins.iter().sum::<f32>() - 1.0).abs() < 1e-6);
                    assert!(histogram.share(&corners([r, g, b])) > 0.1);
                    places.push(Colour::from_rgb(&[r, g, b]));
                }
            }
        }
        places.sort_by_key(|c| c.bin);
        assert!(places.windows(2).all(|pair| pair[0] != pair[1]));
    }
}
