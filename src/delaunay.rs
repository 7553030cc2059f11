//! Delaunay triangulation of points in the plane; the only file that names `spade`.

use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};

/// A point that remembers its index in the input.
struct Site {
    position: Point2<f64>,
    index: u32,
}

impl HasPosition for Site {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.position
    }
}

/// The Delaunay edges of `points`, each `(i, j)` with `i < j`, sorted.
///
/// Points on a line are joined in their order; a point at the very place of an earlier one is joined to that one only, so that no
/// point is left without a neighbour. Coordinates must be finite. O(n log n).
pub fn delaunay_edges(points: &[(f32, f32)]) -> Vec<(u32, u32)> {
    let mut edges = Vec::with_capacity(3 * points.len());
    if let Some(triangulation) = triangulate(points, |i, j| edges.push((i, j))) {
        for edge in triangulation.undirected_edges() {
            let [a, b] = edge.vertices().map(|v| v.data().index);
            edges.push((a.min(b), a.max(b)));
        }
    }
    edges.sort_unstable();
    edges
}

/// The Delaunay triangles of `points`; of several points at one place, the first stands for all. None for points on a line.
/// Coordinates must be finite.
pub fn delaunay_triangles(points: &[(f32, f32)]) -> Vec<[u32; 3]> {
    let triangulation = triangulate(points, |_, _| {});
    triangulation.iter().flat_map(|t| t.inner_faces()).map(|f| f.vertices().map(|v| v.data().index)).collect()
}

/// The triangulation of all different places; `same` is told of each further point at the place of another.
fn triangulate(points: &[(f32, f32)], mut same: impl FnMut(u32, u32)) -> Option<DelaunayTriangulation<Site>> {
    let mut order: Vec<Site> =
        (0..).zip(points).map(|(index, &(x, y))| Site { position: Point2::new(settle(x), settle(y)), index }).collect();
    order.sort_by(|a, b| {
        let (p, q) = (a.position, b.position);
        p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(a.index.cmp(&b.index))
    });
    let mut sites: Vec<Site> = Vec::with_capacity(points.len());
    for site in order {
        match sites.last() {
            Some(last) if last.position == site.position => same(last.index, site.index),
            _ => sites.push(site),
        }
    }
    DelaunayTriangulation::bulk_load(sites).ok()
}

/// The coordinate as `spade` accepts it: magnitudes below 2^-142 are too small for its predicates and count as zero.
fn settle(coordinate: f32) -> f64 {
    if coordinate.abs() < 1e-30 { 0.0 } else { f64::from(coordinate) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    /// Every edge that some circle through its ends shows to be Delaunay, by trying all third points: O(n³).
    fn naive_edges(points: &[(f32, f32)]) -> Vec<(u32, u32)> {
        let n = points.len();
        let p = |i: usize| (f64::from(points[i].0), f64::from(points[i].1));
        let mut edges = Vec::new();
        for i in 0..n {
            for j in i + 1..n {
                // Circles through i and j have centres m + s·normal; every other point bounds s from one side.
                let (a, b) = (p(i), p(j));
                let (nx, ny) = (a.1 - b.1, b.0 - a.0);
                let (mx, my) = (0.5 * (a.0 + b.0), 0.5 * (a.1 + b.1));
                let half = 0.25 * ((a.0 - b.0).powi(2) + (a.1 - b.1).powi(2));
                let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
                for k in (0..n).filter(|&k| k != i && k != j) {
                    let (dx, dy) = (p(k).0 - mx, p(k).1 - my);
                    let side = nx * dx + ny * dy;
                    let bound = (dx * dx + dy * dy - half) / (2.0 * side);
                    if side > 0.0 { high = high.min(bound) } else { low = low.max(bound) }
                }
                if low < high {
                    edges.push((i as u32, j as u32));
                }
            }
        }
        edges
    }

    #[test]
    fn edges_equal_the_empty_circle_definition_on_random_points() {
        let mut rng = Rng::for_stage(5, "delaunay");
        for n in [2, 3, 4, 10, 40] {
            let points: Vec<_> = (0..n).map(|_| (rng.range(0.0, 100.0) as f32, rng.range(0.0, 80.0) as f32)).collect();
            assert_eq!(delaunay_edges(&points), naive_edges(&points), "{n} points");
        }
    }

    #[test]
    fn few_collinear_and_equal_points_keep_their_neighbours() {
        assert!(delaunay_edges(&[]).is_empty());
        assert!(delaunay_edges(&[(1.0, 2.0)]).is_empty());
        assert_eq!(delaunay_edges(&[(0.0, 0.0), (2.0, 2.0), (1.0, 1.0)]), [(0, 2), (1, 2)]);
        assert_eq!(delaunay_edges(&[(3.0, 3.0), (3.0, 3.0), (3.0, 3.0)]), [(0, 1), (0, 2)]);
        assert_eq!(delaunay_edges(&[(0.0, 5.0), (-0.0, 5.0), (1e-40, 9.0)]), [(0, 1), (0, 2)]);
    }

    #[test]
    fn triangles_have_the_edges_and_fill_the_hull() {
        let mut rng = Rng::for_stage(6, "delaunay");
        let mut points = vec![(0.0, 0.0), (50.0, 0.0), (50.0, 40.0), (0.0, 40.0), (50.0, 40.0)];
        points.extend((0..60).map(|_| (rng.range(1.0, 49.0) as f32, rng.range(1.0, 39.0) as f32)));
        let triangles = delaunay_triangles(&points);
        let corner = |i: u32| (f64::from(points[i as usize].0), f64::from(points[i as usize].1));
        let twice_area = |&[a, b, c]: &[u32; 3]| {
            let (a, b, c) = (corner(a), corner(b), corner(c));
            ((b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)).abs()
        };
        assert!((triangles.iter().map(twice_area).sum::<f64>() - 4000.0).abs() < 1e-6);
        let edges = delaunay_edges(&points);
        for [a, b, c] in triangles {
            for (i, j) in [(a, b), (b, c), (a, c)] {
                assert!(edges.contains(&(i.min(j), i.max(j))));
            }
        }
        assert!(delaunay_triangles(&[(0.0, 0.0), (1.0, 1.0), (2.0, 2.0)]).is_empty());
    }

    #[test]
    fn a_regular_grid_is_triangulated() {
        let points: Vec<_> = (0..100).map(|k| ((k % 10) as f32 * 8.0, (k / 10) as f32 * 8.0)).collect();
        assert_eq!(delaunay_edges(&points).len(), 2 * 90 + 81);
    }
}
