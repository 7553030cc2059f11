//! Thinning: what is left of a strength map on its ridges.

use crate::image::{Plane, sample_bilinear};

/// Directions that an orientation map tells apart.
pub const ORIENTATIONS: usize = 8;

/// `strength` where it is largest across the boundary, 0 elsewhere. `orientation` holds the direction of the boundary's
/// normal, in steps of a half turn by [`ORIENTATIONS`] from the x axis towards the y axis.
///
/// A pixel stays when it is larger than the interpolated value one pixel before it along the normal and not smaller
/// than that behind it, so of two equal neighbours one stays. What rises up to the border of the image has no ridge
/// there.
pub fn thin(strength: &Plane<f32>, orientation: &Plane<u8>) -> Plane<f32> {
    let (w, h) = (strength.width(), strength.height());
    let normals = normals();
    let steps = normals.map(|(nx, ny)| [Inner::new(-nx, -ny, w), Inner::new(nx, ny, w)]);
    let data = strength.data();
    Plane::from_fn(w, h, |x, y| {
        let value = strength[(x, y)];
        let k = usize::from(orientation[(x, y)]) % ORIENTATIONS;
        let is_inside = (1..w.max(2) - 1).contains(&x) && (1..h.max(2) - 1).contains(&y);
        let is_largest = if is_inside {
            let [before, behind] = &steps[k];
            let p = y * w + x;
            value > 0.0 && value > before.sample(data, p) && value >= behind.sample(data, p)
        } else {
            value > 0.0 && is_largest_at_rim(strength, (x, y), normals[k])
        };
        if is_largest { value } else { 0.0 }
    })
}

/// A step of one pixel from a pixel that has neighbours on all sides.
struct Inner {
    /// From the pixel to the upper left one of the four around the place where the step ends.
    offset: isize,
    stride: usize,
    fractions: (f32, f32),
}

impl Inner {
    fn new(dx: f32, dy: f32, stride: usize) -> Self {
        // A step of exactly one pixel must not lead beyond the neighbour.
        let whole = |d: f32| if d < 0.0 { -1.0 } else { 0.0_f32 };
        let offset = whole(dy) as isize * stride as isize + whole(dx) as isize;
        Self { offset, stride, fractions: (dx - whole(dx), dy - whole(dy)) }
    }

    /// The interpolated value a step from pixel `p`.
    fn sample(&self, data: &[f32], p: usize) -> f32 {
        let corner = p.wrapping_add_signed(self.offset);
        let (above, below) = (&data[corner..corner + 2], &data[corner + self.stride..][..2]);
        let (fx, fy) = self.fractions;
        let above = above[0] + fx * (above[1] - above[0]);
        let below = below[0] + fx * (below[1] - below[0]);
        above + fy * (below - above)
    }
}

/// The same where a step may lead out of the image.
fn is_largest_at_rim(strength: &Plane<f32>, (x, y): (usize, usize), (nx, ny): (f32, f32)) -> bool {
    let value = strength[(x, y)];
    let step = |sign: f32| {
        let at = (x as f32 + sign * nx, y as f32 + sign * ny);
        (at.0.clamp(0.0, (strength.width() - 1) as f32), at.1.clamp(0.0, (strength.height() - 1) as f32))
    };
    let (before, behind) = (step(-1.0), step(1.0));
    value > sample_bilinear(strength, before.0, before.1)
        && value >= sample_bilinear(strength, behind.0, behind.1)
        && behind != (x as f32, y as f32)
}

/// Unit normals of the orientations.
pub fn normals() -> [(f32, f32); ORIENTATIONS] {
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
    fn of_two_equal_pixels_one_stays_and_of_a_rise_to_the_border_none() {
        // At the rim of the image and inside of it.
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
