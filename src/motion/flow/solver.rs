//! Variational refinement: bends the flow until brightness and its slopes agree between the frames and the flow is
//! smooth.
//!
//! Minimises, over the whole field `(u, v)`, the sum over pixels of `delta psi(E_I) + gamma psi(E_G) + alpha psi(E_S)`
//! with `psi(s^2) = sqrt(s^2 + epsilon^2)`: constancy of brightness (`delta`, [`BRIGHTNESS_WEIGHT`]), constancy of its
//! slopes (`gamma`, [`SLOPE_WEIGHT`]; Brox, Bruhn, Papenberg and Weickert, ECCV 2004), each term divided by the length
//! of its own gradient so that it is a distance in pixels (Zimmer, Bruhn and Weickert, IJCV 2011), and smoothness
//! (`alpha`, `smoothness`).
//!
//! 1. The second frame is warped back by the flow; what follows uses the mean of both frames and their difference.
//! 2. From these come the derivatives of the linearised terms. Where the flow leads outside the frame they are zero:
//!    only smoothness acts there.
//! 3. Each fixed point freezes the robust weights, which leaves a linear system of two equations a pixel.
//! 4. Red-black successive over-relaxation solves it, `u` and `v` of a pixel together.
//!
//! **Deviation** from DIS: the unknown is the flow itself, not an increment, which saves two planes; the constant that
//! softens the smoothness term is larger (`SMOOTH_EPSILON_SQ`).
//!
//! **Order of work.** Steps 3 and 4 run as one wavefront down the rows: sweep `s` two rows behind sweep `s - 1`, fixed
//! point `k` behind the last sweep of `k - 1`. The numbers are those of one pass after another, but a row is still in
//! the cache when it is needed again, and of what only the wavefront looks at no more rows are held than it is long.
//! Cost: about 100 operations a pixel and fixed point, 20 more a sweep. Memory: 32 bytes a pixel, and 64 a pixel of the
//! wavefront's rows.

use super::params::FlowParams;
use super::pyramid::{PAD, Padded};
use crate::image::Plane;
use std::iter;
use wide::{CmpGt, f32x8};

/// Weight of constant brightness.
const BRIGHTNESS_WEIGHT: f32 = 5.0;
/// Weight of constant slopes of brightness; it copes with changing light.
const SLOPE_WEIGHT: f32 = 10.0;
/// Sweeps of the solver for each fixed point.
const SWEEPS: usize = 5;
/// Over-relaxation of the sweeps, 1 to 2.
const OVERRELAXATION: f32 = 1.9;
/// Softens the robust function of the data terms near zero, in pixels, squared.
const DATA_EPSILON_SQ: f32 = 0.01 * 0.01;
/// Softens the same function of the smoothness term, in pixels per pixel, squared. Smaller makes steps of flat pieces out
/// of slopes (more pixels exceed the tracker's limit on flow gradients), larger rounds the borders of objects.
const SMOOTH_EPSILON_SQ: f32 = 0.03 * 0.03;
/// Keeps the division by a gradient's length away from zero where the image is flat (grey levels per pixel, squared).
const ZETA_SQ: f32 = 0.1 * 0.1;
/// Stiffness of a pixel with neither texture nor neighbours, so that its equations have a solution.
const LEAST_STIFFNESS: f32 = 1e-5;
/// Least determinant of a pixel's matrix as a share of its diagonal's product; less would be rounding error only.
const LEAST_DETERMINANT: f32 = 1e-6;

/// Working planes of the refinement.
#[derive(Debug, Clone, Default)]
pub(super) struct Refiner {
    mean: Padded,
    difference: Padded,
    slope_x: Padded,
    slope_y: Padded,
    warp: WarpRow,
    inside: Vec<f32>,
    /// A row of each of the terms.
    rows: [Vec<f32>; 9],
    /// Of brightness, its slope across and its slope down: the coefficients `a, b, c` of the term `a u + b v + c`.
    terms: Bundle<9>,
    u: Checkerboard,
    v: Checkerboard,
    /// Inverse of each pixel's symmetric 2 x 2 matrix (three entries) and its right-hand side (two).
    system: Bundle<5>,
    /// Smoothness weight of the edge to the right and of the edge below.
    edge_right: Checkerboard,
    edge_down: Checkerboard,
}

