//! Sessions that process a long clip window by window.
//!
//! A window is a run over some frames. [`Session::advance`] then drops all frames but the last few, with which the next
//! window begins: their flow is known, trajectories continue through them, and so objects keep their labels. A cut between
//! shots ends a window and all trajectories. Memory depends on one window, not on the clip.

use crate::Error;
use crate::image::Frame;
use crate::session::base::{Outputs, Stage};
use crate::session::jobs::PendingJobs;
use crate::session::run::{Clip, Phase, Session, Trackers};
use crate::session::window::{NumberedTracks, Thumbnail, object_appearances, unmatched_share};

/// Number of frames before a window whose points trajectories keep; chosen by eye.
const PAST_FRAMES: usize = 100;

impl Session {
    #[doc(hidden)]
    /// Adds the next frame of a clip that is processed window by window. Returns true if it begins a new shot: then it is
    /// held back, the present window accepts no more frames, and [`Session::advance`] begins the next one with it.
    ///
    /// # Errors
    /// As [`Session::push_frame`]; [`Error::State`] while another frame is held back.
    pub fn push_in_shot(&mut self, frame: Frame) -> Result<bool, Error> {
        if self.holds_next_shot() {
            return Err(Error::state(
                "a frame was pushed after the shot had ended: run the session and advance it first",
            ));
        }
        let clip = self.open_for(&frame)?;
        if clip.external.is_some() {
            return Err(Error::state("a frame was pushed in a shot after trajectories were set: use push_frame"));
        }
        clip.push_in_shot(&frame)
    }

    /// Returns whether the first frame of the next shot is held back.
    pub(crate) fn holds_next_shot(&self) -> bool {
        self.clip().is_some_and(Clip::holds_next_shot)
    }

    /// Returns whether `frame` would be held back by [`Session::push_in_shot`].
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn begins_shot(&self, frame: &Frame) -> bool {
        self.clip().is_some_and(|clip| clip.begins_shot(frame))
    }

    #[doc(hidden)]
    /// Advances to the next window and drops the results of this one. The next window begins with the last `overlap` frames
    /// of this one, or with the frame of a new shot that is held back.
    ///
    /// # Errors
    /// [`Error::State`] unless frames were added by [`Session::push_in_shot`] and all stages are done, or nothing but the
    /// first frame of a shot was added since the last `advance`; [`Error::Param`] unless `overlap` is at least 1 and less
    /// than the number of frames. Nothing changes then.
    pub fn advance(&mut self, overlap: usize) -> Result<(), Error> {
        if !self.is_window_over() {
            return Err(Error::state(
                "advance was called before frames were pushed in shots and the window was run to its end",
            ));
        }
        let frames = self.num_frames();
        if !self.holds_next_shot() && !(1..frames).contains(&overlap) {
            let expected = format!("a whole number of frames, 1..={}", frames - 1);
            return Err(Error::Param { name: "overlap".to_owned(), value: overlap.to_string(), expected });
        }
        self.epoch = self.epoch.wrapping_add(1);
        self.phase = match std::mem::take(&mut self.phase) {
            Phase::Running(mut run) => {
                store_identities(&mut run.clip, &run.outputs, overlap);
                run.clip.params = self.params.scaled_to(run.clip.scale.working);
                Phase::Frames(Box::new(run.clip))
            }
            phase => phase,
        };
        if let Phase::Frames(clip) = &mut self.phase {
            clip.advance(overlap);
            clip.pending_jobs = PendingJobs::new(self.epoch);
        }
        Ok(())
    }

    /// Returns whether all stages of the present window are done.
    fn is_window_over(&self) -> bool {
        match &self.phase {
            Phase::Running(run) => run.clip.windows.is_some() && run.is_past(Stage::Masks),
            Phase::Frames(clip) => clip.is_shot_over(),
            Phase::Empty => false,
        }
    }
}

/// Stores the labels of trajectories and the appearances of objects for the next window.
fn store_identities(clip: &mut Clip, outputs: &Outputs, overlap: usize) {
    let num_dropped = clip.num_dropped(overlap);
    if let (Some(windows), false) = (&mut clip.windows, outputs.masks.is_empty()) {
        let (track_set, label, objects) = (&outputs.track_set, &outputs.clusters.label, &outputs.cut.objects);
        let appearances = object_appearances(&track_set.tracks, label, objects, &clip.frames);
        let labelled = NumberedTracks { tracks: &track_set.tracks, label, number: &track_set.numbers };
        windows.identities.advance(objects, labelled, num_dropped, &appearances);
    }
}

impl Clip {
    /// Adds a frame, or holds it back if it begins a new shot. Returns whether it does.
    fn push_in_shot(&mut self, frame: &Frame) -> Result<bool, Error> {
        let frame = self.resize_frame(frame)?;
        let thumbnail = Thumbnail::new(&frame);
        let is_cut = self.is_cut_to(&thumbnail);
        let windows = self.windows.get_or_insert_default();
        windows.last_thumbnail = Some(thumbnail);
        if is_cut {
            windows.next_shot = Some(frame);
        } else {
            self.frames.push(frame);
        }
        Ok(is_cut)
    }

    /// Returns whether there is a cut between the last frame and `frame`, which may have any size.
    #[cfg(not(target_arch = "wasm32"))]
    fn begins_shot(&self, frame: &Frame) -> bool {
        self.resize_frame(frame).is_ok_and(|frame| self.is_cut_to(&Thumbnail::new(&frame)))
    }

    fn is_cut_to(&self, next: &Thumbnail) -> bool {
        let bound = self.params.shot.max_unmatched;
        let last = self.windows.as_ref().and_then(|windows| windows.last_thumbnail.as_ref());
        last.is_some_and(|last| bound < 1.0 && unmatched_share(last, next) > bound)
    }

    fn holds_next_shot(&self) -> bool {
        self.windows.as_ref().is_some_and(|w| w.next_shot.is_some())
    }

    /// Returns whether the frames were all in the previous window and the next one begins a new shot.
    fn is_shot_over(&self) -> bool {
        self.windows.as_ref().is_some_and(|w| w.next_shot.is_some() && w.overlap > 0 && w.overlap == self.frames.len())
    }

    /// Drops all frames but the last `overlap`, or all of them if a new shot begins.
    fn advance(&mut self, overlap: usize) {
        let num_dropped = self.num_dropped(overlap);
        let Some(windows) = &mut self.windows else { return };
        if let Some(first) = windows.next_shot.take() {
            windows.first_number = windows.trackers.take().map_or(windows.first_number, |t| t.tracks.state.next_number);
            windows.overlap = 0;
            windows.identities.forget_appearances();
            self.frames = vec![first];
            self.flows = Vec::new();
        } else {
            windows.overlap = overlap;
            windows.trackers.iter_mut().for_each(|trackers| trackers.advance(num_dropped));
            self.frames = self.frames.split_off(num_dropped);
            self.flows = self.flows.split_off(num_dropped);
        }
    }

    /// Returns the number of frames that [`Clip::advance`] drops.
    fn num_dropped(&self, overlap: usize) -> usize {
        if self.holds_next_shot() { self.frames.len() } else { self.frames.len() - overlap }
    }
}

impl Trackers {
    /// Advances to a window that begins `num_dropped` frames later. Only affinities use points from before the window.
    fn advance(&mut self, num_dropped: usize) {
        self.tracks.advance(num_dropped, PAST_FRAMES);
        self.masks.iter_mut().for_each(|tracker| tracker.advance(num_dropped, 0));
    }
}
