//! Object connectedness (section 3): an object is connected in every frame, so that trajectories in different components
//! of the foreground are different objects.
//!
//! In: trajectories, their Delaunay graphs, the foreground. Out: the components of the foreground in each frame, and the
//! affinities between trajectories that are not separated.
//!
//! 1. In each frame, foreground trajectories are connected along the short edges of the Delaunay graph between two of them,
//!    so that background between two agents separates them. Very small components are left out.
//! 2. Components are tracked as agents, so that two that touch for a while stay two (`agents`).
//! 3. Two trajectories violate connectedness in a frame where they belong to different agents (with
//!    [`ConnectednessMode::Paper`]: to different components). With enough violations they have no affinity.
//!
//! The paper defines neither the graph nor the affinities between foreground and background; here the latter stay, and
//! [`ConnectednessMode::ForegroundOnly`] is the other reading (Figure 7(b) has one without the background). In the paper one
//! frame of violation is enough; here it takes a few, so that a hole of a single frame in the foreground does not split
//! an agent for good. Cost: O(Delaunay edges of all frames + stored affinities · common frames). It fails where agents
//! touch in all frames, or one is torn for long.

mod agents;

use crate::discontinuity::Neighborhoods;
use crate::sets::DisjointSets;
use crate::sparse::SymCsr;
use crate::trajectory::Trajectories;
use agents::track_agents;

crate::choices! {
    /// Constraint of the foreground on affinities.
    pub enum ConnectednessMode {
        /// None.
        Off = "off",
        /// Trajectories in different components of the foreground have no affinity.
        Paper = "paper",
        /// Trajectories of different agents have no affinity: components that are tracked while they touch.
        Agents = "agents",
        /// Same as agents, and only the foreground is embedded again and clustered: the background is one cluster.
        ForegroundOnly = "foreground-only",
    }
}

crate::params! {
    /// Object connectedness.
    pub struct ConnectednessParams {
        /// Constraint of the foreground on affinities.
        pub mode: ConnectednessMode = ConnectednessMode::Agents, in 0..=3;
        /// Frames in which two trajectories must be in different components to lose their affinity (section 3: 1).
        /// Higher forgives more holes in the foreground.
        pub min_violations: u32 = 4, in 1..=1000, expert;
        /// Longest Delaunay edge along which the foreground is connected, in steps of the seed grid.
        pub max_edge: f32 = 4.0, in 1.0..=1000.0, expert;
        /// Components of fewer trajectories are ignored; counted at a grid step of 8 pixels and scaled with the inverse
        /// square of the step.
        pub min_component: u32 = 10, in 1..=100000, expert;
    }
}

impl ConnectednessParams {
    /// The paper's: components frame by frame, and one frame of violation is enough.
    pub(crate) fn paper() -> Self {
        Self { mode: ConnectednessMode::Paper, min_violations: 1, ..Self::default() }
    }
}

/// Pairs of trajectories that connectedness separates.
#[derive(Debug, Clone, PartialEq)]
pub struct Separation {
    /// Component of each trajectory point, or its agents forward and backward in time; none if nothing is separated.
    partitions: Vec<Vec<Option<u32>>>,
    min_violations: usize,
}

impl Separation {
    /// Separates by components or by agents, as in `params.mode`.
    pub fn new(tracks: &Trajectories, components: &Components, params: &ConnectednessParams) -> Self {
        let track = |backward: bool| {
            let frames = (0..tracks.num_frames).map(|t| if backward { tracks.num_frames - 1 - t } else { t });
            track_agents(tracks, components, frames, params.min_violations, params.min_component as usize)
        };
        let partitions = match params.mode {
            ConnectednessMode::Off => Vec::new(),
            ConnectednessMode::Paper => vec![components.of_point.clone()],
            ConnectednessMode::Agents | ConnectednessMode::ForegroundOnly => vec![track(false), track(true)],
        };
        Self { partitions, min_violations: params.min_violations as usize }
    }

    /// Returns `true` if both are in different components or agents in enough of their common frames.
    pub(crate) fn separates(&self, tracks: &Trajectories, i: usize, j: usize) -> bool {
        let (a, b) = (tracks.frames(i), tracks.frames(j));
        let start = a.start.max(b.start);
        let common = a.end.min(b.end).saturating_sub(start);
        let violates = |(p, q): (&Option<u32>, &Option<u32>)| p.is_some() && q.is_some() && p != q;
        common >= self.min_violations
            && self.partitions.iter().any(|partition| {
                let [of_i, of_j] = [i, j].map(|k| &partition[tracks.point(k, start)..][..common]);
                of_i.iter().zip(of_j).filter(|&pair| violates(pair)).count() >= self.min_violations
            })
    }
}

