// A clip as frames on canvases: of a video, of the images of a sequence, or the sample that the package draws.

import { synthClip, videoFrames, videoInfo } from 'tracecut';

/** The sample: segmented in seconds, and large enough to look at. */
export const SAMPLE = { width: 480, height: 270, frames: 24, seed: 0 };
const SAMPLE_FRAMES_PER_SECOND = 15;

/** What is taken of a file: from `start` in seconds every `step`-th frame, `size` is the long side in pixels. */
export const DEFAULT_TAKE = { start: 0, maxFrames: 30, step: 1, size: 480 };

/** Cache in which the page leaves the clip that it has; see `studio/view/panels/lab.ts`. */
const HANDED_OVER = 'tracecut-lab';

/** One clip. `decode` decodes each frame once, in order, and keeps it. */
export class Clip {
  /** @type {{canvas: OffscreenCanvas, time: number}[]} The frames so far, with the second at which each is shown. */
  frames = [];
  isDecoded = false;
  /** Number of frames of the whole file, null if not known. */
  total = null;
  /** What is wrong with the file if it is damaged after some good frames, else empty. */
  damage = '';

  /** @param {File[]} files one video, or the images of a sequence; none for the sample */
  constructor(files, take = DEFAULT_TAKE) {
    this.files = files;
    this.take = take;
  }

  get name() {
    if (this.files.length === 0) return 'Sample';
    return this.files[0].name + (this.files.length > 1 ? ` and ${this.files.length - 1} more` : '');
  }

  /** Milliseconds for which a frame is shown, on average. */
  get frameDuration() {
    const { frames } = this;
    return frames.length > 1 ? (1000 * (frames.at(-1).time - frames[0].time)) / (frames.length - 1) : 1000;
  }

  /** Yields the frames; those that are decoded already come at once. @param {AbortSignal} signal */
  async *decode(signal) {
    if (this.isDecoded) return yield* this.frames;
    const frames = (this.frames = []);
    for await (const { pixels, width, height, time } of this.files.length > 0 ? this.#read(signal) : sampleFrames()) {
      const canvas = new OffscreenCanvas(width, height);
      const image = new ImageData(new Uint8ClampedArray((await pixels()).data), width, height);
      canvas.getContext('2d', { willReadFrequently: true }).putImageData(image, 0, 0);
      frames.push({ canvas, time });
      yield frames.at(-1);
    }
    this.isDecoded = true;
  }

  async *#read(signal) {
    const source = this.files.length > 1 ? this.files : this.files[0];
    const { start, ...take } = this.take;
    this.total = this.files.length > 1 ? this.files.length : await countFrames(source);
    const onDamage = ({ error }) => void (this.damage = error.message);
    yield* videoFrames(source, { ...take, start: start > 0 ? start : undefined, signal, onDamage });
  }
}

async function* sampleFrames() {
  const sample = await synthClip(SAMPLE);
  const { width, height, numFrames } = sample;
  for (let t = 0; t < numFrames; t += 1)
    yield { pixels: () => sample.frame(t), width, height, time: t / SAMPLE_FRAMES_PER_SECOND };
  sample.close();
}

async function countFrames(file) {
  const info = await videoInfo(file).catch(() => null);
  return info?.numFrames ?? null;
}

/** Fetches the files that the page handed over, and the second to start at; no files if there are none. */
export async function fetchHandedOver() {
  try {
    const cache = await caches.open(HANDED_OVER);
    const responses = await Promise.all((await cache.keys()).map((key) => cache.match(key)));
    return { files: await Promise.all(responses.map(toFile)), start: Number(responses[0].headers.get('x-start')) };
  } catch {
    return { files: [], start: 0 };
  }
}

async function toFile(response) {
  const { headers } = response;
  const name = decodeURIComponent(headers.get('x-name'));
  return new File([await response.blob()], name, { type: headers.get('content-type') });
}
