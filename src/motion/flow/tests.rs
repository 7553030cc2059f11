//! Laws of the flow: known motions, symmetry, degenerate frames.

use super::*;
use crate::image::{Plane, gaussian_blur};
use crate::rng::Rng;
use std::f64::consts::TAU;

/// Smooth random texture with brightness around 128.
fn texture(width: usize, height: usize, seed: u64) -> Plane<f32> {
    let mut rng = Rng::for_stage(seed, "texture");
    let noise = Plane::from_fn(width, height, |_, _| rng.range(-1.0, 1.0) as f32);
    gaussian_blur(&noise, 2.0).map(|v| 128.0 + 350.0 * v)
}

/// Brightness made of waves no shorter than eight pixels, displaced by `(u, v)`.
fn waves(width: usize, height: usize, u: f32, v: f32) -> Plane<f32> {
    let mut rng = Rng::for_stage(11, "waves");
    let waves: Vec<[f32; 3]> = (0..24)
        .map(|_| {
            let (frequency, direction) = (rng.range(0.1, 0.78), rng.range(0.0, TAU));
            let (fx, fy) = (frequency * direction.cos(), frequency * direction.sin());
            [fx as f32, fy as f32, rng.range(0.0, TAU) as f32]
        })
        .collect();
    Plane::from_fn(width, height, |x, y| {
        let (x, y) = (x as f32 - u, y as f32 - v);
        128.0 + 12.0 * waves.iter().map(|[fx, fy, phase]| (fx * x + fy * y + phase).sin()).sum::<f32>()
    })
}

fn flow(from: &Plane<f32>, to: &Plane<f32>) -> FlowField {
    let params = FlowParams::default();
    flow_between(&FlowPyramid::from_luma(from), &FlowPyramid::from_luma(to), &params)
}

/// Mean end-point error against one displacement over the columns and rows given.
fn error(flow: &FlowField, (u, v): (f32, f32), columns: std::ops::Range<usize>, rows: std::ops::Range<usize>) -> f32 {
    let count = (columns.len() * rows.len()) as f32;
    let pixels = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
    pixels.map(|p| (flow.u[p] - u).hypot(flow.v[p] - v)).sum::<f32>() / count
}

/// Mean length of the difference of two fields.
fn distance(a: &FlowField, b: &FlowField) -> f32 {
    let each = a.u.data().iter().zip(a.v.data()).zip(b.u.data().iter().zip(b.v.data()));
    each.map(|((au, av), (bu, bv))| (au - bu).hypot(av - bv)).sum::<f32>() / a.u.data().len() as f32
}

#[test]
fn translation_of_smooth_noise_is_found_to_a_twentieth_of_a_pixel() {
    let motion = (3.4, -2.1);
    let flow = flow(&waves(160, 120, 0.0, 0.0), &waves(160, 120, motion.0, motion.1));
    let error = error(&flow, motion, 12..148, 12..108);
    assert!(error < 0.05, "error {error}");
}

#[test]
fn where_patches_are_not_searched_they_keep_the_coarser_flow_and_the_refinement_makes_up_for_it() {
    let motion = (3.4, -2.1);
    let (from, to) = (waves(160, 120, 0.0, 0.0), waves(160, 120, motion.0, motion.1));
    // Beyond the coarsest level that one alone is searched.
    for search_level in [1, 2, 4] {
        let params = FlowParams { search_level, ..FlowParams::default() };
        let flow = flow_between(&FlowPyramid::from_luma(&from), &FlowPyramid::from_luma(&to), &params);
        let error = error(&flow, motion, 12..148, 12..108);
        assert!(error < 0.1, "level {search_level}: error {error}");
    }
}

#[test]
fn a_square_that_moves_twenty_pixels_is_followed() {
    let (ground, square) = (texture(200, 150, 7), texture(64, 64, 8));
    let scene = |left: usize, top: usize| {
        Plane::from_fn(200, 150, |x, y| {
            let inside = (left..left + 64).contains(&x) && (top..top + 64).contains(&y);
            if inside { square[(x - left, y - top)] } else { ground[(x, y)] }
        })
    };
    let flow = flow(&scene(50, 40), &scene(70, 40));
    let (inside, outside) = (error(&flow, (20.0, 0.0), 54..110, 44..100), error(&flow, (0.0, 0.0), 4..40, 4..146));
    assert!(inside < 1.0, "error inside {inside}");
    assert!(outside < 0.1, "error outside {outside}");
}

