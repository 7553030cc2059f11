//! The parameters of all stages in one tree, set by name, and their values scaled to a clip.

use crate::Error;
use crate::affinity::AffinityParams;
use crate::background::BackgroundParams;
use crate::connectedness::ConnectednessParams;
use crate::contour::ContourParams;
use crate::cut::{CutParams, VOTE_RADIUS_PX};
use crate::discontinuity::DiscontinuityParams;
use crate::discretize::{DiscretizeMethod, DiscretizeParams};
use crate::embedding::EmbeddingParams;
use crate::flow::FlowParams;
use crate::image::MAX_PIXELS;
use crate::mask::RefineParams;
use crate::params::{ParamField, ParamGroup, ParamValue, flatten};
use crate::saliency::SaliencyParams;
use crate::session::window::ShotParams;
use crate::still::StillParams;
use crate::superpixel::SuperpixelParams;
use crate::trajectory::{Trajectories, TrajectoryParams};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;
use std::ops::Deref;

crate::params! {
    /// Parameters of the whole clip.
    pub struct ClipParams {
        /// Longest side at which frames are processed, in pixels; larger frames are reduced and every result is mapped
        /// back to input pixels. Higher is slower and finds smaller objects.
        pub max_side: u32 = 640, in 16..=4096;
        /// Side of the square frame that lengths refer to, in pixels: in a smaller frame the distances of trajectories and
        /// radii around them are reduced in proportion, down to one half, so that an object has the same number of points
        /// at any size. 0 turns this off. Default: the area of 480×270.
        pub reference_side: u32 = 360, in 0..=4096, expert;
        /// Computes masks; otherwise a run ends with the labels of the trajectories.
        pub dense: bool = true, in 0..=1;
        /// Largest number of pixels of an input frame. Larger frames are errors (`too-large`), before memory is allocated.
        pub max_pixels: u32 = MAX_PIXELS as u32, in 1..=268435456, expert;
        /// Largest number of frames of a session, or of a window of a long clip.
        pub max_frames: u32 = 10000, in 2..=1000000, expert;
        /// Largest number of trajectories.
        pub max_trajectories: u32 = 1000000, in 1..=100000000, expert;
        /// Largest number of points of trajectories from another tracker.
        pub max_points: u32 = 100000000, in 1..=4294967295_u32, expert;
        /// Seed of all pseudo-random numbers.
        pub seed: u32 = 0, in 0..=4294967295_u32;
    }
}

impl ClipParams {
    /// Checks the number of pixels of a frame, whose size must be valid ([`crate::image::Frame`]).
    pub(crate) fn check_pixels(&self, width: usize, height: usize) -> Result<(), Error> {
        Error::check_limit(width * height, self.max_pixels, "pixels in a frame", "clip.max_pixels")
    }

    /// Checks the number of frames.
    pub(crate) fn check_frames(&self, count: usize) -> Result<(), Error> {
        Error::check_limit(count, self.max_frames, "frames in a session", "clip.max_frames")
    }

    /// Checks the number of trajectories.
    pub(crate) fn check_trajectories(&self, count: usize) -> Result<(), Error> {
        Error::check_limit(count, self.max_trajectories, "trajectories", "clip.max_trajectories")
    }

    /// Checks the counts of trajectories from another tracker.
    pub(crate) fn check_external(&self, tracks: &Trajectories) -> Result<(), Error> {
        self.check_frames(tracks.num_frames)?;
        self.check_trajectories(tracks.start_frame.len())?;
        Error::check_limit(tracks.x.len(), self.max_points, "points of trajectories", "clip.max_points")
    }
}

