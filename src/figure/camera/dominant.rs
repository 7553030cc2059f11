//! Dominant motion of a frame: the camera's, if the scene behind the objects is nearly flat or far away.
//!
//! In: a flow field. Out: a [`DominantMotion`], affine or a homography, which predicts the flow of each static pixel.
//!
//! 1. The flow is sampled on a grid of at most [`MAX_SAMPLES_PER_SIDE`] points along the longer side.
//! 2. Affine motions through three random samples compete with no motion, the mean motion, and the motion of the frame
//!    before (RANSAC). The least robust cost `Σ r² / (r² + τ²)` wins (Geman and McClure; `r` is the residual in pixels):
//!    outliers all cost the same, so that the motion of the majority wins even if an object fills nearly half of the
//!    frame.
//! 3. Least squares, reweighted by the same cost, refine its six numbers, and then the eight of a homography if wanted.
//!
//! Cost: O(triples · samples), below a millisecond. It fails where an object fills most of the frame. All in `f64` with
//! sums in a fixed order; only `+ - * /`, square roots and comparisons.

use super::Homography;
use crate::flow::Field;
use crate::rng::Rng;

/// Most samples along the longer side of the frame. Chosen by eye: more change the motion by less than the flow's error.
const MAX_SAMPLES_PER_SIDE: usize = 40;

/// Triples of samples that are tried: if objects fill 60 % of the frame, one in 16 lies on the scene, and with 150 the
/// chance that none does is below 1 in 10,000.
const NUM_TRIPLES: usize = 150;

/// Most rounds of reweighted least squares for each model. Chosen by eye.
const MAX_IRLS_ROUNDS: usize = 8;

/// Largest perspective term at the frame border of a camera's motion between two frames. Chosen by eye.
const MAX_PERSPECTIVE: f64 = 0.25;

/// Least area of a triple, as twice a triangle in units of half the frame's longer side, squared. Chosen by eye.
const MIN_TRIPLE_AREA: f64 = 0.02;

/// A motion of the whole frame, affine or a homography.
///
/// In coordinates `X, Y` from the frame's centre, in halves of its longer side, a point goes to
/// `((1 + p0) X + p1 Y + p2, p3 X + (1 + p4) Y + p5) / (1 + p6 X + p7 Y)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DominantMotion {
    p: [f64; 8],
    frame: Coordinates,
}

/// Origin of a motion's coordinates, and their unit, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Coordinates {
    center: (f64, f64),
    unit: f64,
}

impl Coordinates {
    fn new(flow: &impl Field) -> Self {
        let (width, height) = flow.size();
        let (width, height) = (width as f64, height as f64);
        Self { center: (0.5 * (width - 1.0), 0.5 * (height - 1.0)), unit: 0.5 * width.max(height).max(1.0) }
    }
}

/// Model and tolerance of the fit of a dominant motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MotionFit {
    /// Fits the perspective terms of a homography, too.
    pub(crate) perspective: bool,
    /// Residual in pixels at which a point counts half.
    pub(crate) tolerance: f64,
}

/// The flow at one point, in a frame's coordinates.
#[derive(Debug, Clone, Copy)]
struct Sample {
    x: f64,
    y: f64,
    u: f64,
    v: f64,
}

impl DominantMotion {
    /// No motion, in frames of this flow's size.
    pub(crate) fn still(flow: &impl Field) -> Self {
        Self { p: [0.0; 8], frame: Coordinates::new(flow) }
    }

    /// Returns the same motion as a map of pixels.
    pub(super) fn homography(&self) -> Homography {
        let p = &self.p;
        let ((cx, cy), unit) = (self.frame.center, self.frame.unit);
        let to = Homography([1.0 / unit, 0.0, -cx / unit, 0.0, 1.0 / unit, -cy / unit, 0.0, 0.0, 1.0]);
        let from = Homography([unit, 0.0, cx, 0.0, unit, cy, 0.0, 0.0, 1.0]);
        let motion = Homography([1.0 + p[0], p[1], p[2], p[3], 1.0 + p[4], p[5], p[6], p[7], 1.0]);
        from.after(&motion.after(&to))
    }

    /// Returns the displacement of the point at `(x, y)`, in pixels.
    pub(crate) fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let (x, y) = ((x - self.frame.center.0) / self.frame.unit, (y - self.frame.center.1) / self.frame.unit);
        let (u, v) = displacement(&self.p, x, y);
        (u * self.frame.unit, v * self.frame.unit)
    }

    /// Returns the motion along row `y`, for the residuals of its pixels.
    pub(crate) fn along_row(&self, y: usize) -> RowMotion {
        let p = &self.p;
        let unit = self.frame.unit;
        let row = (y as f64 - self.frame.center.1) / unit;
        RowMotion {
            start: [p[1] * row + p[2], (1.0 + p[4]) * row + p[5], 1.0 + p[7] * row].map(|v| v as f32),
            slope: [1.0 + p[0], p[3], p[6]].map(|v| v as f32),
            center_x: self.frame.center.0 as f32,
            unit: unit as f32,
            row: row as f32,
        }
    }
}

