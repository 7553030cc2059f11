//! `Session`: frames in, one bounded step at a time, results stage by stage.

use super::clip::Clip;
use super::state::Run;
use crate::Error;
use crate::error::check_size;
use crate::image::Frame;
use crate::session::base::{Outputs, Params, Scale, Stage, Step, Tracked};
use crate::trajectory::Trajectories;

/// One clip on its way through the stages.
///
/// Push frames (or set trajectories, or both), call [`Session::step`] until it returns [`Step::Done`], read results;
/// those of a finished stage can be read while later ones still run. To cancel, stop stepping: stepping again later goes
/// on and ends in the same result.
#[derive(Debug, Clone)]
pub struct Session {
    pub(crate) params: Params,
    pub(crate) phase: Phase,
    /// Grows with each clip and window: what was given away before is of no use then.
    pub(crate) epoch: u32,
}

/// What a session runs on, and how far it is.
#[derive(Debug, Clone, Default)]
pub(crate) enum Phase {
    /// Nothing was pushed yet.
    #[default]
    Empty,
    /// Taking frames, or trajectories, or both.
    Frames(Box<Clip>),
    /// The run has begun.
    Begun(Box<Run>),
}

impl Phase {
    /// The clip, once there is one.
    pub(crate) fn clip_mut(&mut self) -> Option<&mut Clip> {
        match self {
            Self::Empty => None,
            Self::Frames(clip) => Some(clip),
            Self::Begun(run) => Some(&mut run.clip),
        }
    }
}

impl Session {
    /// An empty session.
    ///
    /// # Errors
    /// [`Error::Param`] when a parameter is out of range.
    pub fn new(params: Params) -> Result<Self, Error> {
        params.validate()?;
        Ok(Self { params, phase: Phase::Empty, epoch: 0 })
    }

    /// The parameters in force.
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// Adds the next frame: RGBA bytes, four a pixel.
    ///
    /// # Errors
    /// As [`Frame::from_rgba`] and [`Session::push_frame`]; the session stays as it was.
    pub fn push_rgba(&mut self, rgba: &[u8], width: usize, height: usize) -> Result<(), Error> {
        self.push_frame(Frame::from_rgba(rgba, width, height)?)
    }

    /// Adds the next frame from the bytes of a PNG or JPEG file.
    ///
    /// # Errors
    /// As [`Frame::decode`], by `clip.maxPixels`, and [`Session::push_frame`]; the session stays as it was.
    pub fn push_encoded(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.push_frame(Frame::decode_within(bytes, self.params.clip.max_pixels as usize)?)
    }

    /// Adds the next frame.
    ///
    /// # Errors
    /// [`Error::FrameSizeChanged`] unless it has the size of the first, or of the trajectories that were set;
    /// [`Error::TooLarge`] with more pixels than `clip.maxPixels`, or more frames than `clip.maxFrames`;
    /// [`Error::State`] once stepping has begun.
    pub fn push_frame(&mut self, frame: Frame) -> Result<(), Error> {
        self.open_for(&frame)?.push(&frame)
    }

    /// The clip that `frame` can be added to if it has the right size.
    pub(crate) fn open_for(&mut self, frame: &Frame) -> Result<&mut Clip, Error> {
        self.params.clip.check_pixels((frame.width(), frame.height()))?;
        if matches!(self.phase, Phase::Empty) {
            let scale = Scale::new((frame.width(), frame.height()), self.params.clip.max_side as usize);
            let params = self.params.for_size(scale.working);
            self.phase = Phase::Frames(Box::new(Clip::new(scale, params, self.epoch)));
        }
        match &mut self.phase {
            Phase::Frames(clip) => {
                if let (Some(given), true) = (&clip.given, clip.frames.is_empty()) {
                    clip.params = self.params.for_tracks(&given.tracks, true);
                }
                Ok(clip)
            }
            _ => Err(begun_error("a frame was pushed")),
        }
    }

