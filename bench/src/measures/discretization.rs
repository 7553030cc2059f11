//! How well a discretization's clusters are the objects of a shot: the two errors of the paper's Figure 10, and curves
//! of them.
//!
//! **In:** labelled trajectories, and the region map of each labelled frame. **Out:** [`Errors`] of one shot; for a
//! curve of averages over shots, its lower envelope and where it lies to another's ([`compare`]).
//!
//! The paper gives both errors in words; as computed here, on the trajectory points in the labelled frames:
//!
//! 1. A region (an object, or the background) is *missed* unless some cluster matches it, that is shares more than 70 %
//!    of the points that lie in either. A region in which no point lies is missed by every discretization.
//! 2. A cluster belongs to the region that holds most of its points, the first of equal ones, and is a *fragment* of it
//!    if it has at least some share of that region's points, [`FRAGMENT_SHARE`] where nothing else is asked for; less
//!    is taken for points that went astray at the object's outline. The *over-segmentation* of a shot is the number of
//!    fragments beyond the first of each region.
//!
//! A curve is swept by a threshold, and neither error need be monotonous in it. Curves are compared by their lower
//! envelopes: at a rate of misses the least over-segmentation that any threshold reaches without missing more.

use super::moseg::{overlap, visible_regions};
use serde::Serialize;
use tracecut::discretize::Clusters;
use tracecut::image::Plane;
use tracecut::trajectory::Trajectories;

/// A cluster matches a region whose intersection over union with it is above this (section 5).
const MATCHED_ABOVE: f64 = 0.7;
/// Least share of a region's points for a cluster to be a fragment of it, unless another is asked for.
pub const FRAGMENT_SHARE: f64 = 0.05;

/// The two errors, of one shot or on average.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Errors {
    /// Regions that no cluster matches.
    pub missed: f64,
    /// Fragments beyond the first of each region.
    pub oversegmentation: f64,
}

/// The errors of `clusters` on the labelled frames: each a frame number and its region map, of regions in
/// `0..num_regions`. Regions that no map shows do not count; clusters count as fragments from `fragment_share` of a
/// region's points on, of 0 all that have a point.
pub fn errors(
    labelled: &[(usize, &Plane<u8>)],
    num_regions: usize,
    tracks: &Trajectories,
    clusters: &Clusters,
    fragment_share: f64,
) -> Errors {
    let visible = visible_regions(num_regions, labelled.iter().map(|l| l.1));
    errors_of(&overlap(labelled, num_regions, tracks, clusters), &visible, fragment_share)
}

/// The same from `overlap[region][cluster]`, the number of points that both have.
fn errors_of(overlap: &[Vec<u64>], visible: &[bool], fragment_share: f64) -> Errors {
    let num_clusters = overlap.first().map_or(0, Vec::len);
    let region_size: Vec<u64> = overlap.iter().map(|row| row.iter().sum()).collect();
    let cluster_size: Vec<u64> = (0..num_clusters).map(|c| overlap.iter().map(|row| row[c]).sum()).collect();
    let matches = |r: usize, c: usize| {
        let either = region_size[r] + cluster_size[c] - overlap[r][c];
        overlap[r][c] as f64 > MATCHED_ABOVE * either as f64
    };
    let missed = (0..overlap.len()).filter(|&r| visible[r] && !(0..num_clusters).any(|c| matches(r, c))).count();
    let mut fragments = vec![0_u32; overlap.len()];
    for c in (0..num_clusters).filter(|&c| cluster_size[c] > 0) {
        let region = (0..overlap.len()).fold(0, |most, r| if overlap[r][c] > overlap[most][c] { r } else { most });
        let is_fragment = overlap[region][c] as f64 >= fragment_share * region_size[region] as f64;
        fragments[region] += u32::from(is_fragment);
    }
    let extra: u32 = fragments.iter().map(|f| f.saturating_sub(1)).sum();
    Errors { missed: missed as f64, oversegmentation: f64::from(extra) }
}

