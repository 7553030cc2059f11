//! Corrections of a finished segmentation by the user, and the labels of trajectories that follow from them.
//!
//! In: the trajectories with their mask labels and affinities, and a [`Correction`]. Out: new mask labels of some
//! trajectories. The session then regroups the clusters and cuts the affected superpixels again; stages before the clusters
//! do not run again.
//!
//! 1. [`Correction::Merge`] renames. [`Correction::Split`] divides an object into its clusters, or if it has only one, along
//!    the least normalised cut of its own affinities (`bisect`).
//! 2. Strokes join or split the trajectories and pixels under them (`stroke`). The others follow by random walks over the
//!    affinities (`decision`, `random_walk`).
//! 3. Trajectories of labels that a correction does not affect keep them, and labels keep their meaning: a new object takes
//!    the lowest free number.
//!
//! Cuts and walks use one graph: the affinities of trajectories that also stay near each other or succeed each other
//! (`graph`). Motion alone did not separate what the user wants separated, so distance has to.
//!
//! **Why not embed again.** Constraints on affinities could go through embedding, discontinuities and clusters again. But a
//! stroke has a few dozen trajectories, whose affinities are few among a million others: the leading eigenvectors would
//! hardly change, or change anywhere. The walk is the one whose eigenvectors form the embedding (`P = D⁻¹ A`), with
//! absorption at the strokes: it takes a tenth of a second and changes only what the strokes cover and its surroundings.
//!
//! In the cut, superpixels of which a stroke covers a good part are fixed to its label, the mask trajectories there vote for
//! it, and in the mask the pixels under the core of the stroke have it (`recut` of `session`).
//!
//! Limits: a part of an object that neither moves differently nor lies apart, such as a rider on a horse, takes several
//! strokes in several frames. If trajectories are short, a stroke reaches only as far in time as they and their successors.

mod bisect;
mod decision;
mod graph;
mod random_walk;
mod regroup;
mod stroke;
#[cfg(test)]
mod tests;

pub(crate) use bisect::{bisect, part_containing};
pub(crate) use decision::{NO_FREE_LABEL, StrokeInput, distinct, free_labels, join_strokes, split_strokes};
pub(crate) use graph::proximity_graph;
pub(crate) use regroup::regroup;
pub use stroke::Stroke;
pub(crate) use stroke::{core_pixels, strokes_over_tracks};

/// A correction of the masks. Labels are mask labels.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Correction {
    /// Merges the object `from` into `into`; 0 makes it background.
    Merge {
        /// The label that remains.
        into: u8,
        /// The label that is replaced.
        from: u8,
    },
    /// Splits an object in two. The part at the point gets a new label; without a point, the smaller part.
    Split {
        /// The object; 0, which needs a point, makes a part of the background an object.
        label: u8,
        /// Frame and position in input pixels.
        at: Option<(usize, f32, f32)>,
    },
    /// Joins everything under the strokes into one object.
    JoinStrokes(Vec<Stroke>),
    /// Makes each stroke an object of its own.
    SplitStrokes(Vec<Stroke>),
}

/// Pixels and trajectories whose label a stroke fixes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct StrokeConstraint {
    pub(crate) t: usize,
    /// Pixels at working size, row by row, increasing.
    pub(crate) pixels: Vec<u32>,
    /// Trajectories under the stroke.
    pub(crate) tracks: Vec<u32>,
    pub(crate) label: u8,
}
