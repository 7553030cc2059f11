//! Moving objects before a rigid scene that the camera drives into, as from a car.
//!
//! In pairs of frames each point has an inverse depth ([`ForwardMotion`]). The ground is the plane through the focus of
//! expansion, along which inverse depth grows linearly with the distance below the focus in the image. A track violates
//! the rigid scene where
//! 1. it moves across its line from the focus, or towards the focus;
//! 2. it is farther than the ground at its place: no part of the scene lies below the ground;
//! 3. it is nearer, so that it would stand on ground further down in the image, and yet the ground between is visible,
//!    which anything standing there would hide. This separates oncoming cars from parked ones.
//!
//! Not in the paper. Lengths are in pixels of a frame whose longest side has 480 ([`FrameScale`]). Cost: O(points · slopes)
//! for each pair of frames, and a search of the ground for points that seem near. **Limits.** Nothing is known at the
//! height of the focus. An object that moves exactly as the scene at its place counts as scene. Whatever hangs below the height of
//! the focus counts as an object.

use super::reprojection::ObjectClusters;
use crate::camera::{ForwardMotion, FramePair, FrameScale, RadialMotion};
use crate::discontinuity::Neighborhoods;
use crate::discretize::Clusters;
use crate::order;
use crate::sets::DisjointSets;
use crate::trajectory::Trajectories;

// All constants of this file are chosen by eye, on clips from cars.

/// Least distance below the focus at which there is ground.
const MIN_GROUND_OFFSET_PX: f64 = 8.0;
/// Slopes of the ground that are tried, as inverse depth by pixel: the first, the factor to the next, and their number.
const FIRST_SLOPE: f64 = 3e-4;
const SLOPE_FACTOR: f64 = 1.1;
const NUM_SLOPES: usize = 62;
/// Largest factor between the inverse depths of the ground and of its points.
const GROUND_TOLERANCE: f64 = 1.2;
/// Side of the cells in which the ground is counted, and their least number.
const GROUND_CELL_PX: f64 = 16.0;
const MIN_GROUND_CELLS: usize = 5;
/// Largest motion of the scene across its line, plus this part of the motion along it.
const MAX_OFF_LINE_PX: f64 = 1.0;
const MAX_OFF_LINE_RATIO: f64 = 0.1;
/// Largest motion of the scene towards the focus.
const MAX_INWARD_PX: f64 = 1.0;
/// Inverse depths, as parts of the ground's, below and above which a point is not on it ...
const MAX_FAR_RATIO: f64 = 0.6;
const MIN_NEAR_RATIO: f64 = 1.3;
/// ... if that makes a difference of this much motion.
const MIN_VISIBLE_PX: f64 = 2.0;
/// Ground in front of a point is searched this far to either side, from this far below the point to this part of the way
/// to its foot: ground beside a standing thing is visible, too.
const FOOT_SIDE_PX: f64 = 10.0;
const FOOT_GAP_PX: f64 = 6.0;
const FOOT_REACH: f64 = 0.85;
/// Fewest trajectories of an object.
const MIN_TRACKS: usize = 5;
/// Largest difference of the motions of neighbours in one object, by span of a frame pair.
const MAX_GROUP_MOTION_PX: f64 = 6.0;
/// Largest motion of the vehicle that carries the camera, seen at the lower frame border.
const MAX_CARRIER_MOTION_PX: f64 = 3.0;

/// Splits the trajectories into moving objects and the scene, the first cluster. `max_edge` is the longest edge between
/// trajectories of one object, in pixels.
pub(crate) fn segment_rigid_scene(
    motion: &ForwardMotion,
    tracks: &Trajectories,
    neighborhoods: &Neighborhoods,
    max_edge: f32,
) -> ObjectClusters {
    let is_moving = moving_tracks(motion, tracks.len());
    let rules = GroupRules { tracks, max_edge, pixel: (1.0 / motion.scale.factor) as f32 };
    let mut label = vec![0; tracks.len()];
    let mut count = 0;
    for members in rules.groups(neighborhoods, &is_moving) {
        if members.len() >= MIN_TRACKS && !rules.is_carrier(&members) {
            count += 1;
            members.iter().for_each(|&i| label[i] = count);
        }
    }
    let clusters = Clusters::from_labels(tracks, label.clone());
    let mut is_object = vec![false; clusters.count];
    clusters.label.iter().zip(&label).for_each(|(&new, &old)| is_object[new as usize] = old > 0);
    ObjectClusters { clusters, is_object }
}

