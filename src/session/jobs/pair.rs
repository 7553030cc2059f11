//! Optical flow of a frame pair in both directions, with what tracking through the pair needs.

use crate::flow::{
    CompactFlow, FlowField, FlowParams, FlowPyramid, FlowScratch, flow_between_with, local_flow_variation,
};
use crate::image::{Frame, Plane};
use crate::trajectory::structure;

/// Flow of one frame pair in both directions, with what tracking needs; it depends on the two frames alone.
///
/// Flow has the size of the frames; the other planes have half of it, rounded up.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PairFlow {
    pub(crate) forward: FlowField,
    /// Only checks the forward field.
    pub(crate) backward: CompactFlow,
    pub(crate) variation: Plane<f32>,
    /// The structure of the second frame.
    pub(crate) structure: Plane<f32>,
}

impl PairFlow {
    /// Computes the flow between two frames of one size.
    pub(super) fn new(from: &Frame, to: &Frame, params: &FlowParams, scratch: &mut FlowScratch) -> Self {
        let [from, to] = [from, to].map(|frame| FlowFrame::new(frame, params));
        ForwardFlow::new(from, to, params, scratch).finish(params, scratch).0
    }
}

/// A frame prepared for optical flow.
#[derive(Debug, Clone)]
pub(crate) struct FlowFrame {
    luma: Plane<f32>,
    pyramid: FlowPyramid,
}

impl FlowFrame {
    pub(crate) fn new(frame: &Frame, params: &FlowParams) -> Self {
        Self { pyramid: FlowPyramid::reduced(frame, params.max_side), luma: frame.luma() }
    }

    /// Computes the flow to another frame, at the size of the frames.
    fn flow_to(&self, to: &Self, params: &FlowParams, scratch: &mut FlowScratch) -> FlowField {
        flow_between_with(&self.pyramid, &to.pyramid, params, scratch).at_size(self.luma.width(), self.luma.height())
    }
}

/// A frame pair with its forward flow: half of the work on a [`PairFlow`].
#[derive(Debug, Clone)]
pub(crate) struct ForwardFlow {
    from: FlowFrame,
    to: FlowFrame,
    flow: FlowField,
}

impl ForwardFlow {
    pub(crate) fn new(from: FlowFrame, to: FlowFrame, params: &FlowParams, scratch: &mut FlowScratch) -> Self {
        let flow = from.flow_to(&to, params, scratch);
        Self { from, to, flow }
    }

    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn field(&self) -> &FlowField {
        &self.flow
    }

    /// Computes the backward flow. Also returns the second frame, which is the first of the next pair.
    pub(crate) fn finish(self, params: &FlowParams, scratch: &mut FlowScratch) -> (PairFlow, FlowFrame) {
        let Self { from, to, flow: forward } = self;
        let backward = CompactFlow::new(&to.flow_to(&from, &params.for_check(), scratch));
        let variation = local_flow_variation(&forward);
        (PairFlow { forward, backward, variation, structure: structure(&to.luma) }, to)
    }
}
