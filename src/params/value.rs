//! Parameter values as they come from JSON, the command line or a JavaScript object.

use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt;

/// One value from outside.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum ParamValue {
    /// true or false
    Bool(bool),
    /// Any number.
    Number(f64),
    /// Any text; the name of a preset, and no legal value of anything else.
    Text(String),
    /// A nested section.
    Section(ParamTree),
    /// `null`, `undefined` or a list.
    Other(serde::de::IgnoredAny),
}

impl fmt::Display for ParamValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bool(b) => write!(f, "{b}"),
            Self::Number(n) => write!(f, "{n}"),
            Self::Text(t) => write!(f, "\"{t}\""),
            Self::Section(_) => f.write_str("{...}"),
            Self::Other(_) => f.write_str("null or a list"),
        }
    }
}

/// A tree of named values, e.g. the parse of `{"flow": {"patchStride": 5}}`.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(transparent)]
pub struct ParamTree(pub BTreeMap<String, ParamValue>);

impl ParamTree {
    /// All values with their dotted names, in the order of the names.
    pub fn flatten(&self) -> Vec<(String, &ParamValue)> {
        let mut leaves = Vec::new();
        for (name, value) in &self.0 {
            match value {
                ParamValue::Section(tree) => {
                    leaves.extend(tree.flatten().into_iter().map(|(inner, v)| (format!("{name}.{inner}"), v)));
                }
                leaf => leaves.push((name.clone(), leaf)),
            }
        }
        leaves
    }
}

/// A field's type: how it reads a [`ParamValue`] and shows itself as a number.
pub(super) trait Number {
    fn kind(&self) -> &'static str;
    fn get(&self) -> f64;
    fn put(&mut self, number: f64);
    /// The value as this type's number; `None` if it is of another type.
    fn accept(&self, value: &ParamValue) -> Option<f64> {
        match value {
            ParamValue::Number(n) if n.is_finite() => Some(*n),
            _ => None,
        }
    }
}

impl Number for f32 {
    fn kind(&self) -> &'static str {
        "number"
    }
    /// Through the shortest decimal form, so that 0.1 stays 0.1 on its way out and in again.
    fn get(&self) -> f64 {
        self.to_string().parse().unwrap_or(f64::NAN)
    }
    fn put(&mut self, number: f64) {
        *self = number as f32;
    }
}

impl Number for f64 {
    fn kind(&self) -> &'static str {
        "number"
    }
    fn get(&self) -> f64 {
        *self
    }
    fn put(&mut self, number: f64) {
        *self = number;
    }
}

impl Number for u32 {
    fn kind(&self) -> &'static str {
        "integer"
    }
    fn get(&self) -> f64 {
        f64::from(*self)
    }
    fn put(&mut self, number: f64) {
        *self = number as u32;
    }
    fn accept(&self, value: &ParamValue) -> Option<f64> {
        match value {
            ParamValue::Number(n) if n.fract() == 0.0 => Some(*n),
            _ => None,
        }
    }
}

impl Number for bool {
    fn kind(&self) -> &'static str {
        "boolean"
    }
    fn get(&self) -> f64 {
        f64::from(u8::from(*self))
    }
    fn put(&mut self, number: f64) {
        *self = number != 0.0;
    }
    fn accept(&self, value: &ParamValue) -> Option<f64> {
        match value {
            ParamValue::Bool(b) => Some(f64::from(u8::from(*b))),
            _ => None,
        }
    }
}
