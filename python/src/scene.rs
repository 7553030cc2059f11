//! Made clips whose masks and flow are known.

use crate::arrays::{self, FlowArrays, plane, rgb};
use crate::error::{Failure, Result};
use numpy::{PyArray2, PyArray3};
use pyo3::prelude::*;
use tracecut::synth;

/// A synthetic clip.
#[pyclass(frozen, module = "tracecut._tracecut")]
pub(crate) struct Scene(synth::Scene);

impl Scene {
    fn check_frame(&self, t: usize) -> Result<usize> {
        let frames = self.0.num_frames();
        let failure = || Failure::data(format!("t = {t} (expected a frame in 0..{frames})"));
        if t < frames { Ok(t) } else { Err(failure()) }
    }
}

#[pymethods]
impl Scene {
    #[new]
    fn new(kind: &str, width: usize, height: usize, frames: usize, seed: u64) -> Result<Self> {
        let make = match kind {
            "sample" => synth::Scene::sample,
            "two_walkers" => synth::Scene::two_walkers,
            "entangled" => synth::Scene::entangled,
            "still" => synth::Scene::still,
            other => {
                let reason = format!("kind = {other:?} (expected sample, two_walkers, entangled or still)");
                return Err(Failure::data(reason));
            }
        };
        for (name, value, high) in [("width", width, 4096), ("height", height, 4096), ("frames", frames, 100_000)] {
            if !(1..=high).contains(&value) {
                return Err(Failure::data(format!("{name} = {value} (expected a whole number, 1..={high})")));
            }
        }
        Ok(Self(make((width, height), frames, seed)))
    }

    fn num_frames(&self) -> usize {
        self.0.num_frames()
    }

    fn frame<'py>(&self, py: Python<'py>, t: usize) -> Result<Bound<'py, PyArray3<u8>>> {
        let t = self.check_frame(t)?;
        Ok(rgb(py, &py.detach(|| self.0.frame(t))))
    }

    fn mask<'py>(&self, py: Python<'py>, t: usize) -> Result<Bound<'py, PyArray2<u8>>> {
        let t = self.check_frame(t)?;
        Ok(plane(py, py.detach(|| self.0.mask(t))))
    }

    fn flow<'py>(&self, py: Python<'py>, t: usize) -> Result<FlowArrays<'py>> {
        let t = self.check_frame(t)?;
        Ok(arrays::flow(py, py.detach(|| self.0.flow(t))))
    }
}