/// Marks tracks that violate the rigid scene in most informative frame pairs.
fn moving_tracks(motion: &ForwardMotion, num_tracks: usize) -> Vec<bool> {
    let pairs: Vec<PairMotion> =
        motion.pairs.iter().map(|pair| PairMotion { pair, radial: pair.radial_motions() }).collect();
    let mut slopes: Vec<f64> = pairs.iter().filter_map(|pair| pair.ground_slope(motion.scale)).collect();
    order::sort_by_key(&mut slopes, |&slope| order::f64_key(slope));
    let slope = slopes.get(slopes.len() / 2).copied();
    let mut votes = vec![0_i32; num_tracks];
    for pair in &pairs {
        for (k, &(i, _)) in pair.pair.motions.iter().enumerate() {
            if is_off_line(&pair.radial[k]) || pair.is_off_scene(k, slope) {
                votes[i] += 1;
            } else if pair.is_informative(k, slope) {
                votes[i] -= 1;
            }
        }
    }
    votes.iter().map(|&votes| votes > 0).collect()
}

/// Returns `true` for motion that leaves its line from the focus.
fn is_off_line(radial: &RadialMotion) -> bool {
    radial.off_line.abs() > MAX_OFF_LINE_PX + MAX_OFF_LINE_RATIO * (radial.inverse_depth * radial.radius).abs()
}

/// A pair of frames, and the radial motion of each of its points.
struct PairMotion<'a> {
    pair: &'a FramePair,
    radial: Vec<RadialMotion>,
}

impl PairMotion<'_> {
    /// Returns the slope of the ground, as inverse depth by pixel below the focus, that most cells agree on.
    fn ground_slope(&self, scale: FrameScale) -> Option<f64> {
        let columns = (scale.width / GROUND_CELL_PX) as usize + 1;
        let rows = (scale.height / GROUND_CELL_PX) as usize + 1;
        let mut best = (MIN_GROUND_CELLS - 1, None);
        let mut slope = FIRST_SLOPE;
        for _ in 0..NUM_SLOPES {
            slope *= SLOPE_FACTOR;
            let mut is_ground_cell = vec![false; columns * rows];
            for (k, (_, point)) in self.pair.motions.iter().enumerate() {
                if self.is_ground(k, slope) {
                    let cell = |v: f64, count: usize| ((v / GROUND_CELL_PX).max(0.0) as usize).min(count - 1);
                    is_ground_cell[cell(point.y, rows) * columns + cell(point.x, columns)] = true;
                }
            }
            let count = is_ground_cell.iter().filter(|&&is_ground| is_ground).count();
            if count > best.0 {
                best = (count, Some(slope));
            }
        }
        best.1
    }

    fn is_ground(&self, k: usize, slope: f64) -> bool {
        let (offset, radial) = (self.pair.offset_below_focus(k), &self.radial[k]);
        let expected = slope * offset;
        offset > MIN_GROUND_OFFSET_PX
            && radial.inverse_depth < GROUND_TOLERANCE * expected
            && expected < GROUND_TOLERANCE * radial.inverse_depth
            && !is_off_line(radial)
    }

    /// Returns `true` if point `k` moves along its line as no point of a rigid scene on this ground does.
    fn is_off_scene(&self, k: usize, slope: Option<f64>) -> bool {
        let (radial, offset) = (&self.radial[k], self.pair.offset_below_focus(k));
        if radial.inverse_depth * radial.radius < -MAX_INWARD_PX {
            return true;
        }
        let Some(slope) = slope.filter(|_| offset > MIN_GROUND_OFFSET_PX) else { return false };
        let expected = slope * offset;
        let is_visible = (radial.inverse_depth - expected).abs() * radial.radius > MIN_VISIBLE_PX;
        let is_farther = radial.inverse_depth < MAX_FAR_RATIO * expected;
        let is_nearer = radial.inverse_depth > MIN_NEAR_RATIO * expected;
        is_visible && (is_farther || is_nearer && self.is_floating(k, slope))
    }

    /// Returns `true` if a point at this place that is farther than the ground would be noticed.
    fn is_informative(&self, k: usize, slope: Option<f64>) -> bool {
        let offset = self.pair.offset_below_focus(k);
        let min_difference = |slope: f64| (1.0 - MAX_FAR_RATIO) * slope * offset * self.radial[k].radius;
        offset > MIN_GROUND_OFFSET_PX && slope.is_some_and(|slope| min_difference(slope) > MIN_VISIBLE_PX)
    }

    /// Returns `true` if ground is visible that a thing standing on it at the depth of point `k` would hide.
    fn is_floating(&self, k: usize, slope: f64) -> bool {
        let (x, offset) = (self.pair.motions[k].1.x, self.pair.offset_below_focus(k));
        let foot = self.radial[k].inverse_depth / slope;
        let is_in_front = |j: usize| {
            (self.pair.motions[j].1.x - x).abs() < FOOT_SIDE_PX
                && (offset + FOOT_GAP_PX..FOOT_REACH * foot).contains(&self.pair.offset_below_focus(j))
        };
        (0..self.radial.len()).any(|j| is_in_front(j) && self.is_ground(j, slope))
    }
}

