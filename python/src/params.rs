//! Parameters from keyword arguments and dictionaries. Their names are snake_case in Python, camelCase in JSON.

use crate::error::Result;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};
use std::collections::BTreeMap;
use tracecut::Params;
use tracecut::params::ParamValue;

/// The default parameters changed by `options`, such as `{"flow": {"patch_stride": 5}}` or `{"flow.patch_stride": 5}`.
pub(crate) fn params_from(options: &Bound<'_, PyDict>) -> Result<Params> {
    let mut params = Params::default();
    params.apply(&tree(options)?)?;
    Ok(params)
}

fn tree(options: &Bound<'_, PyDict>) -> Result<BTreeMap<String, ParamValue>> {
    let mut entries = BTreeMap::new();
    for (name, value) in options {
        entries.insert(name.str()?.to_string_lossy().into_owned(), value_of(&value)?);
    }
    Ok(entries)
}

fn value_of(value: &Bound<'_, PyAny>) -> Result<ParamValue> {
    if let Ok(section) = value.cast::<PyDict>() {
        return Ok(ParamValue::Section(tree(section)?));
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(ParamValue::Text(text.to_string_lossy().into_owned()));
    }
    if value.is_instance_of::<PyBool>() {
        return Ok(ParamValue::Bool(value.extract()?));
    }
    // NumPy's truth values are numbers too.
    if value.get_type().name()?.to_string_lossy().starts_with("bool") {
        return Ok(ParamValue::Bool(value.is_truthy()?));
    }
    Ok(value.extract().map_or(ParamValue::Null, ParamValue::Number))
}

/// Name, meaning, kind, least, greatest and default value, choices.
type Parameter = (String, &'static str, &'static str, f64, f64, f64, &'static [&'static str]);

/// The parameters that are marked `expert`, or those that are not, in the order of the stages.
#[pyfunction]
pub(crate) fn parameters(expert: bool) -> Vec<Parameter> {
    let mut list = Vec::new();
    Params::default().for_each(&mut |field| {
        let (low, high) = (field.min, field.max);
        let (doc, kind, default, choices) = (field.doc.trim(), field.kind(), field.get(), field.choices());
        if field.expert == expert {
            list.push((snake(&field.name), doc, kind, low, high, default, choices));
        }
    });
    list
}

/// The values in force as a dictionary of sections.
pub(crate) fn params_in_force<'py>(py: Python<'py>, params: &Params) -> Result<Bound<'py, PyDict>> {
    let tree = PyDict::new(py);
    let mut outcome = Ok(());
    params.clone().for_each(&mut |field| {
        if outcome.is_ok() {
            outcome = put(&tree, &snake(&field.name), field.kind(), field.get(), field.choices());
        }
    });
    outcome?;
    Ok(tree)
}

/// Sets `section.name` in a tree to a value as the library shows it: truth values as 0 or 1, choices as their place.
fn put(tree: &Bound<'_, PyDict>, name: &str, kind: &str, value: f64, choices: &[&str]) -> PyResult<()> {
    let (section, name) = name.split_once('.').unwrap_or(("", name));
    let inner = match tree.get_item(section)? {
        Some(inner) => inner.cast_into::<PyDict>()?,
        None => {
            let inner = PyDict::new(tree.py());
            tree.set_item(section, &inner)?;
            inner
        }
    };
    match kind {
        "boolean" => inner.set_item(name, value != 0.0),
        "choice" => inner.set_item(name, choices.get(value as usize)),
        "integer" => inner.set_item(name, value as i64),
        _ => inner.set_item(name, value),
    }
}

/// Converts `patchStride` to `patch_stride`.
pub(crate) fn snake(name: &str) -> String {
    let mut out = String::with_capacity(name.len() + 8);
    for letter in name.chars() {
        if letter.is_ascii_uppercase() {
            out.push('_');
        }
        out.push(letter.to_ascii_lowercase());
    }
    out
}
