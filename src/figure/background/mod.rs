//! What can be told from the background: objects are what does not go with it.
//!
//! In: frames, flow and labelled trajectories of a clip, and what its camera does. Out: which clusters are objects, and
//! for each superpixel what its pixels say for or against one.
//!
//! **Where the camera stands still.**
//! 1. The *plate* (`plate`) is the scene without what moves; each pixel of each frame has a distance from it. Around
//!    trajectories that surely move frames do not count for the plate.
//! 2. What is known of a cluster is how far its trajectories are from the plate (`StillScene::unlike_plate`); what that is
//!    worth is fitted (`evidence`).
//! 3. Each superpixel has two *cues*, its mean distance from the plate and the mean length of its flow, each worth
//!    log-odds that rise with it. What lies under trajectories of a cluster that is hardly an object is doubted
//!    (`add_doubts`), here and where the camera moves.
//!
//! **Where the camera moves.**
//! 1. Every second pixel has two *accounts* (`compare`): how well it is found again in other frames if it goes with the
//!    scene, and if it goes with the objects.
//! 2. Superpixels have the verdict of their pixels. What is found again either way, since it is plain, is doubted to be
//!    an object.
//! 3. Where no cluster is an object, salient trajectories that move alike are tried (`stand_out`).
//!
//! **Where the camera goes forward**, as in a car, objects are what no rigid scene on a ground explains (`rigid`); their
//! pixels are judged by the two accounts.
//!
//! Not in the paper, which has no background. **Limits.** What stands still for more than half of the clip is the plate.
//! An object that moves no more than a few pixels before its scene is doubted where it is plain.

mod clean;
mod compare;
mod plate;
mod rigid;
mod stand_out;

pub(crate) use clean::{PlateInput, clean_plate};
pub(crate) use rigid::{Parted, part_rigid};
pub(crate) use stand_out::{Clustering, stand_out};

use crate::camera::{Camera, CameraPath, Travel};
use crate::cut::pixel_of;
use crate::discretize::Clusters;
use crate::flow::{CompactFlow, Field};
use crate::image::{Frame, Plane};
use crate::superpixel::Superpixels;
use crate::trajectory::Trajectories;
pub(crate) use compare::{Accounts, Sought};
#[cfg(any(feature = "wasm", test))]
pub(crate) use compare::{Lattice, Other};
use compare::{Verdict, is_sought, object};
pub(crate) use plate::Picture;
use plate::{Plate, UNKNOWN, picture};

crate::params! {
    /// The background.
    pub struct BackgroundParams {
        /// Whether clips are judged by their background. Not in the paper.
        pub enabled: bool = true, in 0..=1;
        /// Where the camera stands still: motion that is as much object as background, in pixels a frame.
        pub neutral_motion: f32 = 0.4, in 0.01..=100.0, expert;
        /// Where the camera stands still: weight of the log-odds by the distance from the plate.
        pub plate_weight: f32 = 0.8, in 0.0..=100.0, expert;
        /// Where the camera stands still: weight of the log-odds by motion.
        pub motion_weight: f32 = 0.3, in 0.0..=100.0, expert;
        /// Where the camera moves: weight of which motion explains a superpixel in other frames, the scene's or the
        /// objects'.
        pub reprojection_weight: f32 = 2.5, in 0.0..=100.0, expert;
        /// Where the camera moves: what speaks against an object in each superpixel before anything is known.
        pub prior_log_odds: f32 = 1.3, in 0.0..=100.0, expert;
        /// Where the camera goes forward: whether objects are what no rigid scene on a ground explains.
        pub rigid_scene: bool = true, in 0..=1, expert;
        /// Where the camera moves and no cluster is an object: whether salient trajectories that move alike are some.
        pub salient_fallback: bool = true, in 0..=1, expert;
    }
}

/// Longest side at which backgrounds are compared, in pixels. Higher is slower.
const SIDE: usize = 320;
/// What ends further from where it began than this, in pixels, moves: what only sways comes back.
const MOVED: f32 = 7.0;
/// The value of a cue that is not known.
const NEUTRAL: f32 = -1.0;
/// Log-odds of an object by a cue: how much they rise with it, where they are 0, and the most.
const CUE: (f32, f32, f32) = (8.0, 0.25, 3.0);
/// What differs from its place in the scene by this many times the scene's own mean square is none of it.
const APART: f32 = 4.0;
/// What is left of the doubt where only trajectories of objects are, is one less this.
const TRUST: f32 = 0.5;
/// Weight of what speaks against a cluster, in superpixels where its trajectories are.
const OPINION: f32 = 4.0;
/// The least of which, in grey levels squared.
const LEAST: f32 = 100.0;

