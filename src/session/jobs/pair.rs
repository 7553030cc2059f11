//! What two neighbouring frames tell: flow both ways, its variation, and where points of the second can be tracked.

use crate::flow::{FlowField, FlowParams, FlowPyramid, FlowScratch, flow_between_with, local_flow_variation};
use crate::image::{Frame, Plane};
use crate::trajectory::structure;

/// Flow of one frame pair, both ways, with what tracking through it needs; it depends on the two frames alone.
///
/// Law: flow has the size of the frames, all else half of it, rounded up.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PairFlow {
    pub(crate) forward: FlowField,
    pub(crate) backward: FlowField,
    pub(crate) variation: Plane<f32>,
    /// Of the second frame.
    pub(crate) structure: Plane<f32>,
}

impl PairFlow {
    /// Of two frames of one size.
    pub(crate) fn new(from: &Frame, to: &Frame, params: &FlowParams, scratch: &mut FlowScratch) -> Self {
        let [from, to] = [from, to].map(|frame| Seen::new(frame, params));
        Forward::new(from, to, params, scratch).finish(params, scratch).0
    }
}

/// A frame as the flow sees it.
#[derive(Debug, Clone)]
pub(crate) struct Seen {
    luma: Plane<f32>,
    pyramid: FlowPyramid,
}

impl Seen {
    pub(crate) fn new(frame: &Frame, params: &FlowParams) -> Self {
        Self { pyramid: FlowPyramid::from_frame(frame, params.max_side), luma: frame.luma() }
    }

    /// The flow to another frame, at the size of the frames.
    fn flow_to(&self, to: &Self, params: &FlowParams, scratch: &mut FlowScratch) -> FlowField {
        flow_between_with(&self.pyramid, &to.pyramid, params, scratch).at_size(self.luma.width(), self.luma.height())
    }
}

/// Half of the work on a pair.
#[derive(Debug, Clone)]
pub(crate) struct Forward {
    from: Seen,
    to: Seen,
    flow: FlowField,
}

impl Forward {
    pub(crate) fn new(from: Seen, to: Seen, params: &FlowParams, scratch: &mut FlowScratch) -> Self {
        let flow = from.flow_to(&to, params, scratch);
        Self { from, to, flow }
    }

    /// The forward flow.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn field(&self) -> &FlowField {
        &self.flow
    }

    /// The other half; with the second frame, which is the first of the next pair.
    pub(crate) fn finish(self, params: &FlowParams, scratch: &mut FlowScratch) -> (PairFlow, Seen) {
        let Self { from, to, flow: forward } = self;
        let backward = to.flow_to(&from, params, scratch);
        let variation = local_flow_variation(&forward);
        (PairFlow { forward, backward, variation, structure: structure(&to.luma) }, to)
    }
}
