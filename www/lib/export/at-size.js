// Masks at the size of the pictures that they are laid over.

import { enlargeMask } from '../enlarge.js';
import { TraceCutError, checkedOptions } from '../errors.js';
import { decodeRuns, encodeRuns } from '../video/masks.js';
import { checkedEdges, grown, softAlpha, withoutSpecks } from './adjust.js';
import { breath } from './breath.js';
import { pixelsOf } from './drawable.js';
import { MAX_LABEL, checkMasks, chosenLabels, labelsOf, timesOf } from './mask-source.js';

/** @typedef {import('./mask-source.js').MaskSource} MaskSource */
/** @typedef {import('./adjust.js').Mask} Mask */

/**
 * `labels` holds a label for each pixel, `alpha` how opaque the chosen objects are there, 0 to 255. @typedef {{width:
 * number, height: number, labels: Uint8Array, alpha: Uint8Array<ArrayBuffer>}} MaskAtSize
 */

/**
 * @typedef {object} MasksAtSizeOptions
 * @property {(progress: import('./masks.js').ExportProgress) => void} [onProgress] told of each frame
 * @property {import('./adjust.js').MaskEdges} [edges] specks left out, objects grown or shrunk; `feather` is of no meaning
 *   here
 * @property {import('../options.js').WasmSource} [decoder] as for a session
 * @property {AbortSignal} [signal] ends the work: the promise rejects with its reason
 */

/**
 * Masks at the size of their frames, for exports at the size of the source: frames are read one by one, borders come to
 * where they have them (`enlargeMask`), masks are kept as runs of equal labels. All frames have one size.
 * @param {import('./mask-source.js').MaskSource} masks
 * @param {import('./video.js').EncodeFrames} frames one for each frame of the masks, in order
 * @param {MasksAtSizeOptions} [options]
 * @returns {Promise<import('./mask-source.js').MaskSource>} with the times and shots of `masks`
 */
export async function masksAtSize(masks, frames, options) {
  checkMasks(masks);
  const legal = ['onProgress', 'signal', 'edges', 'decoder'];
  const { onProgress, signal, edges, decoder } = checkedOptions(options ?? {}, legal);
  const how = checkedEdges(edges);
  const { numFrames, shots, end } = masks;
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
    const { labels } = await maskAtSize({ labels: labelsOf(masks, t), width, height }, picture, all, how, decoder);
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
    end: end ?? null,
    ...(Array.isArray(shots) ? { shots } : {}),
    labels: (t) => decodeRuns(/** @type {Uint32Array} */ (runs[t]), size.width * size.height, same),
  };
}

/** How many of its pixels a mask's shape may differ from the picture's, as `enlargeMask` has it: sizes are rounded. */
const SHAPE_TOLERANCE = 2;

/**
 * A mask at the size of a picture, its edges as they are wanted: specks are left out first, so that they grow nowhere;
 * borders come to where the picture has them; lengths are scaled with the mask.
 * @param {Mask} mask
 * @param {import('../frames.js').FrameSource & {width: number, height: number}} picture
 * @param {Uint8Array} chosen 1 for each label that is meant
 * @param {Required<import('./adjust.js').MaskEdges>} edges
 * @param {import('../options.js').WasmSource} [decoder] of what enlarges
 * @returns {Promise<MaskAtSize>}
 */
export async function maskAtSize(mask, picture, chosen, { smallest, grow, feather }, decoder) {
  const { width, height } = picture;
  const clean = withoutSpecks(mask, chosen, smallest);
  const [across, down] = [width / mask.width, height / mask.height];
  const scale = Math.sqrt(across * down);
  // Where the picture shows something else than the mask, its borders are of no use.
  const isOther =
    Math.min(Math.abs(mask.height - height / across), Math.abs(mask.width - width / down)) > SHAPE_TOLERANCE;
  const hasPicture = across > 1 && down > 1 && !isOther;
  const objects = (/** @type {number} */ label) => chosen[label] === 1;
  const found = hasPicture ? await enlargeMask(clean, picture, { objects, decoder }) : null;
  const isLike = across === 1 && down === 1;
  const labels = found?.labels ?? (isLike ? clean.labels : nearest(clean, width, height));
  // As soft as the picture, unless something else is wanted.
  if (found && grow === 0 && feather === 0) return { width, height, labels, alpha: found.alpha };
  const large = grown({ labels, width, height }, chosen, scale * grow);
  return { ...large, alpha: softAlpha(large, chosen, scale * feather) };
}

/**
 * Each pixel has the label of the mask's pixel in which its centre lies.
 * @param {Mask} mask
 * @param {number} width
 * @param {number} height
 */
function nearest(mask, width, height) {
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
