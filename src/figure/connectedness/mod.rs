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
mod components;

use crate::sparse::SymCsr;
use crate::trajectory::Trajectories;
use agents::track_agents;
pub use components::{Components, components};

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

#[cfg(test)]
mod tests;
