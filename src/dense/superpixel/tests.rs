//! Laws of the superpixels.

use super::gabriel::{Point, UNITS_PER_PX};
use super::*;
use crate::rng::Rng;

/// Checks the law of [`Superpixels`].
fn check(s: &Superpixels, width: usize, height: usize) {
    let labels = s.label();
    assert_eq!((labels.width(), labels.height()), (width, height));
    let mut seen = 0;
    for &label in labels.data() {
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
    let map = map_of(Plane::from_fn(40, 30, |x, _| if x == 17 { 0.5 } else { 0.0 }));
    let s = superpixels_in(&map, Some(2), &ContourParams::default(), &SuperpixelParams::default());
    check(&s, 40, 30);
    // Pixels on the line go to its right.
    assert_eq!(s.label(), Plane::from_fn(40, 30, |x, _| u32::from(x >= 17)));
    assert_eq!(s.borders.len(), 1);
    let SuperpixelBorder { length, pb, .. } = s.borders[0];
    assert!((length - 30.0).abs() < 1e-3 && (pb - 0.5).abs() < 1e-6, "length {length}, pb {pb}");
}

#[test]
fn borders_of_four_quarters_have_their_lengths_and_strengths() {
    let strength = |x: usize, y: usize| match (x, y) {
        (17, 0..11) => 0.2,
        (17, _) => 0.4,
        (0..17, 11) => 0.6,
        (_, 11) => 0.8,
        _ => 0.0,
    };
    let s = superpixels_in(
        &map_of(Plane::from_fn(40, 30, strength)),
        Some(4),
        &ContourParams::default(),
        &SuperpixelParams::default(),
    );
    check(&s, 40, 30);
    let expected = [(0, 1, 11.5, 0.2), (0, 2, 17.5, 0.6), (1, 3, 22.5, 0.8), (2, 3, 18.5, 0.4)];
    assert_eq!(s.borders.len(), 4, "{:?}", s.borders);
    for (border, (a, b, length, pb)) in s.borders.iter().zip(expected) {
        assert_eq!((border.a, border.b), (a, b));
        // Near the crossing the strongest of all arms counts.
        assert!((border.length - length).abs() < 1e-3 && (border.pb - pb).abs() < 0.1, "{border:?}");
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
        let [all, seven, one] = [usize::MAX, 7, 1].map(|count| {
            let s = superpixels_in(&map, Some(count), &ContourParams::default(), &SuperpixelParams::default());
            check(&s, width, height);
            s.count
        });
        assert_eq!((seven, one), (all.min(7), 1), "round {round}: {all} in all");
    }
}

fn cross(a: Point, b: Point, c: Point) -> i128 {
    i128::from(b.0 - a.0) * i128::from(c.1 - a.1) - i128::from(b.1 - a.1) * i128::from(c.0 - a.0)
}

/// Returns `true` if two lines cross inside both.
fn cross_properly(a: Point, b: Point, c: Point, d: Point) -> bool {
    let side = |p, q, r| cross(p, q, r).signum();
    side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0
}

/// Positive if `d` lies inside the circle through `a`, `b`, `c`, which turn anticlockwise.
fn in_circle(a: Point, b: Point, c: Point, d: Point) -> i128 {
    let row = |p: Point| {
        let (x, y) = (i128::from(p.0 - d.0), i128::from(p.1 - d.1));
        (x, y, x * x + y * y)
    };
    let (a, b, c) = (row(a), row(b), row(c));
    a.0 * (b.1 * c.2 - b.2 * c.1) - a.1 * (b.0 * c.2 - b.2 * c.0) + a.2 * (b.0 * c.1 - b.1 * c.0)
}

/// Random points on a fine grid, so that hardly ever four lie on a circle, and lines between them that do not cross.
fn random_segments(rng: &mut Rng, width: usize, height: usize, num_points: usize) -> Segments {
    let place = |rng: &mut Rng, end: usize| (rng.range(0.0, end as f64 - 1.0) * 256.0).floor() as f32 / 256.0;
    let points: Vec<(f32, f32)> = (0..num_points).map(|_| (place(rng, width), place(rng, height))).collect();
    let units = |i: u32| {
        let (x, y) = points[i as usize];
        ((x * 256.0) as i64, (y * 256.0) as i64)
    };
    let mut lines: Vec<(u32, u32)> = Vec::new();
    for _ in 0..2 * num_points {
        let (a, b) = (rng.below(num_points) as u32, rng.below(num_points) as u32);
        let near =
            (units(a).0 - units(b).0).abs() < 12 * UNITS_PER_PX && (units(a).1 - units(b).1).abs() < 12 * UNITS_PER_PX;
        let free = lines.iter().all(|&(c, d)| !cross_properly(units(a), units(b), units(c), units(d)));
        if a < b && near && free && !lines.contains(&(a, b)) {
            lines.push((a, b));
        }
    }
    Segments { points, lines }
}

/// Checks that the triangulation covers the image and that each edge that is not given is locally Delaunay; with that
/// it is the constrained Delaunay triangulation (Lee and Lin, "Generalized Delaunay Triangulation for Planar Graphs",
/// 1986).
fn check_triangulation(graph: &Graph, segments: &Segments, width: usize, height: usize) {
    let p = |i: u32| graph.points[i as usize];
    let triangles = &graph.triangulation.triangles;
    let area: i128 = triangles.iter().map(|&[a, b, c]| cross(p(a), p(b), p(c))).sum();
    assert_eq!(area, 2 * (width * height) as i128 * i128::from(UNITS_PER_PX * UNITS_PER_PX));
    let given: Vec<(u32, u32)> =
        graph.triangulation.edges.iter().filter(|e| e.is_constraint).map(|e| (e.ends[0], e.ends[1])).collect();
    let mut wanted = segments.lines.clone();
    wanted.sort();
    assert_eq!(given, wanted);
    for edge in &graph.triangulation.edges {
        let [Some(s), Some(t)] = edge.triangles else { continue };
        let apex = |t: u32| p(*triangles[t as usize].iter().find(|i| !edge.ends.contains(i)).unwrap());
        let [a, b, c] = triangles[s as usize].map(p);
        assert!(cross(a, b, c) > 0);
        assert!(edge.is_constraint || in_circle(a, b, c, apex(t)) <= 0, "{edge:?} is not Delaunay");
        let [e, f] = edge.ends.map(p);
        assert!(cross(e, f, apex(s)).signum() * cross(e, f, apex(t)).signum() < 0, "{edge:?} folds over");
    }
}

/// Classifies an edge by trying every point: it is deleted if one inside its diametral circle sees both of its ends.
fn naive_kind(graph: &Graph, segments: &Segments, ends: [u32; 2], on_hull: bool) -> EdgeKind {
    let p = |i: u32| graph.points[i as usize];
    let [a, b] = ends.map(p);
    if on_hull {
        return EdgeKind::Frame;
    }
    if segments.lines.contains(&(ends[0], ends[1])) {
        return EdgeKind::Constraint;
    }
    let sees = |c: Point, d: Point| segments.lines.iter().all(|&(e, f)| !cross_properly(c, d, p(e), p(f)));
    let inside = |c: Point| (a.0 - c.0) * (b.0 - c.0) + (a.1 - c.1) * (b.1 - c.1) < 0;
    let violated = graph.points.iter().any(|&c| c != a && c != b && inside(c) && sees(a, c) && sees(b, c));
    if violated { EdgeKind::Deleted } else { EdgeKind::Gabriel }
}

/// The face of each triangle, by spreading over pairs of triangles with a deleted edge in common.
fn naive_faces(graph: &Graph, kinds: &[EdgeKind]) -> Vec<usize> {
    let triangles = &graph.triangulation.triangles;
    let mut face: Vec<usize> = (0..triangles.len()).collect();
    for _ in 0..triangles.len() {
        for (edge, kind) in graph.triangulation.edges.iter().zip(kinds) {
            let beside: Vec<usize> =
                (0..triangles.len()).filter(|&t| edge.ends.iter().all(|e| triangles[t].contains(e))).collect();
            if let (&[s, t], EdgeKind::Deleted) = (&beside[..], kind) {
                let both = face[s].min(face[t]);
                (face[s], face[t]) = (both, both);
            }
        }
    }
    face
}

#[test]
fn faces_equal_a_brute_force_construction_on_random_segments() {
    let mut rng = Rng::for_stage(4, "gabriel");
    let params = SuperpixelParams { merge_threshold: 0.0 };
    for round in 0..60 {
        let (width, height) = (20 + rng.below(30), 20 + rng.below(30));
        let num_points = rng.below(30);
        let segments = random_segments(&mut rng, width, height, num_points);
        let graph = Graph::new(&segments, width, height, 0.0);
        check_triangulation(&graph, &segments, width, height);
        let edges = &graph.triangulation.edges;
        let hull = |e: &crate::delaunay::TriangulationEdge| e.triangles.contains(&None);
        let kinds: Vec<EdgeKind> = edges.iter().map(|e| naive_kind(&graph, &segments, e.ends, hull(e))).collect();
        assert_eq!(graph.kinds, kinds, "round {round}");
        let faces = naive_faces(&graph, &kinds);
        let found = gabriel_superpixels(&segments, &map_of(Plane::filled(width, height, 0.0)), &params);
        check(&found, width, height);
        // Superpixel and face of each pixel whose centre is inside a triangle name each other.
        let mut pairs = Vec::new();
        for (i, &label) in found.label().data().iter().enumerate() {
            let centre = ((i % width) as i64 * UNITS_PER_PX, (i / width) as i64 * UNITS_PER_PX);
            let holds = |&t: &usize| {
                let [a, b, c] = graph.triangulation.triangles[t].map(|i| graph.points[i as usize]);
                cross(a, b, centre) > 0 && cross(b, c, centre) > 0 && cross(c, a, centre) > 0
            };
            pairs.extend((0..faces.len()).find(holds).map(|t| (label, faces[t])));
        }
        assert!(pairs.len() > width * height / 2, "round {round}: {} centres", pairs.len());
        pairs.sort();
        pairs.dedup();
        let distinct = |mut v: Vec<usize>| {
            v.sort();
            v.dedup();
            v.len()
        };
        assert_eq!(distinct(pairs.iter().map(|p| p.0 as usize).collect()), pairs.len(), "round {round}");
        assert_eq!(distinct(pairs.iter().map(|p| p.1).collect()), pairs.len(), "round {round}");
    }
}
