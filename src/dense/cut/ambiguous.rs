//! Ambiguous places (section 4.2): triangles between trajectories of different labels.
//!
//! Trajectories near the rim of an object may be dragged along by it, or drag; where labels change from one trajectory
//! to its neighbours, a superpixel's own trajectories are no sure witnesses.

use super::input::UNKNOWN;
use crate::delaunay::constrained_delaunay;
use crate::superpixel::Superpixels;
use crate::trajectory::Trajectories;

/// The share of each superpixel of frame `t` that ambiguous Delaunay triangles cover, 0 to 1.
///
/// Triangulated are the points of the trajectories alive in that frame whose label is known; a triangle is ambiguous if
/// not all three labels are the same. A pixel belongs to a triangle if its centre lies inside or on the triangle's rim.
pub(crate) fn ambiguous_shares(superpixels: &Superpixels, tracks: &Trajectories, label: &[u32], t: usize) -> Vec<f32> {
    let mut points = Vec::new();
    let mut labels = Vec::new();
    for (i, x, y) in tracks.alive(t) {
        if let Some(&l) = label.get(i).filter(|&&l| l != UNKNOWN) {
            points.push((x, y));
            labels.push(l);
        }
    }
    let (width, height) = superpixels.runs().size();
    let mut covered = vec![false; width * height];
    for [a, b, c] in constrained_delaunay(&points, &[]).triangles {
        let of = |corner: u32| labels[corner as usize];
        if of(a) != of(b) || of(a) != of(c) {
            let corners = [a, b, c].map(|corner| points[corner as usize]);
            fill(corners, width, &mut covered);
        }
    }
    let mut counts = vec![0_u32; superpixels.count];
    for (&p, _) in superpixels.label().data().iter().zip(&covered).filter(|(_, covered)| **covered) {
        counts[p as usize] += 1;
    }
    counts.iter().zip(superpixels.areas()).map(|(&count, area)| count as f32 / area.max(1) as f32).collect()
}

/// Marks the pixels whose centres lie in the triangle, row by row.
fn fill(corners: [(f32, f32); 3], width: usize, covered: &mut [bool]) {
    let corners = corners.map(|(x, y)| (f64::from(x), f64::from(y)));
    let height = covered.len() / width.max(1);
    let top = corners.iter().fold(f64::INFINITY, |m, c| m.min(c.1)).ceil().max(0.0) as usize;
    let bottom = corners.iter().fold(f64::NEG_INFINITY, |m, c| m.max(c.1)).floor();
    if bottom < 0.0 {
        return;
    }
    for y in top..(bottom as usize + 1).min(height) {
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..3 {
            let (mut from, mut to) = (corners[k], corners[(k + 1) % 3]);
            if from.1 > to.1 {
                (from, to) = (to, from);
            }
            let row = y as f64;
            if from.1 > row || to.1 < row {
                continue;
            }
            let ends = match to.1 > from.1 {
                true => [from.0 + (to.0 - from.0) * ((row - from.1) / (to.1 - from.1)); 2],
                false => [from.0, to.0],
            };
            for x in ends {
                left = left.min(x);
                right = right.max(x);
            }
        }
        if right >= 0.0 && left <= right {
            let begin = left.ceil().max(0.0) as usize;
            let end = (right.floor() as usize + 1).min(width);
            if begin < end {
                covered[y * width + begin..y * width + end].fill(true);
            }
        }
    }
}
