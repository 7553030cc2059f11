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
  started ??= startDecoder({ module_or_path: frame.decoder });
  await started;
  return decoded(frame.data);
}

/** @param {Uint8Array} file */
function decoded(file) {
  try {
    const [data, width, height] = glue.decode(file);
    return { data, width, height };
  } catch (error) {
    if (error instanceof Error && 'code' in error && typeof error.code === 'string') {
      throw new TraceCutError(/** @type {import('./errors.js').ErrorCode} */ (error.code), error.message);
    }
    // A panic or a trap: the next file gets a fresh instance.
    glue.__wbg_reset_state();
    throw new TraceCutError(
      'decode',
      `image cannot be decoded: the decoder stopped on an internal error: ${String(error)}`,
      { cause: error },
    );
  }
}
