//! Forward motion of the camera over a clip, as from a car: focus of expansion and rotation between pairs of frames.
//!
//! Points of a rigid scene leave the *focus of expansion* `e` along straight lines, the faster the nearer they are, while a
//! rotation of the camera moves all of them alike (Longuet-Higgins and Prazdny, "The interpretation of a moving retinal
//! image", 1980): a point at `x` moves by `q (x − e) + r(x)`, with its inverse depth `q` and a shift and roll `r`. For each
//! of many foci the rotation is fitted that leaves the least motion across those lines, by least squares reweighted to
//! absolute values, so that independent movers count little; the best focus is then refined by halving the step.
//!
//! Not in the paper. Cost: O(foci · points) for each pair of frames. It fails where few points are tracked or the camera
//! translates sideways; then the clip has no forward motion. All in `f64` with `+ - * /`, square roots and comparisons.

use crate::trajectory::Trajectories;

// All constants of this file are chosen by eye, on clips from cars.

/// Frames from the start of one pair to the start of the next.
const PAIR_STRIDE_FRAMES: usize = 3;
/// Share of the pairs in which the camera must surely go forward.
const MIN_SURE_SHARE: f64 = 0.6;
/// Longest side of the frame after scaling, in pixels: all lengths below are for it.
const SCALED_SIDE_PX: f64 = 480.0;
/// Most points that the focus is searched with.
const MAX_SEARCH_POINTS: usize = 200;
/// Fewest points to fit a motion to.
const MIN_POINTS: usize = 40;
/// Columns and rows of the foci of the coarse search, over the whole frame.
const FOCUS_COLUMNS: usize = 13;
const FOCUS_ROWS: usize = 10;
/// Rounds of the fine search, each of half the step.
const FOCUS_HALVINGS: usize = 4;
/// Rounds of reweighted least squares.
const IRLS_ROUNDS: usize = 5;
/// Added to residuals in their weights, so that none is infinite.
const IRLS_FLOOR_PX: f64 = 0.1;
/// Residual at which a point's cost is truncated.
const MAX_RESIDUAL_PX: f64 = 2.0;
/// A point surely leaves the focus if it moves away by more than this ...
const MIN_OUTWARD_PX: f64 = 1.0;
/// ... and across its line by less than this, plus this part of its outward motion.
const MAX_OFF_LINE_PX: f64 = 0.3;
const MAX_OFF_LINE_RATIO: f64 = 0.1;
/// Share of the points that must surely leave the focus.
const MIN_OUTWARD_SHARE: f64 = 0.5;
/// Least number of the eight octants around the focus that have such points, and of points in each.
const MIN_OCTANTS: usize = 4;
const MIN_OCTANT_POINTS: usize = 5;
/// Least distance of the focus from the frame border, as a part of the frame's side.
const MIN_FOCUS_MARGIN: f64 = 0.1;

/// Motion of the camera between two frames.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FramePair {
    /// The first of the two frames.
    pub(crate) start: usize,
    /// Index and motion of each trajectory that is in both frames.
    pub(crate) motions: Vec<(usize, PointMotion)>,
    pub(crate) egomotion: Egomotion,
}

/// Forward motion of the camera in pairs of frames over the whole clip.
#[derive(Debug, Clone, PartialEq)]
pub struct ForwardMotion {
    pub(crate) scale: FrameScale,
    pub(crate) pairs: Vec<FramePair>,
}

impl ForwardMotion {
    /// Frames from the first to the second of a pair. Chosen by eye.
    pub(crate) const PAIR_SPAN_FRAMES: usize = 6;

    /// Estimates the motion from trajectories; `None` unless the camera surely goes forward in most pairs.
    pub fn estimate(tracks: &Trajectories) -> Option<Self> {
        Self::estimate_with(tracks, &mut |_, matches| matches.estimate_egomotion())
    }