/// Trajectories, the cluster of each, and whether each cluster is an object. Other labels do not count.
#[derive(Debug, Clone, Copy)]
pub struct LabelledTracks<'a> {
    /// The trajectories.
    pub tracks: &'a Trajectories,
    /// Label of each trajectory.
    pub label: &'a [u32],
    /// Whether each label is an object.
    pub is_object: &'a [bool],
}

/// Per-pixel evidence for and against objects, by what the camera does.
#[derive(Debug, Clone)]
pub enum Background {
    /// The camera stands still.
    Still(StillScene),
    /// The camera moves.
    Moving(MovingScene),
    /// The camera goes forward, as in a car.
    Forward(Travel, MovingScene),
}

/// The scene before a still camera: the distance of each pixel from the background plate.
#[derive(Debug, Clone)]
pub struct StillScene {
    /// One plane a frame, in 255ths; may be smaller than frames. [`UNKNOWN`] where the plate is not known.
    distance: Vec<Plane<u8>>,
}

/// The scene before a moving camera: how well pixels are found again in other frames.
#[derive(Debug, Clone)]
pub struct MovingScene {
    path: CameraPath,
    /// The frames, reduced by `step`.
    pictures: Vec<Picture>,
    step: usize,
    /// How well the motions of scene and objects explain the pixels of each frame, once there are objects.
    accounts: Vec<Accounts>,
    /// What differs from its place in the scene by this mean square is as much none of it as not.
    strange: f32,
}

impl Background {
    /// Of all frames of a clip, which have equal sizes. Around trajectories that move, as far as `reach` pixels, frames are
    /// not the scene's: what moves slowly would be in the plate for as long as it takes to pass.
    pub fn new(frames: &[Frame], camera: Camera, tracks: &Trajectories, reach: f32) -> Self {
        let side = frames.first().map_or(1, |f| f.width().max(f.height()));
        let step = side.div_ceil(SIDE).max(1);
        let pictures: Vec<Picture> = frames.iter().map(|frame| picture(frame, step)).collect();
        let moving = |path, pictures| MovingScene { path, pictures, step, accounts: Vec::new(), strange: 0.0 };
        match camera {
            Camera::Still => Self::Still(StillScene::new(&pictures, step, tracks, reach)),
            Camera::Moving(path) => Self::Moving(moving(path, pictures)),
            Camera::Forward(path, travel) => Self::Forward(travel, moving(path, pictures)),
        }
    }

    fn moving(&self) -> Option<&MovingScene> {
        match self {
            Self::Still(_) => None,
            Self::Moving(scene) | Self::Forward(_, scene) => Some(scene),
        }
    }

    /// Number of frames with accounts where labels are objects or not: none where no label is one.
    pub(crate) fn num_accounts(&self, is_object: &[bool]) -> usize {
        self.moving().filter(|_| is_object.contains(&true)).map_or(0, |scene| scene.pictures.len())
    }

    /// What the accounts of the pixels of frame `t` are made from by these trajectories; `None` where the camera stands
    /// still.
    pub(crate) fn sought(&self, t: usize, labelled: LabelledTracks<'_>) -> Option<Sought> {
        let LabelledTracks { tracks, label, is_object } = labelled;
        let MovingScene { path, pictures, step, .. } = self.moving()?;
        Some(Sought::new(pictures, *step, t, path, (tracks, label), is_object))
    }

    /// Where the camera moves: compares the pixels of all frames with where scene and objects are in other frames.
    pub fn compare_frames(&mut self, labelled: LabelledTracks<'_>) {
        let frames = 0..self.num_accounts(labelled.is_object);
        self.account(frames.filter_map(|t| Some(self.sought(t, labelled)?.accounts())).collect(), labelled);
    }

    /// Takes the accounts of all frames, or none, by these trajectories.
    pub(crate) fn account(&mut self, made: Vec<Accounts>, labelled: LabelledTracks<'_>) {
        match self {
            Self::Still(_) => {}
            Self::Moving(scene) => {
                scene.accounts = made;
                scene.strange = APART * scene.unlike_scene(labelled).max(LEAST);
            }
            // What goes by on the road is badly known between trajectories: there, unlike the scene is not strange.
            Self::Forward(_, scene) => (scene.accounts, scene.strange) = (made, f32::MAX),
        }
    }

