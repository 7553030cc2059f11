//! Long clips, window by window: what goes along from one to the next.
//!
//! A window is a session's run over some frames. [`Session::advance`] then drops all frames but the last few, which the next window
//! begins with: their flow is known, trajectories go on through them, and by these the objects keep their labels. A cut between shots
//! ends a window, and nothing goes on through it. Memory is that of one window, however long the clip is.

use super::motion::Trackers;
use super::session::{Session, State, state_error};
use crate::Error;
use crate::identity::Identities;
use crate::image::Frame;
use crate::shot::{Thumbnail, unmatched_share};
use crate::trajectory::Trajectories;

/// What a clip that is taken window by window carries along.
#[derive(Debug, Default)]
pub(super) struct Windows {
    /// The last frame pushed, to compare the next one with.
    last: Option<Thumbnail>,
    /// A frame of the next shot, at working size.
    held: Option<Frame>,
    /// The trackers after the present window.
    pub(super) trackers: Option<Trackers>,
    /// How many frames were in the window before too.
    pub(super) overlap: usize,
    /// The number of the first trajectory that starts in this shot.
    pub(super) first_number: u32,
    pub(super) identities: Identities,
}

impl Session {
    /// Adds the next frame of a clip that is taken window by window, unless it begins a new shot: then it is held back, the present
    /// window can take no more, and [`Session::advance`] begins the next one with it. Gives whether it was held back.
    ///
    /// # Errors
    /// As [`Session::push_frame`]; [`Error::State`] while another frame is held back.
    pub fn push_in_shot(&mut self, frame: Frame) -> Result<bool, Error> {
        if self.windows.as_ref().is_some_and(|w| w.held.is_some()) {
            return Err(state_error(
                "a frame was pushed while one of the next shot is held back: run and advance first",
            ));
        }
        let mut windows = self.windows.take().unwrap_or_default();
        let outcome = self.take_in_shot(frame, &mut windows);
        self.windows = Some(windows);
        outcome
    }

    fn take_in_shot(&mut self, frame: Frame, windows: &mut Windows) -> Result<bool, Error> {
        let frame = self.accepted(frame)?;
        let thumbnail = Thumbnail::new(&frame);
        let bound = self.params.shot.unmatched;
        let is_cut = windows.last.as_ref().is_some_and(|last| bound < 1.0 && unmatched_share(last, &thumbnail) > bound);
        windows.last = Some(thumbnail);
        if is_cut {
            windows.held = Some(frame);
        } else {
            self.frames.push(frame);
        }
        Ok(is_cut)
    }

    /// Whether a frame of the next shot is held back.
    pub fn holds_frame(&self) -> bool {
        self.windows.as_ref().is_some_and(|w| w.held.is_some())
    }

    /// Goes on to the next window. It begins with the last `overlap` frames of this one, or, if a frame of a new shot is held back, with
    /// that frame alone. Results of this window are dropped.
    ///
    /// # Errors
    /// [`Error::State`] unless frames came by [`Session::push_in_shot`] and all stages are done, or nothing but a held frame came since the
    /// last `advance`; [`Error::Param`] unless `overlap` is at least 1 and less than the number of frames. Nothing has changed then.
    pub fn advance(&mut self, overlap: usize) -> Result<(), Error> {
        // Where the frame after a full window begins a new shot, the frames kept of that window have been seen to the end already.
        let (done, kept) = (matches!(self.state, State::Done), self.frames.len());
        let ready = |w: &mut Box<Windows>| done || (w.held.is_some() && w.overlap > 0 && w.overlap == kept);
        let Some(mut windows) = self.windows.take_if(ready) else {
            return Err(state_error(
                "advance was called before frames were pushed in shots and the window was run to its end",
            ));
        };
        let begins_shot = windows.held.is_some();
        let legal = 1..self.frames.len();
        if !begins_shot && !legal.contains(&overlap) {
            self.windows = Some(windows);
            let expected = format!("a whole number of frames, 1..={}", self.frames.len() - 1);
            return Err(Error::Param { name: "overlap".to_owned(), value: overlap.to_string(), expected });
        }
        let dropped = if begins_shot { self.frames.len() } else { self.frames.len() - overlap };
        if let (Some(objects), Some(tracks), Some(clusters)) = (self.objects(), &self.working, &self.clusters) {
            windows.identities.advance(objects, tracks, &clusters.label, &self.numbers, dropped);
        }
        let mut next = Self::new(self.params.clone())?;
        next.scale = self.scale;
        if let Some(first) = windows.held.take() {
            windows.first_number = windows.trackers.take().map_or(windows.first_number, |t| t.tracks.next_number());
            windows.overlap = 0;
            next.frames.push(first);
        } else {
            windows.overlap = overlap;
            windows.trackers.iter_mut().for_each(|trackers| trackers.advance(dropped));
            next.frames = self.frames.split_off(dropped);
            next.flows = self.flows.split_off(dropped);
        }
        next.windows = Some(windows);
        *self = next;
        Ok(())
    }

    /// The clip-wide number of each trajectory: one that lives on into the next window keeps it.
    pub fn trajectory_numbers(&self) -> &[u32] {
        &self.numbers
    }

    /// Trackers for the present window, and how many frames they have seen.
    pub(super) fn trackers(&mut self) -> (Trackers, usize) {
        let size = self.scale.map_or((1, 1), |scale| scale.working);
        let fresh = |first| (Trackers::new(first, size, &self.params), 0);
        match &mut self.windows {
            None => fresh(0),
            Some(windows) => match windows.trackers.take() {
                Some(trackers) => (trackers, windows.overlap),
                None => fresh(windows.first_number),
            },
        }
    }

    /// A shot of a single frame has no motion, and so no trajectories.
    pub(super) fn is_lone_frame(&self) -> bool {
        self.windows.is_some() && self.frames.len() == 1 && self.flows.is_empty()
    }

    /// No trajectories at all.
    pub(super) fn lone_frame_tracks(&self) -> Trajectories {
        Trajectories::empty(1, self.scale.map_or((1, 1), |scale| scale.working))
    }
}
