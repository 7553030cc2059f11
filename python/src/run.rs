//! The run behind a session or an iterator of windows, which many threads may read and one may change; and the windows.

use crate::arrays::image_from;
use crate::error::{Failure, Result};
use crate::params::params_from;
use crate::session::Session;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError, RwLock, TryLockError};
use tracecut::image::Frame;
use tracecut::{Params, Progress};

/// The windows of a clip whose frames Python gives.
pub(crate) type Clip = tracecut::Windows<Frames, Failure>;

/// A session of its own, or the one that goes through the windows of a clip.
pub(crate) enum Run {
    Session(Box<tracecut::Session>),
    Windows(Box<Clip>, usize),
}

impl Run {
    pub(crate) fn session(&self) -> &tracecut::Session {
        match self {
            Self::Session(session) => session,
            Self::Windows(windows, _) => windows.session(),
        }
    }
}

/// A run that is shared between Python objects.
#[derive(Clone)]
pub(crate) struct Shared(Arc<RwLock<Run>>);

const AT_WORK: &str = "the session is at work: read its results between steps, or when it is done";

impl Shared {
    pub(crate) fn new(run: Run) -> Self {
        Self(Arc::new(RwLock::new(run)))
    }

    /// Looks at the run; never waits, as what is waited for may need the interpreter.
    pub(crate) fn read<T>(&self, look: impl FnOnce(&Run) -> Result<T>) -> Result<T> {
        match self.0.try_read() {
            Ok(run) => look(&run),
            Err(TryLockError::Poisoned(run)) => look(&run.into_inner()),
            Err(TryLockError::WouldBlock) => Err(Failure::state(AT_WORK)),
        }
    }

    /// The same, and may change it.
    pub(crate) fn write<T>(&self, work: impl FnOnce(&mut Run) -> Result<T>) -> Result<T> {
        match self.0.try_write() {
            Ok(mut run) => work(&mut run),
            Err(TryLockError::Poisoned(run)) => work(&mut run.into_inner()),
            Err(TryLockError::WouldBlock) => Err(Failure::state(AT_WORK)),
        }
    }
}

/// Tells Python of a step, unless nobody listens; and lets it raise what waits, such as `KeyboardInterrupt`.
pub(crate) fn report(listener: Option<&Py<PyAny>>, progress: Progress) -> Result<()> {
    Python::attach(|py| {
        py.check_signals()?;
        if let Some(listener) = listener {
            listener.call1(py, (progress.stage.name(), progress.done, progress.total))?;
        }
        Ok(())
    })
}

/// Frames that a Python iterator gives.
pub(crate) struct Frames {
    pub(crate) iterator: Py<PyAny>,
    pub(crate) sources: Sources,
    pub(crate) params: Params,
    /// Number of frames to come, if known.
    pub(crate) remaining: Option<usize>,
}

impl Iterator for Frames {
    type Item = Result<Frame>;

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.remaining.unwrap_or(0), self.remaining)
    }

    fn next(&mut self) -> Option<Self::Item> {
        let frame = Python::attach(|py| {
            let mut frames = self.iterator.bind(py).try_iter().ok()?;
            Some(frames.next()?.map_err(Failure::from).and_then(|array| image_from(&array, &self.params)))
        })?;
        self.remaining = self.remaining.map(|remaining| remaining.saturating_sub(1));
        if let Ok(frame) = &frame {
            self.sources.push(frame);
        }
        Some(frame)
    }
}

/// The frames of the present window at the size of the source, where that is reduced for the run.
#[derive(Clone)]
pub(crate) struct Sources {
    max_side: usize,
    /// The clip's number of the first, and the frames.
    frames: Arc<Mutex<(usize, VecDeque<Frame>)>>,
}

impl Sources {
    pub(crate) fn new(max_side: usize) -> Self {
        Self { max_side, frames: Arc::default() }
    }

    fn push(&self, frame: &Frame) {
        if frame.width().max(frame.height()) > self.max_side {
            self.frames.lock().unwrap_or_else(PoisonError::into_inner).1.push_back(frame.clone());
        }
    }

    /// Drops the frames before frame `first` of the clip.
    pub(crate) fn drop_before(&self, first: usize) {
        let mut frames = self.frames.lock().unwrap_or_else(PoisonError::into_inner);
        while frames.0 < first && frames.1.pop_front().is_some() {
            frames.0 += 1;
        }
    }

    /// Frame `index` of the clip.
    pub(crate) fn get(&self, index: usize) -> Option<Frame> {
        let frames = self.frames.lock().unwrap_or_else(PoisonError::into_inner);
        frames.1.get(index.checked_sub(frames.0)?).cloned()
    }
}

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
