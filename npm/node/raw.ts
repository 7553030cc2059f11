// Frames from streams of uncompressed video.

import { TraceCutError, checkSides, checkedOptions, illegal, tooLarge, wholeNumber } from '../check/errors.js';
import { MAX_PIXELS } from '../check/options.js';
import type { PixelFrame } from '../worker/frames.js';

/**
 * A stream of bytes: one of Node such as `process.stdin` or `createReadStream(path)`, a `ReadableStream`, or any other
 * sequence of pieces.
 */
export type ByteSource = AsyncIterable<Uint8Array> | Iterable<Uint8Array>;

/** A frame that a program of its own decoded: its pixels, its number, and when and how long it is shown, in seconds. */
export type FileFrame = {
  readonly frame: PixelFrame;
  readonly index: number;
  readonly time: number;
  readonly duration: number;
};

/** The layout of a raw stream, which has frames one after the other. */
export interface RawOptions {
  /** Of a frame in pixels. */
  width: number;
  /** Of a frame in pixels. */
  height: number;
  /** Of a frame, called as ffmpeg's `-pix_fmt`. */
  format: 'rgba' | 'bgra' | 'rgb24' | 'bgr24' | 'gray';
  /** In frames per second; 25 if not given. */
  frameRate?: number;
  /**
   * Most pixels of a frame, 1 to 2^28; 2^26 if not given. Larger ones are refused (`too-large`) before memory is taken.
   */
  maxPixels?: number;
}

/** The bytes of a pixel: their number, and the places of red, green and blue. */
export type PixelLayout = { bytes: number; red: number; green: number; blue: number };

/** Largest legal `maxPixels`, as of `clip.maxPixels`. */
const MOST_PIXELS = 2 ** 28;
/** Memory that is taken for a frame before its bytes have come. */
const FIRST_BYTES = 2 ** 20;

export const RGB24: PixelLayout = { bytes: 3, red: 0, green: 1, blue: 2 };

/** Pixel layouts by their names in ffmpeg. */
const RAW_FORMATS: Map<string, PixelLayout> = new Map([
  ['rgba', { ...RGB24, bytes: 4 }],
  ['bgra', { bytes: 4, red: 2, green: 1, blue: 0 }],
  ['rgb24', RGB24],
  ['bgr24', { bytes: 3, red: 2, green: 1, blue: 0 }],
  ['gray', { bytes: 1, red: 0, green: 0, blue: 0 }],
]);

/**
 * Reads the frames of a raw stream, such as `ffmpeg -f rawvideo` writes.
 *
 * ```js
 * const frames = framesOfRaw(process.stdin, { width: 640, height: 360, format: 'rgb24' });
 * ```
 */
export async function* framesOfRaw(
  source: ByteSource,
  options: RawOptions,
): AsyncGenerator<FileFrame, void, undefined> {
  const { width, height, layout, frameRate } = checkedFormat(options);
  const reader = new ByteReader(source);
  try {
    for (let index = 0; ; index += 1) {
      const bytes = await reader.read(layout.bytes * width * height);
      if (bytes === null) return;
      if (bytes.length < layout.bytes * width * height)
        throw cutOff(index, bytes.length, layout.bytes * width * height);
      const frame = { data: toRgba(bytes, layout), width, height };
      yield { frame, index, time: index / frameRate, duration: 1 / frameRate };
    }
  } finally {
    await reader.close();
  }
}

function checkedFormat(options: RawOptions) {
  const legal = ['width', 'height', 'format', 'frameRate', 'maxPixels'];
  const { width, height, format, frameRate = 25, maxPixels } = checkedOptions(options, legal);
  checkSize(width, height, maxPixels);
  const layout = RAW_FORMATS.get(format);
  if (!layout) throw illegal('param', 'format', format, [...RAW_FORMATS.keys()].join(', '));
  if (typeof frameRate !== 'number' || !(frameRate > 0 && frameRate <= 1000))
    throw illegal('param', 'frameRate', frameRate, 'frames per second, above 0 and at most 1000');
  return { width, height, layout, frameRate };
}

/** Refuses a frame size before memory is taken for it. */
export function checkSize(width: number, height: number, maxPixels: number = MAX_PIXELS) {
  wholeNumber('param', 'maxPixels', maxPixels, 1, MOST_PIXELS);
  checkSides('frame-size', '', { width, height });
  if (width * height > maxPixels) throw tooLarge(width * height, 'pixels in a frame', maxPixels, 'maxPixels');
}

function cutOff(index: number, length: number, expected: number) {
  const words = `frame ${index} of the stream has ${length} bytes (expected ${expected})`;
  return new TraceCutError('truncated', words, { frames: index });
}

/** Returns the pixels as RGBA, opaque. */
export function toRgba(bytes: Uint8Array, { bytes: step, red, green, blue }: PixelLayout) {
  const data = new Uint8Array((4 * bytes.length) / step).fill(255);
  for (let to = 0, from = 0; to < data.length; to += 4, from += step) {
    data[to] = Number(bytes[from + red]);
    data[to + 1] = Number(bytes[from + green]);
    data[to + 2] = Number(bytes[from + blue]);
  }
  return new Uint8ClampedArray(data.buffer);
}

/** Puts pieces of any length together. */
export class ByteReader {
  #pieces;
  #piece: Uint8Array = new Uint8Array();
  #used = 0;

  constructor(source: ByteSource) {
    if (typeof source !== 'object' || source === null || !(Symbol.asyncIterator in source || Symbol.iterator in source))
      throw illegal('data', 'source', source, 'a stream of bytes');
    this.#pieces = Symbol.asyncIterator in source ? source[Symbol.asyncIterator]() : source[Symbol.iterator]();
  }

  /** Reads `length` bytes, fewer where the stream ends before them, null where it has ended. */
  async read(length: number): Promise<Uint8Array | null> {
    // As much memory as there are bytes, whatever size was claimed.
    let bytes = new Uint8Array(Math.min(length, FIRST_BYTES));
    let count = 0;
    while (count < length && (await this.#fetch())) {
      const part = this.#piece.subarray(this.#used, this.#used + length - count);
      if (count + part.length > bytes.length) {
        const before = bytes;
        bytes = new Uint8Array(Math.min(length, 2 * (count + part.length)));
        bytes.set(before.subarray(0, count));
      }
      bytes.set(part, count);
      count += part.length;
      this.#used += part.length;
    }
    return count === 0 ? null : bytes.subarray(0, count);
  }

  /** Returns false at the end of the stream; otherwise some bytes are at hand. */
  async #fetch() {
    while (this.#used >= this.#piece.length) {
      const { value, done } = await this.#pieces.next();
      if (done) return false;
      if (!(value instanceof Uint8Array)) throw illegal('data', 'a piece of the stream', value, 'a Uint8Array');
      [this.#piece, this.#used] = [value, 0];
    }
    return true;
  }

  /** Gives up the rest of the stream. */
  async close() {
    await this.#pieces.return?.();
  }
}
