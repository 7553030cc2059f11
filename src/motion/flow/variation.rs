//! Local flow variation: the standard deviation of the flow around each pixel (Ochs, Malik and Brox, PAMI 2014).
//!
//! In: one flow field. Out: σ in pixels per frame at half the resolution. Affinities divide velocity differences by σ, so
//! that a surface whose flow changes smoothly (zoom, rotation, perspective) is not split, while σ stays small on both sides
//! of a sharp motion boundary, which the averaging does not cross.
//!
//! 1. Halve `u`, `v`, `u²`, `v²`.
//! 2. Diffuse all four with the diffusivity `g = 1 / sqrt(|∇u|² + |∇v|² + ε²)`, computed once, by additive operator
//!    splitting (Weickert, ter Haar Romeny and Viergever 1998), which is stable for any time step.
//! 3. `σ = sqrt(⟨u²⟩ − ⟨u⟩² + ⟨v²⟩ − ⟨v⟩²)`.
//!
//! **Deviation** from the published tool: a few large time steps instead of twenty small ones, with the same total time.
//! **Cost**: O(pixels), six half-size planes. **Limits**: σ is larger at blurred motion boundaries, which lowers the
//! differences there.

use super::field::FlowField;
use crate::image::Plane;
use wide::f32x4;

/// Total diffusion time, in half-resolution pixels squared per unit of diffusivity (the published tool: 20 steps of
/// 0.5).
const TOTAL_TIME: f32 = 10.0;
/// Number of implicit steps; fewer are cheaper and spread a little less evenly. Chosen by eye.
const NUM_STEPS: usize = 4;
/// Keeps the diffusivity finite where the flow is constant, in pixels per frame per pixel (published tool).
const EPSILON: f32 = 0.001;

/// Computes σ at half resolution, `ceil(w / 2) × ceil(h / 2)`, in pixels per frame, finite and not negative.
///
/// # Examples
/// A translation does not vary; a stretching flow does.
///
/// ```
/// use tracecut::flow::{FlowField, local_flow_variation};
/// use tracecut::image::Plane;
///
/// let v = Plane::filled(8, 8, 0.0);
/// let translation = local_flow_variation(&FlowField { u: Plane::filled(8, 8, 3.0), v: v.clone() });
/// let stretching = local_flow_variation(&FlowField { u: Plane::from_fn(8, 8, |x, _| 0.1 * x as f32), v });
/// assert_eq!((translation.width(), translation.height()), (4, 4));
/// assert!(translation.data().iter().all(|&sigma| sigma < 1e-3));
/// assert!(stretching[(2, 2)] > 0.05);
/// ```
#[must_use]
pub fn local_flow_variation(flow: &FlowField) -> Plane<f32> {
    // Without the mean the squares stay small, and their difference below keeps its digits in f32.
    let flow = &FlowField { u: subtract_mean(&flow.u), v: subtract_mean(&flow.v) };
    let (u, v) = (halved(&flow.u), halved(&flow.v));
    let (across, down) = edge_weights(&u, &v);
    let energy = halved_energy(flow);
    // u, v and the sum of their squares side by side: one map of squares suffices, as σ adds both variances.
    let values = u.data().iter().zip(v.data()).zip(energy.data());
    let mut map: Vec<f32x4> = values.map(|((&u, &v), &e)| f32x4::new([u, v, e, 0.0])).collect();
    let mut systems = Systems::new(&across, &down, TOTAL_TIME / NUM_STEPS as f32);
    for _ in 0..NUM_STEPS {
        systems.step(&mut map);
    }
    let variance = map.iter().map(|v| {
        let [u, v, energy, _] = v.to_array();
        (energy - u * u - v * v).max(0.0).sqrt()
    });
    Plane::from_vec(u.width(), u.height(), variance.collect()).unwrap_or_default()
}

fn subtract_mean(plane: &Plane<f32>) -> Plane<f32> {
    let mean = plane.data().iter().map(|&v| f64::from(v)).sum::<f64>() / plane.data().len().max(1) as f64;
    plane.map(|v| v - mean as f32)
}

fn halved(plane: &Plane<f32>) -> Plane<f32> {
    halved_by(plane.width(), plane.height(), |p| plane.data()[p])
}

fn halved_energy(flow: &FlowField) -> Plane<f32> {
    let (u, v) = (flow.u.data(), flow.v.data());
    halved_by(flow.u.width(), flow.u.height(), |p| u[p] * u[p] + v[p] * v[p])
}

