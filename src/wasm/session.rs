//! The session for JavaScript.

use super::convert::{self, float64_array, object, single_precision, uint32_array};
use crate::correction::{Correction, Stroke};
use crate::flow::FlowScratch;
use crate::image::Frame;
use crate::session::{Job, JobId, JobResult, Step, Window, WindowPlan};
use crate::trajectory::Trajectories;
use crate::{Params, Session};
use wasm_bindgen::prelude::*;

/// The segmentation of one clip, with the plan of its windows; see [`Session`].
#[wasm_bindgen(js_name = Session)]
#[derive(Debug)]
pub struct JsSession {
    session: Session,
    plan: WindowPlan,
}

impl JsSession {
    pub(super) fn params_in_force(&self) -> &Params {
        self.session.params()
    }

    fn correct(&mut self, correction: &Correction) -> Result<(), JsValue> {
        self.session.correct(correction).map_err(|e| convert::to_js_error(&e))
    }
}

#[wasm_bindgen(js_class = Session)]
impl JsSession {
    /// Creates a session with the default parameters changed by `options`, a tree such as `{flow: {patchStride: 5}}`.
    #[wasm_bindgen(constructor)]
    pub fn new(options: JsValue) -> Result<JsSession, JsValue> {
        let session = convert::to_params(options).and_then(Session::new);
        session.map(|session| Self { session, plan: WindowPlan::default() }).map_err(|e| convert::to_js_error(&e))
    }

    /// Adds a frame of `width * height` RGBA pixels.
    #[wasm_bindgen(js_name = pushRgba)]
    pub fn push_rgba(&mut self, rgba: &[u8], width: usize, height: usize) -> Result<(), JsValue> {
        self.session.push_rgba(rgba, width, height).map_err(|e| convert::to_js_error(&e))
    }

    /// Adds a frame to a clip that is processed window by window. Returns true if it begins a new shot and is held back.
    #[wasm_bindgen(js_name = pushInShot)]
    pub fn push_in_shot(&mut self, rgba: &[u8], width: usize, height: usize) -> Result<bool, JsValue> {
        let frame = Frame::from_rgba(rgba, width, height);
        frame.and_then(|frame| self.session.push_in_shot(frame)).map_err(|e| convert::to_js_error(&e))
    }

    /// Advances to the next window, which begins with the last `overlap` frames of this one, or with the frame held back.
    pub fn advance(&mut self, overlap: usize) -> Result<(), JsValue> {
        self.session.advance(overlap).map_err(|e| convert::to_js_error(&e))
    }

    /// Sets the number of frames of windows, and how many they share with their neighbours.
    #[wasm_bindgen(js_name = planWindows)]
    pub fn plan_windows(&mut self, window: usize, overlap: Option<usize>) -> Result<(), JsValue> {
        let plan = WindowPlan::new(window, overlap.unwrap_or_else(|| Window::overlap(window)));
        self.plan = plan.map_err(|e| convert::to_js_error(&e))?;
        Ok(())
    }

    /// Returns how many frames the next window shares with this one, when one more frame has been read and `remaining` follow it.
    pub fn shared(&self, remaining: Option<usize>) -> usize {
        self.plan.next_overlap(remaining)
    }

    /// Finishes the present window of `frames` frames; the next one shares `overlap` of them, or begins a new shot. Returns the
    /// numbers of the window, of its shot and of its first frame, and start and end of the frames that it settles.
    #[wasm_bindgen(js_name = closeWindow)]
    pub fn close_window(&mut self, frames: usize, overlap: Option<usize>) -> Vec<usize> {
        let Window { index, shot, first_frame, settled } = self.plan.finish_window(frames, overlap);
        vec![index, shot, first_frame, settled.start, settled.end]
    }

    /// Uses the trajectories of another tracker, in input pixels.
    #[wasm_bindgen(js_name = setTrajectories)]
    #[allow(clippy::too_many_arguments, reason = "flat arrays are what crosses the boundary cheaply")]
    pub fn set_trajectories(
        &mut self,
        num_frames: usize,
        width: usize,
        height: usize,
        start_frame: Vec<u32>,
        offset: Vec<u32>,
        x: Vec<f32>,
        y: Vec<f32>,
    ) -> Result<(), JsValue> {
        let variation = vec![0.0; x.len()];
        let trajectories = Trajectories { num_frames, size: (width, height), start_frame, offset, x, y, variation };
        self.session.set_trajectories(trajectories).map_err(|e| convert::to_js_error(&e))
    }

    /// Takes one bounded step: returns `{stage, done, total}`, or `undefined` when the run is done.
    pub fn step(&mut self) -> Result<JsValue, JsValue> {
        match self.session.step().map_err(|e| convert::to_js_error(&e))? {
            Step::Working(progress) => convert::to_js(&progress),
            Step::Done => Ok(JsValue::UNDEFINED),
        }
    }

