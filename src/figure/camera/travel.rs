//! A camera that goes forward over the whole clip: pairs of frames some way apart, and how it goes in each.

use crate::trajectory::Trajectories;

/// Frames that points are compared across, and from one such pair of frames to the next.
const SPAN: usize = 6;
const STRIDE: usize = 3;
/// Share of the pairs in which the camera must surely go forward.
const LEAST_SURE: f64 = 0.6;

/// How the camera goes from a frame to another.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Pair {
    /// The first of the two frames.
    pub(crate) start: usize,
    /// Each trajectory that is in both, and its step.
    pub(crate) steps: Vec<(usize, Step)>,
    pub(crate) forward: Forward,
}

/// How the camera goes forward: in pairs of frames over the whole clip.
#[derive(Debug, Clone, PartialEq)]
pub struct Travel {
    pub(crate) units: Units,
    pub(crate) pairs: Vec<Pair>,
}

impl Travel {
    /// Frames from the first to the second of a pair.
    pub(crate) const SPAN: usize = SPAN;

    /// What the trajectories tell. `None` unless the camera surely goes forward in most pairs.
    pub fn of(tracks: &Trajectories) -> Option<Self> {
        Self::by(tracks, &mut |_, ways| ways.forward())
    }

    /// The same, where it is told elsewhere how the camera goes in each pair: the motion, and whether it is sure.
    pub(crate) fn by(
        tracks: &Trajectories,
        forward: &mut dyn FnMut(usize, Ways) -> Option<(Forward, bool)>,
    ) -> Option<Self> {
        let units = Units::new(tracks.size);
        let (mut pairs, mut sure) = (Vec::new(), 0);
        let is_enough = |sure: usize, pairs: usize| sure as f64 >= LEAST_SURE * pairs as f64;
        let num_pairs = Self::num_pairs(tracks);
        for k in 0..num_pairs {
            // Not even if it were sure in all that are left.
            if !is_enough(sure + num_pairs - k, pairs.len() + num_pairs - k) {
                return None;
            }
            let start = k * STRIDE;
            let Some((forward, is_sure)) = forward(k, Ways::new(tracks, k)) else { continue };
            sure += usize::from(is_sure);
            let steps = common(tracks, start).map(|(i, from, to)| (i, units.step(from, to))).collect();
            pairs.push(Pair { start, steps, forward });
        }
        (sure > 0 && is_enough(sure, pairs.len())).then_some(Self { units, pairs })
    }

    /// How many pairs of frames are compared.
    pub(crate) fn num_pairs(tracks: &Trajectories) -> usize {
        tracks.num_frames.saturating_sub(SPAN).div_ceil(STRIDE)
    }
}

/// The trajectories that are in the first frame of a pair and in the second, and where.
fn common(tracks: &Trajectories, start: usize) -> impl Iterator<Item = (usize, (f32, f32), (f32, f32))> + '_ {
    tracks.alive(start).filter_map(move |(i, x, y)| Some((i, (x, y), tracks.at(i, start + SPAN)?)))
}

/// The ways of all points in a pair of frames, which tell how the camera goes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Ways {
    /// Of the frames, in pixels.
    pub(crate) size: (usize, usize),
    /// From and to.
    pub(crate) points: Vec<[f32; 4]>,
}

impl Ways {
    /// In the `k`th pair.
    pub(crate) fn new(tracks: &Trajectories, k: usize) -> Self {
        let points = common(tracks, k * STRIDE).map(|(_, from, to)| [from.0, from.1, to.0, to.1]).collect();
        Self { size: tracks.size, points }
    }

    /// How the camera goes, and whether it surely goes forward.
    pub(crate) fn forward(&self) -> Option<(Forward, bool)> {
        let units = Units::new(self.size);
        let steps: Vec<Step> = self.points.iter().map(|&[x, y, u, v]| units.step((x, y), (u, v))).collect();
        let forward = Forward::fit(&steps, units)?;
        Some((forward, forward.is_sure(&steps, units)))
    }
}

impl Pair {
    /// How each of them goes.
    pub(crate) fn goings(&self) -> Vec<Going> {
        self.steps.iter().map(|(_, step)| self.forward.going(step)).collect()
    }

    /// How far below the focus of expansion the `k`th step begins.
    pub(crate) fn below(&self, k: usize) -> f64 {
        self.steps[k].1.y - self.forward.focus.1
    }
}

