// Masks at the size of the pictures that they are laid over, and the pixels of these.

import { TraceCutError, checkedOptions, illegal, typeTag } from '../../check/errors.js';
import { checkMasks, chosenLabels, labelsOf, timesOf } from '../../check/masks.js';
import { decodeRuns, encodeRuns } from '../../session/runs.js';
import { toPixels } from '../../worker/decode.js';
import { fromImage } from '../../worker/frames.js';
import { breath } from '../../worker/pause.js';
import { checkedEdges, grown, softAlpha, withoutSpecks } from './adjust.js';
import { ahead } from './ahead.js';
import { enlargeMask } from './enlarge.js';

/** @typedef {import('../../check/masks.js').MaskSource} MaskSource */
/** @typedef {import('./adjust.js').Mask} Mask */

/**
 * `labels` holds a label for each pixel, `alpha` how opaque the chosen objects are there, 0 to 255. @typedef {{width:
 * number, height: number, labels: Uint8Array, alpha: Uint8Array<ArrayBuffer>}} MaskAtSize
 */

/**
 * @typedef {object} MasksAtSizeOptions
 * @property {(progress: import('../export/masks.js').ExportProgress) => void} [onProgress] told of each frame
 * @property {import('./adjust.js').MaskEdges} [edges] specks left out, objects grown or shrunk; `feather` is of no meaning
 *   here
 * @property {import('../../check/options.js').WasmSource} [decoder] as for a session
 * @property {AbortSignal} [signal] ends the work: the promise rejects with its reason
 */

/**
 * Masks at the size of their frames, for exports at the size of the source: frames are read one by one, borders come to
 * where they have them (`enlargeMask`), masks are kept as runs of equal labels. All frames have one size.
 * @param {import('../../check/masks.js').MaskSource} masks
 * @param {import('../export/video.js').EncodeFrames} frames one for each frame of the masks, in order
 * @param {MasksAtSizeOptions} [options]
 * @returns {Promise<import('../../check/masks.js').MaskSource>} with the times and shots of `masks`
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
  /** @type {import('../../session/runs.js').Runs[]} */
  const runs = [];
  const take = async (/** @type {EncodeFrame} */ item, /** @type {number} */ t) => {
    signal?.throwIfAborted();
    const picture = await pixelsOf(item, t);
    if (t === 0) Object.assign(size, { width: picture.width, height: picture.height });
    checkSize(picture, size, t);
    const { width, height } = masks;
    const mask = maskAtSize({ labels: labelsOf(masks, t), width, height }, picture, all, how, decoder);
    return { picture: null, mask };
  };
  for await (const { mask } of ahead(frames, numFrames, take)) {
    signal?.throwIfAborted();
    runs.push(encodeRuns(mask.labels));
    onProgress?.({ done: runs.length, total: numFrames });
    await breath();
  }
  if (runs.length < numFrames) throw tooFew(runs.length, numFrames);
  return {
    ...size,
    numFrames,
    times,
    end: end ?? null,
    ...(Array.isArray(shots) ? { shots } : {}),
    labels: (t) => decodeRuns(/** @type {import('../../session/runs.js').Runs} */ (runs[t])),
  };
}

/** How many of its pixels a mask's shape may differ from the picture's, as `enlargeMask` has it: sizes are rounded. */
const SHAPE_TOLERANCE = 2;

/**
 * A mask at the size of a picture, its edges as they are wanted: specks are left out first, so that they grow nowhere;
 * borders come to where the picture has them; lengths are scaled with the mask.
 * @param {Mask} mask
 * @param {VideoFrame | (import('../../worker/frames.js').FrameSource & {width: number, height: number})} picture
 * @param {Uint8Array} chosen 1 for each label that is meant
 * @param {Required<import('./adjust.js').MaskEdges>} edges
 * @param {import('../../check/options.js').WasmSource} [decoder] of what enlarges
 * @returns {Promise<MaskAtSize>}
 */