/// Computes means of 2×2 blocks of `value(p)`, pixels in a row; an odd last row or column counts twice.
fn halved_by(width: usize, height: usize, value: impl Fn(usize) -> f32) -> Plane<f32> {
    let mut halved = Vec::with_capacity(width.div_ceil(2) * height.div_ceil(2));
    for y in (0..height).step_by(2) {
        let (top, bottom) = (y * width, (y + 1).min(height - 1) * width);
        halved.extend((0..width).step_by(2).map(|x| {
            let right = (x + 1).min(width - 1);
            0.25 * (value(top + x) + value(top + right) + value(bottom + x) + value(bottom + right))
        }));
    }
    Plane::from_vec(width.div_ceil(2), height.div_ceil(2), halved).unwrap_or_default()
}

/// Computes the diffusivities between each pixel and its right and lower neighbour; zero across the frame border.
fn edge_weights(u: &Plane<f32>, v: &Plane<f32>) -> (Plane<f32>, Plane<f32>) {
    let (w, h) = (u.width(), u.height());
    let mut g = Plane::filled(w, h, 0.0);
    for y in 0..h {
        let below = (y + 1).min(h - 1);
        let ([u, u_below], [v, v_below]) = ([y, below].map(|y| u.row(y)), [y, below].map(|y| v.row(y)));
        for (x, g) in g.row_mut(y).iter_mut().enumerate() {
            let right = (x + 1).min(w - 1);
            let square = |row: &[f32], below: &[f32]| (row[right] - row[x]).powi(2) + (below[x] - row[x]).powi(2);
            let gradient = square(u, u_below) + square(v, v_below);
            *g = 1.0 / (gradient + EPSILON * EPSILON).sqrt();
        }
    }
    // g(x, y) is computed from the differences across these two edges; averaging with the neighbour's g would leak.
    let (mut across, mut down) = (g.clone(), g);
    (0..h).for_each(|y| across.row_mut(y)[w.saturating_sub(1)..].fill(0.0));
    down.data_mut()[h.saturating_sub(1) * w..].fill(0.0);
    (across, down)
}

/// The tridiagonal systems `(1 + 2τ L) z = x` along all rows and all columns, factored once by Thomas's algorithm, for maps of
/// four values a pixel.
///
/// For a line with edge weights `a_k` (edge between `k` and `k + 1`), off-diagonals are `−2τ a_k`; `pivot_k` is the
/// inverse of the eliminated diagonal and `ratio_k = 2τ a_k · pivot_k`.
struct Systems {
    rows: Plane<Factor>,
    columns: Plane<Factor>,
    along_rows: Vec<f32x4>,
    along_columns: Vec<f32x4>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Factor {
    /// Previous off-diagonal, without its sign.
    edge: f32,
    pivot: f32,
    ratio: f32,
}

impl Factor {
    /// Returns the factor after `self` in its line, with `edge = 2τ a_{k-1}` and `next_edge = 2τ a_k`.
    fn next(self, next_edge: f32, edge: f32) -> Self {
        let pivot = 1.0 / (1.0 + edge + next_edge - edge * self.ratio);
        Self { edge, pivot, ratio: next_edge * pivot }
    }
}

impl Systems {
    fn new(across: &Plane<f32>, down: &Plane<f32>, tau: f32) -> Self {
        let (w, h) = (across.width(), across.height());
        let blank = Plane::filled(w, h, Factor::default());
        let (mut rows, mut columns) = (blank.clone(), blank);
        for y in 0..h {
            let (mut factor, mut edge) = (Factor::default(), 0.0);
            for x in 0..w {
                let next_edge = 2.0 * tau * across[(x, y)];
                factor = factor.next(next_edge, edge);
                rows[(x, y)] = factor;
                edge = next_edge;
            }
        }
        for y in 0..h {
            for x in 0..w {
                let (previous, edge) = match y {
                    0 => (Factor::default(), 0.0),
                    _ => (columns[(x, y - 1)], 2.0 * tau * down[(x, y - 1)]),
                };
                columns[(x, y)] = previous.next(2.0 * tau * down[(x, y)], edge);
            }
        }
        let zeros = vec![f32x4::ZERO; w * h];
        Self { rows, columns, along_rows: zeros.clone(), along_columns: zeros }
    }

