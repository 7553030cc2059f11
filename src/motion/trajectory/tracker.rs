//! The tracker: moves live points along one flow field at a time and seeds new ones where none are near.

use super::TrajectoryParams;
use super::structure;
use super::trajectories::Trajectories;
use crate::flow::{CompactFlow, FlowField, local_flow_variation};
use crate::grid::Grid;
use crate::image::{BilinearAxis, BilinearPoint, Frame, Plane, sample_bilinear};
use crate::order;
use serde::{Deserialize, Serialize};

/// Distance of seeds from the frame border, in pixels (published tracker).
const SEED_MARGIN_PX: f32 = 4.0;
/// Decay of the higher threshold for seeds near the border, per pixel (published tracker).
const BORDER_DECAY_PER_PX: f32 = 0.1;
/// A track ends where |w + w'|² is at least this times |w|² + |w'|² plus the absolute bound; w' is the backward flow
/// (section 2 of Sundaram, Brox and Keutzer, ECCV 2010).
const CONSISTENCY_RELATIVE: f32 = 0.01;
/// Absolute part of this bound, in pixels squared (same source).
const CONSISTENCY_ABSOLUTE_PX_SQ: f32 = 0.5;
/// A track ends where |∇u|² + |∇v|² exceeds this times |w|² plus the absolute bound (same source).
const BOUNDARY_RELATIVE: f32 = 0.01;
/// Absolute part of this bound, in pixels per frame per pixel, squared (same source).
const BOUNDARY_ABSOLUTE: f32 = 0.002;

/// Most points that a track keeps beside it; more take longer to copy. Chosen by eye.
const MAX_RECENT: usize = 8;

/// `(x, y, variation)`.
type Point = (f32, f32, f32);

/// A trajectory in the making.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Track {
    number: u32,
    /// Frame of the first point of the current window.
    start: usize,
    /// All points but the recent ones.
    points: Vec<Point>,
    /// Number of points before the current window.
    num_past: usize,
    /// The latest points. They move to the others together, as the memory of these is far away, the further the longer tracks are.
    recent: [Point; MAX_RECENT],
    num_recent: usize,
}

impl Track {
    fn new(number: u32, start: usize, first: Point) -> Self {
        let mut track = Self { number, start, ..Self::default() };
        track.push(first);
        track
    }

    fn push(&mut self, point: Point) {
        if self.num_recent == MAX_RECENT {
            self.settle();
        }
        self.recent[self.num_recent] = point;
        self.num_recent += 1;
    }

    /// Moves the recent points to the others.
    fn settle(&mut self) {
        self.points.extend_from_slice(&self.recent[..self.num_recent]);
        self.num_recent = 0;
    }

    fn last_mut(&mut self) -> Option<&mut Point> {
        match self.num_recent {
            0 => self.points.last_mut(),
            count => Some(&mut self.recent[count - 1]),
        }
    }

    /// Returns the points after the first `skipped`: those of the current window begin after `num_past`.
    fn points(&self, skipped: usize) -> impl Iterator<Item = Point> {
        self.points.iter().chain(&self.recent[..self.num_recent]).copied().skip(skipped)
    }

    /// Returns the number of points of the current window.
    fn len(&self) -> usize {
        self.points.len() + self.num_recent - self.num_past
    }

    /// Drops all points but those of the current window, which begins `dropped` frames later, and `remembered` before them.
    fn advance(&mut self, dropped: usize, remembered: usize) {
        self.settle();
        self.num_past += dropped.saturating_sub(self.start).min(self.len());
        self.start = self.start.saturating_sub(dropped);
        self.points.drain(..self.num_past.saturating_sub(remembered));
        self.points.shrink_to_fit();
        self.num_past = self.num_past.min(remembered);
    }
}

/// Follows points through a clip, flow field by flow field.
///
/// Call [`Tracker::seed`] for frame 0; then for every pair of frames [`Tracker::follow`], and `seed` for the second frame;
/// finally [`Tracker::finish`]. A clip may be tracked in windows: between two windows its first frames are dropped.
///
/// # Examples
/// Tracks points over four frames without motion.
///
/// ```
/// use tracecut::flow::{CompactFlow, FlowField};
/// use tracecut::image::Plane;
/// use tracecut::trajectory::{Tracker, TrajectoryParams, structure};
///
/// let checks = Plane::from_fn(64, 48, |x, y| if (x / 5 + y / 5) % 2 == 0 { 60.0 } else { 180.0 });
/// let still = FlowField { u: Plane::filled(64, 48, 0.0), v: Plane::filled(64, 48, 0.0) };
/// let mut tracker = Tracker::new((64, 48), &TrajectoryParams::default());
/// tracker.seed(&structure(&checks));
/// for _ in 1..4 {
///     tracker.follow(&still, &CompactFlow::new(&still), &Plane::filled(32, 24, 0.0));
///     tracker.seed(&structure(&checks));
/// }
/// let tracks = tracker.finish();
/// assert!(tracks.len() > 20);
/// assert_eq!((tracks.frames(0), tracks.at(0, 0)), (0..4, tracks.at(0, 3)));
/// ```
#[derive(Debug, Clone)]
pub struct Tracker {
    params: TrajectoryParams,
    size: (usize, usize),
    pub(crate) state: TrackerState,
}

