//! Long clips, window by window: what goes along from one to the next.
//!
//! A window is a session's run over some frames. [`Session::advance`] then drops all frames but the last few, which the
//! next window begins with: their flow is known, trajectories go on through them, and by these the objects keep their
//! labels. A cut between shots ends a window, and nothing goes on through it. Memory is that of one window, however
//! long the clip is.

use crate::Error;
use crate::image::Frame;
use crate::session::base::Found;
use crate::session::run::Clip;
use crate::session::run::{Phase, Session};
use crate::session::window::portraits;

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
            Phase::Begun(mut clip, state) => {
                remember_objects(&mut clip, &state.found(), overlap);
                clip.advance(overlap);
                Phase::Frames(clip)
            }
            Phase::Frames(mut clip) => {
                clip.advance(overlap);
                Phase::Frames(clip)
            }
            other => other,
        };
        Ok(())
    }

    /// Whether all of the present window is seen to its end.
    fn is_window_over(&self) -> bool {
        match &self.phase {
            Phase::Begun(clip, state) => clip.windows.is_some() && state.is_done(),
            Phase::Frames(clip) => clip.is_seen(),
            Phase::Empty => false,
        }
    }

    /// The clip-wide number of each trajectory: one that lives on into the next window keeps it.
    pub fn trajectory_numbers(&self) -> &[u32] {
        self.found().tracked.map_or(&[], |tracked| &tracked.numbers)
    }
}

/// Takes note of which trajectories bear which labels.
fn remember_objects(clip: &mut Clip, found: &Found<'_>, overlap: usize) {
    let dropped = clip.dropped_by(overlap);
    if let (Some(windows), Some(tracked), Some(clusters), Some(cut)) =
        (&mut clip.windows, found.tracked, found.clusters, found.cut)
    {
        let looks = portraits(&tracked.tracks, &clusters.label, &cut.objects, &clip.frames);
        windows.identities.advance(&cut.objects, &tracked.tracks, &clusters.label, &tracked.numbers, dropped, &looks);
    }
}
