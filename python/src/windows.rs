//! A long clip window by window.

use crate::error::{Failure, Result};
use crate::params::params_from;
use crate::run::{Frames, Run, Shared, Sources, report};
use crate::session::Session;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The windows of a clip, in the memory of one.
#[pyclass(frozen, module = "tracecut._tracecut")]
pub(crate) struct Windows {
    run: Shared,
    sources: Sources,
    listener: Option<Py<PyAny>>,
}

/// Index, shot, first frame, and the settled frames' begin and end, counted from the first frame.
type Place = (usize, usize, usize, usize, usize);

#[pymethods]
impl Windows {
    #[new]
    #[allow(clippy::too_many_arguments, reason = "Python's own are named; these are the package's")]
    fn new(
        params: &Bound<'_, PyDict>,
        iterator: Py<PyAny>,
        window: usize,
        overlap: Option<usize>,
        length: Option<usize>,
        threads: usize,
        listener: Option<Py<PyAny>>,
    ) -> Result<Self> {
        let params = params_from(params)?;
        let sources = Sources::new(params.clip.max_side as usize);
        let frames = Frames { iterator, sources: sources.clone(), params: params.clone(), remaining: length };
        let overlap = overlap.unwrap_or_else(|| tracecut::Window::overlap(window));
        let windows = tracecut::Windows::new(params, frames)?.with_window(window, overlap)?.with_threads(threads);
        Ok(Self { run: Shared::new(Run::Windows(Box::new(windows), usize::MAX)), sources, listener })
    }

    /// Runs the next window. Returns its position and a session to read its results from; `None` after the last.
    fn next(&self, py: Python<'_>) -> Result<Option<(Place, Session)>> {
        let Some(window) = py.detach(|| self.run.write(|run| self.run_next(run)))? else { return Ok(None) };
        let sources = Some((self.sources.clone(), window.first_frame));
        let session = Session { run: self.run.clone(), window: Some(window.index), sources };
        let place = (window.index, window.shot, window.first_frame, window.settled.start, window.settled.end);
        Ok(Some((place, session)))
    }
}

impl Windows {
    fn run_next(&self, run: &mut Run) -> Result<Option<tracecut::Window>> {
        let Run::Windows(windows, at) = run else { return Err(Failure::state("this is no iterator of windows")) };
        let before = std::mem::replace(at, usize::MAX);
        let window = windows.try_next_window(|progress| report(self.listener.as_ref(), progress));
        let Some(window) = window.transpose()? else {
            // The results of the last window remain.
            *at = before;
            return Ok(None);
        };
        *at = window.index;
        self.sources.drop_before(window.first_frame);
        Ok(Some(window))
    }
}
