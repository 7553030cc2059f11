//! What moves by itself before a rigid scene that the camera goes into, as from a car.
//!
//! Some frames apart, each point has an apparent nearness ([`Travel`]). The ground is the plane through the focus of
//! expansion, along which nearness grows with the distance below it. A trajectory is none of the scene where
//! 1. it goes across its line from the focus, or towards it;
//! 2. it is less near than the ground at its place: no part of a rigid scene lies below the ground;
//! 3. it is nearer, so that it would stand on ground further down in the picture, and yet the ground between is seen:
//!    what stands there would hide it. This tells oncoming cars from parked ones.
//!
//! Not in the paper. Lengths are in pixels of a frame whose longest side has 480 ([`Units`]). **Limits.** Nothing is told
//! at the height of the focus. What goes exactly as fast as its place in the scene seems to, is scene. What hangs below
//! the height of the focus is taken for an object.

use crate::camera::{Going, Pair, Travel, Units};
use crate::discontinuity::Neighborhoods;
use crate::discretize::{Clusters, canonical};
use crate::order;
use crate::sets::DisjointSets;
use crate::trajectory::Trajectories;

/// Points less far below the focus have no ground.
const LEAST_BELOW: f64 = 8.0;
/// Slopes of the ground that are tried, as nearness by pixel: the first, the factor to the next, and their number.
const SLOPES: (f64, f64, i32) = (3e-4, 1.1, 62);
/// Nearness that is the ground's, up to this factor.
const ALIKE: f64 = 1.2;
/// The ground is seen in at least this many cells of this side.
const CELL: f64 = 16.0;
const LEAST_CELLS: usize = 5;
/// A way across of more than this, and this part of the way along, is not the scene's; nor one towards the focus.
const ACROSS: (f64, f64) = (1.0, 0.1);
const TOWARDS: f64 = 1.0;
/// Nearness below this part of the ground's, or above this one, is another where it makes this many pixels.
const BELOW: f64 = 0.6;
const ABOVE: f64 = 1.3;
const VISIBLE: f64 = 2.0;
/// Ground between a point and where it would stand is looked for this far to either side, from this far below the point
/// to this part of the way: ground beside what does stand there is seen too.
const BESIDE: f64 = 10.0;
const UNDER: f64 = 6.0;
const WAY_DOWN: f64 = 0.85;
/// Objects have this many trajectories at least.
const LEAST_TRACKS: usize = 5;
/// Neighbours that differ by more than this on their common way are not of one object.
const APART: f64 = 6.0;
/// What moves by less than this in all, at the lower rim, is the camera's own carrier.
const CARRIED: f64 = 3.0;

/// Clusters of a clip whose camera goes forward.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Parted {
    pub(crate) clusters: Clusters,
    /// Whether each is an object.
    pub(crate) is_object: Vec<bool>,
}

/// Objects before a scene that the camera goes into, in clusters of their own; all else is the first cluster. `longest` is
/// the longest edge between trajectories of one object, in pixels.
pub(crate) fn part_rigid(travel: &Travel, tracks: &Trajectories, near: &Neighborhoods, longest: f32) -> Parted {
    let is_stray = strays(travel, tracks.len());
    let mut label = vec![0; tracks.len()];
    let mut count = 0;
    for members in groups(tracks, near, &is_stray, (longest, travel.units)) {
        if members.len() >= LEAST_TRACKS && !is_carrier(tracks, &members, (longest, travel.units)) {
            count += 1;
            members.iter().for_each(|&i| label[i] = count);
        }
    }
    let clusters = canonical(tracks, label.clone());
    let mut is_object = vec![false; clusters.count];
    clusters.label.iter().zip(&label).for_each(|(&new, &old)| is_object[new as usize] = old > 0);
    Parted { clusters, is_object }
}

