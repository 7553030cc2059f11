//! TraceCut finds the moving objects in a video, without a trained model and without a click.
//!
//! In: the frames of a clip. Out: for every pixel of every frame a label, 0 for the background or the number of an
//! object, the same number for the same object in all frames. The method comes from Fragkiadaki, Zhang and Shi,
//! *Video Segmentation by Tracing Discontinuities in a Trajectory Embedding* (CVPR 2012), all of it; where something
//! measured better, it stands beside the paper's and can be turned off ([`Params::paper`]).
//!
//! # The idea
//!
//! Two frames say little about what belongs together: a walker's leg on the ground moves as the street does. Over a
//! whole clip it does not. So points are followed as long as they can be seen, and two of these trajectories are as
//! alike as their motions are *at the moment when they differ most*. Who is alike makes a graph; its leading
//! eigenvectors give each trajectory a place in a space where things that move as one lie together.
//!
//! Clusters in that space break smooth things, such as a body that bends. The paper looks at its *discontinuities*
//! instead: between neighbours in the image, how far does the affinity fall below what is usual around them? Clusters
//! are merged wherever no such border runs between them. Where pieces of salient motion are seen apart in some frames,
//! they stay apart in all.
//!
//! Trajectories are points; masks need every pixel. Frames are divided into superpixels along their contours, gaps in
//! these bridged by Gabriel edges, and a cut through the superpixels of the whole clip gives each the label that its
//! trajectories, its neighbours and its successors in time ask for.
//!
//! # How to use it
//!
//! [`Session`] runs all of it; [`Session::step`] does so in small pieces, for progress bars and for stopping.
//!
//! ```
//! use tracecut::synth::Scene;
//! use tracecut::{Params, Session};
//!
//! let scene = Scene::sample(96, 54, 4, 1);
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
//! Every number that can be chosen is a field of [`Params`], with its meaning, range and source.
//!
//! # The stages
//!
//! Each stage is a module with an essay, its parameters, and one verb or a few that can be called without a session:
//! plain data in, plain data out. They stand in the order in which they run.
//!
//! | stage | module | verb | paper | in → out |
//! |---|---|---|---|---|
//! | flow | [`flow`] | [`flow_between`](flow::flow_between) | | two frames → [`FlowField`](flow::FlowField) |
//! | trajectories | [`trajectory`] | [`Tracker`](trajectory::Tracker) | 2.1 | flow of all pairs → [`Trajectories`](trajectory::Trajectories) |
//! | affinities | [`affinity`] | [`affinities`](affinity::affinities) | 2.1 | trajectories → [`SymCsr`](sparse::SymCsr) A |
//! | embedding | [`embedding`] | [`embed`](embedding::embed) | 2.1 | A → [`Embedding`](embedding::Embedding) V, Λ |
//! | discontinuities | [`discontinuity`] | [`discontinuities`](discontinuity::discontinuities) | 2.2 | trajectories, embedding → [`Discontinuities`](discontinuity::Discontinuities) d |
//! | saliency | [`saliency`] | [`SaliencyMaps`](saliency::SaliencyMaps), [`context_saliency`](saliency::context_saliency) | 3 | flow, embedding → [`Saliency`](saliency::Saliency) |
//! | connectedness | [`connectedness`] | [`components`](connectedness::components), [`constrain`](connectedness::constrain) | 3 | foreground, A → A without what it keeps apart |
//! | clusters | [`discretize`] | [`discretize`](discretize::discretize) | 2.3 | embedding, d → [`Clusters`](discretize::Clusters) |
//! | superpixels | [`contour`], [`superpixel`] | [`boundary_map`](contour::boundary_map), [`gabriel_superpixels`](superpixel::gabriel_superpixels) | 4.1 | a frame → [`Superpixels`](superpixel::Superpixels) |
//! | objects | [`background`], [`mask`] | [`Background`](background::Background), [`classify_clusters`](mask::classify_clusters) | | frames, flow, labelled trajectories → which clusters are objects, evidence for each superpixel |
//! | cut | [`cut`] | [`gabriel_cut`](cut::gabriel_cut) | 4.2 | superpixels, labelled trajectories, evidence → [`CutLabels`](cut::CutLabels) |
//! | masks | [`mask`] | [`refine`](mask::refine) | | cut, frames → a mask for each frame |
//!
//! Beside them: [`still`] finds discontinuities in single images; [`correction`] says what the user wants otherwise;
//! [`synth`] makes clips whose masks and flow are known; [`image`], [`sparse`] and [`params`] are what all of these are
//! made of.
//!
//! The whole method in straight lines, with the sections of the paper beside them, is in `examples/method.rs`.
//!
//! Results are the same bytes for the same frames, parameters and target, on any number of threads. The library has no
//! clock, opens no files and keeps no global state; it starts threads only in [`Session::run_on`].

mod base;
pub mod correction;
mod dense;
mod figure;
pub mod mask;
mod motion;
pub mod session;
pub mod still;
pub mod synth;
#[doc(hidden)]
pub mod tracks;
#[cfg(all(target_arch = "wasm32", feature = "wasm"))]
pub mod wasm;

// Folders are for readers: from outside, and in paths here, a room has no folder. The rooms of `session` are its own.
use base::{delaunay, error, grid, order};
pub use base::{image, params, sparse};
#[doc(hidden)]
pub use base::{rng, sets};
pub use dense::{contour, cut, superpixel};
pub use figure::{background, connectedness, discretize, saliency};
#[doc(hidden)]
pub use figure::{camera, evidence};
use figure::{classify, objects};
pub use motion::{affinity, discontinuity, embedding, flow, trajectory};

pub use error::Error;
#[cfg(not(target_arch = "wasm32"))]
pub use session::{Checkpoint, Window, Windows};
pub use session::{Explanation, LabelSource, Params, Progress, Session, Stage, Step};

/// The README's Rust, tested with the examples in comments.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
