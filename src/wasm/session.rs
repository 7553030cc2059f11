//! The session as JavaScript sees it.

use super::convert::{self, doubles, narrowed, object, words};
use crate::correction::{Correction, Stroke};
use crate::flow::FlowScratch;
use crate::image::Frame;
use crate::session::{Made, Piece, PieceId, Plan, Step, Window};
use crate::trajectory::Trajectories;
use crate::{Params, Session};
use wasm_bindgen::prelude::*;

/// One clip on its way through the stages, and its windows; see [`Session`].
#[wasm_bindgen(js_name = Session)]
#[derive(Debug)]
pub struct JsSession(Session, Plan);

impl JsSession {
    pub(super) fn params_in_force(&self) -> &Params {
        self.0.params()
    }

    fn correct(&mut self, correction: &Correction) -> Result<(), JsValue> {
        self.0.correct(correction).map_err(|e| convert::to_js_error(&e))
    }
}

#[wasm_bindgen(js_class = Session)]
impl JsSession {
    /// A session with the default parameters changed by `options`, a tree such as `{flow: {patchStride: 5}}`.
    #[wasm_bindgen(constructor)]
    pub fn new(options: JsValue) -> Result<JsSession, JsValue> {
        let session = convert::to_params(options).and_then(Session::new);
        session.map(|session| Self(session, Plan::default())).map_err(|e| convert::to_js_error(&e))
    }

    /// Adds a frame of `width * height` RGBA pixels.
    #[wasm_bindgen(js_name = pushRgba)]
    pub fn push_rgba(&mut self, rgba: &[u8], width: usize, height: usize) -> Result<(), JsValue> {
        self.0.push_rgba(rgba, width, height).map_err(|e| convert::to_js_error(&e))
    }

    /// The same in a clip that is taken window by window: a frame that begins a new shot is held back. Gives whether it
    /// was.
    #[wasm_bindgen(js_name = pushInShot)]
    pub fn push_in_shot(&mut self, rgba: &[u8], width: usize, height: usize) -> Result<bool, JsValue> {
        let frame = Frame::from_rgba(rgba, width, height);
        frame.and_then(|frame| self.0.push_in_shot(frame)).map_err(|e| convert::to_js_error(&e))
    }

    /// Goes on to the next window, which begins with the last `overlap` frames of this one, or with the frame held
    /// back.
    pub fn advance(&mut self, overlap: usize) -> Result<(), JsValue> {
        self.0.advance(overlap).map_err(|e| convert::to_js_error(&e))
    }

    /// Plans windows of `window` frames, neighbours with `overlap` in common.
    #[wasm_bindgen(js_name = planWindows)]
    pub fn plan_windows(&mut self, window: usize, overlap: Option<usize>) -> Result<(), JsValue> {
        let plan = Plan::new(window, overlap.unwrap_or_else(|| Window::overlap(window)));
        self.1 = plan.map_err(|e| convert::to_js_error(&e))?;
        Ok(())
    }

    /// How many frames the next window shares with the one at hand, a frame more being there and `left` still to come.
    pub fn shared(&self, left: Option<usize>) -> usize {
        self.1.shared(left)
    }

    /// The window at hand, of `frames` frames, is over; the next one shares `kept` of them, or begins a new shot. Gives its
    /// number, its shot's, the clip's of its first frame, and the first and the end of the frames that it settles.
    #[wasm_bindgen(js_name = closeWindow)]
    pub fn close_window(&mut self, frames: usize, kept: Option<usize>) -> Vec<usize> {
        let Window { index, shot, first_frame, settled } = self.1.close(frames, kept);
        vec![index, shot, first_frame, settled.start, settled.end]
    }

