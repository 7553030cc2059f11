//! Laws of components, agents and constraints.

use super::*;
use crate::discontinuity::neighborhoods;

/// Trajectories on a line ten pixels separated, alive in all of `frames`; `away` moves those from index 4 on by that much
/// in some frames.
fn row(n: usize, frames: usize, away: impl Fn(usize) -> f32) -> Trajectories {
    let mut tracks = Trajectories::empty(frames, (400, 100));
    for k in 0..n {
        let shift = |t| if k >= 4 { away(t) } else { 0.0 };
        // Two rows, so that the Delaunay graph is no chain.
        tracks.push(0, (0..frames).map(|t| ((k / 2) as f32 * 10.0 + shift(t), (k % 2) as f32 * 10.0, 0.0)));
    }
    tracks
}

fn components_of(tracks: &Trajectories, foreground: &[bool], min_size: usize) -> Components {
    components(tracks, &neighborhoods(tracks), foreground, 30.0, min_size)
}

fn complete(n: u32) -> SymCsr {
    let pairs: Vec<_> = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j, 1.0))).collect();
    SymCsr::from_upper(n as usize, &pairs)
}

fn settings(mode: ConnectednessMode, min_violations: u32) -> ConnectednessParams {
    ConnectednessParams { mode, min_violations, ..ConnectednessParams::default() }
}

fn constrained(
    affinities: &SymCsr,
    tracks: &Trajectories,
    parts: &Components,
    foreground: &[bool],
    params: &ConnectednessParams,
) -> Option<(SymCsr, usize)> {
    constrain(affinities, tracks, &Separation::new(tracks, parts, params), foreground, params)
}

#[test]
fn a_gap_longer_than_an_edge_may_be_makes_two_components() {
    let tracks = row(8, 3, |t| if t == 1 { 60.0 } else { 0.0 });
    let components = components_of(&tracks, &[true; 8], 1);
    assert_eq!(components.count, [1, 2, 1]);
    let at = |t: usize| (0..8).map(|i| components.of_point[3 * i + t]).collect::<Vec<_>>();
    assert_eq!((at(0), at(1)), (vec![Some(0); 8], [0, 0, 0, 0, 1, 1, 1, 1].map(Some).to_vec()));
}

#[test]
fn background_between_two_agents_keeps_them_apart() {
    let tracks = row(12, 2, |_| 0.0);
    let foreground: Vec<bool> = (0..12).map(|i| !(4..8).contains(&i)).collect();
    let components = components_of(&tracks, &foreground, 1);
    assert_eq!(components.count, [2, 2]);
    assert_eq!((components.of_point[0], components.of_point[8], components.of_point[16]), (Some(0), None, Some(1)));
}

#[test]
fn pieces_that_are_too_small_are_none() {
    let tracks = row(10, 2, |_| 90.0);
    assert_eq!(components_of(&tracks, &[true; 10], 5).count, [1, 1]);
    assert_eq!(components_of(&tracks, &[true; 10], 7).count, [0, 0]);
}

#[test]
fn components_do_not_depend_on_the_frames_before() {
    let tracks = row(8, 4, |t| 30.0 * t as f32);
    let of_clip = components_of(&tracks, &[true; 8], 1);
    for t in 0..4 {
        let mut frame = Trajectories::empty(1, tracks.size);
        (0..8).for_each(|i| frame.push(0, tracks.at(i, t).map(|(x, y)| (x, y, 0.0))));
        let of_frame = components_of(&frame, &[true; 8], 1);
        assert_eq!(of_frame.count[0], of_clip.count[t]);
        assert!((0..8).all(|i| of_frame.of_point[i] == of_clip.of_point[4 * i + t]));
    }
}

#[test]
fn only_pairs_across_components_lose_their_affinity() {
    let tracks = row(8, 3, |t| if t > 0 { 60.0 } else { 0.0 });
    let (foreground, all) = ([true; 8], complete(8));
    let parts = components_of(&tracks, &foreground, 1);
    let (affinities, num_removed) =
        constrained(&all, &tracks, &parts, &foreground, &settings(ConnectednessMode::Paper, 2)).unwrap();
    affinities.check().unwrap();
    assert_eq!(num_removed, 16);
    for i in 0..8 {
        let neighbours: Vec<usize> = affinities.row(i).map(|(j, _)| j).collect();
        assert_eq!(neighbours, (0..8).filter(|&j| j != i && (j < 4) == (i < 4)).collect::<Vec<_>>());
    }
    assert!(constrained(&all, &tracks, &parts, &foreground, &settings(ConnectednessMode::Off, 1)).is_none());
}

