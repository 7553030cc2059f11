// A clip as frames on canvases, from a video, an image sequence or the synthetic sample, and one run of the core over them.

import { createSession, synthClip, videoFrames, videoInfo } from 'tracecut';

/** The sample: large enough to look at, and segmented in seconds. */
export const SAMPLE = { width: 480, height: 270, frames: 24, seed: 0 };
const SAMPLE_FRAMES_PER_SECOND = 15;

/** The frames used of a file: every `step`-th one from `start` in seconds, scaled to a long side of `size` pixels. */
export const DEFAULT_SELECTION = { start: 0, maxFrames: 30, step: 1, size: 480 };

/** Cache in which the studio stores its clip for the lab. */
const STUDIO_CLIP_CACHE = 'tracecut-lab';

/** One clip. `decode` decodes each frame once, in order, and stores it. */
export class Clip {
  /** @type {{canvas: OffscreenCanvas, time: number}[]} The frames decoded so far, with their times in seconds. */
  frames = [];
  isDecoded = false;
  /** Number of frames of the whole file, null if unknown. */
  total = null;
  /** Describes the damage of a file that is damaged after some good frames, else empty. */
  damage = '';

  /** @param {File[]} files one video, or the images of a sequence; none for the sample */
  constructor(files, selection = DEFAULT_SELECTION) {
    this.files = files;
    this.selection = selection;
  }

  get name() {
    if (this.files.length === 0) return 'Sample';
    return this.files[0].name + (this.files.length > 1 ? ` and ${this.files.length - 1} more` : '');
  }

  /** Returns the mean duration of a frame in milliseconds. */
  get frameDuration() {
    const { frames } = this;
    return frames.length > 1 ? (1000 * (frames.at(-1).time - frames[0].time)) / (frames.length - 1) : 1000;
  }

  /** Yields the frames; decoded frames come at once. @param {AbortSignal} signal */
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
    const { start, ...options } = this.selection;
    this.total = this.files.length > 1 ? this.files.length : await countFrames(source);
    const onDamage = ({ error }) => void (this.damage = error.message);
    yield* videoFrames(source, { ...options, start: start > 0 ? start : undefined, signal, onDamage });
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

/** Fetches the studio's clip: its files, and the start in seconds. Returns no files if there is none. */
export async function fetchStudioClip() {
  try {
    const cache = await caches.open(STUDIO_CLIP_CACHE);
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

/**
 * Segments a clip in a new session, so that parameters and errors of earlier runs have no effect.
 * @param {Clip} clip
 * @param {import('tracecut').SessionOptions} options
 * @param {{signal: AbortSignal, onFrame: (t: number) => void, onProgress: (progress: import('tracecut').Progress) =>
 *   void}} report
 */
export async function segment(clip, options, { signal, onFrame, onProgress }) {
  const session = await createSession(options);
  try {
    for await (const { canvas } of clip.decode(signal)) {
      signal.throwIfAborted();
      onFrame(session.numFrames);
      await session.push(canvas);
    }
    return new Run(session, await session.run({ signal, onProgress }), options);
  } catch (error) {
    session.close();
    throw error;
  }
}

/** Maximum number of cached answers: a map of a large frame takes megabytes. */
const MAX_ANSWERS = 150;

/** A finished run: its result and its session, which answers queries until it is closed. */
export class Run {
  #answers = new Map();

  /**
   * @param {import('tracecut').Session} session
   * @param {import('tracecut').Result} result
   * @param {import('tracecut').SessionOptions} options
   */
  constructor(session, result, options) {
    this.session = session;
    this.result = result;
    this.options = options;
  }

  /** Queries the result, or the session for the flow, about frame `t`; answers are cached. @param {string} name */
  ask(name, t = 0) {
    const key = `${name} ${t}`;
    if (!this.#answers.has(key)) this.#answers.set(key, name === 'flow' ? this.session.flow(t) : this.result[name](t));
    if (this.#answers.size > MAX_ANSWERS) this.#answers.delete(this.#answers.keys().next().value);
    return this.#answers.get(key);
  }

  close() {
    this.session.close();
  }
}
