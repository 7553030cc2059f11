// Converts all kinds of frames to bytes.

import { TraceCutError, checkSides, illegal, tooLarge, typeTag } from '../check/errors.js';
import { MAX_PIXELS } from '../check/options.js';
import { reducePixels } from './pixels.js';

/** RGBA bytes, four a pixel, row by row; `ImageData` is one. */
export interface PixelFrame {
  /** Bytes, 4 × `width` × `height`. */
  data: Uint8ClampedArray | Uint8Array;
  /** Pixels in a row, 1 to 16384. */
  width: number;
  /** Number of rows, 1 to 16384. */
  height: number;
}

/**
 * A frame for `push`: pixels, anything a canvas can draw, or the bytes of a PNG or JPEG file. Files are decoded in wasm, so
 * the same file gives the same pixels everywhere; canvases and video frames are decoded by the browser.
 */
export type FrameSource =
  | PixelFrame
  | ImageData
  | HTMLCanvasElement
  | OffscreenCanvas
  | VideoFrame
  | ImageBitmap
  | HTMLVideoElement
  | Uint8Array
  | ArrayBuffer
  | Blob;

/**
 * A frame for the engine, in memory that nothing else uses. Files come with the module that decodes them. `index` and
 * `name` identify the frame in errors.
 */
export type RawFrame =
  | { kind: 'pixels'; data: Uint8Array<ArrayBuffer>; width: number; height: number }
  | {
      kind: 'file';
      data: Uint8Array<ArrayBuffer>;
      decoder?: WebAssembly.Module;
      maxPixels: number;
      index?: number;
      name?: string;
    };

const LEGAL_FRAMES =
  'ImageData, {data, width, height}, a canvas, VideoFrame, ImageBitmap, or the bytes of a PNG or JPEG file';

/**
 * Copies a frame. Pixels and bytes are copied before this returns, so the caller may reuse them at once.
 * @param loadDecoder called for files only
 * @param maxPixels checked before memory is allocated
 */
export async function toRawFrame(
  frame: FrameSource,
  loadDecoder: () => Promise<WebAssembly.Module>,
  maxPixels: number = MAX_PIXELS,
): Promise<RawFrame> {
  const raw = await copyFrame(frame, maxPixels);
  return raw.kind === 'file' ? { ...raw, decoder: await loadDecoder() } : raw;
}

async function copyFrame(frame: FrameSource, maxPixels: number): Promise<RawFrame> {
  switch (typeTag(frame)) {
    case 'Uint8Array':
    case 'ArrayBuffer':
      return { kind: 'file', data: new Uint8Array(frame as ArrayBuffer).slice(), maxPixels };
    case 'Blob':
    case 'File':
      return fromFile(frame as File, maxPixels);
    case 'VideoFrame':
      return fromImage(frame as VideoFrame, maxPixels);
    case 'HTMLVideoElement': {
      const video = frame as HTMLVideoElement;
      return draw(video, video.videoWidth, video.videoHeight, maxPixels);
    }
    case 'ImageBitmap':
    case 'HTMLCanvasElement':
    case 'OffscreenCanvas':
      return fromImage(frame as ImageBitmap, maxPixels);
    default:
      return fromPixels(frame, maxPixels);
  }
}

async function fromFile(file: Blob & { name?: string }, maxPixels: number): Promise<RawFrame> {
  return { kind: 'file', data: new Uint8Array(await file.arrayBuffer()), maxPixels, name: file.name };
}

/** Checks a size before memory is allocated for it. */
function checkSize(frame: { width?: unknown; height?: unknown }, maxPixels: number) {
  checkSides('frame-size', 'frame.', frame);
  const { width, height } = frame as PixelFrame;
  const pixels = width * height;
  if (pixels > maxPixels) throw tooLarge(pixels, 'pixels in a frame', maxPixels, 'clip.maxPixels');
}

