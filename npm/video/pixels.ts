// From whatever holds a frame to its pixels, and to fewer of them.

import { inFrame } from '../check/errors.js';
import { platform } from '../platform.js';
import { aside } from '../worker/aside.js';
import { toPixels } from '../worker/decode.js';
import { type PixelFrame, type RawFrame, fromImage } from '../worker/frames.js';
import { reduced } from '../worker/pixels.js';

/** A frame as readers give it: copied, or as the browser holds it. */
export type ReadFrame = RawFrame | { kind: 'image'; image: VideoFrame };

/** The size of a frame with its long side at most `side`: never enlarged, its aspect kept to the nearest pixel. */
export function fitSize(
  { width, height }: { readonly width: number; readonly height: number },
  side: number = Infinity,
) {
  const scale = Math.min(1, side / Math.max(width, height));
  return { width: Math.max(1, Math.round(width * scale)), height: Math.max(1, Math.round(height * scale)) };
}

/** A frame stretched to another size, smoothly. */
export async function stretched(raw: ReadFrame, width: number, height: number): Promise<RawFrame> {
  const image = (await toPixelFrame(await atSize(raw, undefined))) as ImageData;
  const size = { resizeWidth: width, resizeHeight: height, resizeQuality: 'high' } as const;
  const bitmap = await createImageBitmap(image, size);
  try {
    return await fromImage(bitmap);
  } finally {
    bitmap.close();
  }
}

/** Frames of more pixels are copied and reduced in a worker: it takes long enough to be felt where pages are drawn. */
const LARGE = 2 ** 20;

/** The frame at no more than `size`, in memory: pixels, or a file that need not be reduced. An image is closed. */
export async function atSize(raw: ReadFrame, size: number | undefined): Promise<RawFrame> {
  if (raw.kind === 'image') return readAndClose(raw.image, size);
  if (size === undefined) return raw;
  const pixels = await pixelsFrom(raw);
  const { width, height } = fitSize(pixels, size);
  if (width === pixels.width && height === pixels.height) return { kind: 'pixels', ...pixels };
  if (pixels.width * pixels.height <= LARGE || !platform.startAside)
    return { kind: 'pixels', data: reduced(pixels, width, height), width, height };
  const task = { kind: 'reduce', picture: pixels, width, height } as const;
  const data = await aside(task, [pixels.data.buffer]);
  return { kind: 'pixels', data, width, height };
}

async function readAndClose(image: VideoFrame, size: number | undefined): Promise<RawFrame> {
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

/** The frame as pixels that a canvas takes as they are: `ImageData` where there is one. */
export async function toPixelFrame(raw: RawFrame): Promise<PixelFrame> {
  const { data, width, height } = await pixelsFrom(raw);
  const clamped = new Uint8ClampedArray(data.buffer, data.byteOffset, data.length);
  return typeof ImageData === 'undefined' ? { data: clamped, width, height } : new ImageData(clamped, width, height);
}

/**
 * A frame to look at. `frame` is what a canvas draws: a `VideoFrame`, in a browser without these an `ImageBitmap`; in Node,
 * which draws nothing, its pixels. It is there until the next one is asked for. `width` and `height` are its size as it is
 * shown; `pixels` gives a copy, `ImageData` in browsers.
 */
export type ShownFrame = {
  readonly frame: VideoFrame | ImageBitmap | PixelFrame;
  readonly width: number;
  readonly height: number;
  readonly pixels: () => Promise<PixelFrame>;
};

/**
 * The frame at no more than `size` to look at; `close` lets go of it.
 * @param raw whose memory nobody changes meanwhile
 * @param time in seconds
 */
export async function shownFrame(
  raw: ReadFrame,
  size: number | undefined,
  time: number,
): Promise<ShownFrame & { close: () => void }> {
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

/** @param time in seconds */
async function drawn(pixels: PixelFrame, time: number) {
  const { data, width: codedWidth, height: codedHeight } = pixels;
  if (typeof VideoFrame !== 'undefined')
    return new VideoFrame(data, { format: 'RGBA', codedWidth, codedHeight, timestamp: Math.round(1e6 * time) });
  return typeof createImageBitmap === 'undefined' ? pixels : createImageBitmap(pixels as ImageData);
}

/** The pixels of a frame; an error says which one it is. */
export async function pixelsFrom(raw: RawFrame) {
  try {
    return await toPixels(raw);
  } catch (error) {
    throw inFrame(error, raw);
  }
}
