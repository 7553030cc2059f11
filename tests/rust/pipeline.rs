//! End to end on made scenes: frames in, labels out, held against the true masks. Floors only ever go up.

use std::sync::OnceLock;
use tracecut::connectedness::ConnectednessMode;
use tracecut::image::{Frame, Plane};
use tracecut::synth::Scene;
use tracecut::trajectory::Trajectories;
use tracecut::{Params, Session};

/// A clip with its true masks.
#[derive(Clone)]
struct Clip {
    frames: Vec<Frame>,
    masks: Vec<Plane<u8>>,
}

impl Clip {
    fn new(scene: &Scene) -> Self {
        let frames = 0..scene.num_frames();
        Self {
            frames: frames.clone().map(|t| scene.frame(t)).collect(),
            masks: frames.map(|t| scene.mask(t)).collect(),
        }
    }

    fn reversed(mut self) -> Self {
        self.frames.reverse();
        self.masks.reverse();
        self
    }

    fn mirrored(mut self) -> Self {
        for frame in &mut self.frames {
            let rows = frame.rgb().chunks_exact(3 * frame.width());
            let rgb = rows.flat_map(|row| row.rchunks_exact(3).flatten().copied()).collect();
            *frame = Frame::from_rgb(rgb, frame.width(), frame.height()).unwrap();
        }
        for mask in &mut self.masks {
            *mask = Plane::from_fn(mask.width(), mask.height(), |x, y| mask[(mask.width() - 1 - x, y)]);
        }
        self
    }

    /// Every channel as `low + value * share`, rounded.
    fn relit(mut self, low: f32, share: f32) -> Self {
        for frame in &mut self.frames {
            let rgb = frame.rgb().iter().map(|&v| (low + share * f32::from(v)).round() as u8).collect();
            *frame = Frame::from_rgb(rgb, frame.width(), frame.height()).unwrap();
        }
        self
    }

    fn run(&self, params: Params) -> Session {
        let mut session = Session::new(params).unwrap();
        for frame in &self.frames {
            session.push_frame(frame.clone()).unwrap();
        }
        session.run().unwrap();
        session
    }
}

/// The object under most of a trajectory's points.
fn true_object(tracks: &Trajectories, i: usize, masks: &[Plane<u8>]) -> u8 {
    let mut votes = [0; 256];
    for (t, p) in tracks.frames(i).zip(tracks.points(i)) {
        let (x, y) = (tracks.x[p].round() as usize, tracks.y[p].round() as usize);
        let mask = &masks[t];
        votes[usize::from(mask[(x.min(mask.width() - 1), y.min(mask.height() - 1))])] += 1;
    }
    (0..=255).max_by_key(|&o| (votes[usize::from(o)], 255 - o)).unwrap()
}

/// How the labels of a finished session stand to the true objects, background first.
#[derive(Debug)]
struct Match {
    /// Trajectories on each object.
    #[allow(dead_code, reason = "shown when an assertion fails")]
    num: Vec<usize>,
    /// The label that most of them have.
    label: Vec<u32>,
    /// The share of them that have it.
    share: Vec<f64>,
    clusters: usize,
}

impl Match {
    fn new(session: &Session, masks: &[Plane<u8>]) -> Self {
        let (tracks, clusters) = (session.trajectories().unwrap(), session.clusters().unwrap());
        let objects = masks.iter().flat_map(|m| m.data()).max().map_or(1, |&o| usize::from(o) + 1);
        let mut votes = vec![vec![0_usize; clusters.count]; objects];
        for i in 0..tracks.len() {
            votes[usize::from(true_object(tracks, i, masks))][clusters.label[i] as usize] += 1;
        }
        let num: Vec<usize> = votes.iter().map(|v| v.iter().sum()).collect();
        let best = |v: &Vec<usize>| (0..v.len()).max_by_key(|&l| (v[l], v.len() - l)).unwrap();
        let label: Vec<u32> = votes.iter().map(|v| best(v) as u32).collect();
        let share = votes.iter().zip(&num).map(|(v, &n)| v[best(v)] as f64 / n as f64).collect();
        Self { num, label, share, clusters: clusters.count }
    }

    /// Every object has its own label, and at least `floors` of its trajectories have it.
    fn assert_found(&self, floors: &[f64]) {
        for (object, &floor) in floors.iter().enumerate() {
            assert!(self.share[object] >= floor, "object {object} below {floor}: {self:?}");
            assert!(!self.label[..object].contains(&self.label[object]), "objects share a label: {self:?}");
        }
    }
}

