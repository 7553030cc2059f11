//! Per-pixel evidence for and against objects, by the background.
//!
//! In: frames, flow and segmented trajectories of a clip, and its camera. Out: log-odds of each superpixel to be an
//! object's, and cues of each cluster. Those of a still and of a moving camera are weighted by how surely it stands still.
//!
//! **Still camera.**
//! 1. The *plate* (`plate`) is the scene without its movers; each pixel of each frame has a distance from it. Frames do not
//!    count for the plate around trajectories that surely move.
//! 2. A cluster's cue is the mean distance of its trajectories from the plate (`StillScene::plate_distances`), with a
//!    fitted weight (`evidence`).
//! 3. Each superpixel has two cues, its mean distance from the plate and the mean length of its flow; their log-odds rise
//!    linearly up to a bound (`CueResponse`).
//!
//! **Moving camera.**
//! 1. Every second pixel has two *reprojection errors* (`reprojection`): the colour difference to other frames if it moves
//!    with the scene, and if it moves with the objects.
//! 2. The log-odds of a superpixel are the contrast of both errors, less a prior against objects, since plain areas, which
//!    have low errors both ways, are mostly scene.
//!
//! **Forward camera**, as from a car: objects are tracks that violate a rigid scene on a ground (`rigid_scene`); their
//! pixels have reprojection errors, too.
//!
//! With any camera, superpixels under trajectories of an uncertain cluster have a penalty. Not in the paper, which has no
//! background. Cost: O(pixels · reference frames). It fails where objects stand still for half of the clip, which puts them
//! on the plate, and on plain objects that move by a few pixels before their scene.

mod clean_plate;
mod plate;
mod reprojection;
mod rigid_scene;

pub(crate) use clean_plate::{CleanPlateInput, clean_plate};
pub(crate) use plate::Picture;
pub(crate) use reprojection::ObjectClusters;
pub use reprojection::SegmentedTracks;
#[cfg(any(feature = "wasm", test))]
pub(crate) use reprojection::{ReferenceFrame, WarpGrid};
pub(crate) use reprojection::{ReprojectionErrors, ReprojectionInput};
pub(crate) use rigid_scene::segment_rigid_scene;

use crate::camera::{Camera, CameraPath, ForwardMotion};
use crate::cut::pixel_index;
use crate::discretize::Clusters;
use crate::flow::{CompactFlow, Field};
use crate::image::{Frame, Plane};
use crate::superpixel::Superpixels;
use crate::trajectory::Trajectories;
use plate::{Plate, UNKNOWN_DISTANCE, reduce};
use reprojection::is_compared;

crate::params! {
    /// The background.
    pub struct BackgroundParams {
        /// Classifies clusters and superpixels by the background. Not in the paper.
        pub enabled: bool = true, in 0..=1;
        /// Still camera: motion that is as likely an object's as the background's, in pixels a frame.
        pub neutral_motion: f32 = 0.4, in 0.01..=100.0, expert;
        /// Still camera: weight of the log-odds by the distance from the plate.
        pub plate_weight: f32 = 0.8, in 0.0..=100.0, expert;
        /// Still camera: weight of the log-odds by motion.
        pub motion_weight: f32 = 0.3, in 0.0..=100.0, expert;
        /// Moving camera: weight of the reprojection errors, by the scene's motion against the objects'.
        pub reprojection_weight: f32 = 2.5, in 0.0..=100.0, expert;
        /// Moving camera: prior log-odds against an object in each superpixel.
        pub prior_log_odds: f32 = 1.3, in 0.0..=100.0, expert;
        /// Forward camera: takes tracks that violate a rigid scene on a ground for objects.
        pub rigid_scene: bool = true, in 0..=1, expert;
    }
}

// All constants of this file are chosen by eye.

