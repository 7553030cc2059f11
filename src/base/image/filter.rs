//! Separable Gaussian blur and bilinear sampling, borders replicated.

use super::Plane;

/// Blurs `plane` by a Gaussian of standard deviation `sigma` in pixels, cut off at 3 `sigma`; `sigma <= 0` copies.
///
/// Borders are replicated. Separable: O(pixels · sigma).
pub fn gaussian_blur(plane: &Plane<f32>, sigma: f32) -> Plane<f32> {
    if sigma <= 0.0 || plane.data().is_empty() {
        return plane.clone();
    }
    let kernel = gaussian_kernel(sigma);
    let (radius, width) = (kernel.len() - 1, plane.width());
    let mut row_blurred = Plane::filled(width, plane.height(), 0.0);
    let mut padded = Vec::new();
    for y in 0..plane.height() {
        pad_row(plane.row(y), radius, &mut padded);
        convolve_symmetric(row_blurred.row_mut(y), &kernel, |k| &padded[(radius as isize + k) as usize..][..width]);
    }
    let mut blurred = Plane::filled(width, plane.height(), 0.0);
    let last = plane.height() as isize - 1;
    for y in 0..plane.height() {
        convolve_symmetric(blurred.row_mut(y), &kernel, |k| row_blurred.row((y as isize + k).clamp(0, last) as usize));
    }
    blurred
}

/// Returns weights at `0..=r`, `r = ceil(3 sigma)`, whose sum over `-r..=r` is 1.
fn gaussian_kernel(sigma: f32) -> Vec<f32> {
    let radius = (3.0 * sigma).ceil() as i32;
    let weights: Vec<f32> = (0..=radius).map(|k| libm::expf(-0.5 * (k as f32 / sigma).powi(2))).collect();
    let total = weights[0] + 2.0 * weights[1..].iter().sum::<f32>();
    weights.iter().map(|w| w / total).collect()
}

fn pad_row(row: &[f32], radius: usize, padded: &mut Vec<f32>) {
    padded.clear();
    padded.extend(std::iter::repeat_n(row[0], radius));
    padded.extend_from_slice(row);
    padded.extend(std::iter::repeat_n(row[row.len() - 1], radius));
}

/// Computes `out = Σ_k kernel[|k|] slice(k)`. Takes up to nine slices at a time, so that `out` is seldom loaded and stored; the
/// order of the sum does not depend on that.
pub(crate) fn convolve_symmetric<'a>(out: &mut [f32], kernel: &[f32], slice: impl Fn(isize) -> &'a [f32]) {
    let centre = slice(0);
    let pairs = |k: isize| [slice(-k), slice(k), slice(-k - 1), slice(k + 1)];
    let mut k = match *kernel {
        [u, v, w, x, y, ..] => {
            set_to_nine(out, centre, [pairs(1), pairs(3)], [u, v, w, x, y]);
            5
        }
        [u, v, w, ..] => {
            set_to_five(out, centre, pairs(1), [u, v, w]);
            3
        }
        _ => {
            out.iter_mut().zip(centre).for_each(|(o, s)| *o = kernel[0] * s);
            1
        }
    };
    let (twos, rest) = kernel[k as usize..].as_chunks::<2>();
    for &[v, w] in twos {
        add_two_pairs(out, pairs(k), v, w);
        k += 2;
    }
    for &w in rest {
        for ((o, a), b) in out.iter_mut().zip(slice(-k)).zip(slice(k)) {
            *o += w * (a + b);
        }
    }
}

// Not inlined: separate arguments tell the compiler that the slices do not overlap.
#[inline(never)]
fn set_to_nine(out: &mut [f32], centre: &[f32], pairs: [[&[f32]; 4]; 2], [u, v, w, x, y]: [f32; 5]) {
    let n = out.len();
    let (s, [near, far]) = (&centre[..n], pairs);
    let ([a, b, c, d], [e, f, g, h]) = (near.map(|slice| &slice[..n]), far.map(|slice| &slice[..n]));
    for i in 0..n {
        let sum = u * s[i] + (v * (a[i] + b[i]) + w * (c[i] + d[i]));
        out[i] = sum + (x * (e[i] + f[i]) + y * (g[i] + h[i]));
    }
}

#[inline(never)]
fn set_to_five(out: &mut [f32], centre: &[f32], pairs: [&[f32]; 4], [u, v, w]: [f32; 3]) {
    let n = out.len();
    let (s, [a, b, c, d]) = (&centre[..n], pairs.map(|slice| &slice[..n]));
    for i in 0..n {
        out[i] = u * s[i] + (v * (a[i] + b[i]) + w * (c[i] + d[i]));
    }
}

