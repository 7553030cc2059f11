//! What a session or an iterator of windows runs on: one run that many threads may ask, and one may change.

use crate::error::{Failure, Result};
use crate::frame::image_from;
use pyo3::prelude::*;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError, RwLock, TryLockError};
use tracecut::image::Frame;
use tracecut::{Params, Progress, Session, Windows};

/// The windows of a clip whose frames Python gives.
pub(crate) type Clip = Windows<Frames, Failure>;

/// A session of its own, or the one that goes through the windows of a clip.
pub(crate) enum Run {
    Session(Box<Session>),
    Windows(Box<Clip>, usize),
}

impl Run {
    pub(crate) fn session(&self) -> &Session {
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
