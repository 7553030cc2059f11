//! How well one affine motion explains a set of velocities.

/// Part of the weights that holds the motion's slopes back: few points in a line leave some of them open.
const RIDGE: f64 = 1e-3;

/// Sums over points, from which the best affine motion and what it leaves over follow; those of two sets add up.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct AffineSums {
    /// Number of points.
    pub(super) count: f64,
    /// Weights, times 1, x, y, x², xy, y².
    places: [f64; 6],
    /// Weights and velocity to the right, and down, times 1, x, y.
    u: [f64; 3],
    v: [f64; 3],
    /// Weights times squared speed.
    energy: f64,
}

impl AffineSums {
    /// Adds a point at a place of the order of 1 with a velocity in pixels a frame and the inverse square of its noise.
    pub(super) fn add(&mut self, (x, y): (f64, f64), (u, v): (f64, f64), weight: f64) {
        self.count += 1.0;
        let basis = [1.0, x, y];
        let squares = [1.0, x, y, x * x, x * y, y * y];
        self.places.iter_mut().zip(squares).for_each(|(sum, value)| *sum += weight * value);
        self.u.iter_mut().zip(basis).for_each(|(sum, value)| *sum += weight * u * value);
        self.v.iter_mut().zip(basis).for_each(|(sum, value)| *sum += weight * v * value);
        self.energy += weight * (u * u + v * v);
    }

    /// Those of both sets.
    pub(super) fn with(&self, other: &Self) -> Self {
        let mut sum = *self;
        sum.count += other.count;
        sum.places.iter_mut().zip(other.places).for_each(|(a, b)| *a += b);
        sum.u.iter_mut().zip(other.u).for_each(|(a, b)| *a += b);
        sum.v.iter_mut().zip(other.v).for_each(|(a, b)| *a += b);
        sum.energy += other.energy;
        sum
    }

    /// The squared differences from the best affine motion, in units of the noise, summed over the points.
    pub(super) fn residual(&self) -> f64 {
        let [w, x, y, xx, xy, yy] = self.places;
        if w <= 0.0 {
            return 0.0;
        }
        // Elimination: the sums less their means, then the second axis less the first.
        let (xx, xy, yy) = (xx - x * x / w + RIDGE * w, xy - x * y / w, yy - y * y / w + RIDGE * w);
        let yy = yy - xy * xy / xx;
        let explained = |[b, bx, by]: [f64; 3]| {
            let (bx, by) = (bx - x * b / w, by - y * b / w);
            let by = by - xy * bx / xx;
            b * b / w + bx * bx / xx + by * by / yy
        };
        (self.energy - explained(self.u) - explained(self.v)).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    /// Points that move by an affine motion, and by `noise` besides.
    fn points(motion: [f64; 6], noise: f64, seed: u64) -> AffineSums {
        let mut rng = Rng::for_stage(seed, "affine");
        let mut sums = AffineSums::default();
        for _ in 0..200 {
            let (x, y) = (rng.range(-1.0, 1.0), rng.range(-1.0, 1.0));
            let [a, b, c, d, e, f] = motion;
            let stray = (noise * rng.range(-1.0, 1.0), noise * rng.range(-1.0, 1.0));
            sums.add((x, y), (a + b * x + c * y + stray.0, d + e * x + f * y + stray.1), 4.0);
        }
        sums
    }

    #[test]
    fn an_affine_motion_leaves_hardly_anything_and_noise_is_left() {
        let motion = [3.0, 0.5, -0.2, 1.0, 0.3, 0.4];
        assert!(points(motion, 0.0, 1).residual() / 200.0 < 0.01);
        // Each axis has the variance of an even spread, noise² / 3.
        let left = points(motion, 0.5, 1).residual() / 200.0;
        assert!((left / (4.0 * 2.0 * 0.25 / 3.0) - 1.0).abs() < 0.15, "{left}");
    }

    #[test]
    fn two_motions_together_leave_more_than_apart_and_one_motion_does_not() {
        let (one, same) =
            (points([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.1, 1), points([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.1, 2));
        let other = points([2.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.1, 3);
        let gain = |a: &AffineSums, b: &AffineSums| a.with(b).residual() - a.residual() - b.residual();
        assert!(gain(&one, &other) > 100.0 * gain(&one, &same).max(0.1));
        assert!(gain(&one, &same) > -1e-6);
        assert_eq!(AffineSums::default().residual(), 0.0);
    }
}
