//! Variational refinement of the flow: constancy of brightness and its gradient, and smoothness.
//!
//! Minimises, over the whole field `(u, v)`, the sum over pixels of
//!
//! ```text
//! delta psi(E_I) + gamma psi(E_G) + alpha psi(E_S),    psi(s²) = sqrt(s² + epsilon²)
//! ```
//!
//! with constancy of brightness `E_I` ([`BRIGHTNESS_WEIGHT`]), constancy of its gradient `E_G` ([`SLOPE_WEIGHT`]; Brox,
//! Bruhn, Papenberg and Weickert, ECCV 2004), each term divided by the length of its gradient so that it is a distance in
//! pixels (Zimmer, Bruhn and Weickert, IJCV 2011), and smoothness `E_S = |∇u|² + |∇v|²` (parameter `smoothness`).
//!
//! 1. Warp the second frame back by the flow; take the mean of both frames and their difference.
//! 2. Differentiate them for the linearised terms, which are zero where the flow leads outside the frame: only smoothness
//!    acts there.
//! 3. Each fixed-point iteration freezes the robust weights, which leaves a linear system of two equations a pixel.
//! 4. Solve it by red-black successive over-relaxation, `u` and `v` of a pixel together.
//!
//! **Deviation** from DIS: the unknown is the flow itself, not an increment, which saves two planes; the smoothness term has
//! a larger epsilon ([`SMOOTH_EPSILON_SQ`]).
//!
//! **Order of work.** Steps 3 and 4 run as one wavefront down the rows: sweep `s` two rows behind sweep `s - 1`, fixed-point
//! iteration `k` behind the last sweep of `k - 1`. The result is the same as of one pass after another, but a row is still
//! in the cache when it is needed again, and planes that only the wavefront reads hold only its rows.
//!
//! **Cost**: about 100 operations per pixel and fixed-point iteration, 20 more per sweep; 32 bytes a pixel, and 80 a pixel
//! of the wavefront's rows. **Limits**: linearised terms correct the flow by a few pixels only.

use super::FlowParams;
use super::pyramid::{PAD, PaddedPlane, grow};
use crate::image::Plane;
use std::iter;
use wide::{CmpGt, f32x8};

// Constants without a source were chosen by eye and checked on the Middlebury pairs, as the module `flow` reports.

/// Weight of constant brightness (OpenCV's DIS: 5).
const BRIGHTNESS_WEIGHT: f32 = 5.0;
/// Weight of a constant gradient of brightness, which tolerates changing light (OpenCV's DIS: 10).
const SLOPE_WEIGHT: f32 = 10.0;
/// Sweeps of the solver per fixed-point iteration (OpenCV's DIS: 5).
const NUM_SWEEPS: usize = 5;
/// Over-relaxation factor of the sweeps, 1 to 2 (OpenCV's DIS: 1.6).
const OVERRELAXATION: f32 = 1.9;
/// Epsilon of the robust function of the data terms, in pixels, squared.
const DATA_EPSILON_SQ: f32 = 0.01 * 0.01;
/// Epsilon of the robust function of the smoothness term, in pixels per pixel, squared. Smaller turns slopes into stairs
/// (more pixels exceed the tracker's limit on flow gradients), larger blurs the flow at the borders of objects.
const SMOOTH_EPSILON_SQ: f32 = 0.03 * 0.03;
/// Smallest length of a gradient that a term is divided by, in grey levels per pixel, squared (OpenCV: 0.1).
const ZETA_SQ: f32 = 0.1 * 0.1;
/// Diagonal entry for pixels with neither texture nor neighbours, so that their equations have a solution.
const MIN_STIFFNESS: f32 = 1e-5;
/// Smallest determinant of a pixel's matrix relative to the product of its diagonal; less is rounding error.
const MIN_DETERMINANT_RATIO: f32 = 1e-6;

/// Working planes of the refinement.
#[derive(Debug, Clone, Default)]
pub(super) struct Refiner {
    mean: PaddedPlane,
    difference: PaddedPlane,
    slope_x: PaddedPlane,
    slope_y: PaddedPlane,
    warp: WarpRow,
    inside: Vec<f32>,
    /// One row of the coefficients of the terms.
    rows: [Vec<f32>; 9],
    /// Coefficients `a, b, c` of the terms `a u + b v + c` of brightness, its x-slope and its y-slope.
    terms: Bundle<9>,
    u: Checkerboard,
    v: Checkerboard,
    /// Inverse of each pixel's symmetric 2 x 2 matrix (three entries), its right-hand side (two), and the weights of its edges
    /// to the left, to the right, above and below.
    system: Bundle<9>,
    /// Smoothness weight of the edge to the right and of the edge below.
    edge_right: Checkerboard,
    edge_down: Checkerboard,
}

