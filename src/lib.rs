//! TraceCut finds the moving objects in a video, without a trained model and without a click.
//!
//! In: the frames of a clip. Out: a label for every pixel of every frame, 0 for the background or the number of an object,
//! which is the same in all frames. The library implements the whole method of Fragkiadaki, Zhang and Shi, *Video
//! Segmentation by Tracing Discontinuities in a Trajectory Embedding* (CVPR 2012), plus changes that scored better and can
//! be turned off ([`Params::paper`]).
//!
//! # The idea
//!
//! Two frames are not enough to separate objects: a walker's leg on the ground moves as the street does. Over a whole clip
//! it does not. So points are tracked as long as they are visible, and the affinity of two trajectories depends on their
//! motions *in the frame where they differ most*. The affinities form a graph; its leading eigenvectors embed trajectories in
//! a space where points of one rigid motion lie close together.
//!
//! Clustering in this space splits non-rigid objects, such as a body that bends. The paper uses *discontinuities* of the
//! embedding instead: edges between neighbours in the image whose affinity is far below the usual affinity around them.
//! Clusters are merged if no such border lies between them. Connected components of salient motion that are separate in some
//! frames stay separate in all.
//!
//! Trajectories are points; masks need every pixel. Frames are divided into superpixels along their contours, whose gaps are
//! bridged by Gabriel edges. A graph cut labels the superpixels of the whole clip by their trajectories, their neighbours and
//! their successors in time.
//!
//! # How to use it
//!
//! ```toml
//! [dependencies]
//! tracecut = "0.1"
//! ```
//!
//! [`Session`] runs the whole method; [`Session::step`] runs it in small steps, for progress bars and cancelling.
//!
//! ```
//! use tracecut::synth::Scene;
//! use tracecut::{Params, Session};
//!
//! let scene = Scene::sample((96, 54), 4, 1);
//! let mut session = Session::new(Params::default())?;
//! for t in 0..scene.num_frames() {
//!     session.push_frame(scene.frame(t))?; // or push_rgba, push_encoded
//! }
//! session.run()?;
//! let mask = session.labels(0)?; // a label for each pixel
//! assert_eq!((mask.width(), mask.height()), scene.size());
//! # Ok::<(), tracecut::Error>(())
//! ```
//!
//! A clip of any length runs window by window, in the memory of one window:
//!
//! ```
//! use tracecut::synth::Scene;
//! use tracecut::{Error, Params, Windows};
//!
//! let scene = Scene::sample((96, 54), 20, 1);
//! let frames = (0..20).map(|t| Ok::<_, Error>(scene.frame(t))); // or from a decoder, with its own errors
//! let mut windows = Windows::new(Params::fast(), frames)?.with_window(12, 4)?.with_threads(2);
//! while let Some(window) = windows.next_window(|progress| eprintln!("{}", progress.stage)) {
//!     let window = window?;
//!     for t in window.settled {
//!         let mask = windows.session().labels(t)?;
//!         println!("frame {}: {} pixels", window.first_frame + t, mask.data().iter().filter(|&&label| label > 0).count());
//!     }
//! }
//! # Ok::<(), Error>(())
//! ```
//!
//! Every parameter is a field of [`Params`], with its meaning, range and source. Change fields, set them by name
//! ([`Params::set`]), or read them from JSON; errors name the field and its range:
//!
//! ```
//! use tracecut::{Params, Session};
//!
//! let mut params = Params::default();
//! params.trajectory.grid_step = 0.5;
//! let error = Session::new(params).unwrap_err();
//! assert_eq!(error.to_string(), "trajectory.grid_step = 0.5 (expected a number, 3..=64)");
//! ```
//!
//! # The stages
//!
//! Each stage is a module with a description of the method, parameters, and functions that can be called without a session:
//! plain data in, plain data out. Stages are listed in the order in which they run.
//!
//! | stage | module | function | paper | in → out |
//! |---|---|---|---|---|
//! | flow | [`flow`] | [`flow_between`](flow::flow_between) | | two frames → [`FlowField`](flow::FlowField) |
//! | trajectories | [`trajectory`] | [`Tracker`](trajectory::Tracker) | 2.1 | flow of all pairs → [`Trajectories`](trajectory::Trajectories) |
//! | affinities | [`affinity`] | [`affinities`](affinity::affinities) | 2.1 | trajectories → [`SymCsr`](sparse::SymCsr) A |
//! | embedding | [`embedding`] | [`embed`](embedding::embed) | 2.1 | A → [`Embedding`](embedding::Embedding) V, Λ |
//! | discontinuities | [`discontinuity`] | [`discontinuities`](discontinuity::discontinuities) | 2.2 | trajectories, embedding → [`Discontinuities`](discontinuity::Discontinuities) d |
//! | saliency | [`saliency`] | [`SaliencyMaps`](saliency::SaliencyMaps), [`context_saliency`](saliency::context_saliency) | 3 | flow, embedding → [`Saliency`](saliency::Saliency) |
//! | connectedness | [`connectedness`] | [`components`](connectedness::components), [`constrain`](connectedness::constrain) | 3 | foreground, A → A without affinities between separate components |
//! | clusters | [`discretize`] | [`discretize`](discretize::discretize) | 2.3 | embedding, d → [`Clusters`](discretize::Clusters) |
//! | superpixels | [`contour`], [`superpixel`] | [`boundary_map`](contour::boundary_map), [`superpixels_of`](superpixel::superpixels_of) | 4.1 | a frame → [`Superpixels`](superpixel::Superpixels) |
//! | objects | | | | frames, flow, labelled trajectories → which clusters are objects, evidence for each superpixel |
//! | cut | [`cut`] | [`gabriel_cut`](cut::gabriel_cut) | 4.2 | superpixels, labelled trajectories, evidence → [`CutLabels`](cut::CutLabels) |
//! | masks | [`mask`] | [`refine`](mask::refine) | | cut, frames → a mask for each frame |
//!
//! Further modules: [`still`] finds discontinuities in single images; [`correction`] has the user's corrections; [`synth`]
//! renders clips with known masks and flow; [`image`] and [`sparse`] are shared by all of these.
//!
//! `examples/method.rs` has the whole method from top to bottom, with the sections of the paper. It also calls what is not
//! documented here, because it is not in the paper and may change in any release, such as the stage *objects*.
//!
//! Results are the same bytes for the same frames, parameters and target, on any number of threads. The library uses no
//! clock, opens no files and keeps no global state; it starts threads only in [`Session::run_on`].

