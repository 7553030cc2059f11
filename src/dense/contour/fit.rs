//! Straight lines fitted to chains of pixels (Ramer 1972, Douglas and Peucker 1973).
//!
//! A chain is split at the point farthest from the line between its ends, until no point is farther than the tolerance;
//! then long lines are split evenly. Lines begin and end at points of their chain. Two lines that meet elsewhere than in a
//! common end (each is off its chain by up to the tolerance) are split again until none do, which terminates because
//! chains do not cross.

use super::link::Chains;
use crate::order;

/// Straight lines of contours.
///
/// Law: every index of `lines` is below `points.len()`, both ends differ, no line occurs twice (in either direction),
/// two lines meet at most in a common end; points are finite, lie in `-0.5..=width-0.5` and `-0.5..=height-0.5`, and no
/// two are equal.
#[doc(hidden)] // For benchmarks and tests.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Segments {
    /// Ends of the lines in pixels, pixel centres at integers.
    pub points: Vec<(f32, f32)>,
    /// The lines, as indices of their ends.
    pub lines: Vec<(u32, u32)>,
}

/// Points in half pixels.
type Point = (i32, i32);

/// Side of the cells in which meeting lines are searched. Affects speed only.
const CELL_HALF_PX: i32 = 32;

/// The points `from..=to` of a chain as one line, as indices into all points.
#[derive(Clone, Copy, PartialEq)]
struct ChainLine {
    from: usize,
    to: usize,
}

/// Fits lines to all chains. `tolerance` and `max_length` are in pixels; a `max_length` of 0 keeps long lines.
pub(super) fn fit(chains: &Chains, tolerance: f32, max_length: f32) -> Segments {
    let points = &chains.points;
    let mut lines = Vec::new();
    for ends in chains.offset.windows(2) {
        fit_chain(points, ChainLine { from: ends[0], to: ends[1] - 1 }, f64::from(2.0 * tolerance), &mut lines);
    }
    if max_length > 0.0 {
        lines = lines.iter().flat_map(|&line| split_evenly(points, line, f64::from(2.0 * max_length))).collect();
    }
    untangle(points, &mut lines);
    collect_segments(points, &lines)
}

/// Appends the lines of a chain in their order.
fn fit_chain(points: &[Point], chain: ChainLine, tolerance: f64, lines: &mut Vec<ChainLine>) {
    let mut stack = vec![chain];
    while let Some(line) = stack.pop() {
        let (at, distance_sq) = farthest(points, line);
        let closed = points[line.from] == points[line.to];
        if line.to - line.from > 1 && (closed || distance_sq > tolerance * tolerance) {
            stack.push(ChainLine { from: at, ..line });
            stack.push(ChainLine { to: at, ..line });
        } else {
            lines.push(line);
        }
    }
}

/// Returns the inner point that is farthest from the line between the ends (from the ends if they are equal), and its squared
/// distance. Of several the one nearest the middle.
fn farthest(points: &[Point], line: ChainLine) -> (usize, f64) {
    let (a, b) = (points[line.from], points[line.to]);
    let length_sq = distance_sq(a, b);
    let measure = |p: Point| if length_sq == 0 { distance_sq(a, p) } else { cross(a, b, p).abs() };
    let off_middle = |i: usize| (2 * i).abs_diff(line.from + line.to);
    let key = |i: &usize| (measure(points[*i]), std::cmp::Reverse(off_middle(*i)));
    let Some(at) = (line.from + 1..line.to).max_by_key(key) else {
        return (line.from, 0.0);
    };
    let value = measure(points[at]) as f64;
    (at, if length_sq == 0 { value } else { value * value / length_sq as f64 })
}

fn split_evenly(points: &[Point], line: ChainLine, max_length: f64) -> Vec<ChainLine> {
    let length = (distance_sq(points[line.from], points[line.to]) as f64).sqrt();
    let count = ((length / max_length).ceil() as usize).clamp(1, line.to - line.from);
    let bound = |i: usize| line.from + i * (line.to - line.from) / count;
    (0..count).map(|i| ChainLine { from: bound(i), to: bound(i + 1) }).collect()
}

/// Splits lines that meet elsewhere than in a common end, until none do.
fn untangle(points: &[Point], lines: &mut Vec<ChainLine>) {
    loop {
        let mut tangled = vec![false; lines.len()];
        for (i, j) in near_pairs(points, lines) {
            let ends = [lines[i], lines[j]].map(|line| [points[line.from], points[line.to]]);
            if intersect(ends[0], ends[1]) {
                tangled[i] = true;
                tangled[j] = true;
            }
        }
        let mut finer = Vec::with_capacity(lines.len());
        for (&line, tangled) in lines.iter().zip(tangled) {
            if tangled && line.to - line.from > 1 {
                let (at, _) = farthest(points, line);
                finer.extend([ChainLine { to: at, ..line }, ChainLine { from: at, ..line }]);
            } else {
                finer.push(line);
            }
        }
        if finer.len() == lines.len() {
            return;
        }
        *lines = finer;
    }
}

