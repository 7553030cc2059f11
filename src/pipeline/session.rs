//! `Session`: frames in, one bounded step at a time, results stage by stage.

use crate::Error;
use crate::discontinuity::Discontinuities;
use crate::discretize::Clusters;
use crate::embedding::Embedding;
use crate::flow::FlowField;
use crate::params::Params;
use crate::sparse::SymCsr;
use crate::trajectory::Trajectories;
use serde::Serialize;

/// The stages, in the order in which they run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "camelCase")]
pub enum Stage {
    /// Dense optical flow, forward and backward.
    Flow,
    /// Point trajectories.
    Trajectories,
    /// Motion affinities.
    Affinities,
    /// Spectral embedding.
    Embedding,
    /// Delaunay neighbourhoods and embedding discontinuities.
    Discontinuities,
    /// Cluster labels.
    Clusters,
}

/// How far the session is: `done` of `total` steps of `stage`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Progress {
    /// The stage that the step just taken belongs to.
    pub stage: Stage,
    /// Steps of that stage taken so far.
    pub done: u32,
    /// Steps of that stage in all.
    pub total: u32,
}

/// What a call of [`Session::step`] did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// One step was taken; more remain.
    Working(Progress),
    /// Nothing is left to do: all results can be read.
    Done,
}

/// One clip on its way through the stages. Push frames, step until done, read results. To cancel, stop stepping.
#[derive(Debug)]
pub struct Session {
    params: Params,
}

impl Session {
    /// # Errors
    /// [`Error::Param`] when a parameter is out of range.
    pub fn new(params: Params) -> Result<Self, Error> {
        params.validate()?;
        Ok(Self { params })
    }

    /// The parameters in force.
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// Adds the next frame: RGBA bytes, four a pixel.
    pub fn push_rgba(&mut self, _rgba: &[u8], _width: usize, _height: usize) -> Result<(), Error> {
        Ok(())
    }

    /// Adds the next frame from the bytes of a PNG or JPEG file.
    pub fn push_encoded(&mut self, _bytes: &[u8]) -> Result<(), Error> {
        Ok(())
    }

    /// Adds the next frame.
    pub fn push_frame(&mut self, _frame: crate::image::Frame) -> Result<(), Error> {
        Ok(())
    }

    /// Uses `trajectories` of any tracker, in input pixels, in place of frames, flow and tracking.
    pub fn set_trajectories(&mut self, _trajectories: Trajectories) -> Result<(), Error> {
        Ok(())
    }

    /// Takes one bounded step.
    pub fn step(&mut self) -> Result<Step, Error> {
        Ok(Step::Done)
    }

    /// Steps until done.
    pub fn run(&mut self) -> Result<(), Error> {
        while self.step()? != Step::Done {}
        Ok(())
    }

    /// Drops frames and results; parameters stay.
    pub fn clear(&mut self) {}

    /// Number of frames pushed (or of the outside trajectories' clip).
    pub fn num_frames(&self) -> usize {
        0
    }

    /// Width and height of the input frames in pixels; `None` before the first.
    pub fn input_size(&self) -> Option<(usize, usize)> {
        None
    }

    /// Width and height at which frames are processed.
    pub fn working_size(&self) -> Option<(usize, usize)> {
        None
    }

    /// Forward flow from frame `t` to `t + 1`, in input pixels, at working size.
    pub fn flow(&self, _t: usize) -> Result<FlowField, Error> {
        Ok(FlowField::default())
    }

    /// Trajectories in input pixels.
    pub fn trajectories(&self) -> Option<&Trajectories> {
        None
    }

    /// The affinity matrix A.
    pub fn affinities(&self) -> Option<&SymCsr> {
        None
    }

    /// The embedding.
    pub fn embedding(&self) -> Option<&Embedding> {
        None
    }

    /// Neighbour pairs and discontinuities.
    pub fn discontinuities(&self) -> Option<&Discontinuities> {
        None
    }

    /// Cluster labels.
    pub fn clusters(&self) -> Option<&Clusters> {
        None
    }
}
