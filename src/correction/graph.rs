//! Affinities as far as trajectories stay near each other.

use crate::sparse::SymCsr;
use crate::trajectory::Trajectories;

/// Distance at which an affinity counts `1/e` of itself, in distances of neighbours. Gaps between two things that move alike are a few
/// of these wide; much less, and holes within one thing would part it.
const REACH: f32 = 2.5;

/// Affinities that count less than this are left out.
const NEGLIGIBLE: f32 = 1e-4;

/// The graph of `members` (increasing): `A_ij exp(−(r_ij / reach)²)`, where `r` is the largest distance of both in the first, the middle
/// and the last of their common frames. Row `k` is `members[k]`. `spacing` is the distance of neighbours in pixels.
///
/// An affinity above 1 stands for many far pairs that were not compared; such pairs are too far apart to count here.
pub fn near_affinities(affinities: &SymCsr, tracks: &Trajectories, members: &[u32], spacing: f32) -> SymCsr {
    let mut place = vec![u32::MAX; tracks.len().max(affinities.len())];
    for (k, &i) in (0..).zip(members) {
        place[i as usize] = k;
    }
    let reach_sq = (REACH * spacing).powi(2);
    let mut upper = Vec::new();
    for (k, &i) in (0..).zip(members) {
        for (j, w) in affinities.row(i as usize) {
            let other = place[j];
            if other == u32::MAX || other <= k {
                continue;
            }
            if let Some(apart_sq) = largest_distance_sq(tracks, i as usize, j) {
                let weight = w.min(1.0) as f32 * libm::expf(-apart_sq / reach_sq);
                if weight >= NEGLIGIBLE {
                    upper.push((k, other, weight));
                }
            }
        }
    }
    SymCsr::from_upper(members.len(), &upper)
}

/// `None` without a common frame.
fn largest_distance_sq(tracks: &Trajectories, i: usize, j: usize) -> Option<f32> {
    let (a, b) = (tracks.frames(i), tracks.frames(j));
    let (start, end) = (a.start.max(b.start), a.end.min(b.end));
    let last = end.checked_sub(1).filter(|&last| last >= start)?;
    let apart_sq = |t: usize| {
        let ((ax, ay), (bx, by)) = (tracks.at(i, t)?, tracks.at(j, t)?);
        Some((ax - bx).powi(2) + (ay - by).powi(2))
    };
    Some(apart_sq(start)?.max(apart_sq((start + last) / 2)?).max(apart_sq(last)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_near_in_all_common_frames_counts_and_what_parts_does_not() {
        let mut tracks = Trajectories::empty(5, (200, 100));
        for (x, u) in [(10.0, 0.0), (18.0, 0.0), (26.0, 30.0), (150.0, 0.0)] {
            tracks.push(0, (0..5).map(|t| (x + u * t as f32, 20.0, 0.0)));
        }
        tracks.push(4, [(10.0, 20.0, 0.0)]);
        let all = [(0, 1, 0.9), (0, 2, 0.9), (0, 3, 32.0), (0, 4, 0.5), (1, 2, 0.9)];
        let graph = near_affinities(&SymCsr::from_upper(5, &all), &tracks, &[0, 1, 2, 3, 4], 8.0);
        let expected = 0.9 * (-(8.0_f64 / 20.0).powi(2)).exp();
        let row: Vec<_> = graph.row(0).collect();
        assert_eq!(row.iter().map(|e| e.0).collect::<Vec<_>>(), [1, 4]);
        assert!((row[0].1 - expected).abs() < 1e-6 && (row[1].1 - 0.5).abs() < 1e-6, "{row:?}");
        let some = near_affinities(&SymCsr::from_upper(5, &all), &tracks, &[1, 4], 8.0);
        assert_eq!((some.len(), some.num_entries()), (2, 0));
        assert!(near_affinities(&SymCsr::default(), &Trajectories::default(), &[], 8.0).is_empty());
    }
}