// A camera that goes forward, as in a car: where in the picture the scene comes from, and how near each point of it is.
//
// Points of a rigid scene leave the *focus of expansion* along straight lines, the faster the nearer they are; what the
// camera turns meanwhile is the same for all of them (Longuet-Higgins and Prazdny, "The interpretation of a moving
// retinal image", 1980). For each of many foci the turn is what leaves the least motion across those lines, absolute
// values counting, so that what moves by itself counts little; the best focus is searched more finely. All in `f64`
// with `+ - * /`, square roots and comparisons.

/// The side of the frame that lengths here are for, in pixels; others are brought to it.
const SIDE: f64 = 480.0;
/// Points that a focus is searched with, at most.
const MOST_POINTS: usize = 200;
/// Fewer points than these tell nothing.
const ENOUGH: usize = 40;
/// Foci tried at first, in columns and rows over the frame, and how often the best is searched around at half the way.
const GRID: (usize, usize) = (13, 10);
const HALVINGS: usize = 4;
/// Rounds of reweighting, and the residual that counts fully.
const ROUNDS: usize = 5;
const SMALL: f64 = 0.1;
/// No point costs more than one this far off, in pixels.
const MOST_OFF: f64 = 2.0;
/// A point surely goes away from the focus if it does by more than this, and by this part of that at most across.
const LEAST_WAY: f64 = 1.0;
const ACROSS: (f64, f64) = (0.3, 0.1);
/// Before a camera that goes forward at least this share of the points surely do.
const LEAST_SHARE: f64 = 0.5;
/// They do on at least four of the eight sides of the focus, five points on each.
const LEAST_SIDES: usize = 4;
const SOME: usize = 5;
/// The focus keeps this part of the frame's sides from its rim.
const MARGIN: f64 = 0.1;

/// A point of one frame and its way to another, in units of a frame whose longest side has 480.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Step {
    pub(crate) x: f64,
    pub(crate) y: f64,
    u: f64,
    v: f64,
}

/// How points come to the units of [`Step`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Units {
    pub(crate) scale: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl Units {
    /// Of a frame of this size.
    pub(crate) fn new((width, height): (usize, usize)) -> Self {
        let scale = SIDE / width.max(height).max(1) as f64;
        Self { scale, width: scale * width as f64, height: scale * height as f64 }
    }

    /// From one point to the other.
    pub(crate) fn step(&self, from: (f32, f32), to: (f32, f32)) -> Step {
        let [x, y, to_x, to_y] = [from.0, from.1, to.0, to.1].map(|v| self.scale * f64::from(v));
        Step { x, y, u: to_x - x, v: to_y - y }
    }
}

/// The motion of a camera between two frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Forward {
    /// The focus of expansion.
    pub(crate) focus: (f64, f64),
    /// What the camera turns: shift in x and y, and roll around the middle of the frame.
    turn: [f64; 3],
    middle: (f64, f64),
}

/// How a point goes, the camera's turn aside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Going {
    /// Its way from the focus, as a part of its distance from there: the inverse of how often this step of the camera
    /// goes into its depth. Negative where it goes towards the focus.
    pub(crate) nearness: f64,
    /// Its way across.
    pub(crate) off: f64,
    /// Its distance from the focus.
    pub(crate) reach: f64,
}

impl Forward {
    /// The numbers that it is.
    #[cfg(any(feature = "wasm", test))]
    pub(crate) fn numbers(&self) -> [f64; 7] {
        let ((fx, fy), [x, y, roll], (mx, my)) = (self.focus, self.turn, self.middle);
        [fx, fy, x, y, roll, mx, my]
    }

    /// From these.
    #[cfg(any(feature = "wasm", test))]
    pub(crate) fn from_numbers([fx, fy, x, y, roll, mx, my]: [f64; 7]) -> Self {
        Self { focus: (fx, fy), turn: [x, y, roll], middle: (mx, my) }
    }

    /// The motion that explains these steps best. `None` for fewer than 40, or where all focuses are as bad.
    fn fit(steps: &[Step], units: Units) -> Option<Self> {
        if steps.len() < ENOUGH {
            return None;
        }
        let some: Vec<Step> = steps.iter().copied().step_by(steps.len().div_ceil(MOST_POINTS)).collect();
        let mut best: Option<(f64, Self)> = None;
        let mut consider = |focus: (f64, f64)| {
            let tried = Self::around(focus, &some, units);
            let cost = tried.cost(&some);
            if cost.is_some_and(|cost| best.is_none_or(|(least, _)| cost < least)) {
                best = cost.map(|cost| (cost, tried));
            }
            best
        };
        let (across, down) = (units.width / (GRID.0 - 1) as f64, units.height / (GRID.1 - 1) as f64);
        for row in 0..GRID.1 {
            for column in 0..GRID.0 {
                consider((across * column as f64, down * row as f64));
            }
        }
        let (_, mut coarse) = consider((0.5 * units.width, 0.5 * units.height))?;
        let mut way = across.max(down);
        for _ in 0..HALVINGS {
            way *= 0.5;
            let (x, y) = coarse.focus;
            for k in (0..9).filter(|&k| k != 4) {
                (_, coarse) = consider((x + way * (k % 3) as f64 - way, y + way * (k / 3) as f64 - way))?;
            }
        }
        Some(Self::around(coarse.focus, steps, units))
    }

