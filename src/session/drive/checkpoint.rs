//! Checkpoints: the state from which another process can resume a long clip at a window.
//!
//! A checkpoint keeps the trajectories that continue into the next window, with their past, and their labels. Frames are
//! read again, and flow is computed again.

use crate::Error;
use crate::flow::CompactFlow;
use crate::image::Frame;
use crate::session::jobs::{FlowFrame, ForwardFlow};
use crate::session::run::{Clip, Phase, Session, Trackers};
use crate::session::window::{Identities, Thumbnail, WindowPlan};
use crate::trajectory::TrackerState;
use serde::{Deserialize, Serialize};

/// The state of a clip between two windows, without the frames; see [`Windows::resume`].
///
/// It can be written and read by `serde` in a format that keeps every bit of an `f32`. It is valid only with the same
/// parameters, the same frames and the same version of this crate.
///
/// [`Windows::resume`]: super::Windows::resume
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Checkpoint {
    pub(super) plan: WindowPlan,
    /// The clip's number of the first frame needed.
    pub(super) first: usize,
    /// Number of frames to read again: those shared with the previous window, or the one that begins a shot.
    pub(super) overlap: usize,
    /// True if one more frame was read.
    pub(super) has_lookahead: bool,
    pub(super) handover: Handover,
}

impl Checkpoint {
    /// Returns the number of the next window, from 0.
    #[doc(hidden)] // For the command line.
    pub fn window(&self) -> usize {
        self.plan.index
    }

    /// Returns the clip's number of the first frame needed to resume.
    pub fn first_frame(&self) -> usize {
        self.first
    }

    /// Returns the number of frames of the clip whose masks are final.
    pub fn settled(&self) -> usize {
        self.plan.first + self.plan.settled
    }
}

/// The state that a session carries from window to window.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Handover {
    overlap: usize,
    first_number: u32,
    identities: Identities,
    /// The states of both trackers; the second is `None` without masks.
    trackers: Option<(TrackerState, Option<TrackerState>)>,
}

impl Session {
    /// Returns the state carried into the present window, before it is run.
    pub(super) fn handover(&self) -> Option<Handover> {
        let Phase::Frames(clip) = &self.phase else { return None };
        let windows = clip.windows.as_ref()?;
        let state = |t: &Trackers| (t.tracks.state.clone(), t.masks.as_ref().map(|masks| masks.state.clone()));
        Some(Handover {
            overlap: windows.overlap,
            first_number: windows.first_number,
            identities: windows.identities.clone(),
            trackers: windows.trackers.as_ref().map(state),
        })
    }

    /// Restores a window from its first frames and the state carried into it.
    pub(super) fn resume(&mut self, frames: Vec<Frame>, handover: Handover) -> Result<(), Error> {
        for frame in frames {
            self.push_frame(frame)?;
        }
        if let Phase::Frames(clip) = &mut self.phase {
            clip.resume(handover);
        }
        Ok(())
    }
}

impl Clip {
    fn resume(&mut self, handover: Handover) {
        self.flows = (1..handover.overlap).map(|t| self.flow_to(t)).collect();
        let trackers = handover.trackers.map(|(tracks, masks)| {
            let mut trackers = Trackers::new(handover.first_number, self.scale.working, &self.params);
            trackers.tracks.state = tracks;
            trackers.masks.iter_mut().zip(masks).for_each(|(tracker, state)| tracker.state = state);
            trackers
        });
        let last_thumbnail = self.frames.last().map(Thumbnail::new);
        let windows = self.windows.get_or_insert_default();
        (windows.last_thumbnail, windows.trackers, windows.overlap) = (last_thumbnail, trackers, handover.overlap);
        (windows.first_number, windows.identities) = (handover.first_number, handover.identities);
    }

    /// Computes the flow to frame `t`, as the previous window did.
    fn flow_to(&mut self, t: usize) -> CompactFlow {
        let settings = &self.params.for_flow();
        let [from, to] = [t - 1, t].map(|t| FlowFrame::new(&self.frames[t], settings));
        CompactFlow::new(ForwardFlow::new(from, to, settings, &mut self.scratch).field())
    }
}