/// Which of `count` trajectories are none of the scene in most pairs that tell.
fn strays(travel: &Travel, count: usize) -> Vec<bool> {
    let goings: Vec<Vec<Going>> = travel.pairs.iter().map(Pair::goings).collect();
    let pairs = || travel.pairs.iter().zip(&goings);
    let mut slopes: Vec<f64> = pairs().filter_map(|(pair, goings)| ground(pair, goings, travel.units)).collect();
    order::sort_by_key(&mut slopes, |&slope| order::f64_key(slope));
    let slope = slopes.get(slopes.len() / 2).copied();
    let mut votes = vec![0_i32; count];
    for (pair, goings) in pairs() {
        for (k, &(i, _)) in pair.steps.iter().enumerate() {
            if is_across(&goings[k]) || is_astray(k, pair, goings, slope) {
                votes[i] += 1;
            } else if is_telling(k, pair, goings, slope) {
                votes[i] -= 1;
            }
        }
    }
    votes.iter().map(|&votes| votes > 0).collect()
}

/// How much nearness grows by each pixel below the focus along the ground: what most places have.
fn ground(pair: &Pair, goings: &[Going], units: Units) -> Option<f64> {
    let (columns, rows) = ((units.width / CELL) as usize + 1, (units.height / CELL) as usize + 1);
    let mut best = (LEAST_CELLS - 1, None);
    let mut slope = SLOPES.0;
    for _ in 0..SLOPES.2 {
        slope *= SLOPES.1;
        let mut seen = vec![false; columns * rows];
        for (k, going) in goings.iter().enumerate() {
            if is_ground(pair.below(k), going, slope) {
                let place = |v: f64, count: usize| ((v / CELL).max(0.0) as usize).min(count - 1);
                let step = &pair.steps[k].1;
                seen[place(step.y, rows) * columns + place(step.x, columns)] = true;
            }
        }
        let count = seen.iter().filter(|&&seen| seen).count();
        if count > best.0 {
            best = (count, Some(slope));
        }
    }
    best.1
}

fn is_ground(below: f64, going: &Going, slope: f64) -> bool {
    let expected = slope * below;
    below > LEAST_BELOW && going.nearness < ALIKE * expected && expected < ALIKE * going.nearness && !is_across(going)
}

fn is_across(going: &Going) -> bool {
    going.off.abs() > ACROSS.0 + ACROSS.1 * (going.nearness * going.reach).abs()
}

/// Whether point `k` goes along its line from the focus as no point of a rigid scene on this ground does.
fn is_astray(k: usize, pair: &Pair, goings: &[Going], slope: Option<f64>) -> bool {
    let (going, below) = (&goings[k], pair.below(k));
    if going.nearness * going.reach < -TOWARDS {
        return true;
    }
    let Some(slope) = slope.filter(|_| below > LEAST_BELOW) else { return false };
    let expected = slope * below;
    let is_visible = (going.nearness - expected).abs() * going.reach > VISIBLE;
    is_visible
        && (going.nearness < BELOW * expected || going.nearness > ABOVE * expected && floats(k, pair, goings, slope))
}

/// Whether it would be seen if a point were less near than the ground.
fn is_telling(k: usize, pair: &Pair, goings: &[Going], slope: Option<f64>) -> bool {
    let below = pair.below(k);
    below > LEAST_BELOW && slope.is_some_and(|slope| (1.0 - BELOW) * slope * below * goings[k].reach > VISIBLE)
}

/// Whether the ground is seen where something that stood on it would hide it.
fn floats(k: usize, pair: &Pair, goings: &[Going], slope: f64) -> bool {
    let (x, below) = (pair.steps[k].1.x, pair.below(k));
    let foot = goings[k].nearness / slope;
    let between = |j: usize| {
        let (other, lower) = (&pair.steps[j].1, pair.below(j));
        (other.x - x).abs() < BESIDE && (below + UNDER..WAY_DOWN * foot).contains(&lower)
    };
    (0..goings.len()).any(|j| between(j) && is_ground(pair.below(j), &goings[j], slope))
}

