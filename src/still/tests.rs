//! Laws of pixel embeddings and their discontinuities.

use super::*;
use crate::rng::Rng;

fn frame(w: usize, h: usize, mut grey: impl FnMut(usize, usize) -> u8) -> Frame {
    let rgb = (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).flat_map(|(x, y)| [grey(x, y); 3]).collect();
    Frame::from_rgb(rgb, w, h).unwrap()
}

/// Rectangles of random greys, and noise.
fn clutter(w: usize, h: usize, seed: u64) -> Frame {
    let mut rng = Rng::for_stage(seed, "clutter");
    let boxes: Vec<[usize; 5]> =
        (0..10).map(|_| [w, h, w, h, 256].map(|n| (rng.uniform() * n as f64) as usize)).collect();
    let mut noise = Rng::for_stage(seed, "noise");
    frame(w, h, |x, y| {
        let inside = |b: &&[usize; 5]| (b[0]..=b[0] + b[2] / 2).contains(&x) && (b[1]..=b[1] + b[3] / 2).contains(&y);
        let grey = boxes.iter().rev().find(inside).map_or(90, |b| b[4]);
        (grey as u8 / 16 * 15).saturating_add((noise.uniform() * 16.0) as u8)
    })
}

fn detect(frame: &Frame, params: &StillParams) -> ImageDiscontinuities {
    image_discontinuities(frame, params, 0)
}

fn check(result: &ImageDiscontinuities, size: (usize, usize)) {
    let pairs = [
        (&result.pb.pb, &result.pb.thin),
        (&result.d.strength, &result.d.thin),
        (&result.spectral.strength, &result.spectral.thin),
        (&result.combined.pb, &result.combined.thin),
    ];
    for (map, thin) in pairs {
        assert_eq!((map.width(), map.height()), size);
        assert_eq!((thin.width(), thin.height()), size);
        for (&v, &t) in map.data().iter().zip(thin.data()) {
            assert!((0.0..=1.0).contains(&v) && (t == 0.0 || t == v), "strength {v}, thin {t}");
        }
    }
    assert_eq!(result.eigenvalues.len(), result.eigenvectors.len());
    assert!(result.eigenvalues.is_sorted_by(|a, b| a >= b));
}

#[test]
fn two_flat_halves_have_their_discontinuity_between_them() {
    for (w, h) in [(64, 48), (160, 100)] {
        let halves = frame(w, h, |x, _| if x < w / 2 { 40 } else { 210 });
        for (grouping, least, most) in [(Grouping::Joint, 0.95, 0.5), (Grouping::Single, 0.6, 0.3)] {
            let result = detect(&halves, &StillParams { grouping, ..StillParams::default() });
            check(&result, (w, h));
            for y in 0..h {
                let row = result.d.strength.row(y);
                let cut = row[w / 2 - 2..w / 2 + 2].iter().fold(0.0_f32, |m, &v| m.max(v));
                assert!(cut > least, "{cut} on the cut of {w}x{h} {grouping:?}");
                let inside = row.iter().enumerate().filter(|(x, _)| x.abs_diff(w / 2) > 3);
                inside.for_each(|(x, &d)| assert!(d < most, "{d} at {x}, {y} of {w}x{h} {grouping:?}"));
            }
        }
    }
}

#[test]
fn flat_images_have_no_discontinuities() {
    for (w, h) in [(1, 1), (1, 30), (30, 1), (2, 2), (5, 3), (60, 45)] {
        let result = detect(&frame(w, h, |_, _| 120), &StillParams::default());
        check(&result, (w, h));
        for map in [&result.d.strength, &result.spectral.strength] {
            assert!(map.data().iter().all(|&v| v == 0.0), "{w}x{h}");
        }
        assert_eq!(result.combined, result.pb);
    }
}

#[test]
fn images_of_any_small_size_have_legal_maps() {
    for (w, h) in [(1, 1), (1, 2), (2, 1), (1, 40), (40, 1), (2, 2), (3, 5), (16, 4), (19, 18)] {
        for grouping in [Grouping::Joint, Grouping::Single] {
            let params = StillParams { grouping, ..StillParams::default() };
            check(&detect(&clutter(w, h, 5), &params), (w, h));
        }
    }
}

#[test]
fn the_finest_level_is_embedded_with_orthonormal_vectors_every_time_the_same() {
    let image = clutter(140, 100, 1);
    let params = StillParams::default();
    let first = detect(&image, &params);
    check(&first, (140, 100));
    assert!(first.info.residual < 0.1, "{:?}", first.info);
    assert!((first.eigenvalues[0] - 1.0).abs() < 1e-4, "{:?}", first.eigenvalues);
    let graph = graph::PixelGraph::new(&first.pb.thin, params.radius, params.sigma);
    let product = |a: &Plane<f32>, b: &Plane<f32>| -> f64 {
        let terms = a.data().iter().zip(b.data()).zip(&graph.scale);
        terms.map(|((&a, &b), &s)| f64::from(a) * f64::from(b) / f64::from(s * s)).sum()
    };
    for (i, a) in first.eigenvectors.iter().enumerate() {
        for (j, b) in first.eigenvectors.iter().enumerate() {
            let expected = f64::from(u8::from(i == j));
            assert!((product(a, b) - expected).abs() < 1e-4, "VᵀDV has {} at {i}, {j}", product(a, b));
        }
    }
    assert_eq!(detect(&image, &params), first);
}

#[test]
fn parameters_at_the_ends_of_their_ranges_give_legal_maps() {
    let ends = [
        StillParams { sigma: 0.001, ..StillParams::default() },
        StillParams { sigma: 10.0, radius: 10, ..StillParams::default() },
        StillParams { radius: 1, dimensions: 2, ..StillParams::default() },
        StillParams { dimensions: 64, weight: 100.0, ..StillParams::default() },
    ];
    for params in ends {
        check(&detect(&clutter(40, 31, 6), &params), (40, 31));
        check(&detect(&clutter(125, 97, 6), &params), (125, 97));
    }
}

#[test]
fn without_weight_the_combined_map_is_pb() {
    let image = clutter(60, 45, 2);
    let plain = detect(&image, &StillParams { weight: 0.0, ..StillParams::default() });
    assert_eq!(plain.combined, plain.pb);
    let default = detect(&image, &StillParams::default());
    assert_eq!(default.pb, plain.pb);
    assert_ne!(default.combined, default.pb);
}

#[test]
fn large_images_are_reduced() {
    let image = clutter(120, 61, 2);
    let small = detect(&image, &StillParams { max_side: 60, ..StillParams::default() });
    check(&small, (60, 31));
    assert_eq!(small.pb, detect(&image.resized(60, 31), &StillParams::default()).pb);
}
