//! Parameter values from JSON, the command line or a JavaScript object.

use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt;

/// A value given by the caller.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged)]
#[non_exhaustive]
pub enum ParamValue {
    /// `null` or `undefined`; illegal.
    Null,
    /// A boolean.
    Bool(bool),
    /// Any number.
    Number(f64),
    /// Any text: the name of a preset or of a choice; illegal for other parameters.
    Text(String),
    /// A list; illegal.
    List(Vec<ParamValue>),
    /// A nested section: values by their names.
    Section(BTreeMap<String, ParamValue>),
}

impl fmt::Display for ParamValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bool(b) => write!(f, "{b}"),
            Self::Number(n) => write!(f, "{n}"),
            Self::Text(t) => write!(f, "\"{t}\""),
            Self::Null => f.write_str("null"),
            Self::List(_) => f.write_str("[...]"),
            Self::Section(_) => f.write_str("{...}"),
        }
    }
}

/// Returns all values of a tree with their dotted names, in the order of the names.
#[doc(hidden)]
pub fn flatten(tree: &BTreeMap<String, ParamValue>) -> Vec<(String, &ParamValue)> {
    let mut leaves = Vec::new();
    for (name, value) in tree {
        match value {
            ParamValue::Section(tree) => {
                leaves.extend(flatten(tree).into_iter().map(|(inner, v)| (format!("{name}.{inner}"), v)));
            }
            leaf => leaves.push((name.clone(), leaf)),
        }
    }
    leaves
}

/// The type of a parameter: reads a [`ParamValue`] and converts from and to a number.
pub(super) trait Number {
    fn kind(&self) -> &'static str;
    fn get(&self) -> f64;
    fn put(&mut self, number: f64);
    /// Converts `value` to a number; `None` if it is of another type.
    fn accept(&self, value: &ParamValue) -> Option<f64> {
        match value {
            ParamValue::Number(n) if n.is_finite() => Some(*n),
            _ => None,
        }
    }
    /// Returns the names of all values, where they have names.
    fn choices(&self) -> &'static [&'static str] {
        &[]
    }
}

impl Number for f32 {
    fn kind(&self) -> &'static str {
        "number"
    }
    /// Returns the number with fewest decimals that rounds to this one in single precision, so that 0.1 stays 0.1 when
    /// written and read. (Formatting and parsing would be shorter here and add 13 KB to the wasm file.)
    fn get(&self) -> f64 {
        let exact = f64::from(*self);
        let mut scale = 1.0;
        for _ in 0..=9 {
            let decimal = (exact * scale).round() / scale;
            if decimal as f32 == *self {
                return decimal;
            }
            scale *= 10.0;
        }
        exact
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

/// An enum of named alternatives, declared by [`choices!`](crate::choices).
#[doc(hidden)]
pub trait Choice: Copy {
    /// The names, in the order of declaration.
    const NAMES: &'static [&'static str];
    /// Returns the index in that order.
    fn index(self) -> usize;
    /// Returns the alternative at `index`, or the last one.
    fn at(index: usize) -> Self;
}

/// Declares an enum that can be a parameter: `/// meaning` `Variant = "name",`, counted from 0.
#[macro_export]
#[doc(hidden)]
macro_rules! choices {
    ($(#[$meta:meta])* pub enum $choice:ident { $($(#[$doc:meta])* $variant:ident = $name:literal,)* }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[non_exhaustive]
        pub enum $choice {
            $($(#[$doc])* $variant,)*
        }

        impl $crate::params::Choice for $choice {
            const NAMES: &'static [&'static str] = &[$($name),*];
            fn index(self) -> usize {
                self as usize
            }
            fn at(index: usize) -> Self {
                let variants = [$(Self::$variant),*];
                variants[index.min(variants.len() - 1)]
            }
        }

        impl serde::Serialize for $choice {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(<Self as $crate::params::Choice>::NAMES[*self as usize])
            }
        }
    };
}

impl<C: Choice> Number for C {
    fn kind(&self) -> &'static str {
        "choice"
    }
    fn get(&self) -> f64 {
        self.index() as f64
    }
    fn put(&mut self, number: f64) {
        *self = C::at(number as usize);
    }
    fn accept(&self, value: &ParamValue) -> Option<f64> {
        match value {
            ParamValue::Text(name) => C::NAMES.iter().position(|n| n == name).map(|k| k as f64),
            _ => None,
        }
    }
    fn choices(&self) -> &'static [&'static str] {
        C::NAMES
    }
}

#[cfg(test)]
mod tests {
    use super::Number;

    #[test]
    fn single_precision_reads_as_its_shortest_decimal() {
        let decimals = [
            0.1,
            0.002,
            0.72,
            1e-4,
            0.0,
            -0.5,
            16.0,
            1000.0,
            3.25,
            0.000_01,
            4_096.0,
            0.333_333_34,
            123.456,
            16_777_216.0,
        ];
        for value in decimals.into_iter().chain((0..2000).map(|k| k as f32 * 0.0125 - 3.7)) {
            let through_text: f64 = value.to_string().parse().unwrap();
            assert_eq!(Number::get(&value), through_text, "{value}");
        }
        assert!(Number::get(&f32::NAN).is_nan());
        assert_eq!(Number::get(&f32::MIN_POSITIVE) as f32, f32::MIN_POSITIVE);
    }
}
