// PNG and JPEG files to pixels, in a wasm module of their own: who pushes pixels never fetches it.

import startDecoder, * as glue from './decoder.js';
import { TraceCutError } from './errors.js';

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
  const [data, width, height] = await callDecoder(
    frame.decoder,
    (decoder) => decoder.decode(frame.data, frame.maxPixels),
    (words) => ['decode', `image cannot be decoded: the decoder stopped on an internal error: ${words}`],
  );
  return { data, width, height };
}

/**
 * Calls into the module. An error that Rust returned has a code; anything else is a panic or a trap, which `broken` puts
 * into words.
 * @template T
 * @param {WebAssembly.Module} module
 * @param {(decoder: typeof glue) => T} call
 * @param {(words: string) => [import('./errors.js').ErrorCode, string]} broken
 * @returns {Promise<T>}
 */
export async function callDecoder(module, call, broken) {
  started ??= startDecoder({ module_or_path: module });
  await started;
  try {
    return call(glue);
  } catch (error) {
    if (error instanceof Error && 'code' in error && typeof error.code === 'string') {
      throw new TraceCutError(/** @type {import('./errors.js').ErrorCode} */ (error.code), error.message);
    }
    // The next call gets a fresh instance.
    glue.__wbg_reset_state();
    throw new TraceCutError(...broken(String(error)), { cause: error });
  }
}