/// Tools for all other rooms: errors, parameters, images, matrices, sorting and triangulation.
mod base {
    pub(crate) mod delaunay;
    pub(crate) mod error;
    pub(crate) mod grid;
    pub mod image;
    pub(crate) mod order;
    pub mod params;
    #[doc(hidden)]
    pub mod rng;
    #[doc(hidden)]
    pub mod sets;
    pub mod sparse;
}

/// Motion: from frames to trajectories, their affinities, embedding and discontinuities.
mod motion {
    pub mod affinity;
    pub mod discontinuity;
    pub mod embedding;
    pub mod flow;
    pub mod trajectory;
}

/// Contours and superpixels of frames, and the labelling of superpixels.
mod dense {
    pub mod contour;
    pub mod cut;
    pub mod superpixel;
}

/// Figure and ground: camera motion, saliency, clusters of trajectories, and the clusters that are objects.
mod figure {
    pub mod background;
    pub mod camera;
    pub(crate) mod classify;
    pub mod connectedness;
    pub mod discretize;
    #[doc(hidden)]
    pub mod evidence;
    pub(crate) mod objects;
    pub mod saliency;
}

pub mod correction;
pub mod mask;
mod session;
pub mod still;
pub mod synth;
#[doc(hidden)]
pub mod tracks;
#[cfg(all(target_arch = "wasm32", feature = "wasm"))]
pub mod wasm;

// Paths leave the folders out, inside and outside the crate, except inside in `session`.
use base::{delaunay, error, grid, order};
pub use base::{image, sparse};
#[doc(hidden)]
pub use base::{params, rng, sets};
pub use dense::{contour, cut, superpixel};
#[doc(hidden)]
pub use figure::{background, camera, evidence};
use figure::{classify, objects};
pub use figure::{connectedness, discretize, saliency};
pub use motion::{affinity, discontinuity, embedding, flow, trajectory};

pub use background::BackgroundParams;
pub use error::Error;
pub use params::ParamValue;
#[cfg(any(not(target_arch = "wasm32"), feature = "wasm"))]
pub use session::Window;
pub use session::explanation;
#[cfg(not(target_arch = "wasm32"))]
pub use session::{Checkpoint, Windows};
pub use session::{ClipParams, Params, Progress, Session, ShotParams, Stage, Step};

/// The README's Rust, tested with the examples in comments.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