    /// Log-odds that each superpixel is an object's, frame by frame, against it where negative. `doubts` are the log-odds
    /// against each label, or none; the flow is that of each pair of frames.
    #[must_use]
    pub fn evidence(
        &self,
        superpixels: &[Superpixels],
        flows: &[CompactFlow],
        labelled: LabelledTracks<'_>,
        doubts: &[f32],
        params: &BackgroundParams,
    ) -> Vec<f32> {
        let mut evidence = match self {
            Self::Still(scene) => scene.evidence(superpixels, flows, params),
            Self::Moving(scene) | Self::Forward(_, scene) => scene.evidence(superpixels, labelled, params),
        };
        add_doubts(&mut evidence, superpixels, labelled, doubts);
        evidence
    }
}

impl StillScene {
    fn new(pictures: &[Picture], step: usize, tracks: &Trajectories, reach: f32) -> Self {
        let hidden = hidden(pictures, step, tracks, reach);
        let plate = Plate::new(pictures, |t, x, y| hidden[t][(x, y)]);
        let of = |plate: &Plate| pictures.iter().map(|p| plate.distance(p)).collect();
        Self { distance: plate.as_ref().map_or_else(Vec::new, of) }
    }

    /// The mean distance of each cluster's trajectories from the plate, 0 to 1, where it is
    /// known; 1 where it is not at all.
    pub(crate) fn unlike_plate(&self, tracks: &Trajectories, clusters: &Clusters) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); clusters.count];
        for (i, &cluster) in clusters.label.iter().enumerate() {
            let (count, sum) = (tracks.points(i).len() as f64, &mut sums[cluster as usize]);
            *sum = (sum.0 + count * f64::from(self.along(tracks, i).unwrap_or(1.0)), sum.1 + count);
        }
        sums.iter().map(|&(sum, count): &(f64, f64)| sum / count.max(1.0)).collect()
    }

    fn along(&self, tracks: &Trajectories, i: usize) -> Option<f32> {
        let place = |v: f32, from: usize, to: usize| ((v + 0.5).max(0.0) as usize * to / from.max(1)).min(to - 1);
        let (mut sum, mut count) = (0_u32, 0_u32);
        for t in tracks.frames(i) {
            let ((x, y), map) = (tracks.at(i, t)?, self.distance.get(t)?);
            let at = (place(x, tracks.size.0, map.width()), place(y, tracks.size.1, map.height()));
            if map[at] != UNKNOWN {
                (sum, count) = (sum + u32::from(map[at]), count + 1);
            }
        }
        (count > 0).then(|| sum as f32 / (255 * count) as f32)
    }

    /// By the plate and by motion.
    fn evidence(&self, superpixels: &[Superpixels], flows: &[CompactFlow], params: &BackgroundParams) -> Vec<f32> {
        let mut evidence = Vec::new();
        for (t, s) in superpixels.iter().enumerate() {
            let unknown = || vec![0.0; s.count];
            let by_plate = self.distance.get(t).map_or_else(unknown, |map| means(s, map));
            let flow = flows.get(t).or(flows.last());
            let by_motion = flow.map_or_else(unknown, |flow| means(s, &motion(flow, params.neutral_motion)));
            let sum = |(plate, motion)| params.plate_weight * log_odds(plate) + params.motion_weight * log_odds(motion);
            evidence.extend(by_plate.into_iter().zip(by_motion).map(sum));
        }
        evidence
    }
}

impl MovingScene {
    /// The mean square by which trajectories of the scene differ from it.
    fn unlike_scene(&self, labelled: LabelledTracks<'_>) -> f32 {
        let mut scene = Verdict::default();
        for (i, &label) in labelled.label.iter().enumerate() {
            if object(label, labelled.is_object) == Some(false) {
                self.add_along(labelled.tracks, i, &mut scene);
            }
        }
        scene.unlike_scene()
    }

