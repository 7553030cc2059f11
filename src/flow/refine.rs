//! Variational refinement: bends the flow until brightness and its slopes agree between the frames and the flow is smooth.
//!
//! Minimises, over the whole field `(u, v)`, the sum over pixels of
//! `delta · psi(E_I) + gamma · psi(E_G) + alpha · psi(E_S)` with `psi(s^2) = sqrt(s^2 + epsilon^2)`: constancy of brightness, constancy of its slopes
//! (Brox et al., ECCV 2004), both divided by the slopes' size (Zimmer et al., EMMCVPR 2009), and smoothness. As in DIS the
//! first frame's flow is refined by a linearisation around it.
//!
//! 1. The second frame is warped back by the flow; `A` is the mean of both frames, `D` their difference.
//! 2. From `A` and `D` come the derivatives that the linearised terms need.
//! 3. Each fixed point freezes the robust weights, which leaves a linear system of two equations a pixel.
//! 4. Red-black successive over-relaxation solves it, `u` and `v` of a pixel together.
//!
//! **Layout.** Every row is stored as its even columns, then its odd ones. All pixels of one colour of the checkerboard are then
//! neighbours in memory, and so are the four neighbours of each: the solver is made of plain vector loops. Sweeps are run as a
//! wavefront, sweep `s` two rows behind sweep `s - 1`, which gives the same numbers as one after another and keeps the rows
//! in the cache.

use super::FlowParams;
use super::pyramid::{PAD, Padded};
use crate::image::Plane;

/// Softens the robust function near zero, in pixels (data) and pixels per pixel (smoothness).
const EPSILON_SQ: f32 = 1e-3 * 1e-3;
/// Keeps the normalisation of the data terms away from zero where the image is flat (grey levels per pixel, squared).
const ZETA_SQ: f32 = 0.1 * 0.1;
/// Least determinant of a pixel's matrix, as a share of its diagonal's product; less would be rounding error only.
const LEAST_DETERMINANT: f32 = 1e-6;
/// Empty cells before and after each half row.
const MARGIN: usize = 1;

/// How much work the refinement of one level takes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Effort {
    /// Times that the robust weights are renewed.
    pub(super) fixed_points: usize,
    /// Sweeps of the solver for each.
    pub(super) sweeps: usize,
}

/// A plane whose rows hold the even columns, then the odd ones, each half within empty margins; one empty row above and below.
#[derive(Debug, Clone, Default)]
struct Split {
    data: Vec<f32>,
    half: usize,
}

impl Split {
    fn resize(&mut self, width: usize, height: usize) {
        self.half = width.div_ceil(2) + 2 * MARGIN;
        self.data.clear();
        self.data.resize(2 * self.half * (height + 2), 0.0);
    }

    /// Half row of `parity`, with margins; rows count from -1.
    fn half(&self, y: isize, parity: usize) -> &[f32] {
        &self.data[((y + 1) as usize * 2 + parity) * self.half..][..self.half]
    }

    fn half_mut(&mut self, y: usize, parity: usize) -> &mut [f32] {
        &mut self.data[((y + 1) * 2 + parity) * self.half..][..self.half]
    }

    /// Half rows of `parity` above and below, the other half of this row, and this half to write.
    fn around_mut(&mut self, y: usize, parity: usize) -> (Around<'_>, &mut [f32]) {
        let half = self.half;
        let (above, rest) = self.data.split_at_mut((y + 1) * 2 * half);
        let (here, below) = rest.split_at_mut(2 * half);
        let (even, odd) = here.split_at_mut(half);
        let (own, other) = if parity == 0 { (even, odd) } else { (odd, even) };
        let up = &above[above.len() - 2 * half + parity * half..][MARGIN..half - MARGIN];
        let down = &below[parity * half..][MARGIN..half - MARGIN];
        // Even pixel k lies between the odd ones k - 1 and k; odd pixel k between the even ones k and k + 1.
        let left = &other[MARGIN + parity - 1..];
        let right = &other[MARGIN + parity..];
        (Around { left, right, up, down }, &mut own[MARGIN..half - MARGIN])
    }

