//! The clip that a session runs on: frames at working size, their flow, and what goes along from window to window.

use super::trackers::Trackers;
use crate::Error;
use crate::flow::{CompactFlow, FlowScratch};
use crate::image::Frame;
use crate::session::base::Scale;
use crate::session::base::ScaledParams;
use crate::session::base::Tracked;
use crate::session::jobs::Ledger;
use crate::session::window::{Identities, Thumbnail, unmatched_share};
use crate::trajectory::Trajectories;

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
    /// Where the clip is taken window by window.
    pub(crate) windows: Option<Box<Windows>>,
}

/// What a clip that is taken window by window carries along.
#[derive(Debug, Clone, Default)]
pub(crate) struct Windows {
    /// The last frame pushed, to compare the next one with.
    pub(crate) last: Option<Thumbnail>,
    /// A frame of the next shot, at working size.
    held: Option<Frame>,
    /// The trackers after the present window.
    pub(crate) trackers: Option<Trackers>,
    /// How many frames were in the window before too.
    pub(crate) overlap: usize,
    /// The number of the first trajectory that starts in this shot.
    pub(crate) first_number: u32,
    pub(crate) identities: Identities,
}

impl Clip {
    /// No frames yet.
    pub(crate) fn new(scale: Scale, params: ScaledParams) -> Self {
        Self {
            params,
            scale,
            frames: Vec::new(),
            given: None,
            flows: Vec::new(),
            scratch: FlowScratch::default(),
            ledger: Ledger::default(),
            windows: None,
        }
    }

    /// The frame at working size, if it can be added.
    fn accepted(&self, frame: &Frame) -> Result<Frame, Error> {
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

    /// The same, unless the frame begins a new shot: then it is held back. Returns whether it was.
    pub(crate) fn push_in_shot(&mut self, frame: &Frame) -> Result<bool, Error> {
        let frame = self.accepted(frame)?;
        let thumbnail = Thumbnail::new(&frame);
        let is_cut = self.is_cut_before(&thumbnail);
        let windows = self.windows.get_or_insert_default();
        windows.last = Some(thumbnail);
        if is_cut {
            windows.held = Some(frame);
        } else {
            self.frames.push(frame);
        }
        Ok(is_cut)
    }

    /// Whether `frame`, of whatever size, looks nothing like the last one.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn begins_shot(&self, frame: &Frame) -> bool {
        self.accepted(frame).is_ok_and(|frame| self.is_cut_before(&Thumbnail::new(&frame)))
    }

    fn is_cut_before(&self, next: &Thumbnail) -> bool {
        let bound = self.params.shot.unmatched;
        let last = self.windows.as_ref().and_then(|windows| windows.last.as_ref());
        last.is_some_and(|last| bound < 1.0 && unmatched_share(last, next) > bound)
    }

    pub(crate) fn holds_frame(&self) -> bool {
        self.windows.as_ref().is_some_and(|w| w.held.is_some())
    }

    /// Whether these are all frames of a window that was seen to its end already: the frame after it begins a new shot.
    pub(crate) fn is_seen(&self) -> bool {
        self.windows.as_ref().is_some_and(|w| w.held.is_some() && w.overlap > 0 && w.overlap == self.frames.len())
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

    /// Keeps the trackers for the next window, if there can be one.
    pub(crate) fn keep(&mut self, trackers: Trackers) {
        if let Some(windows) = &mut self.windows {
            windows.trackers = Some(trackers);
        }
    }

    /// Drops all frames but the last `overlap`, or, if a frame of a new shot is held back, all of them.
    pub(crate) fn advance(&mut self, overlap: usize) {
        let dropped = self.dropped_by(overlap);
        self.ledger = Ledger::default();
        let Some(windows) = &mut self.windows else { return };
        if let Some(first) = windows.held.take() {
            windows.first_number = windows.trackers.take().map_or(windows.first_number, |t| t.tracks.next_number());
            windows.overlap = 0;
            windows.identities.forget_looks();
            self.frames = vec![first];
            self.flows = Vec::new();
        } else {
            windows.overlap = overlap;
            windows.trackers.iter_mut().for_each(|trackers| trackers.advance(dropped));
            self.frames = self.frames.split_off(dropped);
            self.flows = self.flows.split_off(dropped);
        }
    }

    /// How many frames [`Clip::advance`] drops.
    pub(crate) fn dropped_by(&self, overlap: usize) -> usize {
        if self.holds_frame() { self.frames.len() } else { self.frames.len() - overlap }
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
