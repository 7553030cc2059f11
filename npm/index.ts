/**
 * TraceCut in browsers and bundlers: finds the moving objects in a video. The work runs in a module worker.
 *
 * ```js
 * const session = await createSession();
 * for (const frame of frames) await session.push(frame);
 * const result = await session.run({ onProgress: ({ stage, share, secondsLeft }) => {} });
 * result.labels(0); result.trajectories; result.clusters.label; session.close();
 * ```
 * @module
 */

import { PARAMETERS, type Parameter, VERSION } from './parameters.js';
import { loadPart } from './platform.js';

export { VideoSegmentation, segmentVideo } from './video/segment.js';
export { Session, createSession } from './session/session.js';
export { drawLabels } from './draw/labels.js';

// These are loaded on their first call.
export const masksZip: typeof import('./kit/export/masks.js').masksZip = async (...args) =>
  (await loadPart(import('./kit/export/masks.js'))).masksZip(...args);
export const encodeVideo: typeof import('./kit/export/video.js').encodeVideo = async (...args) =>
  (await loadPart(import('./kit/export/video.js'))).encodeVideo(...args);
export const maskPng: typeof import('./kit/export/masks.js').maskPng = async (...args) =>
  (await loadPart(import('./kit/export/masks.js'))).maskPng(...args);
export const segmentEach: typeof import('./video/queue.js').segmentEach = async function* (...args) {
  yield* (await loadPart(import('./video/queue.js'))).segmentEach(...args);
};
export const readFrames: typeof import('./video/frame-list.js').readFrames = async function* (...args) {
  yield* (await loadPart(import('./video/frame-list.js'))).readFrames(...args);
};
export const videoStrip: typeof import('./video/strip.js').videoStrip = async function* (...args) {
  yield* (await loadPart(import('./video/strip.js'))).videoStrip(...args);
};

export { previewMasks } from './video/segment.js';
export { videoFrames, videoInfo } from './video/source.js';
export { sortFiles } from './video/file-kind.js';
export { fitSize } from './video/pixels.js';
export { Clip, synthClip } from './stages/clip.js';
export { searchReport } from './session/report.js';
export { Result } from './session/result.js';
export { VideoResult } from './video/result.js';
export { WindowResult } from './video/window.js';
export { TraceCutError } from './check/errors.js';
export { configure } from './platform.js';

/** The package's version. */
export const version = VERSION;

/** Returns all parameters with their meaning, kind, range and default, in the order of the stages. */
export function parameters(): Parameter[] {
  return PARAMETERS.map((parameter) => ({ ...parameter }));
}

export type { ErrorCode } from './check/errors.js';
export type { MaskSource, ObjectChoice } from './check/masks.js';
export type { SessionOptions, SessionSettings, WasmSource } from './check/options.js';
export type { Context2D } from './draw/canvas.js';
export type { DrawLabelsOptions, LabelColors } from './draw/labels.js';
export type { ExportProgress, MaskPngOptions, MasksZipOptions } from './kit/export/masks.js';
export type { SoundOptions, VideoQuality } from './kit/export/video-options.js';
export type { EncodeFrame, EncodeFrames, EncodeVideoOptions } from './kit/export/video.js';
export type { Parameter, ParameterOptions } from './parameters.js';
export type { Places, WorkerSource } from './platform.js';
export type { FlowField, Stage } from './session/engine.js';
export type { Progress } from './session/progress.js';
export type { Place, Stroke, TrajectoryInput } from './session/requests.js';
export type { ObjectList, SearchInput, SearchReport, VideoObject } from './session/report.js';
export type {
  Agreement,
  Background,
  ClusterList,
  ClusterObjects,
  ComponentTable,
  EdgeTable,
  Edges,
  EmbeddingTable,
  Explanation,
  FrameRange,
  LabelCost,
  SaliencyMap,
  SaliencyTable,
  SuperpixelLink,
  TrajectoryList,
  Voter,
} from './session/result.js';
export type { RunOptions } from './session/session.js';
export type { ClipOptions } from './stages/clip.js';
export type { BoundaryMap, Superpixels } from './stages/image.js';
export type { EachOptions, EachProgress, QueuedClip, SegmentedClip } from './video/queue.js';
export type { SortedFile } from './video/file-kind.js';
export type { FrameAtTime, FrameFile, ListedFrame } from './video/frame-list.js';
export type { Damage, TakeOptions, VideoInfo } from './video/reader.js';
export type { ClipTrajectories, Shot, Truncation } from './video/result.js';
export type { VideoOptions, VideoProgress, WindowOptions } from './video/segment.js';
export type { DecodedFrame, DrawableFrame, VideoSource } from './video/source.js';
export type { StripCount, StripOptions } from './video/strip.js';
export type { SettledFrame } from './video/window.js';
export type { FrameSource, PixelFrame } from './worker/frames.js';
