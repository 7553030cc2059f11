//! Prompts for models that follow an object from a hint.

use crate::arrays::plane;
use crate::error::Result;
use crate::frame::mask_from;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use tracecut::mask;

/// Looks for prompts in masks, one after the other.
#[pyclass(module = "tracecut._tracecut")]
#[derive(Default)]
pub(crate) struct Prompts {
    prompts: mask::Prompts,
    count: usize,
}

#[pymethods]
impl Prompts {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    fn add(&mut self, py: Python<'_>, mask: &Bound<'_, PyAny>) -> Result<()> {
        let mask = mask_from(mask)?;
        py.detach(|| self.prompts.add(self.count, &mask));
        self.count += 1;
        Ok(())
    }

    /// Returns `{object, frame, bounds, inside, outside, mask}` of each object, and starts again.
    fn finish<'py>(&mut self, py: Python<'py>) -> Result<Bound<'py, PyList>> {
        let prompts = std::mem::take(self).prompts;
        let list = PyList::empty(py);
        for prompt in py.detach(|| prompts.finish()) {
            let fields = PyDict::new(py);
            fields.set_item("object", prompt.object)?;
            fields.set_item("frame", prompt.frame)?;
            fields.set_item("bounds", prompt.bounds)?;
            fields.set_item("inside", prompt.inside)?;
            fields.set_item("outside", prompt.outside)?;
            fields.set_item("mask", plane(py, prompt.mask))?;
            list.append(fields)?;
        }
        Ok(list)
    }
}