fn with_step(step: f32) -> Params {
    let mut params = Params::default();
    params.trajectory.grid_step = step;
    params
}

/// Two textured planes with a relative motion of 2 px a frame, tracked once for all tests.
fn planes() -> &'static (Clip, Session) {
    static PLANES: OnceLock<(Clip, Session)> = OnceLock::new();
    PLANES.get_or_init(|| {
        let clip = Clip::new(&Scene::two_planes(192, 144, 12, (-0.8, 0.3), (1.2, 0.3), 5));
        let session = clip.run(with_step(6.0));
        (clip, session)
    })
}

/// A session with the trajectories of [`planes`], set from outside, and at most `max_dimensions` eigenvectors.
fn planes_again(max_dimensions: u32) -> Session {
    let mut params = with_step(6.0);
    params.embedding.max_dimensions = max_dimensions;
    let mut session = Session::new(params).unwrap();
    session.set_trajectories(planes().1.trajectories().unwrap().clone()).unwrap();
    session
}

#[test]
fn objects_of_the_sample_scene_get_their_own_labels() {
    let clip = Clip::new(&Scene::sample((480, 270), 20, 1));
    let found = Match::new(&clip.run(Params::default()), &clip.masks);
    found.assert_found(&[0.97, 0.95, 0.95, 0.7]);
}

#[test]
fn a_still_video_yields_one_label() {
    let clip = Clip::new(&Scene::still((160, 120), 8, 1));
    let session = clip.run(Params::default());
    let clusters = session.clusters().unwrap();
    assert!(clusters.label.len() > 100, "{} trajectories", clusters.label.len());
    assert_eq!(clusters.count, 1);
    assert!(!session.saliency().unwrap().foreground.contains(&true));
}

#[test]
fn two_planes_are_two_clusters_for_any_number_of_eigenvectors() {
    let (clip, _) = planes();
    for dimensions in [2, 3, 4, 6, 8, 12, 24] {
        let mut session = planes_again(dimensions);
        session.run().unwrap();
        let found = Match::new(&session, &clip.masks);
        assert_eq!(found.clusters, 2, "{dimensions} eigenvectors: {found:?}");
        found.assert_found(&[0.95, 0.95]);
    }
}

/// Discontinuities between the planes and inside them, each in rising order.
fn across_and_inside(session: &Session, masks: &[Plane<u8>]) -> (Vec<f64>, Vec<f64>) {
    let (tracks, found) = (session.trajectories().unwrap(), session.discontinuities().unwrap());
    let object: Vec<u8> = (0..tracks.len()).map(|i| true_object(tracks, i, masks)).collect();
    let (mut across, mut inside) = (Vec::new(), Vec::new());
    for (&(i, j), &d) in found.neighborhoods.pairs.iter().zip(&found.d) {
        let list = if object[i as usize] == object[j as usize] { &mut inside } else { &mut across };
        list.push(d);
    }
    across.sort_by(f64::total_cmp);
    inside.sort_by(f64::total_cmp);
    (across, inside)
}

/// Between the planes `d` is large at any number of eigenvectors; inside it is next to nothing with one eigenvector for
/// each motion, and grows with eigenvectors that stand for no motion.
#[test]
fn discontinuities_are_large_between_two_planes_and_small_inside() {
    let (clip, tracked) = planes();
    for (dimensions, percentile, limit) in [(2, 95, 0.45), (24, 50, 0.45)] {
        let mut session = planes_again(dimensions);
        session.run().unwrap();
        let (across, inside) = across_and_inside(&session, &clip.masks);
        assert!(across.len() > 50 && across[0] > 0.6, "smallest of {} across: {:.3}", across.len(), across[0]);
        let d = inside[(inside.len() - 1) * percentile / 100];
        assert!(d < limit, "{percentile}-percentile of {} inside, {dimensions} eigenvectors: {d:.3}", inside.len());
    }
    assert!(tracked.embedding().unwrap().eigenvalues[1] > 0.95, "two motions give two eigenvalues near 1");
}