    /// The accounts around each point of trajectory `i`.
    fn add_along(&self, tracks: &Trajectories, i: usize, sum: &mut Verdict) {
        for t in tracks.frames(i) {
            let (Some((x, y)), Some(map)) = (tracks.at(i, t), self.accounts.get(t)) else { continue };
            let (x, y) = (place(x, map.width(), self.step), place(y, map.height(), self.step));
            for y in y.saturating_sub(1)..(y + 2).min(map.height()) {
                let columns = x.saturating_sub(1)..(x + 2).min(map.width());
                columns.filter(|&x| is_sought(x, y)).for_each(|x| sum.add(map[(x, y)]));
            }
        }
    }

    /// By the accounts of pixels; nothing is said of frames without.
    fn evidence(
        &self,
        superpixels: &[Superpixels],
        labelled: LabelledTracks<'_>,
        params: &BackgroundParams,
    ) -> Vec<f32> {
        let mut evidence = Vec::new();
        for (t, s) in superpixels.iter().enumerate() {
            let Some(map) = self.accounts.get(t) else {
                evidence.resize(evidence.len() + s.count, 0.0);
                continue;
            };
            let said = verdicts(s, map, self.strange).into_iter();
            let shares = object_shares(s, t, labelled);
            evidence.extend(said.zip(shares).map(|(said, share)| {
                let unseen = 1.0 - TRUST * share;
                params.reprojection_weight * said - params.prior_log_odds * unseen
            }));
        }
        evidence
    }
}

/// Where each reduced frame is within `reach` pixels of trajectories that move.
fn hidden(pictures: &[Picture], step: usize, tracks: &Trajectories, reach: f32) -> Vec<Plane<bool>> {
    let mut hidden: Vec<_> = pictures.iter().map(|p| Plane::filled(p.width(), p.height(), false)).collect();
    let reach = (reach / step as f32 + 0.5) as usize;
    for i in (0..tracks.len()).filter(|&i| moved(tracks, i) > MOVED) {
        for t in tracks.frames(i) {
            let (Some((x, y)), Some(hidden)) = (tracks.at(i, t), hidden.get_mut(t)) else { continue };
            let (w, h) = (hidden.width(), hidden.height());
            let (x, y) = (place(x, w, step), place(y, h, step));
            for y in y.saturating_sub(reach)..(y + reach + 1).min(h) {
                hidden.row_mut(y)[x.saturating_sub(reach)..(x + reach + 1).min(w)].fill(true);
            }
        }
    }
    hidden
}

/// The pixel of a frame reduced by `step`, of this side, that a point of the frame lies in, along one axis.
fn place(v: f32, side: usize, step: usize) -> usize {
    (((v + 0.5).max(0.0) as usize) / step).min(side - 1)
}

/// What a cue says for an object, as log-odds; nothing where it is not known.
fn log_odds(value: f32) -> f32 {
    if value < 0.0 { 0.0 } else { (CUE.0 * (value - CUE.1)).min(CUE.2) }
}

/// How far from where it began a trajectory ends.
fn moved(tracks: &Trajectories, i: usize) -> f32 {
    let points = tracks.points(i);
    let (first, last) = (points.start, points.end - 1);
    ((tracks.x[last] - tracks.x[first]).powi(2) + (tracks.y[last] - tracks.y[first]).powi(2)).sqrt()
}

/// What accounts of its pixels come to for each superpixel; the map may be smaller.
fn verdicts(superpixels: &Superpixels, map: &Accounts, strange: f32) -> Vec<f32> {
    let sums = sums(superpixels, map, |x, y| {
        let [scene, object] = map[(x, y)].map(u32::from);
        if is_sought(x, y) { [scene * scene, object * object, 1] } else { [0; 3] }
    });
    let verdicts = sums.into_iter().map(Verdict::of);
    verdicts.map(|v| v.value().max(v.strangeness(strange))).collect()
}

/// The sums over each superpixel of numbers of each pixel of a map, which may be smaller.
fn sums<T: Copy, const N: usize>(
    superpixels: &Superpixels,
    map: &Plane<T>,
    of: impl Fn(usize, usize) -> [u32; N],
) -> Vec<[u64; N]> {
    let (w, h) = superpixels.runs().size();
    let mut sums = vec![[0; N]; superpixels.count];
    // Of a row of the map, up to each column of the frame: a superpixel has few runs of many pixels.
    let (mut upto, mut row) = (vec![[0; N]; w + 1], usize::MAX);
    for (y, columns, s) in superpixels.runs().rows() {
        let of_map = y * map.height() / h;
        if of_map != row {
            row = of_map;
            for x in 0..w {
                let (before, own) = (upto[x], of(x * map.width() / w, row));
                upto[x + 1] = std::array::from_fn(|k| before[k] + own[k]);
            }
        }
        let (from, to) = (upto[columns.start], upto[columns.end]);
        sums[s as usize].iter_mut().zip(to.iter().zip(from)).for_each(|(sum, (to, from))| *sum += u64::from(to - from));
    }
    sums
}