impl Refiner {
    /// Refines the flow `(u, v)` from `from` to `to` in place.
    pub(super) fn refine(
        &mut self,
        from: &PaddedPlane,
        to: &PaddedPlane,
        u: &mut Plane<f32>,
        v: &mut Plane<f32>,
        params: &FlowParams,
    ) {
        self.resize(from.width, from.height, RowBuffer::of_last(wavefront_rows(params) + 2, from.height));
        self.warp_back(from, to, u, v);
        self.differentiate();
        for y in 0..from.height {
            self.u.write(y, u.row(y));
            self.v.write(y, v.row(y));
        }
        self.solve(u, v, params);
        for y in 0..from.height {
            self.u.read(y, u.row_mut(y));
            self.v.read(y, v.row_mut(y));
        }
    }

    /// Sets the size of all planes; those that only the wavefront reads hold `rows`.
    fn resize(&mut self, width: usize, height: usize, rows: RowBuffer) {
        for plane in [&mut self.mean, &mut self.difference, &mut self.slope_x, &mut self.slope_y] {
            plane.resize(width, height);
        }
        let Self { terms, u, v, system, edge_right, edge_down, .. } = self;
        for plane in [u, v] {
            plane.resize(width, RowBuffer::of_all(height));
        }
        for plane in [edge_right, edge_down] {
            plane.resize(width, rows);
        }
        terms.resize(width, rows);
        system.resize(width, rows);
        self.rows.iter_mut().for_each(|row| row.resize(width, 0.0));
        grow(&mut self.inside, width * height, 0.0);
    }

    /// Step 1: computes mean and difference of the first frame and the warped second one; `inside` is 0 where the flow leads
    /// outside.
    fn warp_back(&mut self, from: &PaddedPlane, to: &PaddedPlane, u: &Plane<f32>, v: &Plane<f32>) {
        for (y, inside) in self.inside.chunks_exact_mut(from.width).take(from.height).enumerate() {
            let warped = self.warp.row(to, y, u.row(y), v.row(y), inside);
            for ((mean, w), i) in self.mean.row_mut(y).iter_mut().zip(warped).zip(from.row(y)) {
                *mean = 0.5 * (w + i);
            }
            for ((difference, w), i) in self.difference.row_mut(y).iter_mut().zip(warped).zip(from.row(y)) {
                *difference = w - i;
            }
        }
        self.mean.replicate_border();
        self.difference.replicate_border();
    }

    /// Step 2: computes the gradient of the mean.
    fn differentiate(&mut self) {
        for y in 0..self.mean.height {
            slope_across(&self.mean, y, self.slope_x.row_mut(y));
            slope_down(&self.mean, y, self.slope_y.row_mut(y));
        }
        self.slope_x.replicate_border();
        self.slope_y.replicate_border();
    }

    /// Step 2 in row `y`: computes the three terms, linearised around the current flow.
    #[inline(never)]
    fn compute_terms(&mut self, y: usize, u: &Plane<f32>, v: &Plane<f32>) {
        let inside = &self.inside[y * self.mean.width..][..self.mean.width];
        let [x, y_, z, xx, xy, xz, yx, yy, yz] = &mut self.rows;
        x.copy_from_slice(self.slope_x.row(y));
        y_.copy_from_slice(self.slope_y.row(y));
        z.copy_from_slice(self.difference.row(y));
        slope_across(&self.slope_x, y, xx);
        slope_down(&self.slope_x, y, xy);
        slope_across(&self.difference, y, xz);
        slope_across(&self.slope_y, y, yx);
        slope_down(&self.slope_y, y, yy);
        slope_down(&self.difference, y, yz);
        for term in [[x, y_, z], [xx, xy, xz], [yx, yy, yz]] {
            linearise(term, u.row(y), v.row(y), inside);
        }
        self.terms.write(y, &self.rows);
    }

    /// Steps 3 and 4 as one wavefront. Pixels whose column and row have an even sum are red; black runs one row behind red.
    /// The equations of row `y` are set up before any sweep of their iteration reaches row `y`, and after all sweeps of the
    /// previous iteration, [`LAG_ROWS`] ahead, have passed row `y + 1`. `u` and `v` are the initial flow.
    fn solve(&mut self, u: &Plane<f32>, v: &Plane<f32>, params: &FlowParams) {
        let height = self.mean.height;
        let fixed_points = params.fixed_points as usize;
        self.edge_down.clear_above();
        for front in 0..height + fixed_points * LAG_ROWS {
            for fixed_point in 0..fixed_points {
                let Some(first) = front.checked_sub(fixed_point * LAG_ROWS) else { break };
                if first < height {
                    if fixed_point == 0 {
                        self.compute_terms(first, u, v);
                    }
                    self.compute_edge_weights(first, height, params.smoothness);
                    self.set_up_equations(first);
                }
                for sweep in 0..NUM_SWEEPS {
                    let Some(red) = first.checked_sub(2 * sweep) else { break };
                    if red < height {
                        self.relax(red, red % 2, OVERRELAXATION);
                    }
                    if let Some(black) = red.checked_sub(1).filter(|&y| y < height) {
                        self.relax(black, 1 - black % 2, OVERRELAXATION);
                    }
                }
            }
        }
    }

