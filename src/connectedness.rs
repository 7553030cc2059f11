//! Object connectedness (section 3): trajectories that are at some time in different pieces of the foreground are different things.
//!
//! In: trajectories, their Delaunay graphs, the foreground. Out: the pieces (components) of the foreground in each frame, and the
//! affinities without those between trajectories that the pieces keep apart.
//!
//! Stand-in.

use crate::discontinuity::Neighborhoods;
use crate::discretize::{Clusters, canonical};
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
/// Pieces of fewer than `min_size` trajectories are none.
pub fn components(
    tracks: &Trajectories,
    _neighborhoods: &Neighborhoods,
    _foreground: &[bool],
    _max_edge: f32,
    _min_size: usize,
) -> Components {
    Components { count: vec![0; tracks.num_frames], of_point: vec![NO_COMPONENT; tracks.x.len()] }
}

/// The affinities as `mode` and the components have them, and the number of pairs that lost theirs; `None` where nothing changes.
pub fn constrain(
    _affinities: &SymCsr,
    _tracks: &Trajectories,
    _components: &Components,
    _foreground: &[bool],
    _params: &ConnectednessParams,
) -> Option<(SymCsr, usize)> {
    None
}

/// The clusters with all background trajectories in one of their own.
pub fn with_background(tracks: &Trajectories, clusters: Clusters, foreground: &[bool]) -> Clusters {
    let background = clusters.count as u32;
    let label = clusters.label.iter().zip(foreground).map(|(&l, &f)| if f { l } else { background }).collect();
    canonical(tracks, label)
}
