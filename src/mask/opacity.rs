//! Opacity along the borders of a mask.
//!
//! In: which pixels are inside, and their picture. Out: 0 to 255 for each pixel, 0 or 255 away from borders.
//!
//! 1. In a window around each pixel near the border: the means `F` and `B` of the colours inside and outside, and their common
//!    covariance Σ. Colours at the border itself may be mixed and are left out.
//! 2. With `a = Σ⁻¹ (F − B)` and `D² = a · (F − B)`, the opacity of a pixel of colour `I` is `1/2 + a · (I − (F + B) / 2) / D²`:
//!    Fisher's discriminant, scaled to 1 at `F` and 0 at `B`. Its variance is `1 / D²`.
//! 3. The mean of these opacities over all windows that contain the pixel, weighted by `D²`.
//! 4. That mean is blended with the mask, with weight `D² s² / (D² s² + HALF_WEIGHT_D_SQ)`, where `s` falls from 1 at the border
//!    to 0 at the reach of a window. So the mask stays where colours do not discriminate, and far from borders.
//!
//! Functions that are linear in the colours of a window and averaged over windows are from the guided filter of He, Sun and
//! Tang ("Guided Image Filtering", PAMI 2013), which fits the mask itself and made hard borders soft. The cost is linear in the
//! pixels near borders. Sums over pixels are in integers. Not in the paper.

use super::refine::border_box;
use crate::image::{Frame, Plane};
use std::ops::{AddAssign, Range, SubAssign};

// All chosen by eye.
/// The longer side of the picture in radii of the windows.
const SIDE_IN_RADII: usize = 140;
/// Largest radius, for speed; sums of squared colours fit 32 bits up to 128.
const MAX_RADIUS_PX: usize = 12;
/// The radius in widths of the band of mixed colours on each side of a border; also the least radius.
const RADIUS_IN_MIXED_BANDS: usize = 3;
/// Variance of the noise in each channel, in squared grey levels.
const NOISE_VARIANCE: f64 = 6.0;
/// D² at which colours and the mask have equal weight at the border.
const HALF_WEIGHT_D_SQ: f64 = 2.0;
/// Side of the tiles that are processed at once, in radii.
const TILE_IN_RADII: usize = 6;

/// Computes the opacity of each pixel: at least 128 inside and less outside.
pub(super) fn opacity(inside: &Plane<bool>, picture: &Frame) -> Plane<u8> {
    let (w, h) = (inside.width(), inside.height());
    let mut alpha = inside.map(|is_inside| if is_inside { 255 } else { 0 });
    let radius = (w.max(h) / SIDE_IN_RADII).clamp(RADIUS_IN_MIXED_BANDS, MAX_RADIUS_PX);
    let (tile, halo) = (TILE_IN_RADII * radius, 2 * radius);
    let widened = |start: usize, end: usize| start.saturating_sub(radius)..(start + tile + radius).min(end);
    for top in (0..h).step_by(tile) {
        for left in (0..w).step_by(tile) {
            let Some(border) = border_box(inside, widened(left, w), widened(top, h)) else { continue };
            // Only pixels within the reach of a window change.
            let clip = |border: &Range<usize>, start: usize, end: usize| {
                start.max(border.start.saturating_sub(radius))..(start + tile).min(border.end + radius).min(end)
            };
            let (columns, rows) = (clip(&border.0, left, w), clip(&border.1, top, h));
            let (x, y) = (columns.start.saturating_sub(halo), rows.start.saturating_sub(halo));
            let size = ((columns.end + halo).min(w) - x, (rows.end + halo).min(h) - y);
            let soft = Patch::new(inside, picture, (x, y), size).opacity(radius);
            for v in rows {
                alpha.row_mut(v)[columns.clone()]
                    .copy_from_slice(&soft[(v - y) * size.0..][columns.start - x..columns.end - x]);
            }
        }
    }
    alpha
}

/// A tile of the picture with the reach of its windows.
struct Patch {
    width: usize,
    /// 1 inside, 0 outside.
    inside: Vec<u32>,
    colours: [Vec<u32>; 3],
}

/// The channels of the entries in the upper triangle of a covariance matrix.
const CHANNEL_PAIRS: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

impl Patch {
    fn new(inside: &Plane<bool>, picture: &Frame, (x, y): (usize, usize), (width, height): (usize, usize)) -> Self {
        let row = |v: usize| &picture.rgb()[3 * (v * picture.width() + x)..][..3 * width];
        let mask_row = |v: usize| inside.row(v)[x..x + width].iter().map(|&is_inside| u32::from(is_inside));
        let channel = |c: usize| {
            let mut values = Vec::with_capacity(width * height);
            (y..y + height).for_each(|v| values.extend(row(v).chunks_exact(3).map(|rgb| u32::from(rgb[c]))));
            values
        };
        Self { width, inside: (y..y + height).flat_map(mask_row).collect(), colours: std::array::from_fn(channel) }
    }

