//! Thinning of a strength map to its ridges by non-maximum suppression (Canny 1986).

use crate::image::{Plane, sample_bilinear};

/// Directions of an orientation map (Martin, Fowlkes and Malik 2004).
pub(crate) const ORIENTATIONS: usize = 8;

/// Keeps `strength` where it is largest across the boundary, and sets it to 0 elsewhere. `orientation` holds the direction of
/// the boundary's normal, in steps of π / [`ORIENTATIONS`] from the x axis towards the y axis.
///
/// A pixel is kept if it is larger than the interpolated value one pixel before it along the normal and not smaller than
/// the one behind it, so that one of two equal neighbours is kept. A rise up to the border of the image is no ridge.
pub(super) fn thin(strength: &Plane<f32>, orientation: &Plane<u8>) -> Plane<f32> {
    let (w, h) = (strength.width(), strength.height());
    let normals = normals();
    let steps = normals.map(|(nx, ny)| [UnitStep::new(-nx, -ny, w), UnitStep::new(nx, ny, w)]);
    let data = strength.data();
    let mut thinned = Plane::filled(w, h, 0.0);
    for y in 0..h {
        let is_row_inside = y > 0 && y + 1 < h;
        let pixels = strength.row(y).iter().zip(orientation.row(y));
        for (x, (thinned, (&value, &orientation))) in thinned.row_mut(y).iter_mut().zip(pixels).enumerate() {
            let k = usize::from(orientation) % ORIENTATIONS;
            let is_largest = if is_row_inside && x > 0 && x + 1 < w {
                let [before, behind] = &steps[k];
                let p = y * w + x;
                value > 0.0 && value > before.sample(data, p) && value >= behind.sample(data, p)
            } else {
                value > 0.0 && is_largest_at_border(strength, x, y, normals[k])
            };
            if is_largest {
                *thinned = value;
            }
        }
    }
    thinned
}

/// A step of one pixel from a pixel that has neighbours on all sides.
struct UnitStep {
    /// From the pixel to the upper left one of the four around the end of the step.
    offset: isize,
    stride: usize,
    fractions: (f32, f32),
}

impl UnitStep {
    fn new(dx: f32, dy: f32, stride: usize) -> Self {
        // A step of exactly one pixel must not lead beyond the neighbour.
        let floor = |d: f32| if d < 0.0 { -1.0 } else { 0.0_f32 };
        let offset = floor(dy) as isize * stride as isize + floor(dx) as isize;
        Self { offset, stride, fractions: (dx - floor(dx), dy - floor(dy)) }
    }

    /// Interpolates the value a step from pixel `p`.
    fn sample(&self, data: &[f32], p: usize) -> f32 {
        let corner = p.wrapping_add_signed(self.offset);
        // One bounds check for all four.
        let around = &data[corner..][..self.stride + 2];
        let (above, below) = ([around[0], around[1]], [around[self.stride], around[self.stride + 1]]);
        let (fx, fy) = self.fractions;
        let above = above[0] + fx * (above[1] - above[0]);
        let below = below[0] + fx * (below[1] - below[0]);
        above + fy * (below - above)
    }
}

/// Returns `true` if a pixel at the border, where steps may leave the image, is largest along `normal`.
fn is_largest_at_border(strength: &Plane<f32>, x: usize, y: usize, normal: Normal) -> bool {
    let value = strength[(x, y)];
    let step = |sign: f32| {
        let (to_x, to_y) = (x as f32 + sign * normal.0, y as f32 + sign * normal.1);
        (to_x.clamp(0.0, (strength.width() - 1) as f32), to_y.clamp(0.0, (strength.height() - 1) as f32))
    };
    let (before, behind) = (step(-1.0), step(1.0));
    value > sample_bilinear(strength, before.0, before.1)
        && value >= sample_bilinear(strength, behind.0, behind.1)
        && behind != (x as f32, y as f32)
}

/// Unit vector across a boundary.
pub(super) type Normal = (f32, f32);

/// Unit normals of the orientations.
pub(crate) fn normals() -> [Normal; ORIENTATIONS] {
    std::array::from_fn(|k| {
        // Exact where a normal is parallel to a side of the image.
        if 2 * k == ORIENTATIONS {
            return (0.0, 1.0);
        }
        let angle = std::f32::consts::PI * k as f32 / ORIENTATIONS as f32;
        (libm::cosf(angle), libm::sinf(angle))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ridge_is_thinned_to_its_crest() {
        let strength = Plane::from_fn(5, 3, |x, _| [0.1, 0.4, 0.9, 0.4, 0.1][x]);
        let out = thin(&strength, &Plane::filled(5, 3, 0));
        for y in 0..3 {
            assert_eq!(out.row(y), [0.0, 0.0, 0.9, 0.0, 0.0]);
        }
        // Along the ridge nothing is larger, so with a normal in this direction no pixel is left.
        assert!(thin(&strength, &Plane::filled(5, 3, 4)).data().iter().all(|&v| v == 0.0));
    }

    #[test]
    fn one_of_two_equal_pixels_is_kept_and_a_rise_to_the_border_is_no_ridge() {
        // At the border of the image and inside of it.
        for rows in [1, 3] {
            let pair = Plane::from_fn(4, rows, |x, _| [0.1, 0.5, 0.5, 0.1][x]);
            assert_eq!(thin(&pair, &Plane::filled(4, rows, 0)).row(rows / 2), [0.0, 0.5, 0.0, 0.0]);
        }
        for rise in [[0.1, 0.2, 0.3, 0.4], [0.4, 0.3, 0.2, 0.1], [0.3, 0.3, 0.3, 0.3]] {
            let out = thin(&Plane::from_fn(4, 1, |x, _| rise[x]), &Plane::filled(4, 1, 0));
            assert!(out.data().iter().all(|&v| v == 0.0), "{rise:?}: {:?}", out.data());
        }
    }
}