/// Declares the tree: `/// meaning` `name: group,`. Names are the sections in options.
macro_rules! tree {
    ($(#[$meta:meta])* pub struct $tree:ident { $($(#[$doc:meta])* $name:ident: $group:ty,)* }) => {
        $(#[$meta])*
        #[non_exhaustive]
        pub struct $tree {
            $($(#[$doc])* pub $name: $group,)*
        }

        impl ParamGroup for $tree {
            fn visit(&mut self, _: &str, visit: &mut dyn FnMut(ParamField<'_>)) {
                $(self.$name.visit(stringify!($name), visit);)*
            }
        }
    };
}

tree! {
    /// All parameters, one group per stage. Start from `Params::default()` and change fields, or set them by name.
    #[derive(Debug, Clone, PartialEq, Default, Serialize)]
    #[serde(rename_all = "camelCase")]
    pub struct Params {
        /// The clip as a whole.
        clip: ClipParams,
        /// Cuts between shots.
        shot: ShotParams,
        /// Dense optical flow.
        flow: FlowParams,
        /// Point trajectories.
        trajectory: TrajectoryParams,
        /// Motion affinities.
        affinity: AffinityParams,
        /// Spectral embedding.
        embedding: EmbeddingParams,
        /// Embedding discontinuities.
        discontinuity: DiscontinuityParams,
        /// Saliency and foreground.
        saliency: SaliencyParams,
        /// Object connectedness.
        connectedness: ConnectednessParams,
        /// Discontinuity-aware discretization.
        discretize: DiscretizeParams,
        /// Boundary probability and contours.
        contour: ContourParams,
        /// Gabriel superpixels.
        superpixel: SuperpixelParams,
        /// The Gabriel cut.
        cut: CutParams,
        /// The background of still cameras.
        background: BackgroundParams,
        /// Borders to the pixel.
        refine: RefineParams,
        /// Pixel embedding of single images.
        still: StillParams,
    }
}

/// Reads a tree of options as [`Params::apply`] does, and starts from the defaults.
impl<'de> Deserialize<'de> for Params {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut params = Self::default();
        params.apply(&BTreeMap::deserialize(deserializer)?).map_err(D::Error::custom)?;
        Ok(params)
    }
}

/// The name of the option that chooses a preset.
const PRESET: &str = "preset";

impl Params {
    /// Returns the parameters of the paper: both flow fields refined, its saliency and connectedness, its merging of clusters into one clustering, Pb at
    /// full size, contours with a higher threshold, its energy, masks from the clustered trajectories alone, borders of
    /// superpixels, and no background model. All other parameters are the defaults.
    pub fn paper() -> Self {
        let mut params = Self {
            saliency: SaliencyParams::paper(),
            connectedness: ConnectednessParams::paper(),
            cut: CutParams::paper(),
            ..Self::default()
        };
        params.discretize.method = DiscretizeMethod::RotationMerge;
        params.discretize.min_agreement = 0.0;
        params.trajectory.mask_step = params.trajectory.grid_step;
        params.trajectory.mask_min_length = params.trajectory.min_length;
        params.flow.max_side = 4096;
        (params.contour.half_size_min_side, params.contour.min_share) = (65536, 0.0);
        (params.refine.band, params.refine.min_part) = (0, 0.0);
        params.background.enabled = false;
        params.clip.reference_side = 0;
        params
    }

    /// Returns the parameters of the flow. Without masks it is computed at full size: mask borders are refined to the pixel
    /// afterwards, but trajectories beside borders depend on the flow alone.
    pub(crate) fn for_flow(&self) -> FlowParams {
        let max_side = if self.clip.dense { self.flow.max_side } else { u32::MAX };
        FlowParams { max_side, ..self.flow.clone() }
    }

    /// Returns parameters for a preview in little more than half of the time: smaller frames, contours at half size, and less
    /// exact flow. Small and fast objects may be lost.
    pub fn fast() -> Self {
        let mut params = Self::default();
        params.clip.max_side = 400;
        params.flow.fixed_points = 3;
        params.contour.half_size_min_side = 1;
        params
    }

    /// Sets the parameter `name`, a field such as `flow.patch_stride` or its JSON name `flow.patchStride`. The name `preset` sets all parameters, to `default`, `fast`
    /// ([`Params::fast`]) or `paper` ([`Params::paper`]).
    ///
    /// # Errors
    /// [`Error::Param`] if no parameter has this name (the message lists similar ones) or the value is not legal.
    pub fn set(&mut self, name: &str, value: &ParamValue) -> Result<(), Error> {
        if name == PRESET {
            return self.set_preset(value);
        }
        let mut outcome = None;
        let mut names = Vec::new();
        self.visit("", &mut |mut field| {
            if field.is_called(name) {
                outcome = Some(field.set(value));
            }
            names.push(field.shown_name());
        });
        outcome.unwrap_or_else(|| {
            Err(Error::Param {
                name: name.to_owned(),
                value: value.to_string(),
                expected: format!("a known parameter, such as {}", similar_names(name, &names)),
            })
        })
    }

    fn set_preset(&mut self, preset: &ParamValue) -> Result<(), Error> {
        *self = match preset {
            ParamValue::Text(name) if name == "default" => Self::default(),
            ParamValue::Text(name) if name == "fast" => Self::fast(),
            ParamValue::Text(name) if name == "paper" => Self::paper(),
            unknown => {
                let expected = "default, fast or paper".to_owned();
                return Err(Error::Param { name: PRESET.to_owned(), value: unknown.to_string(), expected });
            }
        };
        Ok(())
    }

    /// Sets every parameter in `tree`, e.g. from `{"flow": {"patchStride": 5}}`; a `preset` is applied first. Nothing changes on an
    /// error.
    ///
    /// # Errors
    /// As [`Params::set`].
    pub fn apply(&mut self, tree: &BTreeMap<String, ParamValue>) -> Result<(), Error> {
        let mut changed = self.clone();
        if let Some(preset) = tree.get(PRESET) {
            changed.set_preset(preset)?;
        }
        for (name, value) in flatten(tree) {
            if name != PRESET {
                changed.set(&name, value)?;
            }
        }
        *self = changed;
        Ok(())
    }

    /// Calls `visit` for every parameter, in the order of the stages.
    #[doc(hidden)] // For the command line and the Python package.
    pub fn for_each(&mut self, visit: &mut dyn FnMut(ParamField<'_>)) {
        self.visit("", visit);
    }

    /// Checks every value against its range.
    ///
    /// # Errors
    /// [`Error::Param`] for the first value that is out of range or not a number.
    pub fn validate(&self) -> Result<(), Error> {
        let mut first = Ok(());
        self.clone().visit("", &mut |field| {
            if first.is_ok() {
                first = field.check();
            }
        });
        first
    }

    /// Returns the parameters of the stages for processed frames of `size` pixels: lengths are scaled to the frames, and counts of
    /// trajectories, which are stated at a grid step of 8 pixels, to theirs. [`Session`](crate::Session) does this itself.
    #[must_use]
    pub fn for_size(&self, size: (usize, usize)) -> Self {
        self.scaled_to(size).params
    }

    /// Returns the radius of votes ([`ScaledParams::vote_radius`]) for processed frames of `size` pixels.
    #[doc(hidden)] // For `examples/method.rs`.
    pub fn vote_radius(&self, size: (usize, usize)) -> f32 {
        self.scaled_to(size).vote_radius
    }

    /// Scales lengths to processed frames of `size` pixels.
    pub(crate) fn scaled_to(&self, size: (usize, usize)) -> ScaledParams {
        let scale = self.length_scale(size);
        self.scaled(scale, self.trajectory.grid_step * scale)
    }

    /// Scales counts to the spacing of another tracker's trajectories, in processed pixels, and lengths to its frames if there are
    /// any.
    pub(crate) fn for_tracks(&self, tracks: &Trajectories, has_frames: bool) -> ScaledParams {
        let scale = if has_frames { self.length_scale(tracks.size) } else { 1.0 };
        self.scaled(scale, typical_spacing(tracks))
    }

    /// Returns the scale of lengths in frames of `size` pixels.
    fn length_scale(&self, size: (usize, usize)) -> f32 {
        let side = ((size.0 * size.1) as f32).sqrt();
        (side / self.clip.reference_side.max(1) as f32).clamp(MIN_LENGTH_SCALE, 1.0)
    }

    fn scaled(&self, scale: f32, spacing: f32) -> ScaledParams {
        let mut params = self.clone();
        params.trajectory.grid_step = (params.trajectory.grid_step * scale).max(MIN_GRID_STEP_PX);
        params.trajectory.mask_step = (params.trajectory.mask_step * scale).max(MIN_MASK_STEP_PX);
        params.refine.band = (params.refine.band as f32 * scale).round() as u32;
        let density = (REFERENCE_STEP_PX * scale / spacing).powi(2);
        for count in [&mut params.embedding.min_component, &mut params.connectedness.min_component] {
            *count = (*count as f32 * density).round() as u32;
        }
        // The votes of farther trajectories have hardly any weight, but take time.
        let vote_radius = (VOTE_RADIUS_PX * scale).min(MAX_VOTE_SPACINGS * spacing);
        ScaledParams { params, spacing, vote_radius }
    }
}

/// Returns the mean distance of neighbouring trajectories in a frame, in pixels: the square root of the area per trajectory.
fn typical_spacing(tracks: &Trajectories) -> f32 {
    let alive = tracks.x.len() as f32 / tracks.num_frames.max(1) as f32;
    let area = (tracks.size.0 * tracks.size.1) as f32;
    if alive > 0.0 { (area / alive).sqrt().clamp(MIN_SPACING_PX, MAX_SPACING_PX) } else { REFERENCE_STEP_PX }
}

// The limits are chosen by eye.
/// Largest radius of votes, in spacings of trajectories.
const MAX_VOTE_SPACINGS: f32 = 20.0;
/// Least scale of lengths: below it the windows of neighbouring trajectories would overlap almost entirely.
const MIN_LENGTH_SCALE: f32 = 0.5;
/// Least spacing of trajectories: their cost grows with the inverse of its fourth power.
const MIN_GRID_STEP_PX: f32 = 3.0;
/// Least spacing of mask trajectories, which are not compared with each other.
const MIN_MASK_STEP_PX: f32 = 2.0;
/// Least spacing that another tracker's trajectories are assumed to have.
const MIN_SPACING_PX: f32 = 2.0;
/// Largest spacing that another tracker's trajectories are assumed to have.
const MAX_SPACING_PX: f32 = 64.0;

/// The grid step that counts of trajectories in the parameters refer to: the default of `trajectory.gridStep`.
const REFERENCE_STEP_PX: f32 = 8.0;

/// The parameters of one run, as [`Params::for_size`], but counts of trajectories are scaled to the spacing of those at hand.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ScaledParams {
    params: Params,
    spacing: f32,
    vote_radius: f32,
}

impl ScaledParams {
    /// Sets `discretize.mergeLogOdds`.
    pub(crate) fn set_merge_log_odds(&mut self, merge_log_odds: f64) {
        self.params.discretize.merge_log_odds = merge_log_odds;
    }

    /// Returns the distance of neighbouring trajectories, in pixels of the processed frames.
    pub(crate) fn spacing(&self) -> f32 {
        self.spacing
    }

    /// Returns the radius within which labelled trajectories vote on others ([`crate::cut::propagate_labels`]), in pixels of the
    /// processed frames.
    pub(crate) fn vote_radius(&self) -> f32 {
        self.vote_radius
    }
}

impl Deref for ScaledParams {
    type Target = Params;

    fn deref(&self) -> &Params {
        &self.params
    }
}

/// Returns the three names most similar to `name`, by common letter pairs.
fn similar_names(name: &str, names: &[String]) -> String {
    let pairs = |s: &str| -> Vec<[char; 2]> {
        let letters: Vec<char> = s.to_ascii_lowercase().chars().collect();
        letters.windows(2).map(|w| [w[0], w[1]]).collect()
    };
    let name_pairs = pairs(name);
    let mut scored: Vec<(usize, &String)> =
        names.iter().map(|n| (pairs(n).iter().filter(|p| name_pairs.contains(p)).count(), n)).collect();
    crate::order::sort_by_key(&mut scored, |&(common, _)| u64::MAX - common as u64);
    scored.iter().take(3).map(|(_, n)| n.as_str()).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_legal_every_parameter_is_documented_and_at_most_twenty_are_shown() {
        Params::default().validate().unwrap();
        let (mut count, mut shown) = (0, 0);
        Params::default().visit("", &mut |field| {
            assert!(field.doc.len() > 10, "{} has no doc", field.name);
            count += 1;
            shown += usize::from(!field.expert);
        });
        assert!(count > 20 && (10..=20).contains(&shown), "{count} parameters, {shown} shown");
    }

    #[test]
    fn names_values_and_ranges_are_checked() {
        let mut params = Params::default();
        for name in ["clip.maxSide", "clip.max_side"] {
            params.set(name, &ParamValue::Number(320.0)).unwrap();
            assert_eq!(std::mem::take(&mut params).clip.max_side, 320);
        }
        params.clip.max_side = 320;
        let misspelt = params.set("clip.maxSize", &ParamValue::Number(320.0)).unwrap_err().to_string();
        assert!(misspelt.contains("clip.max_side"), "{misspelt}");
        let message = params.set("clip.maxSide", &ParamValue::Number(2.0)).unwrap_err().to_string();
        assert_eq!(message, "clip.max_side = 2 (expected a whole number, 16..=4096)");
        assert!(params.set("clip.maxSide", &ParamValue::Number(320.5)).is_err());
        assert!(params.set("clip.maxSide", &ParamValue::Text("big".into())).is_err());
        assert_eq!(params.clip.max_side, 320);
    }

    #[test]
    fn a_tree_with_one_bad_name_changes_nothing() {
        let tree: BTreeMap<String, ParamValue> =
            serde_json::from_str(r#"{"clip": {"maxSide": 100, "oops": 1}}"#).unwrap();
        let mut params = Params::default();
        assert!(params.apply(&tree).is_err());
        assert_eq!(params, Params::default());
    }

    #[test]
    fn serialized_parameters_can_be_read_again() {
        let mut params = Params::default();
        params.clip.max_side = 123;
        let text = serde_json::to_string(&params).unwrap();
        assert_eq!(serde_json::from_str::<Params>(&text).unwrap(), params);
        let error = serde_json::from_str::<Params>(r#"{"clip": {"maxSide": 2}}"#).unwrap_err().to_string();
        assert!(error.starts_with("clip.max_side = 2 (expected a whole number, 16..=4096)"), "{error}");
    }

    #[test]
    fn a_preset_comes_before_what_is_set_beside_it() {
        let tree: BTreeMap<String, ParamValue> =
            serde_json::from_str(r#"{"cut": {"weightByLength": true}, "preset": "paper"}"#).unwrap();
        let mut params = Params::default();
        params.apply(&tree).unwrap();
        assert!(params.cut.weight_by_length && params.cut.ambiguous_share == 0.3 && params.refine.band == 0);
        params.set("preset", &ParamValue::Text("default".into())).unwrap();
        assert_eq!(params, Params::default());
        let message = params.set("preset", &ParamValue::Number(1.0)).unwrap_err().to_string();
        assert_eq!(message, "preset = 1 (expected default, fast or paper)");
    }

    #[test]
    fn not_a_number_is_out_of_every_range() {
        let mut params = Params::default();
        params.affinity.lambda = f32::NAN;
        assert_eq!(params.validate().unwrap_err().code(), "param");
    }

    #[test]
    fn counts_of_trajectories_follow_their_spacing() {
        let params = Params::default();
        let large = (640, 360);
        assert_eq!(*params.scaled_to(large), params);
        let dense = params.scaled(1.0, 4.0);
        assert_eq!(dense.embedding.min_component, 4 * params.embedding.min_component);
        assert_eq!(dense.connectedness.min_component, 4 * params.connectedness.min_component);
        assert_eq!((dense.spacing(), &dense.cut), (4.0, &params.cut));
    }

    #[test]
    fn votes_are_asked_within_twenty_steps_at_most() {
        let params = Params::default();
        for (spacing, radius) in [(8.0, 24.0), (3.0, 24.0), (1.0, 20.0), (0.5, 10.0)] {
            assert_eq!(params.scaled(1.0, spacing).vote_radius(), radius);
        }
    }

    #[test]
    fn lengths_follow_the_size_of_the_frame_and_counts_do_not() {
        let params = Params::default();
        let half = params.scaled_to((240, 135));
        assert_eq!((half.spacing(), half.trajectory.grid_step, half.trajectory.mask_step), (4.0, 4.0, 2.0));
        assert_eq!((half.vote_radius(), half.refine.band), (12.0, 4));
        assert_eq!(half.discretize, params.discretize);
        assert_eq!(params.scaled_to((32, 18)).spacing(), 4.0);
        assert_eq!(*params.scaled_to((1280, 720)), params);
        assert_eq!(*Params::paper().scaled_to((32, 18)), Params::paper());
    }
}
