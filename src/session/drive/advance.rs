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

#[cfg(test)]
mod tests {
    use crate::Session;
    use crate::image::Frame;
    use crate::rng::Rng;
    use crate::synth::Scene;
    use crate::{Error, Params};

    const SIZE: (usize, usize) = (240, 136);

    fn scene(frames: usize, seed: u64) -> Scene {
        Scene::sample((SIZE.0, SIZE.1), frames, seed)
    }

    fn session() -> Session {
        Session::new(Params::default()).unwrap()
    }

    fn plain(value: u8) -> Frame {
        Frame::from_rgb(vec![value; 3 * 32 * 24], 32, 24).unwrap()
    }

    /// The label that most pixels of each true object bear in frame `t` of the window.
    fn labels_of_objects(session: &Session, scene: &Scene, t: usize, frame: usize) -> Vec<u8> {
        let (found, truth) = (session.labels(t).unwrap(), scene.mask(frame));
        let mut votes = vec![[0_u32; 256]; scene.num_objects() + 1];
        for (&object, &label) in truth.data().iter().zip(found.data()) {
            votes[usize::from(object)][usize::from(label)] += 1;
        }
        votes[1..].iter().map(|v| (0..=255).max_by_key(|&label| v[usize::from(label)]).unwrap()).collect()
    }

    #[test]
    fn objects_keep_their_labels_and_trajectories_their_numbers_from_window_to_window() {
        let scene = scene(44, 1);
        let mut s = session();
        for t in 0..20 {
            assert!(!s.push_in_shot(scene.frame(t)).unwrap());
        }
        s.run().unwrap();
        let first = labels_of_objects(&s, &scene, 14, 14);
        assert!(first.iter().all(|&label| label > 0), "{first:?}");
        for begin in [12, 24] {
            let (tracks, numbers) = (s.trajectories().unwrap().clone(), s.trajectory_numbers().to_vec());
            let flow = s.flow(15).unwrap();
            s.advance(8).unwrap();
            assert_eq!(s.num_frames(), 8);
            (begin + 8..begin + 20).for_each(|t| assert!(!s.push_in_shot(scene.frame(t)).unwrap()));
            s.run().unwrap();
            assert_eq!(labels_of_objects(&s, &scene, 10, begin + 10), first);
            assert_eq!(s.flow(3).unwrap(), flow);
            let mut common = 0;
            for (i, number) in s.trajectory_numbers().iter().enumerate() {
                let Some(old) = numbers.iter().position(|n| n == number) else { continue };
                common += 1;
                for t in 0..8 {
                    if let (Some(now), Some(before)) = (s.trajectories().unwrap().at(i, t), tracks.at(old, t + 12)) {
                        assert_eq!(now, before);
                    }
                }
            }
            assert!(common > 50, "{common} common trajectories");
        }
    }

    /// Advances to a shot whose first frame is held, and runs it.
    fn assert_next_shot_has_new_labels(s: &mut Session, other: &Scene, before: &[u8]) {
        s.advance(5).unwrap();
        assert_eq!((s.num_frames(), s.holds_next_shot()), (1, false));
        (1..12).for_each(|t| assert!(!s.push_in_shot(other.frame(t)).unwrap()));
        s.run().unwrap();
        let after = s.objects().unwrap().labels();
        assert!(!before.is_empty() && !after.is_empty());
        assert!(after.iter().all(|label| !before.contains(label)), "{before:?} {after:?}");
    }

    #[test]
    fn a_cut_holds_the_frame_back_and_begins_a_shot_with_new_labels() {
        let (one, other) = (scene(12, 0), scene(12, 7));
        let mut s = session();
        (0..12).for_each(|t| assert!(!s.push_in_shot(one.frame(t)).unwrap()));
        assert!(s.push_in_shot(other.frame(0)).unwrap() && s.holds_next_shot());
        assert_eq!(s.push_in_shot(other.frame(1)).unwrap_err().code(), "state");
        assert_eq!(s.num_frames(), 12);
        s.run().unwrap();
        let (before, last_number) = (s.objects().unwrap().labels(), *s.trajectory_numbers().iter().max().unwrap());
        assert_next_shot_has_new_labels(&mut s, &other, &before);
        assert!(s.trajectory_numbers().iter().all(|&n| n > last_number));
    }