/// The tracks so far, with which another tracker of the same parameters can continue.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct TrackerState {
    /// The current frame.
    frame: usize,
    /// Number of the next new track.
    pub(crate) next_number: u32,
    live: Vec<Track>,
    ended: Vec<Track>,
}

impl Tracker {
    /// Creates a tracker for frames of `size` pixels.
    pub fn new(size: (usize, usize), params: &TrajectoryParams) -> Self {
        Self { params: params.clone(), size, state: TrackerState::default() }
    }

    /// Starts tracks in `frame`, the current one, where it has structure and no track is near, then moves all tracks to the next
    /// frame along the `forward` flow to it, and ends those that fail a check against the `backward` flow.
    pub fn track(&mut self, frame: &Frame, forward: &FlowField, backward: &FlowField) {
        self.seed(&structure(&frame.luma()));
        self.follow(forward, &CompactFlow::new(backward), &local_flow_variation(forward));
    }

    /// Starts tracks in the current frame at the points of the seed grid that have enough structure and no live track
    /// within one grid step. `structure` is [`super::structure`] of the frame.
    #[doc(hidden)] // For benchmarks.
    pub fn seed(&mut self, structure: &Plane<f32>) {
        let mean = structure.data().iter().sum::<f32>() / structure.data().len().max(1) as f32;
        let step = self.params.grid_step;
        let mut occupied = Grid::new(self.size.0, self.size.1, step);
        for track in &mut self.state.live {
            if let Some(&mut (x, y, _)) = track.last_mut() {
                occupied.add(track.number, x, y);
            }
        }
        let (w, h) = (self.size.0 as f32, self.size.1 as f32);
        for row in 0.. {
            let y = SEED_MARGIN_PX + row as f32 * step;
            if y >= h - SEED_MARGIN_PX {
                break;
            }
            for column in 0.. {
                let x = SEED_MARGIN_PX + column as f32 * step;
                if x >= w - SEED_MARGIN_PX {
                    break;
                }
                if !occupied.is_free(x, y) {
                    continue;
                }
                let border = libm::expf(-BORDER_DECAY_PER_PX * x.min(y).min(w - x).min(h - y));
                let lambda = sample_bilinear(structure, 0.5 * (x - 0.5), 0.5 * (y - 0.5));
                let has_structure = lambda > self.params.structure_mean * mean * (1.0 + 10.0 * border)
                    && lambda > self.params.structure_floor * (1.0 + border);
                if has_structure {
                    let (number, start) = (self.state.next_number, self.state.frame);
                    self.state.live.push(Track::new(number, start, (x, y, 0.0)));
                    self.state.next_number = number.wrapping_add(1);
                }
            }
        }
    }

    /// Moves every live track to the next frame and ends those that fail a check of the flow.
    ///
    /// `variation` is [`crate::flow::local_flow_variation`] of `forward`.
    #[doc(hidden)] // For benchmarks.
    pub fn follow(&mut self, forward: &FlowField, backward: &CompactFlow, variation: &Plane<f32>) {
        let TrackerState { live, ended, .. } = &mut self.state;
        live.retain_mut(|track| {
            let Some(point) = track.last_mut() else { return false };
            // σ has half the resolution: pixel 2k + 1/2 of the frame is pixel k there.
            point.2 = sample_bilinear(variation, (point.0 - 0.5) * 0.5, (point.1 - 0.5) * 0.5);
            let (x, y, sigma) = *point;
            let next = next_position(x, y, forward, backward);
            match next {
                Some((x, y)) => track.push((x, y, sigma)),
                None => ended.push(std::mem::take(track)),
            }
            next.is_some()
        });
        self.state.frame += 1;
    }

    /// Moves on to a window that begins `dropped` frames later, and numbers frames from there. Tracks keep their numbers;
    /// those that reach into the new window keep at most `remembered` points from before it.
    pub(crate) fn advance(&mut self, dropped: usize, remembered: usize) {
        self.state.frame = self.state.frame.saturating_sub(dropped);
        self.state.live.iter_mut().chain(&mut self.state.ended).for_each(|track| track.advance(dropped, remembered));
        self.state.live.retain(|track| track.len() > 0);
        self.state.ended.retain(|track| track.len() > 0);
    }

    /// Returns all tracks of at least the minimum length, ordered by first frame, then by position.
    #[must_use]
    pub fn finish(self) -> Trajectories {
        self.numbered().0
    }