/// How far the flow of each pixel is from none, in 255ths: one half at `half` pixels.
fn motion(flow: &CompactFlow, half: f32) -> Plane<u8> {
    let (width, height) = flow.size();
    Plane::from_fn(width, height, |x, y| {
        let (u, v) = flow.at(x, y);
        let sq = u * u + v * v;
        (254.0 * sq / (sq + half * half)) as u8
    })
}

/// Takes from the evidence what speaks against the clusters of the trajectories in each superpixel, in the mean; `doubts`
/// has it of each cluster.
fn add_doubts(evidence: &mut [f32], superpixels: &[Superpixels], labelled: LabelledTracks<'_>, doubts: &[f32]) {
    if doubts.iter().all(|&doubt| doubt == 0.0) {
        return;
    }
    let mut first = 0;
    for (t, s) in superpixels.iter().enumerate() {
        let (superpixel, mut sums) = (s.label(), vec![(0.0, 0.0_f32); s.count]);
        for (i, x, y) in labelled.tracks.alive(t) {
            let Some(doubt) = labelled.label.get(i).and_then(|&l| doubts.get(l as usize)) else { continue };
            let sum = &mut sums[superpixel.data()[pixel_of(s.runs().size(), x, y)] as usize];
            *sum = (sum.0 + doubt, sum.1 + 1.0);
        }
        for (evidence, (sum, count)) in evidence[first..].iter_mut().zip(sums) {
            *evidence -= OPINION * (sum / count.max(1.0));
        }
        first += s.count;
    }
}

/// The share of objects' trajectories among those of frame `t` in each superpixel.
fn object_shares(superpixels: &Superpixels, t: usize, labelled: LabelledTracks<'_>) -> Vec<f32> {
    let LabelledTracks { tracks, label, is_object } = labelled;
    let (superpixel, mut found) = (superpixels.label(), vec![(0.0, 0.0_f32); superpixels.count]);
    for (i, x, y) in tracks.alive(t) {
        let Some(object) = label.get(i).and_then(|&l| object(l, is_object)) else { continue };
        let sums = &mut found[superpixel.data()[pixel_of(superpixels.runs().size(), x, y)] as usize];
        *sums = (sums.0 + if object { 1.0 } else { 0.0 }, sums.1 + 1.0);
    }
    found.iter().map(|&(objects, all): &(f32, f32)| objects / all.max(1.0)).collect()
}

