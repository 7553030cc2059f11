//! Laws and closed forms of the cut's energy, on superpixels made by hand.

use super::terms::ambiguous_shares;
use super::*;
use crate::superpixel::SuperpixelBorder;
use crate::trajectory::Trajectories;

const WIDTH: usize = 12;
const HEIGHT: usize = 4;

/// Three superpixels of 4 x 4 pixels side by side.
fn thirds() -> Superpixels {
    let border = |a, pb| SuperpixelBorder { a, b: a + 1, length: 4.0, pb };
    let mut thirds = Superpixels::from(&Plane::from_fn(WIDTH, HEIGHT, |x, _| (x / 4) as u32));
    thirds.borders = vec![border(0, 0.0), border(1, 0.06)];
    thirds
}

/// Each track stands still where it is, from its first frame to the last of `num_frames`.
fn standing(num_frames: usize, places: &[(usize, f32, f32)]) -> Trajectories {
    let mut tracks = Trajectories::empty(num_frames, (WIDTH, HEIGHT));
    for &(start, x, y) in places {
        tracks.push(start, (start..num_frames).map(|_| (x, y, 0.0)));
    }
    tracks
}

fn input<'a>(superpixels: &'a [Superpixels], tracks: &'a Trajectories, label: &'a [u32], n: usize) -> CutInput<'a> {
    CutInput { superpixels, tracks, label, num_labels: n, objects: &[], evidence: &[], appearance: &[] }
}

fn energy(input: &CutInput, params: &CutParams) -> Potts {
    super::energy(input, params, &Nodes::new(input))
}

fn units(cost: f64) -> i32 {
    (cost * 65536.0).round() as i32
}

/// The weight between two nodes; each pair must occur once at most.
fn weight(problem: &Potts, p: u32, q: u32) -> Option<i32> {
    let mut weights = problem.edges.iter().zip(&problem.weights).filter(|(e, _)| **e == (p, q)).map(|(_, &w)| w);
    let weight = weights.next();
    assert_eq!(weights.next(), None);
    weight
}

#[test]
fn unary_costs_are_one_minus_the_histogram_and_nothing_without_trajectories() {
    let superpixels = [thirds()];
    let tracks =
        standing(1, &[(0, 0.0, 0.0), (0, 1.0, 1.0), (0, 2.0, 2.0), (0, 3.0, 3.0), (0, 5.0, 0.0), (0, 6.0, 0.0)]);
    let label = [1, 1, 1, 0, UNKNOWN, 0];
    let params = CutParams { unary_weight: 2.0, ..CutParams::default() };
    let problem = energy(&input(&superpixels, &tracks, &label, 2), &params);
    assert_eq!(problem.unary, [units(1.5), units(0.5), 0, units(2.0), 0, 0]);
}

#[test]
fn borders_cost_less_where_contours_are_strong_and_more_where_they_are_long() {
    let mut s = thirds();
    let no_tracks = Trajectories::empty(1, (WIDTH, HEIGHT));
    let paper = CutParams { spatial_weight: 3.0, ..CutParams::paper() };
    let problem = energy(&input(std::slice::from_ref(&s), &no_tracks, &[], 2), &paper);
    assert_eq!(problem.edges, [(0, 1), (1, 2)]);
    assert_eq!(problem.weights, [units(3.0), units(3.0 * f64::exp(-2.0))]);
    s.borders[0].length = 12.0;
    let weight_by_length = CutParams { weight_by_length: true, ..paper };
    let problem = energy(&input(std::slice::from_ref(&s), &no_tracks, &[], 2), &weight_by_length);
    assert_eq!(problem.weights, [units(4.5), units(1.5 * f64::exp(-2.0))]);
}

/// The defaults with every term at weight 1, whatever they measure best with.
fn equal_weights() -> CutParams {
    CutParams { unary_weight: 1.0, spatial_weight: 1.0, temporal_weight: 1.0, ..CutParams::default() }
}