/// Returns pairs of lines that share a cell, some more than once.
fn near_pairs(points: &[Point], lines: &[ChainLine]) -> Vec<(usize, usize)> {
    let cell = |v: i32| (v + 1) / CELL_HALF_PX;
    let mut entries = Vec::new();
    for (index, line) in lines.iter().enumerate() {
        let (a, b) = (points[line.from], points[line.to]);
        for y in cell(a.1.min(b.1))..=cell(a.1.max(b.1)) {
            for x in cell(a.0.min(b.0))..=cell(a.0.max(b.0)) {
                entries.push((y, x, index));
            }
        }
    }
    // Stable: within a cell they stay in the order of their indices.
    order::sort_by_key(&mut entries, |&(y, x, _)| order::pair_key(y as u32, x as u32));
    let mut pairs = Vec::new();
    for group in entries.chunk_by(|p, q| (p.0, p.1) == (q.0, q.1)) {
        for (k, p) in group.iter().enumerate() {
            pairs.extend(group[..k].iter().map(|q| (q.2, p.2)));
        }
    }
    pairs
}

/// Returns `true` if two lines have a point in common other than one end of both. Equal lines do not count: one of them is
/// dropped later.
fn intersect([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    if (a, b) == (c, d) || (a, b) == (d, c) {
        return false;
    }
    let common_end = [(a, b, c, d), (a, b, d, c), (b, a, c, d), (b, a, d, c)].into_iter().find(|(p, _, q, _)| p == q);
    if let Some((p, q, _, r)) = common_end {
        // From a common end they meet again only in the same direction.
        return cross(p, q, r) == 0 && dot(p, q, r) > 0;
    }
    let side = |p, q, r| cross(p, q, r).signum();
    let (s1, s2, s3, s4) = (side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b));
    if s1 == 0 && s2 == 0 {
        return [a, b].iter().any(|&p| dot(p, c, d) <= 0) || [c, d].iter().any(|&p| dot(p, a, b) <= 0);
    }
    s1 * s2 <= 0 && s3 * s4 <= 0
}

fn distance_sq(a: Point, b: Point) -> i64 {
    dot(a, b, b)
}

/// Product of `b - a` and `c - a`.
fn dot(a: Point, b: Point, c: Point) -> i64 {
    i64::from(b.0 - a.0) * i64::from(c.0 - a.0) + i64::from(b.1 - a.1) * i64::from(c.1 - a.1)
}

/// Twice the signed area of a triangle.
fn cross(a: Point, b: Point, c: Point) -> i64 {
    i64::from(b.0 - a.0) * i64::from(c.1 - a.1) - i64::from(b.1 - a.1) * i64::from(c.0 - a.0)
}

/// Collects points and lines, each once.
fn collect_segments(points: &[Point], lines: &[ChainLine]) -> Segments {
    let mut places: Vec<Point> = lines.iter().flat_map(|p| [points[p.from], points[p.to]]).collect();
    order::sort_by_key(&mut places, |&(x, y)| order::pair_key(order::i32_key(y), order::i32_key(x)));
    places.dedup();
    let index = |p: Point| places.partition_point(|&(x, y)| (y, x) < (p.1, p.0)) as u32;
    let mut lines: Vec<(u32, u32)> = lines
        .iter()
        .map(|p| (index(points[p.from]), index(points[p.to])))
        .map(|(a, b)| (a.min(b), a.max(b)))
        .filter(|(a, b)| a != b)
        .collect();
    order::sort_by_key(&mut lines, |&(a, b)| order::pair_key(a, b));
    lines.dedup();
    Segments { points: places.iter().map(|&(x, y)| (0.5 * x as f32, 0.5 * y as f32)).collect(), lines }
}

#[cfg(test)]
mod tests {
    use crate::contour::{BoundaryMap, ContourParams, Segments, contour_segments};
    use crate::image::Plane;
    use crate::rng::Rng;

    fn segments(thin: Plane<f32>) -> Segments {
        let (width, height) = (thin.width() as f32, thin.height() as f32);
        let segments = contour_segments(&BoundaryMap { pb: thin.clone(), thin }, &ContourParams::default());
        check(&segments, width, height);
        segments
    }