    /// Step 3a: computes the weights of the edges to the right of and below row `y`; 0 across the frame border.
    fn compute_edge_weights(&mut self, y: usize, height: usize, smoothness: f32) {
        let row = y as isize;
        for parity in 0..2 {
            let [centre, right, below] = [
                [self.u.row(row, parity), self.v.row(row, parity)],
                [self.u.right_of(row, parity), self.v.right_of(row, parity)],
                [self.u.row(row + 1, parity), self.v.row(row + 1, parity)],
            ];
            let (edge_right, edge_down) = (self.edge_right.row_mut(y, parity), self.edge_down.row_mut(y, parity));
            smoothness_weights(edge_right, edge_down, centre, right, below, smoothness);
            if y + 1 == height {
                edge_down.fill([0.0; LANES]);
            }
            self.edge_right.cells_at_right_border(y, parity).fill(0.0);
        }
    }

    /// Step 3b: sets up the equations of each pixel of row `y`.
    fn set_up_equations(&mut self, y: usize) {
        let row = y as isize;
        for parity in 0..2 {
            let flow = [self.u.row(row, parity), self.v.row(row, parity)];
            let edges = edges(&self.edge_right, &self.edge_down, y, parity);
            compute_equations(self.system.row_mut(y, parity), self.terms.row(y, parity), flow, edges);
        }
    }

    /// Step 4: relaxes the pixels of one colour in row `y`.
    fn relax(&mut self, y: usize, parity: usize, overrelaxation: f32) {
        let (neighbours_u, u) = self.u.row_and_neighbours(y, parity);
        let (neighbours_v, v) = self.v.row_and_neighbours(y, parity);
        relax_row(u, v, [neighbours_u, neighbours_v], self.system.row(y, parity), overrelaxation);
    }
}

/// Rows between one fixed-point iteration and the next.
const LAG_ROWS: usize = 2 * NUM_SWEEPS + 1;

/// Returns the number of rows between the last one set up and the last one finished.
fn wavefront_rows(params: &FlowParams) -> usize {
    params.fixed_points as usize * LAG_ROWS
}

/// Returns the weights of the four edges of each pixel of a half row.
fn edges<'a>(edge_right: &'a Checkerboard, edge_down: &'a Checkerboard, y: usize, parity: usize) -> Edges<'a> {
    let row = y as isize;
    Edges {
        left: edge_right.left_of(row, parity),
        right: edge_right.row(row, parity),
        up: edge_down.row(row - 1, parity),
        down: edge_down.row(row, parity),
    }
}

// The loops below are separate functions, not inlined: their arguments tell the compiler that outputs do not overlap inputs.

#[inline(always)]
fn load(lanes: &Lanes) -> f32x8 {
    f32x8::new(*lanes)
}

/// Computes `alpha / (2 |gradient of the flow|)`, from forward differences, for both edges of each pixel.
#[inline(never)]
fn smoothness_weights(
    edge_right: &mut [Lanes],
    edge_down: &mut [Lanes],
    centre: [&[Lanes]; 2],
    right: [&[Lanes]; 2],
    below: [&[Lanes]; 2],
    smoothness: f32,
) {
    let n = edge_right.len();
    let edge_down = &mut edge_down[..n];
    let ([u, v], [ur, vr], [ud, vd]) = (centre.map(|s| &s[..n]), right.map(|s| &s[..n]), below.map(|s| &s[..n]));
    let (half, epsilon_sq) = (f32x8::splat(0.5 * smoothness), f32x8::splat(SMOOTH_EPSILON_SQ));
    for i in 0..n {
        let (u, v) = (load(&u[i]), load(&v[i]));
        let (ux, vx) = (load(&ur[i]) - u, load(&vr[i]) - v);
        let (uy, vy) = (load(&ud[i]) - u, load(&vd[i]) - v);
        let weight = half / (ux * ux + vx * vx + uy * uy + vy * vy + epsilon_sq).sqrt();
        edge_right[i] = weight.to_array();
        edge_down[i] = weight.to_array();
    }
}