/// Longest side of the reduced frames. Higher is slower.
const MAX_SIDE_PX: usize = 320;
/// Least distance between the ends of a trajectory that surely moves: swaying leaves come back.
const MIN_MOVER_PX: f32 = 7.0;
/// Factor on the scene's mean squared reprojection error above which pixels are outliers.
const OUTLIER_FACTOR: f32 = 4.0;
/// Least mean squared reprojection error of the scene, in grey levels squared.
const MIN_SCENE_ERROR_SQ: f32 = 100.0;
/// Reprojection error that is as likely noise as evidence, in grey levels.
const NOISE_ERROR: f32 = 10.0;
/// Part of the prior against objects that is waived where all trajectories are objects'.
const PRIOR_RELIEF: f32 = 0.5;
/// Weight of a cluster's penalty in the superpixels of its trajectories.
const PENALTY_WEIGHT: f32 = 2.0;

/// Log-odds of an object by a cue of 0 to 1.
struct CueResponse {
    /// Rise of the log-odds with the cue.
    slope: f32,
    /// Cue at which they are 0.
    neutral: f32,
    max_log_odds: f32,
}

const CUE_RESPONSE: CueResponse = CueResponse { slope: 8.0, neutral: 0.25, max_log_odds: 3.0 };
/// Value of an unknown cue; its log-odds are 0.
const UNKNOWN_CUE: f32 = -1.0;

impl CueResponse {
    fn log_odds(&self, cue: f32) -> f32 {
        if cue < 0.0 { 0.0 } else { (self.slope * (cue - self.neutral)).min(self.max_log_odds) }
    }
}

/// Background model of a clip, by the motion of its camera.
#[derive(Debug, Clone)]
pub struct Background {
    /// How surely the camera stands still, 0 to 1: the weight of the still scene; the moving one has the rest.
    stillness: f32,
    still: Option<StillScene>,
    moving: Option<MovingScene>,
    /// The camera's motion if it goes forward.
    forward: Option<ForwardMotion>,
}

/// Scene of a still camera: the distance of each pixel from the background plate.
#[derive(Debug, Clone)]
pub struct StillScene {
    /// One plane a frame, in 254ths, of the reduced size. [`UNKNOWN_DISTANCE`] where the plate is unknown.
    distance: Vec<Plane<u8>>,
}

/// Scene of a moving camera: the reprojection errors of each pixel.
#[derive(Debug, Clone)]
pub struct MovingScene {
    path: CameraPath,
    /// The frames, reduced by `step`.
    pictures: Vec<Picture>,
    step: usize,
    /// Errors of each frame; empty if not computed.
    errors: Vec<ReprojectionErrors>,
    /// Mean squared error that is as likely an outlier's as the scene's.
    outlier_threshold: f32,
}

impl Background {
    /// Builds the model from all frames of a clip, of equal sizes. With a still camera, pixels within `mover_radius` of
    /// moving trajectories are left out of the plate, which would have slow movers for as long as they take to pass.
    pub fn new(frames: &[Frame], camera: Camera, tracks: &Trajectories, mover_radius: f32) -> Self {
        let side = frames.first().map_or(1, |f| f.width().max(f.height()));
        let step = side.div_ceil(MAX_SIDE_PX).max(1);
        let pictures: Vec<Picture> = frames.iter().map(|frame| reduce(frame, step)).collect();
        let Camera { stillness, path, forward } = camera;
        let still = (stillness > 0.0).then(|| StillScene::new(&pictures, step, tracks, mover_radius));
        let moving = (stillness < 1.0).then_some(MovingScene {
            path,
            pictures,
            step,
            errors: Vec::new(),
            outlier_threshold: 0.0,
        });
        Self { stillness, still, moving, forward }
    }

    /// The camera's motion if it goes forward.
    pub(crate) fn forward(&self) -> Option<&ForwardMotion> {
        self.forward.as_ref()
    }

    /// The scene of a still camera, and its weight; `None` if the camera surely moves.
    pub(crate) fn still(&self) -> Option<(&StillScene, f32)> {
        Some((self.still.as_ref()?, self.stillness))
    }

    /// Number of frames with reprojection errors: none without an object or with a still camera.
    pub(crate) fn num_error_frames(&self, is_object: &[bool]) -> usize {
        self.moving.as_ref().filter(|_| is_object.contains(&true)).map_or(0, |scene| scene.pictures.len())
    }