    /// Uses these trajectories, in input pixels, in place of frames.
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
        self.0.set_trajectories(trajectories).map_err(|e| convert::to_js_error(&e))
    }

    /// Takes one bounded step: `{stage, done, total}`, or `undefined` when nothing is left to do.
    pub fn step(&mut self) -> Result<JsValue, JsValue> {
        match self.0.step().map_err(|e| convert::to_js_error(&e))? {
            Step::Working(progress) => convert::to_js(&progress),
            Step::Done => Ok(JsValue::UNDEFINED),
        }
    }

    /// A piece of work for another worker, as words; `undefined` where none is left to give away at present. Flow is
    /// given away for at most `ahead` pairs from the next one on.
    #[wasm_bindgen(js_name = takePiece)]
    pub fn take_piece(&mut self, ahead: usize) -> Option<Vec<u32>> {
        self.0.take_piece(ahead).map(|piece| piece.to_words())
    }

    /// Takes a piece and makes it here; false where there is none.
    #[wasm_bindgen(js_name = makePiece)]
    pub fn make_piece(&mut self, ahead: usize) -> bool {
        self.0.make_piece(ahead)
    }

    /// Does a piece of work that a session with the same options gave away; words that are none give none.
    #[wasm_bindgen(js_name = workOn)]
    pub fn work_on(&self, piece: &[u32]) -> Vec<u32> {
        let made = |piece: Piece| piece.work(self.0.params(), &mut FlowScratch::default()).to_words(piece.id);
        Piece::from_words(piece).map_or_else(Vec::new, made)
    }

    /// Takes what another worker made of a piece.
    pub fn accept(&mut self, made: &[u32]) {
        if let Some((id, made)) = Made::from_words(made) {
            self.0.accept(id, Some(made));
        }
    }

    /// The piece that begins with these words will not come back: the session makes it itself.
    pub fn release(&mut self, piece: &[u32]) {
        if let Some(id) = PieceId::from_words(piece) {
            self.0.accept(id, None);
        }
    }

    /// Whether the next step needs a piece that was given away and is not back; taken all the same, it makes that
    /// itself.
    pub fn awaits(&self) -> bool {
        self.0.awaits()
    }

    /// What is `from` becomes `into`.
    pub fn merge(&mut self, into: u8, from: u8) -> Result<(), JsValue> {
        self.correct(&Correction::Merge { into, from })
    }

    /// An object becomes two; with `at`, the part at this place of frame `t` is the new one.
    pub fn split(&mut self, label: u8, at: bool, t: usize, x: f32, y: f32) -> Result<(), JsValue> {
        self.correct(&Correction::Split { label, at: at.then_some((t, x, y)) })
    }

    /// All that these strokes touch is one thing, or, with `apart`, each stroke is a thing of its own. Stroke `k` is
    /// painted in frame `t[k]` with a brush of radius `radius[k]`, through the points `offset[k]..offset[k + 1]`, each
    /// x and y in `points`.
    pub fn strokes(
        &mut self,
        apart: bool,
        t: Vec<u32>,
        radius: Vec<f32>,
        offset: Vec<u32>,
        points: Vec<f32>,
    ) -> Result<(), JsValue> {
        let part = |k: usize| points.get(2 * *offset.get(k)? as usize..2 * *offset.get(k + 1)? as usize);
        let stroke = |(k, (&t, &radius)): (usize, (&u32, &f32))| {
            let points = part(k).unwrap_or_default().chunks_exact(2).map(|p| (p[0], p[1])).collect();
            Stroke { t: t as usize, points, radius }
        };
        let strokes = t.iter().zip(&radius).enumerate().map(stroke).collect();
        self.correct(&if apart { Correction::Apart(strokes) } else { Correction::Together(strokes) })
    }

    /// Takes the last correction back.
    #[wasm_bindgen(js_name = undoCorrection)]
    pub fn undo_correction(&mut self) -> Result<(), JsValue> {
        self.0.undo_correction().map_err(|e| convert::to_js_error(&e))
    }

    /// Drops frames and results; parameters stay.
    pub fn clear(&mut self) {
        self.0.clear();
        self.1.begin_clip();
    }

    /// `{numFrames, width, height, workingWidth, workingHeight, corrections, memoryBytes}`; sizes are 0 before the
    /// first frame. The memory is that of the whole instance, which never shrinks.
    pub fn info(&self) -> JsValue {
        let (width, height) = self.0.input_size().unwrap_or_default();
        let (working_width, working_height) = self.0.working_size().unwrap_or_default();
        object([
            ("numFrames", self.0.num_frames().into()),
            ("width", width.into()),
            ("height", height.into()),
            ("workingWidth", working_width.into()),
            ("workingHeight", working_height.into()),
            ("corrections", self.0.num_corrections().into()),
            ("memoryBytes", convert::memory_bytes().into()),
        ])
    }

    /// The parameters in force, as a tree.
    pub fn params(&self) -> Result<JsValue, JsValue> {
        convert::to_js(self.0.params())
    }

    /// Forward flow from frame `t` to `t + 1`: `{width, height, u, v}`.
    pub fn flow(&self, t: usize) -> Result<JsValue, JsValue> {
        self.0.flow(t).map(|field| convert::flow(&field)).map_err(|e| convert::to_js_error(&e))
    }

    /// `{count, startFrame, offset, x, y, id}` in input pixels; `undefined` until there are any.
    pub fn trajectories(&self) -> JsValue {
        let numbers = self.0.trajectory_numbers();
        self.0.trajectories().map_or(JsValue::UNDEFINED, |t| convert::trajectories(t, numbers))
    }

    /// `{count, label}`; `undefined` until there are any.
    pub fn clusters(&self) -> JsValue {
        self.0.clusters().map_or(JsValue::UNDEFINED, convert::clusters)
    }

    /// `{count, label}` of the segmentation by thresholded discontinuities; `undefined` until there are any.
    #[wasm_bindgen(js_name = thresholdClusters)]
    pub fn threshold_clusters(&self) -> JsValue {
        self.0.threshold_clusters().as_ref().map_or(JsValue::UNDEFINED, convert::clusters)
    }

    /// The mask of frame `t`: a byte for each input pixel, 0 for the background.
    pub fn labels(&self, t: usize) -> Result<JsValue, JsValue> {
        self.0.labels(t).map(|mask| convert::bytes(mask.data())).map_err(|e| convert::to_js_error(&e))
    }

    /// The scene of frame `t` without the objects, at working size: `{width, height, data}`, RGBA with alpha 0 where it
    /// is not known.
    pub fn background(&self, t: usize) -> Result<JsValue, JsValue> {
        self.0.background(t).map(|plate| convert::picture(&plate)).map_err(|e| convert::to_js_error(&e))
    }

    /// The superpixels of frame `t` at working size; see `convert::superpixels`.
    pub fn superpixels(&self, t: usize) -> Result<JsValue, JsValue> {
        self.0.superpixels(t).map(convert::superpixels).map_err(|e| convert::to_js_error(&e))
    }

    /// The boundary map of frame `t` at working size: `{width, height, pb, thin}`.
    pub fn boundaries(&self, t: usize) -> Result<JsValue, JsValue> {
        self.0.boundaries(t).map(|map| convert::boundaries(&map)).map_err(|e| convert::to_js_error(&e))
    }

    /// `{ofPoints, inContext, foreground}`, an entry for each trajectory; `undefined` until known, and without frames.
    pub fn saliency(&self) -> JsValue {
        self.0.saliency().map_or(JsValue::UNDEFINED, convert::saliency)
    }

    /// How salient each pixel of frame `t` is, at working size: `{width, height, saliency}`.
    #[wasm_bindgen(js_name = saliencyMap)]
    pub fn saliency_map(&self, t: usize) -> Result<JsValue, JsValue> {
        self.0.saliency_map(t).map(|map| convert::saliency_map(&map)).map_err(|e| convert::to_js_error(&e))
    }

    /// How likely the label of each pixel of frame `t` is right, at working size: `{width, height, confidence}`.
    pub fn confidence(&self, t: usize) -> Result<JsValue, JsValue> {
        self.0.confidence(t).map(|map| convert::confidence(&map)).map_err(|e| convert::to_js_error(&e))
    }

    /// The mean confidence of each label, the background first.
    #[wasm_bindgen(js_name = objectConfidence)]
    pub fn object_confidence(&self) -> Result<Vec<f32>, JsValue> {
        self.0.object_confidence().map_err(|e| convert::to_js_error(&e))
    }

    /// Why the pixel `x`, `y` of frame `t` has its label: an `Explanation` of `npm/session/result.ts`.
    pub fn explain(&self, t: usize, x: usize, y: usize) -> Result<JsValue, JsValue> {
        let why = self.0.explain(t, x, y).map_err(|e| convert::to_js_error(&e))?;
        convert::to_js(&why)
    }

    /// `{count, ofPoint}`: the components of the foreground in each frame, and which of them each trajectory point is
    /// in, -1 for none; `undefined` as `saliency`.
    pub fn components(&self) -> JsValue {
        self.0.components().map_or(JsValue::UNDEFINED, convert::components)
    }

    /// `{count, ofCluster, labels}`; `undefined` until the cut is made, or without masks.
    pub fn objects(&self) -> JsValue {
        self.0.objects().map_or(JsValue::UNDEFINED, convert::objects)
    }

    /// `{dimensions, eigenvalues, vectors, converged, residual}`; `undefined` until there is one.
    pub fn embedding(&self) -> JsValue {
        self.0.embedding().map_or(JsValue::UNDEFINED, |e| {
            object([
                ("dimensions", e.dimensions.into()),
                ("eigenvalues", doubles(&e.eigenvalues)),
                ("vectors", narrowed(&e.vectors)),
                ("converged", e.info.converged.into()),
                ("residual", e.info.residual.into()),
            ])
        })
    }

    /// Neighbour pairs and the edges of each frame, `{i, j, d, frameOffset, frameEdges}`; `undefined` until there are
    /// any.
    pub fn edges(&self) -> JsValue {
        self.0.discontinuities().map_or(JsValue::UNDEFINED, |e| {
            let near = &e.neighborhoods;
            let (i, j): (Vec<u32>, Vec<u32>) = near.pairs.iter().copied().unzip();
            object([
                ("i", words(&i)),
                ("j", words(&j)),
                ("d", narrowed(&e.d)),
                ("frameOffset", words(&near.frame_offset)),
                ("frameEdges", words(&near.frame_edges)),
            ])
        })
    }
}
