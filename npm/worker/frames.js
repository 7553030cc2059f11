// What can be pushed as a frame, to bytes.

import { TraceCutError, checkSides, illegal, tooLarge, typeTag } from '../check/errors.js';
import { MAX_PIXELS } from '../check/options.js';

/**
 * RGBA bytes, four a pixel, row by row; `ImageData` is one.
 * @typedef {object} PixelFrame
 * @property {Uint8ClampedArray | Uint8Array} data 4 × `width` × `height` bytes
 * @property {number} width in pixels, 1 to 16384
 * @property {number} height in pixels, 1 to 16384
 */

/**
 * What `push` takes: pixels, anything a canvas can draw, or the bytes of a PNG or JPEG file. Files are decoded in wasm,
 * so the same file gives the same pixels everywhere; canvases and video frames are decoded by the browser.
 * @typedef {PixelFrame | ImageData | HTMLCanvasElement | OffscreenCanvas | VideoFrame | ImageBitmap | HTMLVideoElement
 *   | Uint8Array | ArrayBuffer | Blob} FrameSource
 */

/**
 * A frame on its way to the engine, in memory that nobody else holds. Files go with the module that decodes them.
 * @typedef {{kind: 'pixels', data: Uint8Array<ArrayBuffer>, width: number, height: number}
 *   | {kind: 'file', data: Uint8Array<ArrayBuffer>, decoder?: WebAssembly.Module, maxPixels: number, index?: number,
 *   name?: string}} RawFrame `index` and `name` say which frame of the clip, for errors
 */

const LEGAL = 'ImageData, {data, width, height}, a canvas, VideoFrame, ImageBitmap, or the bytes of a PNG or JPEG file';

/**
 * Copies a frame out of whatever holds it. Pixels and bytes are copied before this returns, so the caller may reuse
 * them at once.
 * @param {FrameSource} frame
 * @param {() => Promise<WebAssembly.Module>} loadDecoder asked for files only
 * @param {number} [maxPixels] looked at before memory is taken
 * @returns {Promise<RawFrame>}
 */
export async function toRawFrame(frame, loadDecoder, maxPixels = MAX_PIXELS) {
  const raw = await copied(frame, maxPixels);
  return raw.kind === 'file' ? { ...raw, decoder: await loadDecoder() } : raw;
}

/**
 * @param {FrameSource} frame
 * @param {number} maxPixels
 * @returns {Promise<RawFrame>}
 */
async function copied(frame, maxPixels) {
  switch (typeTag(frame)) {
    case 'Uint8Array':
    case 'ArrayBuffer':
      return { kind: 'file', data: new Uint8Array(/** @type {ArrayBuffer} */ (frame)).slice(), maxPixels };
    case 'Blob':
    case 'File':
      return fromFile(/** @type {File} */ (frame), maxPixels);
    case 'VideoFrame':
      return fromImage(/** @type {VideoFrame} */ (frame), maxPixels);
    case 'HTMLVideoElement': {
      const video = /** @type {HTMLVideoElement} */ (frame);
      return draw(video, video.videoWidth, video.videoHeight, maxPixels);
    }
    case 'ImageBitmap':
    case 'HTMLCanvasElement':
    case 'OffscreenCanvas':
      return fromImage(/** @type {ImageBitmap} */ (frame), maxPixels);
    default:
      return fromPixels(frame, maxPixels);
  }
}

/**
 * @param {Blob & {name?: string}} file
 * @param {number} maxPixels
 * @returns {Promise<RawFrame>}
 */
async function fromFile(file, maxPixels) {
  return { kind: 'file', data: new Uint8Array(await file.arrayBuffer()), maxPixels, name: file.name };
}

/**
 * Looks at a size before memory is taken for it.
 * @param {{width?: unknown, height?: unknown}} frame
 * @param {number} maxPixels
 */
