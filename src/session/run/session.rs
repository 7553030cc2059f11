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