impl Refiner {
    /// Refines the flow `(u, v)` from `from` to `to` in place.
    pub(super) fn refine(
        &mut self,
        from: &Padded,
        to: &Padded,
        u: &mut Plane<f32>,
        v: &mut Plane<f32>,
        params: &FlowParams,
    ) {
        self.resize(from.width, from.height, Rows::last(wavefront(params) + 2, from.height));
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

    /// Holds these `rows` of what only the wavefront looks at.
    fn resize(&mut self, width: usize, height: usize, rows: Rows) {
        for plane in [&mut self.mean, &mut self.difference, &mut self.slope_x, &mut self.slope_y] {
            plane.resize(width, height);
        }
        let Self { terms, u, v, system, edge_right, edge_down, .. } = self;
        for plane in [u, v] {
            plane.hold(width, Rows::all(height));
        }
        for plane in [edge_right, edge_down] {
            plane.hold(width, rows);
        }
        terms.hold(width, rows);
        system.hold(width, rows);
        self.rows.iter_mut().for_each(|row| row.resize(width, 0.0));
        self.inside.resize(width * height, 0.0);
    }

    /// Step 1: mean and difference of the first frame and the warped second one; where the flow leads outside, `inside`
    /// is 0.
    fn warp_back(&mut self, from: &Padded, to: &Padded, u: &Plane<f32>, v: &Plane<f32>) {
        for (y, inside) in self.inside.chunks_exact_mut(from.width).enumerate() {
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

    /// Step 2: slopes of the mean.
    fn differentiate(&mut self) {
        for y in 0..self.mean.height {
            slope_across(&self.mean, y, self.slope_x.row_mut(y));
            slope_down(&self.mean, y, self.slope_y.row_mut(y));
        }
        self.slope_x.replicate_border();
        self.slope_y.replicate_border();
    }

    /// Step 2 in row `y`: the three terms, linear around the flow so far.
    #[inline(never)]
    fn take_terms(&mut self, y: usize, u: &Plane<f32>, v: &Plane<f32>) {
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

    /// Steps 3 and 4 as one wavefront. Red are the pixels whose column and row have an even sum; black runs one row
    /// behind red. Row `y` gets its equations when no sweep has touched row `y` or `y + 1` yet, which [`LAG`] rows
    /// grant. `u` and `v` are the flow before.
    fn solve(&mut self, u: &Plane<f32>, v: &Plane<f32>, params: &FlowParams) {
        let height = self.mean.height;
        let fixed_points = params.fixed_points as usize;
        self.edge_down.clear_above();
        for front in 0..height + fixed_points * LAG {
            for fixed_point in 0..fixed_points {
                let Some(first) = front.checked_sub(fixed_point * LAG) else { break };
                if first < height {
                    if fixed_point == 0 {
                        self.take_terms(first, u, v);
                    }
                    self.weigh_edges(first, height, params.smoothness);
                    self.set_up(first);
                }
                for sweep in 0..SWEEPS {
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

    /// Step 3a: weights of the edges to the right of and below row `y`; none crosses the border.
    fn weigh_edges(&mut self, y: usize, height: usize, smoothness: f32) {
        let row = y as isize;
        for parity in 0..2 {
            let [here, right, below] = [
                [self.u.row(row, parity), self.v.row(row, parity)],
                [self.u.right_of(row, parity), self.v.right_of(row, parity)],
                [self.u.row(row + 1, parity), self.v.row(row + 1, parity)],
            ];
            let (edge_right, edge_down) = (self.edge_right.row_mut(y, parity), self.edge_down.row_mut(y, parity));
            smoothness_weights(edge_right, edge_down, here, right, below, smoothness);
            if y + 1 == height {
                edge_down.fill([0.0; LANES]);
            }
            self.edge_right.beyond_right(y, parity).fill(0.0);
        }
    }

    /// Step 3b: the equations of each pixel of row `y`, solved for that pixel.
    fn set_up(&mut self, y: usize) {
        let row = y as isize;
        for parity in 0..2 {
            let flow = [self.u.row(row, parity), self.v.row(row, parity)];
            let edges = edges(&self.edge_right, &self.edge_down, y, parity);
            equations(self.system.row_mut(y, parity), self.terms.row(y, parity), flow, edges);
        }
    }

    /// Step 4: one step of over-relaxation for the pixels of one colour in row `y`.
    fn relax(&mut self, y: usize, parity: usize, overrelaxation: f32) {
        let (around_u, u) = self.u.around_mut(y, parity);
        let (around_v, v) = self.v.around_mut(y, parity);
        let edges = edges(&self.edge_right, &self.edge_down, y, parity);
        relax_row(u, v, [around_u, around_v], edges, self.system.row(y, parity), overrelaxation);
    }
}

/// Rows that a fixed point is behind the one before it.
const LAG: usize = 2 * SWEEPS + 1;

/// Rows from the first that still changes to the last that has begun to.
fn wavefront(params: &FlowParams) -> usize {
    params.fixed_points as usize * LAG
}

/// Weights of the four edges of each pixel of a half row.
fn edges<'a>(edge_right: &'a Checkerboard, edge_down: &'a Checkerboard, y: usize, parity: usize) -> Around<'a> {
    let row = y as isize;
    Around {
        left: edge_right.left_of(row, parity),
        right: edge_right.row(row, parity),
        up: edge_down.row(row - 1, parity),
        down: edge_down.row(row, parity),
    }
}

// The loops below are functions of their own, not inlined: their arguments tell the compiler that what they write does
// not overlap what they read. Eight numbers at a time, so that one address serves for more than one instruction.

#[inline(always)]
fn load(lanes: &Lanes) -> f32x8 {
    f32x8::new(*lanes)
}

/// `alpha / (2 |gradient of the flow|)`, from forward differences, for both edges of each pixel.
#[inline(never)]
fn smoothness_weights(
    edge_right: &mut [Lanes],
    edge_down: &mut [Lanes],
    here: [&[Lanes]; 2],
    right: [&[Lanes]; 2],
    below: [&[Lanes]; 2],
    smoothness: f32,
) {
    let n = edge_right.len();
    let edge_down = &mut edge_down[..n];
    let ([u, v], [ur, vr], [ud, vd]) = (here.map(|s| &s[..n]), right.map(|s| &s[..n]), below.map(|s| &s[..n]));
    let (half, softening) = (f32x8::splat(0.5 * smoothness), f32x8::splat(SMOOTH_EPSILON_SQ));
    for i in 0..n {
        let (u, v) = (load(&u[i]), load(&v[i]));
        let (ux, vx) = (load(&ur[i]) - u, load(&vr[i]) - v);
        let (uy, vy) = (load(&ud[i]) - u, load(&vd[i]) - v);
        let weight = half / (ux * ux + vx * vx + uy * uy + vy * vy + softening).sqrt();
        edge_right[i] = weight.to_array();
        edge_down[i] = weight.to_array();
    }
}

/// Robust weights of the data terms at the present flow, and from them matrix and right-hand side of each pixel.
#[inline(never)]
fn equations(system: &mut [[Lanes; 5]], terms: &[[Lanes; 9]], flow: [&[Lanes]; 2], edges: Around<'_>) {
    let n = system.len();
    let ([u, v], terms) = (flow.map(|s| &s[..n]), &terms[..n]);
    let [el, er, eu, ed] = [edges.left, edges.right, edges.up, edges.down].map(|s| &s[..n]);
    let [brightness_weight, slope_weight] = [BRIGHTNESS_WEIGHT, SLOPE_WEIGHT].map(|w| f32x8::splat(0.5 * w));
    let [softening, stiffness, least] = [DATA_EPSILON_SQ, LEAST_STIFFNESS, LEAST_DETERMINANT].map(f32x8::splat);
    for i in 0..n {
        let (u, v) = (load(&u[i]), load(&v[i]));
        let [x, y, z, xx, xy, xz, yx, yy, yz] = &terms[i];
        let (x, y, z) = (load(x), load(y), load(z));
        let (xx, xy, xz) = (load(xx), load(xy), load(xz));
        let (yx, yy, yz) = (load(yx), load(yy), load(yz));
        let brightness = z + x * u + y * v;
        let slope_x = xz + xx * u + xy * v;
        let slope_y = yz + yx * u + yy * v;
        let w = brightness_weight / (brightness * brightness + softening).sqrt();
        let s = slope_weight / (slope_x * slope_x + slope_y * slope_y + softening).sqrt();
        let smooth = (load(&el[i]) + load(&er[i])) + (load(&eu[i]) + load(&ed[i])) + stiffness;
        let a11 = w * (x * x) + s * (xx * xx + yx * yx) + smooth;
        let a22 = w * (y * y) + s * (xy * xy + yy * yy) + smooth;
        let a12 = w * (x * y) + s * (xx * xy + yx * yy);
        let (determinant, least) = (a11 * a22 - a12 * a12, least * (a11 * a22));
        // Where it is no number, the least.
        let inverse = f32x8::ONE / determinant.cmp_gt(least).blend(determinant, least);
        let b1 = -(w * (z * x) + s * (xz * xx + yz * yx));
        let b2 = -(w * (z * y) + s * (xz * xy + yz * yy));
        let [m11, m12, m22, r1, r2] = &mut system[i];
        *m11 = (a22 * inverse).to_array();
        *m12 = (-a12 * inverse).to_array();
        *m22 = (a11 * inverse).to_array();
        *r1 = b1.to_array();
        *r2 = b2.to_array();
    }
}

#[inline(never)]
fn relax_row(
    u: &mut [Lanes],
    v: &mut [Lanes],
    around: [Around<'_>; 2],
    edges: Around<'_>,
    system: &[[Lanes; 5]],
    overrelaxation: f32,
) {
    let n = u.len();
    let (v, system) = (&mut v[..n], &system[..n]);
    let [ul, ur, uu, ud] = [around[0].left, around[0].right, around[0].up, around[0].down].map(|s| &s[..n]);
    let [vl, vr, vu, vd] = [around[1].left, around[1].right, around[1].up, around[1].down].map(|s| &s[..n]);
    let [el, er, eu, ed] = [edges.left, edges.right, edges.up, edges.down].map(|s| &s[..n]);
    let overrelaxation = f32x8::splat(overrelaxation);
    for i in 0..n {
        let [m11, m12, m22, b1, b2] = &system[i];
        let (el, er, eu, ed) = (load(&el[i]), load(&er[i]), load(&eu[i]), load(&ed[i]));
        let r1 = load(b1) + (el * load(&ul[i]) + er * load(&ur[i])) + (eu * load(&uu[i]) + ed * load(&ud[i]));
        let r2 = load(b2) + (el * load(&vl[i]) + er * load(&vr[i])) + (eu * load(&vu[i]) + ed * load(&vd[i]));
        let (m11, m12, m22) = (load(m11), load(m12), load(m22));
        let (u0, v0) = (load(&u[i]), load(&v[i]));
        u[i] = (u0 + overrelaxation * (m11 * r1 + m12 * r2 - u0)).to_array();
        v[i] = (v0 + overrelaxation * (m12 * r1 + m22 * r2 - v0)).to_array();
    }
}

/// Turns `(a, b, c)` of a term `a (u - u0) + b (v - v0) + c` into the same of `a u + b v + c`, divided by the length of
/// `(a, b)`; into zeros where the flow leads outside.
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

/// Central differences along row `y`, exact for polynomials of fourth degree.
#[inline(never)]
fn slope_across(plane: &Padded, y: usize, out: &mut [f32]) {
    let row = plane.padded_row(y as isize);
    five_taps(out, [PAD - 2, PAD - 1, PAD + 1, PAD + 2].map(|start| &row[start..]));
}

/// Central differences down the columns at row `y`.
#[inline(never)]
fn slope_down(plane: &Padded, y: usize, out: &mut [f32]) {
    five_taps(out, [-2, -1, 1, 2].map(|k| &plane.padded_row(y as isize + k)[PAD..]));
}

#[inline(never)]
fn five_taps(out: &mut [f32], taps: [&[f32]; 4]) {
    let n = out.len();
    let [a, b, c, d] = taps.map(|s| &s[..n]);
    for i in 0..n {
        out[i] = (2.0 / 3.0) * (c[i] - b[i]) - (1.0 / 12.0) * (d[i] - a[i]);
    }
}

// The second frame warped back onto the first, a row at a time.

/// Bilinear warping in three loops: positions in vector code, the gather, the blend in vector code.
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

// A plane stored for checkerboard sweeps: each row as its even columns, then its odd ones.
//
// ```text
// row y:  | margin  x=0  x=2  x=4 .. margin | margin  x=1  x=3  x=5 .. margin |
// ```
//
// All pixels of one colour in a row are then neighbours in memory, and so are the pixels to the left of them, to the
// right, above and below: a sweep over one colour is a loop over slices of equal length, [`LANES`] numbers at a time.

/// Numbers that a kernel takes at a time; the cells of a half row are a multiple of it.
const LANES: usize = 8;
/// These numbers.
type Lanes = [f32; LANES];

/// Empty cells before and after each half row.
const MARGIN: usize = 1;

/// A plane in the order above, with one empty row above and below; or as many rows of it as are needed at a time, each in
/// the place of one that is needed no more.
///
/// Law: margins, the rows outside, and the cells beyond the width are zero; a solver that gives them no equation and no
/// edge leaves them so.
#[derive(Debug, Clone, Default)]
struct Checkerboard {
    data: Vec<f32>,
    width: usize,
    rows: Rows,
    /// Cells of a half row, margins included.
    half: usize,
}

/// The four neighbours of each pixel of a half row, [`LANES`] at a time.
#[derive(Debug, Clone, Copy)]
struct Around<'a> {
    left: &'a [Lanes],
    right: &'a [Lanes],
    up: &'a [Lanes],
    down: &'a [Lanes],
}

// Called once a row: copies of them wherever they are called would only make the file larger.
impl Checkerboard {
    /// Gives the plane this width, and room for these `rows`. A plane that has both already keeps its values.
    #[inline(never)]
    fn hold(&mut self, width: usize, rows: Rows) {
        if (self.width, self.rows) != (width, rows) {
            let half = blocks(width) * LANES + 2 * MARGIN;
            (self.width, self.rows, self.half) = (width, rows, half);
            self.data.clear();
            self.data.resize(2 * half * rows.held, 0.0);
        }
    }

    /// The columns of `parity` in row `y`, which counts from -1.
    #[inline(never)]
    fn row(&self, y: isize, parity: usize) -> &[Lanes] {
        self.cells(self.start(y, parity))
    }

    /// The same, to write.
    #[inline(never)]
    fn row_mut(&mut self, y: usize, parity: usize) -> &mut [Lanes] {
        let (start, cells) = (self.start(y as isize, parity), self.half - 2 * MARGIN);
        self.data[start..][..cells].as_chunks_mut().0
    }

    /// The pixels to the left of those of `parity`. Even pixel `k` has the odd `k - 1` there, odd pixel `k` the even
    /// `k`.
    #[inline(never)]
    fn left_of(&self, y: isize, parity: usize) -> &[Lanes] {
        self.cells(self.start(y, 1 - parity) + parity - 1)
    }

    /// The pixels to the right of those of `parity`.
    #[inline(never)]
    fn right_of(&self, y: isize, parity: usize) -> &[Lanes] {
        self.cells(self.start(y, 1 - parity) + parity)
    }

    /// The columns of `parity` in row `y` to write, and their neighbours, in a plane that holds all rows.
    #[inline(never)]
    fn around_mut(&mut self, y: usize, parity: usize) -> (Around<'_>, &mut [Lanes]) {
        let (half, cells) = (self.half, self.half - 2 * MARGIN);
        let (above, rest) = self.data.split_at_mut((y + 1) * 2 * half);
        let (here, below) = rest.split_at_mut(2 * half);
        let (even, odd) = here.split_at_mut(half);
        let (own, other) = if parity == 0 { (even, odd) } else { (odd, even) };
        let around = Around {
            left: other[MARGIN + parity - 1..][..cells].as_chunks().0,
            right: other[MARGIN + parity..][..cells].as_chunks().0,
            up: above[y * 2 * half + parity * half + MARGIN..][..cells].as_chunks().0,
            down: below[parity * half + MARGIN..][..cells].as_chunks().0,
        };
        (around, own[MARGIN..][..cells].as_chunks_mut().0)
    }

    /// The cells of `parity` in row `y` from the first that has no right neighbour on.
    fn beyond_right(&mut self, y: usize, parity: usize) -> &mut [f32] {
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

    /// Row `y` in the usual order.
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

    /// The row above the first becomes zero again.
    fn clear_above(&mut self) {
        self.data[..2 * self.half].fill(0.0);
    }

    fn cells(&self, start: usize) -> &[Lanes] {
        self.data[start..][..self.half - 2 * MARGIN].as_chunks().0
    }

    fn start(&self, y: isize, parity: usize) -> usize {
        (self.rows.place(y) * 2 + parity) * self.half + MARGIN
    }
}

/// Blocks of [`LANES`] pixels of one colour in a row.
fn blocks(width: usize) -> usize {
    width.div_ceil(2).div_ceil(LANES)
}

/// Which rows of a plane are held, those above the first and below the last counted.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Rows {
    held: usize,
    /// Row `y` lies at `y + 1`, of which these bits count: a division would cost as much as half of a row's sweep.
    mask: usize,
}

impl Rows {
    /// All of a plane.
    fn all(height: usize) -> Self {
        Self { held: height + 2, mask: usize::MAX }
    }

    /// At least the last `rows` of a plane.
    fn last(rows: usize, height: usize) -> Self {
        let held = rows.next_power_of_two();
        if held < height + 2 { Self { held, mask: held - 1 } } else { Self::all(height) }
    }

    fn place(self, y: isize) -> usize {
        (y + 1) as usize & self.mask
    }
}

/// `N` numbers a pixel in the same order, [`LANES`] pixels of one and then of the next: they are always read together, and
/// one address serves all.
#[derive(Debug, Clone)]
struct Bundle<const N: usize> {
    data: Vec<[Lanes; N]>,
    rows: Rows,
    half: usize,
}

impl<const N: usize> Default for Bundle<N> {
    fn default() -> Self {
        Self { data: Vec::new(), rows: Rows::default(), half: 0 }
    }
}

impl<const N: usize> Bundle<N> {
    /// Gives the bundle this width, and room for these `rows`. A bundle that has both already keeps its values.
    fn hold(&mut self, width: usize, rows: Rows) {
        let half = blocks(width);
        if (self.half, self.rows) != (half, rows) {
            (self.half, self.rows) = (half, rows);
            self.data.clear();
            self.data.resize(2 * half * rows.held, [[0.0; LANES]; N]);
        }
    }

    /// The columns of `parity` in row `y`.
    fn row(&self, y: usize, parity: usize) -> &[[Lanes; N]] {
        &self.data[(self.rows.place(y as isize) * 2 + parity) * self.half..][..self.half]
    }

    /// The same, to write.
    fn row_mut(&mut self, y: usize, parity: usize) -> &mut [[Lanes; N]] {
        &mut self.data[(self.rows.place(y as isize) * 2 + parity) * self.half..][..self.half]
    }

    /// Fills row `y` from `N` rows of values in the usual order; the cells beyond their length become zero.
    #[inline(never)]
    fn write(&mut self, y: usize, values: &[Vec<f32>; N]) {
        for parity in 0..2 {
            for (block, cells) in self.row_mut(y, parity).iter_mut().enumerate() {
                let start = 2 * LANES * block + parity;
                for (cells, values) in cells.iter_mut().zip(values) {
                    let part = &values[start.min(values.len())..];
                    if let Some(part) = part.first_chunk::<{ 2 * LANES - 1 }>() {
                        for k in 0..LANES {
                            cells[k] = part[2 * k];
                        }
                    } else {
                        let rest = part.iter().step_by(2).copied().chain(iter::repeat(0.0));
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

    fn noise(width: usize, height: usize, rng: &mut Rng) -> Padded {
        let mut plane = Padded::default();
        plane.resize(width, height);
        for y in 0..height {
            plane.row_mut(y).iter_mut().for_each(|v| *v = rng.range(0.0, 255.0) as f32);
        }
        plane.replicate_border();
        plane
    }

    /// All of the refinement but reading the flow back: fixed points and sweeps one after another, each over the whole
    /// plane.
    fn solve_plainly(
        pair: [&Padded; 2],
        [u, v]: [&Plane<f32>; 2],
        params: &FlowParams,
        (sweeps, overrelaxation): (usize, f32),
    ) -> Refiner {
        let (width, height) = (u.width(), u.height());
        let mut refiner = Refiner::default();
        refiner.resize(width, height, Rows::all(height));
        refiner.warp_back(pair[0], pair[1], u, v);
        refiner.differentiate();
        (0..height).for_each(|y| refiner.u.write(y, u.row(y)));
        (0..height).for_each(|y| refiner.v.write(y, v.row(y)));
        (0..height).for_each(|y| refiner.take_terms(y, u, v));
        refiner.edge_down.clear_above();
        for _ in 0..params.fixed_points {
            (0..height).for_each(|y| refiner.weigh_edges(y, height, params.smoothness));
            (0..height).for_each(|y| refiner.set_up(y));
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
        // Of the last two the wavefront holds a part at a time, one after the other in the same rows.
        for (width, height) in [(1, 1), (7, 5), (12, 9), (5, 30), (9, 80), (9, 97)] {
            let (from, to) = (noise(width, height, &mut rng), noise(width, height, &mut rng));
            let flow = Plane::from_fn(width, height, |_, _| rng.range(-2.0, 2.0) as f32);
            let params = FlowParams { fixed_points: 3, ..FlowParams::default() };
            let plain = solve_plainly([&from, &to], [&flow, &flow], &params, (SWEEPS, OVERRELAXATION));
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

    #[test]
    fn rows_return_as_written_and_neighbours_are_the_four_beside_a_pixel() {
        for (width, height) in [(7, 3), (8, 4), (1, 1), (2, 1)] {
            let value = |x: usize, y: usize| (1 + x + 100 * y) as f32;
            let mut plane = Checkerboard::default();
            plane.hold(width, Rows::all(height));
            for y in 0..height {
                plane.write(y, &(0..width).map(|x| value(x, y)).collect::<Vec<_>>());
            }
            let mut row = vec![0.0; width];
            for y in 0..height {
                plane.read(y, &mut row);
                assert_eq!(row, (0..width).map(|x| value(x, y)).collect::<Vec<_>>());
            }
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                let (around, own) = plane.around_mut(y, x % 2);
                assert_eq!(own.as_flattened()[x / 2], value(x, y));
                let at = |cells: &[Lanes]| cells.as_flattened()[x / 2];
                let expected = |inside: bool, v: f32| if inside { v } else { 0.0 };
                assert_eq!(at(around.left), expected(x > 0, value(x, y) - 1.0));
                assert_eq!(at(around.right), expected(x + 1 < width, value(x, y) + 1.0));
                assert_eq!(at(around.up), expected(y > 0, value(x, y) - 100.0));
                assert_eq!(at(around.down), expected(y + 1 < height, value(x, y) + 100.0));
                let beside = (at(around.left), at(around.right));
                assert_eq!((at(plane.left_of(y as isize, x % 2)), at(plane.right_of(y as isize, x % 2))), beside);
            }
        }
    }
}
