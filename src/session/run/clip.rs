//! The clip that a session runs on: frames at working size, their flow, and what goes along from window to window.

use crate::Error;
use crate::flow::{CompactFlow, FlowScratch};
use crate::image::{Frame, Plane};
use crate::session::base::{Params, Scale, ScaledParams, Tracked};
use crate::session::jobs::{Ledger, PairFlow};
use crate::session::window::{Identities, Thumbnail};
use crate::trajectory::{Tracker, Trajectories};

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

    pub(crate) fn push(&mut self, frame: &Frame) -> Result<(), Error> {
        let frame = self.accepted(frame)?;
        self.frames.push(frame);
        Ok(())
    }

    /// A shot of a single frame has no motion, and so no trajectories.
    pub(crate) fn is_lone_frame(&self) -> bool {
        self.windows.is_some() && self.frames.len() == 1 && self.flows.is_empty()
    }

    /// Takes trajectories from outside beside the frames.
    pub(crate) fn give(&mut self, tracked: Box<Tracked>) -> Result<(), Error> {
        let (size, (width, height)) = (tracked.input.size, self.scale.input);
        if self.windows.is_some() {
            return Err(Error::state("trajectories were set in a clip that is taken window by window"));
        }
        if size != self.scale.input {
            let reason =
                format!("trajectories of {}x{} pixels (expected {width}x{height}, as the frames)", size.0, size.1);
            return Err(Error::Data { reason });
        }
        self.given = Some(tracked);
        Ok(())
    }

    /// Checks that there are enough frames for a run, and that trajectories from outside lie in them.
    pub(crate) fn check(&self) -> Result<(), Error> {
        if let Some(given) = &self.given {
            return if self.frames.is_empty() { Ok(()) } else { fits(&given.input, self.frames.len()) };
        }
        let needed = (self.windows.as_ref().map_or(0, |w| w.overlap) + 1).max(2);
        match self.frames.len() {
            got if got < needed && !self.is_lone_frame() => Err(Error::TooFewFrames { got, needed }),
            _ => Ok(()),
        }
    }

    /// Trackers for the present window, and how many frames they have seen.
    pub(crate) fn trackers(&mut self) -> (Trackers, usize) {
        let fresh = |first| (Trackers::new(first, self.scale.working, &self.params), 0);
        match &mut self.windows {
            None => fresh(0),
            Some(windows) => match windows.trackers.take() {
                Some(trackers) => (trackers, windows.overlap),
                None => fresh(windows.first_number),
            },
        }
    }
}

/// Checks that trajectories have this number of frames, and that their points lie in them.
fn fits(tracks: &Trajectories, frames: usize) -> Result<(), Error> {
    let reason = if tracks.num_frames == frames {
        let (width, height) = tracks.size;
        let Some((name, p, v, side)) = stray("x", &tracks.x, width).or_else(|| stray("y", &tracks.y, height)) else {
            return Ok(());
        };
        format!("{name}[{p}] = {v} (expected a place in the frame, -0.5..={})", side - 0.5)
    } else {
        format!("trajectories of {} frames with {frames} frames pushed (expected as many)", tracks.num_frames)
    };
    Err(Error::Data { reason })
}

/// The first coordinate that lies beyond the frame: its name, number and value, and the side of the frame.
#[inline(never)]
fn stray(name: &'static str, values: &[f32], side: usize) -> Option<(&'static str, usize, f64, f64)> {
    let side = side as f64;
    let mut numbered = values.iter().map(|&v| f64::from(v)).enumerate();
    numbered.find(|&(_, v)| v < -0.5 || v > side - 0.5).map(|(p, v)| (name, p, v, side))
}

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
