//! Laws of the agreement, and a naive version.

use super::*;
use crate::flow::FlowField;
use crate::rng::Rng;

const SIZE: (usize, usize) = (80, 60);
/// Every fourth pixel.
const NAIVE_GRID_SIDE: usize = 20;

fn flow_of(size: (usize, usize), motion: impl Fn(usize, usize) -> (f32, f32)) -> CompactFlow {
    let plane = |component: fn((f32, f32)) -> f32| Plane::from_fn(size.0, size.1, |x, y| component(motion(x, y)));
    CompactFlow::new(&FlowField { u: plane(|d| d.0), v: plane(|d| d.1) })
}

/// Object 1, 24 pixels wide and 20 high, with its left border at `left`.
fn object(left: usize) -> Plane<u8> {
    Plane::from_fn(SIZE.0, SIZE.1, |x, y| u8::from((left..left + 24).contains(&x) && (16..36).contains(&y)))
}

fn still(frames: usize) -> Vec<CompactFlow> {
    vec![flow_of(SIZE, |_, _| (0.0, 0.0)); frames - 1]
}

#[test]
fn still_masks_agree_and_empty_ones_say_nothing() {
    let result = agreement(&vec![object(20); 7], &still(7));
    assert_eq!(
        result,
        Agreement {
            clip: Some(1.0),
            frames: vec![Some(1.0); 7],
            objects: vec![vec![Some(1.0); 7]],
            merge_log_odds: None,
            areas: vec![480; 7],
        }
    );

    let result = agreement(&vec![Plane::filled(SIZE.0, SIZE.1, 0); 7], &still(7));
    assert_eq!((result.clip, result.frames, result.objects.len()), (None, vec![None; 7], 0));
}

#[test]
fn masks_that_move_with_the_flow_agree_and_those_that_stay_do_not() {
    // The object moves four pixels a frame before a still scene.
    let corner = |t: usize| 8 + 4 * t;
    let moving: Vec<_> = (0..8).map(|t| object(corner(t))).collect();
    let flows: Vec<_> =
        moving[..7].iter().map(|mask| flow_of(SIZE, |x, y| (4.0 * f32::from(mask[(x, y)]), 0.0))).collect();
    let clip = agreement(&moving, &flows).clip.unwrap();
    assert!(clip > 0.95, "{clip}");
    let clip = agreement(&vec![object(20); 8], &flows).clip.unwrap();
    assert!(clip < 0.9, "{clip}");
}

#[test]
fn a_flooded_mask_agrees_least_and_those_beside_it_less_than_others() {
    let mut masks = vec![object(20); 15];
    masks[7] = Plane::filled(SIZE.0, SIZE.1, 1);
    let frames: Vec<f32> = agreement(&masks, &still(15)).frames.into_iter().flatten().collect();
    assert!(frames[7] < 0.2, "{frames:?}");
    for near in [3, 5, 6, 8, 9, 11] {
        assert!(frames[near] > 0.8 && frames[near] < 0.9, "{frames:?}");
    }
    assert!([0, 1, 2, 4, 10, 12, 13, 14].into_iter().all(|far| frames[far] == 1.0), "{frames:?}");
}

#[test]
fn objects_are_compared_where_one_of_two_frames_has_them() {
    let mut masks = vec![object(20); 12];
    // Object 2 has the right half of object 1 in frame 6 and touches no other frame.
    (16..36).for_each(|y| (32..44).for_each(|x| masks[6][(x, y)] = 2));
    let result = agreement(&masks, &still(12));
    assert_eq!(result.clip, Some(1.0), "all objects as one");
    assert_eq!((result.objects[0][6], result.objects[1][6]), (Some(0.5), Some(0.0)));
    assert_eq!((result.objects[1][7], result.objects[1][9]), (Some(0.0), None));
}

#[test]
fn missing_frames_flows_and_other_sizes_are_left_out() {
    let mut masks = vec![object(20); 6];
    masks[2] = Plane::default();
    let expected = [Some(1.0), Some(1.0), None, Some(1.0), Some(1.0), Some(1.0)];
    assert_eq!(agreement(&masks, &still(6)).frames, expected);
    masks[2] = Plane::filled(90, 60, 1);
    assert_eq!(agreement(&masks, &still(6)).frames, expected);

    let masks = vec![object(20); 4];
    let mut flows = still(4);
    flows[1] = flow_of((20, 20), |_, _| (0.0, 0.0));
    assert_eq!(agreement(&masks, &flows).frames, [Some(1.0); 4], "0 and 1, 2 and 3");
    assert_eq!(agreement(&masks, &flows[..1]).frames, [Some(1.0), Some(1.0), None, None]);
    for (masks, flows) in [(0, 3), (1, 0), (1, 3), (3, 0)] {
        let result = agreement(&vec![object(20); masks], &still(1 + flows));
        assert_eq!((result.clip, result.frames), (None, vec![None; masks]));
    }
    assert_eq!(agreement(&[object(1), object(1)], &still(9)).clip, Some(1.0));
}

