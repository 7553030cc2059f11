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
use crate::image::{Picture, Plane};
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
pub(super) fn opacity<const CHANNELS: usize>(inside: &Plane<bool>, picture: Picture<'_, CHANNELS>) -> Plane<u8> {
    let (w, h) = (inside.width(), inside.height());
    let mut alpha = inside.map(|is_inside| if is_inside { 255 } else { 0 });
    let radius = (w.max(h) / SIDE_IN_RADII).clamp(RADIUS_IN_MIXED_BANDS, MAX_RADIUS_PX);
    let tile = TILE_IN_RADII * radius;
    let widened = |start: usize, end: usize| start.saturating_sub(radius)..(start + tile + radius).min(end);
    for top in (0..h).step_by(tile) {
        for left in (0..w).step_by(tile) {
            let Some(border) = border_box(inside, widened(left, w), widened(top, h)) else { continue };
            // Only pixels within the reach of a window change.
            let clip = |border: &Range<usize>, start: usize, end: usize| {
                start.max(border.start.saturating_sub(radius))..(start + tile).min(border.end + radius).min(end)
            };
            let (columns, rows) = (clip(&border.0, left, w), clip(&border.1, top, h));
            Patch::new(inside, picture, radius, &columns, &rows).set_opacity(&mut alpha);
        }
    }
    alpha
}

/// Numbers of a pixel, or their sums over a window: whether it is inside; whether it is pure, that is, its colour is not mixed; both;
/// red, green and blue of pure ones; the same of pure ones inside; products of two channels of pure ones.
type Moments = [u32; NUM_MOMENTS];
const NUM_MOMENTS: usize = PRODUCTS + CHANNEL_PAIRS.len();
const INSIDE: usize = 0;
const PURE: usize = 1;
const PURE_INSIDE: usize = 2;
const COLOURS: usize = 3;
const INNER_COLOURS: usize = 6;
const PRODUCTS: usize = 9;

/// The channels of the entries in the upper triangle of a covariance matrix, in the order of the products.
const CHANNEL_PAIRS: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

/// The opacity as a linear function of colour: a (three channels), D² times the opacity of black, and D²; all zero without colours
/// of both sides.
type Fit = [f64; 5];

/// The windows of a rectangle.
struct Fits {
    /// The columns in each row whose windows lie on both sides of a border, and perhaps some between.
    mixed: Vec<Range<usize>>,
    /// The pixels inside of each window that lies on both sides, else 0.
    num_inside: Vec<u32>,
    /// Of each window; zero if it lies on one side.
    fits: Vec<Fit>,
}

/// A rectangle of the picture whose opacity is computed, with the reach of its windows: a rectangle within another within a third.
struct Patch {
    radius: usize,
    /// The position of the largest rectangle in the picture.
    place: (usize, usize),
    width: usize,
    height: usize,
    colours: Vec<[u8; 3]>,
    /// The moments before the products, each as a plane.
    planes: [Vec<u8>; PRODUCTS],
    /// The pixels of the smallest rectangle, in the largest.
    columns: Range<usize>,
    rows: Range<usize>,
}

impl Patch {
    fn new<const CHANNELS: usize>(
        inside: &Plane<bool>,
        picture: Picture<'_, CHANNELS>,
        radius: usize,
        columns: &Range<usize>,
        rows: &Range<usize>,
    ) -> Self {
        let place = (columns.start.saturating_sub(2 * radius), rows.start.saturating_sub(2 * radius));
        let width = (columns.end + 2 * radius).min(inside.width()) - place.0;
        let height = (rows.end + 2 * radius).min(inside.height()) - place.1;
        let (mut is_inside, mut colours) = (Vec::with_capacity(width * height), Vec::with_capacity(width * height));
        for y in place.1..place.1 + height {
            is_inside.extend(inside.row(y)[place.0..place.0 + width].iter().map(|&is_inside| u8::from(is_inside)));
            colours.extend(picture.row(y, place.0..place.0 + width).iter().map(|rgb| [rgb[0], rgb[1], rgb[2]]));
        }
        let pure = find_pure(&is_inside, width, radius / RADIUS_IN_MIXED_BANDS);
        let inner = product(&pure, &is_inside);
        let [red, green, blue] =
            std::array::from_fn(|c| colours.iter().zip(&pure).map(|(rgb, pure)| rgb[c] * pure).collect());
        let inner_colours = [&red, &green, &blue].map(|channel: &Vec<u8>| product(channel, &inner));
        let [inner_red, inner_green, inner_blue] = inner_colours;
        Self {
            radius,
            place,
            width,
            height,
            colours,
            planes: [is_inside, pure, inner, red, green, blue, inner_red, inner_green, inner_blue],
            columns: columns.start - place.0..columns.end - place.0,
            rows: rows.start - place.1..rows.end - place.1,
        }
    }

