/**
 * TraceCut in browsers and bundlers: finds the moving objects in a video. The work runs in a module worker.
 *
 * ```js
 * const session = await createSession();
 * for (const frame of frames) await session.push(frame);
 * const result = await session.run({ onProgress: ({ stage, done, total }) => {} });
 * result.labels(0); result.trajectories; result.clusters.label; session.close();
 * ```
 * @module
 */

import { PARAMETERS, VERSION } from './parameters.js';
import { part } from './places.js';

export { VideoSegmentation, segmentVideo } from './video/segment.js';
export { Session, createSession } from './session/session.js';
export { drawLabels } from './draw/labels.js';

// These are loaded when they are first called.
/** @type {typeof import('./kit/export/masks.js').masksZip} */
export const masksZip = async (...args) => (await part(import('./kit/export/masks.js'))).masksZip(...args);
/** @type {typeof import('./kit/export/video.js').encodeVideo} */
export const encodeVideo = async (...args) => (await part(import('./kit/export/video.js'))).encodeVideo(...args);
/** @type {typeof import('./kit/export/masks.js').maskPng} */
export const maskPng = async (...args) => (await part(import('./kit/export/masks.js'))).maskPng(...args);
/** @type {typeof import('./video/each.js').segmentEach} */
export const segmentEach = async function* (...args) {
  yield* (await part(import('./video/each.js'))).segmentEach(...args);
};
/** @type {typeof import('./video/listed.js').readFrames} */
export const readFrames = async function* (...args) {
  yield* (await part(import('./video/listed.js'))).readFrames(...args);
};
/** @type {typeof import('./video/strip.js').videoStrip} */
export const videoStrip = async function* (...args) {
  yield* (await part(import('./video/strip.js'))).videoStrip(...args);
};

export { previewMasks } from './video/segment.js';
export { videoFrames, videoInfo } from './video/source.js';
export { sortFiles } from './video/kind.js';
export { fitSize } from './video/pixels.js';
export { Clip, synthClip } from './stages/clip.js';
export { searchReport } from './session/report.js';
export { Result } from './session/result.js';
export { VideoResult } from './video/result.js';
export { WindowResult } from './video/window.js';
export { TraceCutError } from './check/errors.js';
export { configure } from './places.js';

/** The package's version. */
export const version = VERSION;

/**
 * All parameters with their meaning, kind, range and default, in the order of the stages.
 * @returns {import('./parameters.js').Parameter[]}
 */
export function parameters() {
  return PARAMETERS.map((parameter) => ({ ...parameter }));
}

