//! What is known of masks once they are made: `src/mask` without what finds objects and their confidence.

#[path = "../src/mask/alpha.rs"]
mod alpha;
#[path = "../src/mask/border.rs"]
mod border;
#[path = "../src/mask/coco.rs"]
mod coco;
#[path = "../src/mask/confidence.rs"]
mod confidence;
#[path = "../src/mask/enlarge.rs"]
mod enlarge;
#[path = "../src/mask/prompts.rs"]
mod prompts;
#[path = "../src/mask/table.rs"]
mod table;

pub(crate) use border::RefineParams;
pub(crate) use coco::{CocoRuns, coco_counts, coco_mask, coco_runs, coco_text};
pub(crate) use enlarge::enlarge;
pub(crate) use prompts::{Prompt, Prompts};
pub(crate) use table::{ObjectRow, object_rows, object_table};
