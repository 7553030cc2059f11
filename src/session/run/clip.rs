//! The clip that a session runs on: frames at working size, their flow, and what goes along from window to window.

use crate::Error;
use crate::flow::{CompactFlow, FlowScratch};
use crate::image::Frame;
use crate::session::base::{Params, Scale, ScaledParams, Tracked};
use crate::session::jobs::Ledger;
use crate::session::window::{Identities, Thumbnail};
use crate::trajectory::Tracker;

/// What a run works on.
#[derive(Debug, Clone)]
pub(crate) struct Clip {
    pub(crate) params: ScaledParams,
    pub(crate) scale: Scale,
    /// The frames at working size; there may be none where trajectories come from outside.
    pub(crate) frames: Vec<Frame>,
    /// Trajectories from outside, until the run takes them.
    pub(crate) given: Option<Box<Tracked>>,
    /// The flow of each pair of them, as far as it is known.
    pub(crate) flows: Vec<CompactFlow>,
    /// Working memory of the flow.
    pub(crate) scratch: FlowScratch,
    /// What of the work on them is given away, or back.
    pub(crate) ledger: Ledger,
    /// `None` unless the clip is taken window by window.
    pub(crate) windows: Option<Box<WindowState>>,
}

/// What a clip that is taken window by window carries along.
#[derive(Debug, Clone, Default)]
pub(crate) struct WindowState {
    /// The last frame pushed, to compare the next one with.
    pub(crate) last: Option<Thumbnail>,
    /// A frame of the next shot, at working size.
    pub(crate) held: Option<Frame>,
    /// The trackers after the present window.
    pub(crate) trackers: Option<Trackers>,
    /// How many frames were in the window before too.
    pub(crate) overlap: usize,
    /// The number of the first trajectory that starts in this shot.
    pub(crate) first_number: u32,
    pub(crate) identities: Identities,
}

impl Clip {
    /// No frames yet; pieces are given away under `epoch`.
    pub(crate) fn new(scale: Scale, params: ScaledParams, epoch: u32) -> Self {
        Self {
            params,
            scale,
            frames: Vec::new(),
            given: None,
            flows: Vec::new(),
            scratch: FlowScratch::default(),
            ledger: Ledger::new(epoch),
            windows: None,
        }
    }

    /// The frame at working size, if it can be added.
    pub(crate) fn accepted(&self, frame: &Frame) -> Result<Frame, Error> {
        let (actual, Scale { input, working }) = ((frame.width(), frame.height()), self.scale);
        if input != actual {
            return Err(Error::FrameSizeChanged { index: self.frames.len(), expected: input, actual });
        }
        self.params.clip.check_frames(self.frames.len() + 1)?;
        Ok(frame.resized(working.0, working.1))
    }

    /// A shot of a single frame has no motion, and so no trajectories.
    pub(crate) fn is_lone_frame(&self) -> bool {
        self.windows.is_some() && self.frames.len() == 1 && self.flows.is_empty()
    }
}

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
        let mut tracks = Tracker::new(size, &params.trajectory);
        tracks.state.next_number = first;
        Self { tracks, masks, is_given: false }
    }
}