/// A motion along a row of pixels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RowMotion {
    /// Both numerators and the denominator of the motion, linear in the column.
    start: [f32; 3],
    slope: [f32; 3],
    center_x: f32,
    unit: f32,
    row: f32,
}

impl RowMotion {
    /// Returns the distance of the flow of pixel `x` from the motion, in pixels.
    pub(crate) fn residual(&self, x: usize, flow: (f32, f32)) -> f32 {
        let Self { start, slope, center_x, unit, row } = self;
        let x = (x as f32 - center_x) / unit;
        let scale = 1.0 / (start[2] + slope[2] * x);
        let du = flow.0 - unit * ((start[0] + slope[0] * x) * scale - x);
        let dv = flow.1 - unit * ((start[1] + slope[1] * x) * scale - row);
        (du * du + dv * dv).sqrt()
    }
}

fn displacement(p: &[f64; 8], x: f64, y: f64) -> (f64, f64) {
    // Spares affine motions the division.
    let scale = if p[6] == 0.0 && p[7] == 0.0 { 1.0 } else { 1.0 / (1.0 + p[6] * x + p[7] * y) };
    (((1.0 + p[0]) * x + p[1] * y + p[2]) * scale - x, (p[3] * x + (1.0 + p[4]) * y + p[5]) * scale - y)
}

/// Fits the dominant motion of `flow`; the motion of the frame before is one of the candidates.
pub(crate) fn dominant_motion(flow: &impl Field, fit: &MotionFit, before: Option<&DominantMotion>) -> DominantMotion {
    let frame = Coordinates::new(flow);
    let samples = sample_flow(flow, &frame);
    let tau_sq = (fit.tolerance / frame.unit).powi(2);
    let mut best = choose_candidate(&samples, tau_sq, before.map(|b| b.p));
    for count in [6, 8] {
        if count == 6 || fit.perspective {
            best = refine(&samples, best, count, tau_sq);
        }
    }
    DominantMotion { p: best, frame }
}

/// Samples finite flow on a grid (step 1).
fn sample_flow(flow: &impl Field, frame: &Coordinates) -> Vec<Sample> {
    let (width, height) = flow.size();
    let step = width.max(height).div_ceil(MAX_SAMPLES_PER_SIDE).max(1);
    let positions = |side: usize| (step / 2).min(side.saturating_sub(1))..side;
    let mut samples = Vec::new();
    for y in positions(height).step_by(step) {
        for x in positions(width).step_by(step) {
            let (u, v) = flow.at(x, y);
            let (u, v) = (f64::from(u), f64::from(v));
            if !(u.is_finite() && v.is_finite()) {
                continue;
            }
            samples.push(Sample {
                x: (x as f64 - frame.center.0) / frame.unit,
                y: (y as f64 - frame.center.1) / frame.unit,
                u: u / frame.unit,
                v: v / frame.unit,
            });
        }
    }
    samples
}

/// Returns the candidate of least cost (step 2).
fn choose_candidate(samples: &[Sample], tau_sq: f64, before: Option<[f64; 8]>) -> [f64; 8] {
    let mut best = ([0.0; 8], cost(samples, &[0.0; 8], tau_sq, f64::INFINITY));
    let mut compete = |p: [f64; 8]| {
        let cost = cost(samples, &p, tau_sq, best.1);
        if cost < best.1 {
            best = (p, cost);
        }
    };
    if let Some(p) = before {
        compete(p);
    }
    compete(mean_motion(samples));
    let mut rng = Rng::for_stage(0, "dominant");
    for _ in 0..if samples.len() < 3 { 0 } else { NUM_TRIPLES } {
        let triple = [0; 3].map(|_| samples[rng.below(samples.len())]);
        if let Some(p) = affine_through(&triple) {
            compete(p);
        }
    }
    best.0
}

/// Robust cost of a motion; stops early, at any number not below `limit`, once it reaches `limit`.
fn cost(samples: &[Sample], p: &[f64; 8], tau_sq: f64, limit: f64) -> f64 {
    let mut cost = 0.0;
    for chunk in samples.chunks(64) {
        for s in chunk {
            let r_sq = residual_sq(s, p);
            cost += r_sq / (r_sq + tau_sq);
        }
        if cost >= limit {
            break;
        }
    }
    cost
}

