// Masks at the size of the source in this thread, by the module that also reads image files.

import { callDecoder, toPixels } from './decode.js';
import { fromImage } from './frames.js';

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
  const [large, alpha] = await callDecoder(
    module,
    (decoder) => decoder.enlarge(labels, width, pixels.data, pixels.width, pixels.height, chosen),
    (words) => ['poisoned', `the mask cannot be enlarged: the module stopped on an internal error: ${words}`],
  );
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
