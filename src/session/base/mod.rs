//! What all of a session is made of: parameters, stages, sizes and outputs.

mod outputs;
mod params;
mod scale;
mod stage;

pub(crate) use outputs::{
    Clustered, Corrections, Cut, CutGround, CutRegion, Embedded, Foreground, Found, Linked, Parts, Placed, Salient,
    Segmented, Sureness, Tracked,
};
pub(crate) use params::REFERENCE_STEP;
pub use params::{ClipParams, Params, ScaledParams};
pub(crate) use scale::Scale;
pub use stage::{Progress, Stage, Step};