fn residual_sq(s: &Sample, p: &[f64; 8]) -> f64 {
    let (u, v) = displacement(p, s.x, s.y);
    (s.u - u).powi(2) + (s.v - v).powi(2)
}

/// Mean of all samples, as a translation.
fn mean_motion(samples: &[Sample]) -> [f64; 8] {
    let (mut u, mut v) = (0.0, 0.0);
    for s in samples {
        u += s.u;
        v += s.v;
    }
    let mut p = [0.0; 8];
    if !samples.is_empty() {
        (p[2], p[5]) = (u / samples.len() as f64, v / samples.len() as f64);
    }
    p
}

/// Returns the affine motion through three samples, unless they lie near one line.
fn affine_through([a, b, c]: &[Sample; 3]) -> Option<[f64; 8]> {
    let (bx, by, cx, cy) = (b.x - a.x, b.y - a.y, c.x - a.x, c.y - a.y);
    let area = bx * cy - by * cx;
    if area.abs() < MIN_TRIPLE_AREA {
        return None;
    }
    let mut p = [0.0; 8];
    for (at, [fa, fb, fc]) in [(0, [a.u, b.u, c.u]), (3, [a.v, b.v, c.v])] {
        p[at] = ((fb - fa) * cy - (fc - fa) * by) / area;
        p[at + 1] = ((fc - fa) * bx - (fb - fa) * cx) / area;
        p[at + 2] = fa - p[at] * a.x - p[at + 1] * a.y;
    }
    Some(p)
}

/// Refines the first `count` numbers of the motion, 6 or 8, while the cost falls (step 3).
fn refine(samples: &[Sample], mut p: [f64; 8], count: usize, tau_sq: f64) -> [f64; 8] {
    let mut best = cost(samples, &p, tau_sq, f64::INFINITY);
    for _ in 0..MAX_IRLS_ROUNDS {
        let Some(next) = least_squares(samples, &p, count, tau_sq) else { break };
        let next_cost = cost(samples, &next, tau_sq, f64::INFINITY);
        // False for NaN, too.
        let is_better = next_cost < best && next[6].abs() + next[7].abs() <= MAX_PERSPECTIVE;
        if !is_better {
            break;
        }
        (p, best) = (next, next_cost);
    }
    p
}

/// Returns the least squares motion, with samples weighted by how well `p` fits them.
fn least_squares(samples: &[Sample], p: &[f64; 8], count: usize, tau_sq: f64) -> Option<[f64; 8]> {
    let mut normal = [[0.0; 8]; 8];
    let mut right = [0.0; 8];
    for s in samples {
        let weight = (tau_sq / (residual_sq(s, p) + tau_sq)).powi(2);
        let (to_x, to_y) = (s.x + s.u, s.y + s.v);
        // Each row without its three zeros: indices of unknowns, and their coefficients.
        let rows = [
            ([0, 1, 2, 6, 7], [s.x, s.y, 1.0, -s.x * to_x, -s.y * to_x], s.u),
            ([3, 4, 5, 6, 7], [s.x, s.y, 1.0, -s.x * to_y, -s.y * to_y], s.v),
        ];
        for (unknowns, row, value) in rows {
            for i in 0..count - 3 {
                let weighted = weight * row[i];
                for j in 0..=i {
                    normal[unknowns[i]][unknowns[j]] += weighted * row[j];
                }
                right[unknowns[i]] += weighted * value;
            }
        }
    }
    solve(normal, right, count)
}