    /// Gathers the input of the reprojection errors of frame `t`; `None` with a still camera.
    pub(crate) fn reprojection_input(&self, t: usize, segmented: SegmentedTracks<'_>) -> Option<ReprojectionInput> {
        let MovingScene { path, pictures, step, .. } = self.moving.as_ref()?;
        Some(ReprojectionInput::new(pictures, *step, t, path, segmented))
    }

    /// Computes the reprojection errors of all frames, if the camera moves.
    pub fn compute_reprojection_errors(&mut self, segmented: SegmentedTracks<'_>) {
        let frames = 0..self.num_error_frames(segmented.is_object);
        let errors = frames.filter_map(|t| Some(self.reprojection_input(t, segmented)?.errors())).collect();
        self.set_reprojection_errors(errors, segmented);
    }

    /// Stores the reprojection errors of every frame (empty if not computed) and calibrates the outlier threshold.
    pub(crate) fn set_reprojection_errors(&mut self, errors: Vec<ReprojectionErrors>, segmented: SegmentedTracks<'_>) {
        let Some(scene) = &mut self.moving else { return };
        scene.errors = errors;
        // The motion of the road between trajectories is badly known: high errors there are no outliers.
        scene.outlier_threshold = match self.forward {
            None => OUTLIER_FACTOR * scene.mean_sq_error(segmented).max(MIN_SCENE_ERROR_SQ),
            Some(_) => f32::MAX,
        };
    }

    /// Computes the log-odds of each superpixel to be an object's, frame by frame. `flows` has the flow of each pair of
    /// frames, `penalties` the log-odds against each label, or none.
    #[must_use]
    pub fn evidence(
        &self,
        superpixels: &[Superpixels],
        flows: &[CompactFlow],
        segmented: SegmentedTracks<'_>,
        penalties: &[f32],
        params: &BackgroundParams,
    ) -> Vec<f32> {
        let still = self.still.iter().map(|scene| (self.stillness, scene.evidence(superpixels, flows, params)));
        let moving =
            self.moving.iter().map(|scene| (1.0 - self.stillness, scene.evidence(superpixels, segmented, params)));
        let mut evidence = vec![0.0; superpixels.iter().map(|s| s.count).sum()];
        for (weight, values) in still.chain(moving) {
            evidence.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
        }
        subtract_penalties(&mut evidence, superpixels, segmented, penalties);
        evidence
    }
}

impl StillScene {
    fn new(pictures: &[Picture], step: usize, tracks: &Trajectories, mover_radius: f32) -> Self {
        let is_mover = mover_masks(pictures, step, tracks, mover_radius);
        let plate = Plate::new(pictures, |t, x, y| is_mover[t][(x, y)]);
        let distances = |plate: &Plate| pictures.iter().map(|p| plate.distance(p)).collect();
        Self { distance: plate.as_ref().map_or_else(Vec::new, distances) }
    }

