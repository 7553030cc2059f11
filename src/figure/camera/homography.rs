//! Homographies: projective maps of the image plane, in pixels.

/// Maps `(x, y)` to `(a x + b y + c, d x + e y + f) / (g x + h y + i)`; holds the nine numbers row by row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Homography(pub(super) [f64; 9]);

impl Homography {
    pub(crate) const IDENTITY: Self = Self([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);

    /// Maps a point.
    pub(crate) fn apply(&self, x: f64, y: f64) -> (f64, f64) {
        let m = &self.0;
        let w = 1.0 / (m[6] * x + m[7] * y + m[8]);
        ((m[0] * x + m[1] * y + m[2]) * w, (m[3] * x + m[4] * y + m[5]) * w)
    }

    /// Returns the map that applies `before` and then `self`.
    pub(super) fn after(&self, before: &Self) -> Self {
        let (a, b) = (&self.0, &before.0);
        let entry = |k: usize| (0..3).map(|j| a[k / 3 * 3 + j] * b[j * 3 + k % 3]).sum();
        Self(std::array::from_fn(entry)).normalized()
    }

    /// Returns the inverse map, or the identity if it is singular.
    pub(super) fn inverse(&self) -> Self {
        let m = &self.0;
        let minor = |a: usize, b: usize, c: usize, d: usize| m[a] * m[d] - m[b] * m[c];
        let adjugate = [
            minor(4, 5, 7, 8),
            -minor(1, 2, 7, 8),
            minor(1, 2, 4, 5),
            -minor(3, 5, 6, 8),
            minor(0, 2, 6, 8),
            -minor(0, 2, 3, 5),
            minor(3, 4, 6, 7),
            -minor(0, 1, 6, 7),
            minor(0, 1, 3, 4),
        ];
        let determinant = m[0] * adjugate[0] + m[1] * adjugate[3] + m[2] * adjugate[6];
        if determinant == 0.0 || !determinant.is_finite() { Self::IDENTITY } else { Self(adjugate).normalized() }
    }

    /// Returns the same map for images reduced by `scale`.
    pub(super) fn rescaled(&self, scale: f64) -> Self {
        // Pixel centres are at whole numbers.
        let shift = 0.5 * (scale - 1.0);
        let up = Self([scale, 0.0, shift, 0.0, scale, shift, 0.0, 0.0, 1.0]);
        up.inverse().after(&self.after(&up))
    }

    fn normalized(self) -> Self {
        let w = self.0[8];
        if w == 0.0 { self } else { Self(self.0.map(|v| v / w)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAP: Homography = Homography([1.1, 0.1, 3.0, -0.05, 0.9, -2.0, 1e-4, -2e-4, 1.0]);

    fn is_near(a: (f64, f64), b: (f64, f64)) -> bool {
        (a.0 - b.0).abs() < 1e-9 && (a.1 - b.1).abs() < 1e-9
    }

    #[test]
    fn one_after_the_other_and_back() {
        let second = Homography([0.8, 0.0, 1.0, 0.2, 1.2, 0.0, 0.0, 1e-3, 1.0]);
        for (x, y) in [(0.0, 0.0), (10.0, 5.0), (120.0, 90.0)] {
            let (u, v) = MAP.apply(x, y);
            assert!(is_near(second.after(&MAP).apply(x, y), second.apply(u, v)));
            assert!(is_near(MAP.inverse().apply(u, v), (x, y)));
        }
        assert_eq!(Homography([0.0; 9]).inverse(), Homography::IDENTITY);
    }

    #[test]
    fn in_reduced_images_points_go_where_their_pixels_go() {
        let small = MAP.rescaled(4.0);
        for (x, y) in [(0.0, 0.0), (7.0, 3.0)] {
            let (u, v) = MAP.apply(4.0 * x + 1.5, 4.0 * y + 1.5);
            assert!(is_near(small.apply(x, y), ((u - 1.5) / 4.0, (v - 1.5) / 4.0)));
        }
    }
}
