//! Affinities block by block, then the embedding, then its discontinuities.

use super::clip::Clip;
use super::found::{Embedded, Found, Linked, Placed, Tracked};
use super::stage::{Progress, Stage};
use super::turn::Turn;
use crate::Error;
use crate::affinity::AffinityRows;
use crate::discontinuity::{discontinuities, neighborhoods};
use crate::embedding::embed;

/// Trajectories compared with all others in one step.
const AFFINITY_BLOCK: usize = 512;

/// A step that can fail, and then leaves its work as it was.
type Attempt<W, O> = Result<Turn<W, O>, (W, Error)>;

/// Affinities while they are being made.
#[derive(Debug, Clone)]
pub(super) struct Linking {
    pub(super) tracked: Tracked,
    rows: AffinityRows,
}

impl Linking {
    pub(super) fn new(tracked: Tracked, clip: &Clip) -> Self {
        let params = &clip.params;
        let rows = AffinityRows::new(tracked.lived(), params.spacing(), &params.affinity, params.clip.seed);
        Self { tracked, rows }
    }

    /// One block of rows.
    pub(super) fn step(mut self: Box<Self>, clip: &Clip) -> Attempt<Box<Self>, Box<Linked>> {
        let tracks = self.tracked.lived();
        if let Err(error) = clip.params.clip.check_trajectories(tracks.len()) {
            return Err((self, error));
        }
        let blocks = |rows: usize| rows.div_ceil(AFFINITY_BLOCK).max(1) as u32;
        let more = self.rows.advance(tracks, AFFINITY_BLOCK);
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

    pub(super) fn found(&self) -> Found<'_> {
        self.tracked.found()
    }
}

impl Linked {
    pub(super) fn step(self: Box<Self>, clip: &Clip) -> Turn<Box<Self>, Box<Placed>> {
        let embedding = embed(&self.affinities, &clip.params.embedding, clip.params.clip.seed);
        Turn::whole(Stage::Embedding, Box::new(Placed { linked: *self, embedding }))
    }
}

impl Placed {
    pub(super) fn step(self: Box<Self>, clip: &Clip) -> Turn<Box<Self>, Box<Embedded>> {
        let Self { linked: Linked { tracked, affinities }, embedding } = *self;
        let discontinuities = discontinuities(neighborhoods(&tracked.tracks), &embedding, &clip.params.discontinuity);
        let embedded = Embedded { tracked, affinities, embedding, discontinuities };
        Turn::whole(Stage::Discontinuities, Box::new(embedded))
    }
}
