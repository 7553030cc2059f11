//! Parameters: how they are declared, listed, set by name and checked.
//!
//! Each stage owns a plain struct of public numbers, declared once through [`params!`](crate::params) with name, meaning,
//! default and legal range. From that one declaration come `Default`, the JSON form (camelCase, the same in JSON files, on the
//! command line and in JavaScript), the check of ranges and the refusal of unknown names.

mod value;

#[doc(hidden)]
pub use value::Choice;
pub use value::{ParamTree, ParamValue};

use crate::Error;
use crate::affinity::AffinityParams;
use crate::connectedness::ConnectednessParams;
use crate::contour::ContourParams;
use crate::cut::{CutParams, RefineParams};
use crate::discontinuity::DiscontinuityParams;
use crate::discretize::DiscretizeParams;
use crate::embedding::EmbeddingParams;
use crate::flow::FlowParams;
use crate::saliency::SaliencyParams;
use crate::shot::ShotParams;
use crate::still::StillParams;
use crate::superpixel::SuperpixelParams;
use crate::trajectory::TrajectoryParams;
use serde::Serialize;
use value::Number;

/// One parameter as the outside sees it: its name, meaning and range, and its value to read or write.
pub struct ParamField<'a> {
    /// Section and name in camelCase, e.g. `flow.patchStride`.
    pub name: String,
    /// What it means, its unit and its source.
    pub doc: &'static str,
    /// Smallest and largest legal value.
    pub range: (f64, f64),
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
    pub fn set(&mut self, value: &ParamValue) -> Result<(), Error> {
        let number = self.value.accept(value).filter(|n| (self.range.0..=self.range.1).contains(n));
        match number {
            Some(n) => {
                self.value.put(n);
                Ok(())
            }
            None => Err(self.error(value.to_string())),
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
pub trait ParamGroup {
    /// Calls `visit` for every field, names prefixed by `section` and a dot.
    fn visit(&mut self, section: &str, visit: &mut dyn FnMut(ParamField<'_>));
}

/// Declares a parameter struct: `/// meaning` `pub name: type = default, in low..=high;`.
#[macro_export]
#[doc(hidden)]
macro_rules! params {
    ($(#[$meta:meta])* pub struct $group:ident {
        $($(#[doc = $doc:literal])* pub $field:ident: $type:ty = $default:expr, in $low:literal..=$high:literal;)*
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
                    section, stringify!($field), concat!($($doc, "\n"),*), ($low as f64, $high as f64), &mut self.$field,
                ));)*
            }
        }
    };
}

impl<'a> ParamField<'a> {
    #[doc(hidden)]
    #[allow(private_bounds, reason = "called by the params! macro only, with the number types this module knows")]
    pub fn new<N: Number>(section: &str, field: &str, doc: &'static str, range: (f64, f64), value: &'a mut N) -> Self {
        let name = if section.is_empty() { camel(field) } else { format!("{section}.{}", camel(field)) };
        Self { name, doc, range, value }
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

crate::params! {
    /// Settings of the clip as a whole.
    pub struct ClipParams {
        /// Longest side at which frames are processed, in pixels; larger frames are reduced and every result is mapped back to
        /// input pixels. Higher is slower and finds smaller objects.
        pub max_side: u32 = 640, in 16..=4096;
        /// Whether every pixel gets a label; without, a run ends with the labels of the trajectories.
        pub dense: bool = true, in 0..=1;
        /// Seed of all pseudo-random choices.
        pub seed: u32 = 0, in 0..=4294967295_u32;
    }
}

/// All parameters, one group a stage. Start from `Params::default()` and change fields, or set them by name.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Params {
    /// The clip as a whole.
    pub clip: ClipParams,
    /// Cuts between shots.
    pub shot: ShotParams,
    /// Dense optical flow.
    pub flow: FlowParams,
    /// Point trajectories.
    pub trajectory: TrajectoryParams,
    /// Motion affinities.
    pub affinity: AffinityParams,
    /// Spectral embedding.
    pub embedding: EmbeddingParams,
    /// Embedding discontinuities.
    pub discontinuity: DiscontinuityParams,
    /// Saliency and foreground.
    pub saliency: SaliencyParams,
    /// Object connectedness.
    pub connectedness: ConnectednessParams,
    /// Discontinuity-aware discretization.
    pub discretize: DiscretizeParams,
    /// Boundary probability and contours.
    pub contour: ContourParams,
    /// Gabriel superpixels.
    pub superpixel: SuperpixelParams,
    /// The Gabriel cut.
    pub cut: CutParams,
    /// Borders to the pixel.
    pub refine: RefineParams,
    /// Pixel embedding of single images.
    pub still: StillParams,
}

impl ParamGroup for Params {
    fn visit(&mut self, _: &str, visit: &mut dyn FnMut(ParamField<'_>)) {
        self.clip.visit("clip", visit);
        self.shot.visit("shot", visit);
        self.flow.visit("flow", visit);
        self.trajectory.visit("trajectory", visit);
        self.affinity.visit("affinity", visit);
        self.embedding.visit("embedding", visit);
        self.discontinuity.visit("discontinuity", visit);
        self.saliency.visit("saliency", visit);
        self.connectedness.visit("connectedness", visit);
        self.discretize.visit("discretize", visit);
        self.contour.visit("contour", visit);
        self.superpixel.visit("superpixel", visit);
        self.cut.visit("cut", visit);
        self.refine.visit("refine", visit);
        self.still.visit("still", visit);
    }
}

/// The name under which a preset is chosen from outside.
const PRESET: &str = "preset";

impl Params {
    /// Saliency and connectedness as the paper has them ([`SaliencyParams::paper`], [`ConnectednessParams::paper`]), and the dense half:
    /// contours above a threshold that is not low, superpixels as the Gabriel graph leaves them, the energy of [`CutParams::paper`],
    /// masks from the clustered trajectories alone, borders where the superpixels have them. Everything else is as by default.
    pub fn paper() -> Self {
        let mut params = Self {
            saliency: SaliencyParams::paper(),
            connectedness: ConnectednessParams::paper(),
            cut: CutParams::paper(),
            ..Self::default()
        };
        params.trajectory.mask_step = params.trajectory.grid_step;
        params.trajectory.mask_min_length = params.trajectory.min_length;
        (params.contour.low, params.contour.high) = (0.03, 0.08);
        params.superpixel.join_below = 0.0;
        params.refine.band = 0;
        params
    }

    /// Sets the parameter `name` (e.g. `flow.patchStride`). The name `preset` sets all parameters, to `default` or to `paper`
    /// ([`Params::paper`]).
    ///
    /// # Errors
    /// [`Error::Param`] when no parameter has this name (the message lists near ones) or the value is not legal.
    pub fn set(&mut self, name: &str, value: &ParamValue) -> Result<(), Error> {
        if name == PRESET {
            return self.choose(value);
        }
        let mut outcome = None;
        let mut names = Vec::new();
        self.visit("", &mut |mut field| {
            if field.name == name {
                outcome = Some(field.set(value));
            }
            names.push(field.name);
        });
        outcome.unwrap_or_else(|| {
            Err(Error::Param {
                name: name.to_owned(),
                value: value.to_string(),
                expected: format!("a known parameter, such as {}", nearest(name, &names)),
            })
        })
    }

    fn choose(&mut self, preset: &ParamValue) -> Result<(), Error> {
        *self = match preset {
            ParamValue::Text(name) if name == "default" => Self::default(),
            ParamValue::Text(name) if name == "paper" => Self::paper(),
            other => {
                let expected = "default or paper".to_owned();
                return Err(Error::Param { name: PRESET.to_owned(), value: other.to_string(), expected });
            }
        };
        Ok(())
    }

    /// Sets every parameter named in `tree`, e.g. from `{"flow": {"patchStride": 5}}`; a `preset` goes first, whatever its place.
    /// On an error nothing is changed.
    ///
    /// # Errors
    /// As [`Params::set`].
    pub fn apply(&mut self, tree: &ParamTree) -> Result<(), Error> {
        let mut changed = self.clone();
        if let Some(preset) = tree.0.get(PRESET) {
            changed.choose(preset)?;
        }
        for (name, value) in tree.flatten() {
            if name != PRESET {
                changed.set(&name, value)?;
            }
        }
        *self = changed;
        Ok(())
    }

    /// Checks every value against its range.
    ///
    /// # Errors
    /// [`Error::Param`] for the first value that is out of range or not a number.
    pub fn validate(&self) -> Result<(), Error> {
        let mut first = Ok(());
        self.clone().visit("", &mut |field| {
            let legal = (field.range.0..=field.range.1).contains(&field.get());
            if first.is_ok() && !legal {
                first = Err(field.error(field.get().to_string()));
            }
        });
        first
    }
}

/// The few of `names` most like `name`, by common letter pairs.
fn nearest(name: &str, names: &[String]) -> String {
    let pairs = |s: &str| -> Vec<[char; 2]> {
        let letters: Vec<char> = s.to_ascii_lowercase().chars().collect();
        letters.windows(2).map(|w| [w[0], w[1]]).collect()
    };
    let wanted = pairs(name);
    let mut scored: Vec<(usize, &String)> =
        names.iter().map(|n| (pairs(n).iter().filter(|p| wanted.contains(p)).count(), n)).collect();
    crate::order::sort_by_key(&mut scored, |&(common, _)| u64::MAX - common as u64);
    scored.iter().take(3).map(|(_, n)| n.as_str()).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_legal_and_every_parameter_is_documented() {
        Params::default().validate().unwrap();
        let mut count = 0;
        Params::default().visit("", &mut |field| {
            assert!(field.doc.len() > 10, "{} has no doc", field.name);
            count += 1;
        });
        assert!(count > 20, "{count} parameters");
    }

    #[test]
    fn names_values_and_ranges_are_checked() {
        let mut params = Params::default();
        params.set("clip.maxSide", &ParamValue::Number(320.0)).unwrap();
        assert_eq!(params.clip.max_side, 320);
        let misspelt = params.set("clip.maxSize", &ParamValue::Number(320.0)).unwrap_err().to_string();
        assert!(misspelt.contains("clip.maxSide"), "{misspelt}");
        let message = params.set("clip.maxSide", &ParamValue::Number(2.0)).unwrap_err().to_string();
        assert_eq!(message, "clip.maxSide = 2 (expected a whole number, 16..=4096)");
        assert!(params.set("clip.maxSide", &ParamValue::Number(320.5)).is_err());
        assert!(params.set("clip.maxSide", &ParamValue::Text("big".into())).is_err());
        assert_eq!(params.clip.max_side, 320);
    }

    #[test]
    fn a_tree_with_one_bad_name_changes_nothing() {
        let tree: ParamTree = serde_json::from_str(r#"{"clip": {"maxSide": 100, "oops": 1}}"#).unwrap();
        let mut params = Params::default();
        assert!(params.apply(&tree).is_err());
        assert_eq!(params, Params::default());
    }

    #[test]
    fn serialized_parameters_can_be_applied_again() {
        let mut params = Params::default();
        params.clip.max_side = 123;
        let text = serde_json::to_string(&params).unwrap();
        let mut again = Params::default();
        again.apply(&serde_json::from_str(&text).unwrap()).unwrap();
        assert_eq!(again, params);
    }

    #[test]
    fn a_preset_comes_before_what_is_set_beside_it() {
        let tree: ParamTree = serde_json::from_str(r#"{"cut": {"byLength": true}, "preset": "paper"}"#).unwrap();
        let mut params = Params::default();
        params.apply(&tree).unwrap();
        assert!(params.cut.by_length && params.cut.ambiguous_share == 0.3 && params.refine.band == 0);
        params.set("preset", &ParamValue::Text("default".into())).unwrap();
        assert_eq!(params, Params::default());
        let message = params.set("preset", &ParamValue::Number(1.0)).unwrap_err().to_string();
        assert_eq!(message, "preset = 1 (expected default or paper)");
    }

    #[test]
    fn not_a_number_is_out_of_every_range() {
        let mut params = Params::default();
        params.affinity.lambda = f32::NAN;
        assert_eq!(params.validate().unwrap_err().code(), "param");
    }
}
