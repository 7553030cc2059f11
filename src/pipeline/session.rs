//! `Session`: frames in, one bounded step at a time, results stage by stage.

use super::correct::Corrections;
use super::dense::{Clip, Dense};
use super::foreground::{Connected, Foreground, Motions};
use super::geometry::Scale;
use super::motion::Motion;
use super::stage::{Progress, Stage, Step};
use super::windows::Windows;
use crate::Error;
use crate::affinity::AffinityRows;
use crate::discontinuity::{Discontinuities, discontinuities, neighborhoods};
use crate::discretize::{Clusters, discretize};
use crate::embedding::{Embedding, embed};
use crate::flow::CompactFlow;
use crate::image::Frame;
use crate::params::Params;
use crate::sparse::SymCsr;
use crate::trajectory::Trajectories;

/// Trajectories compared with all others in one step.
const AFFINITY_BLOCK: usize = 512;

/// The grid step at which counts of trajectories are stated in the parameters.
const REFERENCE_STEP: f32 = 8.0;

/// What is in progress: each variant owns the unfinished work of its stage.
#[derive(Debug)]
pub(super) enum State {
    /// Taking frames.
    Open,
    Motion(Box<Motion>),
    Affinities(Box<AffinityRows>),
    Embedding,
    Discontinuities,
    Saliency,
    Connectedness,
    Clusters,
    Dense,
    Done,
}

/// One clip on its way through the stages.
///
/// Push frames (or set trajectories), call [`Session::step`] until it returns [`Step::Done`], read results; those of a finished stage
/// can be read while later ones still run. To cancel, stop stepping: stepping again later goes on and ends in the same result.
#[derive(Debug)]
pub struct Session {
    pub(super) params: Params,
    pub(super) frames: Vec<Frame>,
    pub(super) scale: Option<Scale>,
    /// Distance of neighbouring trajectories, in working pixels.
    pub(super) spacing: f32,
    pub(super) state: State,
    pub(super) flows: Vec<CompactFlow>,
    pub(super) working: Option<Trajectories>,
    pub(super) trajectories: Option<Trajectories>,
    /// The clip-wide number of each trajectory.
    pub(super) numbers: Vec<u32>,
    /// The same trajectories with what is remembered from before the window; `None` where nothing is.
    pub(super) with_past: Option<Trajectories>,
    pub(super) affinities: Option<SymCsr>,
    pub(super) embedding: Option<Embedding>,
    pub(super) discontinuities: Option<Discontinuities>,
    pub(super) clusters: Option<Clusters>,
    pub(super) foreground: Foreground,
    pub(super) dense: Dense,
    /// Where the clip is taken window by window.
    pub(super) windows: Option<Box<Windows>>,
    pub(super) corrections: Corrections,
}

