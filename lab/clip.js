// A clip as frames on canvases: of a video, of the images of a sequence, or the sample that the package draws.

import { synthClip, videoFrames, videoInfo } from 'tracecut';

/** The sample: segmented in seconds, and large enough to look at. */
export const SAMPLE = { width: 480, height: 270, frames: 24, seed: 0 };

/** Frames a second at which the sample is played. */
const SAMPLE_RATE = 15;

/**
 * What is taken of a file: `start` in seconds, every `step`-th frame, `size` is the long side in pixels.
 * @typedef {{readonly start: number, readonly maxFrames: number, readonly step: number, readonly size: number}} Take
 */

/** What is taken if the user chooses nothing else. @type {Take} */
export const DEFAULT_TAKE = { start: 0, maxFrames: 30, step: 1, size: 480 };

/** Where the studio leaves the clip that it has, see `../www/demo/panels/lab.js`. */
const HANDED_OVER = 'tracecut-lab';

/**
 * A frame on a canvas, and the time at which it is shown, in seconds.
 * @typedef {{canvas: OffscreenCanvas, time: number}} Frame
 */

/** One clip. Iterating over it decodes each frame once, in order, and keeps it in `frames`. */
export class Clip {
  /** @type {Frame[]} */
  frames = [];
  /** Whether `frames` has all frames that are taken. */
  isComplete = false;
  /** What is wrong with the file, if it is damaged after some good frames. */
  damage = '';
  /** @type {number | null} Frames of the whole file, if known. */
  total = null;

  /**
   * @param {File[]} files one video, or the images of a sequence; none for the sample
   * @param {Take} take which frames, and how large
   */
  constructor(files, take) {
    this.files = files;
    this.take = take;
  }

  get name() {
    const [file] = this.files;
    if (!file) return 'Sample';
    return this.files.length > 1 ? `${file.name} and ${this.files.length - 1} more` : file.name;
  }

  /**
   * Yields the frames; those that are decoded already come at once.
   * @param {AbortSignal} signal
   * @returns {AsyncGenerator<Frame>}
   */
  async *decode(signal) {
    if (this.isComplete) return yield* this.frames;
    this.frames = [];
    for await (const { frame, time } of this.files.length > 0 ? this.#readFiles(signal) : drawSample(signal)) {
      const canvas = new OffscreenCanvas(frame.width, frame.height);
      const context = /** @type {OffscreenCanvasRenderingContext2D} */ (
        canvas.getContext('2d', { willReadFrequently: true })
      );
      context.putImageData(toImageData(frame), 0, 0);
      this.frames.push({ canvas, time });
      yield { canvas, time };
    }
    this.isComplete = true;
  }

  /** @param {AbortSignal} signal */
  async *#readFiles(signal) {
    const source = this.files.length > 1 ? this.files : /** @type {File} */ (this.files[0]);
    const { start, ...take } = this.take;
    this.total = await videoInfo(source).then(
      ({ numFrames }) => numFrames ?? null,
      () => null,
    );
    const onDamage = (/** @type {import('tracecut').Damage} */ { error }) => void (this.damage = error.message);
    yield* videoFrames(source, { ...take, ...(start > 0 && { start }), signal, onDamage });
  }

  /** How long a frame is shown, in milliseconds. */
  get frameDuration() {
    const [first, last] = [this.frames[0]?.time ?? 0, this.frames.at(-1)?.time ?? 0];
    const mean = (last - first) / Math.max(1, this.frames.length - 1);
    return mean > 0 ? Math.min(1000, 1000 * mean) : 1000 / SAMPLE_RATE;
  }
}

/** @param {AbortSignal} signal */
async function* drawSample(signal) {
  const sample = await synthClip(SAMPLE);
  try {
    for (let t = 0; t < sample.numFrames; t += 1) {
      signal.throwIfAborted();
      yield { frame: sample.frame(t), time: t / SAMPLE_RATE };
    }
  } finally {
    sample.close();
  }
}

/** @param {import('tracecut').DecodedFrame['frame']} frame */
function toImageData(frame) {
  if (frame instanceof ImageData) return frame;
  return new ImageData(new Uint8ClampedArray(frame.data), frame.width, frame.height);
}

/**
 * Fetches the files that the studio handed over, and where in them to start.
 * @returns {Promise<{files: File[], start: number}>} no files if there are none, or no storage
 */
export async function fetchHandedOver() {
  try {
    const cache = await caches.open(HANDED_OVER);
    const responses = await Promise.all((await cache.keys()).map((key) => cache.match(key)));
    const files = await Promise.all(responses.map((response) => toFile(/** @type {Response} */ (response))));
    return { files, start: Number(responses[0]?.headers.get('x-start') ?? 0) };
  } catch {
    return { files: [], start: 0 };
  }
}

/** @param {Response} response */
async function toFile(response) {
  const name = decodeURIComponent(response.headers.get('x-name') ?? 'clip');
  return new File([await response.blob()], name, { type: response.headers.get('content-type') ?? '' });
}
