//! Corrections of a finished segmentation by the user, and the labels of trajectories that follow from them.
//!
//! In: the trajectories with their mask labels and affinities, and a [`Correction`]. Out: new mask labels of some
//! trajectories. The session then regroups the clusters and cuts the affected superpixels again; stages before the clusters
//! do not run again.
//!
//! 1. [`Correction::Merge`] renames. [`Correction::Split`] divides an object into its clusters, or if it has only one, along
//!    the least normalised cut of its own affinities (`bisect`).
//! 2. Strokes join or split the trajectories and pixels under them (`stroke`). The others follow by random walks over the
//!    affinities (`decision`, `random_walk`).
//! 3. Trajectories of labels that a correction does not affect keep them, and labels keep their meaning: a new object takes
//!    the lowest free number.
//!
//! Cuts and walks use one graph: the affinities of trajectories that also stay near each other or succeed each other
//! (`graph`). Motion alone did not separate what the user wants separated, so distance has to.
//!
//! **Why not embed again.** Constraints on affinities could go through embedding, discontinuities and clusters again. But a
//! stroke has a few dozen trajectories, whose affinities are few among a million others: the leading eigenvectors would
//! hardly change, or change anywhere. The walk is the one whose eigenvectors form the embedding (`P = D⁻¹ A`), with
//! absorption at the strokes: it takes a tenth of a second and changes only what the strokes cover and its surroundings.
//!
//! In the cut, superpixels of which a stroke covers a good part are fixed to its label, the mask trajectories there vote for
//! it, and in the mask the pixels under the core of the stroke have it (`recut` of `session`).
//!
//! Limits: a part of an object that neither moves differently nor lies apart, such as a rider on a horse, takes several
//! strokes in several frames. If trajectories are short, a stroke reaches only as far in time as they and their successors.

mod bisect;
mod decision;
mod graph;
mod stroke;

pub(crate) use bisect::{bisect, part_containing};
pub(crate) use decision::{NO_FREE_LABEL, StrokeInput, distinct, free_labels, join_strokes, split_strokes};
pub(crate) use graph::proximity_graph;
pub use stroke::Stroke;
pub(crate) use stroke::{core_pixels, strokes_over_tracks};

use crate::discretize::Clusters;
use crate::trajectory::Trajectories;

/// A correction of the masks. Labels are mask labels.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Correction {
    /// Merges the object `from` into `into`; 0 makes it background.
    Merge {
        /// The label that remains.
        into: u8,
        /// The label that is replaced.
        from: u8,
    },
    /// Splits an object in two. The part at the point gets a new label; without a point, the smaller part.
    Split {
        /// The object; 0, which needs a point, makes a part of the background an object.
        label: u8,
        /// Frame and position in input pixels.
        at: Option<(usize, f32, f32)>,
    },
    /// Joins everything under the strokes into one object.
    JoinStrokes(Vec<Stroke>),
    /// Makes each stroke an object of its own.
    SplitStrokes(Vec<Stroke>),
}

/// Pixels and trajectories whose label a stroke fixes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct StrokeConstraint {
    pub(crate) t: usize,
    /// Pixels at working size, row by row, increasing.
    pub(crate) pixels: Vec<u32>,
    /// Trajectories under the stroke.
    pub(crate) tracks: Vec<u32>,
    pub(crate) label: u8,
}

/// Clusters of one mask label each, and their relation to the clusters before.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct RegroupedClusters {
    pub(crate) clusters: Clusters,
    /// The mask label of each cluster.
    pub(crate) of_cluster: Vec<u8>,
    /// The new cluster that replaces each old one: the largest part with its label, or else its largest part.
    pub(crate) heir: Vec<u32>,
}

/// Splits the clusters whose trajectories now have different labels. `old_labels` has the old label of each cluster, `label`
/// the new label of each trajectory.
pub(crate) fn regroup(
    tracks: &Trajectories,
    clusters: &Clusters,
    old_labels: &[u8],
    label: &[u8],
) -> RegroupedClusters {
    let part = clusters.label.iter().zip(label).map(|(&c, &l)| c << 8 | u32::from(l)).collect();
    let regrouped = Clusters::from_labels(tracks, part);
    let mut of_cluster = vec![0; regrouped.count];
    // Whether the heir has another label, and its number: larger clusters have lower numbers.
    let mut heir = vec![(true, u32::MAX); clusters.count];
    for ((&new, &old), &l) in regrouped.label.iter().zip(&clusters.label).zip(label) {
        of_cluster[new as usize] = l;
        let best = &mut heir[old as usize];
        *best = (*best).min((old_labels.get(old as usize) != Some(&l), new));
    }
    RegroupedClusters { clusters: regrouped, of_cluster, heir: heir.into_iter().map(|h| h.1).collect() }
}

