//! The files of `src/mask` that need nothing of the stages before.

#[path = "../src/mask/coco.rs"]
mod coco;
#[path = "../src/mask/enlarge.rs"]
mod enlarge;
#[path = "../src/mask/opacity.rs"]
mod opacity;
#[path = "../src/mask/prompts.rs"]
mod prompts;
#[path = "../src/mask/refine.rs"]
mod refine;
#[path = "../src/mask/table.rs"]
mod table;

pub(crate) use coco::{CocoRuns, coco_counts, coco_mask, coco_runs, coco_text};
pub(crate) use enlarge::enlarge_to;
pub(crate) use prompts::{Prompt, Prompts};
pub(crate) use refine::RefineParams;
pub(crate) use table::{ObjectRow, object_rows, object_table};
