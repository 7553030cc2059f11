//! Tests of the meaning of strokes.

use super::decision::Decision;
use super::*;
use crate::sparse::SymCsr;
use crate::trajectory::Trajectories;

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

/// Strokes over the first column of each of these blocks; `over` is what lies under each.
fn decide(
    columns: &[usize],
    labels: &[u8],
    strokes: &[usize],
    over: &[&[u8]],
    verb: fn(&StrokeInput) -> Result<Decision, crate::Error>,
) -> Result<Decision, crate::Error> {
    let (tracks, affinities) = blocks(columns);
    let label = of_blocks(labels);
    let mut under = vec![None; tracks.len()];
    for (k, &block) in (0..).zip(strokes) {
        (0..4).for_each(|row| under[16 * block + 4 * row] = Some(k));
    }
    let over: Vec<Vec<u8>> = over.iter().map(|o| o.to_vec()).collect();
    verb(&StrokeInput {
        tracks: &tracks,
        spacing: 8.0,
        affinities: &affinities,
        label: &label,
        used_labels: &distinct(labels),
        is_fixed: &vec![false; tracks.len()],
        stroke: &under,
        core_labels: &over,
    })
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
    let (tracks, affinities) = blocks(&[0, 200]);
    let label = of_blocks(&[0, 1]);
    let mut under = vec![None; 32];
    under[16] = Some(0);
    let over = [vec![1; 5], vec![1; 5]];
    let input = StrokeInput {
        tracks: &tracks,
        spacing: 8.0,
        affinities: &affinities,
        label: &label,
        used_labels: &[0, 1],
        is_fixed: &[false; 32],
        stroke: &under,
        core_labels: &over,
    };
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
    let (tracks, affinities) = blocks(&[0]);
    let input = StrokeInput {
        tracks: &tracks,
        spacing: 8.0,
        affinities: &affinities,
        label: &[0; 16],
        used_labels: &[0, 1],
        is_fixed: &[false; 16],
        stroke: &[Some(0); 16],
        core_labels: &[vec![1; 3]],
    };
    assert!(join_strokes(&input).unwrap_err().to_string().contains("no background would be left"));
    let none = StrokeInput { label: &[], stroke: &[], is_fixed: &[], tracks: &Trajectories::default(), ..input };
    assert_eq!(join_strokes(&none).unwrap(), Decision { label: vec![], stroke_labels: vec![1], affected: vec![1] });
}

#[test]
fn what_earlier_strokes_hold_stays() {
    let (tracks, affinities) = blocks(&[0, 200, 248]);
    let label = of_blocks(&[0, 1, 1]);
    let mut under = vec![None; 48];
    (under[16], under[47]) = (Some(0), Some(1));
    let mut is_fixed = vec![false; 48];
    is_fixed[46] = true;
    let over = [vec![1; 5], vec![1; 5]];
    let input = StrokeInput {
        tracks: &tracks,
        spacing: 8.0,
        affinities: &affinities,
        label: &label,
        used_labels: &[0, 1],
        is_fixed: &is_fixed,
        stroke: &under,
        core_labels: &over,
    };
    let decision = split_strokes(&input).unwrap();
    assert_eq!((decision.label[46], decision.label[47], decision.label[45]), (1, 2, 2));
}