    /// Same as [`estimate`](Self::estimate), with the egomotion of each pair from `egomotion_of(pair, matches)`.
    pub(crate) fn estimate_with(
        tracks: &Trajectories,
        egomotion_of: &mut dyn FnMut(usize, PointMatches) -> Option<(Egomotion, bool)>,
    ) -> Option<Self> {
        let scale = FrameScale::new(tracks.size);
        let (mut pairs, mut num_sure) = (Vec::new(), 0);
        let is_enough = |num_sure: usize, pairs: usize| num_sure as f64 >= MIN_SURE_SHARE * pairs as f64;
        let num_pairs = Self::num_pairs(tracks);
        for k in 0..num_pairs {
            // Not even if all remaining pairs were sure.
            if !is_enough(num_sure + num_pairs - k, pairs.len() + num_pairs - k) {
                return None;
            }
            let start = k * PAIR_STRIDE_FRAMES;
            let Some((egomotion, is_sure)) = egomotion_of(k, PointMatches::new(tracks, k)) else { continue };
            num_sure += usize::from(is_sure);
            let motions = matched_points(tracks, start).map(|(i, from, to)| (i, scale.motion(from, to))).collect();
            pairs.push(FramePair { start, motions, egomotion });
        }
        (num_sure > 0 && is_enough(num_sure, pairs.len())).then_some(Self { scale, pairs })
    }

    /// Number of pairs that are compared.
    pub(crate) fn num_pairs(tracks: &Trajectories) -> usize {
        tracks.num_frames.saturating_sub(Self::PAIR_SPAN_FRAMES).div_ceil(PAIR_STRIDE_FRAMES)
    }
}

/// Trajectories that are in both frames of the pair that begins at `start`: index, and position in each.
fn matched_points(tracks: &Trajectories, start: usize) -> impl Iterator<Item = (usize, (f32, f32), (f32, f32))> + '_ {
    let end = start + ForwardMotion::PAIR_SPAN_FRAMES;
    tracks.alive(start).filter_map(move |(i, x, y)| Some((i, (x, y), tracks.at(i, end)?)))
}

/// Matched points of a pair of frames.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PointMatches {
    /// Width and height of the frames, in pixels.
    pub(crate) size: (usize, usize),
    /// `[x, y, x', y']` of each point, in pixels.
    pub(crate) points: Vec<[f32; 4]>,
}

impl PointMatches {
    /// The points of the `k`th pair.
    pub(crate) fn new(tracks: &Trajectories, k: usize) -> Self {
        let points = matched_points(tracks, k * PAIR_STRIDE_FRAMES);
        Self { size: tracks.size, points: points.map(|(_, from, to)| [from.0, from.1, to.0, to.1]).collect() }
    }

    /// Returns the camera's motion, and `true` if it surely goes forward.
    pub(crate) fn estimate_egomotion(&self) -> Option<(Egomotion, bool)> {
        let scale = FrameScale::new(self.size);
        let motions: Vec<_> = self.points.iter().map(|&[x, y, u, v]| scale.motion((x, y), (u, v))).collect();
        let egomotion = Egomotion::fit(&motions, scale)?;
        Some((egomotion, egomotion.is_surely_forward(&motions, scale)))
    }
}

impl FramePair {
    /// The radial motion of each point, in the order of `motions`.
    pub(crate) fn radial_motions(&self) -> Vec<RadialMotion> {
        self.motions.iter().map(|(_, motion)| self.egomotion.radial_motion(motion)).collect()
    }

    /// Returns how far below the focus of expansion the `k`th point is, in scaled pixels.
    pub(crate) fn offset_below_focus(&self, k: usize) -> f64 {
        self.motions[k].1.y - self.egomotion.focus.1
    }
}

/// A point of one frame and its displacement to another, in scaled pixels ([`FrameScale`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PointMotion {
    pub(crate) x: f64,
    pub(crate) y: f64,
    u: f64,
    v: f64,
}

/// Scale to frames whose longest side has 480 pixels, and the scaled size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FrameScale {
    pub(crate) factor: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl FrameScale {
    pub(crate) fn new(size: (usize, usize)) -> Self {
        let factor = SCALED_SIDE_PX / size.0.max(size.1).max(1) as f64;
        Self { factor, width: factor * size.0 as f64, height: factor * size.1 as f64 }
    }

    fn motion(&self, from: (f32, f32), to: (f32, f32)) -> PointMotion {
        let [x, y, to_x, to_y] = [from.0, from.1, to.0, to.1].map(|v| self.factor * f64::from(v));
        PointMotion { x, y, u: to_x - x, v: to_y - y }
    }
}

/// Motion of a camera that goes forward between two frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Egomotion {
    /// Focus of expansion, in scaled pixels.
    focus: (f64, f64),
    /// Shift in x and y, in scaled pixels, and roll around the centre of the frame, in radians.
    rotation: [f64; 3],
    center: (f64, f64),
}

