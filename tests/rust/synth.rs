//! The scene generator: masks, flow and frames belong together, and its bytes never change.

use tracecut::flow::FlowField;
use tracecut::image::{Plane, sample_bilinear};
use tracecut::synth::Scene;

/// Share of the frame that each label covers, background first.
fn shares(mask: &Plane<u8>) -> [f64; 4] {
    let mut counts = [0.0; 4];
    mask.data().iter().for_each(|&label| counts[usize::from(label)] += 1.0 / mask.data().len() as f64);
    counts
}

/// Mean absolute difference between frame `t` and frame `t + 1` brought back by `flow`, in grey levels, and the share
/// of pixels it was taken over: those whose surroundings in both frames show one object only.
fn warping_error(scene: &Scene, t: usize, flow: &FlowField) -> (f64, f64) {
    const RADIUS: usize = 4;
    let (width, height) = scene.size();
    let (now, next) = (scene.frame(t).luma(), scene.frame(t + 1).luma());
    let (mask, next_mask) = (scene.mask(t), scene.mask(t + 1));
    let pure = |mask: &Plane<u8>, x: usize, y: usize, label: u8| {
        x >= RADIUS
            && y >= RADIUS
            && x + RADIUS < width
            && y + RADIUS < height
            && (y - RADIUS..=y + RADIUS).all(|y| mask.row(y)[x - RADIUS..=x + RADIUS].iter().all(|&l| l == label))
    };
    let (mut sum, mut count) = (0.0, 0);
    for y in 0..height {
        for x in 0..width {
            let (to_x, to_y) = (x as f32 + flow.u[(x, y)], y as f32 + flow.v[(x, y)]);
            let label = mask[(x, y)];
            if pure(&mask, x, y, label) && pure(&next_mask, to_x.round() as usize, to_y.round() as usize, label) {
                sum += f64::from((sample_bilinear(&next, to_x, to_y) - now[(x, y)]).abs());
                count += 1;
            }
        }
    }
    (sum / f64::from(count), f64::from(count) / (width * height) as f64)
}

fn no_flow((width, height): (usize, usize)) -> FlowField {
    FlowField { u: Plane::filled(width, height, 0.0), v: Plane::filled(width, height, 0.0) }
}

fn fnv(bytes: impl IntoIterator<Item = u8>) -> u64 {
    bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3))
}

#[test]
fn each_object_of_the_sample_has_its_size_in_every_frame() {
    let scene = Scene::sample((384, 216), 30, 1);
    assert_eq!((scene.num_objects(), scene.num_frames(), scene.size()), (3, 30, (384, 216)));
    for t in [0, 10, 20, 29] {
        let [background, balloon, van, hiker] = shares(&scene.mask(t));
        assert!((0.78..0.90).contains(&background), "frame {t}: background {background:.4}");
        assert!((0.055..0.11).contains(&balloon), "frame {t}: balloon {balloon:.4}");
        assert!((0.018..0.03).contains(&van), "frame {t}: van {van:.4}");
        assert!((0.025..0.05).contains(&hiker), "frame {t}: hiker {hiker:.4}");
    }
}

#[test]
fn true_flow_brings_the_next_frame_back() {
    for scene in [
        Scene::sample((384, 216), 3, 1),
        Scene::two_walkers((480, 270), 3, 2),
        Scene::entangled((320, 240), 3, 4),
        Scene::two_planes(160, 120, 3, (-0.6, 0.3), (1.7, -0.4), 3),
    ] {
        let (error, share) = warping_error(&scene, 1, &scene.flow(1));
        let (unmoved, _) = warping_error(&scene, 1, &no_flow(scene.size()));
        assert!(share > 0.6, "only {share:.2} of the pixels compared");
        assert!(error < 2.0 && error < 0.4 * unmoved, "error {error:.3}, without flow {unmoved:.3}");
    }
}

#[test]
fn motions_are_as_strong_as_documented() {
    let (scene, t) = (Scene::sample((480, 270), 30, 1), 15);
    let (flow, mask) = (scene.flow(t), scene.mask(t));
    let mut mean = [(0.0, 0.0, 0.0); 4];
    for (i, &label) in mask.data().iter().enumerate() {
        let (u, v) = (f64::from(flow.u.data()[i]), f64::from(flow.v.data()[i]));
        let m = &mut mean[usize::from(label)];
        *m = (m.0 + u, m.1 + v, m.2 + 1.0);
        assert!(label > 0 || (1.0..2.05).contains(&-u), "background moves by {u} at pixel {i}");
    }
    let mean = mean.map(|(u, v, n)| (u / n, v / n));
    for (u, v) in &mean[1..] {
        let relative = (u - mean[0].0).hypot(v - mean[0].1);
        assert!((1.5..4.0).contains(&relative), "relative motion {relative}");
    }
}

