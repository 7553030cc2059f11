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

use super::checkerboard::{Around, Checkerboard};
use super::params::FlowParams;
use super::pyramid::{PAD, Padded};
use super::warp::WarpRow;
use crate::image::Plane;

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
    terms: [Checkerboard; 9],
    u: Checkerboard,
    v: Checkerboard,
    /// Inverse of each pixel's symmetric 2 x 2 matrix (three entries) and its right-hand side (two).
    system: [Checkerboard; 5],
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
        self.resize(from.width, from.height, wavefront(params) + 2);
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

    /// Holds this number of `rows` of what only the wavefront looks at.
    fn resize(&mut self, width: usize, height: usize, rows: usize) {
        for plane in [&mut self.mean, &mut self.difference, &mut self.slope_x, &mut self.slope_y] {
            plane.resize(width, height);
        }
        let Self { terms, u, v, system, edge_right, edge_down, .. } = self;
        for plane in [u, v] {
            plane.resize(width, height);
        }
        for plane in terms.iter_mut().chain([edge_right, edge_down]).chain(system) {
            plane.hold(width, rows.min(height + 2));
        }
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
        for (row, plane) in self.rows.iter().zip(&mut self.terms) {
            plane.write(y, row);
        }
    }

    /// Steps 3 and 4 as one wavefront. Red are the pixels whose column and row have an even sum; black runs one row
    /// behind red. Row `y` gets its equations when no sweep has touched row `y` or `y + 1` yet, which [`LAG`] rows
    /// grant. `u` and `v` are the flow before.
    fn solve(&mut self, u: &Plane<f32>, v: &Plane<f32>, params: &FlowParams) {
        let (width, height) = (self.mean.width, self.mean.height);
        let fixed_points = params.fixed_points as usize;
        self.edge_down.clear_above();
        for front in 0..height + fixed_points * LAG {
            for fixed_point in 0..fixed_points {
                let Some(first) = front.checked_sub(fixed_point * LAG) else { break };
                if first < height {
                    if fixed_point == 0 {
                        self.take_terms(first, u, v);
                    }
                    self.weigh_edges(first, width, height, params.smoothness);
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
    fn weigh_edges(&mut self, y: usize, width: usize, height: usize, smoothness: f32) {
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
                edge_down.fill(0.0);
            }
            // From the last column on there is no right neighbour.
            edge_right[(width - parity) / 2..].fill(0.0);
        }
    }

    /// Step 3b: the equations of each pixel of row `y`, solved for that pixel.
    fn set_up(&mut self, y: usize) {
        let row = y as isize;
        for parity in 0..2 {
            let terms = self.terms.each_ref().map(|plane| plane.row(row, parity));
            let flow = [self.u.row(row, parity), self.v.row(row, parity)];
            let edges = edges(&self.edge_right, &self.edge_down, y, parity);
            let system = self.system.each_mut().map(|plane| plane.row_mut(y, parity));
            equations(system, terms, flow, edges);
        }
    }

    /// Step 4: one step of over-relaxation for the pixels of one colour in row `y`.
    fn relax(&mut self, y: usize, parity: usize, overrelaxation: f32) {
        let (around_u, u) = self.u.around_mut(y, parity);
        let (around_v, v) = self.v.around_mut(y, parity);
        let edges = edges(&self.edge_right, &self.edge_down, y, parity);
        let system = self.system.each_ref().map(|plane| plane.row(y as isize, parity));
        relax_row(u, v, [around_u, around_v], edges, system, overrelaxation);
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
// not overlap what they read, and each becomes vector instructions.

/// `alpha / (2 |gradient of the flow|)`, from forward differences, for both edges of each pixel.
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
        let (ux, vx, uy, vy) = (ur[i] - u[i], vr[i] - v[i], ud[i] - u[i], vd[i] - v[i]);
        let weight = 0.5 * smoothness / (ux * ux + vx * vx + uy * uy + vy * vy + SMOOTH_EPSILON_SQ).sqrt();
        edge_right[i] = weight;
        edge_down[i] = weight;
    }
}

/// Robust weights of the data terms at the present flow, and from them matrix and right-hand side of each pixel.
#[inline(never)]
fn equations(system: [&mut [f32]; 5], terms: [&[f32]; 9], flow: [&[f32]; 2], edges: Around<'_>) {
    let n = flow[0].len();
    let [u, v] = flow.map(|s| &s[..n]);
    let [m11, m12, m22, b1, b2] = system.map(|s| &mut s[..n]);
    let [x, y, z, xx, xy, xz, yx, yy, yz] = terms.map(|s| &s[..n]);
    let [el, er, eu, ed] = [edges.left, edges.right, edges.up, edges.down].map(|s| &s[..n]);
    for i in 0..n {
        let brightness = z[i] + x[i] * u[i] + y[i] * v[i];
        let slope_x = xz[i] + xx[i] * u[i] + xy[i] * v[i];
        let slope_y = yz[i] + yx[i] * u[i] + yy[i] * v[i];
        let w = 0.5 * BRIGHTNESS_WEIGHT / (brightness * brightness + DATA_EPSILON_SQ).sqrt();
        let s = 0.5 * SLOPE_WEIGHT / (slope_x * slope_x + slope_y * slope_y + DATA_EPSILON_SQ).sqrt();
        let smooth = (el[i] + er[i]) + (eu[i] + ed[i]) + LEAST_STIFFNESS;
        let a11 = w * (x[i] * x[i]) + s * (xx[i] * xx[i] + yx[i] * yx[i]) + smooth;
        let a22 = w * (y[i] * y[i]) + s * (xy[i] * xy[i] + yy[i] * yy[i]) + smooth;
        let a12 = w * (x[i] * y[i]) + s * (xx[i] * xy[i] + yx[i] * yy[i]);
        let (determinant, least) = (a11 * a22 - a12 * a12, LEAST_DETERMINANT * (a11 * a22));
        let inverse = 1.0 / if determinant > least { determinant } else { least };
        m11[i] = a22 * inverse;
        m12[i] = -a12 * inverse;
        m22[i] = a11 * inverse;
        b1[i] = -(w * (z[i] * x[i]) + s * (xz[i] * xx[i] + yz[i] * yx[i]));
        b2[i] = -(w * (z[i] * y[i]) + s * (xz[i] * xy[i] + yz[i] * yy[i]));
    }
}

#[inline(never)]
fn relax_row(
    u: &mut [f32],
    v: &mut [f32],
    around: [Around<'_>; 2],
    edges: Around<'_>,
    system: [&[f32]; 5],
    overrelaxation: f32,
) {
    let n = u.len();
    let v = &mut v[..n];
    let [ul, ur, uu, ud] = [around[0].left, around[0].right, around[0].up, around[0].down].map(|s| &s[..n]);
    let [vl, vr, vu, vd] = [around[1].left, around[1].right, around[1].up, around[1].down].map(|s| &s[..n]);
    let [el, er, eu, ed] = [edges.left, edges.right, edges.up, edges.down].map(|s| &s[..n]);
    let [m11, m12, m22, b1, b2] = system.map(|s| &s[..n]);
    for i in 0..n {
        let r1 = b1[i] + (el[i] * ul[i] + er[i] * ur[i]) + (eu[i] * uu[i] + ed[i] * ud[i]);
        let r2 = b2[i] + (el[i] * vl[i] + er[i] * vr[i]) + (eu[i] * vu[i] + ed[i] * vd[i]);
        u[i] += overrelaxation * (m11[i] * r1 + m12[i] * r2 - u[i]);
        v[i] += overrelaxation * (m12[i] * r1 + m22[i] * r2 - v[i]);
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

#[cfg(test)]
mod tests {
    use super::*;
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
        refiner.resize(width, height, height + 2);
        refiner.warp_back(pair[0], pair[1], u, v);
        refiner.differentiate();
        (0..height).for_each(|y| refiner.u.write(y, u.row(y)));
        (0..height).for_each(|y| refiner.v.write(y, v.row(y)));
        (0..height).for_each(|y| refiner.take_terms(y, u, v));
        refiner.edge_down.clear_above();
        for _ in 0..params.fixed_points {
            (0..height).for_each(|y| refiner.weigh_edges(y, width, height, params.smoothness));
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
            for (a, b) in before.row(y, parity).iter().zip(refiner.u.row(y, parity)) {
                assert!((a - b).abs() < 1e-3, "one more sweep moves {a} to {b}");
            }
        }
    }
}
