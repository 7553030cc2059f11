// From whatever holds a frame to its pixels, and to fewer of them.

import { inFrame } from '../check/errors.js';
import { platform } from '../platform.js';
import { aside } from '../worker/aside.js';
import { toPixels } from '../worker/decode.js';
import { fromImage, toRawFrame } from '../worker/frames.js';
import { reduced } from '../worker/pixels.js';

/** @typedef {import('../worker/frames.js').RawFrame} RawFrame */
/** @typedef {import('../worker/frames.js').PixelFrame} PixelFrame */

/**
 * The size of a frame with its long side at most `size`: never enlarged, its aspect kept to the nearest pixel.
 * @param {number} width
 * @param {number} height
 * @param {number | undefined} size
 */
export function fitted(width, height, size = Infinity) {
  const scale = Math.min(1, size / Math.max(width, height));
  return { width: Math.max(1, Math.round(width * scale)), height: Math.max(1, Math.round(height * scale)) };
}

/**
 * A frame stretched to another size, smoothly.
 * @param {RawFrame} raw
 * @param {number} width
 * @param {number} height
 * @returns {Promise<RawFrame>}
 */
export async function stretched(raw, width, height) {
  const image = /** @type {ImageData} */ (await toPixelFrame(raw));
  const size = /** @type {const} */ ({ resizeWidth: width, resizeHeight: height, resizeQuality: 'high' });
  const bitmap = await createImageBitmap(image, size);
  try {
    return await fromImage(bitmap);
  } finally {
    bitmap.close();
  }
}

/** Frames of more pixels are reduced in a worker: it takes long enough to be felt where pages are drawn. */
const LARGE = 2 ** 20;

/**
 * The frame at no more than `size`; files are decoded only when they have to be reduced.
 * @param {RawFrame} raw whose memory nobody else holds
 * @param {number | undefined} size
 * @returns {Promise<RawFrame>}
 */
export async function atSize(raw, size) {
  if (size === undefined) return raw;
  const pixels = await pixelsFrom(raw);
  const { width, height } = fitted(pixels.width, pixels.height, size);
  if (width === pixels.width && height === pixels.height) return { kind: 'pixels', ...pixels };
  if (pixels.width * pixels.height <= LARGE || !platform.startAside)
    return { kind: 'pixels', data: reduced(pixels, width, height), width, height };
  const task = /** @type {const} */ ({ kind: 'reduce', picture: pixels, width, height });
  const data = await aside(task, [pixels.data.buffer]);
  return { kind: 'pixels', data, width, height };
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
 * Copies a decoded frame and closes it. A large one is copied, and reduced where `size` says so, in a worker.
 * @param {VideoFrame} frame
 * @param {number} [size]
 * @returns {Promise<RawFrame>}
 */
export async function readAndClose(frame, size) {
  try {
    const { displayWidth, displayHeight } = frame;
    if (displayWidth * displayHeight > LARGE && platform.startAside) {
      const { width, height } = fitted(displayWidth, displayHeight, size);
      const data = await aside({ kind: 'frame', frame, width, height }, [frame]);
      return { kind: 'pixels', data, width, height };
    }
    return await toRawFrame(frame, noDecoder);
  } finally {
    frame.close();
  }
}

/** A video frame is no file: nothing has to be loaded for it. */
const noDecoder = () => Promise.reject(new Error('a video frame needs no decoder'));

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