#[test]
fn thresholded_discontinuities_part_the_two_planes() {
    let (clip, tracked) = planes();
    let (tracks, clusters) = (tracked.trajectories().unwrap(), tracked.threshold_clusters().unwrap());
    assert_eq!(clusters.label.len(), tracks.len());
    let on = |object: u8, label: u32| {
        (0..tracks.len())
            .filter(|&i| clusters.label[i] == label && true_object(tracks, i, &clip.masks) == object)
            .count()
    };
    let behind = if on(0, 0) > on(0, 1) { 0 } else { 1 };
    for (object, label) in [(0, behind), (1, 1 - behind)] {
        let (right, wrong) = (on(object, label), on(object, 1 - label));
        assert!(right > 20 && right > 9 * wrong, "object {object}: {right} with label {label}, {wrong} with the other");
    }
}

#[test]
fn outside_trajectories_give_the_same_clusters_as_our_own() {
    let mut params = with_step(6.0);
    // Masks can make clusters anew.
    params.clip.dense = false;
    let tracked = planes().0.run(params);
    let mut session = planes_again(Params::default().embedding.max_dimensions);
    session.run().unwrap();
    assert_eq!(session.clusters(), tracked.clusters());
}

#[test]
fn mirrored_reversed_and_relit_clips_keep_the_partition() {
    let clip = Clip::new(&Scene::sample((240, 135), 12, 3));
    let params = with_step(4.0);
    for (name, clip) in [
        ("plain", clip.clone()),
        ("mirrored", clip.clone().mirrored()),
        ("reversed", clip.clone().reversed()),
        ("relit", clip.clone().relit(24.0, 0.9)),
    ] {
        let found = Match::new(&clip.run(params.clone()), &clip.masks);
        found.assert_found(&[0.95, 0.95, 0.9]);
        // The hiker, some twenty pixels tall, may come out on its own or not; nothing else may.
        assert!((3..=4).contains(&found.clusters), "{name}: {found:?}");
    }
}

#[test]
fn the_same_clip_gives_the_same_bits_twice() {
    let (clip, first) = planes();
    let second = clip.run(with_step(6.0));
    assert_eq!(first.trajectories(), second.trajectories());
    assert_eq!(first.affinities(), second.affinities());
    assert_eq!(first.embedding(), second.embedding());
    assert_eq!(first.discontinuities(), second.discontinuities());
    assert_eq!(first.clusters(), second.clusters());
}

#[test]
fn degenerate_clips_end_in_a_result() {
    let grey = |width: usize, height: usize, value: u8| Frame::from_rgb(vec![value; 3 * width * height], width, height);
    for (width, height, frames, value) in [(1, 1, 2, 9), (17, 3, 3, 200), (64, 48, 4, 0), (3, 70, 2, 255)] {
        let mut session = Session::new(Params::default()).unwrap();
        for _ in 0..frames {
            session.push_frame(grey(width, height, value).unwrap()).unwrap();
        }
        session.run().unwrap();
        session.trajectories().unwrap().check().unwrap();
        assert!(session.clusters().unwrap().count <= 1, "{width}x{height}: {:?}", session.clusters());
    }
}

/// Two players who move alike and touch for a while (the paper's Figure 7): the players that each cluster holds at
/// least a tenth of.
fn players_by_cluster(mode: ConnectednessMode, seed: u64) -> Vec<Vec<usize>> {
    let clip = Clip::new(&Scene::entangled((320, 240), 40, seed));
    let mut params = Params::default();
    params.connectedness.mode = mode;
    params.clip.dense = false;
    let session = clip.run(params);
    let (tracks, clusters) = (session.trajectories().unwrap(), session.clusters().unwrap());
    let mut votes = vec![[0_usize; 3]; clusters.count];
    for i in 0..tracks.len() {
        votes[clusters.label[i] as usize][usize::from(true_object(tracks, i, &clip.masks))] += 1;
    }
    let all = [1, 2].map(|o| votes.iter().map(|v| v[o]).sum::<usize>());
    assert!(all.iter().all(|&n| n >= 30), "too few trajectories on the players: {all:?}");
    votes.iter().map(|v| [1, 2].into_iter().filter(|&o| 10 * v[o] >= all[o - 1]).collect()).collect()
}

#[test]
fn players_who_move_alike_and_touch_are_told_apart_by_connectedness_and_not_without() {
    players_are_told_apart(&[2]);
}

#[test]
#[ignore = "more of the same; part of npm run test:long"]
fn more_players_who_move_alike_and_touch_are_told_apart_by_connectedness() {
    players_are_told_apart(&[4, 6]);
}

