//! Object connectedness (section 3): trajectories that are at some time in different pieces of the foreground are different things.
//!
//! In: trajectories, their Delaunay graphs, the foreground. Out: the pieces (components) of the foreground in each frame, and the
//! affinities without those between trajectories that the pieces keep apart.
//!
//! 1. In each frame, foreground trajectories are connected along the edges of the frame's Delaunay graph that join two of them and are
//!    not too long. Background trajectories between two agents so keep them apart. The connected components are the pieces of the foreground;
//!    very small ones are left out.
//! 2. Two trajectories violate connectedness in a frame where both belong to a component and not to the same. Whoever does so in enough of
//!    their common frames has no affinity.
//!
//! 3. Parts of one agent stay together: discontinuities between two foreground trajectories that are not kept apart count for somewhat less
//!    when clusters are merged, so that it takes more to split an agent than to part it from the background. Not in the paper, which
//!    speaks of keeping articulated parts together but has no means of its own for it.
//!
//! The paper gives neither the graph nor what becomes of affinities between foreground and background; here the latter stay as motion has
//! them, and [`ConnectednessMode::ForegroundOnly`] is the other reading (Figure 7(b) has one without the background). It takes one frame of
//! violation for enough. Here it is a few, so that a hole of a single frame in the foreground does not cut an agent in two for good.
//! Cost: O(Delaunay edges of all frames + stored affinities · common frames).

use crate::discontinuity::{Discontinuities, Neighborhoods};
use crate::discretize::{Clusters, canonical};
use crate::sets::DisjointSets;
use crate::sparse::SymCsr;
use crate::trajectory::Trajectories;

crate::choices! {
    /// What the foreground says about affinities.
    pub enum ConnectednessMode {
        /// Nothing.
        Off = "off",
        /// Trajectories in different components of the foreground have no affinity; the background's affinities stay as they are.
        Paper = "paper",
        /// The same, and only the foreground is embedded again and clustered: the background is one cluster.
        ForegroundOnly = "foreground-only",
    }
}

crate::params! {
    /// Object connectedness.
    pub struct ConnectednessParams {
        /// What is done with the components of the foreground.
        pub mode: ConnectednessMode = ConnectednessMode::Paper, in 0..=2;
        /// Frames in which two trajectories must be in different components to lose their affinity (section 3: 1). Higher forgives more
        /// holes in the foreground.
        pub min_violations: u32 = 2, in 1..=1000;
        /// Longest Delaunay edge along which the foreground is connected, in steps of the seed grid.
        pub max_edge: f32 = 4.0, in 1.0..=1000.0;
        /// Factor of the discontinuities between foreground trajectories that nothing keeps apart, when clusters are merged (the paper: 1).
        /// Lower keeps the parts of an agent together more, and agents that touch.
        pub articulation: f64 = 0.88, in 0.0..=1.0;
        /// Components of fewer trajectories keep nothing apart; counted at a grid step of 8 pixels and scaled with the inverse square of the
        /// step.
        pub min_component: u32 = 10, in 1..=100000;
    }
}

/// No component: background, or too small a piece of foreground.
pub const NO_COMPONENT: u32 = u32::MAX;

/// The connected pieces of the foreground in each frame.
///
/// Law: `of_point` has an entry for each trajectory point, in their order; in frame `t` it is below `count[t]` or [`NO_COMPONENT`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Components {
    /// Number of components of each frame.
    pub count: Vec<u32>,
    /// The component of each trajectory point in its frame.
    pub of_point: Vec<u32>,
}

