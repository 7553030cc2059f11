//! Declaration of parameters, their listing, setting by name and checking.
//!
//! Each stage owns a plain struct of public numbers, declared once through `params!` with name,
//! meaning, default and legal range. From that one declaration come `Default`, the JSON form (camelCase, the same in
//! JSON files, on the command line and in JavaScript), the check of ranges and the refusal of unknown names. The tree
//! of all stages' parameters is [`Params`](crate::Params). Errors have the names of fields, and in JavaScript those of JSON.

mod value;

pub use value::ParamValue;
#[doc(hidden)]
pub use value::{Choice, flatten};

use crate::Error;
use crate::error::{camel_case, shown_name};
use value::Number;

/// One parameter: name, meaning, legal range and value.
#[doc(hidden)] // For the command line and the Python package.
pub struct ParamField<'a> {
    /// Section and name in camelCase, e.g. `flow.patchStride`.
    pub name: String,
    /// The field: section and name in `snake_case`.
    field: String,
    /// Meaning, unit and source. Empty in the wasm module for JavaScript, whose package gets it from the build.
    pub doc: &'static str,
    /// Smallest legal value.
    pub min: f64,
    /// Largest legal value.
    pub max: f64,
    /// True for parameters that only research changes; they are listed separately.
    pub expert: bool,
    value: &'a mut dyn Number,
}

impl std::fmt::Debug for ParamField<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} = {} in {}..={}", self.name, self.value.get(), self.min, self.max)
    }
}

impl ParamField<'_> {
    /// Returns the value: 0 or 1 for a boolean, the index in [`ParamField::choices`] for a choice.
    pub fn get(&self) -> f64 {
        self.value.get()
    }

    /// Returns the names of all values of a choice; none for numbers and booleans.
    pub fn choices(&self) -> &'static [&'static str] {
        self.value.choices()
    }

    /// Returns `number`, `integer`, `boolean` or `choice`.
    pub fn kind(&self) -> &'static str {
        self.value.kind()
    }

    /// Sets the value.
    ///
    /// # Errors
    /// [`Error::Param`] if it is of another type or out of range; the old value stays.
    pub(crate) fn set(&mut self, value: &ParamValue) -> Result<(), Error> {
        let number = self.value.accept(value).filter(|&n| self.is_legal(n));
        match number {
            Some(n) => {
                self.value.put(n);
                Ok(())
            }
            None => Err(self.error(value.to_string())),
        }
    }

    /// Checks that the value is legal.
    ///
    /// # Errors
    /// [`Error::Param`] if it is out of range or not a number.
    pub(crate) fn check(&self) -> Result<(), Error> {
        if self.is_legal(self.get()) { Ok(()) } else { Err(self.error(self.get().to_string())) }
    }

    fn is_legal(&self, number: f64) -> bool {
        (self.min..=self.max).contains(&number)
    }

    fn error(&self, value: String) -> Error {
        let Self { min, max, .. } = self;
        let expected = match self.value.kind() {
            "boolean" => "true or false".to_owned(),
            "choice" => format!("one of {}", self.choices().join(", ")),
            "integer" => format!("a whole number, {min}..={max}"),
            _ => format!("a number, {min}..={max}"),
        };
        Error::Param { name: self.shown_name(), value, expected }
    }

    /// True if this is the parameter's name in JSON, or its field.
    pub(crate) fn is_called(&self, name: &str) -> bool {
        self.name == name || self.field == name
    }

    /// Returns the name for errors.
    pub(crate) fn shown_name(&self) -> String {
        shown_name(&self.field)
    }
}

/// A struct of parameters whose fields can be visited in their order of declaration.
#[doc(hidden)]
pub trait ParamGroup {
    /// Calls `visit` for every field, names prefixed by `section` and a dot.
    fn visit(&mut self, section: &str, visit: &mut dyn FnMut(ParamField<'_>));
}

/// Declares a parameter struct: `/// meaning` `pub name: type = default, in low..=high;`, or `..=high, expert;`.
#[macro_export]
#[doc(hidden)]
macro_rules! params {
    ($(#[$meta:meta])* pub struct $group:ident {
        $($(#[doc = $doc:literal])* pub $field:ident: $type:ty = $default:expr, in $low:literal..=$high:literal $(, $expert:ident)?;)*
    }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize)]
        #[serde(rename_all = "camelCase")]
        #[non_exhaustive]
        pub struct $group {
            $($(#[doc = $doc])* pub $field: $type,)*
        }

        impl Default for $group {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }

        impl $crate::params::ParamGroup for $group {
            fn visit(&mut self, section: &str, visit: &mut dyn FnMut($crate::params::ParamField<'_>)) {
                $(visit($crate::params::ParamField::new(
                    section,
                    stringify!($field),
                    if cfg!(all(target_arch = "wasm32", feature = "wasm")) { "" } else { concat!($($doc, "\n"),*) },
                    $low as f64,
                    $high as f64,
                    !stringify!($($expert)?).is_empty(),
                    &mut self.$field,
                ));)*
            }
        }
    };
}

impl<'a> ParamField<'a> {
    #[doc(hidden)]
    #[allow(private_bounds, reason = "called by the params! macro only, with the number types this module knows")]
    pub fn new<N: Number>(
        section: &str,
        field: &str,
        doc: &'static str,
        min: f64,
        max: f64,
        expert: bool,
        value: &'a mut N,
    ) -> Self {
        let field = if section.is_empty() { field.to_owned() } else { format!("{section}.{field}") };
        Self { name: camel_case(&field), field, doc, min, max, expert, value }
    }
}