    fn write(&mut self, y: usize, row: &[f32]) {
        let half = self.half;
        let (even, odd) = self.data[(y + 1) * 2 * half..][..2 * half].split_at_mut(half);
        let pairs = row.chunks_exact(2);
        if let [last] = pairs.remainder() {
            even[half - MARGIN - 1] = *last;
        }
        for ((e, o), pair) in even[MARGIN..].iter_mut().zip(&mut odd[MARGIN..]).zip(pairs) {
            (*e, *o) = (pair[0], pair[1]);
        }
    }

    fn read(&self, y: usize, row: &mut [f32]) {
        let (even, odd) = (&self.half(y as isize, 0)[MARGIN..], &self.half(y as isize, 1)[MARGIN..]);
        let width = row.len();
        let mut pairs = row.chunks_exact_mut(2);
        for ((e, o), pair) in even.iter().zip(odd).zip(&mut pairs) {
            (pair[0], pair[1]) = (*e, *o);
        }
        if let [last] = pairs.into_remainder() {
            *last = even[width / 2];
        }
    }
}

/// The four neighbours of each pixel of a half row.
struct Around<'a> {
    left: &'a [f32],
    right: &'a [f32],
    up: &'a [f32],
    down: &'a [f32],
}

/// Working planes of the refinement; contents never matter between calls.
#[derive(Debug, Clone, Default)]
pub(super) struct Refiner {
    mean: Padded,
    difference: Padded,
    slope_x: Padded,
    slope_y: Padded,
    inside: Vec<f32>,
    warp: WarpRow,
    /// `I_x, I_y, I_z, I_xx, I_xy, I_yy, I_xz, I_yz`; the temporal ones less what the flow so far explains.
    derivatives: [Split; 8],
    u: Split,
    v: Split,
    /// Inverse of each pixel's 2 x 2 matrix (three entries) and its right-hand side (two).
    system: [Split; 5],
    /// Smoothness weight of the edge to the right and of the edge below.
    edge_right: Split,
    edge_down: Split,
}

impl Refiner {
    /// Refines `flow`, which leads from `from` to `to`, in place.
    pub(super) fn refine(
        &mut self,
        from: &Padded,
        to: &Padded,
        flow: (&mut Plane<f32>, &mut Plane<f32>),
        effort: Effort,
        params: &FlowParams,
    ) {
        let (width, height) = (from.width, from.height);
        self.resize(width, height);
        self.warp_back(from, to, flow.0, flow.1);
        self.differentiate(flow.0, flow.1);
        for y in 0..height {
            self.u.write(y, flow.0.row(y));
            self.v.write(y, flow.1.row(y));
        }
        for _ in 0..effort.fixed_points {
            for y in 0..height {
                self.weigh_edges(y, height, width, params);
                for parity in 0..2 {
                    self.set_up(y, parity, params);
                }
            }
            self.solve(height, effort.sweeps, params.overrelaxation);
        }
        for y in 0..height {
            self.u.read(y, flow.0.row_mut(y));
            self.v.read(y, flow.1.row_mut(y));
        }
    }

    fn resize(&mut self, width: usize, height: usize) {
        for plane in [&mut self.mean, &mut self.difference, &mut self.slope_x, &mut self.slope_y] {
            plane.resize(width, height);
        }
        let Self { derivatives, u, v, system, edge_right, edge_down, .. } = self;
        for plane in derivatives.iter_mut().chain([u, v, edge_right, edge_down]).chain(system) {
            plane.resize(width, height);
        }
        self.inside.resize(width * height, 0.0);
    }