/// Motion of a point along its line from the focus and across it, without the camera's rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RadialMotion {
    /// Motion away from the focus divided by the distance from it: the camera's step over the point's depth. Negative
    /// towards the focus.
    pub(crate) inverse_depth: f64,
    /// Motion across the line, in scaled pixels.
    pub(crate) off_line: f64,
    /// Distance from the focus, in scaled pixels.
    pub(crate) radius: f64,
}

impl Egomotion {
    /// Returns its seven numbers, for [`from_array`](Self::from_array).
    #[cfg(any(feature = "wasm", test))]
    pub(crate) fn to_array(self) -> [f64; 7] {
        let ((fx, fy), [x, y, roll], (cx, cy)) = (self.focus, self.rotation, self.center);
        [fx, fy, x, y, roll, cx, cy]
    }

    #[cfg(any(feature = "wasm", test))]
    pub(crate) fn from_array([fx, fy, x, y, roll, cx, cy]: [f64; 7]) -> Self {
        Self { focus: (fx, fy), rotation: [x, y, roll], center: (cx, cy) }
    }

    /// Fits the motion of least cost. `None` for too few points, or if no focus is better than any other.
    fn fit(motions: &[PointMotion], scale: FrameScale) -> Option<Self> {
        if motions.len() < MIN_POINTS {
            return None;
        }
        let step = motions.len().div_ceil(MAX_SEARCH_POINTS);
        let sample: Vec<PointMotion> = motions.iter().copied().step_by(step).collect();
        let mut best: Option<(f64, Self)> = None;
        let mut consider = |focus: (f64, f64)| {
            let candidate = Self::with_focus(focus, &sample, scale);
            let cost = candidate.cost(&sample);
            if cost.is_some_and(|cost| best.is_none_or(|(least, _)| cost < least)) {
                best = cost.map(|cost| (cost, candidate));
            }
            best
        };
        let (dx, dy) = (scale.width / (FOCUS_COLUMNS - 1) as f64, scale.height / (FOCUS_ROWS - 1) as f64);
        for row in 0..FOCUS_ROWS {
            for column in 0..FOCUS_COLUMNS {
                consider((dx * column as f64, dy * row as f64));
            }
        }
        let (_, mut coarse) = consider((0.5 * scale.width, 0.5 * scale.height))?;
        let mut step = dx.max(dy);
        for _ in 0..FOCUS_HALVINGS {
            step *= 0.5;
            let (x, y) = coarse.focus;
            for k in (0..9).filter(|&k| k != 4) {
                (_, coarse) = consider((x + step * (k % 3) as f64 - step, y + step * (k / 3) as f64 - step))?;
            }
        }
        Some(Self::with_focus(coarse.focus, motions, scale))
    }

    /// Fits the rotation that leaves the least motion across the lines from this focus.
    fn with_focus(focus: (f64, f64), motions: &[PointMotion], scale: FrameScale) -> Self {
        let center = (0.5 * scale.width, 0.5 * scale.height);
        let mut egomotion = Self { focus, rotation: [0.0; 3], center };
        let mut weights = vec![1.0; motions.len()];
        for _ in 0..IRLS_ROUNDS {
            let (mut a, mut b) = ([[0.0; 3]; 3], [0.0; 3]);
            for (motion, &weight) in motions.iter().zip(&weights) {
                let (row, off_line) = egomotion.off_line_equation(motion);
                for i in 0..3 {
                    (0..3).for_each(|j| a[i][j] += weight * row[i] * row[j]);
                    b[i] += weight * row[i] * off_line;
                }
            }
            egomotion.rotation = solve_symmetric3(a, b).unwrap_or([0.0; 3]);
            for (motion, weight) in motions.iter().zip(&mut weights) {
                *weight = 1.0 / (egomotion.radial_motion(motion).off_line.abs() + IRLS_FLOOR_PX);
            }
        }
        egomotion
    }

    /// Returns the coefficients of the rotation's three numbers in a point's motion across its line, and that motion.
    fn off_line_equation(&self, motion: &PointMotion) -> ([f64; 3], f64) {
        let (rx, ry) = (motion.x - self.focus.0, motion.y - self.focus.1);
        let radius = (rx * rx + ry * ry).sqrt().max(1e-9);
        let (nx, ny) = (-ry / radius, rx / radius);
        let roll = ny * (motion.x - self.center.0) - nx * (motion.y - self.center.1);
        ([nx, ny, roll], nx * motion.u + ny * motion.v)
    }

