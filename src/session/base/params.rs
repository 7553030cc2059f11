//! The parameters of all stages in one tree, set by name; and the same at a clip's spacing of trajectories.

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
use crate::params::{ParamField, ParamGroup, ParamTree, ParamValue};
use crate::saliency::SaliencyParams;
use crate::session::window::ShotParams;
use crate::still::StillParams;
use crate::superpixel::SuperpixelParams;
use crate::trajectory::{Trajectories, TrajectoryParams};
use serde::Serialize;
use std::ops::Deref;

crate::params! {
    /// Settings of the clip as a whole.
    pub struct ClipParams {
        /// Longest side at which frames are processed, in pixels; larger frames are reduced and every result is mapped
        /// back to input pixels. Higher is slower and finds smaller objects.
        pub max_side: u32 = 640, in 16..=4096;
        /// Side of a square frame for which lengths are meant, in pixels: in a frame of less area trajectories are
        /// closer together in proportion, down to one half, and so are radii around them, so that an object has as
        /// many points at any size. 0 leaves lengths as they are. Default: the area of 480×270.
        pub reference_side: u32 = 360, in 0..=4096, expert;
        /// Whether every pixel gets a label; without, a run ends with the labels of the trajectories.
        pub dense: bool = true, in 0..=1;
        /// Most pixels of a frame of the input. Larger ones are refused (`too-large`) before memory is taken.
        pub max_pixels: u32 = MAX_PIXELS as u32, in 1..=268435456, expert;
        /// Most frames of a session, or of a window of a long clip.
        pub max_frames: u32 = 10000, in 2..=1000000, expert;
        /// Most trajectories, from outside or found.
        pub max_trajectories: u32 = 1000000, in 1..=100000000, expert;
        /// Most points of trajectories from outside.
        pub max_points: u32 = 100000000, in 1..=4294967295_u32, expert;
        /// Seed of all pseudo-random choices.
        pub seed: u32 = 0, in 0..=4294967295_u32;
    }
}

impl ClipParams {
    /// Refuses frames with too many pixels; `size` is that of a [`crate::image::Frame`], or has been checked.
    pub(crate) fn check_pixels(&self, (width, height): (usize, usize)) -> Result<(), Error> {
        Error::unless(width * height, self.max_pixels, "pixels in a frame", "clip.maxPixels")
    }

    /// Refuses more frames at once.
    pub(crate) fn check_frames(&self, count: usize) -> Result<(), Error> {
        Error::unless(count, self.max_frames, "frames in a session", "clip.maxFrames")
    }

    /// Refuses more trajectories.
    pub(crate) fn check_trajectories(&self, count: usize) -> Result<(), Error> {
        Error::unless(count, self.max_trajectories, "trajectories", "clip.maxTrajectories")
    }

    /// Refuses trajectories from outside that are too much.
    pub(crate) fn check_given(&self, tracks: &Trajectories) -> Result<(), Error> {
        self.check_frames(tracks.num_frames)?;
        self.check_trajectories(tracks.start_frame.len())?;
        Error::unless(tracks.x.len(), self.max_points, "points of trajectories", "clip.maxPoints")
    }
}

