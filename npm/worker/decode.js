// What the second wasm module does, in this thread: PNG and JPEG files to pixels, masks to the size of their pictures and to
// data.

import { TraceCutError, throwIfRust } from '../check/errors.js';
import startDecoder, { __wbg_reset_state, decode, enlarge } from '../decoder.js';
import { fromImage } from './frames.js';

/** @type {Promise<unknown> | undefined} */
let started;

/** @typedef {{data: Uint8Array<ArrayBuffer>, width: number, height: number}} Pixels */

/**
 * The pixels of a frame on its way to the engine.
 * @param {import('./frames.js').RawFrame} frame
 * @returns {Promise<Pixels>}
 */
export async function toPixels(frame) {
  if (frame.kind === 'pixels') return frame;
  if (!frame.decoder) throw new TraceCutError('state', 'a file came without the module that decodes it');
  const call = () => decode(frame.data, frame.maxPixels);
  const [data, width, height] = await callDecoder(frame.decoder, call, 'image cannot be decoded', 'decode');
  return { data, width, height };
}

/**
 * Calls into the module, once it has started. An error that Rust returned has a code; anything else is a panic or a trap.
 * @template T
 * @param {WebAssembly.Module} module
 * @param {() => T} call
 * @param {string} failure what cannot be done then
 * @param {import('../check/errors.js').ErrorCode} [code] of that
 * @returns {Promise<T>}
 */
export async function callDecoder(module, call, failure, code = 'poisoned') {
  started ??= startDecoder({ module_or_path: module });
  await started;
  try {
    return call();
  } catch (error) {
    throwIfRust(error);
    // The next call gets a fresh instance.
    __wbg_reset_state();
    throw new TraceCutError(code, `${failure}: the decoder stopped on an internal error: ${error}`, { cause: error });
  }
}

/**
 * A mask at the size of its picture: `labels` holds the label of each pixel, `alpha` how opaque the chosen objects are
 * there, 0 not at all to 255 fully: from 128 on exactly where the label is one of theirs, soft where the picture goes
 * softly from one to the other, and 0 or 255 away from their borders.
 * @typedef {{readonly width: number, readonly height: number, readonly labels: Uint8Array<ArrayBuffer>,
 *   readonly alpha: Uint8Array<ArrayBuffer>}}
 *   EnlargedMask
 */

/**
 * A picture that a worker reads: to do so takes long enough to be felt where pages are drawn.
 * @typedef {{kind: 'image', image: VideoFrame | ImageBitmap}} Image
 */

/**
 * A mask and its picture on their way, in memory that nobody else holds.
 * @typedef {{labels: Uint8Array<ArrayBuffer>, width: number, picture: import('./frames.js').RawFrame | Image, chosen:
 *   Uint8Array<ArrayBuffer>, module: WebAssembly.Module}} EnlargeTask
 */

/**
 * Enlarges in this thread.
 * @param {EnlargeTask} task
 * @returns {Promise<EnlargedMask>}
 */
export async function enlargeHere({ labels, width, picture, chosen, module }) {
  const pixels = await pixelsOf(picture);
  const call = () => enlarge(labels, width, pixels.data, pixels.width, pixels.height, chosen);
  const [large, alpha] = await callDecoder(module, call, 'the mask cannot be enlarged');
  return { width: pixels.width, height: pixels.height, labels: large, alpha };
}

/** @param {EnlargeTask['picture']} picture */
async function pixelsOf(picture) {
  if (picture.kind !== 'image') return toPixels(picture);
  try {
    return await toPixels(await fromImage(picture.image));
  } finally {
    picture.image.close();
  }
}
