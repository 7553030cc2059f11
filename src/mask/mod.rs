//! Masks: their borders, agreement in time, expected J and file formats.
//!
//! The cut gives every superpixel a cluster, after some clusters were selected as objects (`find_objects`). Borders of masks
//! are then refined to the pixel ([`refine`]) and brought to the size of the source ([`enlarge`]).

mod agreement;
mod coco;
mod enlarge;
mod expected_j;
mod opacity;
mod parts;
mod prompts;
mod refine;
mod table;

#[doc(hidden)] // For `examples/method.rs`.
pub use crate::classify::{Classification, Observations, classify_clusters, cluster_penalties};
pub use crate::objects::Objects;
#[doc(hidden)] // For `examples/method.rs`.
pub use crate::objects::number_objects;
pub use agreement::Agreement;
pub(crate) use agreement::{agreement, clip_agreement};
#[doc(hidden)] // For the command line, and the packages for Python and JavaScript.
pub use coco::{CocoRuns, coco_counts, coco_mask, coco_runs, coco_text};
pub use enlarge::{EnlargedMask, enlarge};
pub(crate) use expected_j::{CutMasks, expected_j, expected_j_terms};
#[doc(hidden)] // For `examples/method.rs`.
pub use parts::attach_loose_parts;
#[doc(hidden)] // For the command line, and the packages for Python and JavaScript.
pub use prompts::{Prompt, Prompts};
pub(crate) use refine::refine_since;
pub use refine::{RefineParams, refine};
#[doc(hidden)] // For the command line, and the packages for Python and JavaScript.
pub use table::{ObjectRow, object_rows, object_table};
