//! Masks: which labels they bear, where their borders run, how they are stored.
//!
//! The cut gives every superpixel a cluster. What a mask shows is decided here: which clusters are objects
//! ([`find_objects`]), and where, between superpixels, a border really runs ([`refine`]).

mod alpha;
mod border;
mod confidence;
mod enlarge;
mod objects;
mod prompts;
mod runs;
mod salient;
mod table;

pub(crate) use border::refine_since;
pub use border::{RefineParams, refine};
pub(crate) use confidence::{Said, confidence};
pub use enlarge::{Enlarged, enlarge};
pub use objects::{Objects, find_objects};
pub(crate) use objects::{number_objects, signs};
pub use prompts::{Prompt, Prompts};
pub(crate) use runs::Runs;
pub(crate) use salient::salient_objects;
pub use table::{ObjectRow, object_rows, object_table};