    /// With this focus, the turn that leaves the least across.
    fn around(focus: (f64, f64), steps: &[Step], units: Units) -> Self {
        let middle = (0.5 * units.width, 0.5 * units.height);
        let mut found = Self { focus, turn: [0.0; 3], middle };
        let mut weights = vec![1.0; steps.len()];
        for _ in 0..ROUNDS {
            let (mut a, mut b) = ([[0.0; 3]; 3], [0.0; 3]);
            for (step, &weight) in steps.iter().zip(&weights) {
                let (row, way) = found.row(step);
                for i in 0..3 {
                    (0..3).for_each(|j| a[i][j] += weight * row[i] * row[j]);
                    b[i] += weight * row[i] * way;
                }
            }
            found.turn = solved(a, b).unwrap_or([0.0; 3]);
            for (step, weight) in steps.iter().zip(&mut weights) {
                *weight = 1.0 / (found.going(step).off.abs() + SMALL);
            }
        }
        found
    }

    /// What each number of the turn adds to the way of a point across its line from the focus, and that way.
    fn row(&self, step: &Step) -> ([f64; 3], f64) {
        let (rx, ry) = (step.x - self.focus.0, step.y - self.focus.1);
        let reach = (rx * rx + ry * ry).sqrt().max(1e-9);
        let (nx, ny) = (-ry / reach, rx / reach);
        let rolled = ny * (step.x - self.middle.0) - nx * (step.y - self.middle.1);
        ([nx, ny, rolled], nx * step.u + ny * step.v)
    }

    /// Sum of the ways across; `None` where most points go towards the focus.
    fn cost(&self, steps: &[Step]) -> Option<f64> {
        let goings = steps.iter().map(|step| self.going(step));
        let (mut away, mut sum) = (0, 0.0);
        for going in goings {
            away += usize::from(going.nearness > 0.0);
            sum += going.off.abs().min(MOST_OFF);
        }
        (2 * away >= steps.len()).then_some(sum)
    }

    /// How a point goes.
    pub(crate) fn going(&self, step: &Step) -> Going {
        let (row, way) = self.row(step);
        let off = way - (0..3).map(|k| row[k] * self.turn[k]).sum::<f64>();
        let (rx, ry) = (step.x - self.focus.0, step.y - self.focus.1);
        let u = step.u - self.turn[0] + self.turn[2] * (step.y - self.middle.1);
        let v = step.v - self.turn[1] - self.turn[2] * (step.x - self.middle.0);
        let square = (rx * rx + ry * ry).max(1e-9);
        Going { nearness: (u * rx + v * ry) / square, off, reach: square.sqrt() }
    }

    /// Whether the camera surely goes forward: most of the scene goes away from the focus, to many sides, each point
    /// along its line.
    fn is_sure(&self, steps: &[Step], units: Units) -> bool {
        let within = |v: f64, side: f64| (MARGIN * side..=(1.0 - MARGIN) * side).contains(&v);
        let mut sides = [0; 8];
        for step in steps {
            let going = self.going(step);
            let away = going.nearness * going.reach;
            if away > LEAST_WAY && going.off.abs() < ACROSS.0 + ACROSS.1 * away {
                let (rx, ry) = (step.x - self.focus.0, step.y - self.focus.1);
                sides[usize::from(rx > 0.0) + 2 * usize::from(ry > 0.0) + 4 * usize::from(rx.abs() > ry.abs())] += 1;
            }
        }
        let count: usize = sides.iter().sum();
        within(self.focus.0, units.width)
            && within(self.focus.1, units.height)
            && count as f64 >= LEAST_SHARE * steps.len() as f64
            && sides.iter().filter(|&&count| count >= SOME).count() >= LEAST_SIDES
    }
}

