//! Delaunay triangulations of points in the plane, with and without lines that must be kept; the only file that names
//! `spade`.

use crate::order;
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation as _};

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

/// One type for both uses, so that the wasm file holds spade's generic code once.
type Spade = ConstrainedDelaunayTriangulation<Site>;

/// A triangulation of the convex hull of some points.
///
/// Invariants: every edge has a triangle on one side at least, every triangle has three edges in `edges`; edges are sorted by
/// `ends`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Triangulation {
    /// Indices of each triangle's corners, anticlockwise where y points up.
    pub triangles: Vec<[u32; 3]>,
    /// Each edge once.
    pub edges: Vec<TriangulationEdge>,
}

/// An edge of a [`Triangulation`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TriangulationEdge {
    /// Indices of its ends, the smaller one first.
    pub ends: [u32; 2],
    /// The triangles beside it; one only on the hull.
    pub triangles: [Option<u32>; 2],
    /// True for a given line or a piece of one.
    pub is_constraint: bool,
}

/// Computes the Delaunay edges of `points`, each `(i, j)` with `i < j`, sorted.
///
/// Points on a line are joined in their order; a point at the very place of an earlier one is joined to that one only,
/// so that no point is left without a neighbour. Coordinates must be finite. O(n log n).
pub(crate) fn delaunay_edges(points: &[(f32, f32)]) -> Vec<(u32, u32)> {
    let (sites, mut edges) = distinct_sites(points);
    if let Ok(triangulation) = Spade::bulk_load(sites) {
        for edge in triangulation.undirected_edges() {
            let [a, b] = edge.vertices().map(|v| v.data().index);
            edges.push((a.min(b), a.max(b)));
        }
    }
    order::sort_by_key(&mut edges, |&(a, b)| order::pair_key(a, b));
    edges
}

/// Computes the constrained Delaunay triangulation of `points` that contains the `lines` between them (Chew,
/// "Constrained Delaunay Triangulations", 1989).
///
/// Of points at the same place the first stands for all; a line through further points is kept in pieces; a line that
/// crosses an earlier one is left out. Coordinates must be finite and indices in range; points on one line only give no
/// triangle and no edge.
pub(crate) fn constrained_delaunay(points: &[(f32, f32)], lines: &[(u32, u32)]) -> Triangulation {
    let (sites, duplicates) = distinct_sites(points);
    let mut representative: Vec<u32> = (0..points.len() as u32).collect();
    for (first, duplicate) in duplicates {
        representative[duplicate as usize] = representative[first as usize];
    }
    let Ok(mut spade) = Spade::bulk_load(sites) else {
        return Triangulation::default();
    };
    let mut handles = vec![FixedVertexHandle::from_index(0); points.len()];
    for vertex in spade.vertices() {
        handles[vertex.data().index as usize] = vertex.fix();
    }
    for &(a, b) in lines {
        let [a, b] = [a, b].map(|i| handles[representative[i as usize] as usize]);
        if a != b {
            spade.try_add_constraint(a, b);
        }
    }
    to_triangulation(&spade)
}

/// Converts spade's triangulation to indices.
fn to_triangulation(spade: &Spade) -> Triangulation {
    let triangles = spade.inner_faces().map(|face| face.vertices().map(|v| v.data().index)).collect();
    let mut edges = Vec::with_capacity(spade.num_undirected_edges());
    for edge in spade.undirected_edges() {
        let directed = edge.as_directed();
        let [a, b] = edge.vertices().map(|v| v.data().index);
        // The outer face has index 0.
        let sides = [directed.face(), directed.rev().face()].map(|f| (f.fix().index() as u32).checked_sub(1));
        if sides != [None, None] {
            edges.push(TriangulationEdge {
                ends: [a.min(b), a.max(b)],
                triangles: sides,
                is_constraint: edge.is_constraint_edge(),
            });
        }
    }
    order::sort_by_key(&mut edges, |edge| order::pair_key(edge.ends[0], edge.ends[1]));
    Triangulation { triangles, edges }
}

/// Returns one site for each place, sorted by x, then y, and pairs of points at the same place: the site's point and
/// its duplicate.
fn distinct_sites(points: &[(f32, f32)]) -> (Vec<Site>, Vec<(u32, u32)>) {
    let mut ordered: Vec<Site> = (0..)
        .zip(points)
        .map(|(index, &(x, y))| Site { position: Point2::new(flush_to_zero(x), flush_to_zero(y)), index })
        .collect();
    // Coordinates were given as `f32`, so that two of them fit into a key.
    let key = |v: f64| order::f32_key(v as f32);
    order::sort_by_key(&mut ordered, |site| order::pair_key(key(site.position.x), key(site.position.y)));
    let mut duplicates = Vec::with_capacity(3 * points.len());
    let mut sites: Vec<Site> = Vec::with_capacity(points.len());
    for site in ordered {
        match sites.last() {
            Some(last) if last.position == site.position => duplicates.push((last.index, site.index)),
            _ => sites.push(site),
        }
    }
    (sites, duplicates)
}

/// Smallest coordinate that is not rounded to zero. Spade's predicates refuse magnitudes below 2^-142 (2e-43).
const MIN_COORDINATE_PX: f32 = 1e-30;

/// Rounds coordinates that are too small for spade to zero.
fn flush_to_zero(coordinate: f32) -> f64 {
    if coordinate.abs() < MIN_COORDINATE_PX { 0.0 } else { f64::from(coordinate) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    /// Finds every edge that some circle through its ends shows to be Delaunay, by trying all third points: O(n³).
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
    fn given_lines_are_kept_and_crossing_ones_are_not() {
        let points = [(0.0, 0.0), (10.0, 0.0), (10.0, 1.0), (0.0, 1.0), (5.0, 0.5), (0.0, 0.0)];
        let constraints = |lines: &[(u32, u32)]| -> Vec<[u32; 2]> {
            let edges = constrained_delaunay(&points, lines).edges;
            edges.iter().filter(|e| e.is_constraint).map(|e| e.ends).collect()
        };
        // A line through a point is kept in two pieces, one from a second point at the same place begins in the first.
        assert_eq!(constraints(&[(5, 2)]), [[0, 4], [2, 4]]);
        assert_eq!(constraints(&[(5, 0), (3, 3)]), [[0; 2]; 0]);
        // They meet in the point in the middle; without it the second crosses the first.
        assert_eq!(constraints(&[(0, 2), (1, 3)]), [[0, 4], [1, 4], [2, 4], [3, 4]]);
        let edges = constrained_delaunay(&points[..4], &[(0, 2), (1, 3)]).edges;
        assert!(edges.iter().any(|e| e.ends == [0, 2] && e.is_constraint) && edges.iter().all(|e| e.ends != [1, 3]));
    }

    #[test]
    fn no_triangle_comes_of_points_on_one_line() {
        for n in 0..5 {
            let points: Vec<_> = (0..n).map(|i| (i as f32, 2.0 * i as f32)).collect();
            let lines: Vec<_> = (1..n).map(|i| (0, i)).collect();
            assert_eq!(constrained_delaunay(&points, &lines), Triangulation::default(), "{n} points");
        }
    }

    #[test]
    fn a_regular_grid_is_triangulated() {
        let points: Vec<_> = (0..100).map(|k| ((k % 10) as f32 * 8.0, (k / 10) as f32 * 8.0)).collect();
        assert_eq!(delaunay_edges(&points).len(), 2 * 90 + 81);
    }
}
