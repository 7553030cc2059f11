//! Separable Gaussian blur with mirrored borders, the same bits on every machine.

/// Weights at `0..=r`, `r = ceil(3 sigma)`, such that those at `-r..=r` sum to one; `[1]` for `sigma <= 0`.
pub(super) fn half_kernel(sigma: f32) -> Vec<f32> {
    if sigma <= 0.0 {
        return vec![1.0];
    }
    let radius = libm::ceilf(3.0 * sigma) as usize;
    let weights: Vec<f32> = (0..=radius)
        .map(|k| {
            let z = k as f32 / sigma;
            libm::expf(-0.5 * z * z)
        })
        .collect();
    let total = weights[0] + 2.0 * weights[1..].iter().sum::<f32>();
    weights.iter().map(|w| w / total).collect()
}

/// The index in `0..n` that mirrored borders put at `i`: `-1` is `0`, `n` is `n - 1`.
pub(super) fn mirror(i: isize, n: usize) -> usize {
    let period = 2 * n as isize;
    let wrapped = i.rem_euclid(period);
    wrapped.min(period - 1 - wrapped) as usize
}

/// Blurs images of one size in place.
#[derive(Debug)]
pub(super) struct Blur {
    kernel: Vec<f32>,
    padded: Vec<f32>,
    across: Vec<f32>,
}

impl Blur {
    pub(super) fn new(sigma: f32) -> Self {
        Self { kernel: half_kernel(sigma), padded: Vec::new(), across: Vec::new() }
    }

    /// `image` holds rows of `width` values.
    pub(super) fn apply(&mut self, image: &mut [f32], width: usize) {
        let radius = self.kernel.len() - 1;
        let height = image.len() / width;
        if radius == 0 {
            return;
        }
        self.across.resize(image.len(), 0.0);
        for (row, out) in image.chunks_exact(width).zip(self.across.chunks_exact_mut(width)) {
            pad(row, radius, &mut self.padded);
            weigh(out, &self.padded[radius..], self.kernel[0]);
            for (k, &w) in self.kernel.iter().enumerate().skip(1) {
                add_pair(out, &self.padded[radius - k..], &self.padded[radius + k..], w);
            }
        }
        for (y, out) in image.chunks_exact_mut(width).enumerate() {
            let row = |y: isize| {
                let y = mirror(y, height);
                &self.across[y * width..(y + 1) * width]
            };
            let y = y as isize;
            weigh(out, row(y), self.kernel[0]);
            for (k, &w) in self.kernel.iter().enumerate().skip(1) {
                add_pair(out, row(y - k as isize), row(y + k as isize), w);
            }
        }
    }
}

fn pad(row: &[f32], radius: usize, padded: &mut Vec<f32>) {
    padded.clear();
    let n = row.len();
    padded.extend((0..radius).map(|k| row[mirror(k as isize - radius as isize, n)]));
    padded.extend_from_slice(row);
    padded.extend((0..radius).map(|k| row[mirror((n + k) as isize, n)]));
}

fn weigh(out: &mut [f32], source: &[f32], w: f32) {
    for (o, s) in out.iter_mut().zip(source) {
        *o = w * s;
    }
}

fn add_pair(out: &mut [f32], a: &[f32], b: &[f32], w: f32) {
    for ((o, a), b) in out.iter_mut().zip(a).zip(b) {
        *o += w * (a + b);
    }
}
