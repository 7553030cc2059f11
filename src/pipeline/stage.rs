//! The stages, and how far a session is in them.

use serde::Serialize;

/// The stages, in the order in which they run; flow and trajectories take turns, pair by pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "camelCase")]
pub enum Stage {
    /// Dense optical flow, forward and backward; a step is one field.
    Flow,
    /// Point trajectories; a step is one frame pair.
    Trajectories,
    /// Motion affinities; a step is a block of trajectories.
    Affinities,
    /// Spectral embedding; one step, up to a few seconds for 10 000 trajectories.
    Embedding,
    /// Delaunay neighbourhoods and embedding discontinuities; one step.
    Discontinuities,
    /// Saliency of pixels and trajectories; a step is one flow field looked at, one map made, or the average over the embedding.
    Saliency,
    /// Components of the foreground, and where they keep trajectories apart a second embedding and its discontinuities; one step or
    /// three.
    Connectedness,
    /// Cluster labels; one step.
    Clusters,
    /// Boundary probability, contours and Gabriel superpixels; a step is one frame.
    Superpixels,
    /// The Gabriel cut; a step is one move of the expansion, of the first also making the energy.
    Cut,
    /// A label for every pixel; a step is one frame.
    Masks,
}

impl Stage {
    /// All stages in order.
    pub const ALL: [Self; 11] = [
        Self::Flow,
        Self::Trajectories,
        Self::Affinities,
        Self::Embedding,
        Self::Discontinuities,
        Self::Saliency,
        Self::Connectedness,
        Self::Clusters,
        Self::Superpixels,
        Self::Cut,
        Self::Masks,
    ];

    /// The name used in JSON and JavaScript.
    pub fn name(self) -> &'static str {
        match self {
            Self::Flow => "flow",
            Self::Trajectories => "trajectories",
            Self::Affinities => "affinities",
            Self::Embedding => "embedding",
            Self::Discontinuities => "discontinuities",
            Self::Saliency => "saliency",
            Self::Connectedness => "connectedness",
            Self::Clusters => "clusters",
            Self::Superpixels => "superpixels",
            Self::Cut => "cut",
            Self::Masks => "masks",
        }
    }
}

/// How far the session is: `done` of `total` steps of `stage`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Progress {
    /// The stage that the step just taken belongs to.
    pub stage: Stage,
    /// Steps of that stage taken so far.
    pub done: u32,
    /// Steps of that stage in all.
    pub total: u32,
}

impl Progress {
    /// The one step of a stage that has no more.
    pub(super) fn whole(stage: Stage) -> Self {
        Self { stage, done: 1, total: 1 }
    }
}

/// What a call of [`crate::Session::step`] did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// One step was taken; more may remain.
    Working(Progress),
    /// Nothing was left to do: all results can be read.
    Done,
}