    /// Returns what [`Tracker::finish`] does, and the number of each track; tracking may continue.
    pub(crate) fn numbered(&self) -> (Trajectories, Vec<u32>) {
        let long_tracks = self.long_tracks();
        let mut trajectories = Trajectories::empty(self.state.frame + 1, self.size);
        for track in &long_tracks {
            trajectories.push(track.start, track.points(track.num_past));
        }
        (trajectories, long_tracks.iter().map(|track| track.number).collect())
    }

    /// Returns the same tracks in the same order, with their points from before the current window; frames are numbered
    /// from the earliest of these. `None` if there are none.
    pub(crate) fn with_past(&self) -> Option<Trajectories> {
        let long_tracks = self.long_tracks();
        let num_past = long_tracks.iter().map(|track| track.num_past).max().filter(|&past| past > 0)?;
        let mut trajectories = Trajectories::empty(num_past + self.state.frame + 1, self.size);
        for track in long_tracks {
            trajectories.push(num_past + track.start - track.num_past, track.points(0));
        }
        Some(trajectories)
    }

    /// Returns the tracks of at least the minimum length, which is half of a short window and never below 2, sorted by
    /// first frame, y, x.
    fn long_tracks(&self) -> Vec<&Track> {
        let num_frames = self.state.frame + 1;
        let min_length = (self.params.min_length as usize).min(num_frames.div_ceil(2).max(2));
        let tracks = self.state.ended.iter().chain(&self.state.live);
        let mut long_tracks: Vec<&Track> = tracks.filter(|t| t.len() >= min_length).collect();
        let first = |track: &Track| track.points(track.num_past).next().unwrap_or_default();
        order::sort_by_key(&mut long_tracks, |t| u64::from(order::f32_key(first(t).0)));
        order::sort_by_key(&mut long_tracks, |t| order::pair_key(t.start as u32, order::f32_key(first(t).1)));
        long_tracks
    }
}

/// Returns the point's position in the next frame, or `None` if it leaves the image, fails the forward–backward check or
/// lies on a motion boundary.
fn next_position(x: f32, y: f32, forward: &FlowField, backward: &CompactFlow) -> Option<(f32, f32)> {
    let size = (forward.u.width(), forward.u.height());
    // Four of the five samples share a row or a column with the point itself.
    let sample = |x: BilinearAxis, y: BilinearAxis| {
        let point = BilinearPoint::between(size.0, x, y);
        (point.sample(&forward.u), point.sample(&forward.v))
    };
    let [column, row] = [BilinearAxis::new(x, size.0), BilinearAxis::new(y, size.1)];
    let (u, v) = sample(column, row);
    let (nx, ny) = (x + u, y + v);
    let (right, bottom) = ((size.0 - 1) as f32, (size.1 - 1) as f32);
    if !(0.0..=right).contains(&nx) || !(0.0..=bottom).contains(&ny) {
        return None;
    }
    let (bu, bv) = backward.sample(nx, ny);
    let mismatch = (u + bu).powi(2) + (v + bv).powi(2);
    let energy = u * u + v * v;
    if mismatch >= CONSISTENCY_RELATIVE * (energy + bu * bu + bv * bv) + CONSISTENCY_ABSOLUTE_PX_SQ {
        return None;
    }
    let [east, west] = [x + 1.0, x - 1.0].map(|x| sample(BilinearAxis::new(x, size.0), row));
    let [south, north] = [y + 1.0, y - 1.0].map(|y| sample(column, BilinearAxis::new(y, size.1)));
    let gradient = ((east.0 - west.0).powi(2) + (south.0 - north.0).powi(2))
        + ((east.1 - west.1).powi(2) + (south.1 - north.1).powi(2));
    if 0.25 * gradient > BOUNDARY_RELATIVE * energy + BOUNDARY_ABSOLUTE {
        return None;
    }
    Some((nx, ny))
}

#[cfg(test)]
mod tests {
    use super::super::structure;
    use super::*;

    fn texture(width: usize, height: usize) -> Plane<f32> {
        Plane::from_fn(width, height, |x, y| 20.0 + (crate::rng::mix((x / 2 * 7919 + y / 2) as u64) % 200) as f32)
    }

    fn uniform(width: usize, height: usize, u: f32, v: f32) -> FlowField {
        FlowField { u: Plane::filled(width, height, u), v: Plane::filled(width, height, v) }
    }

    fn track(frames: usize, flow: (f32, f32), params: &TrajectoryParams) -> Trajectories {
        let texture = structure(&texture(64, 48));
        let mut tracker = Tracker::new((64, 48), params);
        tracker.seed(&texture);
        for _ in 1..frames {
            let (forward, backward) = (uniform(64, 48, flow.0, flow.1), uniform(64, 48, -flow.0, -flow.1));
            tracker.follow(&forward, &CompactFlow::new(&backward), &Plane::filled(32, 24, 0.25));
            tracker.seed(&texture);
        }
        let tracks = tracker.finish();
        tracks.check().unwrap();
        tracks
    }

