//! Masks: where their borders run, how sure they are, how they are stored.
//!
//! The cut gives every superpixel a cluster; which clusters are objects ([`find_objects`]) is known before it. What a
//! mask shows is decided here: where, between superpixels, a border really runs ([`refine`]).

mod alpha;
mod border;
mod coco;
mod confidence;
mod enlarge;
mod prompts;
mod table;

pub use crate::classify::{Classification, Observations, classify_clusters, cluster_penalties};
pub use crate::objects::{Objects, find_objects, number_objects};
pub(crate) use border::refine_since;
pub use border::{RefineParams, refine};
#[doc(hidden)] // For the command line, and the packages for Python and JavaScript.
pub use coco::{CocoRuns, coco_counts, coco_mask, coco_runs, coco_text};
pub(crate) use confidence::{Said, confidence};
pub use enlarge::{Enlarged, enlarge};
#[doc(hidden)] // For the command line, and the packages for Python and JavaScript.
pub use prompts::{Prompt, Prompts};
pub use table::{ObjectRow, object_rows, object_table};
