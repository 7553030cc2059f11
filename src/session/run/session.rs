//! `Session`: frames in, one bounded step at a time, results stage by stage.

use super::clip::Clip;
use super::state::Run;
use crate::Error;
use crate::image::Frame;
use crate::session::base::{Outputs, Params, REFERENCE_STEP, Scale, Stage, Step, Tracked};
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
                    clip.params = self.params.for_size_at(clip.scale.working, typical_spacing(&given.tracks));
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
        let scale = Scale::checked(trajectories.size, self.params.clip.max_side as usize)?;
        self.params.clip.check_given(&trajectories)?;
        if trajectories.num_frames < 2 {
            return Err(Error::TooFewFrames { got: trajectories.num_frames, needed: 2 });
        }
        trajectories.check()?;
        let tracked = Box::new(Tracked::given(trajectories, scale));
        let spacing = typical_spacing(&tracked.tracks);
        match &mut self.phase {
            Phase::Frames(clip) if !clip.frames.is_empty() => {
                clip.give(tracked)?;
                clip.params = self.params.for_size_at(scale.working, spacing);
            }
            phase => {
                let mut clip = Box::new(Clip::new(scale, self.params.at_spacing(spacing), self.epoch));
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

/// Distance of neighbouring trajectories in a frame, in pixels: the side of the square that one has for itself on
/// average.
fn typical_spacing(tracks: &Trajectories) -> f32 {
    let alive = tracks.x.len() as f32 / tracks.num_frames.max(1) as f32;
    let area = (tracks.size.0 * tracks.size.1) as f32;
    if alive > 0.0 { (area / alive).sqrt().clamp(2.0, 64.0) } else { REFERENCE_STEP }
}