    /// Makes one step: the mean of the implicit solutions along rows and along columns.
    fn step(&mut self, map: &mut [f32x4]) {
        let (w, h) = (self.rows.width(), self.rows.height());
        let Self { rows, columns, along_rows, along_columns } = self;
        let (fours, rest) = (h / 4 * 4, h % 4);
        for y in (0..fours).step_by(4) {
            solve_rows::<4>(&rows.data()[y * w..], &map[y * w..], &mut along_rows[y * w..], w);
        }
        for y in fours..fours + rest {
            solve_rows::<1>(&rows.data()[y * w..], &map[y * w..], &mut along_rows[y * w..], w);
        }
        // All columns together, row after row, so that memory is read in order.
        for y in 0..h {
            let (solved, rest) = along_columns.split_at_mut(y * w);
            let (factors, source) = (columns.row(y), &map[y * w..][..w]);
            let above = if y > 0 { &solved[(y - 1) * w..] } else { source };
            for (((out, &source), &above), f) in rest.iter_mut().zip(source).zip(above).zip(factors) {
                // The first row has no previous edge.
                *out = (source + f32x4::splat(f.edge) * above) * f32x4::splat(f.pivot);
            }
        }
        for y in (0..h.saturating_sub(1)).rev() {
            let (upper, lower) = along_columns.split_at_mut((y + 1) * w);
            for ((out, &below), f) in upper[y * w..].iter_mut().zip(&lower[..w]).zip(columns.row(y)) {
                *out += f32x4::splat(f.ratio) * below;
            }
        }
        for (value, (&a, &b)) in map.iter_mut().zip(along_rows.iter().zip(&*along_columns)) {
            *value = f32x4::splat(0.5) * (a + b);
        }
    }
}

/// Solves the first `N` rows of `width` pixels side by side: each step of a row waits for the one before.
fn solve_rows<const N: usize>(factors: &[Factor], source: &[f32x4], out: &mut [f32x4], width: usize) {
    let factors: [&[Factor]; N] = std::array::from_fn(|k| &factors[k * width..][..width]);
    let source: [&[f32x4]; N] = std::array::from_fn(|k| &source[k * width..][..width]);
    let mut rest = out;
    let out: [&mut [f32x4]; N] = std::array::from_fn(|_| {
        let (row, below) = std::mem::take(&mut rest).split_at_mut(width);
        rest = below;
        row
    });
    let mut previous = [f32x4::ZERO; N];
    for x in 0..width {
        for k in 0..N {
            let f = factors[k][x];
            previous[k] = (source[k][x] + f32x4::splat(f.edge) * previous[k]) * f32x4::splat(f.pivot);
            out[k][x] = previous[k];
        }
    }
    let mut next = [f32x4::ZERO; N];
    for x in (0..width).rev() {
        for k in 0..N {
            next[k] = out[k][x] + f32x4::splat(factors[k][x].ratio) * next[k];
            out[k][x] = next[k];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(width: usize, height: usize, f: impl Fn(usize, usize) -> (f32, f32)) -> FlowField {
        FlowField {
            u: Plane::from_fn(width, height, |x, y| f(x, y).0),
            v: Plane::from_fn(width, height, |x, y| f(x, y).1),
        }
    }

    #[test]
    fn constant_flow_has_no_variation() {
        let sigma = local_flow_variation(&field(31, 22, |_, _| (3.0, -1.5)));
        assert_eq!((sigma.width(), sigma.height()), (16, 11));
        assert!(sigma.data().iter().all(|&s| s < 0.01), "{:?}", sigma.data().iter().fold(0.0_f32, |a, &b| a.max(b)));
    }

    #[test]
    fn a_zoom_varies_everywhere() {
        let sigma = local_flow_variation(&field(120, 80, |x, y| (0.02 * (x as f32 - 60.0), 0.02 * (y as f32 - 40.0))));
        assert!(
            sigma.data().iter().all(|&s| s > 0.03),
            "least {:?}",
            sigma.data().iter().fold(9.0_f32, |a, &b| a.min(b))
        );
    }

    #[test]
    fn variation_beside_a_sharp_motion_boundary_stays_well_below_that_of_full_mixing() {
        let sigma = local_flow_variation(&field(320, 60, |x, _| if x < 160 { (0.0, 0.0) } else { (4.0, 0.0) }));
        let mixed = 2.0;
        assert!(
            sigma[(30, 15)] < 0.45 * mixed && sigma[(130, 15)] < 0.45 * mixed,
            "{} {}",
            sigma[(30, 15)],
            sigma[(130, 15)]
        );
    }

    #[test]
    fn diffusion_keeps_the_mean() {
        let flow = field(40, 30, |x, y| ((x * y % 7) as f32, 0.0));
        let u = halved(&flow.u);
        let (across, down) = edge_weights(&u, &halved(&flow.v));
        let mut map: Vec<f32x4> = u.data().iter().map(|&v| f32x4::splat(v)).collect();
        let mean = |map: &[f32x4]| map.iter().map(|v| v.to_array()[1]).sum::<f32>() / map.len() as f32;
        let before = mean(&map);
        Systems::new(&across, &down, 2.5).step(&mut map);
        assert!((mean(&map) - before).abs() < 1e-3, "{before} {}", mean(&map));
    }

    #[test]
    fn tiny_fields_are_legal() {
        for (w, h) in [(1, 1), (1, 9), (17, 3)] {
            assert!(local_flow_variation(&field(w, h, |x, _| (x as f32, 0.0))).data().iter().all(|s| s.is_finite()));
        }
    }
}