    /// Uses the trajectories of any tracker, in input pixels, in place of those that tracking would find. With frames
    /// pushed, before or after, as many as the trajectories have, masks are made too, by the flow and the denser
    /// trajectories of this session; without, the run ends with the labels of these. Set again, they take the place of
    /// those before.
    ///
    /// # Errors
    /// [`Error::Data`] when they break the law of [`Trajectories`] (NaN, wrong counts), or have not the size of the
    /// frames pushed; [`Error::TooLarge`] with more frames, trajectories or points than `clip.maxFrames`,
    /// `clip.maxTrajectories` and `clip.maxPoints` allow; [`Error::FrameSize`] and [`Error::TooFewFrames`] as for frames; [`Error::State`] once stepping has
    /// begun, and in a clip that is taken window by window.
    pub fn set_trajectories(&mut self, trajectories: Trajectories) -> Result<(), Error> {
        if matches!(self.phase, Phase::Begun(..)) {
            return Err(begun_error("trajectories were set"));
        }
        check_size(trajectories.size.0, trajectories.size.1)?;
        let scale = Scale::new(trajectories.size, self.params.clip.max_side as usize);
        self.params.clip.check_given(&trajectories)?;
        if trajectories.num_frames < 2 {
            return Err(Error::TooFewFrames { got: trajectories.num_frames, needed: 2 });
        }
        trajectories.check()?;
        let tracked = Box::new(Tracked::given(trajectories, scale));
        match &mut self.phase {
            Phase::Frames(clip) if !clip.frames.is_empty() => {
                let params = self.params.for_tracks(&tracked.tracks, true);
                clip.give(tracked)?;
                clip.params = params;
            }
            phase => {
                let mut clip = Box::new(Clip::new(scale, self.params.for_tracks(&tracked.tracks, false), self.epoch));
                clip.given = Some(tracked);
                *phase = Phase::Frames(clip);
            }
        }
        Ok(())
    }

    /// Takes one bounded step.
    ///
    /// # Errors
    /// [`Error::TooFewFrames`] with fewer than two frames: more can be pushed then. The state is unchanged after any
    /// error.
    pub fn step(&mut self) -> Result<Step, Error> {
        if let Phase::Frames(clip) = &self.phase {
            clip.check()?;
        }
        self.phase = match std::mem::take(&mut self.phase) {
            Phase::Frames(clip) => Phase::Begun(Box::new(Run::new(*clip))),
            phase => phase,
        };
        match &mut self.phase {
            Phase::Begun(run) => run.step(),
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
    pub fn clear(&mut self) {
        self.phase = Phase::Empty;
        self.epoch = self.epoch.wrapping_add(1);
    }

    /// The clip, once there is one.
    pub(crate) fn clip(&self) -> Option<&Clip> {
        match &self.phase {
            Phase::Empty => None,
            Phase::Frames(clip) => Some(clip),
            Phase::Begun(run) => Some(&run.clip),
        }
    }

    /// The run, once it has begun.
    pub(crate) fn begun(&self) -> Option<&Run> {
        if let Phase::Begun(run) = &self.phase { Some(run) } else { None }
    }

    /// The outputs, once the run is past `stage`.
    pub(crate) fn after(&self, stage: Stage) -> Option<&Outputs> {
        Some(&self.begun().filter(|run| run.is_past(stage))?.outputs)
    }
}

fn begun_error(what: &str) -> Error {
    Error::state(&format!("{what} after the run had begun: clear the session or use a new one"))
}

impl Clip {
    fn push(&mut self, frame: &Frame) -> Result<(), Error> {
        let frame = self.accepted(frame)?;
        self.frames.push(frame);
        Ok(())
    }

    /// Takes trajectories from outside beside the frames.
    fn give(&mut self, tracked: Box<Tracked>) -> Result<(), Error> {
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
    fn check(&self) -> Result<(), Error> {
        if let Some(given) = &self.given {
            return if self.frames.is_empty() { Ok(()) } else { fits(&given.input, self.frames.len()) };
        }
        let needed = (self.windows.as_ref().map_or(0, |w| w.overlap) + 1).max(2);
        match self.frames.len() {
            got if got < needed && !self.is_lone_frame() => Err(Error::TooFewFrames { got, needed }),
            _ => Ok(()),
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
