/**
 * TraceCut in Node: the same interface as in browsers, and readers of streams and files; the work runs in-process, in
 * slices, and on threads beside it, or with `worker: true` off the calling thread altogether.
 * @module
 */

export * from './node/index.js';
export { framesOfRaw, framesOfVideo, framesOfY4m } from './node/frames.js';

/** @typedef {import('./node/frames.js').ByteSource} ByteSource */
/** @typedef {import('./node/frames.js').FfmpegOptions} FfmpegOptions */
/** @typedef {import('./node/frames.js').RawOptions} RawOptions */
