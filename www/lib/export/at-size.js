// Masks at the size of the pictures that they are laid over.

import { TraceCutError } from '../errors.js';
import { decodeRuns, encodeRuns } from '../video/masks.js';
import { checkedEdges, grown, softAlpha, withoutSpecks } from './adjust.js';
import { pixelsOf } from './drawable.js';
import { breath } from './masks.js';
import { MAX_LABEL, checkMasks, checkedOptions, chosenLabels, labelsOf, timesOf } from './mask-source.js';

/** @typedef {import('./mask-source.js').MaskSource} MaskSource */
/** @typedef {import('./adjust.js').Mask} Mask */

/**
 * `labels` holds a label for each pixel, `alpha` how opaque the chosen objects are there, 0 to 255. @typedef {{width:
 * number, height: number, labels: Uint8Array<ArrayBuffer>, alpha: Uint8Array<ArrayBuffer>}} MaskAtSize
 */

/**
 * @typedef {object} MasksAtSizeOptions
 * @property {(progress: import('./masks.js').ExportProgress) => void} [onProgress] told of each frame
 * @property {import('./adjust.js').MaskEdges} [edges] specks left out, objects grown or shrunk; `feather` is of no meaning
 *   here
 * @property {AbortSignal} [signal] ends the work: the promise rejects with its reason
 */

/**
 * Brings a mask to the size of a picture that is as large or larger. @typedef {(mask: Mask, picture:
 * import('../frames.js').PixelFrame, options: {objects: (label: number) => boolean}) => Promise<MaskAtSize>} Enlarge
 */

/**
 * @param {MaskSource} masks
 * @param {import('./video.js').EncodeFrames} frames
 * @param {MasksAtSizeOptions | undefined} options
 * @param {Enlarge} enlarge
 * @returns {Promise<MaskSource>}
 */
export async function sized(masks, frames, options = {}, enlarge) {
  checkMasks(masks);
  const { onProgress, signal, edges } = checkedOptions(options, ['onProgress', 'signal', 'edges']);
  const how = checkedEdges(edges);
  const { numFrames, shots } = masks;
  const times = timesOf(masks);
  const all = chosenLabels(undefined);
  const size = { width: 0, height: 0 };
  /** @type {Uint32Array<ArrayBuffer>[]} */
  const runs = [];
  for await (const item of frames) {
    signal?.throwIfAborted();
    const t = runs.length;
    const picture = await pixelsOf(item, t);
    if (t === 0) Object.assign(size, { width: picture.width, height: picture.height });
    checkSize(picture, size, t);
    const { width, height } = masks;
    const { labels } = await maskAtSize({ labels: labelsOf(masks, t), width, height }, picture, {
      chosen: all,
      edges: how,
      enlarge,
    });
    runs.push(encodeRuns(labels));
    onProgress?.({ done: t + 1, total: numFrames });
    if (t + 1 === numFrames) break;
    await breath();
  }
  if (runs.length < numFrames) throw tooFew(runs.length, numFrames);
  const same = Uint8Array.from({ length: MAX_LABEL + 1 }, (_, label) => label);
  return {
    ...size,
    numFrames,
    times,
    ...(Array.isArray(shots) ? { shots } : {}),
    labels: (t) => decodeRuns(/** @type {Uint32Array} */ (runs[t]), size.width * size.height, same),
  };
}

/**
 * A mask at the size of a picture, its edges as they are wanted: specks are left out first, so that they grow nowhere;
 * lengths are scaled with the mask.
 * @param {Mask} mask
 * @param {import('../frames.js').PixelFrame} picture RGBA
 * @param {{chosen: Uint8Array, edges: Required<import('./adjust.js').MaskEdges>, enlarge: Enlarge}} how `chosen` is 1
 *   for each label that is meant
 * @returns {Promise<MaskAtSize>}
 */
export async function maskAtSize(mask, picture, { chosen, edges, enlarge }) {
  const { width, height } = picture;
  const clean = withoutSpecks(mask, chosen, edges.smallest);
  const scale = Math.sqrt((width * height) / (mask.width * mask.height));
  const large = await atSize(clean, picture, chosen, enlarge);
  // The picture says how soft edges are, unless they are wanted otherwise.
  if (large.alpha && edges.grow === 0 && edges.feather === 0) return { ...large, alpha: large.alpha };
  const { labels } = grown({ labels: large.labels, width, height }, chosen, scale * edges.grow);
  return { width, height, labels, alpha: softAlpha({ labels, width, height }, chosen, scale * edges.feather) };
}

/**
 * @param {{labels: Uint8Array<ArrayBuffer>, width: number, height: number}} mask
 * @param {import('../frames.js').PixelFrame} picture
 * @param {Uint8Array} chosen
 * @param {Enlarge} enlarge
 * @returns {Promise<{width: number, height: number, labels: Uint8Array<ArrayBuffer>, alpha?: Uint8Array<ArrayBuffer>}>}
 */
async function atSize(mask, picture, chosen, enlarge) {
  const { width, height } = picture;
  if (mask.width === width && mask.height === height) return mask;
  if (mask.width <= width && mask.height <= height)
    return enlarge(mask, picture, { objects: (label) => chosen[label] === 1 });
  return { width, height, labels: reduced(mask, width, height) };
}

/**
 * Each pixel has the label of the mask's pixel in which its centre lies.
 * @param {Mask} mask
 * @param {number} width
 * @param {number} height
 */
function reduced(mask, width, height) {
  const labels = new Uint8Array(width * height);
  const columns = Uint32Array.from({ length: width }, (_, x) => Math.floor(((x + 0.5) * mask.width) / width));
  for (let y = 0, p = 0; y < height; y += 1) {
    const row = mask.width * Math.floor(((y + 0.5) * mask.height) / height);
    for (let x = 0; x < width; x += 1, p += 1)
      labels[p] = /** @type {number} */ (mask.labels[row + Number(columns[x])]);
  }
  return labels;
}

/**
 * @param {{width: number, height: number}} frame
 * @param {{width: number, height: number}} size
 * @param {number} t
 */
export function checkSize(frame, size, t) {
  if (frame.width === size.width && frame.height === size.height) return;
  throw new TraceCutError(
    'frame-size-changed',
    `frame ${t} is ${frame.width} × ${frame.height} pixels (expected ${size.width} × ${size.height}, as the first)`,
  );
}

/**
 * @param {number} count
 * @param {number} expected
 */
export function tooFew(count, expected) {
  return new TraceCutError(
    'data',
    `the frames ended after ${count} of ${expected} (expected one for each frame of the masks)`,
  );
}