#[inline(never)]
fn add_two_pairs(out: &mut [f32], pairs: [&[f32]; 4], v: f32, w: f32) {
    let n = out.len();
    let [a, b, c, d] = pairs.map(|slice| &slice[..n]);
    for i in 0..n {
        out[i] += v * (a[i] + b[i]) + w * (c[i] + d[i]);
    }
}

/// Interpolates `plane` bilinearly at `(x, y)`; coordinates outside are clamped to the border.
pub fn sample_bilinear(plane: &Plane<f32>, x: f32, y: f32) -> f32 {
    BilinearPoint::new(plane.width(), plane.height(), x, y).sample(plane)
}

/// A position between pixels, to sample several planes of one size.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BilinearPoint {
    /// Index of the upper left pixel.
    first: usize,
    /// Offset to the pixel on its right; 0 on the border.
    right: usize,
    /// Offset to the pixel below; 0 on the border.
    below: usize,
    fraction_x: f32,
    fraction_y: f32,
}

impl BilinearPoint {
    /// Locates `(x, y)` in planes of a size; coordinates outside are clamped to the border.
    pub(crate) fn new(width: usize, height: usize, x: f32, y: f32) -> Self {
        Self::between(width, BilinearAxis::new(x, width), BilinearAxis::new(y, height))
    }

    /// Combines a position across and one down planes of this width.
    pub(crate) fn between(width: usize, x: BilinearAxis, y: BilinearAxis) -> Self {
        let first = y.pixel * width + x.pixel;
        Self { first, right: x.next, below: y.next * width, fraction_x: x.fraction, fraction_y: y.fraction }
    }

    /// Returns the interpolated value.
    #[inline]
    pub(crate) fn sample(&self, plane: &Plane<f32>) -> f32 {
        self.sample_as(plane, |value| value)
    }

    /// Returns the interpolated value of a plane of other numbers.
    #[inline]
    pub(crate) fn sample_as<T: Copy>(&self, plane: &Plane<T>, convert: impl Fn(T) -> f32) -> f32 {
        let Self { first, right, below, fraction_x, fraction_y } = *self;
        let (top, bottom) = (&plane.data()[first..], &plane.data()[first + below..]);
        let [a, b, c, d] = [top[0], top[right], bottom[0], bottom[right]].map(convert);
        let (above, below) = (a + fraction_x * (b - a), c + fraction_x * (d - c));
        above + fraction_y * (below - above)
    }
}

/// A position along one axis: a pixel, the offset to the next (0 on the border), and the fraction between them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BilinearAxis {
    pixel: usize,
    next: usize,
    fraction: f32,
}

impl BilinearAxis {
    /// Locates a position among `length` pixels.
    pub(crate) fn new(position: f32, length: usize) -> Self {
        let clamped = position.clamp(0.0, (length - 1) as f32);
        let pixel = clamped.floor();
        Self { pixel: pixel as usize, next: usize::from(pixel as usize + 1 < length), fraction: clamped - pixel }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blur_keeps_constants_and_total_mass() {
        let flat = Plane::filled(9, 7, 3.0);
        assert!(gaussian_blur(&flat, 1.3).data().iter().all(|v| (v - 3.0).abs() < 1e-5));
        let mut dot = Plane::filled(31, 31, 0.0);
        dot[(15, 15)] = 1.0;
        let blurred = gaussian_blur(&dot, 2.0);
        assert!((blurred.data().iter().sum::<f32>() - 1.0).abs() < 1e-4);
        let peak = 1.0 / (2.0 * std::f32::consts::PI * 4.0);
        assert!((blurred[(15, 15)] - peak).abs() < 0.02 * peak, "peak {}", blurred[(15, 15)]);
    }

    #[test]
    fn bilinear_reproduces_a_ramp_and_clamps() {
        let ramp = Plane::from_fn(5, 4, |x, y| 2.0 * x as f32 - y as f32);
        assert!((sample_bilinear(&ramp, 1.25, 2.5) - 0.0).abs() < 1e-6);
        assert_eq!(sample_bilinear(&ramp, -9.0, -9.0), 0.0);
        assert_eq!(sample_bilinear(&ramp, 99.0, 99.0), 5.0);
        assert_eq!(sample_bilinear(&Plane::filled(1, 1, 4.0), 0.3, 0.9), 4.0);
    }
}