    /// Mean distance of each cluster's trajectories from the plate, 0 to 1; 1 where it is unknown.
    pub(crate) fn plate_distances(&self, tracks: &Trajectories, clusters: &Clusters) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); clusters.count];
        for (i, &cluster) in clusters.label.iter().enumerate() {
            let (count, sum) = (tracks.points(i).len() as f64, &mut sums[cluster as usize]);
            *sum = (sum.0 + count * f64::from(self.mean_distance(tracks, i).unwrap_or(1.0)), sum.1 + count);
        }
        sums.iter().map(|&(sum, count): &(f64, f64)| sum / count.max(1.0)).collect()
    }

    /// Mean distance of trajectory `i` from the plate, 0 to 1.
    fn mean_distance(&self, tracks: &Trajectories, i: usize) -> Option<f32> {
        let reduced = |v: f32, from: usize, to: usize| ((v + 0.5).max(0.0) as usize * to / from.max(1)).min(to - 1);
        let (mut sum, mut count) = (0_u32, 0_u32);
        for t in tracks.frames(i) {
            let ((x, y), map) = (tracks.at(i, t)?, self.distance.get(t)?);
            let pixel = (reduced(x, tracks.size.0, map.width()), reduced(y, tracks.size.1, map.height()));
            if map[pixel] != UNKNOWN_DISTANCE {
                (sum, count) = (sum + u32::from(map[pixel]), count + 1);
            }
        }
        (count > 0).then(|| sum as f32 / (255 * count) as f32)
    }

    /// Weighted sum of the log-odds by the plate and by motion.
    fn evidence(&self, superpixels: &[Superpixels], flows: &[CompactFlow], params: &BackgroundParams) -> Vec<f32> {
        let mut evidence = Vec::new();
        for (t, s) in superpixels.iter().enumerate() {
            let zeros = || vec![0.0; s.count];
            let plate_cues = self.distance.get(t).map_or_else(zeros, |map| mean_cues(s, map));
            let flow = flows.get(t).or(flows.last());
            let motion_cues = flow.map_or_else(zeros, |flow| mean_cues(s, &motion_cue(flow, params.neutral_motion)));
            evidence.extend(plate_cues.into_iter().zip(motion_cues).map(|(plate, motion)| {
                params.plate_weight * CUE_RESPONSE.log_odds(plate)
                    + params.motion_weight * CUE_RESPONSE.log_odds(motion)
            }));
        }
        evidence
    }
}

impl MovingScene {
    /// Mean squared error of the scene's trajectories, by the scene's motion.
    fn mean_sq_error(&self, segmented: SegmentedTracks<'_>) -> f32 {
        let mut sums = ErrorSums::default();
        for i in (0..segmented.label.len()).filter(|&i| segmented.is_object_track(i) == Some(false)) {
            self.add_errors(segmented.tracks, i, &mut sums);
        }
        sums.mean_sq_scene()
    }

    /// Adds the errors in the 3×3 pixels around each point of trajectory `i`.
    fn add_errors(&self, tracks: &Trajectories, i: usize, sums: &mut ErrorSums) {
        for t in tracks.frames(i) {
            let (Some((x, y)), Some(errors)) = (tracks.at(i, t), self.errors.get(t)) else { continue };
            let (w, h) = (errors.width(), errors.height());
            let (x, y) = (reduced_coordinate(x, w, self.step), reduced_coordinate(y, h, self.step));
            for y in y.saturating_sub(1)..(y + 2).min(h) {
                let columns = x.saturating_sub(1)..(x + 2).min(w);
                columns.filter(|&x| is_compared(x, y)).for_each(|x| sums.add(errors[(x, y)]));
            }
        }
    }

    /// Log-odds by the reprojection errors, less the prior; 0 in frames without errors.
    fn evidence(
        &self,
        superpixels: &[Superpixels],
        segmented: SegmentedTracks<'_>,
        params: &BackgroundParams,
    ) -> Vec<f32> {
        let mut evidence = Vec::new();
        for (t, s) in superpixels.iter().enumerate() {
            let Some(errors) = self.errors.get(t) else {
                evidence.resize(evidence.len() + s.count, 0.0);
                continue;
            };
            let scores = object_scores(s, errors, self.outlier_threshold).into_iter();
            let shares = object_shares(s, t, segmented);
            evidence.extend(scores.zip(shares).map(|(score, share)| {
                let relief = 1.0 - PRIOR_RELIEF * share;
                params.reprojection_weight * score - params.prior_log_odds * relief
            }));
        }
        evidence
    }
}

/// Sums of squared errors over some pixels, and their number.
#[derive(Debug, Clone, Copy, Default)]
struct ErrorSums {
    scene: u64,
    object: u64,
    pixels: u64,
}

impl ErrorSums {
    fn new([scene, object, pixels]: [u64; 3]) -> Self {
        Self { scene, object, pixels }
    }

    fn add(&mut self, [scene, object]: [u8; 2]) {
        let [scene, object] = [scene, object].map(u64::from);
        (self.scene, self.object) = (self.scene + scene * scene, self.object + object * object);
        self.pixels += 1;
    }