/// Computes matrix and right-hand side of each pixel from the robust weights of the data terms at the current flow.
#[inline(never)]
fn compute_equations(system: &mut [[Lanes; 9]], terms: &[[Lanes; 9]], flow: [&[Lanes]; 2], edges: Edges<'_>) {
    let n = system.len();
    let ([u, v], terms) = (flow.map(|s| &s[..n]), &terms[..n]);
    let [el, er, eu, ed] = [edges.left, edges.right, edges.up, edges.down].map(|s| &s[..n]);
    let [brightness_weight, slope_weight] = [BRIGHTNESS_WEIGHT, SLOPE_WEIGHT].map(|w| f32x8::splat(0.5 * w));
    let [epsilon_sq, stiffness, min_ratio] = [DATA_EPSILON_SQ, MIN_STIFFNESS, MIN_DETERMINANT_RATIO].map(f32x8::splat);
    for i in 0..n {
        let (u, v) = (load(&u[i]), load(&v[i]));
        let [x, y, z, xx, xy, xz, yx, yy, yz] = &terms[i];
        let (x, y, z) = (load(x), load(y), load(z));
        let (xx, xy, xz) = (load(xx), load(xy), load(xz));
        let (yx, yy, yz) = (load(yx), load(yy), load(yz));
        let brightness = z + x * u + y * v;
        let slope_x = xz + xx * u + xy * v;
        let slope_y = yz + yx * u + yy * v;
        let w = brightness_weight / (brightness * brightness + epsilon_sq).sqrt();
        let s = slope_weight / (slope_x * slope_x + slope_y * slope_y + epsilon_sq).sqrt();
        let (left, right, up, down) = (load(&el[i]), load(&er[i]), load(&eu[i]), load(&ed[i]));
        let smooth = (left + right) + (up + down) + stiffness;
        let a11 = w * (x * x) + s * (xx * xx + yx * yx) + smooth;
        let a22 = w * (y * y) + s * (xy * xy + yy * yy) + smooth;
        let a12 = w * (x * y) + s * (xx * xy + yx * yy);
        let (determinant, min) = (a11 * a22 - a12 * a12, min_ratio * (a11 * a22));
        // NaN becomes the minimum.
        let inverse = f32x8::ONE / determinant.cmp_gt(min).blend(determinant, min);
        let b1 = -(w * (z * x) + s * (xz * xx + yz * yx));
        let b2 = -(w * (z * y) + s * (xz * xy + yz * yy));
        let [m11, m12, m22, r1, r2, to_left, to_right, to_up, to_down] = &mut system[i];
        (*m11, *m12, *m22) = ((a22 * inverse).to_array(), (-a12 * inverse).to_array(), (a11 * inverse).to_array());
        (*r1, *r2) = (b1.to_array(), b2.to_array());
        (*to_left, *to_right, *to_up, *to_down) = (el[i], er[i], eu[i], ed[i]);
    }
}