/// Removes the affinities of separated pairs; with [`ConnectednessMode::ForegroundOnly`] also the background's. Returns
/// the remaining affinities and the number of removed pairs, or `None` if nothing changes.
///
/// # Examples
/// Four foreground trajectories, two in each of two components; every two of them have an affinity.
///
/// ```
/// use tracecut::Params;
/// use tracecut::connectedness::{Components, Separation, constrain};
/// use tracecut::sparse::SymCsr;
/// use tracecut::trajectory::Trajectories;
///
/// let mut tracks = Trajectories::empty(1, (40, 10));
/// (0..4).for_each(|i| tracks.push(0, [(10.0 * i as f32, 5.0, 0.0)]));
/// let all: Vec<_> = (0..4).flat_map(|i| (i + 1..4).map(move |j| (i, j, 1.0))).collect();
/// let components = Components { count: vec![2], of_point: [0, 0, 1, 1].map(Some).to_vec() };
/// let params = Params::paper().connectedness;
/// let separation = Separation::new(&tracks, &components, &params);
/// let constrained = constrain(&SymCsr::from_upper(4, &all), &tracks, &separation, &[true; 4], &params);
/// let (affinities, num_removed) = constrained.ok_or("nothing removed")?;
/// assert_eq!(num_removed, 4); // of six pairs
/// assert_eq!(affinities.row(0).filter(|&(j, _)| j != 0).collect::<Vec<_>>(), [(1, 1.0)]);
/// # Ok::<(), &str>(())
/// ```
#[must_use]
pub fn constrain(
    affinities: &SymCsr,
    tracks: &Trajectories,
    separation: &Separation,
    foreground: &[bool],
    params: &ConnectednessParams,
) -> Option<(SymCsr, usize)> {
    let is_foreground_only = params.mode == ConnectednessMode::ForegroundOnly;
    let mut remaining = Vec::new();
    let mut num_removed = 0;
    for i in 0..affinities.len() {
        for (j, w) in affinities.row(i).filter(|&(j, _)| j > i) {
            let is_foreground_pair = foreground[i] && foreground[j];
            if if is_foreground_pair { separation.separates(tracks, i, j) } else { is_foreground_only } {
                num_removed += 1;
            } else {
                remaining.push((i as u32, j as u32, w as f32));
            }
        }
    }
    (num_removed > 0).then(|| (SymCsr::from_upper(affinities.len(), &remaining), num_removed))
}

/// Connected components of the foreground in each frame.
///
/// Law: `of_point` has an entry for each trajectory point, in their order; in frame `t` it is below `count[t]`, or `None` for
/// the background and for foreground in too small a component.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Components {
    /// Number of components of each frame.
    pub count: Vec<u32>,
    /// The component of each trajectory point in its frame.
    pub of_point: Vec<Option<u32>>,
}

/// Computes the connected components of the foreground, along Delaunay edges of at most `max_edge` pixels. Components of
/// fewer than `min_size` trajectories are left out. They are numbered by their first trajectory.
///
/// # Examples
/// Foreground at either end of a row of trajectories: two components.
///
/// ```
/// use tracecut::connectedness::components;
/// use tracecut::discontinuity::neighborhoods;
/// use tracecut::trajectory::Trajectories;
///
/// let row = "1110000011";
/// let mut tracks = Trajectories::empty(1, (100, 20));
/// (0..10).for_each(|i| tracks.push(0, [(10.0 * i as f32, (i % 2) as f32, 0.0)]));
/// let foreground: Vec<bool> = row.bytes().map(|digit| digit == b'1').collect();
/// let found = components(&tracks, &neighborhoods(&tracks), &foreground, 30.0, 2);
/// assert_eq!(found.count, [2]);
/// assert_eq!((found.of_point[0], found.of_point[3], found.of_point[9]), (Some(0), None, Some(1)));
/// ```
#[must_use]
pub fn components(
    tracks: &Trajectories,
    neighborhoods: &Neighborhoods,
    foreground: &[bool],
    max_edge: f32,
    min_size: usize,
) -> Components {
    let mut components = Components { count: Vec::new(), of_point: vec![None; tracks.x.len()] };
    let mut set = DisjointSets::new(tracks.len());
    let mut size = vec![0_u32; tracks.len()];
    let mut number = vec![None; tracks.len()];
    for t in 0..tracks.num_frames {
        let members: Vec<usize> = tracks.alive(t).map(|(i, _, _)| i).filter(|&i| foreground[i]).collect();
        for &i in &members {
            set.reset(i);
            (size[i], number[i]) = (0, None);
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
            if size[root] as usize >= min_size && number[root].is_none() {
                number[root] = Some(count);
                count += 1;
            }
            components.of_point[tracks.point(i, t)] = number[root];
        }
        components.count.push(count);
    }
    components
}

fn distance_sq(tracks: &Trajectories, i: usize, j: usize, t: usize) -> f32 {
    let (p, q) = (tracks.point(i, t), tracks.point(j, t));
    (tracks.x[p] - tracks.x[q]).powi(2) + (tracks.y[p] - tracks.y[q]).powi(2)
}

#[cfg(test)]
mod tests {
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
}