    /// 1. Mean and difference of the first frame and the warped second one; where the flow leads outside, `inside` is 0.
    fn warp_back(&mut self, from: &Padded, to: &Padded, u: &Plane<f32>, v: &Plane<f32>) {
        let width = from.width;
        for y in 0..from.height {
            let inside = &mut self.inside[y * width..(y + 1) * width];
            let warped = self.warp.row(to, y, u.row(y), v.row(y), inside);
            let here = from.row(y);
            for ((mean, w), i) in self.mean.row_mut(y).iter_mut().zip(warped).zip(here) {
                *mean = 0.5 * (w + i);
            }
            for ((difference, w), i) in self.difference.row_mut(y).iter_mut().zip(warped).zip(here) {
                *difference = w - i;
            }
        }
        self.mean.replicate_border();
        self.difference.replicate_border();
    }

    /// 2. The eight derivatives. Around the flow `(u0, v0)` the brightness term is `I_z + I_x (u - u0) + I_y (v - v0)`; the part
    /// without `u` and `v` is what is kept as temporal derivative, and likewise for the slopes.
    fn differentiate(&mut self, u: &Plane<f32>, v: &Plane<f32>) {
        let (width, height) = (self.mean.width, self.mean.height);
        for y in 0..height {
            slope_across(&self.mean, y, self.slope_x.row_mut(y));
            slope_down(&self.mean, y, self.slope_y.row_mut(y));
        }
        self.slope_x.replicate_border();
        self.slope_y.replicate_border();
        let mut rows: [Vec<f32>; 8] = std::array::from_fn(|_| vec![0.0; width]);
        for y in 0..height {
            let inside = &self.inside[y * width..(y + 1) * width];
            rows[0].copy_from_slice(self.slope_x.row(y));
            rows[1].copy_from_slice(self.slope_y.row(y));
            rows[2].copy_from_slice(self.difference.row(y));
            slope_across(&self.slope_x, y, &mut rows[3]);
            slope_down(&self.slope_x, y, &mut rows[4]);
            slope_down(&self.slope_y, y, &mut rows[5]);
            slope_across(&self.difference, y, &mut rows[6]);
            slope_down(&self.difference, y, &mut rows[7]);
            let [x, yy, z, xx, xy, y2, xz, yz] = &mut rows;
            subtract_explained(z, x, yy, u.row(y), v.row(y));
            subtract_explained(xz, xx, xy, u.row(y), v.row(y));
            subtract_explained(yz, xy, y2, u.row(y), v.row(y));
            for (row, plane) in rows.iter_mut().zip(&mut self.derivatives) {
                for (value, inside) in row.iter_mut().zip(inside) {
                    *value *= inside;
                }
                plane.write(y, row);
            }
        }
    }

    /// 3a. Weights of the edges to the right of and below row `y`; none crosses the border.
    fn weigh_edges(&mut self, y: usize, height: usize, width: usize, params: &FlowParams) {
        for parity in 0..2 {
            let other = 1 - parity;
            let len = self.u.half - 2 * MARGIN;
            let here = [self.u.half(y as isize, parity), self.v.half(y as isize, parity)].map(|h| &h[MARGIN..][..len]);
            let right =
                [self.u.half(y as isize, other), self.v.half(y as isize, other)].map(|h| &h[MARGIN + parity..][..len]);
            let below =
                [self.u.half(y as isize + 1, parity), self.v.half(y as isize + 1, parity)].map(|h| &h[MARGIN..][..len]);
            let edge_right = &mut self.edge_right.half_mut(y, parity)[MARGIN..][..len];
            let edge_down = &mut self.edge_down.half_mut(y, parity)[MARGIN..][..len];
            smoothness_weights(edge_right, edge_down, here, right, below, params.smoothness);
            if y + 1 == height {
                edge_down.fill(0.0);
            }
            // Pixels at and beyond the last column have no right neighbour.
            edge_right[(width - parity) / 2..].fill(0.0);
        }
    }

