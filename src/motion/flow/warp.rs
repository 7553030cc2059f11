//! The second frame warped back onto the first, a row at a time.

use super::pyramid::Padded;

/// Bilinear warping in three loops: positions in vector code, the gather, the blend in vector code.
#[derive(Debug, Clone, Default)]
pub(super) struct WarpRow {
    start: Vec<u32>,
    fraction_x: Vec<f32>,
    fraction_y: Vec<f32>,
    corners: [Vec<f32>; 4],
    warped: Vec<f32>,
}

impl WarpRow {
    /// Row `y` of `image` displaced by `(u, v)`; `inside` becomes 1 where that lies inside the image, else 0.
    pub(super) fn row(&mut self, image: &Padded, y: usize, u: &[f32], v: &[f32], inside: &mut [f32]) -> &[f32] {
        let n = u.len();
        let Self { start, fraction_x, fraction_y, corners, warped } = self;
        start.resize(n, 0);
        for values in [&mut *fraction_x, &mut *fraction_y, &mut *warped].into_iter().chain(corners.iter_mut()) {
            values.resize(n, 0.0);
        }
        aim(image, y as f32, (u, v), start, (fraction_x, fraction_y), inside);
        let data = &image.data()[image.index(0, 0)..];
        let [a, b, c, d] = corners.each_mut().map(|corner| &mut corner[..n]);
        for (x, &start) in start.iter().enumerate() {
            let (upper, lower) = (&data[start as usize..][..2], &data[start as usize + image.stride..][..2]);
            (a[x], b[x], c[x], d[x]) = (upper[0], upper[1], lower[0], lower[1]);
        }
        blend(warped, [a, b, c, d], fraction_x, fraction_y);
        warped
    }
}

/// For each pixel of row `y`: index of the upper left of the four pixels around its target, the fractions, and whether
/// the target is inside. Targets outside are held at the border.
// Not inlined: as a function of its own, the compiler knows that the slices do not overlap.
#[inline(never)]
fn aim(
    image: &Padded,
    y: f32,
    (u, v): (&[f32], &[f32]),
    start: &mut [u32],
    (fraction_x, fraction_y): (&mut [f32], &mut [f32]),
    inside: &mut [f32],
) {
    let n = u.len();
    let (v, start, inside) = (&v[..n], &mut start[..n], &mut inside[..n]);
    let (fraction_x, fraction_y) = (&mut fraction_x[..n], &mut fraction_y[..n]);
    let (right, bottom, stride) = ((image.width - 1) as f32, (image.height - 1) as f32, image.stride as i32);
    for x in 0..n {
        let (to_x, to_y) = (x as i32 as f32 + u[x], y + v[x]);
        let (held_x, held_y) = (hold(to_x, right), hold(to_y, bottom));
        inside[x] = if (held_x == to_x) & (held_y == to_y) { 1.0 } else { 0.0 };
        let (whole_x, whole_y) = (held_x as i32, held_y as i32);
        fraction_x[x] = held_x - whole_x as f32;
        fraction_y[x] = held_y - whole_y as f32;
        start[x] = (whole_y * stride + whole_x) as u32;
    }
}

/// `position` held to `0..=last`; not-a-number becomes 0. Comparisons, because `clamp` does not become vector
/// instructions.
#[inline(always)]
fn hold(position: f32, last: f32) -> f32 {
    let held = if position > 0.0 { position } else { 0.0 };
    if held < last { held } else { last }
}

#[inline(never)]
fn blend(warped: &mut [f32], corners: [&mut [f32]; 4], fraction_x: &[f32], fraction_y: &[f32]) {
    let n = warped.len();
    let [a, b, c, d] = corners.map(|corner| &corner[..n]);
    let (fraction_x, fraction_y) = (&fraction_x[..n], &fraction_y[..n]);
    for x in 0..n {
        let above = a[x] + fraction_x[x] * (b[x] - a[x]);
        let below = c[x] + fraction_x[x] * (d[x] - c[x]);
        warped[x] = above + fraction_y[x] * (below - above);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Plane, sample_bilinear};
    use crate::rng::Rng;

    #[test]
    fn warping_agrees_with_sampling_pixel_by_pixel() {
        let mut rng = Rng::for_stage(4, "warp");
        let plane = Plane::from_fn(23, 9, |_, _| rng.range(0.0, 255.0) as f32);
        let mut image = Padded::default();
        image.resize(23, 9);
        (0..9).for_each(|y| image.row_mut(y).copy_from_slice(plane.row(y)));
        image.replicate_border();
        let (mut warp, mut inside) = (WarpRow::default(), [0.5; 23]);
        for y in 0..9 {
            let [u, v] = [0, 1].map(|_| (0..23).map(|_| rng.range(-9.0, 9.0) as f32).collect::<Vec<_>>());
            let warped = warp.row(&image, y, &u, &v, &mut inside);
            for x in 0..23 {
                let (to_x, to_y) = (x as f32 + u[x], y as f32 + v[x]);
                let expected = sample_bilinear(&plane, to_x, to_y);
                assert!((warped[x] - expected).abs() < 1e-3, "{} for {expected}", warped[x]);
                let is_inside = (0.0..=22.0).contains(&to_x) && (0.0..=8.0).contains(&to_y);
                assert_eq!(inside[x] == 1.0, is_inside, "({to_x}, {to_y})");
            }
        }
    }
}