    /// Steps 3 and 4.
    fn opacity(&self, radius: usize) -> Vec<u8> {
        let fits = self.fits(radius).map(|fit| sums(fit, self.width, radius));
        let counts = sums(vec![1_u32; self.inside.len()], self.width, radius);
        let insides = sums(self.inside.clone(), self.width, radius);
        let blend = |p: usize| {
            let (mask, weight) = (f64::from(self.inside[p]), fits[4][p]);
            if weight == 0.0 {
                return mask;
            }
            let fit = fits[3][p] + (0..3).map(|c| fits[c][p] * f64::from(self.colours[c][p])).sum::<f64>();
            let nearness = 1.0 - (2.0 * f64::from(insides[p]) / f64::from(counts[p]) - 1.0).abs();
            let trust = weight / f64::from(counts[p]) * nearness * nearness;
            mask + ((fit / weight).clamp(0.0, 1.0) - mask) * trust / (trust + HALF_WEIGHT_D_SQ)
        };
        let byte = |p: usize| {
            let value = (255.0 * blend(p) + 0.5) as u8;
            if self.inside[p] == 1 { value.max(128) } else { value.min(127) }
        };
        (0..self.inside.len()).map(byte).collect()
    }

    /// Steps 1 and 2 at each pixel: a (three channels), D² times the opacity of black, and D²; all zero without colours of both
    /// sides.
    fn fits(&self, radius: usize) -> [Vec<f64>; 5] {
        let n = self.inside.len();
        let band = radius / RADIUS_IN_MIXED_BANDS;
        let counts = sums(vec![1_u32; n], self.width, band);
        let insides = sums(self.inside.clone(), self.width, band);
        let is_pure = |(&inside, &count): (&u32, &u32)| u32::from(inside == 0 || inside == count);
        let pure: Vec<u32> = insides.iter().zip(&counts).map(is_pure).collect();
        let sum = |values: Vec<u32>| sums(values, self.width, radius);
        let inner_mask = product(&pure, &self.inside);
        let pure_colours = self.colours.each_ref().map(|colour| product(&pure, colour));
        let inner_colours = self.colours.each_ref().map(|colour| sum(product(&inner_mask, colour)));
        let squares = CHANNEL_PAIRS.map(|(c, d)| sum(product(&pure_colours[c], &self.colours[d])));
        let (total, inner, colours) = (sum(pure), sum(inner_mask), pure_colours.map(sum));
        let mut fits: [Vec<f64>; 5] = std::array::from_fn(|_| vec![0.0; n]);
        for p in (0..n).filter(|&p| inner[p] > 0 && inner[p] < total[p]) {
            let (count, inner) = (f64::from(total[p]), f64::from(inner[p]));
            let outer = count - inner;
            let f: [f64; 3] = std::array::from_fn(|c| f64::from(inner_colours[c][p]) / inner);
            let b: [f64; 3] = std::array::from_fn(|c| f64::from(colours[c][p] - inner_colours[c][p]) / outer);
            let covariance: [f64; 6] = std::array::from_fn(|k| {
                let (c, d) = CHANNEL_PAIRS[k];
                (f64::from(squares[k][p]) - inner * f[c] * f[d] - outer * b[c] * b[d]) / count
            });
            let difference: [f64; 3] = std::array::from_fn(|c| f[c] - b[c]);
            let a = solve_regularized(covariance, difference);
            let dot = |v: [f64; 3]| (0..3).map(|c| a[c] * v[c]).sum::<f64>();
            let weight = dot(difference);
            let at_black = 0.5 * (weight - dot(f) - dot(b));
            for (fit, value) in fits.iter_mut().zip([a[0], a[1], a[2], at_black, weight]) {
                fit[p] = value;
            }
        }
        fits
    }
}

fn product(a: &[u32], b: &[u32]) -> Vec<u32> {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}

/// Rows that are summed in parallel, since each running sum waits for its predecessor.
const PARALLEL_ROWS: usize = 4;