#[inline(never)]
fn relax_row(
    u: &mut [Lanes],
    v: &mut [Lanes],
    neighbours: [Neighbours<'_>; 2],
    system: &[[Lanes; 9]],
    overrelaxation: f32,
) {
    let n = u.len();
    let (v, system) = (&mut v[..n], &system[..n]);
    let [u_up, u_down] = [neighbours[0].up, neighbours[0].down].map(|s| &s[..n]);
    let [v_up, v_down] = [neighbours[1].up, neighbours[1].down].map(|s| &s[..n]);
    let [u_beside, v_beside] = neighbours.map(|n| n.beside);
    assert!(u_beside.len() > LANES * n && v_beside.len() > LANES * n);
    let overrelaxation = f32x8::splat(overrelaxation);
    for i in 0..n {
        let [m11, m12, m22, b1, b2, left, right, up, down] = &system[i];
        let (m11, m12, m22, b1, b2) = (load(m11), load(m12), load(m22), load(b1), load(b2));
        let (left, right, up, down) = (load(left), load(right), load(up), load(down));
        let ([u_left, u_right], [v_left, v_right]) = (load_pair(u_beside, i), load_pair(v_beside, i));
        let r1 = b1 + (left * u_left + right * u_right) + (up * load(&u_up[i]) + down * load(&u_down[i]));
        let r2 = b2 + (left * v_left + right * v_right) + (up * load(&v_up[i]) + down * load(&v_down[i]));
        let (u0, v0) = (load(&u[i]), load(&v[i]));
        u[i] = (u0 + overrelaxation * (m11 * r1 + m12 * r2 - u0)).to_array();
        v[i] = (v0 + overrelaxation * (m12 * r1 + m22 * r2 - v0)).to_array();
    }
}

/// Loads block `i` of a half row, and the same one cell further.
#[inline(always)]
fn load_pair(beside: &[f32], i: usize) -> [f32x8; 2] {
    let cells = &beside[LANES * i..][..LANES + 1];
    let cells_at = |k: usize| load(cells[k..].first_chunk().expect("one more than a block"));
    [cells_at(0), cells_at(1)]
}

/// Converts the coefficients of a term `a (u - u0) + b (v - v0) + c` to `a u + b v + c`, divided by the length of `(a, b)`;
/// zeros where the flow leads outside.
#[inline(never)]
fn linearise(term: [&mut Vec<f32>; 3], u: &[f32], v: &[f32], inside: &[f32]) {
    let n = u.len();
    let [a, b, c] = term.map(|row| &mut row[..n]);
    let (v, inside) = (&v[..n], &inside[..n]);
    for i in 0..n {
        let scale = inside[i] / (a[i] * a[i] + b[i] * b[i] + ZETA_SQ).sqrt();
        let offset = c[i] - a[i] * u[i] - b[i] * v[i];
        (a[i], b[i], c[i]) = (scale * a[i], scale * b[i], scale * offset);
    }
}

/// Differentiates row `y` by central differences, exact for polynomials of fourth degree.
#[inline(never)]
fn slope_across(plane: &PaddedPlane, y: usize, out: &mut [f32]) {
    let row = plane.padded_row(y as isize);
    differentiate_five_taps(out, [PAD - 2, PAD - 1, PAD + 1, PAD + 2].map(|start| &row[start..]));
}

/// Differentiates the columns at row `y` by the same differences.
#[inline(never)]
fn slope_down(plane: &PaddedPlane, y: usize, out: &mut [f32]) {
    differentiate_five_taps(out, [-2, -1, 1, 2].map(|k| &plane.padded_row(y as isize + k)[PAD..]));
}

#[inline(never)]
fn differentiate_five_taps(out: &mut [f32], taps: [&[f32]; 4]) {
    let n = out.len();
    let [a, b, c, d] = taps.map(|s| &s[..n]);
    for i in 0..n {
        out[i] = (2.0 / 3.0) * (c[i] - b[i]) - (1.0 / 12.0) * (d[i] - a[i]);
    }
}

// The second frame warped back onto the first, a row at a time.

/// Bilinear warping in three loops: vectorised positions, the gather, the vectorised blend.
#[derive(Debug, Clone, Default)]
struct WarpRow {
    start: Vec<u32>,
    fraction_x: Vec<f32>,
    fraction_y: Vec<f32>,
    corners: [Vec<f32>; 4],
    warped: Vec<f32>,
}

impl WarpRow {
    /// Computes row `y` of `image` displaced by `(u, v)`; `inside` becomes 1 where the target is inside the image, else 0.
    fn row(&mut self, image: &PaddedPlane, y: usize, u: &[f32], v: &[f32], inside: &mut [f32]) -> &[f32] {
        let n = u.len();
        let Self { start, fraction_x, fraction_y, corners, warped } = self;
        start.resize(n, 0);
        for values in [&mut *fraction_x, &mut *fraction_y, &mut *warped].into_iter().chain(corners.iter_mut()) {
            values.resize(n, 0.0);
        }
        locate_targets(image, y as f32, [u, v], start, [fraction_x, fraction_y], inside);
        let data = &image.data[image.index(0, 0)..];
        let [a, b, c, d] = corners.each_mut().map(|corner| &mut corner[..n]);
        for (x, &start) in start.iter().enumerate() {
            let (upper, lower) = (&data[start as usize..][..2], &data[start as usize + image.stride..][..2]);
            (a[x], b[x], c[x], d[x]) = (upper[0], upper[1], lower[0], lower[1]);
        }
        blend(warped, [a, b, c, d], fraction_x, fraction_y);
        warped
    }
}

/// Computes, for each pixel of row `y`, the index of the upper left of the four pixels around its target, the fractions, and
/// 1 or 0 for a target inside or outside. Targets outside are clamped to the border.
#[inline(never)]
fn locate_targets(
    image: &PaddedPlane,
    y: f32,
    [u, v]: [&[f32]; 2],
    start: &mut [u32],
    [fraction_x, fraction_y]: [&mut Vec<f32>; 2],
    inside: &mut [f32],
) {
    let n = u.len();
    let (v, start, inside) = (&v[..n], &mut start[..n], &mut inside[..n]);
    let (fraction_x, fraction_y) = (&mut fraction_x[..n], &mut fraction_y[..n]);
    let (right, bottom, stride) = ((image.width - 1) as f32, (image.height - 1) as f32, image.stride as i32);
    for x in 0..n {
        let (to_x, to_y) = (x as i32 as f32 + u[x], y + v[x]);
        let (clamped_x, clamped_y) = (clamp_position(to_x, right), clamp_position(to_y, bottom));
        inside[x] = if (clamped_x == to_x) & (clamped_y == to_y) { 1.0 } else { 0.0 };
        let (pixel_x, pixel_y) = (clamped_x as i32, clamped_y as i32);
        fraction_x[x] = clamped_x - pixel_x as f32;
        fraction_y[x] = clamped_y - pixel_y as f32;
        start[x] = (pixel_y * stride + pixel_x) as u32;
    }
}

/// Clamps `position` to `0..=last`; NaN becomes 0. Comparisons, because `f32::clamp` does not vectorise.
#[inline(always)]
fn clamp_position(position: f32, last: f32) -> f32 {
    let clamped = if position > 0.0 { position } else { 0.0 };
    if clamped < last { clamped } else { last }
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

// A plane stored for checkerboard sweeps: each row as its even columns, then its odd ones.
//
// ```text
// row y:  | margin  x=0  x=2  x=4 .. margin | margin  x=1  x=3  x=5 .. margin |
// ```
//
// All pixels of one colour in a row are then neighbours in memory, and so are the pixels to the left of them, to the
// right, above and below: a sweep over one colour is a loop over slices of equal length, [`LANES`] numbers at a time.

/// Numbers in a vector of the kernels: eight `f32` fill 256 bits. The cells of a half row are a multiple of it.
const LANES: usize = 8;
type Lanes = [f32; LANES];

/// Number of empty cells before and after each half row: one neighbour.
const MARGIN: usize = 1;

/// A plane in the order above, with one empty row above and below, or a ring buffer of its last rows.
///
/// Invariants: margins, the rows outside, and the cells beyond the width are zero; a solver that gives them no equation and
/// no edge leaves them so.
#[derive(Debug, Clone, Default)]
struct Checkerboard {
    data: Vec<f32>,
    width: usize,
    rows: RowBuffer,
    /// Cells of a half row, margins included.
    half: usize,
}

/// The four edges of each pixel of a half row, [`LANES`] at a time.
#[derive(Debug, Clone, Copy)]
struct Edges<'a> {
    left: &'a [Lanes],
    right: &'a [Lanes],
    up: &'a [Lanes],
    down: &'a [Lanes],
}

/// The four neighbours of each pixel of a half row.
#[derive(Debug, Clone, Copy)]
struct Neighbours<'a> {
    /// The left neighbour of each pixel, and the right neighbour of the last: the right neighbour of any is the next cell.
    beside: &'a [f32],
    up: &'a [Lanes],
    down: &'a [Lanes],
}

