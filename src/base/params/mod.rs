//! Parameters: how they are declared, listed, set by name and checked.
//!
//! Each stage owns a plain struct of public numbers, declared once through [`params!`](crate::params) with name,
//! meaning, default and legal range. From that one declaration come `Default`, the JSON form (camelCase, the same in
//! JSON files, on the command line and in JavaScript), the check of ranges and the refusal of unknown names. The tree
//! of all stages' parameters is [`Params`](crate::Params).

mod value;

#[doc(hidden)]
pub use value::Choice;
pub use value::{ParamTree, ParamValue};

use crate::Error;
use value::Number;

/// One parameter as the outside sees it: its name, meaning and range, and its value.
pub struct ParamField<'a> {
    /// Section and name in camelCase, e.g. `flow.patchStride`.
    pub name: String,
    /// What it means, its unit and its source; empty in the wasm module for JavaScript, whose package has it from the build.
    pub doc: &'static str,
    /// Smallest and largest legal value.
    pub range: (f64, f64),
    /// Whether only research changes it: such parameters are listed apart.
    pub expert: bool,
    value: &'a mut dyn Number,
}

impl std::fmt::Debug for ParamField<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} = {} in {:?}", self.name, self.value.get(), self.range)
    }
}

impl ParamField<'_> {
    /// The present value; truth values read as 0 or 1, choices as their place among [`ParamField::choices`].
    pub fn get(&self) -> f64 {
        self.value.get()
    }

    /// The names of all values of a choice; empty for numbers and truth values.
    pub fn choices(&self) -> &'static [&'static str] {
        self.value.choices()
    }

    /// `number`, `integer`, `boolean` or `choice`.
    pub fn kind(&self) -> &'static str {
        self.value.kind()
    }

    /// Sets the value.
    ///
    /// # Errors
    /// [`Error::Param`] when it is of another type or out of range; the old value stays.
    pub(crate) fn set(&mut self, value: &ParamValue) -> Result<(), Error> {
        let number = self.value.accept(value).filter(|n| (self.range.0..=self.range.1).contains(n));
        match number {
            Some(n) => {
                self.value.put(n);
                Ok(())
            }
            None => Err(self.error(value.to_string())),
        }
    }

    /// Whether the present value is legal.
    ///
    /// # Errors
    /// [`Error::Param`] when it is out of range or not a number.
    pub(crate) fn check(&self) -> Result<(), Error> {
        match (self.range.0..=self.range.1).contains(&self.get()) {
            true => Ok(()),
            false => Err(self.error(self.get().to_string())),
        }
    }

    fn error(&self, value: String) -> Error {
        let (low, high) = self.range;
        let expected = match self.value.kind() {
            "boolean" => "true or false".to_owned(),
            "choice" => format!("one of {}", self.choices().join(", ")),
            "integer" => format!("a whole number, {low}..={high}"),
            _ => format!("a number, {low}..={high}"),
        };
        Error::Param { name: self.name.clone(), value, expected }
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
                    ($low as f64, $high as f64),
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
        range: (f64, f64),
        expert: bool,
        value: &'a mut N,
    ) -> Self {
        let name = if section.is_empty() { camel(field) } else { format!("{section}.{}", camel(field)) };
        Self { name, doc, range, expert, value }
    }
}

fn camel(snake: &str) -> String {
    let mut words = snake.split('_');
    let mut name = words.next().unwrap_or_default().to_owned();
    for word in words {
        let mut letters = word.chars();
        name.extend(letters.next().map(|c| c.to_ascii_uppercase()));
        name.push_str(letters.as_str());
    }
    name
}
