//! The two trackers of a clip, side by side.

use crate::image::Plane;
use crate::session::base::Params;
use crate::session::jobs::PairFlow;
use crate::trajectory::Tracker;

/// Frames before a window that trajectories remember.
const REMEMBERED: usize = 100;

/// The trackers of a clip, both through the same frames.
#[derive(Debug, Clone)]
pub(crate) struct Trackers {
    pub(crate) tracks: Tracker,
    /// Follows the denser trajectories that the masks are made from.
    pub(crate) masks: Option<Tracker>,
    /// Whether other trajectories take the place of `tracks`, which are none then.
    pub(crate) is_given: bool,
}

impl Trackers {
    /// For frames of `size` pixels; trajectories are numbered from `first` on.
    pub(crate) fn new(first: u32, size: (usize, usize), params: &Params) -> Self {
        let masks = params.clip.dense.then(|| Tracker::new(size, &params.trajectory.for_masks()));
        Self { tracks: Tracker::numbering_from(first, size, &params.trajectory), masks, is_given: false }
    }

    fn each(&mut self) -> impl Iterator<Item = &mut Tracker> {
        (!self.is_given).then_some(&mut self.tracks).into_iter().chain(&mut self.masks)
    }

    /// Starts tracks in the present frame, which has this structure.
    pub(crate) fn seed(&mut self, structure: &Plane<f32>) {
        self.each().for_each(|tracker| tracker.seed(structure));
    }

    /// Goes on to the next frame.
    pub(crate) fn follow(&mut self, flow: &PairFlow) {
        self.each().for_each(|tracker| tracker.follow(&flow.forward, &flow.backward, &flow.variation));
    }

    /// Goes on to a window that begins `dropped` frames later. The past is for the affinities; masks are made without
    /// them.
    pub(crate) fn advance(&mut self, dropped: usize) {
        self.tracks.advance(dropped, REMEMBERED);
        self.masks.iter_mut().for_each(|tracker| tracker.advance(dropped, 0));
    }
}