/// Strays that are neighbours and go together.
fn groups(
    tracks: &Trajectories,
    near: &Neighborhoods,
    is_stray: &[bool],
    (longest, units): (f32, Units),
) -> Vec<Vec<usize>> {
    let mut sets = DisjointSets::new(tracks.len());
    for t in 0..tracks.num_frames {
        for &pair in near.frame(t) {
            let (i, j) = near.pairs[pair as usize];
            let (i, j) = (i as usize, j as usize);
            if is_stray[i] && is_stray[j] && near_at(tracks, i, j, t, longest) && go_together(tracks, i, j, units) {
                sets.join(i, j);
            }
        }
    }
    let mut groups = vec![Vec::new(); tracks.len()];
    (0..tracks.len()).filter(|&i| is_stray[i]).for_each(|i| groups[sets.root(i)].push(i));
    groups.retain(|members| !members.is_empty());
    groups
}

fn near_at(tracks: &Trajectories, i: usize, j: usize, t: usize, longest: f32) -> bool {
    let (Some(a), Some(b)) = (tracks.at(i, t), tracks.at(j, t)) else { return false };
    (a.0 - b.0).powi(2) + (a.1 - b.1).powi(2) <= longest * longest
}

/// Whether two go nearly the same way while both are seen.
fn go_together(tracks: &Trajectories, i: usize, j: usize, units: Units) -> bool {
    let (a, b) = (tracks.frames(i), tracks.frames(j));
    let (first, last) = (a.start.max(b.start), a.end.min(b.end).saturating_sub(1));
    let way = |i: usize| {
        let (from, to) = (tracks.at(i, first)?, tracks.at(i, last)?);
        Some((to.0 - from.0, to.1 - from.1))
    };
    let (Some(p), Some(q)) = (way(i), way(j)) else { return false };
    let unit = (1.0 / units.scale) as f32;
    let spans = ((last - first) as f32 / Travel::SPAN as f32).max(1.0);
    (p.0 - q.0).abs().max((p.1 - q.1).abs()) <= APART as f32 * unit * spans
}