#[test]
fn temporal_weights_are_common_trajectories_by_the_larger_number() {
    let superpixels = [thirds(), thirds()];
    // In frame 0: two in superpixel 0. In frame 1: one of them still there, one in 1, and two new ones in 1.
    let mut tracks = Trajectories::empty(2, (WIDTH, HEIGHT));
    tracks.push(0, [(1.0, 1.0, 0.0), (1.0, 1.0, 0.0)]);
    tracks.push(0, [(3.4, 1.0, 0.0), (3.6, 1.0, 0.0)]);
    tracks.push(1, [(5.0, 1.0, 0.0)]);
    tracks.push(1, [(6.0, 1.0, 0.0)]);
    let problem = energy(&input(&superpixels, &tracks, &[UNKNOWN; 4], 2), &equal_weights());
    assert_eq!(weight(&problem, 0, 3), Some(units(0.5)));
    assert_eq!(weight(&problem, 0, 4), Some(units(1.0 / 3.0)));
    assert_eq!(problem.edges.len(), 6);
    assert!(problem.unary.iter().all(|&c| c == 0));
}

#[test]
fn points_outside_the_image_belong_to_the_nearest_pixel() {
    let superpixels = [thirds()];
    let tracks = standing(1, &[(0, -0.9, -0.9), (0, 11.9, 3.9), (0, 1e9, -1e9)]);
    let problem = energy(&input(&superpixels, &tracks, &[0, 0, 0], 2), &CutParams::default());
    assert_eq!(problem.unary, [0, units(1.0), 0, 0, 0, units(1.0)]);
}

#[test]
fn ambiguous_superpixels_lose_their_witnesses_softly_or_all_at_once() {
    let superpixels = [thirds()];
    // Label 0 left, label 1 right of it: the triangles between x = 2 and x = 6 are mixed.
    let tracks = standing(
        1,
        &[
            (0, 0.0, 0.0),
            (0, 2.0, 0.0),
            (0, 0.0, 3.0),
            (0, 2.0, 3.0),
            (0, 6.0, 0.0),
            (0, 6.0, 3.0),
            (0, 9.0, 0.0),
            (0, 9.0, 3.0),
        ],
    );
    let label = [0, 0, 0, 0, 1, 1, 1, 1];
    assert_eq!(ambiguous_shares(&superpixels[0], &tracks, &label, 0), [0.5, 0.75, 0.0]);
    let unary = |ambiguous_share| {
        let params = CutParams { ambiguous_share, ..CutParams::default() };
        energy(&input(&superpixels, &tracks, &label, 2), &params).unary
    };
    let one = units(1.0);
    assert_eq!(unary(1.0), [0, one, one, 0, one, 0]);
    assert_eq!(unary(0.6), [0, one, 0, 0, one, 0]);
    assert_eq!(unary(0.3), [0, 0, 0, 0, one, 0]);
}

#[test]
fn labels_spread_to_superpixels_without_trajectories_up_to_the_strongest_contour() {
    let mut s = thirds();
    s.borders[0].pb = 0.3;
    let superpixels = [s.clone(), thirds(), s];
    let tracks = standing(3, &[(0, 1.0, 1.0), (0, 10.0, 1.0)]);
    let cut = gabriel_cut(&input(&superpixels, &tracks, &[0, 1], 2), &CutParams::default());
    assert_eq!(cut.labels[0], [0, 1, 1]);
    assert_eq!(cut.labels[1], [0, 0, 1]);
    assert_eq!(cut.labels[2], [0, 1, 1]);
    let mask = paint(&superpixels[0], &cut.labels[0]);
    assert_eq!(mask.row(2), [0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1]);
}

#[test]
fn renaming_labels_renames_the_result() {
    let mut s = thirds();
    s.borders[0].length = 2.0;
    s.borders[1].pb = 0.1;
    let superpixels = [s.clone(), s];
    let tracks = standing(2, &[(0, 1.0, 1.0), (0, 1.0, 2.0), (0, 6.0, 1.0), (0, 9.0, 1.0), (1, 10.0, 1.0)]);
    let run = |label: &[u32]| gabriel_cut(&input(&superpixels, &tracks, label, 3), &equal_weights()).labels.concat();
    let plain = run(&[0, 0, 1, 2, 2]);
    assert!((0..3).all(|l| plain.contains(&l)));
    let renamed = run(&[2, 2, 0, 1, 1]);
    assert_eq!(renamed, plain.iter().map(|&l| (l + 2) % 3).collect::<Vec<_>>());
}