/// Mean over shots.
pub fn mean(shots: &[Errors]) -> Errors {
    let over = |value: fn(&Errors) -> f64| shots.iter().map(value).sum::<f64>() / shots.len().max(1) as f64;
    Errors { missed: over(|e| e.missed), oversegmentation: over(|e| e.oversegmentation) }
}

/// The lower envelope of a curve: from fewer misses to more, the points with less over-segmentation than all before.
pub fn envelope(curve: &[Errors]) -> Vec<Errors> {
    let mut sorted = curve.to_vec();
    sorted.sort_by(|a, b| a.missed.total_cmp(&b.missed).then(a.oversegmentation.total_cmp(&b.oversegmentation)));
    let mut least = f64::INFINITY;
    sorted.retain(|e| {
        let better = e.oversegmentation < least;
        least = least.min(e.oversegmentation);
        better
    });
    sorted
}

/// A comparison of the lower envelopes of two curves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Comparison {
    /// The smallest rate of misses that both reach.
    pub from: f64,
    /// Number of rates, among the steps of both envelopes, at which the curve lies below the other or has no
    /// over-segmentation.
    pub below: usize,
    /// Number of rates at which both are equal.
    pub equal: usize,
    /// Number of rates at which it lies above.
    pub above: usize,
    /// Smallest margin by which it lies below at these rates; negative if it lies above.
    pub margin: f64,
    /// Difference of the smallest rates of misses, this curve's less the other's.
    pub reach: f64,
}

impl Comparison {
    /// Returns true if the curve lies below at every rate that both reach.
    pub fn holds(&self) -> bool {
        self.above == 0 && self.equal == 0
    }
}