    /// Returns how surely the pixels are not the scene's, from -1 to 1; 0 at a mean squared error of `threshold`.
    fn outlier_score(&self, threshold: f32) -> f32 {
        let error_sq = self.mean_sq_scene();
        (error_sq - threshold) / (error_sq + threshold)
    }

    /// Mean squared error by the scene's motion, in grey levels squared.
    fn mean_sq_scene(&self) -> f32 {
        self.scene as f32 / self.pixels.max(1) as f32
    }

    /// Compares both motions: -1 if only the scene's explains the pixels, 0 if both do alike, 1 if only the objects' does.
    fn object_score(&self) -> f32 {
        let [scene, object, pixels] = [self.scene, self.object, self.pixels].map(|v| v as f32);
        (scene - object) / (scene + object + NOISE_ERROR * NOISE_ERROR * pixels).max(1.0)
    }
}

/// Marks the pixels of each reduced frame that are within `radius` of a moving trajectory, in pixels of the frame.
fn mover_masks(pictures: &[Picture], step: usize, tracks: &Trajectories, radius: f32) -> Vec<Plane<bool>> {
    let mut masks: Vec<_> = pictures.iter().map(|p| Plane::filled(p.width(), p.height(), false)).collect();
    let radius = (radius / step as f32 + 0.5) as usize;
    for i in (0..tracks.len()).filter(|&i| net_displacement(tracks, i) > MIN_MOVER_PX) {
        for t in tracks.frames(i) {
            let (Some((x, y)), Some(mask)) = (tracks.at(i, t), masks.get_mut(t)) else { continue };
            let (w, h) = (mask.width(), mask.height());
            let (x, y) = (reduced_coordinate(x, w, step), reduced_coordinate(y, h, step));
            for y in y.saturating_sub(radius)..(y + radius + 1).min(h) {
                mask.row_mut(y)[x.saturating_sub(radius)..(x + radius + 1).min(w)].fill(true);
            }
        }
    }
    masks
}

/// Converts a coordinate of a frame to the pixel of the frame reduced by `step`, which has this side.
fn reduced_coordinate(v: f32, side: usize, step: usize) -> usize {
    (((v + 0.5).max(0.0) as usize) / step).min(side - 1)
}

/// Distance between the first and the last point of a trajectory, in pixels.
fn net_displacement(tracks: &Trajectories, i: usize) -> f32 {
    let points = tracks.points(i);
    let (first, last) = (points.start, points.end - 1);
    ((tracks.x[last] - tracks.x[first]).powi(2) + (tracks.y[last] - tracks.y[first]).powi(2)).sqrt()
}

/// Score of each superpixel for an object by its reprojection errors, -1 to 1.
fn object_scores(superpixels: &Superpixels, errors: &ReprojectionErrors, outlier_threshold: f32) -> Vec<f32> {
    let sums = superpixel_sums(superpixels, errors, |x, y| {
        let [scene, object] = errors[(x, y)].map(u32::from);
        if is_compared(x, y) { [scene * scene, object * object, 1] } else { [0; 3] }
    });
    let sums = sums.into_iter().map(ErrorSums::new);
    sums.map(|sums| sums.object_score().max(sums.outlier_score(outlier_threshold))).collect()
}

/// Sums `value_at(x, y)` of the pixels of a map, which may be smaller than the frame, over each superpixel.
fn superpixel_sums<T: Copy, const N: usize>(
    superpixels: &Superpixels,
    map: &Plane<T>,
    value_at: impl Fn(usize, usize) -> [u32; N],
) -> Vec<[u64; N]> {
    let (w, h) = superpixels.runs().size();
    let mut sums = vec![[0; N]; superpixels.count];
    // Prefix sums along a row of the map, by column of the frame: a superpixel has few runs of many pixels.
    let (mut prefix, mut row) = (vec![[0; N]; w + 1], usize::MAX);
    for (y, columns, s) in superpixels.runs().rows() {
        let map_row = y * map.height() / h;
        if map_row != row {
            row = map_row;
            for x in 0..w {
                let (sum, value) = (prefix[x], value_at(x * map.width() / w, row));
                prefix[x + 1] = std::array::from_fn(|k| sum[k] + value[k]);
            }
        }
        let (from, to) = (prefix[columns.start], prefix[columns.end]);
        sums[s as usize].iter_mut().zip(to.iter().zip(from)).for_each(|(sum, (to, from))| *sum += u64::from(to - from));
    }
    sums
}