#[test]
fn planes_move_by_exactly_what_was_asked() {
    let scene = Scene::two_planes(64, 48, 5, (-0.6, 0.25), (1.4, -0.75), 7);
    let (flow, mask) = (scene.flow(2), scene.mask(2));
    for (i, &label) in mask.data().iter().enumerate() {
        let (u, v) = if label == 0 { (-0.6, 0.25) } else { (1.4, -0.75) };
        assert!((flow.u.data()[i] - u).abs() < 1e-5 && (flow.v.data()[i] - v).abs() < 1e-5, "pixel {i}");
    }
    assert!((shares(&mask)[1] - 0.5).abs() < 0.01, "front plane covers {:.4}", shares(&mask)[1]);
}

#[test]
fn a_still_scene_does_not_change() {
    let scene = Scene::still((64, 48), 4, 1);
    assert_eq!(scene.frame(0), scene.frame(3));
    assert_eq!(scene.flow(1), no_flow((64, 48)));
    assert!(shares(&scene.mask(0))[1] > 0.1);
}

#[test]
fn walkers_touch_at_first_and_part_later() {
    let scene = Scene::two_walkers((480, 270), 40, 1);
    let gap = |t| {
        let mask = scene.mask(t);
        let of = |label| mask.data().iter().enumerate().filter(move |&(_, &l)| l == label).map(|(i, _)| i % 480);
        of(1).min().unwrap() as i64 - of(2).max().unwrap() as i64
    };
    assert!(gap(5) <= 1, "gap {} in frame 5", gap(5));
    assert!(gap(39) > gap(5) + 10, "gap {} in frame 39", gap(39));
}

/// Median flow of an object above row `rows`: of its trunk, as arms and legs are fewer pixels.
fn trunk_motion(scene: &Scene, t: usize, label: u8, rows: usize) -> [f32; 2] {
    let (mask, flow) = (scene.mask(t), scene.flow(t));
    let pixels = 0..rows * scene.size().0;
    [&flow.u, &flow.v].map(|part| {
        let mut values: Vec<f32> =
            pixels.clone().filter(|&i| mask.data()[i] == label).map(|i| part.data()[i]).collect();
        values.sort_by(f32::total_cmp);
        values[values.len() / 2]
    })
}

#[test]
fn players_move_alike_and_are_apart_before_and_after_they_touch() {
    let scene = Scene::entangled((320, 240), 40, 1);
    assert_eq!(scene.num_objects(), 2);
    let gap = |t| {
        let mask = scene.mask(t);
        let of = |label| mask.data().iter().enumerate().filter(move |&(_, &l)| l == label).map(|(i, _)| i % 320);
        of(2).min().unwrap() as i64 - of(1).max().unwrap() as i64
    };
    for t in [0, 3, 6, 9, 12, 30, 33, 36, 39] {
        assert!(gap(t) > 15, "gap {} in frame {t}", gap(t));
    }
    for t in [18, 20, 22] {
        assert!(gap(t) < 0, "gap {} in frame {t}", gap(t));
    }
    for t in 0..39 {
        let [a, b] = [1, 2].map(|label| trunk_motion(&scene, t, label, 150));
        assert!((a[0] - b[0]).abs() < 0.1 && (a[1] - b[1]).abs() < 0.1, "frame {t}: {a:?} {b:?}");
        assert!((0.4..0.6).contains(&a[0]), "frame {t}: {a:?}");
    }
    let shares = shares(&scene.mask(10));
    assert!(shares[1] > 0.05 && shares[2] > 0.05, "{shares:?}");
}

/// Of frames 0 and 5 of `Scene::sample((96, 54), 6, 1)`. It changes when the scene is redrawn, and never otherwise.
const HASH: u64 = 0xdf82_5e06_fd78_03a0;

/// Golden files hold the bytes of the wasm build to those of native code.
#[test]
fn frames_never_change() {
    let scene = Scene::sample((96, 54), 6, 1);
    assert_eq!(scene.frame(4), Scene::sample((96, 54), 6, 1).frame(4));
    assert_ne!(scene.frame(4), Scene::sample((96, 54), 6, 2).frame(4));
    let bytes = [0, 5].into_iter().flat_map(|t| scene.frame(t).rgb().to_vec());
    let hash = fnv(bytes);
    assert_eq!(hash, HASH, "hash of frames 0 and 5: {hash:#018x}");
}

#[test]
fn odd_sizes_and_lengths_are_scenes_too() {
    for (width, height, frames) in [(1, 1, 3), (17, 3, 2), (3, 200, 2), (300, 2, 1), (40, 30, 0), (0, 0, 1)] {
        for scene in [
            Scene::sample((width, height), frames, 1),
            Scene::two_walkers((width, height), frames, 1),
            Scene::entangled((width, height), frames, 1),
            Scene::two_planes(width, height, frames, (2.0, 0.0), (-2.0, 0.0), 1),
            Scene::still((width, height), frames, 1),
        ] {
            assert_eq!(scene.size(), (width.max(1), height.max(1)));
            for t in [0, 1, 1000] {
                let size = (scene.frame(t).width(), scene.frame(t).height());
                assert_eq!(size, scene.size());
                assert!(scene.flow(t).u.data().iter().all(|u| u.is_finite()));
                assert_eq!(scene.mask(t).data().len(), size.0 * size.1);
            }
        }
    }
}