    #[test]
    fn a_translation_is_followed_exactly_until_the_border() {
        let tracks = track(10, (1.5, 0.25), &TrajectoryParams::default());
        assert!(tracks.len() > 20, "{} tracks", tracks.len());
        for i in 0..tracks.len() {
            let points = tracks.points(i);
            for (k, p) in points.clone().enumerate() {
                assert!((tracks.x[p] - tracks.x[points.start] - 1.5 * k as f32).abs() < 1e-3);
                assert_eq!(tracks.variation[p], if p + 1 < points.end { 0.25 } else { tracks.variation[p] });
            }
            let stopped_early = tracks.frames(i).end < 10;
            assert!(!stopped_early || tracks.x[points.end - 1] + 1.5 > 63.0, "track {i} stopped inside");
        }
    }

    #[test]
    fn after_an_advance_tracks_go_on_with_their_numbers_and_their_past() {
        let texture = structure(&texture(64, 48));
        let mut tracker = Tracker::new((64, 48), &TrajectoryParams::default());
        tracker.seed(&texture);
        let follow = |tracker: &mut Tracker| {
            let (forward, backward) = (uniform(64, 48, 0.5, 0.0), uniform(64, 48, -0.5, 0.0));
            tracker.follow(&forward, &CompactFlow::new(&backward), &Plane::filled(32, 24, 0.25));
            tracker.seed(&texture);
        };
        (1..12).for_each(|_| follow(&mut tracker));
        let (before, numbers) = tracker.numbered();
        assert!(tracker.with_past().is_none());
        tracker.advance(7, 100);
        (12..20).for_each(|_| follow(&mut tracker));
        let ((after, later), long) = (tracker.numbered(), tracker.with_past().unwrap());
        assert_eq!((after.num_frames, long.num_frames, after.len()), (13, 20, long.len()));
        after.check().unwrap();
        long.check().unwrap();
        let mut common = 0;
        for (i, number) in later.iter().enumerate() {
            for t in after.frames(i) {
                assert_eq!(after.at(i, t), long.at(i, t + 7));
            }
            if let Some(old) = numbers.iter().position(|n| n == number) {
                common += 1;
                before.frames(old).for_each(|t| assert_eq!(before.at(old, t), long.at(i, t)));
            }
        }
        assert!(common > 15, "{common} of {}", later.len());
        (0..40).for_each(|_| follow(&mut tracker));
        tracker.advance(50, 20);
        assert!(tracker.with_past().is_none_or(|long| long.num_frames <= 3 + 20));
    }

    #[test]
    fn uncovered_area_is_seeded_again() {
        let tracks = track(20, (2.0, 0.0), &TrajectoryParams::default());
        assert!(tracks.start_frame.iter().any(|&s| s > 0));
        for frame in 0..20 {
            let alive: Vec<_> = tracks.alive(frame).collect();
            for (k, a) in alive.iter().enumerate() {
                assert!(alive[k + 1..].iter().all(|b| (a.1 - b.1).powi(2) + (a.2 - b.2).powi(2) > 63.9));
            }
        }
    }

    #[test]
    fn inconsistent_flow_and_motion_boundaries_end_tracks() {
        let forward = uniform(64, 48, 2.0, 0.0);
        let compact = |u| CompactFlow::new(&uniform(64, 48, u, 0.0));
        assert!(next_position(30.0, 20.0, &forward, &compact(-2.0)).is_some());
        assert!(next_position(30.0, 20.0, &forward, &compact(0.0)).is_none());
        assert!(next_position(63.0, 20.0, &forward, &compact(-2.0)).is_none());
        let edge = FlowField { u: Plane::from_fn(64, 48, |x, _| if x < 32 { 0.0 } else { 0.5 }), v: forward.v.clone() };
        let back = FlowField { u: edge.u.map(|u| -u), v: forward.v.clone() };
        assert!(next_position(31.5, 20.0, &edge, &CompactFlow::new(&back)).is_none());
    }

    #[test]
    fn flat_and_tiny_frames_give_no_tracks() {
        for (w, h) in [(1, 1), (17, 3), (64, 48)] {
            let mut tracker = Tracker::new((w, h), &TrajectoryParams::default());
            tracker.seed(&structure(&Plane::filled(w, h, 80.0)));
            tracker.follow(
                &uniform(w, h, 0.0, 0.0),
                &CompactFlow::new(&uniform(w, h, 0.0, 0.0)),
                &Plane::filled(w.div_ceil(2), h.div_ceil(2), 0.0),
            );
            assert!(tracker.finish().is_empty());
        }
    }
}