// Not inlined: called once a row, copies would only make the file larger.
impl Checkerboard {
    /// Sets width and rows. A plane that has both already keeps its values.
    #[inline(never)]
    fn resize(&mut self, width: usize, rows: RowBuffer) {
        if (self.width, self.rows) != (width, rows) {
            let half = num_blocks(width) * LANES + 2 * MARGIN;
            (self.width, self.rows, self.half) = (width, rows, half);
            self.data.clear();
            self.data.resize(2 * half * rows.count, 0.0);
        }
    }

    /// Returns the columns of `parity` in row `y`, which counts from -1.
    #[inline(never)]
    fn row(&self, y: isize, parity: usize) -> &[Lanes] {
        self.cells(self.start(y, parity))
    }

    /// Returns the columns of `parity` in row `y` mutably.
    #[inline(never)]
    fn row_mut(&mut self, y: usize, parity: usize) -> &mut [Lanes] {
        let (start, cells) = (self.start(y as isize, parity), self.half - 2 * MARGIN);
        self.data[start..][..cells].as_chunks_mut().0
    }

    /// Returns the left neighbours of the columns of `parity`: of even pixel `k` the odd `k - 1`, of odd pixel `k` the even
    /// `k`.
    #[inline(never)]
    fn left_of(&self, y: isize, parity: usize) -> &[Lanes] {
        self.cells(self.start(y, 1 - parity) + parity - 1)
    }

    /// Returns the right neighbours of the columns of `parity`.
    #[inline(never)]
    fn right_of(&self, y: isize, parity: usize) -> &[Lanes] {
        self.cells(self.start(y, 1 - parity) + parity)
    }

    /// Returns the neighbours of the columns of `parity` in row `y`, and these columns mutably, in a plane that holds all
    /// rows.
    #[inline(never)]
    fn row_and_neighbours(&mut self, y: usize, parity: usize) -> (Neighbours<'_>, &mut [Lanes]) {
        let (half, cells) = (self.half, self.half - 2 * MARGIN);
        let (above, rest) = self.data.split_at_mut((y + 1) * 2 * half);
        let (row, below) = rest.split_at_mut(2 * half);
        let (even, odd) = row.split_at_mut(half);
        let (centre, beside) = if parity == 0 { (even, odd) } else { (odd, even) };
        let neighbours = Neighbours {
            beside: &beside[MARGIN + parity - 1..][..cells + 1],
            up: above[y * 2 * half + parity * half + MARGIN..][..cells].as_chunks().0,
            down: below[parity * half + MARGIN..][..cells].as_chunks().0,
        };
        (neighbours, centre[MARGIN..][..cells].as_chunks_mut().0)
    }

    /// Returns the cells of `parity` in row `y` that have no right neighbour.
    fn cells_at_right_border(&mut self, y: usize, parity: usize) -> &mut [f32] {
        let width = self.width;
        &mut self.row_mut(y, parity).as_flattened_mut()[(width - parity) / 2..]
    }

    /// Fills row `y` from values in the usual order.
    #[inline(never)]
    fn write(&mut self, y: usize, values: &[f32]) {
        let half = self.half;
        let start = self.start(y as isize, 0) - MARGIN;
        let (even, odd) = self.data[start..][..2 * half].split_at_mut(half);
        let pairs = values.chunks_exact(2);
        if let [last] = pairs.remainder() {
            even[MARGIN + values.len() / 2] = *last;
        }
        for ((e, o), pair) in even[MARGIN..].iter_mut().zip(&mut odd[MARGIN..]).zip(pairs) {
            (*e, *o) = (pair[0], pair[1]);
        }
    }