    /// 3b. The two equations of each pixel of a half row, solved for that pixel.
    fn set_up(&mut self, y: usize, parity: usize, params: &FlowParams) {
        let row = y as isize;
        let len = self.u.half - 2 * MARGIN;
        let derivatives: [&[f32]; 8] = std::array::from_fn(|k| &self.derivatives[k].half(row, parity)[MARGIN..][..len]);
        let (u, v) = (&self.u.half(row, parity)[MARGIN..][..len], &self.v.half(row, parity)[MARGIN..][..len]);
        let edges = Around {
            left: &self.edge_right.half(row, 1 - parity)[MARGIN + parity - 1..][..len],
            right: &self.edge_right.half(row, parity)[MARGIN..][..len],
            up: &self.edge_down.half(row - 1, parity)[MARGIN..][..len],
            down: &self.edge_down.half(row, parity)[MARGIN..][..len],
        };
        let [a, b, c, d, e] = &mut self.system;
        let out = [a, b, c, d, e].map(|plane| &mut plane.half_mut(y, parity)[MARGIN..][..len]);
        data_equations(out, derivatives, u, v, &edges, params.brightness_weight, params.slope_weight);
    }

    /// 4. `sweeps` red-black sweeps; red are the pixels whose column and row have an even sum.
    fn solve(&mut self, height: usize, sweeps: usize, overrelaxation: f32) {
        for front in 0..height + 2 * sweeps {
            for sweep in 0..sweeps {
                let Some(red) = front.checked_sub(2 * sweep) else { break };
                if red < height {
                    self.relax(red, red % 2, overrelaxation);
                }
                if let Some(black) = red.checked_sub(1).filter(|&y| y < height) {
                    self.relax(black, 1 - black % 2, overrelaxation);
                }
            }
        }
    }

    fn relax(&mut self, y: usize, parity: usize, overrelaxation: f32) {
        let row = y as isize;
        let len = self.u.half - 2 * MARGIN;
        let (around_u, u) = self.u.around_mut(y, parity);
        let (around_v, v) = self.v.around_mut(y, parity);
        let edges = Around {
            left: &self.edge_right.half(row, 1 - parity)[MARGIN + parity - 1..],
            right: &self.edge_right.half(row, parity)[MARGIN..],
            up: &self.edge_down.half(row - 1, parity)[MARGIN..],
            down: &self.edge_down.half(row, parity)[MARGIN..],
        };
        let system: [&[f32]; 5] = std::array::from_fn(|k| &self.system[k].half(row, parity)[MARGIN..][..len]);
        relax_row(u, v, &around_u, &around_v, &edges, system, overrelaxation);
    }
}

/// One step of over-relaxation for all pixels of a half row.
#[inline(never)]
fn relax_row(
    u: &mut [f32],
    v: &mut [f32],
    around_u: &Around<'_>,
    around_v: &Around<'_>,
    edges: &Around<'_>,
    system: [&[f32]; 5],
    overrelaxation: f32,
) {
    let n = u.len();
    let v = &mut v[..n];
    let [ul, ur, uu, ud] = [around_u.left, around_u.right, around_u.up, around_u.down].map(|s| &s[..n]);
    let [vl, vr, vu, vd] = [around_v.left, around_v.right, around_v.up, around_v.down].map(|s| &s[..n]);
    let [el, er, eu, ed] = [edges.left, edges.right, edges.up, edges.down].map(|s| &s[..n]);
    let [m11, m12, m22, b1, b2] = system.map(|s| &s[..n]);
    for i in 0..n {
        let right_u = b1[i] + (el[i] * ul[i] + er[i] * ur[i]) + (eu[i] * uu[i] + ed[i] * ud[i]);
        let right_v = b2[i] + (el[i] * vl[i] + er[i] * vr[i]) + (eu[i] * vu[i] + ed[i] * vd[i]);
        u[i] += overrelaxation * (m11[i] * right_u + m12[i] * right_v - u[i]);
        v[i] += overrelaxation * (m12[i] * right_u + m22[i] * right_v - v[i]);
    }
}