/** @typedef {import('./check/errors.js').ErrorCode} ErrorCode */
/** @typedef {import('./check/options.js').SessionOptions} SessionOptions */
/** @typedef {import('./parameters.js').ParameterOptions} ParameterOptions */
/** @typedef {import('./check/options.js').SessionSettings} SessionSettings */
/** @typedef {import('./check/options.js').WasmSource} WasmSource */
/** @typedef {import('./places.js').Places} Places */
/** @typedef {import('./places.js').WorkerSource} WorkerSource */
/** @typedef {import('./parameters.js').Parameter} Parameter */
/** @typedef {import('./worker/frames.js').FrameSource} FrameSource */
/** @typedef {import('./worker/frames.js').PixelFrame} PixelFrame */
/** @typedef {import('./stages/clip.js').ClipOptions} ClipOptions */
/** @typedef {import('./session/inputs.js').TrajectoryInput} TrajectoryInput */
/** @typedef {import('./session/inputs.js').Place} Place */
/** @typedef {import('./session/engine.js').Progress} Progress */
/** @typedef {import('./session/engine.js').Stage} Stage */
/** @typedef {import('./session/engine.js').FlowField} FlowField */
/** @typedef {import('./stages/image.js').BoundaryMap} BoundaryMap */
/** @typedef {import('./stages/image.js').Superpixels} Superpixels */
/** @typedef {import('./session/result.js').Background} Background */
/** @typedef {import('./session/result.js').ClusterList} ClusterList */
/** @typedef {import('./session/result.js').EdgeTable} EdgeTable */
/** @typedef {import('./session/result.js').Edges} Edges */
/** @typedef {import('./session/result.js').EmbeddingTable} EmbeddingTable */
/** @typedef {import('./session/result.js').TrajectoryList} TrajectoryList */
/** @typedef {import('./session/result.js').ComponentTable} ComponentTable */
/** @typedef {import('./session/result.js').ClusterObjects} ClusterObjects */
/** @typedef {import('./session/result.js').ConfidenceMap} ConfidenceMap */
/** @typedef {import('./session/result.js').Explanation} Explanation */
/** @typedef {import('./session/result.js').LabelCost} LabelCost */
/** @typedef {import('./session/result.js').SuperpixelLink} SuperpixelLink */
/** @typedef {import('./session/result.js').Voter} Voter */
/** @typedef {import('./session/report.js').ObjectList} ObjectList */
/** @typedef {import('./session/result.js').SaliencyMap} SaliencyMap */
/** @typedef {import('./session/result.js').SaliencyTable} SaliencyTable */
/** @typedef {import('./session/report.js').Searched} Searched */
/** @typedef {import('./session/report.js').SearchReport} SearchReport */
/** @typedef {import('./session/session.js').RunOptions} RunOptions */
/** @typedef {import('./video/source.js').DecodedFrame} DecodedFrame */
/** @typedef {import('./video/listed.js').FrameAtTime} FrameAtTime */
/** @typedef {import('./video/listed.js').FrameFile} FrameFile */
/** @typedef {import('./video/listed.js').ListedFrame} ListedFrame */
/** @typedef {import('./video/kind.js').SortedFile} SortedFile */
/** @typedef {import('./video/reader.js').Damage} Damage */
/** @typedef {import('./video/reader.js').TakeOptions} TakeOptions */
/** @typedef {import('./video/reader.js').VideoInfo} VideoInfo */
/** @typedef {import('./video/result.js').Shot} Shot */
/** @typedef {import('./video/result.js').Truncated} Truncated */
/** @typedef {import('./session/report.js').VideoObject} VideoObject */
/** @typedef {import('./video/segment.js').VideoOptions} VideoOptions */
/** @typedef {import('./video/segment.js').VideoProgress} VideoProgress */
/** @typedef {import('./video/segment.js').WindowOptions} WindowOptions */
/** @typedef {import('./video/source.js').VideoSource} VideoSource */
/** @typedef {import('./video/strip.js').StripOptions} StripOptions */
/** @typedef {import('./video/strip.js').StripCount} StripCount */
/** @typedef {import('./video/result.js').ClipTrajectories} ClipTrajectories */
/** @typedef {import('./video/window.js').SettledFrame} SettledFrame */
/** @typedef {import('./draw/canvas.js').Context2D} Context2D */
/** @typedef {import('./draw/labels.js').DrawLabelsOptions} DrawLabelsOptions */
/** @typedef {import('./draw/palette.js').LabelColors} LabelColors */
/** @typedef {import('./video/each.js').EachOptions} EachOptions */
/** @typedef {import('./video/each.js').EachProgress} EachProgress */
/** @typedef {import('./video/each.js').QueuedClip} QueuedClip */
/** @typedef {import('./video/each.js').SegmentedClip} SegmentedClip */
/** @typedef {import('./check/masks.js').MaskSource} MaskSource */
/** @typedef {import('./check/masks.js').ObjectChoice} ObjectChoice */
/** @typedef {import('./kit/export/masks.js').ExportProgress} ExportProgress */
/** @typedef {import('./kit/export/masks.js').MaskPngOptions} MaskPngOptions */
/** @typedef {import('./kit/export/masks.js').MasksZipOptions} MasksZipOptions */
/** @typedef {import('./kit/export/video.js').EncodeFrame} EncodeFrame */
/** @typedef {import('./kit/export/video.js').EncodeFrames} EncodeFrames */
/** @typedef {import('./kit/export/video.js').EncodeVideoOptions} EncodeVideoOptions */
/** @typedef {import('./kit/export/quality.js').VideoQuality} VideoQuality */
/** @typedef {import('./kit/export/sound.js').SoundOptions} SoundOptions */
/** @typedef {import('./session/inputs.js').Stroke} Stroke */