/// Declares the tree: `/// meaning` `name: group,`. Names are sections from outside.
macro_rules! tree {
    ($(#[$meta:meta])* pub struct $tree:ident { $($(#[$doc:meta])* $name:ident: $group:ty,)* }) => {
        $(#[$meta])*
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
    /// All parameters, one group a stage. Start from `Params::default()` and change fields, or set them by name.
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

/// The name under which a preset is chosen from outside.
const PRESET: &str = "preset";

impl Params {
    /// Saliency and connectedness as the paper has them, and the dense half: Pb at full size, contours above a threshold
    /// that is not low, superpixels as the Gabriel graph leaves them, the energy of the paper, masks from the clustered
    /// trajectories alone, borders where the superpixels have them, and no background of still cameras. Everything else
    /// is as by default.
    pub fn paper() -> Self {
        let mut params = Self {
            saliency: SaliencyParams::paper(),
            connectedness: ConnectednessParams::paper(),
            cut: CutParams::paper(),
            ..Self::default()
        };
        params.discretize.method = DiscretizeMethod::RotationMerge;
        params.trajectory.mask_step = params.trajectory.grid_step;
        params.trajectory.mask_min_length = params.trajectory.min_length;
        params.flow.max_side = 4096;
        params.contour.half_size_min_side = 65536;
        params.refine.band = 0;
        params.background.enabled = false;
        params.clip.reference_side = 0;
        params
    }

    /// Those of the flow. Borders of masks are refined to the pixel afterwards; points beside borders have their flow
    /// alone, so where no masks follow it is computed at full size.
    pub(crate) fn for_flow(&self) -> FlowParams {
        let max_side = if self.clip.dense { self.flow.max_side } else { u32::MAX };
        FlowParams { max_side, ..self.flow.clone() }
    }

    /// For a first look, at little more than half of the time: smaller frames, contours at half size, and flow that is
    /// less exact. Small and fast things may be lost.
    pub fn fast() -> Self {
        let mut params = Self::default();
        params.clip.max_side = 400;
        params.flow.fixed_points = 3;
        params.contour.half_size_min_side = 1;
        params
    }

    /// Sets the parameter `name` (e.g. `flow.patchStride`). The name `preset` sets all parameters, to `default`, `fast`
    /// ([`Params::fast`]) or `paper` ([`Params::paper`]).
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
            ParamValue::Text(name) if name == "fast" => Self::fast(),
            ParamValue::Text(name) if name == "paper" => Self::paper(),
            other => {
                let expected = "default, fast or paper".to_owned();
                return Err(Error::Param { name: PRESET.to_owned(), value: other.to_string(), expected });
            }
        };
        Ok(())
    }

    /// Sets every parameter named in `tree`, e.g. from `{"flow": {"patchStride": 5}}`; a `preset` goes first, whatever
    /// its place. On an error nothing is changed.
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

    /// Calls `visit` for every parameter, in the order of the stages.
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

    /// The same for processed frames of `size` pixels: lengths are those of such frames.
    pub fn for_size(&self, size: (usize, usize)) -> ScaledParams {
        let scale = self.length_scale(size);
        self.scaled(scale, self.trajectory.grid_step * scale)
    }

    /// The same for trajectories of another tracker, in processed pixels; where frames go with them, lengths are those of
    /// such frames.
    pub(crate) fn for_tracks(&self, tracks: &Trajectories, has_frames: bool) -> ScaledParams {
        let scale = if has_frames { self.length_scale(tracks.size) } else { 1.0 };
        self.scaled(scale, typical_spacing(tracks))
    }

    /// What lengths are to be multiplied with in frames of `size` pixels.
    fn length_scale(&self, (width, height): (usize, usize)) -> f32 {
        let side = ((width * height) as f32).sqrt();
        (side / self.clip.reference_side.max(1) as f32).clamp(LEAST_SCALE, 1.0)
    }

    fn scaled(&self, scale: f32, spacing: f32) -> ScaledParams {
        let mut params = self.clone();
        params.trajectory.grid_step = (params.trajectory.grid_step * scale).max(LEAST_GRID_STEP);
        params.trajectory.mask_step = (params.trajectory.mask_step * scale).max(LEAST_MASK_STEP);
        params.refine.band = (params.refine.band as f32 * scale).round() as u32;
        let density = (REFERENCE_STEP * scale / spacing).powi(2);
        for count in [&mut params.embedding.min_component, &mut params.connectedness.min_component] {
            *count = (*count as f32 * density).round() as u32;
        }
        // Neighbours far beyond have no say, but each would take time.
        let vote_radius = (VOTE_RADIUS_PX * scale).min(MOST_VOTE_STEPS * spacing);
        ScaledParams { params, spacing, vote_radius }
    }
}

/// Distance of neighbouring trajectories in a frame, in pixels: the side of the square that one has for itself on
/// average.
fn typical_spacing(tracks: &Trajectories) -> f32 {
    let alive = tracks.x.len() as f32 / tracks.num_frames.max(1) as f32;
    let area = (tracks.size.0 * tracks.size.1) as f32;
    if alive > 0.0 { (area / alive).sqrt().clamp(2.0, 64.0) } else { REFERENCE_STEP }
}

/// Most steps of the grid from which trajectories are asked for their label.
const MOST_VOTE_STEPS: f32 = 20.0;
/// Least scale of lengths: below, neighbouring trajectories see the same pixels.
const LEAST_SCALE: f32 = 0.5;
/// Least spacing of trajectories, in pixels: what they cost grows with its fourth power.
const LEAST_GRID_STEP: f32 = 3.0;
/// The same of those for masks, which are not compared with each other.
const LEAST_MASK_STEP: f32 = 2.0;

/// The grid step at which counts of trajectories are stated in the parameters, in pixels.
const REFERENCE_STEP: f32 = 8.0;

/// The parameters of one run: lengths are those of frames of the clip's size, and counts of trajectories, which
/// [`Params`] states at a grid step of 8 pixels in large frames, are those at the spacing that the clip's trajectories
/// have. Made by [`Params::for_size`]; reads as [`Params`].
#[derive(Debug, Clone, PartialEq)]
pub struct ScaledParams {
    params: Params,
    spacing: f32,
    vote_radius: f32,
}

impl ScaledParams {
    /// Distance of neighbouring trajectories, in pixels of the processed frames.
    pub fn spacing(&self) -> f32 {
        self.spacing
    }

    #[doc(hidden)]
    /// Radius within which labelled trajectories vote on others ([`crate::cut::propagate_labels`]), in pixels of the
    /// processed frames.
    pub fn vote_radius(&self) -> f32 {
        self.vote_radius
    }
}

impl Deref for ScaledParams {
    type Target = Params;

    fn deref(&self) -> &Params {
        &self.params
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
        let tree: ParamTree = serde_json::from_str(r#"{"cut": {"weightByLength": true}, "preset": "paper"}"#).unwrap();
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
        assert_eq!(*params.for_size(large), params);
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
        let half = params.for_size((240, 135));
        assert_eq!((half.spacing(), half.trajectory.grid_step, half.trajectory.mask_step), (4.0, 4.0, 2.0));
        assert_eq!((half.vote_radius(), half.refine.band), (12.0, 4));
        assert_eq!(half.discretize, params.discretize);
        assert_eq!(params.for_size((32, 18)).spacing(), 4.0);
        assert_eq!(*params.for_size((1280, 720)), params);
        assert_eq!(*Params::paper().for_size((32, 18)), Params::paper());
    }
}
