//! What goes wrong: an error of the library, or an exception of Python on its way through.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;
use tracecut::Error;

/// An error of the library, or an exception that a callback or an iterator of the user's raised.
#[derive(Debug)]
pub(crate) enum Failure {
    Own(Error),
    Python(PyErr),
}

pub(crate) type Result<T> = std::result::Result<T, Failure>;

impl Failure {
    /// Input that is not of the documented form.
    pub(crate) fn data(reason: String) -> Self {
        Self::Own(Error::Data { reason })
    }

    /// A call at the wrong time.
    pub(crate) fn state(reason: &str) -> Self {
        Self::Own(Error::State { reason: reason.to_owned() })
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Own(error)
    }
}

impl From<PyErr> for Failure {
    fn from(error: PyErr) -> Self {
        Self::Python(error)
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Python(error) => error,
            Failure::Own(error) => Python::attach(|py| exception(py, &error)),
        }
    }
}

/// Returns a `tracecut.TraceCutError` with the code and the message of `error`.
fn exception(py: Python<'_>, error: &Error) -> PyErr {
    static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    let exception =
        CLASS.import(py, "tracecut._errors", "TraceCutError").and_then(|c| c.call1((error.code(), error.to_string())));
    match exception {
        Ok(value) => PyErr::from_value(value),
        Err(_) => PyRuntimeError::new_err(error.to_string()),
    }
}
