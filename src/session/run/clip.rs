//! The clip of a session: frames at working size, their flow, and the state carried from window to window.

use crate::Error;
use crate::flow::{CompactFlow, FlowScratch};
use crate::image::Frame;
use crate::saliency::SaliencyMaps;
use crate::session::base::{Params, Scale, ScaledParams, TrackSet};
use crate::session::jobs::{Job, JobInput, JobKind, PendingJobs};
use crate::session::window::{Identities, Thumbnail};
use crate::trajectory::Tracker;

/// The input of a run.
#[derive(Debug, Clone)]
pub(crate) struct Clip {
    pub(crate) params: ScaledParams,
    pub(crate) scale: Scale,
    /// The frames at working size; there may be none with trajectories of another tracker.
    pub(crate) frames: Vec<Frame>,
    /// Trajectories of another tracker, until the run takes them.
    pub(crate) external: Option<Box<TrackSet>>,
    /// The flow of each frame pair computed so far.
    pub(crate) flows: Vec<CompactFlow>,
    /// The dominant motions of all flow fields, once they are known, until the saliency takes them.
    pub(crate) saliency_maps: Option<SaliencyMaps>,
    /// Working memory of the flow.
    pub(crate) scratch: FlowScratch,
    pub(crate) pending_jobs: PendingJobs,
    /// `None` unless the clip is processed window by window.
    pub(crate) windows: Option<Box<WindowState>>,
}

/// The state that a clip carries from window to window.
#[derive(Debug, Clone, Default)]
pub(crate) struct WindowState {
    /// The last frame pushed, to compare the next one with.
    pub(crate) last_thumbnail: Option<Thumbnail>,
    /// The first frame of the next shot, at working size.
    pub(crate) next_shot: Option<Frame>,
    /// The trackers after the present window.
    pub(crate) trackers: Option<Trackers>,
    /// Number of frames shared with the previous window.
    pub(crate) overlap: usize,
    /// The number of the first trajectory that starts in this shot.
    pub(crate) first_number: u32,
    pub(crate) identities: Identities,
}

impl Clip {
    /// Creates a clip without frames; its jobs belong to `epoch`.
    pub(crate) fn new(scale: Scale, params: ScaledParams, epoch: u32) -> Self {
        Self {
            params,
            scale,
            frames: Vec::new(),
            external: None,
            flows: Vec::new(),
            saliency_maps: None,
            scratch: FlowScratch::default(),
            pending_jobs: PendingJobs::new(epoch),
            windows: None,
        }
    }

    /// Returns a new frame at working size, or an error if it cannot be added.
    pub(crate) fn resize_frame(&self, frame: &Frame) -> Result<Frame, Error> {
        let (actual, Scale { input, working }) = ((frame.width(), frame.height()), self.scale);
        if input != actual {
            return Err(Error::FrameSizeChanged { index: self.frames.len(), expected: input, actual });
        }
        self.params.clip.check_frames(self.frames.len() + 1)?;
        Ok(frame.resized(working.0, working.1))
    }

    /// Hands out the unassigned superpixels of a frame.
    pub(crate) fn take_superpixel_job(&mut self) -> Option<Job> {
        let frames = 0..if self.params.clip.dense { self.frames.len() } else { 0 };
        let id = self.pending_jobs.assign(JobKind::Superpixels, frames)?;
        Some(Job { id, input: JobInput::Superpixels(self.frames[id.index as usize].clone()) })
    }

    /// Finds the dominant motions of the flow fields so far.
    pub(crate) fn dominant_motions(&self) -> SaliencyMaps {
        let mut maps = SaliencyMaps::new(&self.params.saliency);
        self.flows.iter().for_each(|flow| maps.add_field(flow));
        maps
    }

    /// Returns whether the clip is a shot of a single frame, which has no motion and so no trajectories.
    pub(crate) fn is_single_frame_shot(&self) -> bool {
        self.windows.is_some() && self.frames.len() == 1 && self.flows.is_empty()
    }
}

/// The trackers of a clip, both through the same frames.
#[derive(Debug, Clone)]
pub(crate) struct Trackers {
    pub(crate) tracks: Tracker,
    /// Follows the denser trajectories that masks are made from.
    pub(crate) masks: Option<Tracker>,
    /// True if trajectories of another tracker are used; then `tracks` has none.
    pub(crate) has_external: bool,
}

impl Trackers {
    /// Creates trackers for frames of `size` pixels; trajectories are numbered from `first` on.
    pub(crate) fn new(first: u32, size: (usize, usize), params: &Params) -> Self {
        let masks = params.clip.dense.then(|| Tracker::new(size, &params.trajectory.for_masks()));
        let mut tracks = Tracker::new(size, &params.trajectory);
        tracks.state.next_number = first;
        Self { tracks, masks, has_external: false }
    }
}
