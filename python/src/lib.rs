//! The Python module `tracecut._tracecut`, on which the Python files of the package `tracecut` are built.
//!
//! Every function converts, makes a call of the library without the interpreter's lock, and converts back. Public
//! names, types and defaults are in the Python files. Results computed for the call become arrays without a copy; results kept
//! by a session are copied once, as they may change under the array.

mod arrays;
mod error;
mod files;
mod frame;
mod images;
mod names;
mod params;
mod prompts;
mod run;
mod scene;
mod session;
mod why;
mod windows;

use pyo3::prelude::*;

/// Native part of `tracecut`.
#[pymodule]
mod _tracecut {
    #[pymodule_export]
    use crate::files::{decode, palette_png, read_tracks, run_counts, run_lengths, run_mask, run_text, write_tracks};
    #[pymodule_export]
    use crate::images::{boundaries, enlarge, flow, image_discontinuities, superpixels};
    #[pymodule_export]
    use crate::params::parameters;
    #[pymodule_export]
    use crate::prompts::Prompts;
    #[pymodule_export]
    use crate::scene::Scene;
    #[pymodule_export]
    use crate::session::Session;
    #[pymodule_export]
    use crate::windows::Windows;

    use super::{Bound, PyModule, PyModuleMethods, PyResult, pyfunction};

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