#[test]
fn a_brightness_offset_hardly_changes_the_flow() {
    let (from, to) = (waves(120, 90, 0.0, 0.0), waves(120, 90, 2.3, 1.2));
    let (plain, brighter) = (flow(&from, &to), flow(&from, &to.map(|v| v + 10.0)));
    let error = error(&brighter, (2.3, 1.2), 12..108, 12..78);
    assert!(error < 0.2, "error {error}");
    assert!(distance(&plain, &brighter) < 0.2, "distance {}", distance(&plain, &brighter));
}

#[test]
fn identical_and_flat_frames_do_not_move() {
    let scene = texture(70, 50, 1);
    let still = flow(&scene, &scene);
    assert!(still.u.data().iter().chain(still.v.data()).all(|v| v.abs() < 1e-3));
    let flat = Plane::filled(70, 50, 90.0);
    let still = flow(&flat, &flat);
    assert!(still.u.data().iter().chain(still.v.data()).all(|&v| v == 0.0));
}

#[test]
fn any_size_gives_finite_flow_of_that_size() {
    for (width, height) in [(1, 1), (17, 3), (1, 40), (40, 1), (2, 2), (9, 8), (65, 33), (300, 9)] {
        let flow = flow(&texture(width, height, 5), &texture(width, height, 6));
        assert_eq!((flow.u.width(), flow.u.height(), flow.v.width(), flow.v.height()), (width, height, width, height));
        assert!(flow.u.data().iter().chain(flow.v.data()).all(|v| v.is_finite()), "{width}x{height}");
    }
    assert_eq!(flow(&Plane::default(), &Plane::default()), FlowField::default());
}

#[test]
fn extreme_settings_and_values_give_finite_flow() {
    let mut from = texture(60, 45, 5);
    (from[(3, 4)], from[(30, 20)], from[(31, 20)]) = (f32::NAN, f32::INFINITY, -1e30);
    let extremes = [
        FlowParams { patch_stride: 8, smoothness: 0.001, ..FlowParams::default() },
        FlowParams { patch_stride: 1, search_level: 4, ..FlowParams::default() },
        FlowParams { smoothness: 1000.0, fixed_points: 12, ..FlowParams::default() },
        FlowParams { fixed_points: 0, ..FlowParams::default() },
    ];
    for params in extremes {
        let [from, to] = [&from, &texture(60, 45, 6)].map(FlowPyramid::from_luma);
        let flow = flow_between(&from, &to, &params);
        assert_eq!((flow.u.width(), flow.v.height()), (60, 45));
        assert!(flow.u.data().iter().chain(flow.v.data()).all(|v| v.is_finite()), "{params:?}");
    }
}

#[test]
fn mirrored_frames_give_mirrored_flow() {
    let mirrored =
        |plane: &Plane<f32>| Plane::from_fn(plane.width(), plane.height(), |x, y| plane[(plane.width() - 1 - x, y)]);
    let (from, to) = (waves(128, 96, 0.0, 0.0), waves(128, 96, 2.6, 1.1));
    let plain = flow(&from, &to);
    let other = flow(&mirrored(&from), &mirrored(&to));
    let back = FlowField { u: mirrored(&other.u).map(|u| -u), v: mirrored(&other.v) };
    let error = error(&back, (2.6, 1.1), 12..116, 12..84);
    assert!(error < 0.05, "error {error}");
    assert!(distance(&plain, &back) < 0.1, "distance {}", distance(&plain, &back));
}

#[test]
fn scratch_of_other_pairs_and_sizes_leaves_no_trace() {
    let params = FlowParams::default();
    let pyramid = |width, height, seed| FlowPyramid::from_luma(&texture(width, height, seed));
    let (from, to) = (pyramid(71, 50, 1), pyramid(71, 50, 2));
    let fresh = flow_between(&from, &to, &params);
    let mut scratch = FlowScratch::default();
    // 72 columns have as many cells in a half row as 71: the last odd one must not keep its value.
    for (width, height) in [(72, 50), (30, 90), (71, 50)] {
        let _ = flow_between_with(&pyramid(width, height, 8), &pyramid(width, height, 9), &params, &mut scratch);
        assert_eq!(flow_between_with(&from, &to, &params, &mut scratch), fresh, "after {width}x{height}");
    }
}

#[test]
fn frames_of_different_size_give_no_motion() {
    let params = FlowParams::default();
    let [from, to] = [(20, 10), (10, 20)].map(|(w, h)| FlowPyramid::from_luma(&texture(w, h, 1)));
    assert_eq!(flow_between(&from, &to, &params), FlowField::zero(20, 10));
}
