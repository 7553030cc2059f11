//! The public interface of a session: frames in, bounded steps, results stage by stage.

use super::clip::Clip;
use super::state::Run;
use crate::Error;
use crate::error::check_size;
use crate::image::Frame;
use crate::session::base::{Outputs, Params, Scale, Stage, Step, TrackSet};
use crate::trajectory::Trajectories;

/// The segmentation of one clip, run stage by stage.
///
/// Push frames (or set trajectories, or both), call [`Session::step`] until it returns [`Step::Done`], and read the results;
/// results of a finished stage can be read while later ones still run. To cancel, stop stepping; stepping again later
/// continues and ends in the same result.
#[derive(Debug, Clone)]
pub struct Session {
    pub(crate) params: Params,
    pub(crate) phase: Phase,
    /// Increases with each clip and window: results of jobs from earlier ones are ignored.
    pub(crate) epoch: u32,
}

/// The input of a session, or its run.
#[derive(Debug, Clone, Default)]
pub(crate) enum Phase {
    #[default]
    Empty,
    /// Accepting frames, trajectories, or both.
    Frames(Box<Clip>),
    Running(Box<Run>),
}

impl Phase {
    /// Returns the clip; `None` if the session is empty.
    pub(crate) fn clip_mut(&mut self) -> Option<&mut Clip> {
        match self {
            Self::Empty => None,
            Self::Frames(clip) => Some(clip),
            Self::Running(run) => Some(&mut run.clip),
        }
    }
}

impl Session {
    /// Creates an empty session.
    ///
    /// # Errors
    /// [`Error::Param`] when a parameter is out of range.
    pub fn new(params: Params) -> Result<Self, Error> {
        params.validate()?;
        Ok(Self { params, phase: Phase::Empty, epoch: 0 })
    }

    /// Returns the parameters of the session.
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// Adds the next frame from RGBA bytes, four a pixel.
    ///
    /// # Errors
    /// As [`Frame::from_rgba`] and [`Session::push_frame`]; the session does not change then.
    pub fn push_rgba(&mut self, rgba: &[u8], width: usize, height: usize) -> Result<(), Error> {
        self.push_frame(Frame::from_rgba(rgba, width, height)?)
    }

    /// Adds the next frame from the bytes of a PNG or JPEG file.
    ///
    /// # Errors
    /// As [`Frame::decode_within`] `clip.maxPixels` pixels, and as [`Session::push_frame`]; the session does not change
    /// then.
    pub fn push_encoded(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.push_frame(Frame::decode_within(bytes, self.params.clip.max_pixels as usize)?)
    }

    /// Adds the next frame.
    ///
    /// # Errors
    /// [`Error::FrameSizeChanged`] if it differs in size from the first frame, or from the trajectories that were set;
    /// [`Error::TooLarge`] with more pixels than `clip.maxPixels`, or more frames than `clip.maxFrames`;
    /// [`Error::State`] once stepping has begun.
    pub fn push_frame(&mut self, frame: Frame) -> Result<(), Error> {
        self.open_for(&frame)?.push(&frame)
    }

    /// Returns the clip that accepts frames, created from the size of `frame` if there is none yet.
    pub(crate) fn open_for(&mut self, frame: &Frame) -> Result<&mut Clip, Error> {
        self.params.clip.check_pixels(frame.width(), frame.height())?;
        if matches!(self.phase, Phase::Empty) {
            let scale = Scale::new((frame.width(), frame.height()), self.params.clip.max_side as usize);
            let params = self.params.scaled_to(scale.working);
            self.phase = Phase::Frames(Box::new(Clip::new(scale, params, self.epoch)));
        }
        match &mut self.phase {
            Phase::Frames(clip) => {
                if let (Some(external), true) = (&clip.external, clip.frames.is_empty()) {
                    clip.params = self.params.for_tracks(&external.tracks, true);
                }
                Ok(clip)
            }
            _ => Err(running_error("a frame was pushed")),
        }
    }