/// The components of the foreground: trajectories joined by Delaunay edges of at most `max_edge` pixels between foreground trajectories.
/// Pieces of fewer than `min_size` trajectories are none. Components are numbered by their first trajectory.
pub fn components(
    tracks: &Trajectories,
    neighborhoods: &Neighborhoods,
    foreground: &[bool],
    max_edge: f32,
    min_size: usize,
) -> Components {
    let mut found = Components { count: Vec::new(), of_point: vec![NO_COMPONENT; tracks.x.len()] };
    let mut set = DisjointSets::new(tracks.len());
    let mut size = vec![0_u32; tracks.len()];
    let mut number = vec![NO_COMPONENT; tracks.len()];
    for t in 0..tracks.num_frames {
        let members: Vec<usize> = tracks.alive(t).map(|(i, _, _)| i).filter(|&i| foreground[i]).collect();
        for &i in &members {
            set.reset(i);
            (size[i], number[i]) = (0, NO_COMPONENT);
        }
        for &pair in neighborhoods.frame(t) {
            let (i, j) = neighborhoods.pairs[pair as usize];
            let (i, j) = (i as usize, j as usize);
            if foreground[i] && foreground[j] && distance_sq(tracks, i, j, t) <= max_edge * max_edge {
                set.join(i, j);
            }
        }
        for &i in &members {
            size[set.root(i)] += 1;
        }
        let mut count = 0;
        for &i in &members {
            let root = set.root(i);
            if size[root] as usize >= min_size && number[root] == NO_COMPONENT {
                number[root] = count;
                count += 1;
            }
            found.of_point[point(tracks, i, t)] = number[root];
        }
        found.count.push(count);
    }
    found
}

/// Where the point of trajectory `i` in frame `t` lies; it must be alive there.
fn point(tracks: &Trajectories, i: usize, t: usize) -> usize {
    tracks.points(i).start + t - tracks.start_frame[i] as usize
}

fn distance_sq(tracks: &Trajectories, i: usize, j: usize, t: usize) -> f32 {
    let (p, q) = (point(tracks, i, t), point(tracks, j, t));
    (tracks.x[p] - tracks.x[q]).powi(2) + (tracks.y[p] - tracks.y[q]).powi(2)
}

/// Whether trajectories `i` and `j` are kept apart: in at least `min_violations` frames, or in all common ones where these are fewer, both
/// are in components, and not in the same.
pub fn kept_apart(tracks: &Trajectories, components: &Components, i: usize, j: usize, min_violations: u32) -> bool {
    let (a, b) = (tracks.frames(i), tracks.frames(j));
    let (start, end) = (a.start.max(b.start), a.end.min(b.end));
    let common = end.saturating_sub(start);
    if common == 0 {
        return false;
    }
    let here = &components.of_point[point(tracks, i, start)..][..common];
    let there = &components.of_point[point(tracks, j, start)..][..common];
    let apart = |(&p, &q): (&u32, &u32)| p != q && p != NO_COMPONENT && q != NO_COMPONENT;
    let violations = here.iter().zip(there).filter(|&pair| apart(pair)).count();
    violations >= (min_violations as usize).min(common)
}

/// The affinities as `params.mode` and the components have them, and the number of pairs that lost theirs; `None` where nothing changes.
pub fn constrain(
    affinities: &SymCsr,
    tracks: &Trajectories,
    components: &Components,
    foreground: &[bool],
    params: &ConnectednessParams,
) -> Option<(SymCsr, usize)> {
    let mut kept = Vec::new();
    let mut lost = 0;
    for i in 0..affinities.len() {
        for (j, w) in affinities.row(i).filter(|&(j, _)| j > i) {
            let dropped = match (params.mode, foreground[i] && foreground[j]) {
                (ConnectednessMode::Off, _) | (ConnectednessMode::Paper, false) => false,
                (ConnectednessMode::ForegroundOnly, false) => true,
                (_, true) => kept_apart(tracks, components, i, j, params.min_violations),
            };
            if dropped {
                lost += 1;
            } else {
                kept.push((i as u32, j as u32, w as f32));
            }
        }
    }
    (lost > 0).then(|| (SymCsr::from_upper(affinities.len(), &kept), lost))
}

