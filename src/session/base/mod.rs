//! Data of a session: parameters, stages, sizes and outputs.

mod outputs;
mod params;
mod scale;
mod stage;

pub(crate) use outputs::{Cut, CutContext, CutRegion, Outputs, SaliencyOutputs, TrackSet};
pub(crate) use params::ScaledParams;
pub use params::{ClipParams, Params};
pub(crate) use scale::Scale;
pub use stage::{Progress, Stage, Step};
