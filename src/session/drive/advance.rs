//! Long clips, window by window: what goes along from one to the next.
//!
//! A window is a session's run over some frames. [`Session::advance`] then drops all frames but the last few, which the
//! next window begins with: their flow is known, trajectories go on through them, and by these the objects keep their
//! labels. A cut between shots ends a window, and nothing goes on through it. Memory is that of one window, however
//! long the clip is.

use crate::Error;
use crate::image::Frame;
use crate::session::base::{Outputs, Stage};
use crate::session::jobs::Ledger;
use crate::session::run::{Clip, Phase, Session, Trackers};
use crate::session::window::{Thumbnail, portraits, unmatched_share};

/// Frames before a window that trajectories remember.
const REMEMBERED: usize = 100;

impl Session {
    #[doc(hidden)]
    /// Adds the next frame of a clip that is taken window by window, unless it begins a new shot: then it is held back,
    /// the present window can take no more, and [`Session::advance`] begins the next one with it. Returns whether it
    /// was held back.
    ///
    /// # Errors
    /// As [`Session::push_frame`]; [`Error::State`] while another frame is held back.
    pub fn push_in_shot(&mut self, frame: Frame) -> Result<bool, Error> {
        if self.holds_frame() {
            return Err(Error::state(
                "a frame was pushed while one of the next shot is held back: run and advance first",
            ));
        }
        let clip = self.open_for(&frame)?;
        if clip.given.is_some() {
            return Err(Error::state("a frame was pushed in a shot after trajectories were set: use push_frame"));
        }
        clip.push_in_shot(&frame)
    }

    /// Whether a frame of the next shot is held back.
    pub(crate) fn holds_frame(&self) -> bool {
        self.clip().is_some_and(Clip::holds_frame)
    }

    /// Whether `frame` would be held back by [`Session::push_in_shot`].
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn begins_shot(&self, frame: &Frame) -> bool {
        self.clip().is_some_and(|clip| clip.begins_shot(frame))
    }

    #[doc(hidden)]
    /// Goes on to the next window. It begins with the last `overlap` frames of this one, or, if a frame of a new shot
    /// is held back, with that frame alone. Results of this window are dropped.
    ///
    /// # Errors
    /// [`Error::State`] unless frames came by [`Session::push_in_shot`] and all stages are done, or nothing but a held
    /// frame came since the last `advance`; [`Error::Param`] unless `overlap` is at least 1 and less than the number of
    /// frames. Nothing has changed then.
    pub fn advance(&mut self, overlap: usize) -> Result<(), Error> {
        if !self.is_window_over() {
            return Err(Error::state(
                "advance was called before frames were pushed in shots and the window was run to its end",
            ));
        }
        let frames = self.num_frames();
        if !self.holds_frame() && !(1..frames).contains(&overlap) {
            let expected = format!("a whole number of frames, 1..={}", frames - 1);
            return Err(Error::Param { name: "overlap".to_owned(), value: overlap.to_string(), expected });
        }
        self.epoch = self.epoch.wrapping_add(1);
        self.phase = match std::mem::take(&mut self.phase) {
            Phase::Begun(mut run) => {
                remember_objects(&mut run.clip, &run.outputs, overlap);
                Phase::Frames(Box::new(run.clip))
            }
            phase => phase,
        };
        if let Phase::Frames(clip) = &mut self.phase {
            clip.advance(overlap);
            clip.ledger = Ledger::new(self.epoch);
        }
        Ok(())
    }

    /// Whether all of the present window is seen to its end.
    fn is_window_over(&self) -> bool {
        match &self.phase {
            Phase::Begun(run) => run.clip.windows.is_some() && run.is_past(Stage::Masks),
            Phase::Frames(clip) => clip.is_seen(),
            Phase::Empty => false,
        }
    }
}

/// Takes note of which trajectories bear which labels.
fn remember_objects(clip: &mut Clip, outputs: &Outputs, overlap: usize) {
    let dropped = clip.dropped_by(overlap);
    if let (Some(windows), false) = (&mut clip.windows, outputs.masks.is_empty()) {
        let (tracked, label, objects) = (&outputs.tracked, &outputs.clusters.label, &outputs.cut.objects);
        let looks = portraits(&tracked.tracks, label, objects, &clip.frames);
        windows.identities.advance(objects, &tracked.tracks, label, &tracked.numbers, dropped, &looks);
    }
}

impl Clip {
    /// The same, unless the frame begins a new shot: then it is held back. Returns whether it was.
    fn push_in_shot(&mut self, frame: &Frame) -> Result<bool, Error> {
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
    fn begins_shot(&self, frame: &Frame) -> bool {
        self.accepted(frame).is_ok_and(|frame| self.is_cut_before(&Thumbnail::new(&frame)))
    }

    fn is_cut_before(&self, next: &Thumbnail) -> bool {
        let bound = self.params.shot.max_unmatched;
        let last = self.windows.as_ref().and_then(|windows| windows.last.as_ref());
        last.is_some_and(|last| bound < 1.0 && unmatched_share(last, next) > bound)
    }

    fn holds_frame(&self) -> bool {
        self.windows.as_ref().is_some_and(|w| w.held.is_some())
    }

    /// Whether these are all frames of a window that was seen to its end already: the frame after it begins a new shot.
    fn is_seen(&self) -> bool {
        self.windows.as_ref().is_some_and(|w| w.held.is_some() && w.overlap > 0 && w.overlap == self.frames.len())
    }

    /// Drops all frames but the last `overlap`, or, if a frame of a new shot is held back, all of them.
    fn advance(&mut self, overlap: usize) {
        let dropped = self.dropped_by(overlap);
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
    fn dropped_by(&self, overlap: usize) -> usize {
        if self.holds_frame() { self.frames.len() } else { self.frames.len() - overlap }
    }
}

impl Trackers {
    /// Goes on to a window that begins `dropped` frames later. The past is for the affinities; masks are made without
    /// them.
    fn advance(&mut self, dropped: usize) {
        self.tracks.advance(dropped, REMEMBERED);
        self.masks.iter_mut().for_each(|tracker| tracker.advance(dropped, 0));
    }
}
