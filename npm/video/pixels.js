// From whatever holds a frame to its pixels, and to fewer of them.

import { inFrame } from '../check/errors.js';
import { platform } from '../platform.js';
import { aside } from '../worker/aside.js';
import { toPixels } from '../worker/decode.js';
import { fromImage } from '../worker/frames.js';
import { reduced } from '../worker/pixels.js';

/** @typedef {import('../worker/frames.js').RawFrame} RawFrame */
/** @typedef {import('../worker/frames.js').PixelFrame} PixelFrame */
/** A frame as readers give it: copied, or as the browser holds it. @typedef {RawFrame | {kind: 'image', image: VideoFrame}} ReadFrame */

/**
 * The size of a frame with its long side at most `side`: never enlarged, its aspect kept to the nearest pixel.
 * @param {{readonly width: number, readonly height: number}} size
 * @param {number} [side]
 */
export function fitSize({ width, height }, side = Infinity) {
  const scale = Math.min(1, side / Math.max(width, height));
  return { width: Math.max(1, Math.round(width * scale)), height: Math.max(1, Math.round(height * scale)) };
}

/**
 * A frame stretched to another size, smoothly.
 * @param {ReadFrame} raw
 * @param {number} width
 * @param {number} height
 * @returns {Promise<RawFrame>}
 */
export async function stretched(raw, width, height) {
  const image = /** @type {ImageData} */ (await toPixelFrame(await atSize(raw, undefined)));
  const size = /** @type {const} */ ({ resizeWidth: width, resizeHeight: height, resizeQuality: 'high' });
  const bitmap = await createImageBitmap(image, size);
  try {
    return await fromImage(bitmap);
  } finally {
    bitmap.close();
  }
}

/** Frames of more pixels are copied and reduced in a worker: it takes long enough to be felt where pages are drawn. */
const LARGE = 2 ** 20;

/**
 * The frame at no more than `size`, in memory: pixels, or a file that need not be reduced. An image is closed.
 * @param {ReadFrame} raw whose memory nobody else holds
 * @param {number | undefined} size
 * @returns {Promise<RawFrame>}
 */
export async function atSize(raw, size) {
  if (raw.kind === 'image') return readAndClose(raw.image, size);
  if (size === undefined) return raw;
  const pixels = await pixelsFrom(raw);
  const { width, height } = fitSize(pixels, size);
  if (width === pixels.width && height === pixels.height) return { kind: 'pixels', ...pixels };
  if (pixels.width * pixels.height <= LARGE || !platform.startAside)
    return { kind: 'pixels', data: reduced(pixels, width, height), width, height };
  const task = /** @type {const} */ ({ kind: 'reduce', picture: pixels, width, height });
  const data = await aside(task, [pixels.data.buffer]);
  return { kind: 'pixels', data, width, height };
}

/**
 * @param {VideoFrame} image
 * @param {number | undefined} size
 * @returns {Promise<RawFrame>}
 */
async function readAndClose(image, size) {
  try {
    const shown = { width: image.displayWidth, height: image.displayHeight };
    if (shown.width * shown.height <= LARGE || !platform.startAside) return atSize(await fromImage(image), size);
    const { width, height } = fitSize(shown, size);
    const data = await aside({ kind: 'frame', frame: image, width, height }, [image]);
    return { kind: 'pixels', data, width, height };
  } finally {
    image.close();
  }
}

/**
 * The frame as pixels that a canvas takes as they are: `ImageData` where there is one.
 * @param {RawFrame} raw
 * @returns {Promise<PixelFrame>}
 */
export async function toPixelFrame(raw) {
  const { data, width, height } = await pixelsFrom(raw);
  const clamped = new Uint8ClampedArray(data.buffer, data.byteOffset, data.length);
  return typeof ImageData === 'undefined' ? { data: clamped, width, height } : new ImageData(clamped, width, height);
}

/**
 * A frame to look at. `frame` is what a canvas draws: a `VideoFrame`, in a browser without these an `ImageBitmap`; in Node,
 * which draws nothing, its pixels. It is there until the next one is asked for. `width` and `height` are its size as it is
 * shown; `pixels` gives a copy, `ImageData` in browsers.
 * @typedef {{readonly frame: VideoFrame | ImageBitmap | PixelFrame, readonly width: number, readonly height: number,
 *   readonly pixels: () => Promise<PixelFrame>}} ShownFrame
 */

/**
 * The frame at no more than `size` to look at; `close` lets go of it.
 * @param {ReadFrame} raw whose memory nobody changes meanwhile
 * @param {number | undefined} size
 * @param {number} time in seconds
 * @returns {Promise<ShownFrame & {close: () => void}>}
 */
export async function shownFrame(raw, size, time) {
  if (raw.kind === 'image') {
    const { image } = raw;
    const { displayWidth: width, displayHeight: height } = image;
    if (size === undefined || Math.max(width, height) <= size) {
      const pixels = async () => toPixelFrame(await fromImage(image));
      return { frame: image, width, height, pixels, close: () => image.close() };
    }
  }
  const still = await toPixelFrame(await atSize(raw, size));
  const { data, width, height } = still;
  const frame = await drawn(still, time);
  const pixels = () => toPixelFrame({ kind: 'pixels', data: new Uint8Array(data), width, height });
  return { frame, width, height, pixels, close: () => void ('close' in frame && frame.close()) };
}

/**
 * @param {PixelFrame} pixels
 * @param {number} time in seconds
 */
async function drawn(pixels, time) {
  const { data, width: codedWidth, height: codedHeight } = pixels;
  if (typeof VideoFrame !== 'undefined')
    return new VideoFrame(data, { format: 'RGBA', codedWidth, codedHeight, timestamp: Math.round(1e6 * time) });
  return typeof createImageBitmap === 'undefined' ? pixels : createImageBitmap(/** @type {ImageData} */ (pixels));
}

/**
 * The pixels of a frame; an error says which one it is.
 * @param {RawFrame} raw
 */
export async function pixelsFrom(raw) {
  try {
    return await toPixels(raw);
  } catch (error) {
    throw inFrame(error, raw);
  }
}
