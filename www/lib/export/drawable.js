// Frames of all kinds as something that a canvas can draw, and as pixels.

import { TraceCutError, illegal, typeTag } from '../errors.js';

/** @typedef {import('./video.js').EncodeFrame} EncodeFrame */
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
      return { image, width: image.displayWidth, height: image.displayHeight };
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
 * @returns {Drawable}
 */
function fromPixels(frame, t) {
  const { data, width, height } = /** @type {Partial<import('../frames.js').PixelFrame>} */ (frame ?? {});
  if (!ArrayBuffer.isView(data) || !(Number(width) > 0) || data.length !== 4 * Number(width) * Number(height)) {
    throw illegal(
      'data',
      `frame ${t}`,
      frame,
      'something a canvas can draw, ImageData, {data, width, height} in RGBA, or a Blob of an image',
    );
  }
  const canvas = new OffscreenCanvas(Number(width), Number(height));
  context2d(canvas).putImageData(new ImageData(new Uint8ClampedArray(data), Number(width), Number(height)), 0, 0);
  return { image: canvas, width: canvas.width, height: canvas.height };
}

/**
 * @param {EncodeFrame | {frame: EncodeFrame}} item
 * @param {number} t
 * @returns {Promise<import('../frames.js').PixelFrame>} RGBA; what already is that is not copied
 */
export async function pixelsOf(item, t) {
  const frame = /** @type {unknown} */ (unwrapped(item));
  const { data, width, height } = /** @type {Partial<import('../frames.js').PixelFrame>} */ (frame ?? {});
  if (ArrayBuffer.isView(data) && Number(width) > 0 && data.length === 4 * Number(width) * Number(height))
    return /** @type {import('../frames.js').PixelFrame} */ (frame);
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
