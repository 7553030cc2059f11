//! The stages, and how far a session is in them.

use serde::Serialize;

/// Declares the list of stages: `/// meaning` `Variant = "name",`.
macro_rules! stages {
    ($(#[$meta:meta])* pub enum $stage:ident { $($(#[$doc:meta])* $variant:ident = $name:literal,)* }) => {
        $(#[$meta])*
        pub enum $stage {
            $($(#[$doc])* $variant,)*
        }

        impl $stage {
            /// All stages in order.
            #[cfg(test)]
            pub(crate) const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// The name used in JSON and JavaScript.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}

stages! {
    /// The stages, in the order in which they run; flow and trajectories take turns, pair by pair.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
    #[serde(rename_all = "camelCase")]
    pub enum Stage {
        /// Dense optical flow, forward and backward; a step is one field.
        Flow = "flow",
        /// Point trajectories; a step is one frame pair.
        Trajectories = "trajectories",
        /// Motion affinities; a step is a block of trajectories.
        Affinities = "affinities",
        /// Spectral embedding; one step, up to a few seconds for 10 000 trajectories.
        Embedding = "embedding",
        /// Delaunay neighbourhoods and embedding discontinuities; one step.
        Discontinuities = "discontinuities",
        /// Saliency of pixels and trajectories; a step is one flow field looked at, one map made, or the average over the
        /// embedding.
        Saliency = "saliency",
        /// Components of the foreground, and where they keep trajectories apart a second embedding and its discontinuities;
        /// one step or three.
        Connectedness = "connectedness",
        /// Cluster labels; one step.
        Clusters = "clusters",
        /// Boundary probability, contours and Gabriel superpixels; a step is one frame.
        Superpixels = "superpixels",
        /// The Gabriel cut; a step is one move of the expansion, of the first also making the energy.
        Cut = "cut",
        /// A label for every pixel; a step is one frame.
        Masks = "masks",
    }
}

/// How far the session is: `done` of `total` steps of `stage`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Progress {
    /// The stage that the step just taken belongs to.
    pub stage: Stage,
    /// Steps of that stage taken so far.
    pub done: u32,
    /// Steps of that stage in all; of the cut as far as is known, since a move that gains something asks for more.
    pub total: u32,
}

/// What a call of [`crate::Session::step`] did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// One step was taken; more may remain.
    Working(Progress),
    /// Nothing was left to do: all results can be read.
    Done,
}