fn players_are_told_apart(seeds: &[u64]) {
    for &seed in seeds {
        let without = players_by_cluster(ConnectednessMode::Off, seed);
        assert!(without.contains(&vec![1, 2]), "seed {seed}: {without:?}");
        for mode in [ConnectednessMode::Agents, ConnectednessMode::ForegroundOnly] {
            let with = players_by_cluster(mode, seed);
            assert!(with.iter().all(|players| players.len() < 2), "seed {seed}: {with:?}");
            // Where only the foreground is clustered, an arm may come out on its own.
            let most = if mode == ConnectednessMode::Agents { 1 } else { 2 };
            let num_clusters = |player| with.iter().flatten().filter(|p| **p == player).count();
            assert!([1, 2].iter().all(|&player| (1..=most).contains(&num_clusters(player))), "seed {seed}: {with:?}");
        }
    }
}

/// The trajectories of the foreground on each object, as shares.
fn foreground_shares(session: &Session, masks: &[Plane<u8>]) -> Vec<f64> {
    let (tracks, saliency) = (session.trajectories().unwrap(), session.saliency().unwrap());
    let objects = masks.iter().flat_map(|m| m.data()).max().map_or(1, |&o| usize::from(o) + 1);
    let mut counts = vec![(0, 0); objects];
    for i in 0..tracks.len() {
        let count = &mut counts[usize::from(true_object(tracks, i, masks))];
        *count = (count.0 + usize::from(saliency.foreground[i]), count.1 + 1);
    }
    counts.iter().map(|&(n, of)| f64::from(n as u32) / f64::from(of.max(1) as u32)).collect()
}

#[test]
fn objects_of_the_sample_scene_are_the_foreground_though_the_camera_pans() {
    let clip = Clip::new(&Scene::sample((480, 270), 20, 1));
    let mut params = Params::default();
    params.clip.dense = false;
    let shares = foreground_shares(&clip.run(params), &clip.masks);
    assert!(shares[0] < 0.05 && shares[1..].iter().all(|&s| s > 0.85), "{shares:?}");
}

/// A scene without any mover before a camera that goes sideways: far away a pixel a frame, a slope that is nearer at the
/// bottom up to three, and a tree at four whose crown reaches over the frame.
fn garden() -> Vec<Frame> {
    const SIZE: (usize, usize) = (240, 160);
    // Smooth blobs that no two places share.
    let texture = |x: f64, y: f64, kind: f64| {
        let wave = |a: f64, b: f64, phase: f64| (a * x + b * y + phase + kind).sin();
        let waves = [wave(0.31, 0.17, 0.0), wave(0.13, -0.41, 1.0), wave(-0.53, 0.37, 2.0), wave(0.07, 0.71, 3.0)];
        let slow = (0.03 * x + 0.05 * y + kind).sin() * (0.11 * x - 0.02 * y).cos();
        (128.0 + 20.0 * waves.iter().sum::<f64>() + 40.0 * slow).clamp(0.0, 255.0) as u8
    };
    let frame = |t: usize| {
        let pixel = |i: usize| {
            let (x, y) = ((i % SIZE.0) as f64, (i / SIZE.0) as f64);
            let t = t as f64;
            let near = x + 4.0 * t;
            let crown = y < 44.0 + 6.0 * (0.1 * near).sin() && (40.0..280.0).contains(&near);
            let value = if crown || (130.0..156.0).contains(&near) {
                texture(near, y, 9.0)
            } else if y < 60.0 {
                texture(x + t, y, 0.0)
            } else {
                texture(x + t * (1.0 + (y - 60.0) / 50.0), y, 5.0)
            };
            [value; 3]
        };
        Frame::from_rgb((0..SIZE.0 * SIZE.1).flat_map(pixel).collect(), SIZE.0, SIZE.1).unwrap()
    };
    (0..16).map(frame).collect()
}

#[test]
fn in_a_scene_of_depth_where_nothing_moves_nothing_is_found() {
    let clip = Clip { frames: garden(), masks: Vec::new() };
    let session = clip.run(Params::default());
    let labelled: usize =
        (0..16).map(|t| session.labels(t).unwrap().data().iter().filter(|&&label| label > 0).count()).sum();
    assert!(200 * labelled <= 16 * 240 * 160, "{labelled} pixels");
}