/// Maps the length `l` of each pixel's flow to `l² / (l² + half²)`, in 254ths.
fn motion_cue(flow: &CompactFlow, half: f32) -> Plane<u8> {
    let (width, height) = flow.size();
    Plane::from_fn(width, height, |x, y| {
        let (u, v) = flow.at(x, y);
        let sq = u * u + v * v;
        (254.0 * sq / (sq + half * half)) as u8
    })
}

/// Subtracts from each superpixel's evidence the mean penalty of its trajectories; `penalties` has one for each label.
fn subtract_penalties(
    evidence: &mut [f32],
    superpixels: &[Superpixels],
    segmented: SegmentedTracks<'_>,
    penalties: &[f32],
) {
    if penalties.iter().all(|&penalty| penalty == 0.0) {
        return;
    }
    let mut first = 0;
    for (t, s) in superpixels.iter().enumerate() {
        let penalty = |i: usize| penalties.get(*segmented.label.get(i)? as usize).copied();
        for (evidence, mean) in evidence[first..].iter_mut().zip(superpixel_means(s, t, segmented, penalty)) {
            *evidence -= PENALTY_WEIGHT * mean;
        }
        first += s.count;
    }
}

/// Share of objects' trajectories in each superpixel of frame `t`.
fn object_shares(superpixels: &Superpixels, t: usize, segmented: SegmentedTracks<'_>) -> Vec<f32> {
    let share = |i: usize| Some(if segmented.is_object_track(i)? { 1.0 } else { 0.0 });
    superpixel_means(superpixels, t, segmented, share)
}

/// Mean over each superpixel of frame `t` of `value(i)` of its trajectories, without those that have none; 0 without any.
fn superpixel_means(
    superpixels: &Superpixels,
    t: usize,
    segmented: SegmentedTracks<'_>,
    value: impl Fn(usize) -> Option<f32>,
) -> Vec<f32> {
    let (superpixel, mut sums) = (superpixels.label(), vec![(0.0, 0.0_f32); superpixels.count]);
    for (i, x, y) in segmented.tracks.alive(t) {
        let Some(value) = value(i) else { continue };
        let sum = &mut sums[superpixel.data()[pixel_index(superpixels.runs().size(), x, y)] as usize];
        *sum = (sum.0 + value, sum.1 + 1.0);
    }
    sums.iter().map(|&(sum, count): &(f32, f32)| sum / count.max(1.0)).collect()
}

