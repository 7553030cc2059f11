// Reads the pixels of a frame from any source, and reduces frames.

import { withFrame } from '../check/errors.js';
import { platform } from '../platform.js';
import { runTask } from '../worker/aside.js';
import { toPixels } from '../worker/instance.js';
import { type PixelFrame, type RawFrame, fromImage, reduceVideoFrame } from '../worker/frames.js';
import { reducePixels } from '../worker/pixels.js';

/** A frame from a reader: copied, or as the browser holds it. */
export type ReadFrame = RawFrame | { kind: 'image'; image: VideoFrame };

/** Returns the size of a frame reduced to a longer side of at most `side`: never enlarged, aspect kept to the nearest pixel. */
export function fitSize(
  { width, height }: { readonly width: number; readonly height: number },
  side: number = Infinity,
) {
  const scale = Math.min(1, side / Math.max(width, height));
  return { width: Math.max(1, Math.round(width * scale)), height: Math.max(1, Math.round(height * scale)) };
}

/** Scales a frame to another size, smoothly, regardless of its aspect. */
export async function stretchFrame(raw: ReadFrame, width: number, height: number): Promise<RawFrame> {
  const image = (await toPixelFrame(await reduceFrame(raw, undefined))) as ImageData;
  const size = { resizeWidth: width, resizeHeight: height, resizeQuality: 'high' } as const;
  const bitmap = await createImageBitmap(image, size);
  try {
    return await fromImage(bitmap);
  } finally {
    bitmap.close();
  }
}

/** Size in pixels from which frames are copied and reduced in a worker, as it would be noticed in the page's thread. */
const LARGE_FRAME_PX = 2 ** 20;

/** Returns the frame reduced to at most `size`, in memory: pixels, or a file that need not be reduced. Closes an image. */
export async function reduceFrame(raw: ReadFrame, size: number | undefined): Promise<RawFrame> {
  if (raw.kind === 'image') return readAndClose(raw.image, size);
  if (size === undefined) return raw;
  const pixels = await decodePixels(raw);
  const { width, height } = fitSize(pixels, size);
  if (width === pixels.width && height === pixels.height) return { kind: 'pixels', ...pixels };
  if (pixels.width * pixels.height <= LARGE_FRAME_PX || !platform.startAside)
    return { kind: 'pixels', data: reducePixels(pixels, width, height), width, height };
  const task = { kind: 'reduce', picture: pixels, width, height } as const;
  const data = await runTask(task, [pixels.data.buffer]);
  return { kind: 'pixels', data, width, height };
}

async function readAndClose(image: VideoFrame, size: number | undefined): Promise<RawFrame> {
  try {
    const displaySize = { width: image.displayWidth, height: image.displayHeight };
    const { width, height } = fitSize(displaySize, size);
    const isSmall = displaySize.width * displaySize.height <= LARGE_FRAME_PX || !platform.startAside;
    const data = isSmall
      ? await reduceVideoFrame(image, width, height)
      : await runTask({ kind: 'frame', frame: image, width, height }, [image]);
    return { kind: 'pixels', data, width, height };
  } finally {
    image.close();
  }
}

/** Converts a frame to pixels that a canvas accepts: `ImageData` if there is one. */
async function toPixelFrame(raw: RawFrame): Promise<PixelFrame> {
  const { data, width, height } = await decodePixels(raw);
  const clamped = new Uint8ClampedArray(data.buffer, data.byteOffset, data.length);
  return typeof ImageData === 'undefined' ? { data: clamped, width, height } : new ImageData(clamped, width, height);
}

/**
 * A frame for display. `frame` can be drawn on a canvas: a `VideoFrame`, or an `ImageBitmap` in browsers without it; in
 * Node, which has no canvas, its pixels. It is valid until the next one is requested. `width` and `height` are its display
 * size; `pixels` returns a copy, `ImageData` in browsers.
 */
export type ShownFrame = {
  readonly frame: VideoFrame | ImageBitmap | PixelFrame;
  readonly width: number;
  readonly height: number;
  readonly pixels: () => Promise<PixelFrame>;
};

/**
 * Returns the frame, reduced to at most `size`, for display; `close` frees it.
 * @param raw must not change meanwhile
 * @param time in seconds
 */
export async function toShownFrame(
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
  const pixelFrame = await toPixelFrame(await reduceFrame(raw, size));
  const { data, width, height } = pixelFrame;
  const frame = await toDrawable(pixelFrame, time);
  const pixels = () => toPixelFrame({ kind: 'pixels', data: new Uint8Array(data), width, height });
  return { frame, width, height, pixels, close: () => void ('close' in frame && frame.close()) };
}

/** @param time in seconds */
async function toDrawable(pixels: PixelFrame, time: number) {
  const { data, width: codedWidth, height: codedHeight } = pixels;
  if (typeof VideoFrame !== 'undefined')
    return new VideoFrame(data, { format: 'RGBA', codedWidth, codedHeight, timestamp: Math.round(1e6 * time) });
  return typeof createImageBitmap === 'undefined' ? pixels : createImageBitmap(pixels as ImageData);
}

/** Returns the pixels of a frame; an error names the frame. */
export async function decodePixels(raw: RawFrame) {
  try {
    return await toPixels(raw);
  } catch (error) {
    throw withFrame(error, raw);
  }
}
