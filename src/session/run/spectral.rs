//! Affinities block by block, then the embedding, then its discontinuities.

use super::clip::Clip;
use super::work::{StageWork, Turn};
use crate::Error;
use crate::affinity::AffinityRows;
use crate::camera::{ForwardMotion, PointMatches};
use crate::delaunay::delaunay_edges;
use crate::discontinuity::{discontinuities, neighborhoods_by, points_in};
use crate::embedding::embed;
use crate::session::base::{Outputs, Stage, Tracked};
use crate::session::jobs::{Ledger, Made, Piece, PieceKind, Work};

/// Trajectories compared with all others in one step.
const AFFINITY_BLOCK: usize = 512;

/// Affinities while they are being made.
#[derive(Debug, Clone)]
pub(crate) struct AffinityWork(AffinityRows);

impl AffinityWork {
    pub(crate) fn new(tracked: &Tracked, clip: &Clip) -> Self {
        let params = &clip.params;
        Self(AffinityRows::new(tracked.with_past(), params.spacing(), &params.affinity, params.clip.seed))
    }

    /// The number of the block that is next.
    fn block(&self) -> usize {
        self.0.done() / AFFINITY_BLOCK
    }

    fn take_rows(&self, clip: &mut Clip, tracked: &Tracked) -> Option<Piece> {
        let tracks = tracked.with_past();
        clip.params.clip.check_trajectories(tracks.len()).ok()?;
        let id = clip.ledger.take(PieceKind::Affinities, self.block()..tracks.len().div_ceil(AFFINITY_BLOCK))?;
        let rows = self.0.rows(tracks, id.t as usize * AFFINITY_BLOCK, AFFINITY_BLOCK);
        Some(Piece { id, work: Work::Affinities(Box::new(rows)) })
    }
}

impl StageWork for AffinityWork {
    /// One block of rows.
    fn step(&mut self, clip: &mut Clip, outputs: &mut Outputs) -> Result<Turn, Error> {
        let tracks = outputs.tracked.with_past();
        clip.params.clip.check_trajectories(tracks.len())?;
        let blocks = |rows: usize| rows.div_ceil(AFFINITY_BLOCK).max(1);
        let is_more = match clip.ledger.collect(PieceKind::Affinities, self.block()) {
            Some(Made::Affinities(entries)) => self.0.accept(entries, AFFINITY_BLOCK),
            _ => self.0.advance(tracks, AFFINITY_BLOCK),
        };
        let turn = Turn::new(Stage::Affinities, blocks(self.0.done()), blocks(tracks.len()));
        if !is_more {
            outputs.affinities = self.0.finish()?;
        }
        Ok(Turn { is_last: !is_more, ..turn })
    }

    fn take(&self, clip: &mut Clip, outputs: &Outputs) -> Option<Piece> {
        self.take_rows(clip, &outputs.tracked).or_else(|| take_ahead(&outputs.tracked, clip))
    }

    fn awaits(&self, ledger: &Ledger, _: &Outputs) -> bool {
        ledger.is_out(PieceKind::Affinities, self.block())
    }
}

/// The embedding, in one step.
#[derive(Debug, Clone)]
pub(crate) struct EmbeddingWork;

impl StageWork for EmbeddingWork {
    fn step(&mut self, clip: &mut Clip, outputs: &mut Outputs) -> Result<Turn, Error> {
        outputs.embedding = embed(&outputs.affinities, &clip.params.embedding, clip.params.clip.seed);
        Ok(Turn::new(Stage::Embedding, 1, 1))
    }

    fn take(&self, clip: &mut Clip, outputs: &Outputs) -> Option<Piece> {
        take_ahead(&outputs.tracked, clip)
    }
}

/// The discontinuities of the embedding, in one step.
#[derive(Debug, Clone)]
pub(crate) struct DiscontinuityWork;

impl StageWork for DiscontinuityWork {
    fn step(&mut self, clip: &mut Clip, outputs: &mut Outputs) -> Result<Turn, Error> {
        let tracks = &outputs.tracked.tracks;
        let mut graph = |t: usize| match clip.ledger.collect(PieceKind::Graph, t) {
            Some(Made::Graph(edges)) => edges,
            _ => delaunay_edges(&points_in(tracks, t)),
        };
        let near = neighborhoods_by(tracks, &mut graph);
        outputs.discontinuities = discontinuities(near, &outputs.embedding, &clip.params.discontinuity);
        Ok(Turn::new(Stage::Discontinuities, 1, 1))
    }

    fn take(&self, clip: &mut Clip, outputs: &Outputs) -> Option<Piece> {
        take_ahead(&outputs.tracked, clip)
    }

    fn awaits(&self, ledger: &Ledger, outputs: &Outputs) -> bool {
        (0..outputs.tracked.tracks.num_frames).any(|t| ledger.is_out(PieceKind::Graph, t))
    }
}

/// What needs nothing but trajectories: the graph of a frame; how the camera goes in a pair of frames.
fn take_ahead(tracked: &Tracked, clip: &mut Clip) -> Option<Piece> {
    let tracks = &tracked.tracks;
    if let Some(id) = clip.ledger.take(PieceKind::Graph, 0..tracks.num_frames) {
        return Some(Piece { id, work: Work::Graph(points_in(tracks, id.t as usize)) });
    }
    let settings = &clip.params.background;
    let is_asked = clip.params.clip.dense && settings.enabled && settings.rigid_scene && !clip.frames.is_empty();
    let pairs = if is_asked { ForwardMotion::num_pairs(tracks) } else { 0 };
    let id = clip.ledger.take(PieceKind::Ways, 0..pairs)?;
    Some(Piece { id, work: Work::Ways(PointMatches::new(tracks, id.t as usize)) })
}
