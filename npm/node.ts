/**
 * TraceCut in Node: the same interface as in browsers, and readers of streams and files. The work runs in-process, in
 * slices, with threads beside it, or with `worker: true` off the calling thread altogether.
 * @module
 */

export * from './node/index.js';
export { framesOfRaw } from './node/raw.js';
export { framesOfVideo } from './node/video.js';

export type { ByteSource, RawOptions } from './node/raw.js';
export type { FfmpegOptions } from './node/video.js';