#[inline(never)]
fn smoothness_weights(
    edge_right: &mut [f32],
    edge_down: &mut [f32],
    here: [&[f32]; 2],
    right: [&[f32]; 2],
    below: [&[f32]; 2],
    smoothness: f32,
) {
    let n = edge_right.len();
    let edge_down = &mut edge_down[..n];
    let ([u, v], [ur, vr], [ud, vd]) = (here.map(|s| &s[..n]), right.map(|s| &s[..n]), below.map(|s| &s[..n]));
    for i in 0..n {
        let (right_u, right_v, down_u, down_v) = (ur[i] - u[i], vr[i] - v[i], ud[i] - u[i], vd[i] - v[i]);
        let across = right_u * right_u + right_v * right_v;
        let along = down_u * down_u + down_v * down_v;
        let weight = 0.5 * smoothness / (across + along + EPSILON_SQ).sqrt();
        edge_right[i] = weight;
        edge_down[i] = weight;
    }
}

#[inline(never)]
fn data_equations(
    out: [&mut [f32]; 5],
    derivatives: [&[f32]; 8],
    u: &[f32],
    v: &[f32],
    edges: &Around<'_>,
    brightness_weight: f32,
    slope_weight: f32,
) {
    let n = u.len();
    let v = &v[..n];
    let [m11, m12, m22, r1, r2] = out.map(|s| &mut s[..n]);
    let [x, y, z, xx, xy, yy, xz, yz] = derivatives.map(|s| &s[..n]);
    let [el, er, eu, ed] = [edges.left, edges.right, edges.up, edges.down].map(|s| &s[..n]);
    for i in 0..n {
        let size = x[i] * x[i] + y[i] * y[i] + ZETA_SQ;
        let residual = z[i] + x[i] * u[i] + y[i] * v[i];
        let weight = 0.5 * brightness_weight / (size * (residual * residual / size + EPSILON_SQ).sqrt());
        let size_x = 1.0 / (xx[i] * xx[i] + xy[i] * xy[i] + ZETA_SQ);
        let size_y = 1.0 / (yy[i] * yy[i] + xy[i] * xy[i] + ZETA_SQ);
        let residual_x = xz[i] + xx[i] * u[i] + xy[i] * v[i];
        let residual_y = yz[i] + xy[i] * u[i] + yy[i] * v[i];
        let squares = residual_x * residual_x * size_x + residual_y * residual_y * size_y;
        let slopes = 0.5 * slope_weight / (squares + EPSILON_SQ).sqrt();
        let (weight_x, weight_y) = (slopes * size_x, slopes * size_y);
        let smooth = (el[i] + er[i]) + (eu[i] + ed[i]) + ZETA_SQ * 1e-3;
        let a11 = weight * x[i] * x[i] + weight_x * xx[i] * xx[i] + weight_y * xy[i] * xy[i] + smooth;
        let a22 = weight * y[i] * y[i] + weight_x * xy[i] * xy[i] + weight_y * yy[i] * yy[i] + smooth;
        let a12 = weight * x[i] * y[i] + weight_x * xx[i] * xy[i] + weight_y * xy[i] * yy[i];
        let (product, determinant) = (a11 * a22, a11 * a22 - a12 * a12);
        let least = LEAST_DETERMINANT * product;
        let inverse = 1.0 / if determinant > least { determinant } else { least };
        m11[i] = a22 * inverse;
        m12[i] = -a12 * inverse;
        m22[i] = a11 * inverse;
        r1[i] = -(weight * z[i] * x[i] + weight_x * xz[i] * xx[i] + weight_y * yz[i] * xy[i]);
        r2[i] = -(weight * z[i] * y[i] + weight_x * xz[i] * xy[i] + weight_y * yz[i] * yy[i]);
    }
}