/// Rules by which moving tracks form objects.
struct GroupRules<'a> {
    tracks: &'a Trajectories,
    /// Longest edge between trajectories of one object, in pixels.
    max_edge: f32,
    /// Pixels of the frame in a scaled pixel.
    pixel: f32,
}

impl GroupRules<'_> {
    /// Connected groups of moving tracks that are neighbours and move alike.
    fn groups(&self, neighborhoods: &Neighborhoods, is_moving: &[bool]) -> Vec<Vec<usize>> {
        let num_tracks = self.tracks.len();
        let mut sets = DisjointSets::new(num_tracks);
        for t in 0..self.tracks.num_frames {
            for &pair in neighborhoods.frame(t) {
                let (i, j) = neighborhoods.pairs[pair as usize];
                let (i, j) = (i as usize, j as usize);
                if is_moving[i] && is_moving[j] && self.is_near(i, j, t) && self.moves_alike(i, j) {
                    sets.join(i, j);
                }
            }
        }
        let mut groups = vec![Vec::new(); num_tracks];
        (0..num_tracks).filter(|&i| is_moving[i]).for_each(|i| groups[sets.root(i)].push(i));
        groups.retain(|members| !members.is_empty());
        groups
    }

    fn is_near(&self, i: usize, j: usize, t: usize) -> bool {
        let (Some(a), Some(b)) = (self.tracks.at(i, t), self.tracks.at(j, t)) else { return false };
        (a.0 - b.0).powi(2) + (a.1 - b.1).powi(2) <= self.max_edge * self.max_edge
    }

    /// Returns `true` if two tracks have nearly the same displacement over their common frames.
    fn moves_alike(&self, i: usize, j: usize) -> bool {
        let (a, b) = (self.tracks.frames(i), self.tracks.frames(j));
        let (first, last) = (a.start.max(b.start), a.end.min(b.end).saturating_sub(1));
        let displacement = |i: usize| {
            let (from, to) = (self.tracks.at(i, first)?, self.tracks.at(i, last)?);
            Some((to.0 - from.0, to.1 - from.1))
        };
        let (Some(p), Some(q)) = (displacement(i), displacement(j)) else { return false };
        let spans = ((last - first) as f32 / ForwardMotion::PAIR_SPAN_FRAMES as f32).max(1.0);
        (p.0 - q.0).abs().max((p.1 - q.1).abs()) <= MAX_GROUP_MOTION_PX as f32 * self.pixel * spans
    }

    /// Returns `true` if a group stands still in the image at the lower frame border: a part of the camera's vehicle.
    fn is_carrier(&self, members: &[usize]) -> bool {
        let tracks = self.tracks;
        let mut displacements: Vec<f32> = Vec::new();
        let mut is_at_border = false;
        for &i in members {
            let points = tracks.points(i);
            let (first, last) = (points.start, points.end - 1);
            let (dx, dy) = (tracks.x[last] - tracks.x[first], tracks.y[last] - tracks.y[first]);
            displacements.push(dx.abs().max(dy.abs()) / self.pixel);
            is_at_border |= tracks.y[first] + self.max_edge > tracks.size.1 as f32;
        }
        order::sort_by_key(&mut displacements, |&length| u64::from(order::f32_key(length)));
        is_at_border && f64::from(displacements[displacements.len() / 2]) < MAX_CARRIER_MOTION_PX
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discontinuity::neighborhoods;
    use crate::rng::Rng;

    const SIZE: (usize, usize) = (480, 270);
    const FRAMES: usize = 19;
    /// Motion of the camera in metres a frame; it is a metre and a half above the ground.
    const SPEED: f64 = 0.4;

    /// A street: points of the ground, of walls on both sides, and of the backs of cars. A car is `(x, z, speed)`:
    /// its centre, and its forward motion in a frame. Returns the car of each trajectory, 0 for none.
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
            // Equally many at each height of the image; none where a car stands or will.
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

    /// Returns the share of trajectories in objects: the street's first, then each car's.
    fn object_shares(cars: &[(f64, f64, f64)]) -> Vec<f64> {
        let (tracks, of_car) = street(cars);
        let motion = ForwardMotion::estimate(&tracks).expect("the camera goes forward");
        let ObjectClusters { clusters, is_object } =
            segment_rigid_scene(&motion, &tracks, &neighborhoods(&tracks), 30.0);
        let mut counts = vec![(0.0, 0.0); cars.len() + 1];
        for (&car, &cluster) in of_car.iter().zip(&clusters.label) {
            let count: &mut (f64, f64) = &mut counts[car];
            *count = (count.0 + f64::from(u8::from(is_object[cluster as usize])), count.1 + 1.0);
        }
        counts.iter().map(|(objects, total)| objects / total).collect()
    }

    #[test]
    fn an_empty_street_has_no_objects() {
        assert!(object_shares(&[])[0] < 0.01);
    }

    #[test]
    fn cars_ahead_and_oncoming_are_objects_and_parked_ones_are_not() {
        for (car, is_object) in [((-0.5, 12.0, 0.4), true), ((2.5, 30.0, -0.5), true), ((3.5, 16.0, 0.0), false)] {
            let shares = object_shares(&[car]);
            assert!(shares[0] < 0.02, "{car:?} {shares:?}");
            // Nothing is known at the height of the focus.
            assert!(if is_object { shares[1] > 0.6 } else { shares[1] < 0.05 }, "{car:?} {shares:?}");
        }
    }

    #[test]
    fn tracks_that_stand_still_at_the_lower_frame_border_are_the_cameras_vehicle() {
        let (mut tracks, of_car) = street(&[]);
        for k in 0..60 {
            tracks.push(0, (0..FRAMES).map(|_| (100.0 + 8.0 * (k % 30) as f32, 258.0 + 6.0 * (k / 30) as f32, 0.0)));
        }
        let motion = ForwardMotion::estimate(&tracks).expect("the camera goes forward");
        let segmented = segment_rigid_scene(&motion, &tracks, &neighborhoods(&tracks), 30.0);
        let carrier = &segmented.clusters.label[of_car.len()..];
        assert!(carrier.iter().all(|&c| !segmented.is_object[c as usize]), "{segmented:?}");
    }
}