/// The mean of a map over each superpixel, 0 to 1, of what is known of it; the map may be smaller.
fn means(superpixels: &Superpixels, map: &Plane<u8>) -> Vec<f32> {
    let of = |value| if value == UNKNOWN { [0; 2] } else { [u32::from(value), 1] };
    let sums = sums(superpixels, map, |x, y| of(map[(x, y)]));
    let mean = |[sum, count]: [u64; 2]| if count == 0 { NEUTRAL } else { sum as f32 / (255 * count) as f32 };
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
        match Background::new(frames, Camera::Still, tracks, 1.0) {
            Background::Still(scene) => scene,
            other => panic!("{other:?}"),
        }
    }

    fn halves() -> Superpixels {
        let label = Plane::from_fn(40, 20, |x, y| if y < 7 { 0 } else { 1 + u32::from(x < 20) });
        Superpixels::from(&label)
    }

    #[test]
    fn what_moves_less_than_its_own_length_is_not_in_the_plate() {
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
        let far = |tracks| still_scene(&frames, tracks).distance[0][(10, 10)];
        let none = Trajectories::empty(10, (40, 20));
        assert_eq!(far(&none), 0);
        assert!(far(&tracks) > 200);
    }

    #[test]
    fn what_moves_is_unlike_the_plate_and_what_rests_is_like_it() {
        let mut tracks = Trajectories::empty(10, (40, 20));
        tracks.push(0, (0..10).map(|t| (3.0 * t as f32 + 3.0, 11.0, 0.0)));
        tracks.push(0, (0..10).map(|_| (5.0, 2.0, 0.0)));
        let unlike = still_scene(&frames(), &tracks).unlike_plate(&tracks, &Clusters { count: 3, label: vec![0, 1] });
        assert!(unlike[0] > 0.9 && unlike[1..] == [0.0, 0.0], "{unlike:?}");
    }

    /// Ten frames of a scene of random blocks that goes two pixels to the left each, and before it a square of blocks of
    /// its own that goes three to the right.
    fn panned() -> Vec<Frame> {
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
    fn followed() -> (Trajectories, Vec<u32>) {
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
    fn before_a_moving_camera_superpixels_go_with_what_explains_them() {
        let params = BackgroundParams::default();
        let (tracks, label) = followed();
        let mut background = Background::new(&panned(), Camera::panning(-2.0, 10), &tracks, 1.0);
        let labelled = LabelledTracks { tracks: &tracks, label: &label, is_object: &[false, true] };
        background.compare_frames(labelled);
        // The square of frame 4, and all around it.
        let inside = |x: usize, y: usize| (24..48).contains(&x) && (20..44).contains(&y);
        let plane = Plane::from_fn(96, 64, |x, y| u32::from(inside(x, y)));
        let superpixels = vec![Superpixels::from(&plane); 10];
        let found = background.evidence(&superpixels, &[], labelled, &[], &params);
        assert!(found[8] < -1.0 && found[9] > 1.0, "{found:?}");
    }

    #[test]
    fn doubts_of_a_cluster_count_where_its_trajectories_are() {
        let mut tracks = Trajectories::empty(2, (40, 20));
        tracks.push(0, (0..2).map(|_| (5.0, 11.0, 0.0)));
        tracks.push(0, (0..2).map(|_| (7.0, 15.0, 0.0)));
        tracks.push(1, [(30.0, 11.0, 0.0)]);
        let mut evidence = vec![1.0; 6];
        let labelled = LabelledTracks { tracks: &tracks, label: &[0, 1, 1], is_object: &[] };
        add_doubts(&mut evidence, &vec![halves(); 2], labelled, &[0.0, 0.5]);
        assert_eq!(evidence, [1.0, 1.0, 1.0 - OPINION * 0.25, 1.0, 1.0 - OPINION * 0.5, 1.0 - OPINION * 0.25]);
    }

    #[test]
    fn without_objects_nothing_is_said() {
        let params = BackgroundParams::default();
        let (tracks, label) = followed();
        let mut background = Background::new(&panned(), Camera::panning(-2.0, 10), &tracks, 1.0);
        let labelled = LabelledTracks { tracks: &tracks, label: &label, is_object: &[false, false] };
        background.compare_frames(labelled);
        let found = background.evidence(&vec![halves(); 10], &[], labelled, &[], &params);
        assert_eq!(found, vec![0.0; 30]);
    }

    #[test]
    fn more_of_a_cue_never_speaks_less_for_an_object_and_none_says_nothing() {
        assert_eq!(log_odds(NEUTRAL), 0.0);
        let found: Vec<f32> = (0..=20).map(|k| log_odds(k as f32 / 20.0)).collect();
        assert!(found.is_sorted() && found[0] < 0.0 && found[20] == CUE.2, "{found:?}");
    }

    #[test]
    fn superpixels_with_what_moves_speak_for_objects_and_others_against() {
        let mut tracks = Trajectories::empty(10, (40, 20));
        for k in 0..5 {
            tracks.push(0, (0..10).map(|t| (3.0 * t as f32 + 1.0 + k as f32, 11.0, 0.0)));
            tracks.push(0, (0..10).map(|_| (7.0 * k as f32, 2.0, 0.0)));
        }
        let background = Background::new(&frames(), Camera::Still, &tracks, 1.0);
        let label: Vec<u32> = (0..10).map(|i| i % 2).collect();
        let superpixels = vec![halves(); 10];
        let labelled = LabelledTracks { tracks: &tracks, label: &label, is_object: &[true, false] };
        let found = background.evidence(&superpixels, &[], labelled, &[], &BackgroundParams::default());
        assert_eq!(found.len(), 30);
        // In the first frame the square is on the left, in the last on the right; above there is nothing at any time.
        assert!(found[0] < 0.0 && found[27] < 0.0, "{found:?}");
        assert!(found[2] > found[1] && found[28] > found[29], "{found:?}");
    }
}
