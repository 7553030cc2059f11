/**
 * TraceCut in Node: the same interface as in browsers; the work runs in-process, in slices.
 * @module
 */

import { readFile } from 'node:fs/promises';
import { makeClip } from './clip.js';
import { TraceCutError } from './errors.js';
import { boundariesOf, discontinuitiesOf, superpixelsOf } from './image.js';
import { loadModule } from './load.js';
import { once } from './platform.js';
import { openSession } from './session.js';
import { framesOf, infoOf } from './video/frames.js';
import { segment } from './video/segment.js';

export * from './common.js';

const packaged = once(() => readModule(new URL('./tracecut_bg.wasm', import.meta.url)));
const packagedDecoder = once(() => readModule(new URL('./decoder_bg.wasm', import.meta.url)));

/** @type {import('./platform.js').Platform} */
const platform = {
  loadModule: (source) => (source === undefined ? packaged() : load(source)),
  loadDecoder: (source) => (source === undefined ? packagedDecoder() : load(source)),
  startWorker: undefined,
};

/** @param {import('./options.js').WasmSource} source */
function load(source) {
  return source instanceof URL && source.protocol === 'file:' ? readModule(source) : loadModule(source);
}

/** @param {URL} url */
async function readModule(url) {
  try {
    return await loadModule(await readFile(url));
  } catch (cause) {
    if (cause instanceof TraceCutError) throw cause;
    throw new TraceCutError('wasm-load', `${url.href} could not be read: ${String(cause)}`, { cause });
  }
}

/**
 * Opens a session.
 * @param {import('./options.js').SessionOptions} [options]
 * @returns {Promise<import('./session.js').Session>}
 */
export function createSession(options) {
  return openSession(options, platform);
}

/**
 * Makes a clip of moving objects with known masks and known flow, on the calling thread.
 * @param {import('./clip.js').ClipOptions} [options]
 * @returns {Promise<import('./clip.js').Clip>}
 */
export function synthClip(options) {
  return makeClip(options, platform);
}

/**
 * The boundary probability of a single image, at its own size.
 * @param {import('./frames.js').FrameSource} image
 * @param {import('./image.js').ImageOptions} [options]
 * @returns {Promise<import('./image.js').BoundaryMap>}
 */
export function boundaries(image, options) {
  return boundariesOf(image, options, platform);
}

/**
 * The Gabriel superpixels of a single image, at its own size.
 * @param {import('./frames.js').FrameSource} image
 * @param {import('./image.js').SuperpixelOptions} [options]
 * @returns {Promise<import('./image.js').Superpixels>}
 */
export function superpixels(image, options) {
  return superpixelsOf(image, options, platform);
}

/**
 * Boundaries of a single image by the discontinuities of its pixel embedding, at its own size or reduced to `still.maxSide`.
 * @param {import('./frames.js').FrameSource} image
 * @param {import('./image.js').DiscontinuityOptions} [options]
 * @returns {Promise<import('./image.js').ImageDiscontinuities>}
 */
export function imageDiscontinuities(image, options) {
  return discontinuitiesOf(image, options, platform);
}

/**
 * Segments a video: a file, an address, a video element, a stream, or frames one by one (Node takes the last only). Long clips are run window by
 * window, in bounded memory; labels keep their meaning from window to window, and a cut begins a new shot with new ones.
 *
 * ```js
 * const video = segmentVideo(file, { size: 480, end: 10 });
 * for await (const window of video) {
 *   for (const { time, labels } of window.frames()) console.log(time, labels);
 * }
 * ```
 * @param {import('./video/source.js').VideoSource} source
 * @param {import('./video/segment.js').VideoOptions} [options]
 * @returns {import('./video/segment.js').VideoSegmentation}
 */
export function segmentVideo(source, options) {
  return segment(source, options, platform);
}

/**
 * The frames of a video, in order, each with its time in seconds; none is lost or doubled. Nothing is read before the first is asked for, and
 * leaving the loop closes the source.
 * @param {import('./video/source.js').VideoSource} source
 * @param {import('./video/options.js').TakeOptions} [options]
 * @returns {AsyncGenerator<import('./video/frames.js').DecodedFrame, void, undefined>}
 */
export function videoFrames(source, options) {
  return framesOf(source, options, platform);
}

/**
 * Size, duration, frame rate and codec of a video, read from its container where there is one.
 * @param {import('./video/source.js').VideoSource} source
 * @param {Pick<import('./video/options.js').TakeOptions, 'decoding'>} [options]
 * @returns {Promise<import('./video/reader.js').VideoInfo>}
 */
export function videoInfo(source, options) {
  return infoOf(source, options, platform);
}