    /// Uses the trajectories of another tracker, in input pixels, in place of the session's own.
    ///
    /// If all frames of the trajectories are pushed too, before or after, masks are made from the flow and the denser
    /// trajectories of this session; otherwise the run ends with the labels of the trajectories. Trajectories that are set
    /// again replace the earlier ones.
    ///
    /// # Errors
    /// [`Error::Data`] if they violate the invariants of [`Trajectories`] (NaN, wrong counts) or differ in size from the
    /// frames pushed; [`Error::TooLarge`] with more frames, trajectories or points than `clip.maxFrames`,
    /// `clip.maxTrajectories` and `clip.maxPoints` allow; [`Error::FrameSize`] and [`Error::TooFewFrames`] as for frames;
    /// [`Error::State`] once stepping has begun, and in a clip that is processed window by window.
    pub fn set_trajectories(&mut self, trajectories: Trajectories) -> Result<(), Error> {
        if matches!(self.phase, Phase::Running(..)) {
            return Err(running_error("trajectories were set"));
        }
        check_size(trajectories.size.0, trajectories.size.1)?;
        let scale = Scale::new(trajectories.size, self.params.clip.max_side as usize);
        self.params.clip.check_external(&trajectories)?;
        if trajectories.num_frames < 2 {
            return Err(Error::TooFewFrames { got: trajectories.num_frames, needed: 2 });
        }
        trajectories.check()?;
        let track_set = Box::new(TrackSet::external(trajectories, scale));
        match &mut self.phase {
            Phase::Frames(clip) if !clip.frames.is_empty() => {
                let params = self.params.for_tracks(&track_set.tracks, true);
                clip.set_external(track_set)?;
                clip.params = params;
            }
            phase => {
                let params = self.params.for_tracks(&track_set.tracks, false);
                let mut clip = Box::new(Clip::new(scale, params, self.epoch));
                clip.external = Some(track_set);
                *phase = Phase::Frames(clip);
            }
        }
        Ok(())
    }

    /// Takes one bounded step.
    ///
    /// # Errors
    /// [`Error::TooFewFrames`] with fewer than two frames; more can be pushed then. The state is unchanged after any
    /// error.
    pub fn step(&mut self) -> Result<Step, Error> {
        if let Phase::Frames(clip) = &self.phase {
            clip.check()?;
        }
        self.phase = match std::mem::take(&mut self.phase) {
            Phase::Frames(clip) => Phase::Running(Box::new(Run::new(*clip))),
            phase => phase,
        };
        match &mut self.phase {
            Phase::Running(run) => run.step(),
            _ => Err(Error::TooFewFrames { got: 0, needed: 2 }),
        }
    }

    /// Steps until done.
    ///
    /// # Errors
    /// As [`Session::step`].
    pub fn run(&mut self) -> Result<(), Error> {
        while self.step()? != Step::Done {}
        Ok(())
    }

    /// Drops frames and results; parameters stay.
    #[doc(hidden)] // For the package for JavaScript.
    pub fn clear(&mut self) {
        self.phase = Phase::Empty;
        self.epoch = self.epoch.wrapping_add(1);
    }

    /// Returns the clip; `None` if the session is empty.
    pub(crate) fn clip(&self) -> Option<&Clip> {
        match &self.phase {
            Phase::Empty => None,
            Phase::Frames(clip) => Some(clip),
            Phase::Running(run) => Some(&run.clip),
        }
    }

    /// Returns the run, once it has begun.
    pub(crate) fn running(&self) -> Option<&Run> {
        if let Phase::Running(run) = &self.phase { Some(run) } else { None }
    }

    /// Returns the outputs, once the run is past `stage`.
    pub(crate) fn outputs_after(&self, stage: Stage) -> Option<&Outputs> {
        Some(&self.running().filter(|run| run.is_past(stage))?.outputs)
    }
}

fn running_error(action: &str) -> Error {
    Error::state(&format!("{action} after the run had begun: clear the session or use a new one"))
}