/// Solves the symmetric system of the first `count` unknowns by Cholesky's method; only the lower triangle is read. A
/// slight ridge keeps underdetermined systems solvable; `None` if the solution is not finite.
fn solve(mut a: [[f64; 8]; 8], mut x: [f64; 8], count: usize) -> Option<[f64; 8]> {
    let trace: f64 = (0..count).map(|i| a[i][i]).sum();
    for i in 0..count {
        a[i][i] += 1e-9 * trace;
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| a[i][k] * a[j][k]).sum();
            let rest = a[i][j] - sum;
            if i > j {
                a[i][j] = rest / a[j][j];
            } else if rest > 0.0 {
                a[i][i] = rest.sqrt();
            } else {
                return None;
            }
        }
        let sum: f64 = (0..i).map(|k| a[i][k] * x[k]).sum();
        x[i] = (x[i] - sum) / a[i][i];
    }
    for i in (0..count).rev() {
        let sum: f64 = (i + 1..count).map(|k| a[k][i] * x[k]).sum();
        x[i] = (x[i] - sum) / a[i][i];
    }
    x[count..].fill(0.0);
    x.iter().all(|v| v.is_finite()).then_some(x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::FlowField;
    use crate::image::Plane;

    const FIT: MotionFit = MotionFit { perspective: false, tolerance: 0.5 };

    fn field(width: usize, height: usize, motion: impl Fn(f64, f64) -> (f64, f64)) -> FlowField {
        let at = |x: usize, y: usize| motion(x as f64, y as f64);
        FlowField {
            u: Plane::from_fn(width, height, |x, y| at(x, y).0 as f32),
            v: Plane::from_fn(width, height, |x, y| at(x, y).1 as f32),
        }
    }

    /// Largest error of a motion at the corners and the centre of the frame.
    fn max_error(
        estimate: &DominantMotion,
        (width, height): (f64, f64),
        truth: impl Fn(f64, f64) -> (f64, f64),
    ) -> f64 {
        [(0.0, 0.0), (width, 0.0), (0.0, height), (width, height), (width / 2.0, height / 2.0)]
            .map(|(x, y)| {
                let (a, b) = (estimate.at(x, y), truth(x, y));
                (a.0 - b.0).abs().max((a.1 - b.1).abs())
            })
            .into_iter()
            .fold(0.0, f64::max)
    }

    #[test]
    fn an_object_of_two_fifths_of_the_frame_leaves_the_motion_as_it_is() {
        let ground = |x: f64, y: f64| (0.02 * x - 0.01 * y + 1.5, 0.005 * x + 0.015 * y - 2.0);
        let flow = field(160, 120, |x, y| {
            let object = (x - 70.0).abs() < 50.0 && (y - 62.0).abs() < 38.0;
            if object { (6.0, 3.0) } else { ground(x, y) }
        });
        let estimate = dominant_motion(&flow, &FIT, None);
        assert!(max_error(&estimate, (160.0, 120.0), ground) < 0.02, "{estimate:?}");
    }

    #[test]
    fn a_homography_is_found_where_an_affine_motion_is_not_enough() {
        let ground = |x: f64, y: f64| {
            let scale = 1.0 / (1.0 + 2e-4 * x - 1e-4 * y);
            ((1.01 * x + 2.0) * scale - x, (0.99 * y - 1.0) * scale - y)
        };
        let flow = field(160, 120, ground);
        let error = |perspective| {
            let estimate = dominant_motion(&flow, &MotionFit { perspective, ..FIT }, None);
            max_error(&estimate, (160.0, 120.0), ground)
        };
        assert!(error(true) < 0.02, "{}", error(true));
        assert!(error(false) > 0.3, "{}", error(false));
    }

    #[test]
    fn residuals_are_the_distances_from_the_motion() {
        let flow = field(50, 40, |x, y| (0.1 * x, 0.02 * x * y));
        let motion = dominant_motion(&flow, &MotionFit { perspective: true, ..FIT }, None);
        for x in 0..50 {
            let r = motion.along_row(7).residual(x, Field::at(&flow, x, 7));
            let x = x as f64;
            let (u, v) = motion.at(x, 7.0);
            let expected = ((0.1 * x - u).powi(2) + (0.14 * x - v).powi(2)).sqrt();
            assert!((f64::from(r) - expected).abs() < 1e-4, "{x}: {r} not {expected}");
        }
    }

    #[test]
    fn still_and_constant_flow_of_any_size_is_its_own_motion() {
        for (width, height) in [(1, 1), (1, 7), (9, 1), (2, 2), (64, 48)] {
            for motion in [(0.0, 0.0), (5.0, -3.0)] {
                for perspective in [false, true] {
                    let flow = field(width, height, |_, _| motion);
                    let estimate = dominant_motion(&flow, &MotionFit { perspective, ..FIT }, None);
                    let (u, v) = estimate.at(0.0, 0.0);
                    let error = (u - motion.0).abs().max((v - motion.1).abs());
                    assert!(error < 1e-3, "{width} x {height}, {motion:?}: {estimate:?}");
                }
            }
        }
    }

    #[test]
    fn nan_flow_does_not_count() {
        let flow = field(60, 40, |x, y| if x < 20.0 { (f64::NAN, y) } else { (2.0, f64::from(u8::from(x > 1e9))) });
        let estimate = dominant_motion(&flow, &FIT, None);
        let (u, v) = estimate.at(30.0, 20.0);
        assert!((u - 2.0).abs() < 1e-6 && v.abs() < 1e-6, "{estimate:?}");
        let nothing = dominant_motion(&field(9, 9, |_, _| (f64::NAN, 0.0)), &FIT, None);
        assert_eq!(nothing.at(3.0, 3.0), (0.0, 0.0));
    }
}
