//! What all of a session is made of: parameters, stages, sizes and outputs.

mod outputs;
mod params;
mod scale;
mod stage;

pub(crate) use outputs::{Cut, CutGround, CutRegion, Outputs, Salient, Sureness, Tracked};
pub use params::{ClipParams, Params, ScaledParams};
pub(crate) use scale::Scale;
pub use stage::{Progress, Stage, Step};
