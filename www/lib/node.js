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
