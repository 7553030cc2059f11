//! Laws of the boundary map.

use super::*;
use crate::rng::Rng;

fn frame(w: usize, h: usize, mut color: impl FnMut(usize, usize) -> [u8; 3]) -> Frame {
    let rgb = (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).flat_map(|(x, y)| color(x, y)).collect();
    Frame::from_rgb(rgb, w, h).unwrap()
}

/// Rectangles of random colours, and noise.
fn clutter(w: usize, h: usize, seed: u64) -> Frame {
    let mut rng = Rng::for_stage(seed, "clutter");
    let mut byte = move || rng.below(256) as u8;
    let boxes: Vec<([usize; 4], [u8; 3])> = (0..12)
        .map(|_| {
            let [x, y, dx, dy] = [w, h, w, h].map(|n| usize::from(byte()) * n / 256);
            ([x, y, x + dx, y + dy], [byte(), byte(), byte()])
        })
        .collect();
    frame(w, h, |x, y| {
        let inside = |b: &[usize; 4]| (b[0]..=b[2]).contains(&x) && (b[1]..=b[3]).contains(&y);
        let color = boxes.iter().rev().find(|(b, _)| inside(b)).map_or([90; 3], |&(_, color)| color);
        color.map(|v| v / 16 * 15 + byte() / 16)
    })
}

fn map_of(frame: &Frame) -> BoundaryMap {
    boundary_map(frame)
}

#[test]
fn values_are_probabilities_and_thin_keeps_them_or_nothing() {
    for seed in 0..4 {
        let map = map_of(&clutter(61, 47, seed));
        let mut num_kept = 0;
        for (&pb, &thin) in map.pb.data().iter().zip(map.thin.data()) {
            assert!((0.0..=1.0).contains(&pb), "pb {pb}");
            assert!(thin == 0.0 || thin == pb, "thin {thin}, pb {pb}");
            num_kept += usize::from(thin > 0.1);
        }
        assert!(num_kept > 30, "{num_kept} pixels on ridges");
    }
}

#[test]
fn a_flat_image_has_no_boundary_not_even_at_its_frame() {
    for (w, h) in [(40, 31), (1, 1), (1, 9), (7, 1), (2, 2), (3, 3)] {
        for color in [[0; 3], [255; 3], [200, 30, 90]] {
            let map = map_of(&frame(w, h, |_, _| color));
            assert_eq!((map.pb.width(), map.pb.height()), (w, h));
            assert!(map.pb.data().iter().chain(map.thin.data()).all(|v| v.abs() < 1e-6), "{w}x{h} {color:?}");
        }
    }
}

#[test]
fn images_of_any_small_size_give_probabilities() {
    for (w, h) in [(1, 1), (1, 2), (2, 1), (1, 40), (40, 1), (2, 2), (3, 5), (5, 4)] {
        let map = map_of(&clutter(w, h, 3));
        assert!(map.pb.data().iter().all(|v| (0.0..=1.0).contains(v)), "{w}x{h}");
    }
}

#[test]
fn a_step_gives_a_strong_line_beside_it_from_frame_to_frame() {
    let (w, h) = (64, 48);
    for (slope_x, slope_y) in [(1.0_f32, 0.0_f32), (0.0, 1.0), (0.707, 0.707), (0.6, -0.8)] {
        let side = |x: usize, y: usize| slope_x * (x as f32 - 31.5) + slope_y * (y as f32 - 23.5);
        let map = map_of(&frame(w, h, |x, y| if side(x, y) < 0.0 { [60, 70, 60] } else { [190, 150, 120] }));
        let mut on_line = 0;
        for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
            let thin = map.thin[(x, y)];
            let distance = side(x, y).abs();
            // Mirroring bends a slanting step where it meets the frame.
            let inside = (6..w - 6).contains(&x) && (6..h - 6).contains(&y);
            assert!(!inside || thin < 0.05 || distance <= 1.2, "{thin} at {x}, {y}, {distance} from the step");
            on_line += usize::from(thin > 0.4);
        }
        assert!((h - 4..=2 * w).contains(&on_line), "{on_line} pixels on the step ({slope_x}, {slope_y})");
    }
}

#[test]
fn a_step_of_colour_alone_or_texture_alone_is_seen() {
    let color = map_of(&frame(64, 48, |x, _| if x < 32 { [150, 110, 110] } else { [95, 133, 110] }));
    let texture = map_of(&frame(64, 48, |x, y| {
        let bright = if x < 32 { x % 6 < 3 } else { y % 6 < 3 };
        [if bright { 150 } else { 100 }; 3]
    }));
    for (name, map) in [("colour", color), ("texture", texture)] {
        let (middle, side) = (map.pb[(31, 24)].max(map.pb[(32, 24)]), map.pb[(14, 24)]);
        assert!(middle > 0.03 && middle > 2.0 * side, "{name}: {middle} at the step, {side} beside it");
    }
}

#[test]
fn mirrored_and_transposed_images_give_mirrored_and_transposed_maps() {
    // Sides divisible by four, as halving starts at the top left.
    let (w, h) = (48, 40);
    let image = clutter(w, h, 9);
    let at = |x: usize, y: usize| {
        let i = 3 * (y * w + x);
        [image.rgb()[i], image.rgb()[i + 1], image.rgb()[i + 2]]
    };
    let map = map_of(&image);
    let mirrored = map_of(&frame(w, h, |x, y| at(w - 1 - x, y)));
    let transposed = map_of(&frame(h, w, |x, y| at(y, x)));
    for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
        let pb = map.pb[(x, y)];
        let transformed = [mirrored.pb[(w - 1 - x, y)], transposed.pb[(y, x)]];
        assert!(transformed.iter().all(|o| (o - pb).abs() < 1e-3), "{pb} and {transformed:?} at {x}, {y}");
    }
}