/// Sums values over square windows of this radius, clipped at the frame border.
fn sums<T: Copy + Default + AddAssign + SubAssign>(values: Vec<T>, width: usize, radius: usize) -> Vec<T> {
    let height = values.len() / width;
    let mut row_sums = values;
    let mut lines = vec![[T::default(); PARALLEL_ROWS]; width];
    for rows in row_sums.chunks_mut(PARALLEL_ROWS * width) {
        for (k, row) in rows.chunks_exact(width).enumerate() {
            lines.iter_mut().zip(row).for_each(|(line, &v)| line[k] = v);
        }
        let mut sum = [T::default(); PARALLEL_ROWS];
        lines.iter().take(radius).for_each(|line| add(&mut sum, line));
        for x in 0..width {
            if let Some(next) = lines.get(x + radius) {
                add(&mut sum, next);
            }
            if x > radius {
                sum.iter_mut().zip(lines[x - radius - 1]).for_each(|(sum, v)| *sum -= v);
            }
            rows.chunks_exact_mut(width).zip(sum).for_each(|(row, sum)| row[x] = sum);
        }
    }
    let mut line = vec![T::default(); width];
    let mut window_sums = Vec::with_capacity(row_sums.len());
    let row = |y: usize| &row_sums[y * width..][..width];
    for y in 0..radius.min(height) {
        add(&mut line, row(y));
    }
    for y in 0..height {
        if y + radius < height {
            add(&mut line, row(y + radius));
        }
        if y > radius {
            line.iter_mut().zip(row(y - radius - 1)).for_each(|(sum, &v)| *sum -= v);
        }
        window_sums.extend_from_slice(&line);
    }
    window_sums
}

fn add<T: Copy + AddAssign>(sums: &mut [T], values: &[T]) {
    sums.iter_mut().zip(values).for_each(|(sum, &v)| *sum += v);
}

/// Returns `(S + NOISE_VARIANCE · 1)⁻¹ t`. S is given by its upper triangle.
fn solve_regularized([s00, s01, s02, s11, s12, s22]: [f64; 6], t: [f64; 3]) -> [f64; 3] {
    let (s00, s11, s22) = (s00 + NOISE_VARIANCE, s11 + NOISE_VARIANCE, s22 + NOISE_VARIANCE);
    // The matrix of cofactors; the determinant is at least NOISE_VARIANCE³, as S has no negative eigenvalue.
    let (c00, c01, c02) = (s11 * s22 - s12 * s12, s02 * s12 - s01 * s22, s01 * s12 - s02 * s11);
    let (c11, c12, c22) = (s00 * s22 - s02 * s02, s01 * s02 - s00 * s12, s00 * s11 - s01 * s01);
    let determinant = s00 * c00 + s01 * c01 + s02 * c02;
    [[c00, c01, c02], [c01, c11, c12], [c02, c12, c22]]
        .map(|row| (row[0] * t[0] + row[1] * t[1] + row[2] * t[2]) / determinant)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn sums_are_those_of_each_window() {
        let mut rng = Rng::for_stage(1, "alpha");
        for (w, h, radius) in [(9, 7, 2), (5, 8, 0), (3, 4, 6), (1, 1, 1), (20, 3, 3)] {
            let values: Vec<u32> = (0..w * h).map(|_| rng.below(100) as u32).collect();
            let fast = sums(values.clone(), w, radius);
            for y in 0..h {
                for x in 0..w {
                    let is_near = |p: &usize| (p % w).abs_diff(x) <= radius && (p / w).abs_diff(y) <= radius;
                    let slow: u32 = (0..w * h).filter(is_near).map(|p| values[p]).sum();
                    assert_eq!(fast[y * w + x], slow, "at {x}, {y}, radius {radius}");
                }
            }
        }
    }

    #[test]
    fn the_solution_solves_its_system() {
        let s = [90.0, 20.0, -10.0, 60.0, 5.0, 40.0];
        let a = solve_regularized(s, [7.0, -3.0, 2.0]);
        let rows = [
            [s[0] + NOISE_VARIANCE, s[1], s[2]],
            [s[1], s[3] + NOISE_VARIANCE, s[4]],
            [s[2], s[4], s[5] + NOISE_VARIANCE],
        ];
        for (row, t) in rows.into_iter().zip([7.0, -3.0, 2.0]) {
            let product: f64 = row.iter().zip(a).map(|(r, a)| r * a).sum();
            assert!((product - t).abs() < 1e-12, "{product} for {t}");
        }
    }

    #[test]
    fn tiles_do_not_show() {
        // A border along the whole picture, which many tiles share, has one profile.
        let (w, h) = (200, 40);
        let rgb = (0..w * h).flat_map(|p| [[40, 40, 40], [90, 80, 85], [150, 130, 140]][(p / w).clamp(18, 20) - 18]);
        let picture = Frame::from_rgb(rgb.collect(), w, h).unwrap();
        let alpha = opacity(&Plane::from_fn(w, h, |_, y| y >= 20), &picture);
        for y in 0..h {
            assert!(alpha.row(y).iter().all(|&a| a == alpha[(0, y)]), "row {y}: {:?}", alpha.row(y));
        }
        assert!((90..128).contains(&alpha[(0, 19)]), "{}", alpha[(0, 19)]);
        assert_eq!((alpha[(0, 15)], alpha[(0, 24)]), (0, 255));
    }
}