    /// Steps 1 to 4 in the smallest rectangle.
    fn set_opacity(&self, alpha: &mut Plane<u8>) {
        // A window around a pixel of the smallest rectangle has pixels of the next one.
        let widened =
            |range: &Range<usize>, end| range.start.saturating_sub(self.radius)..(range.end + self.radius).min(end);
        let (columns, rows) = (widened(&self.columns, self.width), widened(&self.rows, self.height));
        let fits = self.fits(columns.clone(), rows.clone());
        let (left, width) = (columns.start, columns.len());
        let mut lines = vec![[0.0; 5]; width];
        let target = self.rows.start - rows.start..self.rows.end - rows.start;
        let row = |v: usize| fits.mixed[v].clone().zip(&fits.fits[v * width..][fits.mixed[v].clone()]);
        let add_row = |lines: &mut Vec<Fit>, v: usize| row(v).for_each(|(u, fit)| add(&mut lines[u], fit));
        let subtract_row = |lines: &mut Vec<Fit>, v: usize| row(v).for_each(|(u, fit)| subtract(&mut lines[u], fit));
        slide(self.radius, target, rows.len(), &mut lines, add_row, subtract_row, |lines, v| {
            let (mixed, y) = (&fits.mixed[v], rows.start + v);
            let columns = mixed.start.max(self.columns.start - left)..mixed.end.min(self.columns.end - left);
            for_row_sums(lines, self.radius, columns, |u, fit| {
                let (x, num_inside) = (left + u, fits.num_inside[v * width + u]);
                if num_inside > 0 {
                    let p = y * self.width + x;
                    let count = self.window_size(x, y);
                    let opacity = blend(self.colours[p], self.planes[INSIDE][p], fit, count, num_inside);
                    alpha[(self.place.0 + x, self.place.1 + y)] = opacity;
                }
            });
        });
    }

    /// Steps 1 and 2 for the pixels of a rectangle.
    fn fits(&self, columns: Range<usize>, rows: Range<usize>) -> Fits {
        let (left, width) = (columns.start, columns.len());
        let mut fits = vec![[0.0; 5]; width * rows.len()];
        let mut num_inside = vec![0; width * rows.len()];
        let mut all_mixed = Vec::with_capacity(rows.len());
        // Sums over the rows of a window, of all columns, one moment after the other.
        let mut lines = vec![0_u32; NUM_MOMENTS * self.width];
        let mut moments: Vec<Moments> = vec![[0; NUM_MOMENTS]; self.width];
        let add_row = |lines: &mut Vec<u32>, y| self.for_row_moments(lines, y, |sum, value| *sum += value);
        let subtract_row = |lines: &mut Vec<u32>, y| self.for_row_moments(lines, y, |sum, value| *sum -= value);
        slide(self.radius, rows.clone(), self.height, &mut lines, add_row, subtract_row, |lines, y| {
            let at = (y - rows.start) * width;
            let mut mixed = self.width..self.width;
            let insides = lines[..self.width].as_chunks::<1>().0;
            for_row_sums(insides, self.radius, columns.clone(), |x, &[inside]| {
                if inside > 0 && inside < self.window_size(x, y) {
                    num_inside[at + x - left] = inside;
                    mixed = mixed.start.min(x)..x + 1;
                }
            });
            if mixed.is_empty() {
                all_mixed.push(0..0);
                return;
            }
            let reach = mixed.start.saturating_sub(self.radius)..(mixed.end + self.radius).min(self.width);
            for (k, line) in lines.chunks_exact(self.width).enumerate() {
                let sums = moments[reach.clone()].iter_mut().zip(&line[reach.clone()]);
                sums.for_each(|(moments, &sum)| moments[k] = sum);
            }
            all_mixed.push(mixed.start - left..mixed.end - left);
            for_row_sums(&moments, self.radius, mixed, |x, sums| fits[at + x - left] = fit(sums));
        });
        Fits { mixed: all_mixed, num_inside, fits }
    }