    /// Reads row `y` in the usual order.
    fn read(&self, y: usize, values: &mut [f32]) {
        let [even, odd] = [0, 1].map(|parity| self.row(y as isize, parity).as_flattened());
        let middle = values.len() / 2;
        let mut pairs = values.chunks_exact_mut(2);
        for ((e, o), pair) in even.iter().zip(odd).zip(&mut pairs) {
            (pair[0], pair[1]) = (*e, *o);
        }
        if let [last] = pairs.into_remainder() {
            *last = even[middle];
        }
    }

    /// Sets the row above the first to zero.
    fn clear_above(&mut self) {
        self.data[..2 * self.half].fill(0.0);
    }

    fn cells(&self, start: usize) -> &[Lanes] {
        self.data[start..][..self.half - 2 * MARGIN].as_chunks().0
    }

    fn start(&self, y: isize, parity: usize) -> usize {
        (self.rows.index(y) * 2 + parity) * self.half + MARGIN
    }
}

/// Returns the number of blocks of [`LANES`] pixels of one colour in a row.
fn num_blocks(width: usize) -> usize {
    width.div_ceil(2).div_ceil(LANES)
}

/// The rows of a plane in memory: all of them and one above and below, or a ring buffer of the last ones.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct RowBuffer {
    count: usize,
    /// Bits of `y + 1` that are the index of row `y`: a division would cost half as much as a row's sweep.
    mask: usize,
}

impl RowBuffer {
    /// Holds all rows of a plane.
    fn of_all(height: usize) -> Self {
        Self { count: height + 2, mask: usize::MAX }
    }

    /// Holds at least the last `rows` rows of a plane.
    fn of_last(rows: usize, height: usize) -> Self {
        let count = rows.next_power_of_two();
        if count < height + 2 { Self { count, mask: count - 1 } } else { Self::of_all(height) }
    }

    fn index(self, y: isize) -> usize {
        (y + 1) as usize & self.mask
    }
}

/// `N` numbers a pixel in the same order, interleaved in blocks of [`LANES`] pixels, as they are always read together.
#[derive(Debug, Clone)]
struct Bundle<const N: usize> {
    data: Vec<[Lanes; N]>,
    rows: RowBuffer,
    half: usize,
}

impl<const N: usize> Default for Bundle<N> {
    fn default() -> Self {
        Self { data: Vec::new(), rows: RowBuffer::default(), half: 0 }
    }
}

impl<const N: usize> Bundle<N> {
    /// Sets width and rows; values are unspecified.
    fn resize(&mut self, width: usize, rows: RowBuffer) {
        (self.half, self.rows) = (num_blocks(width), rows);
        grow(&mut self.data, 2 * self.half * rows.count, [[0.0; LANES]; N]);
    }

    /// Returns the columns of `parity` in row `y`.
    fn row(&self, y: usize, parity: usize) -> &[[Lanes; N]] {
        &self.data[(self.rows.index(y as isize) * 2 + parity) * self.half..][..self.half]
    }

    /// Returns the columns of `parity` in row `y` mutably.
    fn row_mut(&mut self, y: usize, parity: usize) -> &mut [[Lanes; N]] {
        &mut self.data[(self.rows.index(y as isize) * 2 + parity) * self.half..][..self.half]
    }