/// The discontinuities with those between foreground trajectories that are not kept apart times `params.articulation`.
pub fn articulated(
    found: &Discontinuities,
    tracks: &Trajectories,
    components: &Components,
    foreground: &[bool],
    params: &ConnectednessParams,
) -> Discontinuities {
    let mut softer = found.clone();
    for (&(i, j), d) in found.neighborhoods.pairs.iter().zip(&mut softer.d) {
        let (i, j) = (i as usize, j as usize);
        if foreground[i] && foreground[j] && !kept_apart(tracks, components, i, j, params.min_violations) {
            *d *= params.articulation;
        }
    }
    softer
}

/// The clusters with all background trajectories in one of their own.
pub fn with_background(tracks: &Trajectories, clusters: Clusters, foreground: &[bool]) -> Clusters {
    let background = clusters.count as u32;
    let label = clusters.label.iter().zip(foreground).map(|(&l, &f)| if f { l } else { background }).collect();
    canonical(tracks, label)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discontinuity::neighborhoods;

    /// Trajectories on a line ten pixels apart, alive in all of `frames`; `away` moves those from index 4 on by that much in some frames.
    fn row(n: usize, frames: usize, away: impl Fn(usize) -> f32) -> Trajectories {
        let mut tracks = Trajectories::empty(frames, (400, 100));
        for k in 0..n {
            let shift = |t| if k >= 4 { away(t) } else { 0.0 };
            // Two rows, so that the Delaunay graph is no chain.
            tracks.push(0, (0..frames).map(|t| ((k / 2) as f32 * 10.0 + shift(t), (k % 2) as f32 * 10.0, 0.0)));
        }
        tracks
    }

    fn found(tracks: &Trajectories, foreground: &[bool], min_size: usize) -> Components {
        components(tracks, &neighborhoods(tracks), foreground, 30.0, min_size)
    }

    fn complete(n: u32) -> SymCsr {
        let pairs: Vec<_> = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j, 1.0))).collect();
        SymCsr::from_upper(n as usize, &pairs)
    }

    fn settings(mode: ConnectednessMode, min_violations: u32) -> ConnectednessParams {
        ConnectednessParams { mode, min_violations, ..ConnectednessParams::default() }
    }

    #[test]
    fn a_gap_longer_than_an_edge_may_be_makes_two_components() {
        let tracks = row(8, 3, |t| if t == 1 { 60.0 } else { 0.0 });
        let found = found(&tracks, &[true; 8], 1);
        assert_eq!(found.count, [1, 2, 1]);
        let at = |t: usize| (0..8).map(|i| found.of_point[3 * i + t]).collect::<Vec<_>>();
        assert_eq!((at(0), at(1)), (vec![0; 8], vec![0, 0, 0, 0, 1, 1, 1, 1]));
    }

    #[test]
    fn background_between_two_agents_keeps_them_apart() {
        let tracks = row(12, 2, |_| 0.0);
        let foreground: Vec<bool> = (0..12).map(|i| !(4..8).contains(&i)).collect();
        let found = found(&tracks, &foreground, 1);
        assert_eq!(found.count, [2, 2]);
        assert_eq!((found.of_point[0], found.of_point[8], found.of_point[16]), (0, NO_COMPONENT, 1));
    }

    #[test]
    fn pieces_that_are_too_small_are_none() {
        let tracks = row(10, 2, |_| 90.0);
        assert_eq!(found(&tracks, &[true; 10], 5).count, [1, 1]);
        assert_eq!(found(&tracks, &[true; 10], 7).count, [0, 0]);
    }

    #[test]
    fn components_do_not_depend_on_the_frames_before() {
        let tracks = row(8, 4, |t| 30.0 * t as f32);
        let whole = found(&tracks, &[true; 8], 1);
        for t in 0..4 {
            let mut alone = Trajectories::empty(1, tracks.size);
            (0..8).for_each(|i| alone.push(0, tracks.at(i, t).map(|(x, y)| (x, y, 0.0))));
            let alone = found(&alone, &[true; 8], 1);
            assert_eq!(alone.count[0], whole.count[t]);
            assert!((0..8).all(|i| alone.of_point[i] == whole.of_point[4 * i + t]));
        }
    }

    #[test]
    fn only_pairs_across_components_lose_their_affinity() {
        let tracks = row(8, 3, |t| if t > 0 { 60.0 } else { 0.0 });
        let (foreground, all) = ([true; 8], complete(8));
        let parts = found(&tracks, &foreground, 1);
        let (constrained, lost) =
            constrain(&all, &tracks, &parts, &foreground, &settings(ConnectednessMode::Paper, 2)).unwrap();
        constrained.check().unwrap();
        assert_eq!(lost, 16);
        for i in 0..8 {
            let near: Vec<usize> = constrained.row(i).map(|(j, _)| j).collect();
            assert_eq!(near, (0..8).filter(|&j| j != i && (j < 4) == (i < 4)).collect::<Vec<_>>());
        }
        assert!(constrain(&all, &tracks, &parts, &foreground, &settings(ConnectednessMode::Off, 1)).is_none());
    }

    #[test]
    fn a_hole_of_a_single_frame_is_forgiven_unless_the_paper_is_followed() {
        let tracks = row(8, 9, |t| if t == 4 { 60.0 } else { 0.0 });
        let (foreground, all) = ([true; 8], complete(8));
        let parts = found(&tracks, &foreground, 1);
        let outcome = |m| constrain(&all, &tracks, &parts, &foreground, &settings(ConnectednessMode::Paper, m));
        assert_eq!(outcome(2), None);
        assert_eq!(outcome(1).unwrap().1, 16);
    }

    #[test]
    fn the_background_keeps_its_affinities_unless_the_foreground_stands_alone() {
        let tracks = row(8, 3, |_| 0.0);
        let foreground: Vec<bool> = (0..8).map(|i| i < 4).collect();
        let (parts, all) = (found(&tracks, &foreground, 1), complete(8));
        assert!(constrain(&all, &tracks, &parts, &foreground, &settings(ConnectednessMode::Paper, 1)).is_none());
        let alone = settings(ConnectednessMode::ForegroundOnly, 1);
        let (constrained, _) = constrain(&all, &tracks, &parts, &foreground, &alone).unwrap();
        assert_eq!(constrained.num_entries(), 12);
        let clusters = Clusters { count: 1, label: vec![0; 8] };
        assert_eq!(with_background(&tracks, clusters, &foreground).label, [0, 0, 0, 0, 1, 1, 1, 1]);
    }

    #[test]
    fn discontinuities_weaken_within_an_agent_only() {
        let tracks = row(12, 6, |t| if t > 2 { 60.0 } else { 0.0 });
        let foreground: Vec<bool> = (0..12).map(|i| i < 8).collect();
        let near = neighborhoods(&tracks);
        let parts = components(&tracks, &near, &foreground, 30.0, 1);
        let d = vec![0.8; near.pairs.len()];
        let found = Discontinuities { neighborhoods: near, d, ..Discontinuities::default() };
        let softer = articulated(&found, &tracks, &parts, &foreground, &settings(ConnectednessMode::Paper, 2));
        let factor = ConnectednessParams::default().articulation;
        for (&(i, j), &d) in softer.neighborhoods.pairs.iter().zip(&softer.d) {
            let same = i < 8 && j < 8 && (i < 4) == (j < 4);
            assert_eq!(d, if same { 0.8 * factor } else { 0.8 }, "{i} {j}");
        }
    }

    #[test]
    fn no_trajectories_have_no_components() {
        let nothing = Trajectories::empty(3, (8, 8));
        assert_eq!(found(&nothing, &[], 1), Components { count: vec![0; 3], of_point: vec![] });
    }
}
