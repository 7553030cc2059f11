//! Tools to paint sprites: hashed noise, signed distances and mixing of colours, by sums, products and square roots only.

use crate::rng::mix;

/// Red, green and blue in `0.0..=255.0`.
pub(crate) type Colour = [f32; 3];

/// Smooth pseudo-random fields, one for each seed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Noise(pub u64);

impl Noise {
    /// Samples noise of a wavelength of about two units, in `-1.0..=1.0`.
    fn value(self, x: f32, y: f32) -> f32 {
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (smooth(x - x0), smooth(y - y0));
        let (column, row) = (x0 as i64, y0 as i64);
        let top = lerp(self.lattice(column, row), self.lattice(column + 1, row), fx);
        let bottom = lerp(self.lattice(column, row + 1), self.lattice(column + 1, row + 1), fx);
        lerp(top, bottom, fy)
    }

    fn lattice(self, column: i64, row: i64) -> f32 {
        let hash = mix(self.0 ^ (column as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (row as u64).rotate_left(32));
        (hash >> 40) as f32 * (2.0 / 16_777_216.0) - 1.0
    }

    /// Samples a sum of octaves, about `-1.0..=1.0`: cells from `coarsest` down to `finest` units, each octave half as wide
    /// and 0.6 times as strong. It is band-limited, so that a sprite can be resampled.
    #[inline(never)]
    pub(crate) fn fractal(self, x: f32, y: f32, coarsest: f32, finest: f32) -> f32 {
        let (mut x, mut y, mut cell, mut strength, mut sum) = (x, y, coarsest, 0.62, 0.0);
        let mut octave = self;
        while cell >= finest && strength > 0.02 {
            sum += strength * octave.value(x / cell, y / cell);
            // Rotated by the angle of a 3-4-5 triangle, so that the lattices of the octaves do not align.
            (x, y) = (0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y);
            octave = Self(octave.0.wrapping_add(0x1234_5677));
            cell *= 0.5;
            strength *= 0.6;
        }
        sum
    }
}

/// Eases `f` in `0.0..=1.0` by Perlin's quintic polynomial.
fn smooth(f: f32) -> f32 {
    f * f * f * (f * (f * 6.0 - 15.0) + 10.0)
}

/// Interpolates from `a` to `b` as `f` goes from 0 to 1.
pub(super) fn lerp(a: f32, b: f32, f: f32) -> f32 {
    a + (b - a) * f
}

/// Interpolates from colour `a` to `b` as `f` goes from 0 to 1.
#[inline(never)]
pub(super) fn blend(a: Colour, b: Colour, f: f32) -> Colour {
    [lerp(a[0], b[0], f), lerp(a[1], b[1], f), lerp(a[2], b[2], f)]
}

/// Makes a colour lighter (`amount > 0`) or darker, in proportion.
#[inline(never)]
pub(super) fn shade(colour: Colour, amount: f32) -> Colour {
    colour.map(|c| (c * (1.0 + amount)).clamp(0.0, 255.0))
}

/// Returns 0 below `low`, 1 above `high`, and a smooth step between (GLSL's `smoothstep`).
#[inline(never)]
pub(super) fn ramp(low: f32, high: f32, value: f32) -> f32 {
    let f = ((value - low) / (high - low)).clamp(0.0, 1.0);
    f * f * (3.0 - 2.0 * f)
}

/// Computes the signed distance to a bar from `a` to `b` with round ends of radii `ra` and `rb`; exact for equal radii.
#[inline(never)]
pub(super) fn bar(x: f32, y: f32, a: (f32, f32), b: (f32, f32), ra: f32, rb: f32) -> f32 {
    let (px, py, dx, dy) = (x - a.0, y - a.1, b.0 - a.0, b.1 - a.1);
    let f = ((px * dx + py * dy) / (dx * dx + dy * dy).max(1e-9)).clamp(0.0, 1.0);
    length(px - f * dx, py - f * dy) - lerp(ra, rb, f)
}

/// Computes the signed distance to a disc.
#[inline(never)]
pub(super) fn disc(x: f32, y: f32, centre: (f32, f32), radius: f32) -> f32 {
    length(x - centre.0, y - centre.1) - radius
}

/// Computes the signed distance to a box of half sides `half` whose corners are rounded by `radius`.
#[inline(never)]
pub(super) fn rounded_box(x: f32, y: f32, centre: (f32, f32), half: (f32, f32), radius: f32) -> f32 {
    let (dx, dy) = ((x - centre.0).abs() - half.0 + radius, (y - centre.1).abs() - half.1 + radius);
    length(dx.max(0.0), dy.max(0.0)) + dx.max(dy).min(0.0) - radius
}

fn length(x: f32, y: f32) -> f32 {
    (x * x + y * y).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_bounded_and_has_no_mean() {
        let noise = Noise(5);
        let values: Vec<f32> = (0..4096).map(|i| noise.fractal((i % 64) as f32, (i / 64) as f32, 16.0, 2.0)).collect();
        let mean = values.iter().sum::<f32>() / 4096.0;
        let spread = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f32>() / 4096.0;
        assert!(values.iter().all(|v| v.abs() < 1.6), "largest {:?}", values.iter().copied().reduce(f32::max));
        assert!(mean.abs() < 0.15 && spread > 0.02, "mean {mean}, variance {spread}");
    }

    #[test]
    fn distances_of_simple_shapes() {
        assert_eq!(disc(3.0, 4.0, (0.0, 0.0), 2.0), 3.0);
        assert_eq!(bar(5.0, 3.0, (0.0, 0.0), (10.0, 0.0), 1.0, 1.0), 2.0);
        assert_eq!(rounded_box(7.0, 0.0, (0.0, 0.0), (5.0, 2.0), 1.0), 2.0);
        assert_eq!(rounded_box(0.0, 0.0, (0.0, 0.0), (5.0, 2.0), 1.0), -2.0);
    }
}
