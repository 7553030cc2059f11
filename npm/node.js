/**
 * TraceCut in Node: the same interface as in browsers, and readers of streams and files; the work runs in-process, in
 * slices, and on threads beside it, or with `worker: true` off the calling thread altogether.
 * @module
 */

export * from './node/index.js';
export { framesOfRaw } from './node/raw.js';
export { framesOfVideo } from './node/video.js';

/** @typedef {import('./node/raw.js').ByteSource} ByteSource */
/** @typedef {import('./node/video.js').FfmpegOptions} FfmpegOptions */
/** @typedef {import('./node/raw.js').RawOptions} RawOptions */