    /// Fills row `y` from `N` rows of values in the usual order, padded with zeros.
    #[inline(never)]
    fn write(&mut self, y: usize, values: &[Vec<f32>; N]) {
        for parity in 0..2 {
            for (block, cells) in self.row_mut(y, parity).iter_mut().enumerate() {
                let start = 2 * LANES * block + parity;
                for (cells, values) in cells.iter_mut().zip(values) {
                    let tail = &values[start.min(values.len())..];
                    if let Some(block) = tail.first_chunk::<{ 2 * LANES - 1 }>() {
                        for k in 0..LANES {
                            cells[k] = block[2 * k];
                        }
                    } else {
                        let rest = tail.iter().step_by(2).copied().chain(iter::repeat(0.0));
                        cells.iter_mut().zip(rest).for_each(|(cell, value)| *cell = value);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Plane, sample_bilinear};
    use crate::rng::Rng;

    fn noise(width: usize, height: usize, rng: &mut Rng) -> PaddedPlane {
        let mut plane = PaddedPlane::default();
        plane.resize(width, height);
        for y in 0..height {
            plane.row_mut(y).iter_mut().for_each(|v| *v = rng.range(0.0, 255.0) as f32);
        }
        plane.replicate_border();
        plane
    }

    /// Refines without reading the flow back: fixed-point iterations and sweeps one after another, each over the whole plane.
    fn solve_plainly(
        pair: [&PaddedPlane; 2],
        [u, v]: [&Plane<f32>; 2],
        params: &FlowParams,
        (sweeps, overrelaxation): (usize, f32),
    ) -> Refiner {
        let (width, height) = (u.width(), u.height());
        let mut refiner = Refiner::default();
        refiner.resize(width, height, RowBuffer::of_all(height));
        refiner.warp_back(pair[0], pair[1], u, v);
        refiner.differentiate();
        (0..height).for_each(|y| refiner.u.write(y, u.row(y)));
        (0..height).for_each(|y| refiner.v.write(y, v.row(y)));
        (0..height).for_each(|y| refiner.compute_terms(y, u, v));
        refiner.edge_down.clear_above();
        for _ in 0..params.fixed_points {
            (0..height).for_each(|y| refiner.compute_edge_weights(y, height, params.smoothness));
            (0..height).for_each(|y| refiner.set_up_equations(y));
            for _ in 0..sweeps {
                (0..height).for_each(|y| refiner.relax(y, y % 2, overrelaxation));
                (0..height).for_each(|y| refiner.relax(y, 1 - y % 2, overrelaxation));
            }
        }
        refiner
    }

    #[test]
    fn the_wavefront_gives_the_bits_of_one_sweep_after_another() {
        let mut rng = Rng::for_stage(2, "refine");
        let mut wavefront = Refiner::default();
        // The wavefront is shorter than the last two planes, which use the same rows one after the other.
        for (width, height) in [(1, 1), (7, 5), (12, 9), (5, 30), (9, 80), (9, 97)] {
            let (from, to) = (noise(width, height, &mut rng), noise(width, height, &mut rng));
            let flow = Plane::from_fn(width, height, |_, _| rng.range(-2.0, 2.0) as f32);
            let params = FlowParams { fixed_points: 3, ..FlowParams::default() };
            let plain = solve_plainly([&from, &to], [&flow, &flow], &params, (NUM_SWEEPS, OVERRELAXATION));
            wavefront.refine(&from, &to, &mut flow.clone(), &mut flow.clone(), &params);
            for (y, parity) in (0..height as isize).flat_map(|y| [(y, 0), (y, 1)]) {
                assert_eq!(plain.u.row(y, parity), wavefront.u.row(y, parity), "{width}x{height}");
                assert_eq!(plain.v.row(y, parity), wavefront.v.row(y, parity), "{width}x{height}");
            }
        }
    }

    #[test]
    fn many_sweeps_solve_the_linear_system() {
        let mut rng = Rng::for_stage(3, "refine");
        let (width, height) = (9, 8);
        let (from, to) = (noise(width, height, &mut rng), noise(width, height, &mut rng));
        let flow = [0, 1].map(|_| Plane::from_fn(width, height, |_, _| rng.range(-1.0, 1.0) as f32));
        let params = FlowParams { fixed_points: 1, ..FlowParams::default() };
        let mut refiner = solve_plainly([&from, &to], flow.each_ref(), &params, (64, 1.5));
        let before = refiner.u.clone();
        (0..height).for_each(|y| refiner.relax(y, y % 2, 1.0));
        (0..height).for_each(|y| refiner.relax(y, 1 - y % 2, 1.0));
        for (y, parity) in (0..height as isize).flat_map(|y| [(y, 0), (y, 1)]) {
            let [a, b] = [&before, &refiner.u].map(|plane| plane.row(y, parity).as_flattened());
            for (a, b) in a.iter().zip(b) {
                assert!((a - b).abs() < 1e-3, "one more sweep moves {a} to {b}");
            }
        }
    }

    #[test]
    fn warping_agrees_with_sampling_pixel_by_pixel() {
        let mut rng = Rng::for_stage(4, "warp");
        let plane = Plane::from_fn(23, 9, |_, _| rng.range(0.0, 255.0) as f32);
        let mut image = PaddedPlane::default();
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

    #[test]
    fn rows_return_as_written_and_neighbours_are_the_four_beside_a_pixel() {
        for (width, height) in [(7, 3), (8, 4), (1, 1), (2, 1)] {
            let value = |x: usize, y: usize| (1 + x + 100 * y) as f32;
            let mut plane = Checkerboard::default();
            plane.resize(width, RowBuffer::of_all(height));
            for y in 0..height {
                plane.write(y, &(0..width).map(|x| value(x, y)).collect::<Vec<_>>());
            }
            let mut row = vec![0.0; width];
            for y in 0..height {
                plane.read(y, &mut row);
                assert_eq!(row, (0..width).map(|x| value(x, y)).collect::<Vec<_>>());
            }
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                let (neighbours, centre) = plane.row_and_neighbours(y, x % 2);
                assert_eq!(centre.as_flattened()[x / 2], value(x, y));
                let at = |cells: &[Lanes]| cells.as_flattened()[x / 2];
                let expected = |inside: bool, v: f32| if inside { v } else { 0.0 };
                let (left, right) = (neighbours.beside[x / 2], neighbours.beside[x / 2 + 1]);
                assert_eq!(left, expected(x > 0, value(x, y) - 1.0));
                assert_eq!(right, expected(x + 1 < width, value(x, y) + 1.0));
                assert_eq!(at(neighbours.up), expected(y > 0, value(x, y) - 100.0));
                assert_eq!(at(neighbours.down), expected(y + 1 < height, value(x, y) + 100.0));
                assert_eq!(
                    (at(plane.left_of(y as isize, x % 2)), at(plane.right_of(y as isize, x % 2))),
                    (left, right)
                );
            }
        }
    }
}