/// Follows one pixel at a time and compares one label at a time.
fn naive(masks: &[Plane<u8>], flows: &[CompactFlow], t: usize, is_object: impl Fn(u8) -> bool) -> Option<f32> {
    let ((w, h), step) = (SIZE, 1 << grid_step_log2(SIZE.0, NAIVE_GRID_SIDE));
    let land = |s: usize, gap: usize, x: usize, y: usize| {
        let (mut px, mut py) = (x as f32, y as f32);
        for flow in &flows[s..s + gap] {
            let (u, v) = flow.at((px + 0.5) as usize, (py + 0.5) as usize);
            (px, py) = (px + u, py + v);
            if px < -0.5 || py < -0.5 || px >= w as f32 - 0.5 || py >= h as f32 - 0.5 {
                return None;
            }
        }
        Some((px, py))
    };
    let mut overlaps = Vec::new();
    for gap in [1, 2, 4] {
        for s in [t.checked_sub(gap), Some(t)].into_iter().flatten().filter(|s| s + gap < masks.len()) {
            let starts = || (0..w * h).map(|p| (p % w, p / w)).filter(|(x, y)| x % step == 0 && y % step == 0);
            let cell = |(x, y): (f32, f32)| ((x + 0.5) as usize / step, (y + 0.5) as usize / step);
            let label = |mask: &Plane<u8>, (x, y): (f32, f32)| mask[((x + 0.5) as usize, (y + 0.5) as usize)];
            let (mut both, mut either) = (0, 0);
            for (x, y) in starts() {
                let Some(to) = land(s, gap, x, y) else { continue };
                let (first, second) = (masks[s][(x, y)], label(&masks[s + gap], to));
                let is_shown = |(a, b): (usize, usize)| {
                    let other = land(s, gap, a, b).filter(|&other| cell(other) == cell(to));
                    other.is_some_and(|other| masks[s][(a, b)] == label(&masks[s + gap], other))
                };
                let counts = first == second || !starts().any(is_shown);
                both += u32::from(counts && is_object(first) && is_object(second));
                either += u32::from(counts && (is_object(first) || is_object(second)));
            }
            overlaps.extend((either > 0).then(|| f64::from(both) / f64::from(either)));
        }
    }
    (!overlaps.is_empty()).then(|| (overlaps.iter().sum::<f64>() / overlaps.len() as f64) as f32)
}

#[test]
fn the_agreement_is_that_of_a_naive_version() {
    let mut rng = Rng::for_stage(1, "agreement");
    let (w, h) = SIZE;
    let mut mask = || {
        let corners: Vec<(usize, usize)> = (0..3).map(|_| (rng.below(w), rng.below(h))).collect();
        let label = |x: usize, y: usize| corners.iter().position(|c| c.0.abs_diff(x) < 18 && c.1.abs_diff(y) < 14);
        Plane::from_fn(w, h, |x, y| label(x, y).map_or(0, |k| k as u8 + 1))
    };
    let masks: Vec<_> = (0..6).map(|_| mask()).collect();
    let motion = |t: usize| {
        flow_of(SIZE, move |x, y| {
            let (x, y) = (x as f64 / 7.0 + t as f64, y as f64 / 5.0);
            (2.5 * (x + y).sin() as f32, 1.5 * (x - 2.0 * y).cos() as f32)
        })
    };
    let flows: Vec<_> = (0..5).map(motion).collect();
    let result = agreement_of_grid(&masks, &flows, NAIVE_GRID_SIDE);
    let is_near = |a: Option<f32>, b: Option<f32>| match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() < 1e-6,
        (a, b) => a == b,
    };
    for t in 0..6 {
        let all = naive(&masks, &flows, t, |label| label > 0);
        assert!(is_near(result.frames[t], all), "frame {t}: {:?} {all:?}", result.frames[t]);
        for label in 1..=3 {
            let (object, one) = (result.objects[label - 1][t], naive(&masks, &flows, t, |l| usize::from(l) == label));
            assert!(is_near(object, one), "frame {t}, label {label}: {object:?} {one:?}");
        }
    }
}

#[test]
fn doubts_are_ranges_around_the_frames_that_agree_least() {
    let doubts = |frames: &[Option<f32>]| {
        let areas = vec![100; frames.len()];
        Agreement { frames: frames.to_vec(), areas, ..Agreement::default() }.doubts()
    };
    assert!(doubts(&[]).is_empty() && doubts(&[None; 9]).is_empty() && doubts(&[Some(0.0); 9]).is_empty());
    let mut frames = [Some(0.8); 30];
    assert!(doubts(&frames).is_empty());
    // Just above the threshold, then below it.
    frames[9] = Some(0.57);
    assert!(doubts(&frames).is_empty());
    (frames[9], frames[13], frames[19], frames[0]) = (Some(0.55), Some(0.1), Some(0.2), Some(0.3));
    assert_eq!(doubts(&frames), [0..3, 7..16, 17..22]);
    (frames[29], frames[20]) = (Some(0.0), None);
    assert_eq!(doubts(&frames), [0..3, 7..16, 17..22, 27..30]);
}

#[test]
fn a_flooded_frame_is_a_doubt() {
    let mut masks = vec![object(20); 15];
    masks[7] = Plane::filled(SIZE.0, SIZE.1, 1);
    assert_eq!(agreement(&masks, &still(15)).doubts(), [Range { start: 5, end: 10 }]);
}

#[test]
fn areas_that_jump_are_doubts_and_those_that_grow_are_not() {
    let doubts = |areas: &[u32]| {
        Agreement { frames: vec![Some(0.9); areas.len()], areas: areas.to_vec(), ..Agreement::default() }.doubts()
    };
    let growing: Vec<u32> = (0..40).map(|t| 100 + 20 * t).collect();
    assert!(doubts(&growing).is_empty() && doubts(&[0; 20]).is_empty());
    let mut areas = [100; 30];
    (areas[9], areas[10], areas[20]) = (179, 56, 0);
    assert_eq!(doubts(&areas), [Range { start: 18, end: 23 }]);
    (areas[9], areas[10]) = (181, 55);
    assert_eq!(doubts(&areas), [7..13, 18..23]);
    // An object that enters: too few frames around have one.
    let entering: Vec<u32> = (0..30).map(|t| if t < 26 { 0 } else { 50 }).collect();
    assert!(doubts(&entering).is_empty());
}