    /// Hands out a job for another worker as a message; `undefined` if there is none at present. Flow is handed out for at most
    /// `ahead` pairs from the next one on.
    #[wasm_bindgen(js_name = takePiece)]
    pub fn take_piece(&mut self, ahead: usize) -> Option<Vec<u32>> {
        self.session.take_job(ahead).map(|job| job.encode())
    }

    /// Takes a job and runs it at once; false if there is none.
    #[wasm_bindgen(js_name = makePiece)]
    pub fn make_piece(&mut self, ahead: usize) -> bool {
        self.session.run_one_job(ahead)
    }

    /// Runs a job of a session with the same options and returns the message of its result, which is empty if `message` is not
    /// valid.
    #[wasm_bindgen(js_name = workOn)]
    pub fn work_on(&self, message: &[u32]) -> Vec<u32> {
        let run = |job: Job| job.run(self.session.params(), &mut FlowScratch::default()).encode(job.id);
        Job::decode(message).map_or_else(Vec::new, run)
    }

    /// Stores the result of another worker.
    pub fn accept(&mut self, message: &[u32]) {
        if let Some((id, result)) = JobResult::decode(message) {
            self.session.store_result(id, Some(result));
        }
    }

    /// Marks a job as lost, by the start of its message: the session does it itself.
    pub fn release(&mut self, message: &[u32]) {
        if let Some(id) = JobId::decode(message) {
            self.session.store_result(id, None);
        }
    }

    /// Returns whether the next step needs the result of a pending job. The step can be taken all the same, and then does the
    /// job itself.
    pub fn awaits(&self) -> bool {
        self.session.is_waiting()
    }

    /// Merges the object `from` into `into`.
    pub fn merge(&mut self, into: u8, from: u8) -> Result<(), JsValue> {
        self.correct(&Correction::Merge { into, from })
    }

    /// Splits an object in two; with `at`, the part at this position of frame `t` is the new one.
    pub fn split(&mut self, label: u8, at: bool, t: usize, x: f32, y: f32) -> Result<(), JsValue> {
        self.correct(&Correction::Split { label, at: at.then_some((t, x, y)) })
    }

    /// Joins the strokes into one object, or with `splits` makes each an object of its own. Stroke `k` is in frame `t[k]`, has a
    /// brush of radius `radius[k]` and the points `offset[k]..offset[k + 1]`, each x and y in `points`.
    pub fn strokes(
        &mut self,
        splits: bool,
        t: Vec<u32>,
        radius: Vec<f32>,
        offset: Vec<u32>,
        points: Vec<f32>,
    ) -> Result<(), JsValue> {
        let coordinates = |k: usize| points.get(2 * *offset.get(k)? as usize..2 * *offset.get(k + 1)? as usize);
        let stroke = |(k, (&t, &radius)): (usize, (&u32, &f32))| {
            let points = coordinates(k).unwrap_or_default().chunks_exact(2).map(|p| (p[0], p[1])).collect();
            Stroke { t: t as usize, points, radius }
        };
        let strokes = t.iter().zip(&radius).enumerate().map(stroke).collect();
        self.correct(&if splits { Correction::SplitStrokes(strokes) } else { Correction::JoinStrokes(strokes) })
    }

    /// Undoes the last correction.
    #[wasm_bindgen(js_name = undoCorrection)]
    pub fn undo_correction(&mut self) -> Result<(), JsValue> {
        self.session.undo_correction().map_err(|e| convert::to_js_error(&e))
    }

    /// Drops frames and results; parameters stay.
    pub fn clear(&mut self) {
        self.session.clear();
        self.plan.begin_clip();
    }

    /// `{numFrames, width, height, workingWidth, workingHeight, corrections, memoryBytes}`; sizes are 0 before the
    /// first frame. Memory is counted for the whole instance, which never shrinks.
    pub fn info(&self) -> JsValue {
        let (width, height) = self.session.input_size().unwrap_or_default();
        let (working_width, working_height) = self.session.working_size().unwrap_or_default();
        object([
            ("numFrames", self.session.num_frames().into()),
            ("width", width.into()),
            ("height", height.into()),
            ("workingWidth", working_width.into()),
            ("workingHeight", working_height.into()),
            ("corrections", self.session.num_corrections().into()),
            ("memoryBytes", convert::memory_bytes().into()),
        ])
    }

    /// Returns the parameters as a tree.
    pub fn params(&self) -> Result<JsValue, JsValue> {
        convert::to_js(self.session.params())
    }

    /// Returns the forward flow from frame `t` to `t + 1`: `{width, height, u, v}`.
    pub fn flow(&self, t: usize) -> Result<JsValue, JsValue> {
        self.session.flow(t).map(|field| convert::flow(&field)).map_err(|e| convert::to_js_error(&e))
    }

    /// `{count, startFrame, offset, x, y, id}` in input pixels; `undefined` until there are any.
    pub fn trajectories(&self) -> JsValue {
        let numbers = self.session.trajectory_numbers();
        self.session.trajectories().map_or(JsValue::UNDEFINED, |t| convert::trajectories(t, numbers))
    }

