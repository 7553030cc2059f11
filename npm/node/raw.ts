// Frames from streams of uncompressed video.

import { TraceCutError, checkOptions, checkSides, checkWholeNumber, illegal, tooLarge } from '../check/errors.js';
import { MAX_PIXELS } from '../check/options.js';
import type { PixelFrame } from '../worker/frames.js';

/**
 * A stream of bytes: a Node stream such as `process.stdin` or `createReadStream(path)`, a `ReadableStream`, or any other
 * sequence of chunks.
 */
export type ByteSource = AsyncIterable<Uint8Array> | Iterable<Uint8Array>;

/** A frame decoded by another program: its pixels, its number, and its time and duration in seconds. */
export type FileFrame = {
  readonly frame: PixelFrame;
  readonly index: number;
  readonly time: number;
  readonly duration: number;
};

/** Layout of a raw stream, a sequence of frames. */
export interface RawOptions {
  /** Width of a frame in pixels. */
  width: number;
  /** Height of a frame in pixels. */
  height: number;
  /** Pixel format of a frame, named as ffmpeg's `-pix_fmt`. */
  format: 'rgba' | 'bgra' | 'rgb24' | 'bgr24' | 'gray';
  /** Frames per second; 25 if not given. */
  frameRate?: number;
  /** Most pixels of a frame, 1 to 2^28; 2^26 if not given. Larger frames are refused (`too-large`) before allocation. */
  maxPixels?: number;
}

/** Layout of a pixel: its number of bytes, and the offsets of red, green and blue. */
export type PixelLayout = { bytes: number; red: number; green: number; blue: number };

/** Largest legal `maxPixels`, as for `clip.maxPixels`. */
const MAX_MAX_PIXELS = 2 ** 28;
/** Bytes allocated for a frame before its bytes have arrived. */
const INITIAL_BYTES = 2 ** 20;

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
  const { width, height, layout, frameRate } = checkFormat(options);
  const reader = new ByteReader(source);
  try {
    for (let index = 0; ; index += 1) {
      const bytes = await reader.read(layout.bytes * width * height);
      if (bytes === null) return;
      if (bytes.length < layout.bytes * width * height)
        throw createCutError(index, bytes.length, layout.bytes * width * height);
      const frame = { data: toRgba(bytes, layout), width, height };
      yield { frame, index, time: index / frameRate, duration: 1 / frameRate };
    }
  } finally {
    await reader.close();
  }
}

function checkFormat(options: RawOptions) {
  const legal = ['width', 'height', 'format', 'frameRate', 'maxPixels'];
  const { width, height, format, frameRate = 25, maxPixels } = checkOptions(options, legal);
  checkSize(width, height, maxPixels);
  const layout = RAW_FORMATS.get(format);
  if (!layout) throw illegal('param', 'format', format, [...RAW_FORMATS.keys()].join(', '));
  if (typeof frameRate !== 'number' || !(frameRate > 0 && frameRate <= 1000))
    throw illegal('param', 'frameRate', frameRate, 'frames per second, above 0 and at most 1000');
  return { width, height, layout, frameRate };
}

/** Throws if a frame is too large, before memory is allocated for it. */
export function checkSize(width: number, height: number, maxPixels: number = MAX_PIXELS) {
  checkWholeNumber('param', 'maxPixels', maxPixels, 1, MAX_MAX_PIXELS);
  checkSides('frame-size', '', { width, height });
  if (width * height > maxPixels) throw tooLarge(width * height, 'pixels in a frame', maxPixels, 'maxPixels');
}

function createCutError(index: number, length: number, expected: number) {
  const message = `frame ${index} of the stream has ${length} bytes (expected ${expected})`;
  return new TraceCutError('truncated', message, { frames: index });
}

/** Converts pixels to opaque RGBA. */
export function toRgba(bytes: Uint8Array, { bytes: step, red, green, blue }: PixelLayout) {
  const data = new Uint8Array((4 * bytes.length) / step).fill(255);
  for (let to = 0, from = 0; to < data.length; to += 4, from += step) {
    data[to] = Number(bytes[from + red]);
    data[to + 1] = Number(bytes[from + green]);
    data[to + 2] = Number(bytes[from + blue]);
  }
  return new Uint8ClampedArray(data.buffer);
}

/** Reads a stream in pieces of any length. */
export class ByteReader {
  #chunks;
  #chunk: Uint8Array = new Uint8Array();
  #offset = 0;

  constructor(source: ByteSource) {
    if (typeof source !== 'object' || source === null || !(Symbol.asyncIterator in source || Symbol.iterator in source))
      throw illegal('data', 'source', source, 'a stream of bytes');
    this.#chunks = Symbol.asyncIterator in source ? source[Symbol.asyncIterator]() : source[Symbol.iterator]();
  }

  /** Reads `length` bytes, fewer if the stream ends before, null if it has ended. */
  async read(length: number): Promise<Uint8Array | null> {
    // Memory grows with the bytes that arrive, whatever size was claimed.
    let bytes = new Uint8Array(Math.min(length, INITIAL_BYTES));
    let count = 0;
    while (count < length && (await this.#fetch())) {
      const part = this.#chunk.subarray(this.#offset, this.#offset + length - count);
      if (count + part.length > bytes.length) {
        const before = bytes;
        bytes = new Uint8Array(Math.min(length, 2 * (count + part.length)));
        bytes.set(before.subarray(0, count));
      }
      bytes.set(part, count);
      count += part.length;
      this.#offset += part.length;
    }
    return count === 0 ? null : bytes.subarray(0, count);
  }

  /** Fetches the next chunk if the present one is used up; returns false at the end of the stream. */
  async #fetch() {
    while (this.#offset >= this.#chunk.length) {
      const { value, done } = await this.#chunks.next();
      if (done) return false;
      if (!(value instanceof Uint8Array)) throw illegal('data', 'a piece of the stream', value, 'a Uint8Array');
      [this.#chunk, this.#offset] = [value, 0];
    }
    return true;
  }

  /** Cancels the stream. */
  async close() {
    await this.#chunks.return?.();
  }
}