export async function maskAtSize(mask, picture, chosen, { smallest, grow, feather }, decoder) {
  const { width, height } = 'displayWidth' in picture ? sizeOf(picture) : picture;
  const clean = withoutSpecks(mask, chosen, smallest);
  const [only = 0] = clean.labels;
  if (clean.labels.every((label) => label === only)) {
    const filled = (/** @type {number} */ value) => new Uint8Array(width * height).fill(value);
    return { width, height, labels: filled(only), alpha: filled(chosen[only] ? 255 : 0) };
  }
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

/** @param {VideoFrame} frame */
const sizeOf = ({ displayWidth, displayHeight }) => ({ width: displayWidth, height: displayHeight });

/** @typedef {import('../export/video.js').EncodeFrame} EncodeFrame */
/**
 * What a canvas can draw; `close` where it was made of a frame and is to be let go. @typedef {{image:
 * CanvasImageSource, width: number, height: number, close?: () => void}} Drawable
 */

/** @param {OffscreenCanvas} canvas */
export function context2d(canvas) {
  const context = canvas.getContext('2d', { willReadFrequently: true });
  if (!context) throw new TraceCutError('unsupported', 'the browser gave no 2d canvas to paint frames on');
  return context;
}

/**
 * @param {EncodeFrame | {frame: EncodeFrame}} item
 * @param {number} t
 * @returns {Promise<Drawable>}
 */
export async function drawable(item, t) {
  const frame = /** @type {unknown} */ (unwrapped(item));
  switch (typeTag(frame)) {
    case 'VideoFrame': {
      const image = /** @type {VideoFrame} */ (frame);
      return { image, ...sizeOf(image) };
    }
    case 'HTMLVideoElement': {
      const image = /** @type {HTMLVideoElement} */ (frame);
      return { image, width: image.videoWidth, height: image.videoHeight };
    }
    case 'HTMLImageElement': {
      const image = /** @type {HTMLImageElement} */ (frame);
      return { image, width: image.naturalWidth, height: image.naturalHeight };
    }
    case 'ImageBitmap':
    case 'HTMLCanvasElement':
    case 'OffscreenCanvas': {
      const image = /** @type {ImageBitmap} */ (frame);
      return { image, width: image.width, height: image.height };
    }
    case 'Blob':
    case 'File': {
      const image = await createImageBitmap(/** @type {Blob} */ (frame));
      return { image, width: image.width, height: image.height, close: () => image.close() };
    }
    default:
      return fromPixels(frame, t);
  }
}

/**
 * @param {unknown} frame
 * @param {number} t
 * @returns {Promise<Drawable>}
 */
async function fromPixels(frame, t) {
  const { data, width, height } = /** @type {Partial<import('../../worker/frames.js').PixelFrame>} */ (frame ?? {});
  if (!ArrayBuffer.isView(data) || !(Number(width) > 0) || data.length !== 4 * Number(width) * Number(height)) {
    throw illegal(
      'data',
      `frame ${t}`,
      frame,
      'something a canvas can draw, ImageData, {data, width, height} in RGBA, or a Blob of an image',
    );
  }
  const pixels =
    typeTag(frame) === 'ImageData' ? frame : new ImageData(new Uint8ClampedArray(data), Number(width), Number(height));
  const image = await createImageBitmap(/** @type {ImageData} */ (pixels));
  return { image, width: image.width, height: image.height, close: () => image.close() };
}

/**
 * @param {EncodeFrame | {frame: EncodeFrame}} item
 * @param {number} t
 * @returns {Promise<import('../../worker/frames.js').PixelFrame>} RGBA; what already is that is not copied
 */
export async function pixelsOf(item, t) {
  const frame = /** @type {unknown} */ (unwrapped(item));
  const { data, width, height } = /** @type {Partial<import('../../worker/frames.js').PixelFrame>} */ (frame ?? {});
  if (ArrayBuffer.isView(data) && Number(width) > 0 && data.length === 4 * Number(width) * Number(height))
    return /** @type {import('../../worker/frames.js').PixelFrame} */ (frame);
  // As the decoder has it: a canvas may change it.
  if (typeTag(frame) === 'VideoFrame') return toPixels(await fromImage(/** @type {VideoFrame} */ (frame)));
  if (typeof OffscreenCanvas === 'undefined')
    throw illegal(
      'data',
      `frame ${t}`,
      frame,
      '{data, width, height} in RGBA: this engine has no canvas to draw it on',
    );
  const found = await drawable(item, t);
  try {
    const context = context2d(new OffscreenCanvas(found.width, found.height));
    context.drawImage(found.image, 0, 0, found.width, found.height);
    return context.getImageData(0, 0, found.width, found.height);
  } finally {
    found.close?.();
  }
}

/** @param {EncodeFrame | {frame: EncodeFrame}} item */
function unwrapped(item) {
  return typeTag(item) === 'Object' && 'frame' in item ? item.frame : item;
}