/// Mean of a map's known values over each superpixel, 0 to 1; the map may be smaller than the frame.
fn mean_cues(superpixels: &Superpixels, map: &Plane<u8>) -> Vec<f32> {
    let value = |value| if value == UNKNOWN_DISTANCE { [0; 2] } else { [u32::from(value), 1] };
    let sums = superpixel_sums(superpixels, map, |x, y| value(map[(x, y)]));
    let mean = |[sum, count]: [u64; 2]| if count == 0 { UNKNOWN_CUE } else { sum as f32 / (255 * count) as f32 };
    sums.into_iter().map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten frames of a flat scene, a bright square moving to the right before it.
    fn frames() -> Vec<Frame> {
        let frame = |t: usize| {
            let at = |i: usize| (i % 40, i / 40);
            let inside = |(x, y): (usize, usize)| (3 * t..3 * t + 6).contains(&x) && (8..14).contains(&y);
            let rgb = (0..40 * 20).flat_map(|i| [if inside(at(i)) { 200 } else { 80 }; 3]).collect();
            Frame::from_rgb(rgb, 40, 20).unwrap()
        };
        (0..10).map(frame).collect()
    }

    fn still_scene(frames: &[Frame], tracks: &Trajectories) -> StillScene {
        Background::new(frames, Camera::still(), tracks, 1.0).still.unwrap()
    }

    fn halves() -> Superpixels {
        let label = Plane::from_fn(40, 20, |x, y| if y < 7 { 0 } else { 1 + u32::from(x < 20) });
        Superpixels::from(&label)
    }

    #[test]
    fn slow_movers_are_not_on_the_plate() {
        // A bar of 20 pixels goes two a frame: in the middle of the frame it is there most of the time.
        let inside = |t: usize, x: usize, y: usize| (2 * t..2 * t + 20).contains(&x) && (8..14).contains(&y);
        let frame = |t: usize| {
            let grey = |i: usize| if inside(t, i % 40, i / 40) { 200 } else { 80 };
            Frame::from_rgb((0..40 * 20).flat_map(|i| [grey(i); 3]).collect(), 40, 20).unwrap()
        };
        let frames: Vec<Frame> = (0..10).map(frame).collect();
        let mut tracks = Trajectories::empty(10, (40, 20));
        for (x, y) in (0..20 * 6).map(|k| ((k % 20) as f32, (8 + k / 20) as f32)) {
            tracks.push(0, (0..10).map(|t| (x + 2.0 * t as f32, y, 0.0)));
        }
        let distance = |tracks: &Trajectories| still_scene(&frames, tracks).distance[0][(10, 10)];
        assert_eq!(distance(&Trajectories::empty(10, (40, 20))), 0);
        assert!(distance(&tracks) > 200);
    }

    #[test]
    fn movers_are_far_from_the_plate_and_the_scene_is_near() {
        let mut tracks = Trajectories::empty(10, (40, 20));
        tracks.push(0, (0..10).map(|t| (3.0 * t as f32 + 3.0, 11.0, 0.0)));
        tracks.push(0, (0..10).map(|_| (5.0, 2.0, 0.0)));
        let distances =
            still_scene(&frames(), &tracks).plate_distances(&tracks, &Clusters { count: 3, label: vec![0, 1] });
        assert!(distances[0] > 0.9 && distances[1..] == [0.0, 0.0], "{distances:?}");
    }

    /// Ten frames of a scene of random blocks that moves two pixels a frame to the left, and before it a square of other
    /// blocks that moves three to the right.
    fn pan_frames() -> Vec<Frame> {
        let grey =
            |u: usize, v: usize| crate::rng::Rng::for_stage((u / 3 * 1000 + v / 3) as u64, "scene").below(256) as u8;
        let frame = |t: usize| {
            let at = |i: usize| {
                let (x, y) = (i % 96, i / 96);
                let inside = (3 * t + 12..3 * t + 36).contains(&x) && (20..44).contains(&y);
                [if inside { grey(x + 600 - 3 * t, y) } else { grey(x + 2 * t, y) }; 3]
            };
            Frame::from_rgb((0..96 * 64).flat_map(at).collect(), 96, 64).unwrap()
        };
        (0..10).map(frame).collect()
    }

    /// Trajectories four pixels apart: object 1 and scene 0.
    fn pan_tracks() -> (Trajectories, Vec<u32>) {
        let (mut tracks, mut label) = (Trajectories::empty(10, (96, 64)), Vec::new());
        for (x, y) in (0..24 * 16).map(|k| (4 * (k % 24) + 2, 4 * (k / 24) + 2)) {
            let inside = (12..36).contains(&x) && (20..44).contains(&y);
            let speed = if inside { 3.0 } else { -2.0 };
            let frames = (0..10).take_while(|&t| (0.0..96.0).contains(&(x as f32 + speed * t as f32)));
            tracks.push(0, frames.map(|t| (x as f32 + speed * t as f32, y as f32, 0.0)));
            label.push(u32::from(inside));
        }
        (tracks, label)
    }

    #[test]
    fn with_a_moving_camera_superpixels_follow_the_motion_that_explains_them() {
        let params = BackgroundParams::default();
        let (tracks, label) = pan_tracks();
        let mut background = Background::new(&pan_frames(), Camera::panning(-2.0, 10), &tracks, 1.0);
        let segmented = SegmentedTracks { tracks: &tracks, label: &label, is_object: &[false, true] };
        background.compute_reprojection_errors(segmented);
        // The square of frame 4, and all around it.
        let inside = |x: usize, y: usize| (24..48).contains(&x) && (20..44).contains(&y);
        let plane = Plane::from_fn(96, 64, |x, y| u32::from(inside(x, y)));
        let superpixels = vec![Superpixels::from(&plane); 10];
        let evidence = background.evidence(&superpixels, &[], segmented, &[], &params);
        assert!(evidence[8] < -1.0 && evidence[9] > 1.0, "{evidence:?}");
    }

    #[test]
    fn penalties_count_in_superpixels_of_the_clusters_trajectories() {
        let mut tracks = Trajectories::empty(2, (40, 20));
        tracks.push(0, (0..2).map(|_| (5.0, 11.0, 0.0)));
        tracks.push(0, (0..2).map(|_| (7.0, 15.0, 0.0)));
        tracks.push(1, [(30.0, 11.0, 0.0)]);
        let mut evidence = vec![1.0; 6];
        let segmented = SegmentedTracks { tracks: &tracks, label: &[0, 1, 1], is_object: &[] };
        subtract_penalties(&mut evidence, &vec![halves(); 2], segmented, &[0.0, 0.5]);
        assert_eq!(
            evidence,
            [1.0, 1.0, 1.0 - PENALTY_WEIGHT * 0.25, 1.0, 1.0 - PENALTY_WEIGHT * 0.5, 1.0 - PENALTY_WEIGHT * 0.25]
        );
    }

    #[test]
    fn without_objects_the_evidence_is_zero() {
        let params = BackgroundParams::default();
        let (tracks, label) = pan_tracks();
        let mut background = Background::new(&pan_frames(), Camera::panning(-2.0, 10), &tracks, 1.0);
        let segmented = SegmentedTracks { tracks: &tracks, label: &label, is_object: &[false, false] };
        background.compute_reprojection_errors(segmented);
        let evidence = background.evidence(&vec![halves(); 10], &[], segmented, &[], &params);
        assert_eq!(evidence, vec![0.0; 30]);
    }

    #[test]
    fn log_odds_rise_with_the_cue_and_are_zero_if_unknown() {
        assert_eq!(CUE_RESPONSE.log_odds(UNKNOWN_CUE), 0.0);
        let log_odds: Vec<f32> = (0..=20).map(|k| CUE_RESPONSE.log_odds(k as f32 / 20.0)).collect();
        assert!(log_odds.is_sorted() && log_odds[0] < 0.0 && log_odds[20] == CUE_RESPONSE.max_log_odds, "{log_odds:?}");
    }

    #[test]
    fn superpixels_of_movers_have_positive_evidence() {
        let mut tracks = Trajectories::empty(10, (40, 20));
        for k in 0..5 {
            tracks.push(0, (0..10).map(|t| (3.0 * t as f32 + 1.0 + k as f32, 11.0, 0.0)));
            tracks.push(0, (0..10).map(|_| (7.0 * k as f32, 2.0, 0.0)));
        }
        let background = Background::new(&frames(), Camera::still(), &tracks, 1.0);
        let label: Vec<u32> = (0..10).map(|i| i % 2).collect();
        let superpixels = vec![halves(); 10];
        let segmented = SegmentedTracks { tracks: &tracks, label: &label, is_object: &[true, false] };
        let evidence = background.evidence(&superpixels, &[], segmented, &[], &BackgroundParams::default());
        assert_eq!(evidence.len(), 30);
        // In the first frame the square is on the left, in the last on the right; above there is nothing at any time.
        assert!(evidence[0] < 0.0 && evidence[27] < 0.0, "{evidence:?}");
        assert!(evidence[2] > evidence[1] && evidence[28] > evidence[29], "{evidence:?}");
    }
}