    /// `{count, label}`; `undefined` until there are any.
    pub fn clusters(&self) -> JsValue {
        self.session.clusters().map_or(JsValue::UNDEFINED, convert::clusters)
    }

    /// `{count, label}` of the segmentation by thresholded discontinuities; `undefined` until there are any.
    #[wasm_bindgen(js_name = thresholdClusters)]
    pub fn threshold_clusters(&self) -> JsValue {
        self.session.threshold_clusters().as_ref().map_or(JsValue::UNDEFINED, convert::clusters)
    }

    /// Returns the mask of frame `t`: a byte for each input pixel, 0 for the background.
    pub fn labels(&self, t: usize) -> Result<JsValue, JsValue> {
        self.session.labels(t).map(|mask| convert::uint8_array(mask.data())).map_err(|e| convert::to_js_error(&e))
    }

    /// Computes the scene of frame `t` without the objects, at working size: `{width, height, data}`, RGBA with alpha 0 where it
    /// is unknown.
    pub fn background(&self, t: usize) -> Result<JsValue, JsValue> {
        self.session.background(t).map(|plate| convert::picture(&plate)).map_err(|e| convert::to_js_error(&e))
    }

    /// Returns the superpixels of frame `t` at working size; see `convert::superpixels`.
    pub fn superpixels(&self, t: usize) -> Result<JsValue, JsValue> {
        self.session.superpixels(t).map(convert::superpixels).map_err(|e| convert::to_js_error(&e))
    }

    /// Computes the boundary map of frame `t` at working size: `{width, height, pb, thin}`.
    pub fn boundaries(&self, t: usize) -> Result<JsValue, JsValue> {
        self.session.boundaries(t).map(|map| convert::boundaries(&map)).map_err(|e| convert::to_js_error(&e))
    }

    /// `{ofPoints, inContext, foreground}`, an entry for each trajectory; `undefined` until known, and without frames.
    pub fn saliency(&self) -> JsValue {
        self.session.saliency().map_or(JsValue::UNDEFINED, convert::saliency)
    }

    /// Computes the saliency of each pixel of frame `t`, at working size: `{width, height, saliency}`.
    #[wasm_bindgen(js_name = saliencyMap)]
    pub fn saliency_map(&self, t: usize) -> Result<JsValue, JsValue> {
        self.session.saliency_map(t).map(|map| convert::saliency_map(&map)).map_err(|e| convert::to_js_error(&e))
    }

    /// Computes the agreement of the masks with the masks of nearby frames: an `Agreement` of `npm/session/result.ts`; `null`
    /// without masks.
    pub fn agreement(&self) -> JsValue {
        self.session.agreement().map_or(JsValue::NULL, convert::agreement)
    }

    /// Explains the label of pixel `x`, `y` of frame `t`: an `Explanation` of `npm/session/result.ts`.
    pub fn explain(&self, t: usize, x: usize, y: usize) -> Result<JsValue, JsValue> {
        let explanation = self.session.explain(t, (x, y)).map_err(|e| convert::to_js_error(&e))?;
        convert::to_js(&explanation)
    }

    /// `{count, ofPoint}`: the number of foreground components in each frame, and the component of each trajectory point, -1 for
    /// none; `undefined` as `saliency`.
    pub fn components(&self) -> JsValue {
        self.session.components().map_or(JsValue::UNDEFINED, convert::components)
    }

    /// `{count, ofCluster, labels, doubts}`; `undefined` until the cut is made, or without masks. `doubts` is a list of
    /// `{from, to}`, frames whose masks should be looked at; `null` until all masks are made.
    pub fn objects(&self) -> JsValue {
        let doubts = self.session.agreement().map_or(JsValue::NULL, convert::doubts);
        self.session.objects().map_or(JsValue::UNDEFINED, |objects| convert::objects(objects, doubts))
    }

    /// `{dimensions, eigenvalues, vectors, converged, residual}`; `undefined` until there is one.
    pub fn embedding(&self) -> JsValue {
        self.session.embedding().map_or(JsValue::UNDEFINED, |e| {
            object([
                ("dimensions", e.dimensions.into()),
                ("eigenvalues", float64_array(&e.eigenvalues)),
                ("vectors", single_precision(&e.vectors)),
                ("converged", e.info.converged.into()),
                ("residual", e.info.residual.into()),
            ])
        })
    }

    /// Neighbour pairs and the edges of each frame, `{i, j, d, frameOffset, frameEdges}`; `undefined` until there are
    /// any.
    pub fn edges(&self) -> JsValue {
        self.session.discontinuities().map_or(JsValue::UNDEFINED, |e| {
            let neighborhoods = &e.neighborhoods;
            let (i, j): (Vec<u32>, Vec<u32>) = neighborhoods.pairs.iter().copied().unzip();
            object([
                ("i", uint32_array(&i)),
                ("j", uint32_array(&j)),
                ("d", single_precision(&e.d)),
                ("frameOffset", uint32_array(&neighborhoods.frame_offset)),
                ("frameEdges", uint32_array(&neighborhoods.frame_edges)),
            ])
        })
    }
}