    /// Sum of the truncated motions across the lines; `None` if most points move towards the focus.
    fn cost(&self, motions: &[PointMotion]) -> Option<f64> {
        let (mut num_outward, mut sum) = (0, 0.0);
        for radial in motions.iter().map(|motion| self.radial_motion(motion)) {
            num_outward += usize::from(radial.inverse_depth > 0.0);
            sum += radial.off_line.abs().min(MAX_RESIDUAL_PX);
        }
        (2 * num_outward >= motions.len()).then_some(sum)
    }

    fn radial_motion(&self, motion: &PointMotion) -> RadialMotion {
        let (row, off_line) = self.off_line_equation(motion);
        let off_line = off_line - (0..3).map(|k| row[k] * self.rotation[k]).sum::<f64>();
        let (rx, ry) = (motion.x - self.focus.0, motion.y - self.focus.1);
        let u = motion.u - self.rotation[0] + self.rotation[2] * (motion.y - self.center.1);
        let v = motion.v - self.rotation[1] - self.rotation[2] * (motion.x - self.center.0);
        let radius_sq = (rx * rx + ry * ry).max(1e-9);
        RadialMotion { inverse_depth: (u * rx + v * ry) / radius_sq, off_line, radius: radius_sq.sqrt() }
    }

    /// Returns `true` if most points leave the focus along their lines, in many directions.
    fn is_surely_forward(&self, motions: &[PointMotion], scale: FrameScale) -> bool {
        let is_central = |v: f64, side: f64| (MIN_FOCUS_MARGIN * side..=(1.0 - MIN_FOCUS_MARGIN) * side).contains(&v);
        let mut octants = [0; 8];
        for motion in motions {
            let radial = self.radial_motion(motion);
            let outward = radial.inverse_depth * radial.radius;
            if outward > MIN_OUTWARD_PX && radial.off_line.abs() < MAX_OFF_LINE_PX + MAX_OFF_LINE_RATIO * outward {
                let (rx, ry) = (motion.x - self.focus.0, motion.y - self.focus.1);
                octants[usize::from(rx > 0.0) + 2 * usize::from(ry > 0.0) + 4 * usize::from(rx.abs() > ry.abs())] += 1;
            }
        }
        let count: usize = octants.iter().sum();
        is_central(self.focus.0, scale.width)
            && is_central(self.focus.1, scale.height)
            && count as f64 >= MIN_OUTWARD_SHARE * motions.len() as f64
            && octants.iter().filter(|&&count| count >= MIN_OCTANT_POINTS).count() >= MIN_OCTANTS
    }
}

