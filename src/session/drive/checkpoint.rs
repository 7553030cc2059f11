//! Where a long clip can go on in another process: what its next window needs of those before.
//!
//! Frames are not kept, but read again, and what depends on them alone is made again. What is kept are the trajectories
//! that go on into the next window, with their past, and which labels they bore.

use crate::Error;
use crate::flow::CompactFlow;
use crate::image::Frame;
use crate::session::jobs::{Forward, Seen};
use crate::session::run::{Clip, Phase, Session, Trackers};
use crate::session::window::{Identities, Plan, Thumbnail};
use crate::trajectory::TrackerState;
use serde::{Deserialize, Serialize};

/// Where the next window of a clip begins, with all that it needs but the frames; see [`Windows::resume`].
///
/// It can be written and read by `serde`, in a format that keeps every bit of an `f32`. It is for the same parameters,
/// the same frames, and the version of this crate that made it: with others its results mean nothing.
///
/// [`Windows::resume`]: super::Windows::resume
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Checkpoint {
    pub(crate) plan: Plan,
    /// The clip's number of the first frame that is needed.
    pub(crate) first: usize,
    /// How many frames the next window shares with those before, or the one that begins a shot.
    pub(crate) kept: usize,
    /// Whether one more frame was read.
    pub(crate) is_ahead: bool,
    pub(crate) carried: Carried,
}

impl Checkpoint {
    /// The number of the next window, from 0.
    pub fn window(&self) -> usize {
        self.plan.index
    }

    /// The clip's number of the first frame that is needed to go on.
    pub fn first_frame(&self) -> usize {
        self.first
    }

    /// How many frames of the clip are settled.
    pub fn settled(&self) -> usize {
        self.plan.first + self.plan.settled
    }
}

/// What a session carries from window to window.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Carried {
    overlap: usize,
    first_number: u32,
    identities: Identities,
    /// States of the tracker and, with dense masks, of the denser tracker.
    trackers: Option<(TrackerState, Option<TrackerState>)>,
}

impl Session {
    /// What goes along into the window at hand, before it is run.
    pub(crate) fn carried(&self) -> Option<Carried> {
        let Phase::Frames(clip) = &self.phase else { return None };
        let windows = clip.windows.as_ref()?;
        let states = |t: &Trackers| (t.tracks.state.clone(), t.masks.as_ref().map(|masks| masks.state.clone()));
        Some(Carried {
            overlap: windows.overlap,
            first_number: windows.first_number,
            identities: windows.identities.clone(),
            trackers: windows.trackers.as_ref().map(states),
        })
    }

    /// Takes the frames that a window begins with, and what goes along into it.
    pub(crate) fn go_on(&mut self, frames: Vec<Frame>, carried: Carried) -> Result<(), Error> {
        for frame in frames {
            self.push_frame(frame)?;
        }
        if let Phase::Frames(clip) = &mut self.phase {
            clip.go_on(carried);
        }
        Ok(())
    }
}

impl Clip {
    fn go_on(&mut self, carried: Carried) {
        self.flows = (1..carried.overlap).map(|t| self.flow_before(t)).collect();
        let trackers = carried.trackers.map(|(tracks, masks)| {
            let mut trackers = Trackers::new(carried.first_number, self.scale.working, &self.params);
            trackers.tracks.state = tracks;
            trackers.masks.iter_mut().zip(masks).for_each(|(tracker, state)| tracker.state = state);
            trackers
        });
        let last = self.frames.last().map(Thumbnail::new);
        let windows = self.windows.get_or_insert_default();
        (windows.last, windows.trackers, windows.overlap) = (last, trackers, carried.overlap);
        (windows.first_number, windows.identities) = (carried.first_number, carried.identities);
    }

    /// The flow that leads to frame `t`, as the window before had it.
    fn flow_before(&mut self, t: usize) -> CompactFlow {
        let settings = &self.params.for_flow();
        let [from, to] = [t - 1, t].map(|t| Seen::new(&self.frames[t], settings));
        CompactFlow::new(Forward::new(from, to, settings, &mut self.scratch).field())
    }
}
