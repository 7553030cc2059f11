//! Affinities block by block, then the embedding, then its discontinuities.

use super::clip::Clip;
use super::turn::Turn;
use crate::Error;
use crate::affinity::AffinityRows;
use crate::camera::{Travel, Ways};
use crate::delaunay::delaunay_edges;
use crate::discontinuity::{discontinuities, neighborhoods_by, points_in};
use crate::embedding::embed;
use crate::session::base::{Embedded, Found, Linked, Placed, Tracked};
use crate::session::base::{Progress, Stage};
use crate::session::jobs::Ledger;
use crate::session::jobs::{Made, PieceKind, Work};

/// Trajectories compared with all others in one step.
const AFFINITY_BLOCK: usize = 512;

/// A step that can fail, and then leaves its work as it was.
type Attempt<W, O> = Result<Turn<W, O>, (W, Error)>;

/// Affinities while they are being made.
#[derive(Debug, Clone)]
pub(crate) struct Linking {
    pub(crate) tracked: Tracked,
    rows: AffinityRows,
}

impl Linking {
    pub(crate) fn new(tracked: Tracked, clip: &Clip) -> Self {
        let params = &clip.params;
        let rows = AffinityRows::new(tracked.lived(), params.spacing(), &params.affinity, params.clip.seed);
        Self { tracked, rows }
    }

    /// The number of the block that is next.
    pub(crate) fn block(&self) -> usize {
        self.rows.done() / AFFINITY_BLOCK
    }

    pub(crate) fn take(&self, clip: &mut Clip) -> Option<(PieceKind, usize, Work)> {
        let tracks = self.tracked.lived();
        clip.params.clip.check_trajectories(tracks.len()).ok()?;
        let block = clip.ledger.take(PieceKind::Affinities, self.block()..tracks.len().div_ceil(AFFINITY_BLOCK))?;
        let rows = self.rows.rows(tracks, block * AFFINITY_BLOCK, AFFINITY_BLOCK);
        Some((PieceKind::Affinities, block, Work::Affinities(Box::new(rows))))
    }

    /// One block of rows.
    pub(crate) fn step(mut self: Box<Self>, clip: &mut Clip) -> Attempt<Box<Self>, Box<Linked>> {
        let tracks = self.tracked.lived();
        if let Err(error) = clip.params.clip.check_trajectories(tracks.len()) {
            return Err((self, error));
        }
        let blocks = |rows: usize| rows.div_ceil(AFFINITY_BLOCK).max(1) as u32;
        let block = self.block();
        let more = match clip.ledger.collect(PieceKind::Affinities, block) {
            Some(Made::Affinities(entries)) => self.rows.accept(entries, AFFINITY_BLOCK),
            _ => self.rows.advance(tracks, AFFINITY_BLOCK),
        };
        let (done, total) = (blocks(self.rows.done()), blocks(tracks.len()));
        let progress = Progress { stage: Stage::Affinities, done, total };
        if more {
            return Ok(Turn::more(progress, self));
        }
        match self.rows.finish() {
            Ok(affinities) => Ok(Turn::done(progress, Box::new(Linked { tracked: self.tracked, affinities }))),
            Err(error) => Err((self, error)),
        }
    }

    pub(crate) fn found(&self) -> Found<'_> {
        self.tracked.found()
    }
}

impl Linked {
    pub(crate) fn step(self: Box<Self>, clip: &Clip) -> Turn<Box<Self>, Box<Placed>> {
        let embedding = embed(&self.affinities, &clip.params.embedding, clip.params.clip.seed);
        Turn::whole(Stage::Embedding, Box::new(Placed { linked: *self, embedding }))
    }
}

/// What needs nothing but trajectories: the graph of a frame; how the camera goes in a pair of frames.
pub(crate) fn take_ahead(tracked: &Tracked, clip: &mut Clip) -> Option<(PieceKind, usize, Work)> {
    let tracks = &tracked.tracks;
    if let Some(t) = clip.ledger.take(PieceKind::Graph, 0..tracks.num_frames) {
        return Some((PieceKind::Graph, t, Work::Graph(points_in(tracks, t))));
    }
    let settings = &clip.params.background;
    let is_asked = clip.params.clip.dense && settings.judge && settings.rigid && !clip.frames.is_empty();
    let pairs = if is_asked { Travel::num_pairs(tracks) } else { 0 };
    let k = clip.ledger.take(PieceKind::Ways, 0..pairs)?;
    Some((PieceKind::Ways, k, Work::Ways(Ways::new(tracks, k))))
}

impl Placed {
    pub(crate) fn awaits(&self, ledger: &Ledger) -> bool {
        (0..self.linked.tracked.tracks.num_frames).any(|t| ledger.is_out(PieceKind::Graph, t))
    }

    pub(crate) fn step(self: Box<Self>, clip: &mut Clip) -> Turn<Box<Self>, Box<Embedded>> {
        let Self { linked: Linked { tracked, affinities }, embedding } = *self;
        let mut graph = |t: usize| match clip.ledger.collect(PieceKind::Graph, t) {
            Some(Made::Graph(found)) => found,
            _ => delaunay_edges(&points_in(&tracked.tracks, t)),
        };
        let near = neighborhoods_by(&tracked.tracks, &mut graph);
        let discontinuities = discontinuities(near, &embedding, &clip.params.discontinuity);
        let embedded = Embedded { tracked, affinities, embedding, discontinuities };
        Turn::whole(Stage::Discontinuities, Box::new(embedded))
    }
}