    #[test]
    fn a_cut_right_after_a_window_begins_a_shot_without_another_run() {
        let (one, other) = (scene(12, 0), scene(12, 7));
        let mut s = session();
        (0..12).for_each(|t| assert!(!s.push_in_shot(one.frame(t)).unwrap()));
        s.run().unwrap();
        let before = s.objects().unwrap().labels();
        s.advance(5).unwrap();
        assert_eq!(s.advance(5).unwrap_err().code(), "state");
        assert!(s.push_in_shot(other.frame(0)).unwrap());
        assert_next_shot_has_new_labels(&mut s, &other, &before);
    }

    #[test]
    fn a_shot_of_one_frame_is_all_background() {
        let mut s = session();
        assert!(!s.push_in_shot(plain(10)).unwrap());
        assert!(s.push_in_shot(plain(200)).unwrap());
        for _ in 0..2 {
            s.run().unwrap();
            assert_eq!(s.labels(0).unwrap().data(), vec![0; 32 * 24]);
            assert!(s.trajectories().unwrap().is_empty() && s.saliency().is_none());
            if s.holds_next_shot() {
                s.advance(1).unwrap();
            }
        }
        assert_eq!(s.advance(1).unwrap_err().code(), "param");
        assert_eq!(s.labels(0).unwrap().data(), vec![0; 32 * 24]);
    }

    #[test]
    fn advance_wants_a_finished_window_a_legal_overlap_and_then_new_frames() {
        let mut s = session();
        assert_eq!(s.advance(1).unwrap_err().code(), "state");
        (0..6).for_each(|k| assert!(!s.push_in_shot(plain(50 + k)).unwrap()));
        assert_eq!(s.advance(1).unwrap_err().code(), "state");
        s.run().unwrap();
        assert_eq!(s.advance(6).unwrap_err().to_string(), "overlap = 6 (expected a whole number of frames, 1..=5)");
        assert_eq!(s.advance(0).unwrap_err().code(), "param");
        assert_eq!(s.labels(5).unwrap().width(), 32);
        s.advance(3).unwrap();
        assert_eq!(s.run(), Err(Error::TooFewFrames { got: 3, needed: 4 }));
        s.push_in_shot(plain(56)).unwrap();
        s.run().unwrap();
        assert_eq!(s.num_frames(), 4);
        let mut plain_session = session();
        (0..3).for_each(|_| plain_session.push_frame(plain(9)).unwrap());
        plain_session.run().unwrap();
        assert_eq!(plain_session.advance(1).unwrap_err().code(), "state");
    }

    /// A scene of random grey blocks, and before it a red square of blocks of its own that leaves the frame to the right and
    /// comes back.
    fn leaving_and_back(t: usize) -> Frame {
        let (w, h) = (160, 96);
        let noise = |u: usize, v: usize| Rng::for_stage((u / 4 * 1000 + v / 4) as u64, "leaving").below(200) as u8;
        let left = if t < 40 { 40 + 4 * t } else { 400 - 4 * t };
        let pixel = |i: usize| {
            let (x, y) = (i % w, i / w);
            let grey = noise(x, y);
            if (left..left + 40).contains(&x) && (30..70).contains(&y) {
                let own = noise(x + 900 - left, y);
                return [55 + own, own / 4, own / 4];
            }
            [grey; 3]
        };
        Frame::from_rgb((0..w * h).flat_map(pixel).collect(), w, h).unwrap()
    }

    #[test]
    fn what_leaves_the_frame_and_comes_back_has_its_label_again() {
        let mut s = session();
        let mut labels = Vec::new();
        for begin in [0, 15, 30, 45, 60] {
            if begin > 0 {
                s.advance(5).unwrap();
            }
            let first = begin + s.num_frames();
            (first..begin + 20).for_each(|t| assert!(!s.push_in_shot(leaving_and_back(t)).unwrap()));
            s.run().unwrap();
            labels.push(s.objects().unwrap().labels());
        }
        assert_eq!(labels.first(), Some(&vec![1]), "{labels:?}");
        assert!(labels[2].is_empty(), "{labels:?}");
        assert_eq!(labels.last(), Some(&vec![1]), "{labels:?}");
    }
}
