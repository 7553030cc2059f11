//! The stages of a session, and its progress.

use serde::Serialize;

/// Declares the list of stages: `/// meaning` `Variant = "name", cost;`.
macro_rules! stages {
    ($(#[$meta:meta])* pub enum $stage:ident { $($(#[$doc:meta])* $variant:ident = $name:literal, $cost:literal;)* }) => {
        $(#[$meta])*
        pub enum $stage {
            $($(#[$doc])* $variant,)*
        }

        impl $stage {
            /// All stages in order.
            #[doc(hidden)] // For the command line and the Python package.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// Returns the usual time of the stage for a frame, as a fit to runs of the sample clip; flow and trajectories together
            /// are one unit.
            #[doc(hidden)] // For the command line and the Python package.
            pub fn cost(self) -> f64 {
                match self {
                    $(Self::$variant => $cost,)*
                }
            }

            /// Returns the name used in JSON and JavaScript.
            #[doc(hidden)] // Users have `Display`.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }

        impl std::fmt::Display for $stage {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}

stages! {
    /// The stages, in the order in which they run; flow and trajectories alternate, pair by pair.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
    #[serde(rename_all = "camelCase")]
    #[non_exhaustive]
    pub enum Stage {
        /// Dense optical flow, forward and backward; a step is one field.
        Flow = "flow", 0.5;
        /// Point trajectories; a step is one frame pair.
        Trajectories = "trajectories", 0.5;
        /// Motion affinities; a step is a block of trajectories.
        Affinities = "affinities", 0.03;
        /// Spectral embedding; one step, up to a few seconds for 10 000 trajectories.
        Embedding = "embedding", 0.01;
        /// Delaunay neighbourhoods and embedding discontinuities; one step.
        Discontinuities = "discontinuities", 0.02;
        /// Saliency of pixels and trajectories; a step is the dominant motion of a flow field, a saliency map, or the average
        /// over the embedding.
        Saliency = "saliency", 0.06;
        /// Components of the foreground, and if they separate trajectories a second embedding and its discontinuities; one step
        /// or three.
        Connectedness = "connectedness", 0.02;
        /// Cluster labels; one step.
        Clusters = "clusters", 0.01;
        /// Boundary probability, contours and Gabriel superpixels; a step is one frame.
        Superpixels = "superpixels", 0.25;
        /// The Gabriel cut; a step is one expansion move, the first one also sets up the energy.
        Cut = "cut", 0.32;
        /// A label for every pixel; a step is one frame.
        Masks = "masks", 0.13;
    }
}

/// The progress of a session: `done` of `total` steps of `stage`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Progress {
    /// The stage of the last step.
    pub stage: Stage,
    /// Steps of that stage taken so far.
    pub done: u32,
    /// Total number of steps of that stage; an estimate during the cut, where a successful move adds more.
    pub total: u32,
}

/// The outcome of [`crate::Session::step`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// One step was taken; more may remain.
    Working(Progress),
    /// The run is done: all results can be read.
    Done,
}