#[cfg(test)]
mod tests {
    use super::decision::Decision;
    use super::*;
    use crate::sparse::SymCsr;
    use crate::trajectory::Trajectories;

    #[test]
    fn clusters_split_by_label_and_leave_an_heir() {
        let mut tracks = Trajectories::empty(1, (9, 9));
        (0..9).for_each(|k| tracks.push(0, [(k as f32, 0.0, 0.0)]));
        let clusters = Clusters { count: 3, label: vec![0, 0, 0, 0, 1, 1, 1, 2, 2] };
        let regrouped = regroup(&tracks, &clusters, &[0, 1, 2], &[0, 0, 0, 0, 1, 4, 4, 5, 5]);
        assert_eq!(regrouped.clusters, Clusters { count: 4, label: vec![0, 0, 0, 0, 3, 1, 1, 2, 2] });
        assert_eq!((regrouped.of_cluster, regrouped.heir), (vec![0, 4, 5, 1], vec![0, 3, 2]));
        assert_eq!(regroup(&Trajectories::default(), &Clusters::default(), &[], &[]), RegroupedClusters::default());
    }

    /// Blocks of 4 by 4 still trajectories, 8 pixels apart from each other, from these columns on.
    fn blocks(columns: &[usize]) -> (Trajectories, SymCsr) {
        let mut tracks = Trajectories::empty(5, (400, 40));
        for &column in columns {
            for k in 0..16 {
                let (x, y) = ((column + 8 * (k % 4)) as f32, (4 + 8 * (k / 4)) as f32);
                tracks.push(0, (0..5).map(|_| (x, y, 0.0)));
            }
        }
        let n = tracks.len() as u32;
        let all: Vec<_> = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j, 1.0))).collect();
        let affinities = SymCsr::from_upper(n as usize, &all);
        (tracks, affinities)
    }

    /// The labels of blocks of 16.
    fn of_blocks(labels: &[u8]) -> Vec<u8> {
        labels.iter().flat_map(|&l| [l; 16]).collect()
    }

    /// Strokes on these trajectories and what lies under each, where labels 0 and 1 are used.
    fn input<'a>(
        (tracks, affinities): &'a (Trajectories, SymCsr),
        label: &'a [u8],
        stroke: &'a [Option<u8>],
        is_fixed: &'a [bool],
        core_labels: &'a [Vec<u8>],
    ) -> StrokeInput<'a> {
        let used_labels = &[0, 1];
        StrokeInput { tracks, spacing: 8.0, affinities, label, used_labels, is_fixed, stroke, core_labels }
    }

    /// Strokes over the first column of each of these blocks; `over` is what lies under each.
    fn decide(
        columns: &[usize],
        labels: &[u8],
        strokes: &[usize],
        over: &[&[u8]],
        verb: fn(&StrokeInput) -> Result<Decision, crate::Error>,
    ) -> Result<Decision, crate::Error> {
        let (blocks, label) = (blocks(columns), of_blocks(labels));
        let mut under = vec![None; label.len()];
        for (k, &block) in (0..).zip(strokes) {
            (0..4).for_each(|row| under[16 * block + 4 * row] = Some(k));
        }
        let over: Vec<Vec<u8>> = over.iter().map(|o| o.to_vec()).collect();
        let is_fixed = vec![false; label.len()];
        verb(&StrokeInput { used_labels: &distinct(labels), ..input(&blocks, &label, &under, &is_fixed, &over) })
    }

    #[test]
    fn strokes_over_one_object_divide_it_and_the_larger_part_keeps_the_label() {
        // Two figures that move alike, 24 pixels apart; the one on the right has two blocks.
        let columns = [0, 200, 248, 280];
        let decision = decide(&columns, &[0, 1, 1, 1], &[1, 2], &[&[1; 9], &[1; 9]], split_strokes).unwrap();
        assert_eq!(decision.label, of_blocks(&[0, 2, 1, 1]));
        assert_eq!((decision.stroke_labels, decision.affected), (vec![2, 1], vec![1, 2]));
    }

    #[test]
    fn a_stroke_that_also_lies_over_background_takes_out_of_an_object_what_is_bound_to_it() {
        let columns = [0, 200, 300];
        let decision = decide(&columns, &[0, 1, 1], &[1, 2], &[&[1; 9], &[1, 1, 1, 0]], split_strokes).unwrap();
        assert_eq!(decision.stroke_labels, [1, 0]);
        assert_eq!(decision.label[16..32], [1; 16]);
        assert!((0..4).all(|row| decision.label[32 + 4 * row] == 0), "what is under the stroke");
        assert_eq!(decision.affected, [0, 1]);
    }

    #[test]
    fn a_stroke_over_no_trajectory_is_background_and_makes_no_object() {
        let (blocks, label) = (blocks(&[0, 200]), of_blocks(&[0, 1]));
        let mut under = vec![None; 32];
        under[16] = Some(0);
        let over = [vec![1; 5], vec![1; 5]];
        let input = input(&blocks, &label, &under, &[false; 32], &over);
        let decision = split_strokes(&input).unwrap();
        assert_eq!((decision.stroke_labels, decision.label), (vec![1, 0], label.clone()));
        let nowhere = StrokeInput { core_labels: &[vec![0; 5], vec![0; 5]], ..input };
        assert!(split_strokes(&nowhere).unwrap_err().to_string().contains("stroke 1 lies over no trajectory"));
        // Where no cluster is background, masks cannot have any either (found by the fuzzer).
        let all_objects = StrokeInput { used_labels: &[1, 2], ..input };
        assert!(split_strokes(&all_objects).unwrap_err().to_string().contains("stroke 1 lies over no trajectory"));
    }

    #[test]
    fn strokes_over_different_labels_have_them_already() {
        let decision = decide(&[0, 200], &[0, 3], &[0, 1], &[&[0; 4], &[3; 4]], split_strokes).unwrap();
        assert_eq!((decision.label, decision.stroke_labels), (of_blocks(&[0, 3]), vec![0, 3]));
    }

    #[test]
    fn of_the_background_a_new_object_takes_only_what_is_bound_to_its_stroke() {
        let columns = [0, 40, 80, 120, 300];
        let decision = decide(&columns, &[0; 5], &[4, 1], &[&[0; 9], &[0; 9]], split_strokes).unwrap();
        assert_eq!(decision.stroke_labels, [1, 0]);
        assert_eq!(decision.label[..64], [0; 64]);
        assert!((0..4).all(|row| decision.label[64 + 4 * row] == 1));
    }

    #[test]
    fn joining_joins_objects_to_the_lowest_and_background_under_the_stroke() {
        let columns = [0, 100, 200, 300];
        let decision = decide(&columns, &[0, 5, 2, 7], &[1, 2], &[&[5; 9], &[2, 2, 5]], join_strokes).unwrap();
        assert_eq!((decision.label, decision.affected), (of_blocks(&[0, 2, 2, 7]), vec![2, 5]));
        let decision = decide(&columns, &[0, 5, 2, 7], &[1, 0], &[&[5; 9], &[0; 9]], join_strokes).unwrap();
        assert_eq!(decision.stroke_labels, [5, 5]);
        assert!(
            (0..4).all(|row| decision.label[4 * row] == 5 && decision.label[4 * row + 3] == 0),
            "{:?}",
            &decision.label[..16]
        );
        assert_eq!(decision.label[16..], of_blocks(&[5, 2, 7]));
        // A corner of an object is enough where there is no more of any.
        let decision = decide(&columns, &[0, 5, 2, 7], &[0], &[&[0, 0, 0, 0, 0, 0, 0, 0, 7]], join_strokes).unwrap();
        assert_eq!(decision.stroke_labels, [7]);
    }

    #[test]
    fn joining_needs_an_object_and_leaves_some_background() {
        let nothing = decide(&[0, 100], &[0, 1], &[0], &[&[0; 9]], join_strokes).unwrap_err();
        assert!(nothing.to_string().contains("over no object"), "{nothing}");
        let (blocks, over) = (blocks(&[0]), [vec![1; 3]]);
        let input = input(&blocks, &[0; 16], &[Some(0); 16], &[false; 16], &over);
        assert!(join_strokes(&input).unwrap_err().to_string().contains("no background would be left"));
        let none = StrokeInput { label: &[], stroke: &[], is_fixed: &[], tracks: &Trajectories::default(), ..input };
        assert_eq!(join_strokes(&none).unwrap(), Decision { label: vec![], stroke_labels: vec![1], affected: vec![1] });
    }

    #[test]
    fn what_earlier_strokes_hold_stays() {
        let (blocks, label) = (blocks(&[0, 200, 248]), of_blocks(&[0, 1, 1]));
        let mut under = vec![None; 48];
        (under[16], under[47]) = (Some(0), Some(1));
        let mut is_fixed = vec![false; 48];
        is_fixed[46] = true;
        let over = [vec![1; 5], vec![1; 5]];
        let input = input(&blocks, &label, &under, &is_fixed, &over);
        let decision = split_strokes(&input).unwrap();
        assert_eq!((decision.label[46], decision.label[47], decision.label[45]), (1, 2, 2));
    }
}
