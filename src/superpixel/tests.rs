//! Laws of the superpixels.

use super::*;
use crate::rng::Rng;

/// Checks what [`Superpixels`] promises.
fn check(s: &Superpixels, width: usize, height: usize) {
    assert_eq!((s.label.width(), s.label.height()), (width, height));
    let mut seen = 0;
    for &label in s.label.data() {
        assert!(label <= seen, "label {label} before {seen}");
        seen += u32::from(label == seen);
    }
    assert_eq!(seen as usize, s.count);
    for pair in s.borders.windows(2) {
        assert!((pair[0].a, pair[0].b) < (pair[1].a, pair[1].b), "{pair:?}");
    }
    for border in &s.borders {
        assert!(border.a < border.b && (border.b as usize) < s.count, "{border:?} of {}", s.count);
        assert!(border.length > 0.0 && (0.0..=1.0).contains(&border.pb), "{border:?}");
    }
    let inside =
        |(x, y): (f32, f32)| (-0.5..=width as f32 - 0.5).contains(&x) && (-0.5..=height as f32 - 0.5).contains(&y);
    assert!(s.edges.iter().all(|e| inside(e.from) && inside(e.to) && e.from != e.to));
}

fn map_of(thin: Plane<f32>) -> BoundaryMap {
    BoundaryMap { pb: thin.clone(), thin }
}

fn run(map: &BoundaryMap) -> Superpixels {
    let s = superpixels_in(map, None, &ContourParams::default(), &SuperpixelParams::default());
    check(&s, map.pb.width(), map.pb.height());
    s
}

/// Ridges as a boundary map gives them: the pixels of random lines.
fn random_lines(rng: &mut Rng, width: usize, height: usize, count: usize) -> Plane<f32> {
    let mut thin = Plane::filled(width, height, 0.0);
    for _ in 0..count {
        let mut end = || (rng.range(0.0, width as f64), rng.range(0.0, height as f64));
        let (a, b) = (end(), end());
        let strength = rng.range(0.05, 1.0) as f32;
        let steps = (b.0 - a.0).abs().max((b.1 - a.1).abs()) as usize + 1;
        for k in 0..steps {
            let share = k as f64 / steps as f64;
            thin[((a.0 + share * (b.0 - a.0)) as usize, (a.1 + share * (b.1 - a.1)) as usize)] = strength;
        }
    }
    thin
}

#[test]
fn degenerate_images_give_a_valid_partition() {
    for (width, height) in [(1, 1), (1, 50), (50, 1), (2, 2), (3, 40), (64, 48)] {
        run(&map_of(Plane::filled(width, height, 0.0)));
        run(&map_of(Plane::filled(width, height, 1.0)));
        let mut rng = Rng::for_stage(1, "noise");
        run(&map_of(Plane::from_fn(width, height, |_, _| rng.uniform() as f32)));
        run(&map_of(Plane::from_fn(width, height, |x, y| if (x + y) % 2 == 0 { 0.5 } else { 0.0 })));
    }
    let empty = superpixels_in(&BoundaryMap::default(), None, &ContourParams::default(), &SuperpixelParams::default());
    assert_eq!(empty, Superpixels::default());
}

#[test]
fn a_contour_across_the_image_separates_its_sides() {
    let s = run(&map_of(Plane::from_fn(40, 30, |x, _| if x == 17 { 0.5 } else { 0.0 })));
    let (left, right) = (0..17, 18..40);
    for y in 0..30 {
        for x in left.clone() {
            assert!(right.clone().all(|r| s.label[(x, y)] != s.label[(r, y)]), "column {x}, row {y}");
        }
    }
}

#[test]
fn random_contours_give_a_valid_partition_at_every_count() {
    let mut rng = Rng::for_stage(2, "superpixels");
    for round in 0..200 {
        let (width, height) = (1 + rng.below(90), 1 + rng.below(70));
        let lines = rng.below(30);
        let map = map_of(random_lines(&mut rng, width, height, lines));
        run(&map);
        for count in [1, 7, 40] {
            let s = superpixels_in(&map, Some(count), &ContourParams::default(), &SuperpixelParams::default());
            check(&s, width, height);
            assert!(s.count <= count, "round {round}: {} of {count}", s.count);
        }
    }
}