#[test]
fn without_trajectories_or_labels_everything_is_label_zero() {
    let superpixels = [thirds(), thirds()];
    let no_tracks = Trajectories::empty(2, (WIDTH, HEIGHT));
    for num_labels in [0, 1, 2, 5] {
        let cut = gabriel_cut(&input(&superpixels, &no_tracks, &[], num_labels), &CutParams::default());
        assert_eq!(cut.labels, [[0, 0, 0], [0, 0, 0]]);
    }
    assert!(gabriel_cut(&input(&[], &no_tracks, &[], 2), &CutParams::default()).labels.is_empty());
}

#[test]
fn one_superpixel_a_frame_takes_the_label_of_most() {
    let single = Superpixels::from(&Plane::filled(WIDTH, HEIGHT, 0));
    let tracks = standing(1, &[(0, 1.0, 1.0), (0, 5.0, 1.0), (0, 9.0, 1.0)]);
    let one = std::slice::from_ref(&single);
    for params in [CutParams::default(), CutParams::paper()] {
        assert_eq!(gabriel_cut(&input(one, &tracks, &[1, 2, 2], 3), &params).labels, [[2]]);
    }
    // Trajectories of more frames than there are superpixels, labels that do not exist.
    let longer = standing(5, &[(0, 1.0, 1.0), (2, 5.0, 1.0)]);
    assert_eq!(gabriel_cut(&input(one, &longer, &[1], 2), &CutParams::default()).labels, [[1]]);
    assert_eq!(gabriel_cut(&input(one, &longer, &[7, 7, 7], 2), &CutParams::default()).labels, [[0]]);
}

#[test]
fn steps_count_up_to_the_result_of_the_whole() {
    let superpixels = [thirds(), thirds()];
    let tracks = standing(2, &[(0, 1.0, 1.0), (0, 6.0, 1.0), (0, 9.0, 1.0)]);
    let input = input(&superpixels, &tracks, &[0, 1, 2], 3);
    let mut cut = GabrielCut::new(&input, &CutParams::default());
    let mut last = 0;
    loop {
        let more = cut.step();
        let (done, total) = cut.progress();
        assert!(done > last && done <= total && more == (done < total));
        last = done;
        if !more {
            break;
        }
    }
    assert_eq!(cut.finish(), gabriel_cut(&input, &CutParams::default()));
}

#[test]
fn strangers_count_for_every_object_and_not_for_the_background() {
    let superpixels = [thirds()];
    let tracks = standing(1, &[(0, 1.0, 1.0), (0, 2.0, 1.0), (0, 2.0, 2.0), (0, 5.0, 1.0)]);
    let label = [0, OUTLIER, OUTLIER, OUTLIER];
    let input = CutInput { objects: &[false, true, true], ..input(&superpixels, &tracks, &label, 3) };
    let params = CutParams { outlier_weight: 0.5, ..CutParams::default() };
    let half = units(0.5);
    assert_eq!(energy(&input, &params).unary, [half, half, half, half, 0, 0, 0, 0, 0]);
    let one = units(1.0);
    let without = CutParams { outlier_weight: 0.0, ..CutParams::default() };
    for (objects, params) in [(input.objects, &without), (&[], &params), (&[false; 3], &params)] {
        assert_eq!(energy(&CutInput { objects, ..input }, params).unary, [0, one, one, 0, 0, 0, 0, 0, 0]);
    }
}

#[test]
fn evidence_costs_the_labels_that_it_speaks_against() {
    let superpixels = [thirds()];
    let no_tracks = Trajectories::empty(1, (3, 1));
    let evidence = [0.5, -0.25, 0.0];
    let input =
        CutInput { objects: &[false, true, true], evidence: &evidence, ..input(&superpixels, &no_tracks, &[], 3) };
    let params = CutParams::default();
    let [half, quarter] = [0.5, 0.25].map(|cost: f32| (cost * 65536.0) as i32);
    assert_eq!(energy(&input, &params).unary, [half, 0, 0, 0, quarter, quarter, 0, 0, 0]);
}

#[test]
fn beside_appearance_trajectories_count_less() {
    let superpixels = [thirds()];
    let tracks = standing(1, &[(0, 0.0, 0.0)]);
    let appearance = [0.5, -1.0, 0.0];
    let input = CutInput { objects: &[false, true], appearance: &appearance, ..input(&superpixels, &tracks, &[1], 2) };
    let params = CutParams { appearance_weight: 2.0, appearance_unary_factor: 0.25, ..CutParams::default() };
    let problem = energy(&input, &params);
    assert_eq!(problem.unary, [units(0.25 + 1.0), 0, 0, units(2.0), 0, 0]);
}