/// Whether a group stands still in the picture, at its lower rim.
fn is_carrier(tracks: &Trajectories, members: &[usize], (margin, units): (f32, Units)) -> bool {
    let unit = (1.0 / units.scale) as f32;
    let mut ways: Vec<f32> = Vec::new();
    let mut is_at_rim = false;
    for &i in members {
        let points = tracks.points(i);
        let (first, last) = (points.start, points.end - 1);
        ways.push((tracks.x[last] - tracks.x[first]).abs().max((tracks.y[last] - tracks.y[first]).abs()) / unit);
        is_at_rim |= tracks.y[first] + margin > tracks.size.1 as f32;
    }
    order::sort_by_key(&mut ways, |&way| u64::from(order::f32_key(way)));
    is_at_rim && f64::from(ways[ways.len() / 2]) < CARRIED
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discontinuity::neighborhoods;
    use crate::rng::Rng;

    const SIZE: (usize, usize) = (480, 270);
    const FRAMES: usize = 19;
    /// What the camera goes each frame, in metres; it is a metre and a half above the ground.
    const SPEED: f64 = 0.4;

    /// A street: points of the ground, of walls on both sides, and of the backs of cars. A car is given by the place of
    /// its middle, and by what it goes forward each frame. Returns which trajectories are of which car, 0 for none.
    fn street(cars: &[(f64, f64, f64)]) -> (Trajectories, Vec<usize>) {
        let mut rng = Rng::for_stage(1, "street");
        let (mut tracks, mut of_car) = (Trajectories::empty(FRAMES, SIZE), Vec::new());
        let mut push = |x: f64, y: f64, z: f64, speed: f64, car: usize| {
            let seen = |t: usize| {
                let depth = z + (speed - SPEED) * t as f64;
                let at = ((240.0 + 300.0 * x / depth) as f32, (120.0 + 300.0 * y / depth) as f32);
                (depth > 1.0 && (0.0..480.0).contains(&at.0) && (0.0..270.0).contains(&at.1))
                    .then_some((at.0, at.1, 0.0))
            };
            let points: Vec<_> = (0..FRAMES).map_while(seen).collect();
            if points.len() > 1 {
                tracks.push(0, points);
                of_car.push(car);
            }
        };
        for _ in 0..700 {
            // Equally many at each height of the picture; none where a car stands or will.
            let (z, x) = (1.5 * 300.0 / rng.range(12.0, 140.0), rng.range(-6.0, 6.0));
            let hides = |&(middle, depth, speed): &(f64, f64, f64)| {
                let ways = [0.0, FRAMES as f64];
                (x / z - middle / depth).abs() < 1.2 / depth
                    && ways.iter().any(|t| z > depth + (speed * t) && z < 3.0 * depth + speed * t)
            };
            if !cars.iter().any(hides) {
                push(x, 1.5, z, 0.0, 0);
            }
        }
        for _ in 0..400 {
            push([-7.0, 7.0][rng.below(2)], rng.range(-4.0, 1.5), rng.range(8.0, 60.0), 0.0, 0);
        }
        for (k, &(x, z, speed)) in cars.iter().enumerate() {
            for i in 0..48 {
                push(x - 0.8 + 0.2 * (i % 8) as f64, 0.2 + 0.22 * (i / 8) as f64, z, speed, k + 1);
            }
        }
        (tracks, of_car)
    }

    /// The share of each car's trajectories, and of the street's before them, that are in objects.
    fn found(cars: &[(f64, f64, f64)]) -> Vec<f64> {
        let (tracks, of_car) = street(cars);
        let travel = Travel::of(&tracks).expect("the camera goes forward");
        let Parted { clusters, is_object } = part_rigid(&travel, &tracks, &neighborhoods(&tracks), 30.0);
        let mut counts = vec![(0.0, 0.0); cars.len() + 1];
        for (&car, &cluster) in of_car.iter().zip(&clusters.label) {
            let count: &mut (f64, f64) = &mut counts[car];
            *count = (count.0 + f64::from(u8::from(is_object[cluster as usize])), count.1 + 1.0);
        }
        counts.iter().map(|(objects, all)| objects / all).collect()
    }

    #[test]
    fn an_empty_street_has_no_objects() {
        assert!(found(&[])[0] < 0.01);
    }

    #[test]
    fn cars_ahead_and_oncoming_are_objects_and_parked_ones_are_not() {
        for (car, is_object) in [((-0.5, 12.0, 0.4), true), ((2.5, 30.0, -0.5), true), ((3.5, 16.0, 0.0), false)] {
            let found = found(&[car]);
            assert!(found[0] < 0.02, "{car:?} {found:?}");
            // Nothing is told of what is at the height of the focus.
            assert!(if is_object { found[1] > 0.6 } else { found[1] < 0.05 }, "{car:?} {found:?}");
        }
    }

    #[test]
    fn what_stands_still_in_the_picture_at_its_lower_rim_is_the_cameras_carrier() {
        let (mut tracks, of_car) = street(&[]);
        for k in 0..60 {
            tracks.push(0, (0..FRAMES).map(|_| (100.0 + 8.0 * (k % 30) as f32, 258.0 + 6.0 * (k / 30) as f32, 0.0)));
        }
        let travel = Travel::of(&tracks).expect("the camera goes forward");
        let parted = part_rigid(&travel, &tracks, &neighborhoods(&tracks), 30.0);
        let carrier = &parted.clusters.label[of_car.len()..];
        assert!(carrier.iter().all(|&c| !parted.is_object[c as usize]), "{parted:?}");
    }
}