/// Solves three symmetric equations; returns `None` if the system is near-singular.
fn solve_symmetric3(a: [[f64; 3]; 3], b: [f64; 3]) -> Option<[f64; 3]> {
    let minor = |i: usize, j: usize| {
        let (r, s) = ((i + 1) % 3, (i + 2) % 3);
        let (c, d) = ((j + 1) % 3, (j + 2) % 3);
        a[r][c] * a[s][d] - a[r][d] * a[s][c]
    };
    let determinant: f64 = (0..3).map(|j| a[0][j] * minor(0, j)).sum();
    let scale = a[0][0].max(a[1][1]).max(a[2][2]);
    let solution: [f64; 3] = std::array::from_fn(|j| (0..3).map(|i| b[i] * minor(i, j)).sum::<f64>() / determinant);
    (determinant.abs() > 1e-12 * scale * scale * scale && solution.iter().all(|v| v.is_finite())).then_some(solution)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    /// Points of random depth before a camera that goes forward by `speed`, and to the right by `aside`, each frame.
    fn tracks(speed: f64, aside: f64) -> Trajectories {
        let mut rng = Rng::for_stage(7, "travel");
        let mut tracks = Trajectories::empty(20, (480, 270));
        for _ in 0..400 {
            let (depth, x, y) = (rng.range(6.0, 40.0), rng.range(-0.8, 0.8), rng.range(-0.45, 0.45));
            let at = |t: f64| {
                let z = depth - speed * t;
                (240.0 + 300.0 * (x * depth - aside * t) / z, 135.0 + 300.0 * y * depth / z)
            };
            let points =
                (0..20).map(|t| at(f64::from(t))).take_while(|&(x, y)| x > 0.0 && x < 480.0 && y > 0.0 && y < 270.0);
            tracks.push(0, points.map(|(x, y)| (x as f32, y as f32, 0.0)));
        }
        tracks
    }

    #[test]
    fn only_a_camera_that_goes_forward_has_forward_motion() {
        let estimate = ForwardMotion::estimate(&tracks(0.2, 0.0)).unwrap();
        assert!(estimate.pairs.iter().all(|pair| (pair.egomotion.focus.0 - 240.0).abs() < 5.0), "{estimate:?}");
        assert_eq!(ForwardMotion::estimate(&tracks(0.0, 0.2)), None);
        assert_eq!(ForwardMotion::estimate(&tracks(0.0, 0.0)), None);
        assert_eq!(ForwardMotion::estimate(&Trajectories::empty(20, (480, 270))), None);
    }

    const SIZE: (usize, usize) = (480, 270);
    const FOCUS: (f64, f64) = (230.0, 140.0);

    /// Points of random depth before a camera that goes forward and turns by `rotation`.
    fn scene(rotation: [f64; 3], seed: u64) -> Vec<PointMotion> {
        let mut rng = Rng::for_stage(seed, "forward");
        (0..300)
            .map(|_| {
                let (x, y) = (rng.range(0.0, 480.0), rng.range(0.0, 270.0));
                let inverse_depth = rng.range(0.01, 0.2);
                let u = rotation[0] - rotation[2] * (y - 135.0) + inverse_depth * (x - FOCUS.0);
                let v = rotation[1] + rotation[2] * (x - 240.0) + inverse_depth * (y - FOCUS.1);
                PointMotion { x, y, u, v }
            })
            .collect()
    }

    #[test]
    fn focus_and_rotation_are_found_despite_independent_movers() {
        for (seed, rotation) in [(1, [0.0; 3]), (2, [3.0, -2.0, 0.01]), (3, [-6.0, 1.0, -0.005])] {
            let mut motions = scene(rotation, seed);
            motions.iter_mut().step_by(5).for_each(|motion| (motion.u, motion.v) = (9.0 - 0.1 * motion.u, -4.0));
            let scale = FrameScale::new(SIZE);
            let estimate = Egomotion::fit(&motions, scale).unwrap();
            assert!(
                (estimate.focus.0 - FOCUS.0).abs() < 4.0 && (estimate.focus.1 - FOCUS.1).abs() < 4.0,
                "{estimate:?}"
            );
            assert!(estimate.is_surely_forward(&motions, scale));
        }
    }

    #[test]
    fn inverse_depth_is_the_motion_from_the_focus_over_the_distance() {
        let egomotion = Egomotion { focus: FOCUS, rotation: [2.0, 0.0, 0.0], center: (240.0, 135.0) };
        let radial = egomotion.radial_motion(&PointMotion { x: 330.0, y: 140.0, u: 12.0, v: 3.0 });
        assert!((radial.inverse_depth - 0.1).abs() < 1e-12 && (radial.radius - 100.0).abs() < 1e-12);
        assert!((radial.off_line.abs() - 3.0).abs() < 1e-12);
    }

    #[test]
    fn pans_and_sideways_motions_are_not_forward() {
        let mut rng = Rng::for_stage(1, "sideways");
        let mut motions = scene([0.0; 3], 4);
        let scale = FrameScale::new(SIZE);
        for motion in &mut motions {
            (motion.u, motion.v) = (-rng.range(2.0, 20.0), 0.0);
        }
        assert!(!Egomotion::fit(&motions, scale).is_some_and(|estimate| estimate.is_surely_forward(&motions, scale)));
        motions.iter_mut().for_each(|motion| (motion.u, motion.v) = (-5.0, 2.0));
        assert!(!Egomotion::fit(&motions, scale).is_some_and(|estimate| estimate.is_surely_forward(&motions, scale)));
        assert_eq!(Egomotion::fit(&motions[..39], scale), None);
    }

    #[test]
    fn frames_of_any_size_are_scaled_to_one() {
        let scale = FrameScale::new((960, 540));
        assert_eq!(scale.motion((480.0, 270.0), (490.0, 260.0)), PointMotion { x: 240.0, y: 135.0, u: 5.0, v: -5.0 });
        assert_eq!((scale.width, scale.height), (480.0, 270.0));
    }
}