    /// Calls `f` with each number of `lines`, and the moment of the pixel of row `y` that belongs to it.
    fn for_row_moments(&self, lines: &mut [u32], y: usize, f: impl Fn(&mut u32, u32)) {
        let row = |k: usize| &self.planes[k][y * self.width..][..self.width];
        let (lines, products) = lines.split_at_mut(PRODUCTS * self.width);
        for (k, line) in lines.chunks_exact_mut(self.width).enumerate() {
            line.iter_mut().zip(row(k)).for_each(|(sum, &value)| f(sum, u32::from(value)));
        }
        for ((c, d), line) in CHANNEL_PAIRS.iter().zip(products.chunks_exact_mut(self.width)) {
            let channels = row(COLOURS + c).iter().zip(row(COLOURS + d));
            line.iter_mut().zip(channels).for_each(|(sum, (&a, &b))| f(sum, u32::from(u16::from(a) * u16::from(b))));
        }
    }

    /// Returns the pixels of the window around a pixel.
    fn window_size(&self, x: usize, y: usize) -> u32 {
        let length = |at: usize, end: usize| (at + self.radius + 1).min(end) - at.saturating_sub(self.radius);
        (length(x, self.width) * length(y, self.height)) as u32
    }
}

fn product(a: &[u8], b: &[u8]) -> Vec<u8> {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}

/// Returns 1 for each pixel whose window of this radius lies on one side of the border, and else 0.
fn find_pure(inside: &[u8], width: usize, radius: usize) -> Vec<u8> {
    let height = inside.len() / width;
    let mut pure = Vec::with_capacity(inside.len());
    // The pixels inside of each column of the window, and all.
    let mut lines = vec![[0_u8; 2]; width];
    let row = |y: usize| inside[y * width..][..width].iter().map(|&inside| [inside, 1]);
    let add_row =
        |lines: &mut Vec<[u8; 2]>, y: usize| lines.iter_mut().zip(row(y)).for_each(|(line, pixel)| add(line, &pixel));
    let subtract_row = |lines: &mut Vec<[u8; 2]>, y: usize| {
        lines.iter_mut().zip(row(y)).for_each(|(line, pixel)| subtract(line, &pixel));
    };
    slide(radius, 0..height, height, &mut lines, add_row, subtract_row, |lines, _| {
        for_row_sums(lines, radius, 0..width, |_, &[inside, all]| pure.push(u8::from(inside == 0 || inside == all)));
    });
    pure
}

/// Steps 1 and 2 for a window.
fn fit(sums: &Moments) -> Fit {
    let (total, inner) = (sums[PURE], sums[PURE_INSIDE]);
    if inner == 0 || inner == total {
        return [0.0; 5];
    }
    let (count, inner) = (f64::from(total), f64::from(inner));
    let outer = count - inner;
    let f: [f64; 3] = std::array::from_fn(|c| f64::from(sums[INNER_COLOURS + c]) / inner);
    let b: [f64; 3] = std::array::from_fn(|c| f64::from(sums[COLOURS + c] - sums[INNER_COLOURS + c]) / outer);
    let covariance: [f64; 6] = std::array::from_fn(|k| {
        let (c, d) = CHANNEL_PAIRS[k];
        (f64::from(sums[PRODUCTS + k]) - inner * f[c] * f[d] - outer * b[c] * b[d]) / count
    });
    let difference: [f64; 3] = std::array::from_fn(|c| f[c] - b[c]);
    let a = solve_regularized(covariance, difference);
    let dot = |v: [f64; 3]| (0..3).map(|c| a[c] * v[c]).sum::<f64>();
    let weight = dot(difference);
    [a[0], a[1], a[2], 0.5 * (weight - dot(f) - dot(b)), weight]
}

/// Steps 3 and 4 for a pixel.
///
/// * `fit`: the sum over all windows that contain the pixel.
/// * `count`, `num_inside`: the pixels of its own window, and those of them that are inside.
fn blend(colour: [u8; 3], inside: u8, fit: &Fit, count: u32, num_inside: u32) -> u8 {
    let (mask, weight) = (f64::from(inside), fit[4]);
    if weight == 0.0 {
        return 255 * inside;
    }
    let opacity = fit[3] + (0..3).map(|c| fit[c] * f64::from(colour[c])).sum::<f64>();
    let nearness = 1.0 - (2.0 * f64::from(num_inside) / f64::from(count) - 1.0).abs();
    let trust = weight / f64::from(count) * nearness * nearness;
    let blended = mask + ((opacity / weight).clamp(0.0, 1.0) - mask) * trust / (trust + HALF_WEIGHT_D_SQ);
    let value = (255.0 * blended + 0.5) as u8;
    if inside == 1 { value.max(128) } else { value.min(127) }
}

