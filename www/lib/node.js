/**
 * TraceCut in Node: the same interface as in browsers; the work runs in-process, in slices.
 * @module
 */

import { readFile } from 'node:fs/promises';
import { makeClip } from './clip.js';
import { TraceCutError } from './errors.js';
import { boundariesOf, superpixelsOf } from './image.js';
import { loadModule } from './load.js';
import { openSession } from './session.js';

export * from './common.js';

/** @type {Promise<WebAssembly.Module> | undefined} */
let packaged;

/** @type {import('./platform.js').Platform} */
const platform = {
  loadModule(source) {
    if (source instanceof URL && source.protocol === 'file:') return readModule(source);
    if (source !== undefined) return loadModule(source);
    packaged ??= readModule(new URL('./tracecut_bg.wasm', import.meta.url));
    packaged.catch(() => (packaged = undefined));
    return packaged;
  },
  startWorker: undefined,
};

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