impl Clip {
    fn push(&mut self, frame: &Frame) -> Result<(), Error> {
        let frame = self.resize_frame(frame)?;
        self.frames.push(frame);
        Ok(())
    }

    /// Adds trajectories of another tracker to the frames.
    fn set_external(&mut self, track_set: Box<TrackSet>) -> Result<(), Error> {
        let (size, (width, height)) = (track_set.input.size, self.scale.input);
        if self.windows.is_some() {
            return Err(Error::state("trajectories were set in a clip that is processed window by window"));
        }
        if size != self.scale.input {
            let reason =
                format!("trajectories of {}x{} pixels (expected {width}x{height}, as the frames)", size.0, size.1);
            return Err(Error::Data { reason });
        }
        self.external = Some(track_set);
        Ok(())
    }

    /// Checks that there are enough frames for a run, and that trajectories of another tracker fit them.
    fn check(&self) -> Result<(), Error> {
        if let Some(external) = &self.external {
            return if self.frames.is_empty() { Ok(()) } else { check_fit(&external.input, self.frames.len()) };
        }
        let needed = (self.windows.as_ref().map_or(0, |w| w.overlap) + 1).max(2);
        match self.frames.len() {
            got if got < needed && !self.is_single_frame_shot() => Err(Error::TooFewFrames { got, needed }),
            _ => Ok(()),
        }
    }
}

/// Checks that trajectories have this number of frames, and that their points lie inside.
fn check_fit(tracks: &Trajectories, frames: usize) -> Result<(), Error> {
    if tracks.num_frames != frames {
        let reason =
            format!("trajectories of {} frames (expected {frames}, as many as were pushed)", tracks.num_frames);
        return Err(Error::Data { reason });
    }
    check_inside("x", &tracks.x, tracks.size.0)?;
    check_inside("y", &tracks.y, tracks.size.1)
}