/// Compares `curve` with `other` at the steps of their envelopes, which are constant in between; `None` if either has no
/// points.
pub fn compare(curve: &[Errors], other: &[Errors]) -> Option<Comparison> {
    let (ours, theirs) = (envelope(curve), envelope(other));
    let (first, other_first) = (ours.first()?.missed, theirs.first()?.missed);
    let from = first.max(other_first);
    let at = |steps: &[Errors], rate: f64| {
        steps.iter().take_while(|e| e.missed <= rate).last().map_or(f64::INFINITY, |e| e.oversegmentation)
    };
    let mut result =
        Comparison { from, below: 0, equal: 0, above: 0, margin: f64::INFINITY, reach: first - other_first };
    for rate in [from].into_iter().chain(ours.iter().chain(&theirs).map(|e| e.missed).filter(|&m| m > from)) {
        let (our_count, their_count) = (at(&ours, rate), at(&theirs, rate));
        if our_count < their_count || our_count <= 0.0 {
            result.below += 1;
        } else if our_count > their_count {
            result.above += 1;
        } else {
            result.equal += 1;
        }
        result.margin = result.margin.min(their_count - our_count);
    }
    Some(result)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(rows: &[&[u64]]) -> (f64, f64) {
        let overlap: Vec<Vec<u64>> = rows.iter().map(|r| r.to_vec()).collect();
        let e = errors_of(&overlap, &vec![true; rows.len()], FRAGMENT_SHARE);
        (e.missed, e.oversegmentation)
    }

    #[test]
    fn a_cluster_for_each_region_makes_no_error() {
        assert_eq!(of(&[&[100, 0], &[0, 20]]), (0.0, 0.0));
        // 20 of 28 points: 71 %.
        assert_eq!(of(&[&[100, 8], &[0, 20]]), (0.0, 0.0));
        // 70 of 100 is not above 70 %.
        assert_eq!(of(&[&[900, 30], &[0, 70]]), (1.0, 0.0));
    }

    #[test]
    fn one_cluster_for_all_misses_the_smaller_region() {
        assert_eq!(of(&[&[100], &[20]]), (1.0, 0.0));
        assert_eq!(of(&[&[100], &[80]]), (2.0, 0.0));
    }

    #[test]
    fn fragments_are_counted_beyond_the_first_and_can_miss_their_region() {
        // Region 0 falls into 60, 30 and 10 points: two fragments too many, none of which is 70 % of it.
        assert_eq!(of(&[&[60, 30, 10, 0], &[0, 0, 0, 50]]), (1.0, 2.0));
        // 4 of 100 points are no fragment.
        assert_eq!(of(&[&[96, 4, 0], &[0, 0, 50]]), (0.0, 0.0));
        assert_eq!(of(&[&[95, 5, 0], &[0, 0, 50]]), (0.0, 1.0));
        // Of a share of 0 every cluster with a point is one.
        assert_eq!(errors_of(&[vec![97, 2, 1, 0]], &[true], 0.0).oversegmentation, 2.0);
    }

    #[test]
    fn a_cluster_belongs_to_the_region_of_most_of_its_points() {
        // The second cluster has all of region 1, but more of region 0: a fragment of that.
        assert_eq!(of(&[&[100, 40], &[0, 30]]), (1.0, 1.0));
    }

    #[test]
    fn regions_without_points_are_missed_and_those_not_shown_do_not_count() {
        assert_eq!(of(&[&[100], &[0]]), (1.0, 0.0));
        assert_eq!(errors_of(&[vec![100], vec![0]], &[true, false], 0.05).missed, 0.0);
        assert_eq!(of(&[&[], &[]]), (2.0, 0.0));
    }

    #[test]
    fn points_count_where_the_labelled_frames_see_them() {
        // Two frames of 4 x 1 pixels; in the second the object has moved on.
        let maps = [vec![0, 0, 1, 1], vec![0, 0, 0, 1]].map(|row| Plane::from_vec(4, 1, row).unwrap());
        let mut tracks = Trajectories::empty(3, (4, 1));
        for x in 0..4_i16 {
            tracks.push(0, (0..3).map(|_| (f32::from(x), 0.0, 0.0)));
        }
        let clusters = Clusters { count: 2, label: vec![0, 0, 1, 1] };
        let labelled = |t: usize| [(0, &maps[0]), (t, &maps[1])];
        assert_eq!(errors(&labelled(0)[..1], 2, &tracks, &clusters, 0.05), Errors::default());
        // Region 0 has 5 points, 4 of them in cluster 0; region 1 has 3, all in cluster 1, which has 4.
        assert_eq!(errors(&labelled(2), 2, &tracks, &clusters, 0.05), Errors::default());
        let one = Clusters { count: 1, label: vec![0; 4] };
        assert_eq!(errors(&labelled(2), 2, &tracks, &one, 0.05), Errors { missed: 2.0, oversegmentation: 0.0 });
    }

    fn curve(points: &[(f64, f64)]) -> Vec<Errors> {
        points.iter().map(|&(missed, oversegmentation)| Errors { missed, oversegmentation }).collect()
    }

    #[test]
    fn the_envelope_holds_what_no_other_point_beats() {
        let points = curve(&[(2.0, 0.0), (1.0, 0.5), (1.0, 0.4), (1.5, 0.6), (1.2, 0.4), (0.8, 3.0)]);
        assert_eq!(envelope(&points), curve(&[(0.8, 3.0), (1.0, 0.4), (2.0, 0.0)]));
        assert!(envelope(&[]).is_empty());
    }

    #[test]
    fn curves_are_compared_where_both_reach() {
        let ours = curve(&[(0.5, 1.0), (1.0, 0.25), (2.0, 0.0)]);
        let worse = compare(&ours, &curve(&[(1.0, 3.0), (1.5, 0.5), (2.0, 0.0)])).unwrap();
        assert_eq!((worse.from, worse.below, worse.equal, worse.above), (1.0, 4, 0, 0));
        assert_eq!((worse.margin, worse.reach), (0.0, -0.5));
        assert!(worse.holds());
        // Below at 1.0, equal from 1.25 on, above from 1.75 to 2.
        let crossing = compare(&ours, &curve(&[(1.0, 0.5), (1.25, 0.25), (1.75, 0.125)])).unwrap();
        assert_eq!((crossing.below, crossing.equal, crossing.above), (2, 1, 1));
        assert_eq!((crossing.margin, crossing.holds()), (-0.125, false));
        assert_eq!(compare(&ours, &[]), None);
    }
}