function fromPixels(frame: unknown, maxPixels: number): RawFrame {
  if (typeof frame !== 'object' || frame === null || !('data' in frame && 'width' in frame && 'height' in frame)) {
    throw illegal('data', 'frame', frame, LEGAL_FRAMES);
  }
  checkSize(frame, maxPixels);
  const { width, height } = frame as PixelFrame;
  const tag = typeTag(frame.data);
  if (tag !== 'Uint8ClampedArray' && tag !== 'Uint8Array') {
    throw illegal('frame-bytes', 'frame.data', frame.data, 'a Uint8ClampedArray or Uint8Array, four bytes a pixel');
  }
  const data = frame.data as Uint8Array;
  const expected = 4 * width * height;
  if (data.length !== expected) {
    throw new TraceCutError('frame-bytes', `frame data has ${data.length} bytes (expected ${expected})`);
  }
  return { kind: 'pixels', data: new Uint8Array(data), width, height };
}

/** Reads the pixels of an image that the browser holds. */
export async function fromImage(image: VideoFrame | ImageBitmap, maxPixels: number = MAX_PIXELS): Promise<RawFrame> {
  if ('visibleRect' in image) return fromVideoFrame(image, maxPixels);
  return draw(image, image.width, image.height, maxPixels);
}

/** Memory of the last frame that was reduced: new memory costs a video frame three times the time of its copy. */
let spareMemory = new Uint8Array();

/** Reads a video frame and reduces it. @param width at most the frame's */
export async function reduceVideoFrame(frame: VideoFrame, width: number, height: number) {
  const memory = spareMemory;
  // Another frame may be read meanwhile.
  spareMemory = new Uint8Array();
  const { displayWidth, displayHeight } = frame;
  const isReduced = width < displayWidth || height < displayHeight;
  const raw = await fromVideoFrame(frame, MAX_PIXELS, isReduced ? memory : undefined);
  if (!isReduced || raw.kind !== 'pixels') return raw.data;
  spareMemory = raw.data;
  return reducePixels(raw, width, height);
}

/**
 * Reads a video frame. `copyTo` returns the decoder's own colours without a canvas, to which privacy settings may add
 * noise; if it cannot return RGBA (Safari), or the frame is displayed rotated or stretched, a canvas is used.
 * @param memory for the pixels, if it has their size
 */
async function fromVideoFrame(
  frame: VideoFrame,
  maxPixels: number,
  memory?: Uint8Array<ArrayBuffer>,
): Promise<RawFrame> {
  // Photos, and cameras of phones, give frames to be rotated: not every type library has these fields.
  const {
    visibleRect: rect,
    displayWidth,
    displayHeight,
    rotation,
    flip,
  } = frame as VideoFrame & { rotation?: number; flip?: boolean };
  if (rect) checkSize(rect, maxPixels);
  if (!rotation && !flip && rect && rect.width === displayWidth && rect.height === displayHeight) {
    try {
      const numBytes = 4 * rect.width * rect.height;
      const data = memory?.length === numBytes ? memory : new Uint8Array(numBytes);
      await frame.copyTo(data, { format: 'RGBA', layout: [{ offset: 0, stride: 4 * rect.width }] });
      return { kind: 'pixels', data, width: rect.width, height: rect.height };
    } catch (error) {
      if (frame.format === null && frame.codedWidth === 0) throw error; // Closed: a canvas cannot draw it either.
    }
  }
  return draw(frame, displayWidth, displayHeight, maxPixels);
}

function draw(image: CanvasImageSource, width: number, height: number, maxPixels: number): RawFrame {
  checkSize({ width, height }, maxPixels);
  if (typeof OffscreenCanvas === 'undefined') {
    throw new TraceCutError('unsupported', 'this engine has no OffscreenCanvas; push {data, width, height}');
  }
  const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
  if (!context) throw new TraceCutError('unsupported', 'the browser cannot create a 2D canvas');
  context.drawImage(image, 0, 0, width, height);
  const pixels = context.getImageData(0, 0, width, height).data;
  return { kind: 'pixels', data: new Uint8Array(pixels.buffer), width, height };
}
