//! Pieces of a run that depend on little of it: any thread, worker or process can work on them, in any order.
//!
//! A session gives a [`Piece`] away and takes what became of it (`give`). Its steps use what is there; what is not back
//! yet they make themselves, so nothing depends on who does the work, and a piece that never comes back is only late.

use super::pair::PairFlow;
use crate::affinity::Rows;
use crate::background::{ReprojectionErrors, ReprojectionInput};
use crate::camera::{Egomotion, PointMatches};
use crate::delaunay::delaunay_edges;
use crate::discretize::NormalizedRows;
use crate::flow::FlowScratch;
use crate::image::{Frame, Plane};
use crate::mask::refine;
use crate::saliency::SaliencyQuery;
use crate::session::base::Params;
use crate::superpixel::{Superpixels, frame_superpixels};

/// Which piece of which run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PieceId {
    /// The window that the session was at.
    pub(crate) epoch: u32,
    pub(crate) kind: PieceKind,
    /// Frame, or first frame of the pair; of other kinds a number.
    pub(crate) t: u32,
}

/// What is to be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PieceKind {
    Pair = 0,
    Superpixels = 1,
    Mask = 2,
    /// The saliency of the trajectories' points in a frame.
    Saliency = 3,
    /// The Delaunay graph of the trajectories in a frame.
    Graph = 4,
    /// A block of rows of affinities.
    Affinities = 5,
    /// How the camera goes in a pair of frames.
    Ways = 6,
    /// Clusters by a number of eigenvectors.
    Rotation = 7,
    /// How well the pixels of a frame are found again in others.
    Accounts = 8,
}

impl PieceKind {
    pub(crate) const ALL: [Self; 9] = [
        Self::Pair,
        Self::Superpixels,
        Self::Mask,
        Self::Saliency,
        Self::Graph,
        Self::Affinities,
        Self::Ways,
        Self::Rotation,
        Self::Accounts,
    ];
}

/// A piece of work: what it needs, owned.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Piece {
    pub(crate) id: PieceId,
    pub(crate) work: Work,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Work {
    Pair(Frame, Frame),
    Superpixels(Frame),
    /// Borders of these labels are to be refined.
    Mask(Frame, Plane<u8>),
    Saliency(SaliencyQuery),
    Graph(Vec<(f32, f32)>),
    Affinities(Box<Rows>),
    Ways(PointMatches),
    Rotation(NormalizedRows),
    Accounts(ReprojectionInput),
}

/// What became of a piece.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Made {
    Pair(Box<PairFlow>),
    Superpixels(Superpixels),
    Mask(Plane<u8>),
    Saliency(Vec<f32>),
    Graph(Vec<(u32, u32)>),
    Affinities(Vec<(u32, u32, f32)>),
    /// The motion, and whether it is sure.
    Ways(Option<(Egomotion, bool)>),
    Rotation(Vec<u32>),
    Accounts(ReprojectionErrors),
}

impl Piece {
    /// Does the work, under the parameters of the session that gave it away.
    pub(crate) fn work(&self, params: &Params, scratch: &mut FlowScratch) -> Made {
        match &self.work {
            Work::Pair(from, to) => Made::Pair(Box::new(PairFlow::new(from, to, &params.for_flow(), scratch))),
            Work::Superpixels(frame) => {
                Made::Superpixels(frame_superpixels(frame, &params.contour, &params.superpixel))
            }
            Work::Mask(frame, labels) => {
                Made::Mask(refine(labels, frame, &params.for_size((frame.width(), frame.height())).refine))
            }
            Work::Saliency(query) => Made::Saliency(query.evaluate(&params.saliency)),
            Work::Graph(points) => Made::Graph(delaunay_edges(points)),
            Work::Affinities(rows) => Made::Affinities(rows.entries()),
            Work::Ways(matches) => Made::Ways(matches.estimate_egomotion()),
            Work::Rotation(rows) => Made::Rotation(rows.rotate()),
            Work::Accounts(input) => Made::Accounts(input.errors()),
        }
    }
}