function checkSize(frame, maxPixels) {
  checkSides('frame-size', 'frame.', frame);
  const { width, height } = /** @type {PixelFrame} */ (frame);
  const pixels = width * height;
  if (pixels > maxPixels) throw tooLarge(pixels, 'pixels in a frame', maxPixels, 'clip.maxPixels');
}

/**
 * @param {unknown} frame
 * @param {number} maxPixels
 * @returns {RawFrame}
 */
function fromPixels(frame, maxPixels) {
  if (typeof frame !== 'object' || frame === null || !('data' in frame && 'width' in frame && 'height' in frame)) {
    throw illegal('data', 'frame', frame, LEGAL);
  }
  checkSize(frame, maxPixels);
  const { width, height } = /** @type {PixelFrame} */ (frame);
  const tag = typeTag(frame.data);
  if (tag !== 'Uint8ClampedArray' && tag !== 'Uint8Array') {
    throw illegal('frame-bytes', 'frame.data', frame.data, 'a Uint8ClampedArray or Uint8Array, four bytes a pixel');
  }
  const data = /** @type {Uint8Array} */ (frame.data);
  const expected = 4 * width * height;
  if (data.length !== expected) {
    throw new TraceCutError('frame-bytes', `frame data has ${data.length} bytes (expected ${expected})`);
  }
  return { kind: 'pixels', data: new Uint8Array(data), width, height };
}

/**
 * The pixels of an image that the browser holds.
 * @param {VideoFrame | ImageBitmap} image
 * @param {number} [maxPixels]
 * @returns {Promise<RawFrame>}
 */
export async function fromImage(image, maxPixels = MAX_PIXELS) {
  if ('visibleRect' in image) return fromVideoFrame(image, maxPixels);
  return draw(image, image.width, image.height, maxPixels);
}

/**
 * `copyTo` gives the decoder's own colours without a canvas that privacy settings may add noise to; where it cannot
 * give RGBA (Safari), or where the frame is to be shown turned or stretched, a canvas has to do.
 * @param {VideoFrame} frame
 * @param {number} maxPixels
 * @returns {Promise<RawFrame>}
 */
async function fromVideoFrame(frame, maxPixels) {
  // Photos, and cameras of phones, give frames that are to be turned: not every library of types knows.
  const {
    visibleRect: rect,
    displayWidth,
    displayHeight,
    rotation,
    flip,
  } = /** @type {VideoFrame & {rotation?: number, flip?: boolean}} */ (frame);
  if (rect) checkSize(rect, maxPixels);
  if (!rotation && !flip && rect && rect.width === displayWidth && rect.height === displayHeight) {
    try {
      const data = new Uint8Array(4 * rect.width * rect.height);
      await frame.copyTo(data, { format: 'RGBA', layout: [{ offset: 0, stride: 4 * rect.width }] });
      return { kind: 'pixels', data, width: rect.width, height: rect.height };
    } catch (error) {
      if (frame.format === null && frame.codedWidth === 0) throw error; // Closed: a canvas cannot draw it either.
    }
  }
  return draw(frame, displayWidth, displayHeight, maxPixels);
}

/**
 * @param {CanvasImageSource} image
 * @param {number} width
 * @param {number} height
 * @param {number} maxPixels
 * @returns {RawFrame}
 */
function draw(image, width, height, maxPixels) {
  checkSize({ width, height }, maxPixels);
  if (typeof OffscreenCanvas === 'undefined') {
    throw new TraceCutError('unsupported', 'this engine has no OffscreenCanvas; push {data, width, height}');
  }
  const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
  if (!context) throw new TraceCutError('unsupported', 'the browser gave no 2d canvas to read the frame with');
  context.drawImage(image, 0, 0, width, height);
  const pixels = context.getImageData(0, 0, width, height).data;
  return { kind: 'pixels', data: new Uint8Array(/** @type {ArrayBuffer} */ (pixels.buffer)), width, height };
}