/// Calls `take` for each of the rows, after `add` for each row that enters the window of this radius around it, and `subtract` for
/// the one that leaves it.
fn slide<S>(
    radius: usize,
    rows: Range<usize>,
    height: usize,
    sums: &mut S,
    add: impl Fn(&mut S, usize),
    subtract: impl Fn(&mut S, usize),
    mut take: impl FnMut(&mut S, usize),
) {
    (rows.start.saturating_sub(radius)..(rows.start + radius).min(height)).for_each(|y| add(sums, y));
    for y in rows.clone() {
        if y + radius < height {
            add(sums, y + radius);
        }
        if y > rows.start && y > radius {
            subtract(sums, y - radius - 1);
        }
        take(sums, y);
    }
}

/// Calls `take` with the sum over the window of this radius around each of the columns.
fn for_row_sums<T: Copy + Default + AddAssign + SubAssign, const N: usize>(
    row: &[[T; N]],
    radius: usize,
    columns: Range<usize>,
    mut take: impl FnMut(usize, &[T; N]),
) {
    let mut sum = [T::default(); N];
    row[columns.start.saturating_sub(radius)..(columns.start + radius).min(row.len())]
        .iter()
        .for_each(|v| add(&mut sum, v));
    for x in columns.clone() {
        if let Some(next) = row.get(x + radius) {
            add(&mut sum, next);
        }
        if x > columns.start && x > radius {
            subtract(&mut sum, &row[x - radius - 1]);
        }
        take(x, &sum);
    }
}

fn add<T: Copy + AddAssign, const N: usize>(sums: &mut [T; N], values: &[T; N]) {
    sums.iter_mut().zip(values).for_each(|(sum, &value)| *sum += value);
}

fn subtract<T: Copy + SubAssign, const N: usize>(sums: &mut [T; N], values: &[T; N]) {
    sums.iter_mut().zip(values).for_each(|(sum, &value)| *sum -= value);
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
    use crate::image::Frame;
    use crate::rng::Rng;

    #[test]
    fn sums_are_those_of_each_window() {
        let mut rng = Rng::for_stage(1, "alpha");
        for (w, h, radius) in [(9_usize, 7_usize, 2), (5, 8, 0), (3, 4, 6), (1, 1, 1), (20, 3, 3)] {
            let values: Vec<[u32; 1]> = (0..w * h).map(|_| [rng.below(100) as u32]).collect();
            let row = |y: usize| &values[y * w..][..w];
            let add_row = |sums: &mut Vec<[u32; 1]>, y| sums.iter_mut().zip(row(y)).for_each(|(sum, v)| add(sum, v));
            let subtract_row =
                |sums: &mut Vec<[u32; 1]>, y| sums.iter_mut().zip(row(y)).for_each(|(sum, v)| subtract(sum, v));
            for (columns, rows) in [(0..w, 0..h), (w / 3..w, h / 2..h), (0..w.div_ceil(2), h / 3..h / 3 + 1)] {
                let mut pixels = Vec::new();
                slide(radius, rows.clone(), h, &mut vec![[0]; w], add_row, subtract_row, |sums, y| {
                    for_row_sums(sums, radius, columns.clone(), |x, &[sum]| {
                        let is_near = |p: &usize| (p % w).abs_diff(x) <= radius && (p / w).abs_diff(y) <= radius;
                        let slow: u32 = (0..w * h).filter(is_near).map(|p| values[p][0]).sum();
                        assert_eq!(sum, slow, "at {x}, {y}, radius {radius}");
                        pixels.push((x, y));
                    });
                });
                assert_eq!(pixels, rows.flat_map(|y| columns.clone().map(move |x| (x, y))).collect::<Vec<_>>());
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
        let alpha = opacity(&Plane::from_fn(w, h, |_, y| y >= 20), picture.picture());
        for y in 0..h {
            assert!(alpha.row(y).iter().all(|&a| a == alpha[(0, y)]), "row {y}: {:?}", alpha.row(y));
        }
        assert!((90..128).contains(&alpha[(0, 19)]), "{}", alpha[(0, 19)]);
        assert_eq!((alpha[(0, 15)], alpha[(0, 24)]), (0, 255));
    }
}
