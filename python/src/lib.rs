//! The Python module `tracecut._tracecut`, on which the Python files of the package `tracecut` are built.
//!
//! Every function converts, makes a call of the library without the interpreter's lock, and converts back. Public
//! names, types and defaults are in the Python files. Results computed for the call become arrays without a copy; results kept
//! by a session are copied once, as they may change under the array.

mod arrays;
mod error;
mod files;
mod images;
mod params;
mod run;
mod scene;
mod session;

use pyo3::prelude::*;
use std::ffi::OsString;
use std::iter;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Native part of `tracecut`.
#[pymodule]
mod _tracecut {
    #[pymodule_export]
    use crate::files::Prompts;
    #[pymodule_export]
    use crate::files::{decode, palette_png, read_tracks, run_counts, run_lengths, run_mask, run_text, write_tracks};
    #[pymodule_export]
    use crate::images::{boundaries, enlarge, flow, image_discontinuities, superpixels};
    #[pymodule_export]
    use crate::params::parameters;
    #[pymodule_export]
    use crate::run::Windows;
    #[pymodule_export]
    use crate::scene::Scene;
    #[pymodule_export]
    use crate::session::Session;

    use super::{AssertUnwindSafe, Bound, OsString, PyModule, PyModuleMethods, PyResult, Python};
    use super::{catch_unwind, iter, pyfunction};

    /// Runs the command line with these arguments and returns its exit code. Installs its handlers of signals, which end the
    /// process.
    #[pyfunction]
    fn run_program(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
        let arguments = iter::once("tracecut".into()).chain(arguments);
        let run = AssertUnwindSafe(|| tracecut_cli::run_program(arguments));
        // The code of a Rust program that panics, after the message of the panic.
        py.detach(|| catch_unwind(run).unwrap_or(101))
    }

    /// A fault on purpose: tests see that it becomes an exception, and not the end of the process.
    #[pyfunction]
    fn panic_on_purpose() {
        std::panic::panic_any("on purpose");
    }

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("window_frames", tracecut::Window::FRAMES)?;
        module.add("stage_costs", tracecut::Stage::ALL.map(|stage| (stage.name(), stage.cost())).to_vec())?;
        module.add("version", env!("CARGO_PKG_VERSION"))
    }
}
