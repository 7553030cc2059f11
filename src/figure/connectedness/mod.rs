//! Object connectedness (section 3): trajectories that are at some time in different pieces of the foreground are
//! different things.
//!
//! In: trajectories, their Delaunay graphs, the foreground. Out: the pieces (components) of the foreground in each
//! frame, and the affinities without those between trajectories that the pieces keep apart.
//!
//! 1. In each frame, foreground trajectories are connected along the edges of the frame's Delaunay graph that join two
//!    of them and are not too long. Background trajectories between two agents so keep them apart. The connected
//!    components are the pieces of the foreground; very small ones are left out.
//! 2. Components are followed through time as agents, so that two that touch for a while stay two (`agents`).
//! 3. Two trajectories violate connectedness in a frame where both belong to an agent (with
//!    [`ConnectednessMode::Paper`]: a component) and not to the same. Whoever does so in enough of their common frames
//!    has no affinity.
//!
//! The paper gives neither the graph nor what becomes of affinities between foreground and background; here the latter
//! stay as motion has them, and [`ConnectednessMode::ForegroundOnly`] is the other reading (Figure 7(b) has one without
//! the background). It takes one frame of violation for enough. Here it is a few, so that a hole of a single frame in
//! the foreground does not cut an agent in two for good. Cost: O(Delaunay edges of all frames + stored affinities ·
//! common frames).

mod agents;
mod components;

use crate::sparse::SymCsr;
use crate::trajectory::Trajectories;
use agents::follow;
pub use components::{Components, NO_COMPONENT, components};

crate::choices! {
    /// What the foreground says about affinities.
    pub enum ConnectednessMode {
        /// Nothing.
        Off = "off",
        /// Trajectories in different components of the foreground have no affinity; the background's affinities stay as
        /// they are.
        Paper = "paper",
        /// Trajectories of different agents have no affinity: components that are followed through the frames in which
        /// they touch.
        Agents = "agents",
        /// The same, and only the foreground is embedded again and clustered: the background is one cluster.
        ForegroundOnly = "foreground-only",
    }
}

crate::params! {
    /// Object connectedness.
    pub struct ConnectednessParams {
        /// What is done with the components of the foreground.
        pub mode: ConnectednessMode = ConnectednessMode::Agents, in 0..=3;
        /// Frames in which two trajectories must be in different components to lose their affinity (section 3: 1).
        /// Higher forgives more holes in the foreground.
        pub min_violations: u32 = 4, in 1..=1000, expert;
        /// Longest Delaunay edge along which the foreground is connected, in steps of the seed grid.
        pub max_edge: f32 = 4.0, in 1.0..=1000.0, expert;
        /// Components of fewer trajectories keep nothing apart; counted at a grid step of 8 pixels and scaled with the
        /// inverse square of the step.
        pub min_component: u32 = 10, in 1..=100000, expert;
    }
}

impl ConnectednessParams {
    /// As the paper has it: components frame by frame, one frame of violation is enough.
    pub fn paper() -> Self {
        Self { mode: ConnectednessMode::Paper, min_violations: 1, ..Self::default() }
    }
}

/// Which trajectories connectedness keeps apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Separation {
    /// For each trajectory point, its component, or its agent forward and backward in time.
    parts: Vec<Vec<u32>>,
    min_violations: usize,
}

impl Separation {
    /// By components or by agents, as `params.mode` has it; with the mode off nothing is kept apart.
    pub fn new(tracks: &Trajectories, components: &Components, params: &ConnectednessParams) -> Self {
        let follow = |backward: bool| {
            let frames = (0..tracks.num_frames).map(|t| if backward { tracks.num_frames - 1 - t } else { t });
            follow(tracks, components, frames, params.min_violations, params.min_component as usize)
        };
        let parts = match params.mode {
            ConnectednessMode::Off => Vec::new(),
            ConnectednessMode::Paper => vec![components.of_point.clone()],
            ConnectednessMode::Agents | ConnectednessMode::ForegroundOnly => vec![follow(false), follow(true)],
        };
        Self { parts, min_violations: params.min_violations as usize }
    }

    /// Whether both are in some part, and not in the same, in enough of the frames in which both are alive.
    pub(crate) fn apart(&self, tracks: &Trajectories, i: usize, j: usize) -> bool {
        let (a, b) = (tracks.frames(i), tracks.frames(j));
        let start = a.start.max(b.start);
        let common = a.end.min(b.end).saturating_sub(start);
        let violates = |(&p, &q): (&u32, &u32)| p != q && p != NO_COMPONENT && q != NO_COMPONENT;
        common >= self.min_violations
            && self.parts.iter().any(|part| {
                let [here, there] = [i, j].map(|k| &part[tracks.point(k, start)..][..common]);
                here.iter().zip(there).filter(|&pair| violates(pair)).count() >= self.min_violations
            })
    }
}

/// The affinities that are left, and the number of pairs that lost theirs; `None` where nothing changes. Where the
/// foreground stands alone the background loses all.
///
/// # Examples
/// Four foreground trajectories, two in each of two components; every two of them have an affinity.
///
/// ```
/// use tracecut::connectedness::{Components, ConnectednessParams, Separation, constrain};
/// use tracecut::sparse::SymCsr;
/// use tracecut::trajectory::Trajectories;
///
/// let mut tracks = Trajectories::empty(1, (40, 10));
/// (0..4).for_each(|i| tracks.push(0, [(10.0 * i as f32, 5.0, 0.0)]));
/// let all: Vec<_> = (0..4).flat_map(|i| (i + 1..4).map(move |j| (i, j, 1.0))).collect();
/// let components = Components { count: vec![2], of_point: vec![0, 0, 1, 1] };
/// let params = ConnectednessParams::paper();
/// let separation = Separation::new(&tracks, &components, &params);
/// let left = constrain(&SymCsr::from_upper(4, &all), &tracks, &separation, &[true; 4], &params);
/// let (left, lost) = left.ok_or("nothing lost")?;
/// assert_eq!(lost, 4); // of six pairs
/// assert_eq!(left.row(0).filter(|&(j, _)| j != 0).collect::<Vec<_>>(), [(1, 1.0)]);
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
    let alone = params.mode == ConnectednessMode::ForegroundOnly;
    let mut kept = Vec::new();
    let mut lost = 0;
    for i in 0..affinities.len() {
        for (j, w) in affinities.row(i).filter(|&(j, _)| j > i) {
            let both = foreground[i] && foreground[j];
            let dropped = if both { separation.apart(tracks, i, j) } else { alone };
            if dropped {
                lost += 1;
            } else {
                kept.push((i as u32, j as u32, w as f32));
            }
        }
    }
    (lost > 0).then(|| (SymCsr::from_upper(affinities.len(), &kept), lost))
}

#[cfg(test)]
mod tests;