#[test]
fn a_hole_of_a_single_frame_is_forgiven_unless_the_paper_is_followed() {
    let tracks = row(8, 9, |t| if t == 4 { 60.0 } else { 0.0 });
    let (foreground, all) = ([true; 8], complete(8));
    let parts = components_of(&tracks, &foreground, 1);
    let outcome = |m| constrained(&all, &tracks, &parts, &foreground, &settings(ConnectednessMode::Paper, m));
    assert_eq!(outcome(2), None);
    assert_eq!(outcome(1).unwrap().1, 16);
}

#[test]
fn only_foreground_only_removes_affinities_of_the_background() {
    let tracks = row(8, 3, |_| 0.0);
    let foreground: Vec<bool> = (0..8).map(|i| i < 4).collect();
    let (parts, all) = (components_of(&tracks, &foreground, 1), complete(8));
    assert!(constrained(&all, &tracks, &parts, &foreground, &settings(ConnectednessMode::Paper, 1)).is_none());
    let params = settings(ConnectednessMode::ForegroundOnly, 1);
    let (affinities, _) = constrained(&all, &tracks, &parts, &foreground, &params).unwrap();
    assert_eq!(affinities.column.len(), 12);
}

#[test]
fn no_trajectories_have_no_components() {
    let empty = Trajectories::empty(3, (8, 8));
    assert_eq!(components_of(&empty, &[], 1), Components { count: vec![0; 3], of_point: vec![] });
}

/// Two rows of four trajectories that lie separated at first, touch from frame 4 on and part again in frame 8; trajectories
/// 8 and 9 live only while they touch, beside one row each.
fn touching() -> Trajectories {
    let mut tracks = Trajectories::empty(12, (400, 100));
    let shift = |k: usize, t: usize| if k >= 4 && !(4..8).contains(&t) { 70.0 } else { 0.0 };
    for k in 0..8 {
        tracks.push(0, (0..12).map(|t| ((k / 2) as f32 * 10.0 + shift(k, t), (k % 2) as f32 * 10.0, 0.0)));
    }
    tracks.push(4, (0..4).map(|_| (-9.0, 5.0, 0.0)));
    tracks.push(4, (0..4).map(|_| (39.0, 5.0, 0.0)));
    tracks
}

#[test]
fn trajectories_that_live_only_while_agents_touch_belong_to_the_nearer_one() {
    let tracks = touching();
    let parts = components_of(&tracks, &[true; 10], 1);
    assert_eq!(parts.count, [2, 2, 2, 2, 1, 1, 1, 1, 2, 2, 2, 2]);
    let separated = |mode, i, j| {
        let params = ConnectednessParams { min_component: 2, ..settings(mode, 2) };
        Separation::new(&tracks, &parts, &params).separates(&tracks, i, j)
    };
    for (k, own, other) in [(8, 0..4, 4..8), (9, 4..8, 0..4)] {
        assert!(own.clone().all(|i| !separated(ConnectednessMode::Agents, k, i)));
        assert!(other.clone().all(|i| separated(ConnectednessMode::Agents, k, i)));
        assert!(other.clone().all(|i| !separated(ConnectednessMode::Paper, k, i)));
        assert!(own.zip(other).all(|(i, j)| separated(ConnectednessMode::Paper, i, j)));
    }
    assert!(!separated(ConnectednessMode::Off, 0, 7));
}

#[test]
fn agents_that_only_part_at_the_end_are_told_apart_from_there_backward() {
    let mut tracks = Trajectories::empty(10, (400, 100));
    for k in 0..8 {
        let away = |t: usize| if k >= 4 && t >= 6 { 70.0 } else { 0.0 };
        tracks.push(0, (0..10).map(|t| ((k / 2) as f32 * 10.0 + away(t), (k % 2) as f32 * 10.0, 0.0)));
    }
    tracks.push(0, (0..5).map(|_| (-9.0, 5.0, 0.0)));
    let parts = components_of(&tracks, &[true; 9], 1);
    let params = ConnectednessParams { min_component: 2, ..settings(ConnectednessMode::Agents, 2) };
    let separation = Separation::new(&tracks, &parts, &params);
    assert!(separation.separates(&tracks, 8, 7) && !separation.separates(&tracks, 8, 1));
}

#[test]
fn a_foreground_torn_for_a_single_frame_stays_one_agent() {
    let tracks = row(8, 9, |t| if t == 4 { 60.0 } else { 0.0 });
    let parts = components_of(&tracks, &[true; 8], 1);
    let separated = |m| {
        let params = ConnectednessParams { min_component: 2, ..settings(ConnectednessMode::Agents, m) };
        Separation::new(&tracks, &parts, &params).separates(&tracks, 0, 7)
    };
    assert!(!separated(2) && separated(1));
}