    /// The law of [`Segments`], pair by pair.
    fn check(segments: &Segments, width: f32, height: f32) {
        let p = |i: u32| segments.points[i as usize];
        for (i, &(x, y)) in segments.points.iter().enumerate() {
            assert!((-0.5..=width - 0.5).contains(&x) && (-0.5..=height - 0.5).contains(&y), "({x}, {y})");
            assert!(!segments.points[..i].contains(&(x, y)), "({x}, {y}) twice");
        }
        // Coordinates are halves below 2^14, so that these products are exact.
        let cross = |a: (f32, f32), b: (f32, f32), c: (f32, f32)| {
            f64::from(b.0 - a.0) * f64::from(c.1 - a.1) - f64::from(b.1 - a.1) * f64::from(c.0 - a.0)
        };
        let on = |q: (f32, f32), (a, b): (u32, u32)| {
            let (a, b) = (p(a), p(b));
            let within = |v: f32, s: f32, t: f32| s.min(t) <= v && v <= s.max(t);
            cross(a, b, q) == 0.0 && within(q.0, a.0, b.0) && within(q.1, a.1, b.1)
        };
        let side = |a, b, c| cross(a, b, c).partial_cmp(&0.0).map_or(0, |o| o as i32);
        for (i, &(a, b)) in segments.lines.iter().enumerate() {
            assert!(a != b && a.max(b) < segments.points.len() as u32);
            for &(c, d) in &segments.lines[..i] {
                assert!((c, d) != (a, b) && (d, c) != (a, b), "a line twice");
                let [e, f, g, h] = [a, b, c, d].map(p);
                let through = side(e, f, g) * side(e, f, h) < 0 && side(g, h, e) * side(g, h, f) < 0;
                assert!(!through, "{e:?}-{f:?} crosses {g:?}-{h:?}");
                for (end, line) in [(a, (c, d)), (b, (c, d)), (c, (a, b)), (d, (a, b))] {
                    assert!(end == line.0 || end == line.1 || !on(p(end), line), "{:?} on {line:?}", p(end));
                }
            }
        }
    }

    #[test]
    fn lines_of_noise_meet_in_their_ends_only() {
        let mut rng = Rng::for_stage(1, "fit");
        for _ in 0..60 {
            let (width, height) = (1 + rng.below(60), 1 + rng.below(60));
            let share = rng.uniform();
            let noise = |rng: &mut Rng| if rng.uniform() < share { rng.uniform() as f32 } else { 0.0 };
            segments(Plane::from_fn(width, height, |_, _| noise(&mut rng)));
        }
    }

    #[test]
    fn a_straight_ridge_becomes_one_line_from_border_to_border() {
        // It ends three pixels before the border on one side and has a gap of one pixel.
        let segments = segments(Plane::from_fn(40, 30, |x, y| if x == 11 && y > 2 && y != 14 { 0.5 } else { 0.0 }));
        assert_eq!(segments.points, [(11.0, -0.5), (11.0, 29.5)]);
        assert_eq!(segments.lines, [(0, 1)]);
    }

    #[test]
    fn faint_and_short_ridges_are_left_out() {
        let ridge = |length: usize, strength: f32| {
            let on = |x: usize, y: usize| y == 20 && (20..20 + length).contains(&x);
            segments(Plane::from_fn(60, 40, |x, y| if on(x, y) { strength } else { 0.0 }))
        };
        let ContourParams { high_threshold: high, min_length: min_chain, .. } = ContourParams::default();
        // The thresholds fall in an image that has hardly a line.
        assert!(ridge(20, 0.09 * high).lines.is_empty());
        assert!(ridge(min_chain as usize - 1, 1.0).lines.is_empty());
        assert_eq!(ridge(min_chain as usize, 1.0).lines.len(), 1);
    }

    #[test]
    fn a_ring_becomes_a_closed_polygon_of_few_lines() {
        let on_ring = |x: usize, y: usize| {
            let (dx, dy) = (x as f32 - 40.0, y as f32 - 40.0);
            ((dx * dx + dy * dy).sqrt() - 25.0).abs() < 0.6
        };
        let segments = segments(Plane::from_fn(80, 80, |x, y| if on_ring(x, y) { 0.5 } else { 0.0 }));
        assert_eq!(segments.lines.len(), segments.points.len());
        assert!((6..=16).contains(&segments.lines.len()), "{} lines", segments.lines.len());
        for i in 0..segments.points.len() as u32 {
            assert_eq!(segments.lines.iter().filter(|&&(a, b)| a == i || b == i).count(), 2);
        }
    }

    #[test]
    fn an_open_ended_crossing_keeps_its_four_arms() {
        let segments = segments(Plane::from_fn(61, 61, |x, y| if x == 30 || y == 30 { 0.5 } else { 0.0 }));
        assert_eq!(segments.points.len(), 5, "{segments:?}");
        assert_eq!(segments.lines.len(), 4);
    }
}
