//! Corrections by the user: what to change in a finished segmentation, and what follows for its trajectories.
//!
//! In: the trajectories with the mask label of each, their affinities, and a [`Correction`]. Out: another mask label
//! for some of the trajectories. The session then makes clusters of them and cuts again what is concerned; nothing
//! before the clusters is made anew.
//!
//! 1. [`Correction::Merge`] renames. [`Correction::Split`] parts an object into the clusters that it has, or else along
//!    the weakest place of its own affinities (`halves`).
//! 2. Strokes say of the trajectories and pixels under them that they are one thing, or several (`stroke`). They hold
//!    for these as they stand; the others follow by random walks over the affinities (`decide`).
//! 3. Trajectories of labels that a correction does not touch keep theirs, and labels keep their meaning: a new object
//!    takes the lowest number that is free.
//!
//! Both the weakest place and the walks are found in one graph: the affinities as far as the trajectories also stay
//! near each other or take each other's place (`graph`). Motion alone did not part what the user wants parted, so that
//! space has to say where.
//!
//! **Why not embed again.** Constraints on affinities could go through the whole chain of embedding, discontinuities
//! and clusters. A stroke has some dozen trajectories; the affinities between them weigh nothing among a million
//! others, and the leading eigenvectors stay as they are. What did change could be anything anywhere. The walk is that
//! whose eigenvectors the embedding consists of (`P = D⁻¹ A`), with the strokes as places where it ends: it takes a
//! tenth of a second, and changes what the strokes speak of.
//!
//! In the cut, superpixels that a stroke lies over to a good part can have its label only, the denser trajectories
//! there vote for it, and in the mask the pixels under the middle of the stroke have it (`session`'s `recut`).
//!
//! Limits: a part of a thing that neither moves nor lies apart from the rest, such as a rider on a horse, takes several
//! strokes in several frames. Where trajectories are short, what a stroke says reaches only as far in time as they and
//! those after them do.

mod decide;
mod graph;
mod halves;
mod regroup;
mod stroke;
#[cfg(test)]
mod tests;

pub(crate) use decide::{Painted, apart, distinct, free_labels, together};
pub(crate) use graph::near_affinities;
pub(crate) use halves::{halves, part_at};
pub(crate) use regroup::regroup;
pub use stroke::Stroke;
pub(crate) use stroke::{cores, under_strokes};

/// What the user wants changed. Labels are those of the masks.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Correction {
    /// What is `from` becomes `into`; 0 makes it background.
    Merge {
        /// The label that stays.
        into: u8,
        /// The label that goes.
        from: u8,
    },
    /// An object becomes two. The part at the point gets a new label, without a point the smaller part.
    Split {
        /// The object; 0, which needs a point, makes an object of what is there in the background.
        label: u8,
        /// Frame, and place in input pixels.
        at: Option<(usize, f32, f32)>,
    },
    /// All that these strokes touch is one thing.
    Together(Vec<Stroke>),
    /// Each of these strokes is a thing of its own.
    Apart(Vec<Stroke>),
}

/// Pixels of a frame that a stroke holds to a label.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Held {
    /// The frame.
    pub t: usize,
    /// The pixels, increasing, row by row at working size.
    pub pixels: Vec<u32>,
    /// The trajectories under the stroke.
    pub tracks: Vec<u32>,
    /// Their label.
    pub label: u8,
}