/// Solves three symmetric equations; `None` where they do not tell.
fn solved(a: [[f64; 3]; 3], b: [f64; 3]) -> Option<[f64; 3]> {
    let minor = |i: usize, j: usize| {
        let (r, s) = ((i + 1) % 3, (i + 2) % 3);
        let (c, d) = ((j + 1) % 3, (j + 2) % 3);
        a[r][c] * a[s][d] - a[r][d] * a[s][c]
    };
    let determinant: f64 = (0..3).map(|j| a[0][j] * minor(0, j)).sum();
    let scale = a[0][0].max(a[1][1]).max(a[2][2]);
    let found: [f64; 3] = std::array::from_fn(|j| (0..3).map(|i| b[i] * minor(i, j)).sum::<f64>() / determinant);
    (determinant.abs() > 1e-12 * scale * scale * scale && found.iter().all(|v| v.is_finite())).then_some(found)
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
    fn only_a_camera_that_goes_forward_travels() {
        let found = Travel::of(&tracks(0.2, 0.0)).unwrap();
        assert!(found.pairs.iter().all(|pair| (pair.forward.focus.0 - 240.0).abs() < 5.0), "{found:?}");
        assert_eq!(Travel::of(&tracks(0.0, 0.2)), None);
        assert_eq!(Travel::of(&tracks(0.0, 0.0)), None);
        assert_eq!(Travel::of(&Trajectories::empty(20, (480, 270))), None);
    }

    const SIZE: (usize, usize) = (480, 270);
    const FOCUS: (f64, f64) = (230.0, 140.0);

    /// Steps of a scene of random depth before a camera that goes forward and turns by `turn`.
    fn scene(turn: [f64; 3], seed: u64) -> Vec<Step> {
        let mut rng = Rng::for_stage(seed, "forward");
        (0..300)
            .map(|_| {
                let (x, y) = (rng.range(0.0, 480.0), rng.range(0.0, 270.0));
                let near = rng.range(0.01, 0.2);
                let u = turn[0] - turn[2] * (y - 135.0) + near * (x - FOCUS.0);
                let v = turn[1] + turn[2] * (x - 240.0) + near * (y - FOCUS.1);
                Step { x, y, u, v }
            })
            .collect()
    }

    #[test]
    fn focus_and_turn_are_found_though_some_points_move_by_themselves() {
        for (seed, turn) in [(1, [0.0; 3]), (2, [3.0, -2.0, 0.01]), (3, [-6.0, 1.0, -0.005])] {
            let mut steps = scene(turn, seed);
            steps.iter_mut().step_by(5).for_each(|step| (step.u, step.v) = (9.0 - 0.1 * step.u, -4.0));
            let units = Units::new(SIZE);
            let found = Forward::fit(&steps, units).unwrap();
            assert!((found.focus.0 - FOCUS.0).abs() < 4.0 && (found.focus.1 - FOCUS.1).abs() < 4.0, "{found:?}");
            assert!(found.is_sure(&steps, units));
        }
    }

    #[test]
    fn nearness_is_the_way_from_the_focus_as_a_part_of_the_distance() {
        let forward = Forward { focus: FOCUS, turn: [2.0, 0.0, 0.0], middle: (240.0, 135.0) };
        let going = forward.going(&Step { x: 330.0, y: 140.0, u: 12.0, v: 3.0 });
        assert!((going.nearness - 0.1).abs() < 1e-12 && (going.reach - 100.0).abs() < 1e-12);
        assert!((going.off.abs() - 3.0).abs() < 1e-12);
    }

    #[test]
    fn pans_zooms_at_the_rim_and_sideways_ways_are_not_forward() {
        let mut rng = Rng::for_stage(1, "sideways");
        let mut steps = scene([0.0; 3], 4);
        let units = Units::new(SIZE);
        for step in &mut steps {
            (step.u, step.v) = (-rng.range(2.0, 20.0), 0.0);
        }
        assert!(!Forward::fit(&steps, units).is_some_and(|found| found.is_sure(&steps, units)));
        steps.iter_mut().for_each(|step| (step.u, step.v) = (-5.0, 2.0));
        assert!(!Forward::fit(&steps, units).is_some_and(|found| found.is_sure(&steps, units)));
        assert_eq!(Forward::fit(&steps[..39], units), None);
    }

    #[test]
    fn frames_of_any_size_are_brought_to_one() {
        let units = Units::new((960, 540));
        assert_eq!(units.step((480.0, 270.0), (490.0, 260.0)), Step { x: 240.0, y: 135.0, u: 5.0, v: -5.0 });
        assert_eq!((units.width, units.height), (480.0, 270.0));
    }
}