/// Central differences along row `y`, exact for cubics.
fn slope_across(plane: &Padded, y: usize, out: &mut [f32]) {
    let n = out.len();
    let row = plane.padded_row(y as isize);
    let [a, b, c, d] = [PAD - 2, PAD - 1, PAD + 1, PAD + 2].map(|start| &row[start..][..n]);
    five_taps(out, a, b, c, d);
}

/// Central differences down the columns at row `y`.
fn slope_down(plane: &Padded, y: usize, out: &mut [f32]) {
    let n = out.len();
    let [a, b, c, d] = [-2, -1, 1, 2].map(|k| &plane.padded_row(y as isize + k)[PAD..][..n]);
    five_taps(out, a, b, c, d);
}

#[inline(never)]
fn five_taps(out: &mut [f32], a: &[f32], b: &[f32], c: &[f32], d: &[f32]) {
    let n = out.len();
    let (a, b, c, d) = (&a[..n], &b[..n], &c[..n], &d[..n]);
    for i in 0..n {
        out[i] = (2.0 / 3.0) * (c[i] - b[i]) - (1.0 / 12.0) * (d[i] - a[i]);
    }
}

fn subtract_explained(temporal: &mut [f32], slope_x: &[f32], slope_y: &[f32], u: &[f32], v: &[f32]) {
    let n = temporal.len();
    let (slope_x, slope_y, u, v) = (&slope_x[..n], &slope_y[..n], &u[..n], &v[..n]);
    for i in 0..n {
        temporal[i] -= slope_x[i] * u[i] + slope_y[i] * v[i];
    }
}

/// Bilinear warping, a row at a time: positions in vector code, then the gather, then the blend in vector code.
#[derive(Debug, Clone, Default)]
struct WarpRow {
    start: Vec<u32>,
    fraction_x: Vec<f32>,
    fraction_y: Vec<f32>,
    corners: [Vec<f32>; 4],
    warped: Vec<f32>,
}

impl WarpRow {
    /// Row `y` of `image` displaced by `(u, v)`; `inside` becomes 1 where that lies inside the image, else 0.
    fn row(&mut self, image: &Padded, y: usize, u: &[f32], v: &[f32], inside: &mut [f32]) -> &[f32] {
        let n = u.len();
        let Self { start, fraction_x, fraction_y, corners, warped } = self;
        for values in [&mut *fraction_x, &mut *fraction_y, &mut *warped].into_iter().chain(corners.iter_mut()) {
            values.resize(n, 0.0);
        }
        start.resize(n, 0);
        let (right, bottom) = ((image.width - 1) as f32, (image.height - 1) as f32);
        let stride = image.stride as f32;
        for x in 0..n {
            let (to_x, to_y) = (x as f32 + u[x], y as f32 + v[x]);
            let held_x = if to_x > 0.0 { to_x } else { 0.0 };
            let held_x = if held_x < right { held_x } else { right };
            let held_y = if to_y > 0.0 { to_y } else { 0.0 };
            let held_y = if held_y < bottom { held_y } else { bottom };
            inside[x] = if held_x == to_x && held_y == to_y { 1.0 } else { 0.0 };
            let (whole_x, whole_y) = (held_x.floor(), held_y.floor());
            fraction_x[x] = held_x - whole_x;
            fraction_y[x] = held_y - whole_y;
            start[x] = (whole_y as i32 * stride as i32 + whole_x as i32) as u32;
        }
        let data = &image.data()[image.index(0, 0)..];
        let [a, b, c, d] = corners;
        for (x, &start) in start.iter().enumerate() {
            let start = start as usize;
            let (upper, lower) = (&data[start..start + 2], &data[start + image.stride..start + image.stride + 2]);
            (a[x], b[x], c[x], d[x]) = (upper[0], upper[1], lower[0], lower[1]);
        }
        for x in 0..n {
            let above = a[x] + fraction_x[x] * (b[x] - a[x]);
            let below = c[x] + fraction_x[x] * (d[x] - c[x]);
            warped[x] = above + fraction_y[x] * (below - above);
        }
        warped
    }
}