/// Checks that coordinates along one side lie in the frame.
#[inline(never)]
fn check_inside(name: &'static str, values: &[f32], side: usize) -> Result<(), Error> {
    let end = side as f64 - 0.5;
    match values.iter().map(|&v| f64::from(v)).enumerate().find(|&(_, v)| v < -0.5 || v > end) {
        None => Ok(()),
        Some((p, v)) => {
            Err(Error::Data { reason: format!("{name}[{p}] = {v} (expected a position in the frame, -0.5..={end})") })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Phase;
    use crate::image::{Frame, Plane};
    use crate::synth::Scene;
    use crate::trajectory::Trajectories;
    use crate::{Error, Params};
    use crate::{Session, Stage, Step};

    const SIZE: (usize, usize) = (320, 180);
    const FRAMES: usize = 10;

    fn session() -> Session {
        Session::new(Params::default()).unwrap()
    }

    fn shades(width: usize, height: usize, value: u8) -> Vec<u8> {
        vec![value; 4 * width * height]
    }

    #[test]
    fn too_few_frames_are_an_error_and_more_can_be_pushed() {
        let mut s = session();
        assert_eq!(s.step(), Err(Error::TooFewFrames { got: 0, needed: 2 }));
        s.push_rgba(&shades(32, 24, 9), 32, 24).unwrap();
        assert_eq!(s.step(), Err(Error::TooFewFrames { got: 1, needed: 2 }));
        s.push_rgba(&shades(32, 24, 9), 32, 24).unwrap();
        s.run().unwrap();
        assert_eq!(s.clusters().unwrap().count, 0);
    }

    #[test]
    fn a_frame_of_another_size_is_refused_and_the_session_goes_on() {
        let mut s = session();
        s.push_rgba(&shades(32, 24, 9), 32, 24).unwrap();
        let error = s.push_rgba(&shades(24, 32, 9), 24, 32).unwrap_err();
        assert_eq!(error, Error::FrameSizeChanged { index: 1, expected: (32, 24), actual: (24, 32) });
        s.push_rgba(&shades(32, 24, 9), 32, 24).unwrap();
        s.run().unwrap();
    }

    #[test]
    fn tiny_and_black_clips_run_to_their_end() {
        for (w, h, frames) in [(1, 1, 2), (17, 3, 3), (64, 48, 8)] {
            let mut s = session();
            for _ in 0..frames {
                s.push_rgba(&shades(w, h, 0), w, h).unwrap();
            }
            s.run().unwrap();
            assert!(s.trajectories().unwrap().is_empty());
            assert_eq!(s.flow(0).unwrap().u.width(), w);
            assert_eq!(s.flow(frames - 1).unwrap_err().code(), "state");
        }
    }

    #[test]
    fn outside_trajectories_are_checked() {
        let mut tracks = Trajectories::empty(3, (64, 48));
        tracks.push(0, [(1.0, 1.0, 0.0), (f32::NAN, 1.0, 0.0), (1.0, 1.0, 0.0)]);
        let message = session().set_trajectories(tracks).unwrap_err().to_string();
        assert_eq!(message, "x[1] = NaN (expected a finite number of pixels)");
        assert!(session().set_trajectories(Trajectories::empty(1, (64, 48))).is_err());
        assert!(session().set_trajectories(Trajectories::empty(3, (0, 48))).is_err());
        let mut s = session();
        s.set_trajectories(Trajectories::empty(3, (64, 48))).unwrap();
        s.run().unwrap();
        assert_eq!(s.push_rgba(&shades(64, 48, 0), 64, 48).unwrap_err().code(), "state");
        assert_eq!(s.set_trajectories(Trajectories::empty(3, (64, 48))).unwrap_err().code(), "state");
        s.clear();
        s.set_trajectories(Trajectories::empty(3, (64, 48))).unwrap();
    }

    #[test]
    fn progress_counts_up_to_its_total_in_every_stage() {
        let mut s = session();
        for _ in 0..4 {
            s.push_rgba(&shades(40, 30, 50), 40, 30).unwrap();
        }
        let mut last = std::collections::BTreeMap::new();
        while let Step::Working(p) = s.step().unwrap() {
            let before = last.insert(p.stage, p);
            assert!(p.done <= p.total && before.is_none_or(|b| b.done < p.done));
        }
        assert_eq!(last.len(), Stage::ALL.len());
        assert!(last.values().all(|p| p.done == p.total));
    }

    #[test]
    fn a_run_without_masks_ends_without_objects() {
        for is_dense in [true, false] {
            let mut params = Params::default();
            params.clip.dense = is_dense;
            let mut s = Session::new(params).unwrap();
            for _ in 0..3 {
                s.push_rgba(&shades(32, 24, 9), 32, 24).unwrap();
            }
            s.run().unwrap();
            assert_eq!(s.objects().is_some(), is_dense);
            assert_eq!(s.labels(0).is_ok(), is_dense);
        }
    }

    fn frames() -> Vec<Frame> {
        let scene = Scene::sample((SIZE.0, SIZE.1), FRAMES, 2);
        (0..FRAMES).map(|t| scene.frame(t)).collect()
    }

    fn with(frames: &[Frame]) -> Session {
        let mut session = Session::new(Params::default()).unwrap();
        frames.iter().for_each(|frame| session.push_frame(frame.clone()).unwrap());
        session
    }

    fn masks(session: &Session) -> Vec<Plane<u8>> {
        (0..FRAMES).map(|t| session.labels(t).unwrap()).collect()
    }

    /// What the tracker found, as another one would give it.
    fn outside(session: &Session) -> Trajectories {
        let mut tracks = session.trajectories().unwrap().clone();
        tracks.variation.fill(0.0);
        tracks
    }

    #[test]
    fn our_own_trajectories_from_outside_give_our_own_masks() {
        let frames = frames();
        let mut ours = with(&frames);
        ours.run().unwrap();
        let mut theirs = with(&frames);
        theirs.set_trajectories(outside(&ours)).unwrap();
        // How far apart they are is guessed from how many there are; here it is known.
        let Phase::Frames(clip) = &mut theirs.phase else { panic!("the run has begun") };
        clip.params = ours.params().scaled_to(SIZE);
        theirs.run().unwrap();
        assert_eq!(
            theirs.running().unwrap().outputs.track_set.tracks,
            ours.running().unwrap().outputs.track_set.tracks
        );
        assert_eq!(theirs.clusters(), ours.clusters());
        assert!(ours.objects().unwrap().highest_label > 1);
        assert_eq!(masks(&theirs), masks(&ours));
    }

    #[test]
    fn with_a_guessed_spacing_masks_are_nearly_the_same_and_the_order_of_calls_does_not_matter() {
        let frames = frames();
        let mut ours = with(&frames);
        ours.run().unwrap();
        let mut after = with(&frames);
        after.set_trajectories(outside(&ours)).unwrap();
        let mut before = with(&[]);
        before.set_trajectories(outside(&ours)).unwrap();
        frames.iter().for_each(|frame| before.push_frame(frame.clone()).unwrap());
        after.run().unwrap();
        before.run_on(2, |_| {}).unwrap();
        assert_eq!(masks(&before), masks(&after));
        assert_eq!(before.trajectories(), Some(&outside(&ours)));
        let same = |(a, b): (&Plane<u8>, &Plane<u8>)| a.data().iter().zip(b.data()).filter(|(a, b)| a == b).count();
        let agreed: usize = masks(&ours).iter().zip(&masks(&after)).map(same).sum();
        let share = agreed as f64 / (SIZE.0 * SIZE.1 * FRAMES) as f64;
        assert!(share > 0.98, "{share} of the pixels are the same");
    }

    #[test]
    fn what_does_not_fit_the_frames_is_refused_and_can_be_set_again() {
        let frames: Vec<Frame> = frames().into_iter().take(3).collect();
        let corners = [(-0.5, -0.5, 0.0), (319.5, 179.5, 0.0), (0.0, 179.5, 0.0)];
        let made = |count, size, point: (f32, f32, f32)| {
            let mut tracks = Trajectories::empty(count, size);
            tracks.push(0, corners);
            tracks.push(1, [point]);
            tracks
        };
        let mut session = with(&frames);
        let size = session.set_trajectories(made(3, (320, 200), corners[0])).unwrap_err();
        assert_eq!(size.to_string(), "trajectories of 320x200 pixels (expected 320x180, as the frames)");
        let refused = |session: &mut Session, tracks| {
            session.set_trajectories(tracks).unwrap();
            session.run().unwrap_err().to_string()
        };
        let longer = refused(&mut session, made(4, SIZE, corners[0]));
        assert_eq!(longer, "trajectories of 4 frames (expected 3, as many as were pushed)");
        let outside = refused(&mut session, made(3, SIZE, (20.0, 179.6, 0.0)));
        assert_eq!(outside, "y[3] = 179.60000610351563 (expected a position in the frame, -0.5..=179.5)");
        session.set_trajectories(made(3, SIZE, corners[1])).unwrap();
        session.run().unwrap();
        assert_eq!(session.labels(2).unwrap().data().len(), 320 * 180);
        session.clear();
        session.set_trajectories(made(3, (320, 200), corners[0])).unwrap();
        let error = session.push_frame(frames[0].clone()).unwrap_err();
        assert_eq!(error, Error::FrameSizeChanged { index: 0, expected: (320, 200), actual: SIZE });
    }

    #[test]
    fn clips_in_windows_take_none() {
        let frames = frames();
        let tracks = Trajectories::empty(2, SIZE);
        let mut session = with(&[]);
        session.push_in_shot(frames[0].clone()).unwrap();
        assert_eq!(session.set_trajectories(tracks.clone()).unwrap_err().code(), "state");
        session.clear();
        session.set_trajectories(tracks).unwrap();
        assert_eq!(session.push_in_shot(frames[0].clone()).unwrap_err().code(), "state");
        session.push_frame(frames[0].clone()).unwrap();
        session.push_frame(frames[1].clone()).unwrap();
        session.run().unwrap();
    }
}