impl Session {
    /// An empty session.
    ///
    /// # Errors
    /// [`Error::Param`] when a parameter is out of range.
    pub fn new(params: Params) -> Result<Self, Error> {
        params.validate()?;
        Ok(Self {
            spacing: params.trajectory.grid_step,
            params,
            frames: Vec::new(),
            scale: None,
            state: State::Open,
            flows: Vec::new(),
            working: None,
            trajectories: None,
            numbers: Vec::new(),
            with_past: None,
            affinities: None,
            embedding: None,
            discontinuities: None,
            clusters: None,
            foreground: Foreground::default(),
            dense: Dense::default(),
            windows: None,
            corrections: Corrections::default(),
        })
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
    /// As [`Frame::decode`] and [`Session::push_frame`]; the session stays as it was.
    pub fn push_encoded(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.push_frame(Frame::decode(bytes)?)
    }

    /// Adds the next frame.
    ///
    /// # Errors
    /// [`Error::FrameSizeChanged`] unless it has the size of the first; [`Error::State`] once stepping has begun or when
    /// trajectories were set.
    pub fn push_frame(&mut self, frame: Frame) -> Result<(), Error> {
        let frame = self.accepted(frame)?;
        self.frames.push(frame);
        Ok(())
    }

    /// The frame at working size, if it can be added.
    pub(super) fn accepted(&mut self, frame: Frame) -> Result<Frame, Error> {
        self.require_open("a frame was pushed")?;
        if self.working.is_some() {
            return Err(state_error("a frame was pushed after trajectories were set: clear the session first"));
        }
        let actual = (frame.width(), frame.height());
        let scale = self.scale.unwrap_or_else(|| Scale::new(actual, self.params.clip.max_side as usize));
        if scale.input != actual {
            return Err(Error::FrameSizeChanged { index: self.frames.len(), expected: scale.input, actual });
        }
        self.scale = Some(scale);
        Ok(frame.resized(scale.working.0, scale.working.1))
    }

    /// Uses the trajectories of any tracker, in input pixels, in place of frames, flow and tracking.
    ///
    /// # Errors
    /// [`Error::Data`] when they break the law of [`Trajectories`] (NaN, wrong counts), [`Error::FrameSize`] and
    /// [`Error::TooFewFrames`] as for frames, [`Error::State`] when frames were pushed or stepping has begun.
    pub fn set_trajectories(&mut self, trajectories: Trajectories) -> Result<(), Error> {
        self.require_open("trajectories were set")?;
        if !self.frames.is_empty() {
            return Err(state_error("trajectories were set after frames were pushed: clear the session first"));
        }
        let scale = Scale::checked(trajectories.size, self.params.clip.max_side as usize)?;
        if trajectories.num_frames < 2 {
            return Err(Error::TooFewFrames { got: trajectories.num_frames, needed: 2 });
        }
        trajectories.check()?;
        let working = scale.to_working(&trajectories);
        self.numbers = (0..working.len() as u32).collect();
        self.spacing = typical_spacing(&working);
        self.scale = Some(scale);
        self.working = Some(working);
        self.trajectories = Some(trajectories);
        Ok(())
    }

    fn require_open(&self, what: &str) -> Result<(), Error> {
        match self.state {
            State::Open => Ok(()),
            _ => Err(state_error(&format!("{what} after the run had begun: clear the session or use a new one"))),
        }
    }

    /// Takes one bounded step.
    ///
    /// # Errors
    /// [`Error::TooFewFrames`] with fewer than two frames: more can be pushed then. The state is unchanged after any error.
    pub fn step(&mut self) -> Result<Step, Error> {
        if matches!(self.state, State::Open) {
            self.begin()?;
        }
        let progress = match &mut self.state {
            State::Open | State::Done => return Ok(Step::Done),
            State::Motion(motion) => {
                let progress = motion.step(&self.frames, &mut self.flows);
                if motion.is_finished() {
                    self.end_motion();
                }
                progress
            }
            State::Affinities(rows) => {
                let tracks = self.with_past.as_ref().or(self.working.as_ref()).ok_or_else(lost)?;
                let more = rows.advance(tracks, AFFINITY_BLOCK);
                let blocks = |rows: usize| rows.div_ceil(AFFINITY_BLOCK).max(1) as u32;
                let progress =
                    Progress { stage: Stage::Affinities, done: blocks(rows.done()), total: blocks(tracks.len()) };
                if !more {
                    self.end_affinities()?;
                }
                progress
            }
            State::Embedding => self.embed()?,
            State::Discontinuities => self.discontinue()?,
            State::Saliency => self.find_salient()?,
            State::Connectedness => self.connect()?,
            State::Clusters => self.cluster()?,
            State::Dense => self.densify()?,
        };
        Ok(Step::Working(progress))
    }

    /// Steps until done.
    ///
    /// # Errors
    /// As [`Session::step`].
    pub fn run(&mut self) -> Result<(), Error> {
        while self.step()? != Step::Done {}
        Ok(())
    }

    fn begin(&mut self) -> Result<(), Error> {
        if let Some(tracks) = &self.working {
            self.state = self.affinity_state(tracks);
            return Ok(());
        }
        if self.is_lone_frame() {
            self.take_tracks(self.lone_frame_tracks(), Vec::new());
            return Ok(());
        }
        let needed = (self.windows.as_ref().map_or(0, |w| w.overlap) + 1).max(2);
        if self.frames.len() < needed {
            return Err(Error::TooFewFrames { got: self.frames.len(), needed });
        }
        let (trackers, known) = self.trackers();
        self.state = State::Motion(Box::new(Motion::new(&self.frames, trackers, known, &self.params)));
        Ok(())
    }

    fn affinity_state(&self, tracks: &Trajectories) -> State {
        let rows = AffinityRows::new(tracks, self.spacing, &self.params.affinity, self.params.clip.seed);
        State::Affinities(Box::new(rows))
    }

    fn end_motion(&mut self) {
        let State::Motion(motion) = std::mem::replace(&mut self.state, State::Open) else { return };
        let trackers = motion.into_trackers();
        let (working, numbers) = trackers.tracks.numbered();
        self.with_past = trackers.tracks.with_past();
        self.dense.tracks = trackers.masks.as_ref().map(|masks| masks.numbered().0);
        if let Some(windows) = &mut self.windows {
            windows.trackers = Some(trackers);
        }
        self.take_tracks(working, numbers);
    }

    /// Goes on to the affinities, which look at the whole life of trajectories, as far as it is remembered.
    fn take_tracks(&mut self, working: Trajectories, numbers: Vec<u32>) {
        self.state = self.affinity_state(self.with_past.as_ref().unwrap_or(&working));
        self.trajectories = self.scale.map(|scale| scale.to_input(&working));
        self.working = Some(working);
        self.numbers = numbers;
    }

    fn end_affinities(&mut self) -> Result<(), Error> {
        if let State::Affinities(rows) = std::mem::replace(&mut self.state, State::Embedding) {
            self.affinities = Some(rows.finish()?);
        }
        Ok(())
    }

    fn embed(&mut self) -> Result<Progress, Error> {
        let affinities = self.affinities.as_ref().ok_or_else(lost)?;
        self.embedding = Some(embed(affinities, &self.scaled_params().embedding, self.params.clip.seed));
        self.state = State::Discontinuities;
        Ok(Progress::whole(Stage::Embedding))
    }

    fn discontinue(&mut self) -> Result<Progress, Error> {
        let tracks = self.working.as_ref().ok_or_else(lost)?;
        let embedding = self.embedding.as_ref().ok_or_else(lost)?;
        self.discontinuities = Some(discontinuities(neighborhoods(tracks), embedding, &self.params.discontinuity));
        self.state = State::Saliency;
        Ok(Progress::whole(Stage::Discontinuities))
    }

    fn find_salient(&mut self) -> Result<Progress, Error> {
        let params = self.scaled_params();
        let mut foreground = std::mem::take(&mut self.foreground);
        let progress = self.motions(&params).map(|motions| foreground.step_saliency(&motions));
        self.foreground = foreground;
        if progress.as_ref().is_ok_and(|p| p.done == p.total) {
            self.state = State::Connectedness;
        }
        progress
    }

    fn connect(&mut self) -> Result<Progress, Error> {
        let params = self.scaled_params();
        let mut foreground = std::mem::take(&mut self.foreground);
        let outcome = self.motions(&params).map(|motions| foreground.step_connectedness(&motions));
        self.foreground = foreground;
        let (progress, found) = outcome?;
        match found {
            Connected::More => return Ok(progress),
            Connected::Unchanged => {}
            Connected::Changed(found) => {
                let (affinities, embedding, discontinuities) = *found;
                self.affinities = Some(affinities);
                self.embedding = Some(embedding);
                self.discontinuities = Some(discontinuities);
            }
        }
        self.state = State::Clusters;
        Ok(progress)
    }

    /// What motion alone has found so far.
    fn motions<'a>(&'a self, params: &'a Params) -> Result<Motions<'a>, Error> {
        Ok(Motions {
            flows: &self.flows,
            tracks: self.working.as_ref().ok_or_else(lost)?,
            mask_tracks: self.dense.tracks.as_ref(),
            affinities: self.affinities.as_ref().ok_or_else(lost)?,
            embedding: self.embedding.as_ref().ok_or_else(lost)?,
            discontinuities: self.discontinuities.as_ref().ok_or_else(lost)?,
            params,
            spacing: self.spacing,
        })
    }

    fn cluster(&mut self) -> Result<Progress, Error> {
        let (Some(tracks), Some(embedding), Some(found)) = (&self.working, &self.embedding, &self.discontinuities)
        else {
            return Err(lost());
        };
        let params = self.scaled_params();
        let clusters = discretize(tracks, embedding, found, &params.discretize, params.clip.seed);
        self.clusters = Some(self.foreground.settle(tracks, clusters, found, &params));
        self.state = if self.params.clip.dense && !self.frames.is_empty() { State::Dense } else { State::Done };
        Ok(Progress::whole(Stage::Clusters))
    }

    fn densify(&mut self) -> Result<Progress, Error> {
        let (Some(tracks), Some(clusters)) = (&self.working, &self.clusters) else { return Err(lost()) };
        let clip = Clip {
            frames: &self.frames,
            flows: &self.flows,
            tracks,
            clusters,
            salience: &self.foreground.of_mask_tracks,
            numbers: &self.numbers,
            windows: self.windows.as_deref(),
            params: &self.params,
        };
        let progress = self.dense.step(&clip);
        if self.dense.is_finished(&self.frames) {
            self.state = State::Done;
        }
        Ok(progress)
    }

    /// The parameters with counts of trajectories, which are stated at the reference grid step, at the present spacing.
    pub(super) fn scaled_params(&self) -> Params {
        let mut params = self.params.clone();
        let dense = (REFERENCE_STEP / self.spacing).powi(2);
        for count in [
            &mut params.embedding.min_component,
            &mut params.discretize.min_cluster,
            &mut params.connectedness.min_component,
        ] {
            *count = (*count as f32 * dense).round() as u32;
        }
        params
    }

    /// Drops frames and results; parameters stay.
    pub fn clear(&mut self) {
        if let Ok(fresh) = Self::new(self.params.clone()) {
            *self = fresh;
        }
    }
}

pub(super) fn state_error(reason: &str) -> Error {
    Error::State { reason: reason.to_owned() }
}

/// Each stage stores its result before the next begins; this error would be a bug, and is still no panic.
fn lost() -> Error {
    state_error("the result of an earlier stage is missing")
}

/// Distance of neighbouring trajectories in a frame, in pixels: the side of the square that one has for itself on average.
fn typical_spacing(tracks: &Trajectories) -> f32 {
    let alive = tracks.x.len() as f32 / tracks.num_frames.max(1) as f32;
    let area = (tracks.size.0 * tracks.size.1) as f32;
    if alive > 0.0 { (area / alive).sqrt().clamp(2.0, 64.0) } else { REFERENCE_STEP }
}
